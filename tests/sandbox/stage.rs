//! The sandbox without a display and without a graphics driver, and hands to use it with.

use std::time::Duration;

use bevy::camera::NormalizedRenderTarget;
use bevy::input::ButtonState;
use bevy::input::keyboard::{Key, KeyboardInput};
use bevy::input::mouse::{MouseScrollUnit, MouseWheel};
use bevy::input::touch::TouchPhase;
use bevy::log::LogPlugin;
use bevy::math::DVec3;
use bevy::picking::pointer::{Location, PointerAction, PointerButton, PointerId, PointerInput};
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::render::settings::{RenderCreation, WgpuSettings};
use bevy::time::TimeUpdateStrategy;
use bevy::window::{PrimaryWindow, WindowRef, WindowResolution};
use bevy::winit::WinitPlugin;
use plumb::physics::{Position, RenderOrigin};
use plumb::sandbox::{CurrentScene, SandboxAction, SandboxPlugin, StepBudget};

/// Logical size of the window, which nobody sees.
pub const SIZE: Vec2 = Vec2::new(1280.0, 720.0);

/// The sandbox on a scene, stepped frame by frame, 1/60 s each.
pub struct Stage {
    pub app: App,
    pointer: Vec2,
}

impl Stage {
    /// Opens the sandbox on a scene in the format of scene files.
    pub fn open(scene: &str) -> Self {
        let mut app = App::new();
        app.add_plugins(
            DefaultPlugins
                .build()
                .disable::<WinitPlugin>()
                .disable::<LogPlugin>()
                .set(WindowPlugin {
                    primary_window: Some(Window {
                        resolution: WindowResolution::new(SIZE.x as u32, SIZE.y as u32).with_scale_factor_override(1.0),
                        ..default()
                    }),
                    ..default()
                })
                .set(RenderPlugin {
                    render_creation: RenderCreation::Automatic(Box::new(WgpuSettings { backends: None, ..default() })),
                    ..default()
                }),
        );
        app.add_plugins(SandboxPlugin);
        app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f64(1.0 / 60.0)));
        // On a busy machine too, what happens in a frame is what would happen on an idle one.
        app.insert_resource(StepBudget { least: Duration::MAX, of_picture: 0.0 });
        app.finish();
        app.cleanup();
        let mut stage = Self { app, pointer: Vec2::ZERO };
        stage.frames(2);
        stage.load(scene);
        stage.frames(5);
        stage
    }

    /// Replaces the scene.
    pub fn load(&mut self, scene: &str) {
        let file = tempfile::Builder::new().suffix(".ron").tempfile().expect("a temporary file");
        std::fs::write(file.path(), scene).expect("a scene file");
        let scene = file.path().to_str().expect("a UTF-8 path").to_owned();
        self.act(SandboxAction::LoadScene { scene, parameters: Vec::new() });
    }

    pub fn frames(&mut self, count: usize) {
        for _ in 0..count {
            self.app.update();
        }
    }

    pub fn act(&mut self, action: SandboxAction) {
        self.app.world_mut().write_message(action);
        self.frames(1);
    }

    pub fn world(&mut self) -> &mut World {
        self.app.world_mut()
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
        let from = self.pointer;
        for i in 1..=4 {
            self.jump_to(from.lerp(position, i as f32 / 4.0));
            self.frames(1);
        }
    }

    /// Moves the pointer at once; nothing sees it before the next frame.
    pub fn jump_to(&mut self, position: Vec2) {
        let delta = position - self.pointer;
        self.pointer = position;
        let window = self.window();
        let mut entity = self.app.world_mut().entity_mut(window);
        let mut window = entity.get_mut::<Window>().expect("a window");
        window.set_cursor_position(Some(position));
        self.point(PointerAction::Move { delta });
    }

    pub fn press(&mut self) {
        self.point(PointerAction::Press(PointerButton::Primary));
        self.frames(1);
    }

    pub fn release(&mut self) {
        self.point(PointerAction::Release(PointerButton::Primary));
        self.frames(1);
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

    pub fn window(&mut self) -> Entity {
        let world = self.app.world_mut();
        world.query_filtered::<Entity, With<PrimaryWindow>>().single(world).expect("one window")
    }

    fn point(&mut self, action: PointerAction) {
        let window = self.window();
        let target = WindowRef::Primary.normalize(Some(window)).expect("the primary window");
        let location = Location { target: NormalizedRenderTarget::Window(target), position: self.pointer };
        self.app.world_mut().write_message(PointerInput::new(PointerId::Mouse, location, action));
    }
}
