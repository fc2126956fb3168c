//! What is watched while a scene runs: quantities that are plotted, trails of points, tapes between two.

use std::collections::HashMap;

use bevy::math::DVec3;
use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::BodySpec;
use super::joint::in_principal_axes;

/// Most probes that a scene may have.
pub const MAX_PROBES: usize = 100;

/// Something that is watched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Probe<Body, Joint> {
    /// A quantity, plotted against time.
    Plot(ProbeSubject<Body, Joint>, ProbePlot),
    /// The way that a point went in the last seconds.
    Trail(ProbePoint<Body>),
    /// The distance of two points.
    Tape([ProbePoint<Body>; 2]),
}

/// As data: bodies by their names, joints by their places in [`SceneSpec::joints`](super::SceneSpec::joints).
pub type ProbeSpec = Probe<String, usize>;

/// The probes of the running scene, by entities. Those whose body or joint is gone stay: it may come back.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct Probes(pub Vec<Probe<Entity, Entity>>);

/// What a quantity is of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ProbeSubject<Body, Joint> {
    /// A point of a body, or a body: then the point does not matter.
    Point(ProbePoint<Body>),
    /// A joint.
    Joint(Joint),
    /// All of the scene.
    Scene,
}

/// A point that goes along with a body, or a point of the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbePoint<Body> {
    /// None: the world.
    pub body: Option<Body>,
    /// From the centre of mass, m: in the axes of [`BodySpec::rotation`], of an entity in its principal axes. Of the world:
    /// where it is.
    pub at: DVec3,
}

/// A quantity that can be plotted.
#[derive(Serialize, Deserialize, Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProbePlot {
    /// Of a point, world, m.
    X,
    /// Of a point, world, m.
    Y,
    /// Of a point, world, m.
    Z,
    /// Of a point, m/s.
    VelocityX,
    /// Of a point, m/s.
    VelocityY,
    /// Of a point, m/s.
    VelocityZ,
    /// Of a point, m/s.
    Speed,
    /// Of a body: |ω|, rad/s.
    Spin,
    /// Of a body or of the scene, J.
    KineticEnergy,
    /// Of a body or of the scene in its gravity, 0 at the world's origin, J.
    PotentialEnergy,
    /// Their sum, J.
    Energy,
    /// Sum of all contact forces on a body, N.
    ContactForceX,
    /// Sum of all contact forces on a body, N.
    ContactForceY,
    /// Sum of all contact forces on a body, N.
    ContactForceZ,
    /// The norm of that sum, N.
    ContactForce,
    /// That a joint carries, N.
    Force,
    /// That a joint carries, N·m.
    Torque,
    /// Where a joint stands along its axis, m or °.
    Coordinate,
    /// By how far what a joint holds is apart, of the scene the largest, m.
    Gap,
    /// Of the scene: the largest depth of a contact, m.
    Overlap,
    /// Of the scene: wall-clock time of a step, s.
    StepTime,
    /// Of the scene: that the broad phase handed on.
    Pairs,
    /// Of the scene: pairs that touch.
    Touching,
    /// Of the scene: contact points.
    Contacts,
    /// Of the scene: scalar constraints solved in one substep.
    Rows,
    /// Of the scene: rows × iterations × solves.
    RowUpdates,
    /// Of the scene: groups of awake bodies that touch or are joined.
    Islands,
    /// Of the scene: awake bodies of islands at rest.
    AtRest,
    /// Of the scene: bodies that sleep.
    Asleep,
}

impl ProbePlot {
    /// What it is called beside what it is of.
    pub fn label(self) -> &'static str {
        match self {
            Self::X => "x",
            Self::Y => "y",
            Self::Z => "z",
            Self::VelocityX => "vx",
            Self::VelocityY => "vy",
            Self::VelocityZ => "vz",
            Self::Speed => "speed",
            Self::Spin => "spin",
            Self::KineticEnergy => "kinetic",
            Self::PotentialEnergy => "potential",
            Self::Energy => "energy",
            Self::ContactForceX => "Fx",
            Self::ContactForceY => "Fy",
            Self::ContactForceZ => "Fz",
            Self::ContactForce => "contact force",
            Self::Force => "force",
            Self::Torque => "torque",
            Self::Coordinate => "coordinate",
            Self::Gap => "gap",
            Self::Overlap => "overlap",
            Self::StepTime => "step time",
            Self::Pairs => "pairs",
            Self::Touching => "touching",
            Self::Contacts => "contacts",
            Self::Rows => "rows",
            Self::RowUpdates => "row updates",
            Self::Islands => "islands",
            Self::AtRest => "at rest",
            Self::Asleep => "asleep",
        }
    }

    /// Of its values; of a coordinate that of one along a line.
    pub fn unit(self) -> &'static str {
        match self {
            Self::X | Self::Y | Self::Z | Self::Coordinate | Self::Gap | Self::Overlap => "m",
            Self::VelocityX | Self::VelocityY | Self::VelocityZ | Self::Speed => "m/s",
            Self::Spin => "rad/s",
            Self::KineticEnergy | Self::PotentialEnergy | Self::Energy => "J",
            Self::ContactForceX | Self::ContactForceY | Self::ContactForceZ | Self::ContactForce | Self::Force => "N",
            Self::Torque => "N·m",
            Self::StepTime => "s",
            _ => "",
        }
    }

    /// Whether that has it.
    pub fn is_of<Body, Joint>(self, subject: &ProbeSubject<Body, Joint>) -> bool {
        let is_energy = matches!(self, Self::KineticEnergy | Self::PotentialEnergy | Self::Energy);
        let is_of_joint = matches!(self, Self::Force | Self::Torque | Self::Coordinate | Self::Gap);
        let is_of_body = is_energy || self.is_contact_force() || matches!(self.unit(), "m/s" | "rad/s");
        match subject {
            ProbeSubject::Point(point) => {
                point.body.is_some() && (is_of_body || matches!(self, Self::X | Self::Y | Self::Z))
            }
            ProbeSubject::Joint(_) => is_of_joint,
            ProbeSubject::Scene => {
                is_energy || matches!(self, Self::Gap | Self::Overlap | Self::StepTime) || self.unit().is_empty()
            }
        }
    }

    /// Whether contacts make it.
    pub fn is_contact_force(self) -> bool {
        matches!(self, Self::ContactForceX | Self::ContactForceY | Self::ContactForceZ | Self::ContactForce)
    }
}

impl<Body> ProbePoint<Body> {
    /// A body's centre of mass.
    pub fn center(body: Body) -> Self {
        Self { body: Some(body), at: DVec3::ZERO }
    }
}

impl<Body, Joint> Probe<Body, Joint> {
    /// The same of other points and joints; none where one of them has no counterpart.
    pub(super) fn map<OtherBody, OtherJoint>(
        &self,
        point: impl Fn(&ProbePoint<Body>) -> Option<ProbePoint<OtherBody>>,
        joint: impl Fn(&Joint) -> Option<OtherJoint>,
    ) -> Option<Probe<OtherBody, OtherJoint>> {
        Some(match self {
            Self::Plot(subject, plot) => {
                let subject = match subject {
                    ProbeSubject::Point(of) => ProbeSubject::Point(point(of)?),
                    ProbeSubject::Joint(of) => ProbeSubject::Joint(joint(of)?),
                    ProbeSubject::Scene => ProbeSubject::Scene,
                };
                Probe::Plot(subject, *plot)
            }
            Self::Trail(of) => Probe::Trail(point(of)?),
            Self::Tape([from, to]) => Probe::Tape([point(from)?, point(to)?]),
        })
    }
}

impl Probes {
    /// Of bodies and joints that are these entities.
    pub(super) fn of_specs(probes: &[ProbeSpec], bodies: &[BodySpec], [as_bodies, as_joints]: [&[Entity]; 2]) -> Self {
        let by_name: HashMap<&str, usize> =
            bodies.iter().enumerate().map(|(place, body)| (body.name.as_str(), place)).collect();
        let point = |point: &ProbePoint<String>| {
            let Some(name) = &point.body else { return Some(ProbePoint { body: None, at: point.at }) };
            let place = *by_name.get(name.as_str())?;
            let at = in_principal_axes(&bodies[place]).inverse() * point.at;
            Some(ProbePoint { body: Some(*as_bodies.get(place)?), at })
        };
        let joint = |place: &usize| as_joints.get(*place).copied();
        Self(probes.iter().filter_map(|probe| probe.map(point, joint)).collect())
    }

    /// As data, without those of what is gone: of a scene with these entities.
    pub(super) fn to_specs(&self, bodies: &HashMap<Entity, &BodySpec>, joints: &[Entity]) -> Vec<ProbeSpec> {
        let point = |point: &ProbePoint<Entity>| {
            let Some(entity) = point.body else { return Some(ProbePoint { body: None, at: point.at }) };
            let body = bodies.get(&entity)?;
            Some(ProbePoint { body: Some(body.name.clone()), at: in_principal_axes(body) * point.at })
        };
        let joint = |entity: &Entity| joints.iter().position(|joint| joint == entity);
        self.0.iter().filter_map(|probe| probe.map(point, joint)).collect()
    }
}
