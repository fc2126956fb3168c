//! Each engine's joints are those of the scene: they hold what these hold, end where their limits are, and turn the right
//! way.

use ::plumb::physics::{JointAxes, JointMotor, MotorTarget};
use ::plumb::scene::{BodySpec, JointKindSpec, JointSpec, SceneSpec, ShapeSpec};
use bevy::math::{DQuat, DVec3};

use super::*;

const SETTINGS: Settings = Settings { hz: 60.0, substeps: None, threads: 1, sleep: false };

/// Leans against all axes, so that a frame that is laid wrong shows.
const AXIS: DVec3 = DVec3::new(0.6, 0.0, 0.8);

/// The 2009 engine has joints that only pull back what they let go.
fn with_joints() -> impl Iterator<Item = EngineKind> {
    EngineKind::all().into_iter().filter(|kind| kind.to_string() != "plumb:classic")
}

/// A rod of 1 m and 1 kg along +x from a pivot at the origin, on a joint there.
fn rod_on(gravity: DVec3, join: impl Fn(&BodySpec, &BodySpec) -> JointSpec) -> Scene {
    let mut spec = SceneSpec::new("rod", gravity);
    // Turned, so that frames in body axes are not those of the world.
    let turned = DQuat::from_rotation_y(0.5);
    let pivot = BodySpec::pin("pivot", DVec3::ZERO).with_rotation(turned);
    let shape = ShapeSpec::Cuboid { size: DVec3::new(1.0, 0.1, 0.1) };
    let rod = BodySpec::new("rod", shape, 0.5 * DVec3::X).with_mass(1.0).without_collision();
    spec.joints.push(join(&pivot, &rod));
    spec.bodies.extend([pivot, rod]);
    Scene::of(spec)
}

/// Watches the states after each step.
fn watch(kind: EngineKind, scene: &Scene, seconds: f64, mut see: impl FnMut(f64, &[BodyState])) {
    let mut run = kind.start(scene, &SETTINGS).unwrap();
    for _ in 0..(seconds * SETTINGS.hz).round() as u32 {
        run.step().unwrap();
        let time = run.time();
        see(time, run.read().unwrap());
    }
}

fn angle(scene: &Scene, states: &[BodyState]) -> f64 {
    scene.joints[0].coordinate(&states[0], &states[1], 0.0)
}

#[test]
fn a_hinge_holds_its_point_and_its_axis() {
    // Half of the weight pulls along the axis.
    let scene = rod_on(-10.0 * (AXIS + DVec3::Y), |pivot, rod| JointSpec::hinge(pivot, rod, DVec3::ZERO, AXIS));
    let at_start = AXIS;
    for kind in with_joints() {
        let (mut gap, mut tilt, mut swing) = (0.0f64, 0.0f64, 0.0f64);
        watch(kind, &scene, 2.0, |_, states| {
            gap = gap.max(scene.joints[0].separation(states));
            tilt = tilt.max((states[1].rotation * AXIS).angle_between(at_start));
            swing = swing.max(angle(&scene, states).abs());
        });
        // Soft joints sag: a tenth of a radian is a hinge, a ball joint would let it hang.
        assert!(gap < 0.02 && tilt < 0.1, "{kind}: {gap} m, {tilt} rad");
        assert!(swing > 1.0, "{kind}: turns by {swing} rad at most");
    }
}

#[test]
fn a_limit_stops_a_hinge_on_both_sides() {
    for side in [1.0, -1.0] {
        // Falls to one side and stays at that end.
        let join = |pivot: &BodySpec, rod: &BodySpec| {
            JointSpec::hinge(pivot, rod, DVec3::ZERO, DVec3::Z).with_range(-0.7, 0.4)
        };
        let scene = rod_on(side * 10.0 * DVec3::Y, join);
        let end = if side > 0.0 { 0.4 } else { -0.7 };
        for kind in with_joints() {
            let (mut furthest, mut last) = (0.0f64, 0.0);
            watch(kind, &scene, 2.0, |_, states| {
                last = angle(&scene, states);
                furthest = furthest.max(side * last);
            });
            assert!((last - end).abs() < 0.05, "{kind}: {last} at the end, not {end} rad");
            assert!(furthest < end.abs() + 0.1, "{kind}: {furthest} rad, limit {end}");
        }
    }
}

#[test]
fn limits_stop_the_swing_and_the_twist_of_a_ball_joint() {
    let swing_limit = 0.5;
    let join = |pivot: &BodySpec, rod: &BodySpec| {
        JointSpec::at(pivot, rod, DVec3::ZERO).with_swing_twist(swing_limit, [-0.3, 0.3], DVec3::X)
    };
    // Falls off the axis.
    let falling = rod_on(-10.0 * DVec3::Y, join);
    // Spins about it.
    let mut spinning = rod_on(DVec3::ZERO, join).spec;
    spinning.bodies[1].angular_velocity = 2.0 * DVec3::X;
    let spinning = Scene::of(spinning);
    for kind in with_joints() {
        let (mut swing, mut last, mut twist) = (0.0f64, 0.0, 0.0f64);
        watch(kind, &falling, 2.0, |_, states| {
            last = (states[1].rotation * DVec3::X).angle_between(DVec3::X);
            swing = swing.max(last);
        });
        assert!(
            swing < swing_limit + 0.1 && (last - swing_limit).abs() < 0.05,
            "{kind}: swings to {swing}, {last} rad"
        );
        watch(kind, &spinning, 1.0, |_, states| twist = twist.max(angle(&spinning, states).abs()));
        assert!((0.2..0.4).contains(&twist), "{kind}: twists by {twist} rad");
    }
}

#[test]
fn a_fixed_joint_holds_all_and_a_slider_all_but_one_distance() {
    let fixed =
        rod_on(-10.0 * DVec3::Y, |pivot, rod| JointSpec::of_kind(JointKindSpec::Fixed, pivot, rod, DVec3::ZERO));
    let slider = rod_on(-10.0 * DVec3::Y, |pivot, rod| {
        JointSpec::of_kind(JointKindSpec::Slider, pivot, rod, DVec3::ZERO).with_axis(DVec3::new(0.0, 0.8, 0.6))
    });
    for kind in with_joints() {
        let mut turned = 0.0f64;
        watch(kind, &fixed, 1.0, |_, states| turned = turned.max(states[1].rotation.angle_between(DQuat::IDENTITY)));
        assert!(turned < 0.1, "{kind}: {turned} rad");
        let (mut last, mut gap) = (0.0, 0.0f64);
        watch(kind, &slider, 0.5, |_, states| {
            last = angle(&slider, states);
            gap = gap.max(slider.joints[0].separation(states));
            turned = turned.max(states[1].rotation.angle_between(DQuat::IDENTITY));
        });
        // ½ g t² of its share along the axis; whole steps are up to ½ g t h more.
        assert!((last + 0.5 * 8.0 * 0.25).abs() < 0.05, "{kind}: {last} m");
        assert!(gap < 0.02 && turned < 0.1, "{kind}: {gap} m, {turned} rad");
    }
}

#[test]
fn a_rope_ends_a_fall() {
    let join = |pivot: &BodySpec, rod: &BodySpec| {
        let length = ::plumb::physics::DistanceLaw::Range { min: 0.0, max: 1.0 };
        JointSpec {
            anchor_b: DVec3::ZERO,
            ..JointSpec::of_kind(JointKindSpec::Distance(length), pivot, rod, DVec3::ZERO)
        }
    };
    let scene = rod_on(-10.0 * DVec3::Y, join);
    for kind in with_joints() {
        let mut furthest = 0.0f64;
        watch(kind, &scene, 1.0, |_, states| furthest = furthest.max(states[1].position.length()));
        assert!((0.95..1.05).contains(&furthest), "{kind}: {furthest} m");
    }
}

#[test]
fn a_motor_turns_the_right_way_at_its_speed_and_no_stronger_than_it_may() {
    let driven = |motor: JointMotor| {
        move |pivot: &BodySpec, rod: &BodySpec| JointSpec::hinge(pivot, rod, DVec3::ZERO, AXIS).with_motor(motor)
    };
    let strong = rod_on(DVec3::ZERO, driven(JointMotor::new(MotorTarget::Speed(1.5))));
    // ⅓ kg·m² about its end, across; the axis leans by 53° against the rod.
    let weak = rod_on(DVec3::ZERO, driven(JointMotor::new(MotorTarget::Speed(100.0)).with_max_force(0.2)));
    let lever = AXIS.cross(DVec3::X).length_squared();
    let inertia = (1.01 / 12.0 + 0.25) * lever + 0.02 / 12.0 * (1.0 - lever);
    for kind in with_joints() {
        let (mut speed, mut turned) = (0.0, 0.0);
        watch(kind, &strong, 0.5, |_, states| {
            speed = states[1].angular.dot(AXIS);
            turned = angle(&strong, states);
        });
        // Some take a few steps until they have that speed. Avian's shakes without a largest torque: its hinge leans
        // against the rod's axes.
        let gets_there = (speed - 1.5).abs() < 0.05 && (0.5..0.8).contains(&turned);
        assert!(gets_there || kind == EngineKind::Avian, "{kind}: {speed} rad/s, {turned} rad");
        watch(kind, &weak, 0.5, |_, states| speed = states[1].angular.dot(AXIS));
        let should = 0.5 * 0.2 / inertia;
        assert!((speed / should - 1.0).abs() < 0.1, "{kind}: {speed}, not {should} rad/s");
    }
}

#[test]
fn a_motor_follows_a_motion_and_a_spring_swings_at_its_frequency() {
    let arm = Scene::parse("arm").unwrap();
    let servo = Scene::parse("servo f=1 zeta=0").unwrap();
    for kind in with_joints() {
        let mut off = 0.0f64;
        watch(kind, &arm, 1.0, |time, states| {
            for joint in &arm.joints {
                let Some(Motor { drive: Drive::Motion(motion), .. }) = joint.motor else { panic!("{joint:?}") };
                let [should, ..] = motion.at_time(time);
                off = off.max((joint.coordinate(&states[joint.a], &states[joint.b], should) - should).abs());
            }
        });
        // A step at their fastest, 2.8 rad/s, is 0.05 rad.
        assert!(off < 0.1, "{kind}: {off} rad");
        // Undamped, it is at twice its target after half a period, but for what its integrator damps.
        let mut most = (0.0, 0.0);
        watch(kind, &servo, 0.8, |time, states| {
            let angle = angle(&servo, states);
            if angle > most.1 {
                most = (time, angle);
            }
        });
        if kind != EngineKind::Avian {
            assert!((most.0 - 0.5f64).abs() < 0.05 && (1.5..2.1).contains(&most.1), "{kind}: {most:?}");
        }
    }
}

#[test]
fn what_an_engine_lacks_is_said() {
    let generic = JointKindSpec::Generic { translations: [true; 3], rotations: [true, false, true], axis: None };
    let universal = rod_on(DVec3::ZERO, |pivot, rod| JointSpec {
        axes: JointAxes::World(AXIS),
        ..JointSpec::of_kind(generic, pivot, rod, DVec3::ZERO)
    });
    for kind in EngineKind::all().into_iter().filter(|kind| !kind.is_plumb()) {
        let refusal = kind.start(&universal, &SETTINGS).err();
        let should = (kind != EngineKind::Rapier).then_some(Unable::NotTranslated("generic joints"));
        assert_eq!(refusal, should, "{kind}");
        let refusal = kind.start(&Scene::parse("tower 2").unwrap(), &SETTINGS).err();
        assert_eq!(refusal, Some(Unable::NotTranslated("joints that break")), "{kind}");
        assert!(kind.start(&Scene::parse("bridge 3").unwrap(), &SETTINGS).is_ok(), "{kind}");
    }
}
