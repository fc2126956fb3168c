//! Contact points in their colors, over the picture.

use bevy::prelude::*;

use super::paint::Painted;
use crate::physics::RenderOrigin;

/// Radius of a point, of the camera's distance.
const SIZE: f32 = 0.0045;
/// Drawn as rings, one in the other: a gizmo fills nothing.
const RINGS: [f32; 3] = [1.0, 0.66, 0.33];

/// In front of all bodies.
#[derive(Default, Reflect, GizmoConfigGroup)]
struct Points;

pub(super) fn plugin(app: &mut App) {
    let line = GizmoLineConfig { width: 2.4, ..default() };
    app.insert_gizmo_config(Points, GizmoConfig { depth_bias: -0.97, line, ..default() })
        .add_systems(PostUpdate, draw.run_if(|painted: Res<Painted>| !painted.points().is_empty()));
}

fn draw(
    mut gizmos: Gizmos<Points>,
    painted: Res<Painted>,
    origin: Res<RenderOrigin>,
    camera: Single<&GlobalTransform, With<Camera3d>>,
) {
    let (eye, facing) = (camera.translation(), camera.rotation());
    for (point, [r, g, b]) in painted.points() {
        let place = (*point - origin.0).as_vec3();
        let radius = SIZE * place.distance(eye);
        if !radius.is_finite() {
            continue;
        }
        for ring in RINGS {
            let at = Isometry3d::new(place, facing);
            gizmos.circle(at, ring * radius, Color::srgb_u8(*r, *g, *b)).resolution(10);
        }
    }
}
