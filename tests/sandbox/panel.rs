//! The panel, drawn and clicked without a display.

use bevy::input::ButtonState;
use bevy::input::keyboard::{Key, KeyboardInput};
use bevy::input::mouse::MouseButtonInput;
use bevy::prelude::*;
use bevy::window::CursorMoved;
use bevy_egui::input::EguiWantsInput;
use bevy_egui::{EguiContexts, egui};
use plumb::physics::{ContactForces, Diagnostics, JointLoad};
use plumb::sandbox::{CurrentScene, Notice, Page, Playback, SandboxAction, Selection};

use crate::eyes::{click, point_at};
use crate::stage::{SIZE, Stage};

const SCENE: &str = r#"(
    bodies: [
        (name: "ground", kind: Static, shape: HalfSpace),
        (name: "box", shape: Cuboid(size: (1, 1, 1)), mass: 10, position: (0, 0.5, 0)),
    ],
)"#;

/// On the large button of the strip under the picture.
const PAUSE: Vec2 = Vec2::new(166.0, SIZE.y - 33.0);

#[test]
fn a_click_on_a_button_is_carried_out() {
    let mut stage = Stage::open(SCENE);
    click(&mut stage, PAUSE);
    assert!(stage.world().resource::<Playback>().paused);
    click(&mut stage, PAUSE);
    assert!(!stage.world().resource::<Playback>().paused);
}

#[test]
fn a_slow_click_is_a_click() {
    let mut stage = Stage::open(SCENE);
    point_at(&mut stage, PAUSE);
    let window = stage.window();
    for state in [ButtonState::Pressed, ButtonState::Released] {
        stage.world().write_message(MouseButtonInput { button: MouseButton::Left, state, window });
        stage.frames(120); // two seconds
    }
    assert!(stage.world().resource::<Playback>().paused);
}

#[test]
fn a_click_within_a_frame_is_a_click() {
    let mut stage = Stage::open(SCENE);
    let window = stage.window();
    stage.world().write_message(CursorMoved { window, position: PAUSE, delta: None });
    for state in [ButtonState::Pressed, ButtonState::Released] {
        stage.world().write_message(MouseButtonInput { button: MouseButton::Left, state, window });
    }
    stage.frames(2);
    assert!(stage.world().resource::<Playback>().paused);
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
    assert!(!stage.world().contains_resource::<Diagnostics>(), "nobody sees the plots at the start");
    assert!(!stage.world().contains_resource::<ContactForces>());
    let world = stage.world();
    assert_eq!(world.query::<&JointLoad>().iter(world).count(), 0);
    stage.act(SandboxAction::TogglePlots);
    stage.frames(2);
    assert!(stage.world().contains_resource::<Diagnostics>());
    stage.act(SandboxAction::TogglePlots);
    stage.frames(2);
    assert!(!stage.world().contains_resource::<Diagnostics>());
}

#[test]
fn a_click_beside_what_was_clicked_last_is_not_lost() {
    let mut stage = Stage::open(SCENE);
    let [build, analyse] = [SIZE.x - 220.0, SIZE.x - 140.0].map(|x| Vec2::new(x, 20.0));
    for (page, place) in [(Page::Build, build), (Page::Analyse, analyse)] {
        click(&mut stage, place);
        assert_eq!(*stage.world().resource::<Page>(), page);
        let before = stage.world().resource::<Playback>().paused;
        click(&mut stage, PAUSE);
        assert_ne!(stage.world().resource::<Playback>().paused, before, "after a click on {page:?}");
    }
}

#[test]
fn the_edge_makes_the_panel_wider_and_closes_it() {
    let mut stage = Stage::open(SCENE);
    let over = |stage: &mut Stage, x: f32| {
        point_at(stage, Vec2::new(x, 0.6 * SIZE.y));
        stage.world().resource::<EguiWantsInput>().wants_any_pointer_input()
    };
    let drag = |stage: &mut Stage, from: f32, to: f32| {
        let window = stage.window();
        for (x, state) in [(from, ButtonState::Pressed), (to, ButtonState::Released)] {
            point_at(stage, Vec2::new(x, 0.6 * SIZE.y));
            stage.world().write_message(MouseButtonInput { button: MouseButton::Left, state, window });
            stage.frames(2);
        }
    };
    let edge = SIZE.x - 332.0;
    assert!(!over(&mut stage, edge - 50.0));
    drag(&mut stage, edge, edge - 100.0);
    assert!(over(&mut stage, edge - 50.0), "wider");
    drag(&mut stage, edge - 100.0, SIZE.x - 30.0);
    assert!(!over(&mut stage, SIZE.x - 60.0), "closed");
}

/// Types into what has the focus.
fn type_text(stage: &mut Stage, text: &str) {
    for letter in text.chars() {
        type_key(stage, Key::Character(letter.to_string().into()));
    }
}

fn type_key(stage: &mut Stage, logical_key: Key) {
    let window = stage.window();
    let text = match &logical_key {
        Key::Character(text) => Some(text.clone()),
        _ => None,
    };
    for state in [ButtonState::Pressed, ButtonState::Released] {
        let (key_code, logical_key, text) = (KeyCode::F24, logical_key.clone(), text.clone());
        let input = KeyboardInput { key_code, logical_key, state, text, repeat: false, window };
        stage.world().write_message(input);
        stage.frames(1);
    }
    stage.frames(1);
}

fn is_typing(stage: &mut Stage) -> bool {
    stage.world().resource::<EguiWantsInput>().wants_any_keyboard_input()
}

#[test]
fn a_bad_file_name_keeps_the_focus_until_it_is_mended() {
    let mut stage = Stage::open(SCENE);
    fn focus(mut contexts: EguiContexts) {
        let context = contexts.ctx_mut().expect("a panel");
        context.memory_mut(|memory| memory.request_focus(egui::Id::new("scene file")));
        // The line holds the path of the scene on view.
        let last = egui::text::CCursor::new(1000);
        let mut state = egui::TextEdit::load_state(context, egui::Id::new("scene file")).unwrap_or_default();
        state.cursor.set_char_range(Some(egui::text::CCursorRange::two(egui::text::CCursor::new(0), last)));
        state.store(context, egui::Id::new("scene file"));
    }
    stage.world().run_system_cached(focus).unwrap();
    stage.frames(2);
    type_text(&mut stage, "no such file.ron");
    type_key(&mut stage, Key::Enter);
    let Notice::Error(said) = stage.world().resource::<Notice>().clone() else { panic!("nothing was said") };
    assert!(said.contains("no such file.ron"), "{said}");
    assert!(is_typing(&mut stage), "what is typed next mends the name");

    for _ in 0.."no such file.ron".len() {
        type_key(&mut stage, Key::Backspace);
    }
    type_text(&mut stage, "pendulum");
    type_key(&mut stage, Key::Enter);
    assert_eq!(stage.world().resource::<CurrentScene>().scene, "pendulum");
    assert!(!is_typing(&mut stage), "the scene is open: keys are keys again");
}

#[test]
fn a_long_name_does_not_widen_the_panel() {
    let name = "a body whose name goes on and on and on, well beyond what any panel has room for";
    let scene = SCENE.replace("name: \"box\"", &format!("name: \"{name}\""));
    let edge = |stage: &mut Stage| {
        // From the left, the first place that is the panel's.
        (0..100).map(|step| SIZE.x - 600.0 + 5.0 * step as f32).find(|x| {
            point_at(stage, Vec2::new(*x, 0.6 * SIZE.y));
            stage.world().resource::<EguiWantsInput>().wants_any_pointer_input()
        })
    };
    let mut stage = Stage::open(&scene);
    let before = edge(&mut stage).expect("a panel");
    let body = stage.body(name);
    *stage.world().resource_mut::<Selection>() = Selection::of(body);
    stage.frames(10);
    assert_eq!(edge(&mut stage), Some(before));
}
