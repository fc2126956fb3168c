//! The panel, drawn and clicked without a display.

use bevy::prelude::*;
use bevy_egui::input::EguiWantsInput;
use plumb::physics::{ContactForces, Diagnostics, JointLoad};
use plumb::sandbox::Playback;

use crate::eyes::{click, point_at};
use crate::stage::{SIZE, Stage};

const SCENE: &str = r#"(
    bodies: [
        (name: "ground", kind: Static, shape: HalfSpace),
        (name: "box", shape: Cuboid(size: (1, 1, 1)), mass: 10, position: (0, 0.5, 0)),
    ],
)"#;

/// On the button at the panel's top left.
const PAUSE: Vec2 = Vec2::new(SIZE.x - 290.0, 18.0);

#[test]
fn a_click_on_a_button_is_carried_out() {
    let mut stage = Stage::open(SCENE);
    click(&mut stage, PAUSE);
    assert!(stage.world().resource::<Playback>().paused);
    click(&mut stage, PAUSE);
    assert!(!stage.world().resource::<Playback>().paused);
}

#[test]
fn the_pointer_is_the_panels_over_the_panel_and_the_pictures_beside_it() {
    let mut stage = Stage::open(SCENE);
    for (x, over) in [(SIZE.x - 100.0, true), (400.0, false), (SIZE.x - 2.0, true)] {
        point_at(&mut stage, Vec2::new(x, 0.6 * SIZE.y));
        assert_eq!(stage.world().resource::<EguiWantsInput>().wants_any_pointer_input(), over, "at x = {x}");
    }
}

#[test]
fn only_what_is_on_view_is_measured() {
    let mut stage = Stage::open(SCENE);
    assert!(stage.world().contains_resource::<Diagnostics>(), "the plots are open at the start");
    assert!(!stage.world().contains_resource::<ContactForces>());
    let world = stage.world();
    assert_eq!(world.query::<&JointLoad>().iter(world).count(), 0);
}
