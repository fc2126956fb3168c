//! The sandbox without a display and without a graphics driver, and hands to use it with.

use std::time::Duration;

use bevy::camera::NormalizedRenderTarget;
use bevy::log::LogPlugin;
use bevy::picking::pointer::{Location, PointerAction, PointerButton, PointerId, PointerInput};
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::render::settings::{RenderCreation, WgpuSettings};
use bevy::time::TimeUpdateStrategy;
use bevy::window::{PrimaryWindow, WindowRef, WindowResolution};
use bevy::winit::WinitPlugin;

use super::{SandboxAction, SandboxPlugin, StepBudget};

/// Time that passes from frame to frame, s.
const FRAME: f64 = 1.0 / 60.0;

/// The sandbox in a window that nobody sees, with nothing in it yet, and a hand on its mouse. A frame takes 1/60 s however
/// long it takes, and makes all steps that are due in it.
pub struct Hands {
    /// The sandbox.
    pub app: App,
    /// Where the pointer is, logical pixels.
    pointer: Vec2,
}

impl Hands {
    /// Opens the sandbox. The window is of that size, logical pixels.
    pub fn open(size: UVec2) -> Self {
        let resolution = WindowResolution::new(size.x, size.y).with_scale_factor_override(1.0);
        let window = WindowPlugin { primary_window: Some(Window { resolution, ..default() }), ..default() };
        let render = RenderPlugin {
            render_creation: RenderCreation::Automatic(Box::new(WgpuSettings { backends: None, ..default() })),
            ..default()
        };
        let mut app = App::new();
        app.add_plugins(DefaultPlugins.build().disable::<WinitPlugin>().disable::<LogPlugin>().set(window).set(render));
        app.add_plugins(SandboxPlugin);
        app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f64(FRAME)));
        // On a busy machine too, what happens in a frame is what would happen on an idle one.
        app.insert_resource(StepBudget { least: Duration::MAX, of_picture: 0.0 });
        app.finish();
        app.cleanup();
        let mut hands = Self { app, pointer: Vec2::ZERO };
        hands.frames(2);
        hands
    }

    /// Lets so many frames pass.
    pub fn frames(&mut self, count: usize) {
        for _ in 0..count {
            self.app.update();
        }
    }

    /// Asks for something; the frame in which it is done passes.
    pub fn act(&mut self, action: SandboxAction) {
        self.app.world_mut().write_message(action);
        self.frames(1);
    }

    /// The sandbox's world.
    pub fn world(&mut self) -> &mut World {
        self.app.world_mut()
    }

    /// Where the pointer is, logical pixels.
    pub fn pointer(&self) -> Vec2 {
        self.pointer
    }

    /// Moves the pointer at once; nothing sees it before the next frame.
    pub fn jump_to(&mut self, position: Vec2) {
        let delta = position - self.pointer;
        self.pointer = position;
        let window = self.window();
        if let Some(mut window) = self.app.world_mut().get_mut::<Window>(window) {
            window.set_cursor_position(Some(position));
        }
        self.point(PointerAction::Move { delta });
    }

    /// Presses the left button.
    pub fn press(&mut self) {
        self.point(PointerAction::Press(PointerButton::Primary));
        self.frames(1);
    }

    /// Releases it.
    pub fn release(&mut self) {
        self.point(PointerAction::Release(PointerButton::Primary));
        self.frames(1);
    }

    /// Presses the right button.
    pub fn press_right(&mut self) {
        self.point(PointerAction::Press(PointerButton::Secondary));
        self.frames(1);
    }

    /// Releases it.
    pub fn release_right(&mut self) {
        self.point(PointerAction::Release(PointerButton::Secondary));
        self.frames(1);
    }

    /// The window.
    ///
    /// # Panics
    /// Somebody closed it.
    pub fn window(&mut self) -> Entity {
        let world = self.app.world_mut();
        world.query_filtered::<Entity, With<PrimaryWindow>>().single(world).expect("one window")
    }

    fn point(&mut self, action: PointerAction) {
        let window = self.window();
        let Some(target) = WindowRef::Primary.normalize(Some(window)) else { return };
        let location = Location { target: NormalizedRenderTarget::Window(target), position: self.pointer };
        self.app.world_mut().write_message(PointerInput::new(PointerId::Mouse, location, action));
    }
}
