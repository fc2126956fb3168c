//! What a probe reads in the world as it is, and what it is called.

use bevy::ecs::system::SystemParam;
use bevy::math::DVec3;
use bevy::prelude::*;

use crate::physics::{
    Bodies, ContactForces, Diagnostics, Gravity, GravityScale, Inertia, Joints, Mass, Position, RigidBody, Rotation,
    StepStats, Velocity,
};
use crate::sandbox::any_joint::{IsJoint, WholeJoint, WholeJointItem, noun};
use crate::sandbox::panel::name_of;
use crate::scene::{Probe, ProbePlot, ProbePoint, ProbeSubject};

/// A probe of the running scene.
pub type Watched = Probe<Entity, Entity>;
/// What such a one plots something of.
pub type WatchedSubject = ProbeSubject<Entity, Entity>;
/// A point of the running scene.
pub type WatchedPoint = ProbePoint<Entity>;

/// All that probes read.
#[derive(SystemParam)]
pub struct Reader<'w, 's> {
    bodies: Query<
        'w,
        's,
        (
            &'static RigidBody,
            &'static Position,
            &'static Rotation,
            &'static Velocity,
            Option<&'static Mass>,
            Option<&'static Inertia>,
            Option<&'static GravityScale>,
        ),
    >,
    joints: Query<'w, 's, WholeJoint, IsJoint>,
    names: Query<'w, 's, &'static Name>,
    packed: (Res<'w, Bodies>, Res<'w, Joints>),
    stats: Res<'w, StepStats>,
    gravity: Res<'w, Gravity>,
    diagnostics: Option<Res<'w, Diagnostics>>,
    forces: Option<Res<'w, ContactForces>>,
}

impl Reader<'_, '_> {
    /// The steps that the world has made, and its time, s.
    pub fn now(&self) -> (u64, f64) {
        (self.stats.steps, self.stats.time)
    }

    /// Whether what it is of is there.
    pub fn is_there(&self, probe: &Watched) -> bool {
        let is_point = |point: &WatchedPoint| point.body.is_none_or(|body| self.bodies.contains(body));
        match probe {
            Probe::Plot(ProbeSubject::Scene, _) => true,
            Probe::Plot(ProbeSubject::Joint(joint), _) => self.joints.contains(*joint),
            Probe::Plot(ProbeSubject::Point(point), _) | Probe::Trail(point) => is_point(point),
            Probe::Tape(ends) => ends.iter().all(is_point),
        }
    }

    /// What it reads; not a number where nothing is known.
    pub fn value(&self, probe: &Watched) -> f64 {
        let value = match probe {
            Probe::Plot(ProbeSubject::Scene, plot) => self.of_scene(*plot),
            Probe::Plot(ProbeSubject::Joint(joint), plot) => self.of_joint(*joint, *plot),
            Probe::Plot(ProbeSubject::Point(point), plot) => self.of_point(point, *plot),
            Probe::Tape([from, to]) => self.place(from).zip(self.place(to)).map(|(from, to)| from.distance(to)),
            Probe::Trail(_) => None,
        };
        value.unwrap_or(f64::NAN)
    }

    /// What the list says of it: as [`Self::value`], but what a step alone tells is as that told it, not a number before.
    pub fn told(&self, probe: &Watched, by_last_step: Option<f64>) -> f64 {
        match probe {
            Probe::Plot(ProbeSubject::Scene, _) => by_last_step.unwrap_or(f64::NAN),
            Probe::Plot(_, plot) if plot.is_contact_force() => by_last_step.unwrap_or(f64::NAN),
            _ => self.value(probe),
        }
    }

    /// Where a point is, world, m.
    pub fn place(&self, point: &WatchedPoint) -> Option<DVec3> {
        let Some(body) = point.body else { return Some(point.at) };
        let (_, position, rotation, ..) = self.bodies.get(body).ok()?;
        Some(position.0 + rotation.0 * point.at)
    }

    fn of_point(&self, point: &WatchedPoint, plot: ProbePlot) -> Option<f64> {
        let body = point.body?;
        if plot.is_contact_force() {
            return self.contact_force(body, plot);
        }
        let (kind, position, rotation, velocity, mass, inertia, scale) = self.bodies.get(body).ok()?;
        let arm = rotation.0 * point.at;
        let (place, velocity_there) = (position.0 + arm, velocity.linear + velocity.angular.cross(arm));
        let kinetic = || {
            let (mass, inertia) = mass.zip(inertia).filter(|_| *kind == RigidBody::Dynamic)?;
            let spin = rotation.0.inverse() * velocity.angular;
            Some(0.5 * (mass.0 * velocity.linear.length_squared() + (inertia.0 * spin).dot(spin)))
        };
        let potential = || {
            let mass = mass.filter(|_| *kind == RigidBody::Dynamic)?;
            Some(-mass.0 * scale.map_or(1.0, |scale| scale.0) * self.gravity.0.dot(position.0))
        };
        match plot {
            ProbePlot::X => Some(place.x),
            ProbePlot::Y => Some(place.y),
            ProbePlot::Z => Some(place.z),
            ProbePlot::VelocityX => Some(velocity_there.x),
            ProbePlot::VelocityY => Some(velocity_there.y),
            ProbePlot::VelocityZ => Some(velocity_there.z),
            ProbePlot::Speed => Some(velocity_there.length()),
            ProbePlot::Spin => Some(velocity.angular.length()),
            ProbePlot::KineticEnergy => kinetic(),
            ProbePlot::PotentialEnergy => potential(),
            ProbePlot::Energy => Some(kinetic()? + potential()?),
            _ => None,
        }
    }

    /// In the last step.
    fn contact_force(&self, body: Entity, plot: ProbePlot) -> Option<f64> {
        let on_body = self.forces.as_ref()?.0.iter().map(|contact| match body {
            body if body == contact.b => contact.force,
            body if body == contact.a => -contact.force,
            _ => DVec3::ZERO,
        });
        let sum: DVec3 = on_body.sum();
        Some(match plot {
            ProbePlot::ContactForceX => sum.x,
            ProbePlot::ContactForceY => sum.y,
            ProbePlot::ContactForceZ => sum.z,
            _ => sum.length(),
        })
    }

    fn of_joint(&self, entity: Entity, plot: ProbePlot) -> Option<f64> {
        let joint = self.joints.get(entity).ok()?;
        match plot {
            ProbePlot::Force => Some(joint.known_load(&self.stats)?.force.length()),
            ProbePlot::Torque => Some(joint.known_load(&self.stats)?.torque.length()),
            ProbePlot::Coordinate => {
                let value = self.coordinate(&joint)?;
                Some(if is_angle(&joint) { value.to_degrees() } else { value })
            }
            ProbePlot::Gap => self.gap(entity),
            _ => None,
        }
    }

    fn coordinate(&self, joint: &WholeJointItem) -> Option<f64> {
        let ends = self.bodies.get_many(joint.joint.component()?.bodies()).ok()?;
        joint.value(ends.map(|(_, position, rotation, ..)| (position.0, rotation.0)))
    }

    /// After the last step; 0 of what is broken.
    fn gap(&self, entity: Entity) -> Option<f64> {
        let (bodies, joints) = &self.packed;
        let pieces = joints.list.iter().filter(|joint| joint.entity == entity);
        let separations = pieces.filter_map(|joint| {
            let ends = [bodies.list.get(joint.a as usize)?, bodies.list.get(joint.b as usize)?];
            Some(joint.definition.separation(ends, self.stats.time))
        });
        Some(separations.fold(0.0, f64::max))
    }

    fn of_scene(&self, plot: ProbePlot) -> Option<f64> {
        let stats = &self.stats;
        let count = match plot {
            ProbePlot::Pairs => stats.pairs.into(),
            ProbePlot::Touching => stats.manifolds.into(),
            ProbePlot::Contacts => stats.contact_points.into(),
            ProbePlot::Rows => stats.rows.into(),
            ProbePlot::RowUpdates => stats.row_updates as f64,
            ProbePlot::Islands => stats.islands.into(),
            ProbePlot::AtRest => stats.resting.into(),
            ProbePlot::Asleep => stats.sleeping.into(),
            ProbePlot::StepTime => stats.step_seconds,
            _ => return self.measured(plot),
        };
        Some(count)
    }

    fn measured(&self, plot: ProbePlot) -> Option<f64> {
        let diagnostics = self.diagnostics.as_ref()?;
        match plot {
            ProbePlot::KineticEnergy => Some(diagnostics.kinetic_energy),
            ProbePlot::PotentialEnergy => Some(diagnostics.potential_energy),
            ProbePlot::Energy => Some(diagnostics.energy()),
            ProbePlot::Gap => Some(diagnostics.joint_error),
            ProbePlot::Overlap => Some(diagnostics.penetration),
            _ => None,
        }
    }

    /// Of its values.
    pub fn unit(&self, probe: &Watched) -> &'static str {
        match probe {
            Probe::Plot(ProbeSubject::Joint(joint), ProbePlot::Coordinate)
                if self.joints.get(*joint).is_ok_and(|joint| is_angle(&joint)) =>
            {
                "°"
            }
            Probe::Plot(_, plot) => plot.unit(),
            Probe::Trail(_) | Probe::Tape(_) => "m",
        }
    }

    /// What it is called.
    pub fn name(&self, probe: &Watched) -> String {
        match probe {
            Probe::Plot(ProbeSubject::Scene, plot) => format!("scene {}", plot.label()),
            Probe::Plot(ProbeSubject::Joint(joint), plot) => format!("{} {}", self.name_of_joint(*joint), plot.label()),
            Probe::Plot(ProbeSubject::Point(point), plot) => format!("{} {}", self.name_of_point(point), plot.label()),
            Probe::Trail(point) => format!("{} trail", self.name_of_point(point)),
            Probe::Tape([from, to]) => format!("{} to {}", self.name_of_point(from), self.name_of_point(to)),
        }
    }

    /// What a body is called.
    pub fn name_of_body(&self, body: Entity) -> String {
        name_of(self.names.get(body).ok(), body)
    }

    /// What a joint is called; nothing where it is gone.
    pub fn name_of_joint(&self, joint: Entity) -> String {
        let Some(component) = self.joints.get(joint).ok().and_then(|joint| joint.joint.component()) else {
            return String::new();
        };
        let [a, b] = component.bodies().map(|body| self.name_of_body(body));
        format!("{} of {a} and {b}", noun(&component))
    }

    fn name_of_point(&self, point: &WatchedPoint) -> String {
        match point.body {
            Some(body) if point.at == DVec3::ZERO => self.name_of_body(body),
            Some(body) => format!("{} {}", self.name_of_body(body), coordinates(point.at)),
            None => format!("world {}", coordinates(point.at)),
        }
    }

    /// Whether a joint is there that has a coordinate, and whether that is an angle.
    pub fn axis_of(&self, joint: Entity) -> Option<bool> {
        let joint = self.joints.get(joint).ok()?;
        joint.axis().map(|axis| axis.is_angle())
    }
}

fn is_angle(joint: &WholeJointItem) -> bool {
    joint.axis().is_some_and(|axis| axis.is_angle())
}

/// To the centimetre.
pub fn coordinates(at: DVec3) -> String {
    let [x, y, z] = at.to_array().map(|x| ((x * 100.0).round() + 0.0) / 100.0);
    format!("({x} {y} {z})")
}
