//! Gives bodies the colors of the quantity that is chosen, and their own colors back.

use std::collections::HashMap;

use bevy::ecs::entity::EntityHashMap;
use bevy::prelude::*;

use super::color_by::ColorBy;
use super::legend::Legend;
use super::quantity::{Colors, GRAY, colors};
use super::scale::Rgb;
use crate::physics::RigidBody;
use crate::sandbox::meshes::dress_bodies;

/// What is colored, and how.
#[derive(Resource, Default)]
pub struct Painted {
    by: ColorBy,
    colors: Colors,
    /// Of each painted body: its own material, and the one that it was given.
    bodies: EntityHashMap<[Handle<StandardMaterial>; 2]>,
    /// Those that were given, by color and by what they are made from.
    materials: HashMap<(Rgb, AssetId<StandardMaterial>), Handle<StandardMaterial>>,
}

impl Painted {
    /// What the colors mean, while there are some.
    pub fn legend(&self) -> Option<&Legend> {
        (self.by != ColorBy::Nothing).then_some(&self.colors.legend)
    }

    /// Whether joints have colors.
    pub fn has_joints(&self) -> bool {
        self.by.is_of_joints()
    }

    /// The color of a joint.
    pub fn joint(&self, joint: Entity) -> Option<Rgb> {
        self.colors.joints.get(&joint).copied()
    }

    /// Contact points with their colors.
    pub(super) fn points(&self) -> &[(bevy::math::DVec3, Rgb)] {
        &self.colors.points
    }
}

pub(super) fn plugin(app: &mut App) {
    let is_due = |by: Res<ColorBy>, painted: Res<Painted>| *by != ColorBy::Nothing || painted.by != ColorBy::Nothing;
    // With the bodies that are new: none is seen in its own color, not for a frame.
    app.init_resource::<Painted>().add_systems(Update, paint.after(dress_bodies).run_if(is_due));
}

fn paint(world: &mut World) {
    let by = *world.resource::<ColorBy>();
    let found = colors(world, by);
    world.resource_scope(|world, mut painted: Mut<Painted>| {
        (painted.by, painted.colors) = (by, found);
        let Painted { colors, bodies: own, materials, .. } = &mut *painted;
        let mut bodies = world.query_filtered::<(Entity, &mut MeshMaterial3d<StandardMaterial>), With<RigidBody>>();
        if by == ColorBy::Nothing {
            for (body, [own, given]) in own.drain() {
                // What was dressed anew since has its own.
                if let Ok((_, mut present)) = bodies.get_mut(world, body)
                    && present.0 == given
                {
                    present.0 = own;
                }
            }
            materials.clear();
            return;
        }
        world.resource_scope(|world, mut assets: Mut<Assets<StandardMaterial>>| {
            let mut before = std::mem::take(own);
            for (body, mut present) in bodies.iter_mut(world) {
                let own_material = match before.remove(&body) {
                    Some([own, given]) if present.0 == given => own,
                    _ => present.0.clone(),
                };
                let color = colors.bodies.get(&body).copied().unwrap_or(GRAY);
                let given = materials.entry((color, own_material.id())).or_insert_with(|| {
                    let [r, g, b] = color;
                    let like = assets.get(&own_material).cloned().unwrap_or_default();
                    assets.add(StandardMaterial { base_color: Color::srgb_u8(r, g, b), ..like })
                });
                if present.0 != *given {
                    present.0 = given.clone();
                }
                own.insert(body, [own_material, given.clone()]);
            }
        });
    });
}
