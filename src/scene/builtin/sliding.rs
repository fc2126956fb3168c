//! Friction: `incline`, `slide_roll`, `rolling`, `painleve`.

use std::f64::consts::TAU;

use bevy::math::{DQuat, DVec3};

use super::gravity::{EARTH, EARTH_G};
use super::palette;
use crate::physics::LockedAxes;
use crate::scene::info::Parameter;
use crate::scene::{BodySpec, SceneInfo, SceneSpec, ShapeSpec, Subject, ViewSpec};

pub(super) const INCLINE: SceneInfo = SceneInfo {
    name: "incline",
    title: "Box on a slope",
    subject: Subject::Friction,
    about: "a box 2 x 0.5 x 1 m at rest, its long side down a slope (level ground, gravity turned toward +x), or a prism",
    truth: "closed form: sticks if tan theta < mu, else s = 1/2 g (sin theta - mu cos theta) t^2",
    parameters: &[
        Parameter::real("theta", "angle of the slope, degrees", 30.0, 0.0, 85.0),
        Parameter::real("mu", "friction of the pair", 0.4, 0.0, 10.0),
        Parameter::whole("points", "corners that it stands on: 4 of the box, else of a prism", 4.0, 1.0, 64.0),
    ],
    seconds: 2.0,
    bodies: |_| 2.0,
    build: |values| build_incline(values[0], values[1], values[2] as usize),
};

pub(super) const SLIDE_ROLL: SceneInfo = SceneInfo {
    name: "slide_roll",
    title: "Sliding, then rolling",
    subject: Subject::Friction,
    about: "a ball of radius 0.5 m thrown along the ground at 5 m/s without spin, friction 0.3",
    truth: "closed form: rolls from t = 2 v0 / (7 mu g) on at 5/7 v0",
    parameters: &[],
    seconds: 2.0,
    bodies: |_| 2.0,
    build: |_| {
        const RADIUS: f64 = 0.5;
        let mut scene = SceneSpec::new("slide_roll", EARTH);
        scene.bodies.push(BodySpec::ground().with_material(0.3, 0.0).with_color(palette::GROUND));
        scene.bodies.push(
            BodySpec::new("ball", ShapeSpec::Sphere { radius: RADIUS }, RADIUS * DVec3::Y)
                .with_velocity(5.0 * DVec3::X, DVec3::ZERO)
                .with_material(0.3, 0.0)
                .with_color(palette::RED),
        );
        scene.view = Some(ViewSpec::framing(DVec3::new(3.0, 0.5, 0.0), 4.5, DVec3::new(0.1, 0.35, 1.0)));
        scene
    },
};

pub(super) const ROLLING: SceneInfo = SceneInfo {
    name: "rolling",
    title: "Balls on a pushed slab",
    subject: Subject::Friction,
    about: "a slab 20 x 1 x 20 m of 10 kg with 25 balls of 1 kg on it, pushed at its centre with 150 N",
    truth: "closed form: a_slab = (150 - 0.4 * 35 g) / (10 + 50/7), a_ball = 2/7 a_slab",
    parameters: &[Parameter::real("angle", "of the push to the x axis, toward +z, degrees", 0.0, 0.0, 90.0)],
    seconds: 4.0,
    bodies: |_| 27.0,
    build: |values| build_rolling(values[0]),
};

pub(super) const PAINLEVE: SceneInfo = SceneInfo {
    name: "painleve",
    title: "Painlevé's rod",
    subject: Subject::Friction,
    about: "a rod 1 x 0.02 x 0.02 m tilted to the ground, its lower end sliding at 5 m/s away from the side it leans to",
    truth: "mu < 1.34 at 60 degrees: the equation of motion, till it lifts off or sticks; above, no rigid motion exists: no energy gained",
    parameters: &[
        Parameter::real("mu", "friction of the pair", 1.0, 0.0, 10.0),
        Parameter::real("tilt", "angle of the rod to the ground, degrees", 60.0, 5.0, 85.0),
    ],
    seconds: 1.0,
    bodies: |_| 2.0,
    build: |values| build_painleve(values[0], values[1]),
};

fn build_incline(theta_degrees: f64, friction: f64, points: usize) -> SceneSpec {
    let (sin, cos) = theta_degrees.to_radians().sin_cos();
    let mut scene = SceneSpec::new("incline", EARTH_G * DVec3::new(sin, -cos, 0.0));
    let (shape, height) = slider(points);
    // What stands on one or two points would fall over.
    let rotation = [points < 3; 3];
    scene.bodies.push(BodySpec::ground().with_material(friction, 0.0).with_color(palette::GROUND));
    scene.bodies.push(BodySpec {
        locked: LockedAxes { rotation, ..LockedAxes::default() },
        ..BodySpec::new("box", shape, DVec3::new(0.0, height, 0.0))
            .with_material(friction, 0.0)
            .with_color(palette::ORANGE)
    });
    scene.view = Some(ViewSpec::framing(DVec3::new(2.0, 0.25, 0.0), 3.5, DVec3::new(0.2, 0.35, 1.0)));
    scene
}

/// What stands on so many corners, and how high its centre is then, m: a ball, a wedge on its edge, the box, or a prism
/// so flat that it does not fall over on any slope.
fn slider(points: usize) -> (ShapeSpec, f64) {
    const RADIUS: f64 = 0.8;
    const HALF_HEIGHT: f64 = 0.1;
    match points {
        1 => (ShapeSpec::Sphere { radius: 0.5 }, 0.5),
        2 => {
            let ends = [-0.5, 0.5].into_iter();
            let wedge = ends.flat_map(|z| [(0.0, -0.2), (-0.4, 0.1), (0.4, 0.1)].map(|(x, y)| DVec3::new(x, y, z)));
            (ShapeSpec::hull(wedge.collect::<Vec<_>>()), 0.2)
        }
        4 => (ShapeSpec::Cuboid { size: DVec3::new(2.0, 0.5, 1.0) }, 0.25),
        _ => {
            let corner = |index: usize, y: f64| {
                let (sin, cos) = (TAU * index as f64 / points as f64).sin_cos();
                DVec3::new(RADIUS * cos, y, RADIUS * sin)
            };
            let corners = (0..points).flat_map(|index| [-HALF_HEIGHT, HALF_HEIGHT].map(|y| corner(index, y)));
            (ShapeSpec::hull(corners.collect::<Vec<_>>()), HALF_HEIGHT)
        }
    }
}

fn build_rolling(angle: f64) -> SceneSpec {
    const PUSH: f64 = 150.0;
    // √(0.8·0.8) between ball and slab, √(0.8·0.2) = 0.4 between slab and ground.
    const UPPER_FRICTION: f64 = 0.8;
    const GROUND_FRICTION: f64 = 0.2;
    let (sin, cos) = angle.to_radians().sin_cos();
    let mut scene = SceneSpec::new("rolling", EARTH);
    scene.bodies.push(BodySpec::ground().with_material(GROUND_FRICTION, 0.0).with_color(palette::GROUND));
    let slab = ShapeSpec::Cuboid { size: DVec3::new(20.0, 1.0, 20.0) };
    scene.bodies.push(BodySpec {
        force: PUSH * DVec3::new(cos, 0.0, sin),
        ..BodySpec::new("slab", slab, 0.5 * DVec3::Y)
            .with_mass(10.0)
            .with_material(UPPER_FRICTION, 0.0)
            .with_color(palette::WOOD)
    });
    for i in 0..25 {
        let (x, z) = (2.0 * f64::from(i / 5) - 4.0, 2.0 * f64::from(i % 5) - 4.0);
        scene.bodies.push(
            BodySpec::new(format!("ball {i}"), ShapeSpec::Sphere { radius: 0.5 }, DVec3::new(x, 1.5, z))
                .with_mass(1.0)
                .with_material(UPPER_FRICTION, 0.0)
                .with_color(palette::bright(i as usize)),
        );
    }
    scene.view = Some(ViewSpec::framing(DVec3::new(2.0, 0.5, 0.0), 14.0, DVec3::new(0.4, 0.6, 1.0)));
    scene
}

/// The lower edge that touches is at the origin. The rod is held in its plane: so thin, it would
/// roll about its long axis at the least difference between the ends of that edge.
///
/// Normal force and friction of unit N accelerate it upwards by (1 + x (x − μ y)/k²)/m, where it
/// lies x beside and y below the centre of mass, and m k² = m (L² + w²)/12 is the moment of
/// inertia. From μ = (k² + x²)/(x y) on, 1.3396 at 60°, that is not upwards: a larger force presses the
/// edge only harder into the ground, and no finite force stops it (Painlevé 1895).
fn build_painleve(friction: f64, tilt_degrees: f64) -> SceneSpec {
    const SIZE: DVec3 = DVec3::new(1.0, 0.02, 0.02);
    let mut scene = SceneSpec::new("painleve", EARTH);
    scene.bodies.push(BodySpec::ground().with_material(friction, 0.0).with_color(palette::GROUND));
    // The rod's x axis points from its lower end up and back.
    let rotation = DQuat::from_rotation_z((180.0 - tilt_degrees).to_radians());
    let touching = rotation * DVec3::new(-0.5 * SIZE.x, 0.5 * SIZE.y, 0.0);
    scene.bodies.push(BodySpec {
        locked: LockedAxes { translation: [false, false, true], rotation: [true, true, false] },
        ..BodySpec::new("rod", ShapeSpec::Cuboid { size: SIZE }, DVec3::new(-touching.x, -touching.y, 0.0))
            .with_rotation(rotation)
            .with_velocity(5.0 * DVec3::X, DVec3::ZERO)
            .with_material(friction, 0.0)
            .with_color(palette::RED)
    });
    scene.view = Some(ViewSpec::framing(DVec3::new(0.6, 0.4, 0.0), 1.2, DVec3::new(0.1, 0.15, 1.0)));
    scene
}
