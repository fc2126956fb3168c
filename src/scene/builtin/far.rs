//! A stack and a chain far from the origin: `far`.

use bevy::math::DVec3;

use super::gravity::TEN;
use super::{hanging, palette, stacking};
use crate::scene::info::Parameter;
use crate::scene::{BodySpec, SceneInfo, SceneSpec, Subject, ViewSpec};

pub(super) const FAR: SceneInfo = SceneInfo {
    name: "far",
    title: "Far from the origin",
    subject: Subject::Large,
    about: "'stack 10', and 'chain 100' hung 15 m up and 6 m behind it, both d metres from the origin along x",
    truth: "as at the origin, within 1e-5 m",
    parameters: &[Parameter::real("d", "distance from the origin, m", 1e7, 0.0, 1e8)],
    seconds: 5.0,
    bodies: |_| 23.0,
    build: |values| {
        let d = values[0];
        let mut scene = SceneSpec::new("far", TEN);
        scene.bodies.push(BodySpec::ground().with_color(palette::GROUND));
        stacking::add_column(&mut scene, 10, d);
        // The chain sweeps 12 m around its pivot in a plane that the stack does not reach.
        hanging::hang_chain(&mut scene, DVec3::new(d, 15.0, -6.0), 100.0);
        scene.view = Some(ViewSpec::framing(DVec3::new(d + 3.0, 8.0, -3.0), 13.0, DVec3::new(0.3, 0.15, 1.0)));
        scene
    },
};
