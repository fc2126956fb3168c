//! A row of dominoes: `dominoes`.

use bevy::math::{DQuat, DVec3};

use super::gravity::EARTH;
use super::palette;
use crate::scene::{BodySpec, SceneInfo, SceneSpec, ShapeSpec, Subject, ViewSpec};

const COUNT: usize = 20;
const PITCH: f64 = 0.5;
const SIZE: DVec3 = DVec3::new(0.2, 1.0, 0.5);
/// Past atan(0.2/1) = 11.3°, where it would balance on its edge. Its centre is in line with the
/// others': it falls by 11° till it meets the next. Were its edge in line, it would meet the next
/// 2.5° on, too slow to push it over.
const FIRST_TILT_DEGREES: f64 = 15.0;

pub(super) const DOMINOES: SceneInfo = SceneInfo {
    name: "dominoes",
    title: "Dominoes",
    subject: Subject::Friction,
    about: "20 dominoes 0.2 x 1 x 0.5 m in a row, 0.5 m apart, the first tilted by 15 degrees toward the next",
    truth: "all fall, one after the other",
    parameters: &[],
    seconds: 8.0,
    bodies: |_| COUNT as f64 + 1.0,
    build: |_| {
        let mut scene = SceneSpec::new("dominoes", EARTH);
        scene.bodies.push(BodySpec::ground().with_color(palette::GROUND));
        for i in 0..COUNT {
            let tilt = if i == 0 { FIRST_TILT_DEGREES.to_radians() } else { 0.0 };
            let height = SIZE.y * tilt.cos() + SIZE.x * tilt.sin();
            let position = DVec3::new(i as f64 * PITCH, 0.5 * height, 0.0);
            let rotation = DQuat::from_rotation_z(-tilt);
            scene.bodies.push(
                BodySpec::new(format!("domino {i}"), ShapeSpec::Cuboid { size: SIZE }, position)
                    .with_rotation(rotation)
                    .with_color(palette::bright(i)),
            );
        }
        let middle = DVec3::new(0.5 * PITCH * (COUNT - 1) as f64, 0.4, 0.0);
        scene.view = Some(ViewSpec::framing(middle, 3.9, DVec3::new(-0.4, 0.45, 1.0)));
        scene
    },
};
