//! The interface, larger and smaller.

use bevy::prelude::*;
use bevy::window::WindowResized;
use bevy_egui::{EguiContext, PrimaryEguiContext, egui};
use plumb::sandbox::{InterfaceScale, Notice, Page, Playback, SandboxAction, ScaleChange, Selection, Tool};

use crate::eyes::{click, point_at};
use crate::stage::{SIZE, Stage};

const SCENE: &str = r#"(
    bodies: [
        (name: "ground", kind: Static, shape: HalfSpace),
        (name: "box", shape: Cuboid(size: (1, 1, 1)), mass: 10, position: (0, 0.5, 0)),
    ],
    view: (eye: (0, 0.5, 12), target: (0, 0.5, 0)),
)"#;

/// The large button of the strip, and a page of the panel, from the corners that they keep to, at 100 %.
const PAUSE: Vec2 = Vec2::new(166.0, -33.0);
const BUILD: Vec2 = Vec2::new(-220.0, 20.0);
/// Width of the panel at 100 %.
const PANEL: f32 = 334.0;

fn at(percent: u16) -> Stage {
    let mut stage = Stage::open(SCENE);
    let change = if percent > 100 { ScaleChange::Larger } else { ScaleChange::Smaller };
    while stage.world().resource::<InterfaceScale>().0 != percent {
        stage.act(SandboxAction::ScaleInterface(change));
    }
    stage.frames(5);
    stage
}

/// What of the interface lies in front there, points.
fn layer_at(stage: &mut Stage, place: Vec2) -> Option<egui::Id> {
    let world = stage.world();
    let mut context = world.query_filtered::<&mut EguiContext, With<PrimaryEguiContext>>().single_mut(world).unwrap();
    context.get_mut().layer_id_at(egui::pos2(place.x, place.y)).map(|layer| layer.id)
}

#[test]
fn buttons_and_bodies_are_where_they_are_seen_at_any_scale() {
    for percent in [75, 150, 200] {
        let scale = f32::from(percent) / 100.0;
        let mut stage = at(percent);
        click(&mut stage, Vec2::new(0.0, SIZE.y) + scale * PAUSE);
        assert!(stage.world().resource::<Playback>().paused, "{percent} %");
        click(&mut stage, Vec2::new(SIZE.x, 0.0) + scale * BUILD);
        assert_eq!(*stage.world().resource::<Page>(), Page::Build, "{percent} %");

        // Nothing of the strip lies over the panel, however narrow the picture is.
        let strip = Vec2::new(SIZE.x - scale * (PANEL - 20.0), SIZE.y - scale * 33.0);
        point_at(&mut stage, strip);
        let panel = egui::Id::new("panel").with("area");
        assert_eq!(layer_at(&mut stage, strip / scale), Some(panel), "{percent} %");

        // The body is in the middle of what the panel leaves free.
        let body = stage.body("box");
        let position = stage.position("box");
        let place = stage.seen_at(position);
        let middle = 0.5 * (SIZE.x - scale * PANEL);
        assert!((place.x - middle).abs() < 2.0, "{percent} %: seen at {place}, the middle is at {middle}");
        stage.move_to(place);
        stage.press();
        stage.release();
        assert_eq!(stage.world().resource::<Selection>().entity(), Some(body), "{percent} %");
    }
}

#[test]
fn what_the_panel_covers_is_not_picked() {
    let mut stage = at(150);
    // Beside the panel at 100 %, under it at 150 %.
    let place = Vec2::new(SIZE.x - 1.25 * PANEL, 0.5 * SIZE.y);
    stage.act(SandboxAction::ChooseTool(Tool::Add));
    let count = |stage: &mut Stage| {
        let world = stage.world();
        world.query::<&plumb::physics::RigidBody>().iter(world).count()
    };
    let before = count(&mut stage);
    for (place, added) in [(place, 0), (place - Vec2::X * 0.5 * PANEL, 1)] {
        stage.move_to(place);
        stage.press();
        stage.release();
        stage.frames(2);
        assert_eq!(count(&mut stage), before + added, "at {place}");
    }
}

#[test]
fn keys_change_it_and_choose_no_tool() {
    let mut stage = Stage::open(SCENE);
    for (key, percent) in [
        (KeyCode::Equal, 110),
        (KeyCode::NumpadAdd, 125),
        (KeyCode::Minus, 110),
        (KeyCode::Digit0, 100),
        (KeyCode::NumpadSubtract, 90),
    ] {
        stage.key_with_control(key);
        assert_eq!(stage.world().resource::<InterfaceScale>().0, percent, "{key:?}");
    }
    assert_eq!(*stage.world().resource::<Tool>(), Tool::Drag);
}

#[test]
fn it_grows_no_larger_than_the_window_has_room_for() {
    let mut stage = at(200);
    let window = stage.window();
    stage.world().entity_mut(window).get_mut::<Window>().unwrap().resolution.set(640.0, 360.0);
    stage.world().write_message(WindowResized { window, width: 640.0, height: 360.0 });
    stage.frames(5);
    // All of it is there, at 100 %, but for what the strip leaves out where it is narrow: a button before this one.
    click(&mut stage, Vec2::new(0.0, 360.0) + PAUSE - Vec2::new(32.0, 0.0));
    assert!(stage.world().resource::<Playback>().paused);
    stage.act(SandboxAction::ScaleInterface(ScaleChange::Larger));
    assert!(matches!(stage.world().resource::<Notice>(), Notice::Error(said) if said.contains("no room")));
    assert_eq!(stage.world().resource::<InterfaceScale>().0, 200, "as it was chosen, for a larger window");
}
