//! Andrews' squeezer: `andrews`, a plane mechanism of seven bodies (Schiehlen 1990; Hairer and Wanner, Solving Ordinary
//! Differential Equations II, VII.7, whose symbols these are). SI. Nothing collides.

use bevy::math::{DQuat, DVec2, DVec3};

use super::palette;
use crate::physics::DistanceLaw;
use crate::scene::{BodySpec, JointKindSpec, JointSpec, SceneInfo, SceneSpec, ShapeSpec, Subject, ViewSpec};

pub(super) const ANDREWS: SceneInfo = SceneInfo {
    name: "andrews",
    title: "Andrews' squeezer",
    subject: Subject::Machines,
    about: "seven plane bodies of some cm on ten hinges, a spring, a torque on the crank, no \
            collision",
    truth: "published angles at 0.03 s",
    parameters: &[],
    seconds: 0.03,
    bodies: |_| 8.0,
    build: |_| build(),
};

/// Fixed points.
const A: DVec2 = DVec2::new(-0.06934, -0.00227);
const B: DVec2 = DVec2::new(-0.03635, 0.03273);
const C: DVec2 = DVec2::new(0.014, 0.072);

// Angles at the start, rad.
const BETA: f64 = -0.0617138900142764;
const THETA: f64 = 0.0;
const GAMMA: f64 = 0.4552798191630704;
const PHI: f64 = 0.2226683901658859;
const DELTA: f64 = 0.4873649795438426;
const OMEGA: f64 = -0.2226683901658859;
const EPSILON: f64 = 1.230547444549821;

// Lengths, m.
const D: f64 = 0.028;
const DA: f64 = 0.0115;
const E: f64 = 0.02;
const EA: f64 = 0.01421;
const RR: f64 = 0.007;
const RA: f64 = 0.00092;
const SA: f64 = 0.01874;
const SB: f64 = 0.01043;
const SC: f64 = 0.018;
const SD: f64 = 0.02;
const TA: f64 = 0.02308;
const TB: f64 = 0.00916;
const U: f64 = 0.04;
const UA: f64 = 0.01228;
const UB: f64 = 0.00449;
const ZF: f64 = 0.02;
const ZT: f64 = 0.04;
const FA: f64 = 0.01421;

const SPRING: DistanceLaw = DistanceLaw::Spring { rest: 0.07785, stiffness: 4530.0, damping: 0.0 };
/// Of the torque on the crank, N·m.
const DRIVE: f64 = 0.033;

/// (cos a, sin a).
fn along(angle: f64) -> DVec2 {
    DVec2::from_angle(angle)
}

/// (sin a, −cos a).
fn right_of(angle: f64) -> DVec2 {
    -along(angle).perp()
}

/// Mass, kg, inertia about z, kg·m², centre, m, orientation, rad, and size of the picture, m, of each body, in the order
/// of the publication.
fn bodies() -> [(f64, f64, DVec2, f64, DVec2); 7] {
    let crank_end = RR * along(BETA);
    let knee = A + ZT * along(DELTA);
    let other_knee = A + U * right_of(EPSILON);
    let bar = |length: f64| DVec2::new(length, 0.004);
    [
        (0.04325, 2.194e-6, RA * along(BETA), BETA, bar(0.016)),
        (0.00365, 4.410e-7, crank_end - DA * along(BETA + THETA), BETA + THETA, bar(D)),
        (0.02373, 5.255e-6, B + SA * right_of(GAMMA) + SB * along(GAMMA), GAMMA, DVec2::new(0.03, 0.03)),
        (0.00706, 5.667e-7, knee + (E - EA) * right_of(PHI + DELTA), PHI + DELTA, DVec2::new(0.004, E)),
        (0.07050, 1.169e-5, A + TA * along(DELTA) + TB * along(DELTA).perp(), DELTA, bar(ZT)),
        (0.00706, 5.667e-7, other_knee + (ZF - FA) * along(OMEGA + EPSILON), OMEGA + EPSILON, bar(ZF)),
        (0.05498, 1.912e-5, A + UA * right_of(EPSILON) - UB * along(EPSILON), EPSILON, DVec2::new(0.004, U)),
    ]
}

fn build() -> SceneSpec {
    let mut scene = SceneSpec::new("andrews", DVec3::ZERO);
    scene.bodies.push(BodySpec::pin("ground", DVec3::ZERO));
    for (i, (mass, inertia, centre, angle, size)) in bodies().into_iter().enumerate() {
        let shape = ShapeSpec::Cuboid { size: size.extend(0.003) };
        let body = BodySpec::new(format!("body {}", i + 1), shape, centre.extend(0.0))
            .with_mass(mass)
            .with_rotation(DQuat::from_rotation_z(angle))
            .without_collision()
            .with_color(palette::bright(i));
        // Those about x and y do nothing in the plane.
        let moments = DVec3::new(0.5 * inertia, 0.5 * inertia, inertia);
        scene.bodies.push(BodySpec { inertia: Some(moments), ..body });
    }
    scene.bodies[1].torque = DRIVE * DVec3::Z;
    let meeting = RR * along(BETA) - D * along(BETA + THETA);
    let hinges = [
        (0, 1, DVec2::ZERO),
        (1, 2, RR * along(BETA)),
        (0, 3, B),
        (0, 5, A),
        (0, 7, A),
        (4, 5, A + ZT * along(DELTA)),
        (6, 7, A + U * right_of(EPSILON)),
        (2, 3, meeting),
        (3, 4, meeting),
        (3, 6, meeting),
    ];
    let bodies = &scene.bodies;
    let hinge = |(a, b, at): (usize, usize, DVec2)| JointSpec::hinge(&bodies[a], &bodies[b], at.extend(0.0), DVec3::Z);
    scene.joints = hinges.into_iter().map(hinge).collect();
    let hook = B + SC * right_of(GAMMA) + SD * along(GAMMA);
    let (ground, lever) = (&bodies[0], &bodies[3]);
    scene.joints.push(JointSpec {
        kind: JointKindSpec::Distance(SPRING),
        ..JointSpec::new(ground, ground.anchor(C.extend(0.0)), lever, lever.anchor(hook.extend(0.0)))
    });
    scene.view = Some(ViewSpec::framing(DVec3::new(-0.03, 0.02, 0.0), 0.08, DVec3::new(0.0, 0.2, 1.0)));
    scene
}
