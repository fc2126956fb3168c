//! How far a contact is from the laws of non-penetration and Coulomb friction, as one number.
//!
//! With n the unit normal from A to B, λ the impulse on B and u the velocity of B's point relative
//! to A's, Signorini's condition 0 ≤ λ_n ⊥ u_n ≥ 0 and Coulomb's law with friction μ together say
//! K* ∋ û ⊥ λ ∈ K with
//!
//! û = u + μ |u_t| n,  K = { λ : |λ_t| ≤ μ λ_n },  K* = { v : v_n ≥ μ |v_t| } its dual cone
//!
//! (G. De Saxcé and Z.-Q. Feng, *The bipotential method*, Mathematical and Computer Modelling 28,
//! 1998). That is so exactly where the natural map
//!
//! r = λ/ρ − P_K(λ/ρ − û)
//!
//! is zero, P_K being the projection on K and ρ any mass (V. Acary, M. Brémond and O. Huber, *On
//! solving contact problems with Coulomb friction: formulations and numerical comparisons*, 2018).
//! With ρ = 1/(n·J M⁻¹Jᵀ n), the contact's effective mass along its normal, |r| is a velocity: how
//! much that of the contact is off, or what its wrong impulse would change it by.

use bevy::math::DVec3;

/// A contact point after a solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SolvedContact {
    /// n: unit, from A to B.
    pub normal: DVec3,
    /// μ.
    pub friction: f64,
    /// ρ, kg.
    pub effective_mass: f64,
    /// λ: impulse on B, N·s.
    pub impulse: DVec3,
    /// u: velocity of B's point relative to A's, m/s; along n, more by what the contact may close
    /// a gap by within the step, or bounces by.
    pub velocity: DVec3,
}

impl SolvedContact {
    /// |r|, m/s.
    pub fn residual(&self) -> f64 {
        let tangential = self.velocity - self.normal * self.normal.dot(self.velocity);
        let shifted = self.velocity + self.friction * tangential.length() * self.normal;
        let impulse = self.impulse / self.effective_mass;
        impulse.distance(on_cone(impulse - shifted, self.normal, self.friction))
    }
}

/// P_K: the point of Coulomb's cone about `normal` that is nearest to a vector.
fn on_cone(vector: DVec3, normal: DVec3, friction: f64) -> DVec3 {
    let along = normal.dot(vector);
    let across = vector - along * normal;
    let width = across.length();
    if width <= friction * along {
        vector
    } else if friction * width <= -along {
        DVec3::ZERO
    } else {
        let height = (along + friction * width) / (1.0 + friction * friction);
        height * (normal + friction * across / width)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const N: DVec3 = DVec3::Y;

    /// A box of 2 kg on the ground: g h = 0.1 m/s, so that λ = 0.2 N·s holds it.
    fn resting() -> SolvedContact {
        let impulse = 0.2 * N;
        SolvedContact { normal: N, friction: 0.5, effective_mass: 2.0, impulse, velocity: DVec3::ZERO }
    }

    #[test]
    fn exact_contacts_have_no_residual() {
        let sliding = SolvedContact { impulse: DVec3::new(-0.1, 0.2, 0.0), velocity: 3.0 * DVec3::X, ..resting() };
        let frictionless = SolvedContact { friction: 0.0, velocity: DVec3::new(1.0, 0.0, 2.0), ..resting() };
        let sticking = SolvedContact { impulse: DVec3::new(0.05, 0.2, -0.06), ..resting() };
        let parting = SolvedContact { impulse: DVec3::ZERO, velocity: DVec3::new(4.0, 0.3, 0.0), ..resting() };
        let grazing = SolvedContact { impulse: DVec3::ZERO, velocity: DVec3::new(4.0, 0.0, 1.0), ..resting() };
        for contact in [resting(), sliding, frictionless, sticking, parting, grazing] {
            assert!(contact.residual() < 1e-15, "{contact:?}: {}", contact.residual());
        }
    }

    #[test]
    fn each_broken_law_shows_as_the_velocity_it_is_off_by() {
        let residual = |impulse: DVec3, velocity: DVec3| SolvedContact { impulse, velocity, ..resting() }.residual();
        let close = |value: f64, expected: f64| assert!((value - expected).abs() < 1e-14, "{value}, not {expected}");
        // It goes on into the ground.
        close(residual(DVec3::ZERO, -0.3 * N), 0.3);
        // It is held while it leaves, by less or by more than it leaves with: the lesser counts.
        close(residual(0.02 * N, 0.3 * N), 0.01);
        close(residual(0.2 * N, 0.03 * N), 0.03);
        // It is pulled: the impulse has to go, and the fall it would leave is none.
        close(residual(-0.2 * N, DVec3::ZERO), 0.1);
        // It is pulled sideways by an impulse off the cone, at 45° where the cone ends at 26.6°:
        // the distance to the cone's side.
        let off = residual(DVec3::new(0.2, 0.2, 0.0), DVec3::ZERO);
        close(off, 0.1 * 2.0_f64.sqrt() * (45_f64.to_radians() - 0.5_f64.atan()).sin());
    }

    #[test]
    fn friction_must_be_as_large_as_it_can_and_against_the_slip() {
        let sliding = |impulse: DVec3| SolvedContact { impulse, velocity: 3.0 * DVec3::X, ..resting() }.residual();
        assert!(sliding(DVec3::new(-0.1, 0.2, 0.0)) < 1e-15);
        for wrong in [DVec3::new(-0.09, 0.2, 0.0), DVec3::new(-0.11, 0.2, 0.0), DVec3::new(0.1, 0.2, 0.0)] {
            assert!(sliding(wrong) > 1e-3, "{wrong}: {}", sliding(wrong));
        }
        let aslant = 0.1 * DVec3::new(-0.8, 0.0, 0.6) + 0.2 * N;
        assert!(sliding(aslant) > 1e-2);
    }

    #[test]
    fn the_projection_is_the_nearest_point_of_the_cone() {
        let friction = 0.7;
        for vector in [DVec3::new(1.0, 0.2, 0.5), DVec3::new(-2.0, 1.0, 0.3), DVec3::new(0.3, -0.1, 0.2)] {
            let nearest = on_cone(vector, N, friction);
            let distance = vector.distance(nearest);
            assert!(nearest.x.hypot(nearest.z) <= friction * nearest.y + 1e-15);
            // No point of the cone's surface is nearer.
            for turn in 0..360 {
                for height in 0..300 {
                    let (sin, cos) = f64::from(turn).to_radians().sin_cos();
                    let point = 0.01 * f64::from(height) * DVec3::new(friction * cos, 1.0, friction * sin);
                    assert!(vector.distance(point) >= distance - 1e-12, "{vector}: {point} is nearer");
                }
            }
        }
    }
}
