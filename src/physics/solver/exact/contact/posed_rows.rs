//! The rows of contacts and joints at the poses of their bodies.

use super::super::constants::SAME_ROWS;
use crate::physics::solver::cone::{ConeBody, ConeContact, ConeJoint};

/// What the cone solver is set to.
#[derive(Clone, Debug, Default)]
pub(super) struct PosedRows {
    pub bodies: Vec<ConeBody>,
    pub contacts: Vec<ConeContact>,
    pub joints: Vec<ConeJoint>,
}

impl PosedRows {
    pub fn clear(&mut self) {
        self.bodies.clear();
        self.contacts.clear();
        self.joints.clear();
    }

    /// Whether a solver that is set to the other may solve for these: the same bodies are coupled by the same laws, and no number
    /// differs by more than [`SAME_ROWS`] of the largest beside it.
    pub fn are_as(&self, other: &Self) -> bool {
        are_alike(&self.bodies, &other.bodies, |one, other| {
            one.inverse_mass == other.inverse_mass
                && are_near(one.inverse_inertia.as_slice(), other.inverse_inertia.as_slice())
        }) && are_alike(&self.contacts, &other.contacts, |one, other| {
            let is_same_arm = |end: usize| {
                one.bodies[end].is_none() || are_near(one.arms[end].as_slice(), other.arms[end].as_slice())
            };
            (one.bodies, one.friction) == (other.bodies, other.friction)
                && are_near(one.normal.as_slice(), other.normal.as_slice())
                && is_same_arm(0)
                && is_same_arm(1)
        }) && are_alike(&self.joints, &other.joints, |one, other| {
            let is_same_end = |end: usize| {
                one.bodies[end].is_none() || are_near(one.jacobians[end].as_slice(), other.jacobians[end].as_slice())
            };
            (one.bodies, one.bounds) == (other.bodies, other.bounds) && is_same_end(0) && is_same_end(1)
        })
    }
}

fn are_alike<T>(some: &[T], others: &[T], is_alike: impl Fn(&T, &T) -> bool) -> bool {
    some.len() == others.len() && some.iter().zip(others).all(|(one, other)| is_alike(one, other))
}

/// Whether no number differs from the other's by more than a share of the largest.
fn are_near(some: &[f64], others: &[f64]) -> bool {
    let largest = some.iter().fold(0.0, |largest: f64, number| largest.max(number.abs()));
    some.iter().zip(others).all(|(one, other)| (one - other).abs() <= SAME_ROWS * largest)
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, Vector3};

    use super::*;

    fn rows() -> PosedRows {
        let body = ConeBody { inverse_mass: Vector3::repeat(0.5), inverse_inertia: Matrix3::identity() * 0.1 };
        let arms = [Vector3::new(0.0, 0.5, 0.2), Vector3::new(0.0, -0.5, 0.2)];
        let contact = ConeContact { bodies: [None, Some(0)], arms, normal: Vector3::y(), friction: 0.5 };
        PosedRows {
            bodies: vec![body; 2],
            contacts: vec![contact],
            joints: vec![ConeJoint::ball([Some(0), Some(1)], &arms)],
        }
    }

    #[test]
    fn rows_are_the_same_where_bodies_hardly_moved() {
        let changed = |change: fn(&mut PosedRows)| {
            let mut rows = rows();
            change(&mut rows);
            rows.are_as(&self::rows())
        };
        assert!(changed(|_| {}));
        assert!(changed(|rows| rows.contacts[0].arms[1].x += 0.4 * SAME_ROWS));
        assert!(changed(|rows| rows.contacts[0].arms[0].x += 1.0), "nobody reads that of the ground");
        for change in [
            |rows: &mut PosedRows| rows.contacts[0].arms[1].x += 2.0 * SAME_ROWS,
            |rows: &mut PosedRows| rows.contacts[0].normal.z += 2.0 * SAME_ROWS,
            |rows: &mut PosedRows| rows.contacts[0].friction = 0.4,
            |rows: &mut PosedRows| rows.contacts[0].bodies[1] = Some(1),
            |rows: &mut PosedRows| rows.bodies[1].inverse_inertia[(0, 1)] += 2.0 * SAME_ROWS,
            |rows: &mut PosedRows| rows.bodies[1].inverse_mass.x = 0.0,
            |rows: &mut PosedRows| rows.joints[0].jacobians[1][(0, 5)] += 2.0 * SAME_ROWS,
            |rows: &mut PosedRows| rows.joints[0].bounds = (0.0, f64::INFINITY),
            |rows: &mut PosedRows| rows.joints.clear(),
            |rows: &mut PosedRows| rows.contacts[0].arms[1].x = f64::NAN,
        ] {
            assert!(!changed(change));
        }
    }
}
