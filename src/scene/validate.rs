//! Whether a scene makes sense, whoever made it.

use std::collections::HashMap;

use bevy::math::{DQuat, DVec3};

use super::error::Flaw;
use super::number::{Finite, Fraction, NonNegative, NumberError, Positive};
use super::{BodySpec, JointSpec, MAX_BODIES, SceneError, SceneSpec, ShapeSpec, ViewSpec};
use crate::physics::{RigidBody, Softness};

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
        ShapeSpec::Cone { radius, height } => {
            number::<Positive>("shape.radius", *radius)?;
            number::<Positive>("shape.height", *height)?;
        }
        ShapeSpec::Hull(hull) => _ = hull.hull().as_ref().map_err(|error| ("shape.points", error.to_string()))?,
        ShapeSpec::Mesh(_) => {} // has a hull
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
    if let Some(Softness { frequency, damping_ratio, max_force }) = joint.softness {
        number::<Positive>("softness.frequency", frequency)?;
        number::<NonNegative>("softness.damping_ratio", damping_ratio)?;
        number::<Positive>("softness.max_force", max_force)?;
    }
    Ok(())
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
