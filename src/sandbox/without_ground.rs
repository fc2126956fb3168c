//! What there is to go by in a scene without a ground: a faint grid under it, the axes of the world, and the pivots that hold it.

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_egui::{EguiContexts, EguiPrimaryContextPass, egui};

use super::CurrentScene;
use super::any_joint::{AnyJoint, IsJoint};
use super::camera::bounds;
use super::ground::GroundOf;
use super::in_front::in_front;
use super::panel::Quantity;
use crate::lab::round_step;
use crate::physics::{Collider, Gravity, RenderOrigin, RigidBody};
use crate::scene::{SceneEntity, SceneSpec};

/// Cells of the grid from its middle to its edge.
const CELLS: i32 = 10;
/// Of them, how many a scene takes up, at most, from its middle to its edge.
const COVERED: f64 = 5.0;
/// Pieces of a line, by which it fades.
const PIECES: i32 = 10;
/// Opacity of the grid in its middle.
const FAINT: f32 = 0.4;
/// Of a pivot: its height, of its distance from the camera, and how many are drawn at most.
const PIVOT: f32 = 0.016;
const MOST_PIVOTS: usize = 200;

const LINE: Color = Color::srgb(0.28, 0.34, 0.44);
const HELD: Color = Color::srgb(0.93, 0.94, 0.96);
/// Of x, y and z.
const AXES: [(Vec3, &str, [u8; 3]); 3] =
    [(Vec3::X, "X", [206, 48, 36]), (Vec3::Y, "Y", [34, 128, 40]), (Vec3::Z, "Z", [32, 88, 208])];

/// Lines that bodies hide.
#[derive(Default, Reflect, GizmoConfigGroup)]
struct GridLines;

/// Lines in front of bodies: a pivot lies inside what it holds.
#[derive(Default, Reflect, GizmoConfigGroup)]
struct Pivots;

pub(super) fn plugin(app: &mut App) {
    in_front::<GridLines>(app, 0.0, 1.2);
    in_front::<Pivots>(app, 0.96, 2.2);
    app.init_resource::<Grid>()
        .add_systems(Update, lay.after(super::action::CarryOut))
        .add_systems(PostUpdate, (draw_grid, draw_pivots).run_if(has_no_ground).before(TransformSystems::Propagate))
        .add_systems(EguiPrimaryContextPass, letter.run_if(has_no_ground));
}

fn has_no_ground(
    scene: Option<Res<CurrentScene>>,
    grounds: Query<(), With<GroundOf>>,
    bodies: Query<&Collider, With<SceneEntity>>,
) -> bool {
    scene.is_some() && grounds.is_empty() && !bodies.iter().any(|collider| collider.shape().is_ground())
}

/// The grid of the scene on view.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
struct Grid {
    /// Its middle, where lines cross, m.
    middle: DVec3,
    /// Side of a cell, m.
    cell: f64,
}

impl Grid {
    /// Under all that the scene's bodies reach, hung up or not.
    fn of(spec: &SceneSpec) -> Self {
        let (low, high) = bounds(spec);
        let size = (high - low).length().max(1e-3);
        // What hangs on something that is fixed swings.
        let hangs = spec.gravity != DVec3::ZERO && !spec.joints.is_empty();
        let height = if hangs { high.y - size } else { low.y - 0.1 * size };
        let cell = round_step(0.5 * size / COVERED);
        let crossing = |place: f64| (place / cell).round() * cell;
        let middle = 0.5 * (low + high);
        let middle = DVec3::new(crossing(middle.x), (height / cell).floor() * cell, crossing(middle.z));
        Self { middle, cell }
    }
}

fn lay(scene: Option<Res<CurrentScene>>, mut grid: ResMut<Grid>) {
    if let Some(scene) = scene.filter(|scene| scene.is_changed()) {
        grid.set_if_neq(Grid::of(&scene.spec));
    }
}

/// Lines that fade with the distance from the middle, and the axes.
fn draw_grid(grid: Res<Grid>, origin: Res<RenderOrigin>, mut gizmos: Gizmos<GridLines>) {
    let middle = (grid.middle - origin.0).as_vec3();
    let cell = grid.cell as f32;
    let edge = CELLS as f32;
    let at = |along: Vec3, across: Vec3, x: f32, y: f32| middle + cell * (x * along + y * across);
    let color = |x: f32, y: f32| LINE.with_alpha(FAINT * (1.0 - x.hypot(y) / edge).max(0.0));
    for (along, across) in [(Vec3::X, Vec3::Z), (Vec3::Z, Vec3::X)] {
        for line in -CELLS..=CELLS {
            let y = line as f32;
            let points = (-PIECES..=PIECES).map(|piece| {
                let x = edge * piece as f32 / PIECES as f32;
                (at(along, across, x, y), color(x, y))
            });
            gizmos.linestrip_gradient(points);
        }
    }
    for (direction, _, [r, g, b]) in AXES {
        gizmos.arrow(middle, middle + cell * direction, Color::srgb_u8(r, g, b)).with_tip_length(0.16 * cell);
    }
}

/// A triangle on a hatched base, as drawings have it, upright in the picture, with its tip where what is fixed holds a joint.
fn draw_pivots(
    joints: Query<AnyJoint, (IsJoint, With<SceneEntity>)>,
    poses: Query<(&RigidBody, &Transform)>,
    camera: Single<&GlobalTransform, With<Camera3d>>,
    gravity: Res<Gravity>,
    mut gizmos: Gizmos<Pivots>,
) {
    let joints = joints.iter().filter_map(|joint| joint.component());
    let held = joints.flat_map(|joint| joint.ends()).filter_map(|(body, anchor)| {
        let (kind, pose) = poses.get(body).ok()?;
        (*kind == RigidBody::Static).then(|| pose.translation + pose.rotation * anchor.as_vec3())
    });
    let down = gravity.0.as_vec3().normalize_or(Vec3::NEG_Y);
    for tip in held.filter(|tip| tip.is_finite()).take(MOST_PIVOTS) {
        let view = camera.translation() - tip;
        let size = PIVOT * view.length();
        // Away from whom it is seen by, gravity tells nothing: down in the picture then.
        let across = view.cross(down).try_normalize().unwrap_or(camera.right().as_vec3());
        let below = across.cross(view).normalize_or(down);
        let at = |x: f32, y: f32| tip + size * (x * across - y * below);
        gizmos.linestrip([at(-0.6, -1.0), tip, at(0.6, -1.0)], HELD);
        gizmos.line(at(-0.9, -1.0), at(0.9, -1.0), HELD);
        for hatch in [-0.6, -0.1, 0.4] {
            gizmos.line(at(hatch + 0.25, -1.0), at(hatch, -1.35), HELD);
        }
        gizmos.sphere(tip, 0.2 * size, HELD).resolution(10);
    }
}

/// The letters of the axes, and how long an axis and a cell are, behind the panel.
fn letter(
    mut contexts: EguiContexts,
    grid: Res<Grid>,
    origin: Res<RenderOrigin>,
    camera: Single<(&Camera, &GlobalTransform), With<Camera3d>>,
) -> Result {
    let context = contexts.ctx_mut()?;
    let painter = context.layer_painter(egui::LayerId::new(egui::Order::Background, egui::Id::new("axes")));
    let middle = (grid.middle - origin.0).as_vec3();
    let write = |place: Vec3, text: &str, color: egui::Color32| {
        let Ok(at) = camera.0.world_to_viewport(camera.1, place) else { return };
        let at = egui::pos2(at.x, at.y) / context.zoom_factor();
        let font = egui::FontId::proportional(14.0);
        // Read on the sky and on a body alike.
        let shade = egui::Color32::from_white_alpha(150);
        for (x, y) in [(-1.0, 0.0), (1.0, 0.0), (0.0, -1.0), (0.0, 1.0)] {
            painter.text(at + egui::vec2(x, y), egui::Align2::CENTER_CENTER, text, font.clone(), shade);
        }
        painter.text(at, egui::Align2::CENTER_CENTER, text, font, color);
    };
    let cell = grid.cell as f32;
    for (direction, name, [r, g, b]) in AXES {
        write(middle + 1.15 * cell * direction, name, egui::Color32::from_rgb(r, g, b));
    }
    let suiting = Quantity::suiting(grid.cell, "m");
    let length = format!("{:.0} {}", grid.cell * suiting.factor, suiting.unit);
    write(middle + cell * Vec3::new(0.5, -0.2, 0.0), &length, egui::Color32::from_gray(30));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_grid_lies_under_all_that_may_swing_on_round_numbers() {
        for (scene, parameters) in [("pendulum", vec![]), ("chain", vec![("r".to_owned(), 100.0)]), ("top", vec![])] {
            let spec = crate::scene::load(scene, &parameters).unwrap();
            let Grid { middle, cell } = Grid::of(&spec);
            let (low, high) = bounds(&spec);
            assert!(middle.y < low.y, "{scene}: {middle}");
            let reach = CELLS as f64 * cell;
            assert!((high - low).length() < 2.0 * reach && (high - low).length() > 0.2 * reach, "{scene}: {cell}");
            for place in middle.to_array() {
                assert!((place / cell - (place / cell).round()).abs() < 1e-6, "{scene}: {middle} by {cell}");
            }
        }
        let pendulum = crate::scene::load("pendulum", &[]).unwrap();
        assert!(Grid::of(&pendulum).middle.y <= -1.0, "a rod of a metre swings above it");
    }
}
