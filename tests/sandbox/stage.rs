//! The sandbox without a display and without a graphics driver, and hands to use it with.

use std::ops::{Deref, DerefMut};
use std::path::Path;

use bevy::input::ButtonState;
use bevy::input::keyboard::{Key, KeyboardInput};
use bevy::input::mouse::{MouseScrollUnit, MouseWheel};
use bevy::input::touch::TouchPhase;
use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_egui::{EguiContexts, EguiPrimaryContextPass, egui};
use plumb::lab::recording::{Recording, Replay};
use plumb::physics::{Position, RenderOrigin};
use plumb::sandbox::{CurrentScene, Hands, SandboxAction};

/// Logical size of the window, which nobody sees.
pub const SIZE: Vec2 = Vec2::new(1280.0, 720.0);

/// The sandbox on a scene, and hands for it.
pub struct Stage {
    hands: Hands,
}

impl Deref for Stage {
    type Target = Hands;

    fn deref(&self) -> &Hands {
        &self.hands
    }
}

impl DerefMut for Stage {
    fn deref_mut(&mut self) -> &mut Hands {
        &mut self.hands
    }
}

impl Stage {
    /// Opens the sandbox on a scene in the format of scene files.
    pub fn open(scene: &str) -> Self {
        let mut stage = Self { hands: Hands::open(SIZE.as_uvec2()) };
        stage.load(scene);
        stage.frames(5);
        stage
    }

    /// The same, where time stands still.
    pub fn open_paused(scene: &str) -> Self {
        let mut stage = Self::open(scene);
        stage.act(SandboxAction::TogglePause);
        stage
    }

    /// Somebody is typing into a field from now on.
    pub fn type_into_a_form(&mut self) {
        self.app.add_systems(EguiPrimaryContextPass, |mut contexts: EguiContexts| -> Result {
            egui::Window::new("form").show(contexts.ctx_mut()?, |ui| {
                let mut text = String::new();
                ui.text_edit_singleline(&mut text).request_focus();
            });
            Ok(())
        });
        self.frames(3);
    }

    /// Replaces the scene.
    pub fn load(&mut self, scene: &str) {
        let file = tempfile::Builder::new().suffix(".ron").tempfile().expect("a temporary file");
        std::fs::write(file.path(), scene).expect("a scene file");
        let scene = file.path().to_str().expect("a UTF-8 path").to_owned();
        self.act(SandboxAction::LoadScene { scene, parameters: Vec::new() });
    }

    /// What happened since the scene began.
    pub fn record(&mut self) -> Recording {
        let current = self.world().resource::<CurrentScene>().clone();
        let (scene, entities) = current.beginning();
        Recording::of_world(self.world(), scene, entities).expect("a history from the start")
    }

    /// What happened since the scene began is a recording that runs again to the last bit.
    pub fn replays(&mut self) {
        let recording = self.record();
        let replay = recording.replay(Path::new("recording.plumb"), |_| ()).unwrap();
        assert_eq!(replay, Replay { steps: recording.steps(), differs: None });
    }

    /// The body of that name in the scene file.
    pub fn body(&mut self, name: &str) -> Entity {
        let current = self.app.world().resource::<CurrentScene>();
        let index = current.spec.bodies.iter().position(|body| body.name == name).expect("a body of that name");
        current.entities.bodies[index]
    }

    /// Its centre of mass, m.
    pub fn position(&mut self, name: &str) -> DVec3 {
        let body = self.body(name);
        self.app.world().get::<Position>(body).expect("a body that is still there").0
    }

    /// The orbit camera's pose.
    pub fn camera(&mut self) -> Transform {
        let world = self.app.world_mut();
        *world.query_filtered::<&Transform, With<Camera3d>>().single(world).expect("one camera")
    }

    /// Distance of a point from the camera along its view, m.
    pub fn depth(&mut self, point: DVec3) -> f64 {
        let camera = self.camera();
        let origin = self.app.world().resource::<RenderOrigin>().0;
        (point - origin - camera.translation.as_dvec3()).dot(camera.forward().as_dvec3())
    }

    /// Where in the window a point of the world is seen.
    pub fn seen_at(&mut self, point: DVec3) -> Vec2 {
        self.try_seen_at(point).expect("a point in the picture")
    }

    /// The same, if it is seen.
    pub fn try_seen_at(&mut self, point: DVec3) -> Option<Vec2> {
        let world = self.app.world_mut();
        let origin = world.resource::<RenderOrigin>().0;
        let (camera, transform) =
            world.query_filtered::<(&Camera, &GlobalTransform), With<Camera3d>>().single(world).expect("one camera");
        camera.world_to_viewport(transform, (point - origin).as_vec3()).ok()
    }

    /// Moves the pointer, as a hand would: in a few frames.
    pub fn move_to(&mut self, position: Vec2) {
        let from = self.pointer();
        for i in 1..=4 {
            self.jump_to(from.lerp(position, i as f32 / 4.0));
            self.frames(1);
        }
    }

    /// Turns the wheel by some notches, up is positive.
    pub fn wheel(&mut self, notches: f32) {
        let window = self.window();
        let (unit, phase) = (MouseScrollUnit::Line, TouchPhase::Moved);
        self.app.world_mut().write_message(MouseWheel { unit, x: 0.0, y: notches, window, phase });
        self.frames(1);
    }

    /// Presses and releases a key.
    pub fn key(&mut self, key_code: KeyCode) {
        self.hold(key_code);
        self.let_go(key_code);
        self.frames(1);
    }

    /// Presses and releases a key while Ctrl is held.
    pub fn key_with_control(&mut self, key_code: KeyCode) {
        self.hold(KeyCode::ControlLeft);
        self.key(key_code);
        self.let_go(KeyCode::ControlLeft);
    }

    /// Presses a key.
    pub fn hold(&mut self, key_code: KeyCode) {
        self.turn_key(key_code, ButtonState::Pressed);
    }

    /// Releases a key.
    pub fn let_go(&mut self, key_code: KeyCode) {
        self.turn_key(key_code, ButtonState::Released);
    }

    /// Presses and releases a key faster than a frame.
    pub fn tap(&mut self, key_code: KeyCode) {
        self.tap_together(&[key_code]);
    }

    /// Presses keys one after the other and releases them, all faster than a frame.
    pub fn tap_together(&mut self, keys: &[KeyCode]) {
        keys.iter().for_each(|key| self.write_key(*key, ButtonState::Pressed));
        keys.iter().rev().for_each(|key| self.write_key(*key, ButtonState::Released));
        self.frames(1);
    }

    fn turn_key(&mut self, key_code: KeyCode, state: ButtonState) {
        self.write_key(key_code, state);
        self.frames(1);
    }

    fn write_key(&mut self, key_code: KeyCode, state: ButtonState) {
        let window = self.window();
        let logical_key = Key::Unidentified(bevy::input::keyboard::NativeKey::Unidentified);
        let (text, repeat) = (None, false);
        self.app.world_mut().write_message(KeyboardInput { key_code, logical_key, state, text, repeat, window });
    }
}
