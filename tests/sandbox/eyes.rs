//! The panel as somebody at the screen has it: texts and dots where they are drawn, clicks on them, a line to type in.

use bevy::input::ButtonState;
use bevy::input::keyboard::{Key, KeyCode, KeyboardInput, NativeKeyCode};
use bevy::input::mouse::MouseButtonInput;
use bevy::prelude::*;
use bevy::window::{CursorMoved, WindowResized};
use bevy_egui::egui::{self, Shape};
use bevy_egui::{EguiFullOutput, EguiPostUpdateSet, PrimaryEguiContext};
use plumb::sandbox::Page;

use crate::stage::{SIZE, Stage};

/// Higher than the whole panel, so that nothing has to be scrolled to.
const HEIGHT: f32 = 3000.0;

/// What egui painted in the last frame.
#[derive(Resource, Default)]
struct Painted {
    texts: Vec<(String, Vec2)>,
    discs: Vec<(egui::Color32, Vec2)>,
    /// Red frames, which egui draws in debug builds around what has got another id, since eyes were opened.
    alarms: usize,
}

impl Painted {
    fn take(&mut self, shape: &Shape) {
        match shape {
            Shape::Vec(shapes) => shapes.iter().for_each(|shape| self.take(shape)),
            Shape::Text(text) => {
                let middle = text.visual_bounding_rect().center();
                self.texts.push((text.galley.text().to_owned(), Vec2::new(middle.x, middle.y)));
            }
            Shape::Rect(frame) if frame.stroke == egui::Stroke::new(2.0, egui::Color32::RED) => self.alarms += 1,
            Shape::Circle(disc) => self.discs.push((disc.fill, Vec2::new(disc.center.x, disc.center.y))),
            _ => {}
        }
    }
}

fn look(output: Single<&EguiFullOutput, With<PrimaryEguiContext>>, mut painted: ResMut<Painted>) {
    if let Some(output) = &output.0 {
        *painted = Painted { alarms: painted.alarms, ..default() };
        output.shapes.iter().for_each(|clipped| painted.take(&clipped.shape));
    }
}

/// From here on the panel can be read, all of that page.
pub fn open_eyes(stage: &mut Stage, page: Page) {
    stage.world().insert_resource(page);
    stage
        .app
        .init_resource::<Painted>()
        .add_systems(PostUpdate, look.after(EguiPostUpdateSet::EndPass).before(EguiPostUpdateSet::ProcessOutput));
    let window = stage.window();
    let mut entity = stage.world().entity_mut(window);
    entity.get_mut::<Window>().expect("a window").resolution.set(SIZE.x, HEIGHT);
    stage.world().write_message(WindowResized { window, width: SIZE.x, height: HEIGHT });
    stage.frames(4);
}

/// Every text, in the order of drawing.
pub fn texts(stage: &mut Stage) -> Vec<(String, Vec2)> {
    stage.world().resource::<Painted>().texts.clone()
}

/// Whether a text is shown that has this in it.
pub fn reads(stage: &mut Stage, part: &str) -> bool {
    texts(stage).iter().any(|(text, _)| text.contains(part))
}

/// The first text that has this in it.
pub fn text_with(stage: &mut Stage, part: &str) -> Option<String> {
    texts(stage).into_iter().map(|(text, _)| text).find(|text| text.contains(part))
}

/// How often egui has drawn a red frame: something is in the place of another thing, and egui takes it for that one.
pub fn alarms(stage: &mut Stage) -> usize {
    stage.world().resource::<Painted>().alarms
}

/// Where that very text is, below another one if it is on view more than once.
pub fn seen(stage: &mut Stage, text: &str, below: &str) -> Vec2 {
    let texts = texts(stage);
    let at = |wanted: &str, from: f32| {
        let found = texts.iter().filter(|(text, place)| text == wanted && place.y >= from);
        found.min_by(|(_, one), (_, other)| one.y.total_cmp(&other.y)).map(|(_, place)| *place)
    };
    let from = at(below, 0.0).map_or(0.0, |place| place.y);
    at(text, from)
        .unwrap_or_else(|| panic!("no '{text}' among {:?}", texts.iter().map(|(text, _)| text).collect::<Vec<_>>()))
}

/// Middles of the discs of a colour, from left to right.
pub fn discs(stage: &mut Stage, [r, g, b]: [u8; 3]) -> Vec<Vec2> {
    let color = egui::Color32::from_rgb(r, g, b);
    let of_color = stage.world().resource::<Painted>().discs.iter().filter(|(fill, _)| *fill == color);
    let mut places: Vec<Vec2> = of_color.map(|(_, place)| *place).collect();
    places.sort_by(|one, other| one.x.total_cmp(&other.x));
    places
}

/// Puts the pointer there.
pub fn point_at(stage: &mut Stage, position: Vec2) {
    let window = stage.window();
    stage.world().write_message(CursorMoved { window, position, delta: None });
    stage.frames(2);
}

/// Clicks there.
pub fn click(stage: &mut Stage, position: Vec2) {
    point_at(stage, position);
    let window = stage.window();
    for state in [ButtonState::Pressed, ButtonState::Released] {
        stage.world().write_message(MouseButtonInput { button: MouseButton::Left, state, window });
        stage.frames(1);
    }
    stage.frames(1);
}

/// Clicks on that very text, below another one if it is on view more than once.
pub fn click_on(stage: &mut Stage, text: &str, below: &str) {
    let place = seen(stage, text, below);
    click(stage, place);
    // What opens takes a frame to know its size, and some to unfold.
    stage.frames(30);
}

/// Replaces what a line says, and presses Enter.
pub fn rewrite(stage: &mut Stage, line: &str, below: &str, text: &str) {
    click_on(stage, line, below);
    key(stage, Key::End);
    line.chars().for_each(|_| key(stage, Key::Backspace));
    text.chars().for_each(|letter| key(stage, Key::Character(letter.to_string().into())));
    key(stage, Key::Enter);
    stage.frames(2);
}

fn key(stage: &mut Stage, logical_key: Key) {
    let window = stage.window();
    let key_code = KeyCode::Unidentified(NativeKeyCode::Unidentified);
    for state in [ButtonState::Pressed, ButtonState::Released] {
        let (logical_key, text, repeat) = (logical_key.clone(), None, false);
        stage.world().write_message(KeyboardInput { key_code, logical_key, state, text, repeat, window });
    }
    stage.frames(1);
}
