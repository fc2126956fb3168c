//! `empty`: a ground to build on.

use bevy::math::DVec3;

use super::gravity::EARTH;
use super::palette;
use crate::scene::{BodySpec, SceneInfo, SceneSpec, Subject, ViewSpec};

pub(super) const EMPTY: SceneInfo = SceneInfo {
    name: "empty",
    title: "Empty ground",
    subject: Subject::Machines,
    about: "level ground and nothing on it, to build on",
    truth: "nothing moves",
    parameters: &[],
    seconds: 1.0,
    bodies: |_| 1.0,
    build: |_| {
        let mut scene = SceneSpec::new("empty", EARTH);
        scene.bodies.push(BodySpec::ground().with_color(palette::GROUND));
        scene.view = Some(ViewSpec::framing(DVec3::new(0.0, 0.9, 0.0), 3.0, DVec3::new(0.2, 0.22, 1.0)));
        scene
    },
};
