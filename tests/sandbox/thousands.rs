//! Ten thousand bodies: what the picture makes of them is counted.

use std::collections::HashSet;

use bevy::ecs::change_detection::Tick;
use bevy::prelude::*;
use plumb::physics::{Gravity, RigidBody, SolverSettings};
use plumb::sandbox::{
    Blueprint, CurrentScene, JoinKind, Notice, Page, Playback, SandboxAction, Selection, ShownGizmos, Tool,
};
use plumb::scene::Probes;

use crate::stage::Stage;

const COUNT: usize = 10_000;

/// A heap of ten thousand things of a kind, which nobody has let fall yet.
fn heap(kind: f64) -> Stage {
    let mut stage = Stage::open("(bodies: [])");
    stage.act(SandboxAction::TogglePause);
    let parameters = vec![("n".to_owned(), COUNT as f64), ("kind".to_owned(), kind)];
    stage.act(SandboxAction::LoadScene { scene: "heap".into(), parameters });
    stage.frames(4);
    stage
}

/// Different ones among the bodies' components.
fn count_different<C: Component, T: std::hash::Hash + Eq>(stage: &mut Stage, of: impl Fn(&C) -> T) -> usize {
    let world = stage.world();
    let mut all = world.query_filtered::<&C, With<RigidBody>>();
    let all: Vec<T> = all.iter(world).map(of).collect();
    assert!(all.len() >= COUNT, "{} of them", all.len());
    all.into_iter().collect::<HashSet<_>>().len()
}

#[test]
fn boxes_balls_and_cones_of_all_sizes_share_a_mesh_and_few_materials() {
    /// Colors that scenes and the sandbox give to bodies of a kind.
    const COLORS: usize = 12;
    for kind in [0.0, 1.0, 3.0] {
        let mut stage = heap(kind);
        let meshes = count_different(&mut stage, |mesh: &Mesh3d| mesh.id());
        let materials = count_different(&mut stage, |material: &MeshMaterial3d<StandardMaterial>| material.id());
        assert_eq!(meshes, 1, "kind {kind}");
        assert!(materials <= COLORS, "kind {kind}: {materials} materials");
    }
}

/// How many bodies had that component written since.
fn written<C: Component>(world: &mut World, since: Tick) -> usize {
    let now = world.change_tick();
    let mut all = world.query_filtered::<Ref<C>, With<RigidBody>>();
    all.iter(world).filter(|component| component.last_changed().is_newer_than(since, now)).count()
}

/// Whether a resource was written since.
fn is_written<R: Resource>(world: &mut World, since: Tick) -> bool {
    let now = world.change_tick();
    world.get_resource_ref::<R>().is_some_and(|resource| resource.last_changed().is_newer_than(since, now))
}

#[test]
fn a_frame_in_which_nothing_moves_writes_nothing() {
    let mut stage = heap(4.0);
    let picked = stage.world().resource::<CurrentScene>().entities.bodies[COUNT / 2];
    *stage.world().resource_mut::<Selection>() = Selection::of(picked);
    for page in [Page::Play, Page::Build, Page::Analyse, Page::Solver] {
        stage.world().insert_resource(page);
        stage.frames(4);
        let since = stage.world().increment_change_tick();
        stage.frames(1);
        let world = stage.world();
        let bodies = [
            ("Transform", written::<Transform>(world, since)),
            ("GlobalTransform", written::<GlobalTransform>(world, since)),
            ("Mesh3d", written::<Mesh3d>(world, since)),
            ("material", written::<MeshMaterial3d<StandardMaterial>>(world, since)),
            ("bounds", written::<bevy::camera::primitives::Aabb>(world, since)),
        ];
        for (name, count) in bodies {
            assert_eq!(count, 0, "{name} of bodies, on {page:?}");
        }
        let resources = [
            ("meshes", is_written::<Assets<Mesh>>(world, since)),
            ("materials", is_written::<Assets<StandardMaterial>>(world, since)),
            ("scene", is_written::<CurrentScene>(world, since)),
            ("selection", is_written::<Selection>(world, since)),
            ("settings", is_written::<SolverSettings>(world, since)),
            ("gravity", is_written::<Gravity>(world, since)),
            ("gizmos", is_written::<ShownGizmos>(world, since)),
            ("playback", is_written::<Playback>(world, since)),
            ("notice", is_written::<Notice>(world, since)),
            ("page", is_written::<Page>(world, since)),
            ("tool", is_written::<Tool>(world, since)),
            ("blueprint", is_written::<Blueprint>(world, since)),
            ("kind of joint", is_written::<JoinKind>(world, since)),
            ("probes", is_written::<Probes>(world, since)),
        ];
        for (name, is_written) in resources {
            assert!(!is_written, "{name}, on {page:?}");
        }
    }
}
