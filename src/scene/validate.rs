//! Whether a scene makes sense, whoever made it.

use std::collections::HashMap;
use std::f64::consts::PI;

use bevy::math::{DQuat, DVec3};

#[cfg(feature = "sandbox")]
use super::JointParts;
use super::error::Flaw;
use super::number::{Finite, Fraction, NonNegative, NumberError, Positive};
use super::{
    BodySpec, JointKindSpec, JointSpec, LimitSpec, MAX_BODIES, MAX_PROBES, MotorKeys, Probe, ProbePoint, ProbeSpec,
    ProbeSubject, SceneError, SceneSpec, ShapeSpec, ViewSpec,
};
use crate::physics::{DistanceLaw, JointAxes, JointMotor, MotorTarget, RigidBody, Softness};

/// A field of a body, joint or view, and what is wrong with it.
type FieldFlaw = (&'static str, String);

impl SceneSpec {
    /// Checks all that can be wrong with a scene before it is spawned: numbers that are not finite
    /// or out of their range, names that are taken or missing, bodies without mass, joints that
    /// join nothing. An empty scene is fine.
    ///
    /// # Errors
    /// The first thing that is wrong, with its place in the scene.
    pub fn validate(&self) -> Result<(), SceneError> {
        self.validate_as(&self.name)
    }

    /// As [`validate`](Self::validate), for a scene that the user knows as `source`.
    pub(super) fn validate_as(&self, source: &str) -> Result<(), SceneError> {
        if self.bodies.len() > MAX_BODIES {
            return Err(SceneError::TooManyBodies { scene: source.to_owned(), bodies: self.bodies.len() as u64 });
        }
        self.find_flaw().map_err(|flaw| flaw.of(source))
    }

    fn find_flaw(&self) -> Result<(), Flaw> {
        finite("gravity", self.gravity).map_err(|(place, problem)| Flaw::new(place, problem))?;
        let mut by_name: HashMap<&str, usize> = HashMap::with_capacity(self.bodies.len());
        for (i, body) in self.bodies.iter().enumerate() {
            if let Some(earlier) = by_name.insert(&body.name, i) {
                let problem = format!("'{}' is already the name of bodies[{earlier}]", body.name);
                return Err(Flaw::new(format!("bodies[{i}].name"), problem));
            }
            check_body(body).map_err(|(field, problem)| Flaw::new(format!("bodies[{i}].{field}"), problem))?;
        }
        for (i, joint) in self.joints.iter().enumerate() {
            check_joint(joint, |name| by_name.get(name).map(|&body| &self.bodies[body]))
                .map_err(|(field, problem)| Flaw::new(format!("joints[{i}].{field}"), problem))?;
        }
        if self.probes.len() > MAX_PROBES {
            let problem = format!("{} are more than the limit of {MAX_PROBES}", self.probes.len());
            return Err(Flaw::new("probes", problem));
        }
        for (i, probe) in self.probes.iter().enumerate() {
            check_probe(probe, |name| by_name.contains_key(name), self.joints.len())
                .map_err(|(field, problem)| Flaw::new(format!("probes[{i}].{field}"), problem))?;
        }
        match &self.view {
            Some(view) => check_view(view).map_err(|(field, problem)| Flaw::new(format!("view.{field}"), problem)),
            None => Ok(()),
        }
    }
}

fn check_body(body: &BodySpec) -> Result<(), FieldFlaw> {
    if body.name.is_empty() {
        return Err(("name", "must not be empty".to_owned()));
    }
    if body.name_is_reserved() {
        return Err(("name", format!("'{}' is kept for what does not move; choose another", body.name)));
    }
    finite("position", body.position)?;
    unit("rotation", body.rotation)?;
    finite("velocity", body.linear_velocity)?;
    finite("angular_velocity", body.angular_velocity)?;
    finite("force", body.force)?;
    finite("torque", body.torque)?;
    number::<Finite>("gravity_scale", body.gravity_scale)?;
    number::<NonNegative>("linear_damping", body.damping.0)?;
    number::<NonNegative>("angular_damping", body.damping.1)?;
    number::<NonNegative>("friction", body.material.friction)?;
    number::<Fraction>("restitution", body.material.restitution)?;
    number::<Positive>("density", body.density)?;
    for channel in body.color.into_iter().flatten() {
        number::<Fraction>("color", channel.into())?;
    }
    if let Some(mass) = body.mass {
        number::<Positive>("mass", mass)?;
    }
    if let Some(inertia) = body.inertia {
        positive("inertia", inertia)?;
    }
    check_shape(body)
}

fn check_shape(body: &BodySpec) -> Result<(), FieldFlaw> {
    let Some(shape) = &body.shape else {
        return if body.kind == RigidBody::Dynamic && (body.mass.is_none() || body.inertia.is_none()) {
            let problem = "a dynamic body needs a shape, or both a mass and an inertia; or say kind: Static";
            Err(("shape", problem.to_owned()))
        } else {
            Ok(())
        };
    };
    match shape {
        ShapeSpec::HalfSpace if body.kind == RigidBody::Static => return Ok(()),
        ShapeSpec::HalfSpace => {
            return Err(("shape", "a half-space has no mass and does not move: say kind: Static".to_owned()));
        }
        ShapeSpec::Sphere { radius } => number::<Positive>("shape.radius", *radius)?,
        ShapeSpec::Cuboid { size } => positive("shape.size", *size)?,
        ShapeSpec::Capsule { radius, length } => {
            number::<Positive>("shape.radius", *radius)?;
            number::<Positive>("shape.length", *length)?;
        }
        ShapeSpec::Cylinder { radius, height } | ShapeSpec::Cone { radius, height } => {
            number::<Positive>("shape.radius", *radius)?;
            number::<Positive>("shape.height", *height)?;
        }
        ShapeSpec::Hull(hull) => _ = hull.hull().as_ref().map_err(|error| ("shape.points", error.to_string()))?,
        ShapeSpec::Mesh(_) => {}     // has a hull
        ShapeSpec::Compound(_) => {} // is one
        ShapeSpec::Surface(_) if body.kind == RigidBody::Dynamic => {
            let problem = "a surface has no mass: say kind: Static, or Kinematic for one that moves as it is told";
            return Err(("shape", problem.to_owned()));
        }
        ShapeSpec::Surface(_) => return Ok(()),
    }
    // Sizes and densities that are fine alone can together leave f64's range.
    let mass = body.mass.unwrap_or(body.density * shape.volume());
    let inertia = mass * shape.bounding_radius().powi(2);
    if mass.is_normal() && inertia.is_normal() {
        Ok(())
    } else {
        Err(("shape", format!("its size and density give a mass of {mass:e} kg; use less extreme ones")))
    }
}

fn check_joint<'a>(joint: &JointSpec, body: impl Fn(&str) -> Option<&'a BodySpec>) -> Result<(), FieldFlaw> {
    let known = |field, name: &str| body(name).ok_or_else(|| (field, no_body(name)));
    let (body_a, body_b) = (known("body_a", &joint.body_a)?, known("body_b", &joint.body_b)?);
    if joint.body_a == joint.body_b {
        return Err(("body_b", format!("joins '{}' to itself; a joint needs two bodies", joint.body_b)));
    }
    if body_a.kind != RigidBody::Dynamic && body_b.kind != RigidBody::Dynamic {
        let problem = format!("neither '{}' nor '{}' is dynamic; one of them must be", joint.body_a, joint.body_b);
        return Err(("body_b", problem));
    }
    finite("anchor_a", joint.anchor_a)?;
    finite("anchor_b", joint.anchor_b)?;
    check_axes(&joint.axes)?;
    if let Some(Softness { frequency, damping_ratio, max_force }) = joint.softness {
        number::<Positive>("softness.frequency", frequency)?;
        number::<NonNegative>("softness.damping_ratio", damping_ratio)?;
        number::<Positive>("softness.max_force", max_force)?;
        if joint.kind != JointKindSpec::Ball {
            return Err(("softness", "is for ball joints; a motor with a target of Spring drives others".to_owned()));
        }
    }
    check_laws(joint)
}

fn check_axes(axes: &JointAxes) -> Result<(), FieldFlaw> {
    if axes.is_valid() {
        return Ok(());
    }
    let no_axis =
        |end: &str, axis: &DVec3| format!("{end}must be finite and not (0, 0, 0), is {axis}; give a direction");
    Err(match axes {
        JointAxes::World(axis) => ("axis", no_axis("", axis)),
        JointAxes::Bodies(a, b) => {
            let (end, axis) = if a.is_finite() && *a != DVec3::ZERO { ("B's ", b) } else { ("A's ", a) };
            ("axes", no_axis(end, axis))
        }
        JointAxes::Frames(..) => ("frames", "each must be a quaternion of length 1".to_owned()),
    })
}

/// Whether limits, motor, friction and strength make sense on a joint.
///
/// # Errors
/// What does not, in one line.
#[cfg(feature = "sandbox")]
pub(crate) fn check_parts(joint: &JointParts) -> Result<(), String> {
    let end = BodySpec::pin("", DVec3::ZERO);
    check_laws(&joint.to_spec([&end; 2])).map_err(|(field, problem)| format!("{field}: {problem}"))
}

fn check_laws(joint: &JointSpec) -> Result<(), FieldFlaw> {
    if let JointKindSpec::Distance(length) = joint.kind {
        check_length(&length)?;
    }
    if let Some(limits) = &joint.limits {
        check_limits(joint, limits)?;
    }
    if let Some(motor) = &joint.motor {
        if !joint.has_axis() {
            return Err(("motor", NO_AXIS.to_owned()));
        }
        check_motor(motor)?;
    }
    if let Some(keys) = &joint.keys {
        check_keys(keys)?;
        if joint.motor.and_then(|motor| motor.target.value()).is_none() {
            return Err(("motor.keys", "set a speed or a position: the motor's target must be one".to_owned()));
        }
    }
    number::<NonNegative>("friction", joint.friction)?;
    if joint.friction > 0.0 && !joint.has_axis() && joint.kind != JointKindSpec::Ball {
        return Err(("friction", NO_AXIS.to_owned()));
    }
    if let Some(breakable) = joint.breakable
        && !breakable.is_valid()
    {
        let problem = "force and torque must be greater than 0, window and from finite and at least 0";
        return Err(("breakable", problem.to_owned()));
    }
    number::<Finite>("coordinate", joint.coordinate)
}

/// Whether keys are two that may be keys: which there are, the window knows.
fn check_keys(keys: &MotorKeys) -> Result<(), FieldFlaw> {
    keys.values.into_iter().chain([keys.rest]).try_for_each(|value| number::<Finite>("motor.keys.values", value))?;
    let is_name = |name: &str| {
        name.starts_with(|first: char| first.is_ascii_uppercase()) && name.chars().all(|c| c.is_ascii_alphanumeric())
    };
    for (field, name) in ["motor.keys.forward", "motor.keys.back"].into_iter().zip(&keys.keys) {
        if !is_name(name) {
            let problem = format!("no key '{name}'; name one as Bevy's KeyCode does, such as ArrowUp, KeyW or Space");
            return Err((field, problem));
        }
    }
    let [forward, back] = &keys.keys;
    if forward == back {
        return Err(("motor.keys.back", format!("'{back}' is already the key for forward; choose another")));
    }
    Ok(())
}

/// What to say of limits, a motor or friction of a joint that has nothing for them to act on.
const NO_AXIS: &str = "the joint has no axis of its own: use a Hinge, a Slider, a Distance, or a Generic with an axis";

fn check_length(length: &DistanceLaw) -> Result<(), FieldFlaw> {
    match *length {
        DistanceLaw::Range { min, max } => {
            number::<NonNegative>("kind.min", min)?;
            if min <= max && max > 0.0 { Ok(()) } else { Err(("kind.max", disorder(min, max))) }
        }
        DistanceLaw::Spring { rest, stiffness, damping } => {
            number::<NonNegative>("kind.rest", rest)?;
            number::<NonNegative>("kind.stiffness", stiffness)?;
            number::<NonNegative>("kind.damping", damping)
        }
    }
}

fn check_limits(joint: &JointSpec, limits: &LimitSpec) -> Result<(), FieldFlaw> {
    let LimitSpec { swing, min, max, restitution } = *limits;
    number::<Fraction>("limits.restitution", restitution)?;
    if min.is_nan() || max.is_nan() || min > max {
        return Err(("limits.min", disorder(min, max)));
    }
    match (swing, joint.kind) {
        (Some(swing), JointKindSpec::Ball) => {
            let is_angle = |angle: f64, is_none: bool| is_none || angle.abs() < PI;
            if !(swing > 0.0 && is_angle(swing, swing == f64::INFINITY)) {
                return Err(("limits.swing", format!("must be greater than 0 and less than π, is {swing}")));
            }
            if !is_angle(min, min == f64::NEG_INFINITY) || !is_angle(max, max == f64::INFINITY) {
                return Err(("limits.min", format!("a twist must lie between −π and π, is {min} to {max}")));
            }
            Ok(())
        }
        (Some(_), _) => Err(("limits.swing", "is for ball joints; others have min and max".to_owned())),
        (None, _) if !joint.has_axis() => Err(("limits", NO_AXIS.to_owned())),
        (None, _) => Ok(()),
    }
}

fn check_motor(motor: &JointMotor) -> Result<(), FieldFlaw> {
    if motor.max_force.is_nan() || motor.max_force < 0.0 {
        return Err(("motor.max_force", format!("must be at least 0, is {}", motor.max_force)));
    }
    match motor.target {
        MotorTarget::Speed(speed) => number::<Finite>("motor.target", speed),
        MotorTarget::Position { target, frequency, damping_ratio } => {
            number::<Finite>("motor.target", target)?;
            number::<Positive>("motor.target.frequency", frequency)?;
            number::<NonNegative>("motor.target.damping_ratio", damping_ratio)
        }
        MotorTarget::Spring { target, stiffness, damping } => {
            number::<Finite>("motor.target", target)?;
            number::<NonNegative>("motor.target.stiffness", stiffness)?;
            number::<NonNegative>("motor.target.damping", damping)
        }
        MotorTarget::Motion(motion) if motion.is_finite() => Ok(()),
        MotorTarget::Motion(_) => Err(("motor.target", "must be finite".to_owned())),
    }
}

fn disorder(min: f64, max: f64) -> String {
    format!("must be in order, the least first, are {min} and {max}")
}

/// What to say of a joint to a body that is not there.
pub(super) fn no_body(name: &str) -> String {
    format!("no body '{name}'; name one of the scene's bodies, or 'world'")
}

fn check_view(view: &ViewSpec) -> Result<(), FieldFlaw> {
    finite("eye", view.eye)?;
    finite("target", view.target)?;
    if view.eye == view.target {
        return Err(("target", "must not be where the eye is".to_owned()));
    }
    Ok(())
}

fn check_probe(probe: &ProbeSpec, is_body: impl Fn(&str) -> bool, joints: usize) -> Result<(), FieldFlaw> {
    let check_point = |fields: [&'static str; 2], point: &ProbePoint<String>| match &point.body {
        Some(name) if !is_body(name) => Err((fields[0], no_body(name))),
        _ => finite(fields[1], point.at),
    };
    let here = ["body", "at"];
    match probe {
        Probe::Plot(subject, plot) => {
            match subject {
                ProbeSubject::Point(point) => check_point(here, point)?,
                ProbeSubject::Joint(joint) if *joint >= joints => {
                    return Err(("joint", format!("no joint {joint}; the scene has {joints}, counted from 0")));
                }
                ProbeSubject::Joint(_) | ProbeSubject::Scene => {}
            }
            let of = match subject {
                ProbeSubject::Point(ProbePoint { body: Some(_), .. }) => "a body",
                ProbeSubject::Point(_) => "the world, which stands still; name a body",
                ProbeSubject::Joint(_) => "a joint",
                ProbeSubject::Scene => "a scene; name a body or a joint",
            };
            if plot.is_of(subject) { Ok(()) } else { Err(("show", format!("there is no {plot:?} of {of}"))) }
        }
        Probe::Trail(point) if point.body.is_none() => {
            Err(("body", "the world leaves no trail; name one of the scene's bodies".to_owned()))
        }
        Probe::Trail(point) => check_point(here, point),
        Probe::Tape([from, to]) => {
            check_point(here, from)?;
            check_point(["show.body", "show.at"], to)
        }
    }
}

fn number<N: TryFrom<f64, Error = NumberError>>(field: &'static str, value: f64) -> Result<(), FieldFlaw> {
    N::try_from(value).map(|_| ()).map_err(|error| (field, error.to_string()))
}

fn finite(field: &'static str, vector: DVec3) -> Result<(), FieldFlaw> {
    vector.to_array().into_iter().try_for_each(|value| number::<Finite>(field, value))
}

fn positive(field: &'static str, vector: DVec3) -> Result<(), FieldFlaw> {
    vector.to_array().into_iter().try_for_each(|value| number::<Positive>(field, value))
}

fn unit(field: &'static str, rotation: DQuat) -> Result<(), FieldFlaw> {
    let length = rotation.length();
    if (length - 1.0).abs() <= 1e-6 {
        Ok(())
    } else {
        Err((field, format!("a rotation must be a quaternion of length 1, is of length {length}")))
    }
}
