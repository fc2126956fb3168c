//! What the panel looks like: what stands where, and what is told of settings that were changed.

use bevy::prelude::*;
use plumb::physics::SolverSettings;
use plumb::sandbox::{CurrentScene, Page, SandboxAction, Selection};

use crate::eyes::{alarms, click_on, open_eyes, reads, seen, texts};
use crate::stage::Stage;

const SCENE: &str = r#"(
    bodies: [
        (name: "ground", kind: Static, shape: HalfSpace),
        (name: "ball", shape: Sphere(radius: 0.5), position: (-2, 0.5, 0)),
        (name: "post", kind: Static, shape: Cuboid(size: (1, 1, 1)), position: (0, 0.5, 0)),
        (name: "arm", shape: Cuboid(size: (1, 0.2, 0.2)), position: (1, 1, 0)),
        (name: "hand", shape: Cuboid(size: (0.2, 0.2, 0.2)), position: (1.6, 1, 0)),
    ],
    joints: [
        (body_a: "post", body_b: "arm", at: (0.5, 1, 0), kind: Hinge, axis: (0, 0, 1)),
        (body_a: "arm", body_b: "hand", at: (1.5, 1, 0)),
    ],
)"#;

fn pick(stage: &mut Stage, name: &str) {
    let body = stage.body(name);
    *stage.world().resource_mut::<Selection>() = Selection::of(body);
    stage.frames(6);
}

#[test]
fn names_of_pages_stand_in_the_middle_of_their_buttons() {
    let mut stage = Stage::open(SCENE);
    open_eyes(&mut stage, Page::Play);
    let middles = ["Play", "Build", "Analyse", "Solver"].map(|name| seen(&mut stage, name, name).x);
    let apart: Vec<f32> = middles.windows(2).map(|pair| pair[1] - pair[0]).collect();
    // Buttons are equally wide, and words are not: only middles are equally far apart.
    for distance in &apart {
        assert!((distance - apart[0]).abs() < 1.5, "{apart:?}");
    }
}

#[test]
fn what_is_shown_in_the_place_of_something_else_is_another_thing() {
    let mut stage = Stage::open(SCENE);
    stage.act(SandboxAction::TogglePause);
    open_eyes(&mut stage, Page::Build);
    for name in ["ball", "arm", "post", "hand", "arm"] {
        pick(&mut stage, name);
        assert!(reads(&mut stage, "Inspector"), "{name}");
        assert_eq!(alarms(&mut stage), 0, "after {name} was picked");
    }
    let joint = stage.world().resource::<CurrentScene>().entities.joints[0];
    stage.act(SandboxAction::Cut(joint));
    stage.frames(6);
    assert_eq!(alarms(&mut stage), 0, "after a joint was cut");
    stage.act(SandboxAction::Undo);
    stage.frames(6);
    assert_eq!(alarms(&mut stage), 0, "after it was there again");
    for page in [Page::Solver, Page::Analyse, Page::Play, Page::Build] {
        stage.world().insert_resource(page);
        stage.frames(6);
        assert_eq!(alarms(&mut stage), 0, "after {page:?} was turned to");
    }
}

#[test]
fn settings_that_were_changed_are_marked_and_go_back_one_by_one_and_all_at_once() {
    let mut stage = Stage::open(SCENE);
    let preset = *stage.world().resource::<SolverSettings>();
    assert_eq!(preset, SolverSettings::game());
    open_eyes(&mut stage, Page::Solver);
    assert!(!reads(&mut stage, "changed") && !reads(&mut stage, "⟲ all"));
    stage.world().resource_mut::<SolverSettings>().hz = 125.0;
    stage.frames(2);
    stage.world().resource_mut::<SolverSettings>().slop = 0.02;
    stage.frames(2);
    assert!(reads(&mut stage, "game, 2 changed") && reads(&mut stage, "Advanced (1 changed)"));
    assert!(!reads(&mut stage, "axis merging"), "rare ones are folded");

    // The arrow of one row, below its label.
    click_on(&mut stage, "⟲", "method");
    let now = *stage.world().resource::<SolverSettings>();
    assert_eq!((now.hz, now.slop), (preset.hz, 0.02));
    click_on(&mut stage, "Advanced (1 changed)", "Step");
    assert!(reads(&mut stage, "axis merging"));
    click_on(&mut stage, "⟲ all", "preset");
    assert_eq!(*stage.world().resource::<SolverSettings>(), preset);
    assert!(!reads(&mut stage, "changed"));
}

#[test]
fn a_scene_without_a_ground_has_axes_and_a_cell_of_known_length() {
    let mut stage = Stage::open(SCENE);
    open_eyes(&mut stage, Page::Solver);
    let letters = |stage: &mut Stage| {
        let texts = texts(stage);
        ["X", "Y", "Z"].map(|letter| texts.iter().any(|(text, _)| text == letter))
    };
    assert_eq!(letters(&mut stage), [false; 3], "the ground has squares of its own");
    let hung = r#"(bodies: [
            (name: "hook", kind: Static, position: (0, 0, 0)),
            (name: "rod", shape: Cuboid(size: (4, 0.2, 0.2)), position: (2, 0, 0)),
        ],
        joints: [(body_a: "hook", body_b: "rod", at: (0, 0, 0), kind: Hinge, axis: (0, 0, 1))])"#;
    stage.load(hung);
    stage.frames(3);
    assert_eq!(letters(&mut stage), [true; 3]);
    assert!(texts(&mut stage).iter().any(|(text, _)| text == "1 m"), "{:?}", texts(&mut stage));
    stage.load(SCENE);
    stage.frames(3);
    assert_eq!(letters(&mut stage), [false; 3]);
}
