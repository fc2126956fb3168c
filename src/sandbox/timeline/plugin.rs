use bevy::app::{RunFixedMainLoop, RunFixedMainLoopSystems};
use bevy::picking::mesh_picking::ray_cast::RayCastBackfaces;
use bevy::prelude::*;

use super::head::{Timeline, go_round, let_go_of_what_nobody_holds};
use super::looking::{draw, follow_the_head, run_backwards};
use super::poses::{PoseTrack, record};
use super::shown::ShownStep;
use crate::physics::Keep;
use crate::sandbox::build::Pin;
use crate::sandbox::held::DragPart;
use crate::scene::keep_scene;

pub fn plugin(app: &mut App) {
    keep_scene(app);
    app.keep_look::<Mesh3d>()
        .keep_look::<MeshMaterial3d<StandardMaterial>>()
        .keep_look::<RayCastBackfaces>()
        .keep_look::<Pin>()
        .keep_look::<DragPart>();
    app.init_resource::<Timeline>()
        .init_resource::<PoseTrack>()
        .init_resource::<ShownStep>()
        .add_systems(
            RunFixedMainLoop,
            (run_backwards, follow_the_head).chain().in_set(RunFixedMainLoopSystems::BeforeFixedMainLoop),
        )
        .add_systems(FixedPreUpdate, let_go_of_what_nobody_holds)
        .add_systems(FixedLast, (record, go_round).chain())
        .add_systems(PostUpdate, draw.after(TransformSystems::Propagate));
}
