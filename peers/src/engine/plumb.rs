//! Plumb through its public face: a headless world, a scene spawned into it, `step`.

use bevy::app::App;
use bevy::prelude::Entity;
use plumb::lab::BodyState;
use plumb::physics::{ImpulseSettings, Position, Precision, Rotation, SolverSettings, Velocity, headless_app, step};

use super::{Engine, Method, Settings};
use crate::scene::Scene;

/// A scene in a world of its own.
pub struct Plumb {
    app: App,
    bodies: Vec<Entity>,
}

impl Plumb {
    pub fn new(scene: &Scene, settings: SolverSettings) -> Self {
        let mut app = headless_app();
        app.insert_resource(settings);
        let bodies = scene.spec.spawn(app.world_mut()).bodies;
        Self { app, bodies }
    }
}

impl Engine for Plumb {
    fn step(&mut self) {
        step(self.app.world_mut());
    }

    fn read(&mut self, states: &mut Vec<BodyState>) {
        states.clear();
        states.extend(self.bodies.iter().map(|&body| {
            let body = self.app.world().entity(body);
            let (Position(position), Rotation(rotation), velocity) =
                body.components::<(&Position, &Rotation, &Velocity)>();
            BodyState { position: *position, rotation: *rotation, linear: velocity.linear, angular: velocity.angular }
        }));
    }
}

/// What else is measured besides the presets: the default one with all its effort for what rests, too.
pub const FULL_EFFORT: &str = "full-effort";

/// A preset at the asked rate, with sleep off, as in the other engines, unless it is asked for. Substeps are the preset's own unless asked for.
pub fn settings(preset: &str, asked: &Settings) -> SolverSettings {
    let fits_effort = preset != FULL_EFFORT;
    let preset = SolverSettings::preset(preset).unwrap_or_default();
    SolverSettings {
        impulse: ImpulseSettings {
            fitted_effort: preset.impulse.fitted_effort && fits_effort,
            sleep_speed: preset.impulse.sleep_speed.filter(|_| asked.sleep),
        },
        hz: asked.hz,
        substeps: asked.substeps.unwrap_or(preset.substeps),
        threads: asked.threads,
        ..preset
    }
}

pub fn method(preset: &str, asked: &Settings) -> Method {
    let settings = settings(preset, asked);
    let precision = match settings.precision {
        Precision::F32 => "f32",
        Precision::F64 => "f64",
    };
    Method {
        version: super::locked_version("plumb"),
        precision,
        substeps: settings.substeps,
        iterations: settings.iterations,
    }
}
