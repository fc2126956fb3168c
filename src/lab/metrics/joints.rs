//! How far joints are from what they hold, and what they carry.

use std::collections::BTreeMap;

use bevy::math::DVec3;
use serde::Serialize;

use crate::lab::angle::wrapped;
use crate::lab::joined::{Joined, Relative, joined};
use crate::lab::simulation::Simulation;
use crate::physics::{BrokenJoint, DistanceLaw, JointAxis, JointCoordinate, JointForces, RigidBody};
use crate::scene::{JointKindSpec, JointSpec, LimitSpec, SceneSpec};

/// How far the rigid joints of a kind came from what they hold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct JointGap {
    /// Largest distance between two anchors along what is held of it; of a distance joint, from what it may be.
    pub gap_m: f64,
    /// Largest angle off the axes that are held; none of a kind that holds none.
    pub tilt_rad: Option<f64>,
}

/// How far joints went beyond their limits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct LimitOvershoot {
    /// Of angles; none where no joint has such limits.
    pub angle_rad: Option<f64>,
    /// Of lengths; none where no joint has such limits.
    pub length_m: Option<f64>,
}

/// What the joint that carried the most carried, a mean over a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct JointLoadMax {
    /// Norm of its force.
    pub force_n: f64,
    /// Norm of its torque about B's anchor, which may be another joint's.
    pub torque_n_m: f64,
}

/// What was seen of the joints of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct JointMetrics {
    pub gaps: BTreeMap<&'static str, JointGap>,
    /// None where no joint has limits.
    pub overshoot: Option<LimitOvershoot>,
    /// None without joints.
    pub load: Option<JointLoadMax>,
    /// How many are broken in the end.
    pub broken: u32,
    /// Largest separation over the limb's diameter.
    pub of_limb: f64,
}

/// Of the rigid joints that are asked for, the one that is farthest from what it holds now, by the names of its bodies, and
/// how far: as a share of the smaller bounding diameter of the bodies that it holds. What broke holds nothing.
pub fn widest_gap_of_limb(simulation: &Simulation, is_asked: impl Fn(&JointSpec) -> bool) -> Option<(String, f64)> {
    let (scene, states) = (simulation.scene(), simulation.sample().bodies);
    let asked = joined(scene).enumerate().filter(|(_, (joint, _))| is_asked(joint));
    let held = asked.filter_map(|(place, (joint, bodies))| {
        let watched = Watched::new(place, joint, bodies, scene);
        let is_broken = simulation.world().get::<BrokenJoint>(simulation.entities().joints[place]).is_some();
        let held = watched.held.filter(|_| !is_broken)?;
        let gap = held.gap(&watched.joined.relative(states)) / watched.diameter;
        Some((format!("the {} between '{}' and '{}'", watched.kind, joint.body_a, joint.body_b), gap))
    });
    held.max_by(|(_, a), (_, b)| a.total_cmp(b))
}

/// A joint as it is watched.
struct Watched {
    /// Its place in the scene.
    place: usize,
    joined: Joined,
    kind: &'static str,
    /// None of a spring.
    held: Option<Held>,
    limits: Option<(JointAxis, LimitSpec)>,
    /// Smaller bounding diameter of the bodies that have a shape, m.
    diameter: f64,
}

/// What a rigid joint holds.
#[derive(Clone, Copy)]
enum Held {
    /// Translations along A's axes, and the twist and the swings about y and z.
    Axes { translations: DVec3, rotations: [bool; 3] },
    /// The distance of the anchors.
    Distance { min: f64, max: f64 },
}

impl Held {
    /// None where the joint is a spring.
    fn of(joint: &JointSpec) -> Option<Self> {
        let axes = |translations: [bool; 3], rotations| {
            let translations = translations.map(|held| f64::from(u8::from(held))).into();
            Some(Self::Axes { translations, rotations })
        };
        match joint.kind {
            JointKindSpec::Ball if joint.softness.is_some() => None,
            JointKindSpec::Ball => axes([true; 3], [false; 3]),
            JointKindSpec::Hinge => axes([true; 3], [false, true, true]),
            JointKindSpec::Slider => axes([false, true, true], [true; 3]),
            JointKindSpec::Fixed => axes([true; 3], [true; 3]),
            JointKindSpec::Distance(DistanceLaw::Range { min, max }) => Some(Self::Distance { min, max }),
            JointKindSpec::Distance(DistanceLaw::Spring { .. }) => None,
            JointKindSpec::Generic { translations, rotations, .. } => axes(translations, rotations),
        }
    }

    /// How far the anchors are from where they may be, m.
    fn gap(self, relative: &Relative) -> f64 {
        match self {
            Self::Axes { translations, .. } => (translations * relative.apart).length(),
            Self::Distance { min, max } => {
                let distance = relative.apart.length();
                (min - distance).max(distance - max).max(0.0)
            }
        }
    }

    /// How far B's frame is turned off the axes of A's that are held, rad; none where none is.
    fn tilt(self, relative: &Relative) -> Option<f64> {
        let Self::Axes { rotations, .. } = self else { return None };
        if rotations == [true; 3] {
            return Some(relative.angle());
        }
        // A swing that is held alone is a right angle, which the other swing may be far from.
        let along = relative.turn * DVec3::X;
        let swing = match rotations[1..] {
            [true, true] => relative.swing(),
            [true, _] => along.z.clamp(-1.0, 1.0).asin(),
            [_, true] => along.y.clamp(-1.0, 1.0).asin(),
            _ => 0.0,
        };
        let twist = if rotations[0] { relative.twist() } else { 0.0 };
        rotations.contains(&true).then_some(twist.hypot(swing))
    }
}

/// Watches the joints of a run.
pub(super) struct JointMeter {
    joints: Vec<Watched>,
    seen: JointMetrics,
}

impl JointMeter {
    pub fn new(scene: &SceneSpec) -> Self {
        let joints = joined(scene).enumerate();
        let joints = joints.map(|(place, (joint, bodies))| Watched::new(place, joint, bodies, scene)).collect();
        Self { joints, seen: JointMetrics::default() }
    }

    /// Takes in the state after a step, and the forces that it found.
    pub fn observe(&mut self, simulation: &Simulation) {
        let (world, entities) = (simulation.world(), &simulation.entities().joints);
        let states = simulation.sample().bodies;
        let Self { joints, seen } = self;
        seen.broken = 0;
        for watched in joints {
            let entity = entities[watched.place];
            // What broke holds nothing any more.
            if world.get::<BrokenJoint>(entity).is_some() {
                seen.broken += 1;
                continue;
            }
            let turned = world.get::<JointCoordinate>(entity).map_or(0.0, |coordinate| coordinate.value);
            watched.observe(&watched.joined.relative(states), turned, seen);
        }
        for joint in &world.resource::<JointForces>().0 {
            let load = seen.load.get_or_insert_default();
            load.force_n = load.force_n.max(joint.force.length());
            load.torque_n_m = load.torque_n_m.max(joint.torque.length());
        }
    }

    /// What was seen.
    pub fn finish(self) -> JointMetrics {
        self.seen
    }
}

impl Watched {
    fn new(place: usize, joint: &JointSpec, bodies: [usize; 2], scene: &SceneSpec) -> Self {
        let diameter = |body: usize| {
            let body = &scene.bodies[body];
            let shape = body.shape.as_ref().filter(|_| body.kind == RigidBody::Dynamic);
            shape.map_or(f64::INFINITY, |shape| 2.0 * shape.bounding_radius())
        };
        let (kind, axis) = match joint.kind {
            JointKindSpec::Ball => ("ball", Some(JointAxis::Twist)),
            JointKindSpec::Hinge => ("hinge", Some(JointAxis::Twist)),
            JointKindSpec::Slider => ("slider", Some(JointAxis::X)),
            JointKindSpec::Fixed => ("fixed", None),
            JointKindSpec::Distance(_) => ("distance", Some(JointAxis::Distance)),
            JointKindSpec::Generic { axis, .. } => ("generic", axis),
        };
        Self {
            place,
            joined: Joined::of(joint, bodies, scene),
            kind,
            held: Held::of(joint),
            limits: axis.zip(joint.limits),
            diameter: diameter(bodies[0]).min(diameter(bodies[1])),
        }
    }

    /// For a joint whose angle over all turns is near `turned`, rad.
    fn observe(&self, relative: &Relative, turned: f64, seen: &mut JointMetrics) {
        if let Some(held) = self.held {
            let (gap, tilt) = (held.gap(relative), held.tilt(relative));
            seen.of_limb = seen.of_limb.max(gap / self.diameter);
            let largest = seen.gaps.entry(self.kind).or_default();
            largest.gap_m = largest.gap_m.max(gap);
            largest.tilt_rad = larger(largest.tilt_rad, tilt);
        }
        if let Some((axis, limits)) = self.limits {
            let mut coordinate = relative.coordinate(axis);
            if axis == JointAxis::Twist {
                coordinate = turned + wrapped(coordinate - turned);
            }
            let of_swing = limits.swing.map_or(0.0, |most| relative.swing() - most);
            let beyond = Some(limits.beyond(coordinate).max(of_swing).max(0.0));
            let largest = seen.overshoot.get_or_insert_default();
            let largest = if axis.is_angle() { &mut largest.angle_rad } else { &mut largest.length_m };
            *largest = larger(*largest, beyond);
        }
    }
}

fn larger(one: Option<f64>, other: Option<f64>) -> Option<f64> {
    one.into_iter().chain(other).reduce(f64::max)
}
