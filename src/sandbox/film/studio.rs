//! The sandbox's picture without a window: an app that draws into an image.

use std::time::Duration;

use bevy::app::{FixedMain, PluginGroupBuilder};
use bevy::camera::RenderTarget;
use bevy::log::LogPlugin;
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::render::pipelined_rendering::PipelinedRenderingPlugin;
use bevy::render::render_resource::TextureFormat;
use bevy::render::settings::{Backends, RenderCreation, WgpuSettings};
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured};
use bevy::time::TimeUpdateStrategy;
use bevy::window::ExitCondition;
use bevy::winit::WinitPlugin;

use crate::physics::{PhysicsPlugin, SolverSettings, StepStats};
use crate::sandbox::camera::{self, Framing};
use crate::sandbox::quality::Quality;
use crate::sandbox::window::LOG_FILTER;
use crate::sandbox::{ground, light, meshes, quality, sky};
use crate::scene::{SceneSpec, SpawnedScene, keep_scene};

/// Frames that are drawn before the first that counts: textures and shadows have their place then.
const WARM_UP: usize = 3;
/// Frames after which a picture that was asked for will not come.
const PATIENCE: usize = 100;

/// An app that draws a scene off screen.
pub(super) struct Studio {
    app: App,
    target: Handle<Image>,
    /// The scene's bodies and joints.
    pub entities: SpawnedScene,
    /// Time before the last step, s.
    before: f64,
}

/// What the camera draws into.
#[derive(Resource)]
struct Target(Handle<Image>);

/// The picture that was taken, until somebody takes it away.
#[derive(Resource, Default)]
struct Taken(Option<Image>);

impl Studio {
    /// Puts a scene before the camera, from where it is seen best. The picture is of that size, pixels.
    ///
    /// # Panics
    /// There is no graphics driver: the caller turns that into an error.
    pub fn open(scene: &SceneSpec, settings: SolverSettings, [width, height]: [u16; 2]) -> Self {
        let mut app = App::new();
        app.add_plugins(without_a_window())
            .insert_resource(settings)
            .add_plugins(PhysicsPlugin::default())
            .add_plugins((quality::plugin, light::plugin, sky::plugin, ground::plugin, meshes::plugin));
        keep_scene(&mut app);
        // Steps are made here and by nobody else.
        app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::ZERO)).init_resource::<Taken>();
        app.add_systems(Startup, spawn_camera).add_observer(keep);
        app.finish();
        app.cleanup();
        let image = Image::new_target_texture(u32::from(width), u32::from(height), TextureFormat::Rgba8UnormSrgb, None);
        let target = app.world_mut().resource_mut::<Assets<Image>>().add(image);
        app.insert_resource(Target(target.clone()));
        app.update();
        let world = app.world_mut();
        let entities = scene.spawn(world);
        camera::look(world, Framing::of(scene));
        for _ in 0..WARM_UP {
            app.update();
        }
        Self { app, target, entities, before: 0.0 }
    }

    pub fn world(&mut self) -> &mut World {
        self.app.world_mut()
    }

    /// A picture of the scene at that time, s, no earlier than the last one.
    pub fn picture(&mut self, time: f64) -> Option<Image> {
        while self.time() <= time {
            self.before = self.time();
            self.world().run_schedule(FixedMain);
        }
        let (before, after) = (self.before, self.time());
        // The loop makes a step where a whole one is due: a picture just before it is as good.
        let share = ((time - before) / (after - before)).clamp(0.0, 1.0 - 1e-6);
        let mut fixed = self.world().resource_mut::<Time<Fixed>>();
        let (due, length) = (fixed.overstep(), fixed.timestep());
        fixed.discard_overstep(due);
        fixed.accumulate_overstep(length.mul_f64(share));
        self.take()
    }

    fn time(&self) -> f64 {
        self.app.world().resource::<StepStats>().time
    }

    fn take(&mut self) -> Option<Image> {
        let screenshot = Screenshot::image(self.target.clone());
        self.world().spawn(screenshot);
        (0..PATIENCE).find_map(|_| {
            self.app.update();
            self.app.world_mut().resource_mut::<Taken>().0.take()
        })
    }
}

fn without_a_window() -> PluginGroupBuilder {
    DefaultPlugins
        .build()
        .disable::<WinitPlugin>()
        .disable::<PipelinedRenderingPlugin>()
        .set(WindowPlugin { primary_window: None, exit_condition: ExitCondition::DontExit, ..default() })
        .set(LogPlugin { filter: LOG_FILTER.into(), ..default() })
        .set(RenderPlugin {
            // The others need a display.
            render_creation: RenderCreation::Automatic(Box::new(WgpuSettings {
                backends: Some(Backends::from_env().unwrap_or(Backends::PRIMARY)),
                ..default()
            })),
            // No frame is drawn with a part missing.
            synchronous_pipeline_compilation: true,
            ..default()
        })
}

fn spawn_camera(mut commands: Commands, quality: Res<Quality>, target: Res<Target>) {
    commands.spawn((camera::eye(&quality), RenderTarget::Image(target.0.clone().into())));
}

fn keep(captured: On<ScreenshotCaptured>, mut taken: ResMut<Taken>) {
    taken.0 = Some(captured.image.clone());
}
