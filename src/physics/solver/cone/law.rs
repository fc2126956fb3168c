//! The laws of one point: unilateral contact, with Coulomb friction or without, the ball joint, and a row whose impulse is
//! bounded.
//!
//! In the frame of a contact (normal n from A to B, then two tangents), with λ the impulse on B and u the velocity of
//! B's point relative to A's, Signorini's condition and Coulomb's law say (De Saxcé & Feng 1998)
//!
//! K* ∋ û ⊥ λ ∈ K,  û = u + μ|u_t| n,  K = { |λ_t| ≤ μ λ_n }.
//!
//! The shift μ|u_t| makes of Coulomb's law, whose slip is along the ground, one whose slip û is normal to the cone. A
//! contact without friction has K = { λ_n ≥ 0, λ_t = 0 } and K* = { û_n ≥ 0 }; a joint K = ℝ³ and K* = { 0 }. A row with
//! bounds has an interval for K, which is no cone: u = 0 inside, u ≥ 0 at its lower end, u ≤ 0 at its upper one. For all
//! of them the law holds where the natural map (Acary, Brémond & Huber 2018)
//!
//! r = λ/ρ − P_K(λ/ρ − û)
//!
//! is zero; with ρ the effective mass of the point, |r| is a velocity.

use nalgebra::Vector3;

/// What an impulse may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Law {
    /// Any: three bilateral rows.
    Joint,
    /// Along the normal, not pulling.
    Frictionless,
    /// In Coulomb's cone of this μ > 0.
    Friction(f64),
    /// Along the first axis, within these, N·s.
    Within(f64, f64),
}

impl Law {
    /// μ; of a joint and where there is none, zero.
    pub fn friction(self) -> f64 {
        match self {
            Self::Friction(friction) => friction,
            Self::Joint | Self::Frictionless | Self::Within(..) => 0.0,
        }
    }

    /// Whether it says something of the first axis alone.
    pub fn is_single(self) -> bool {
        matches!(self, Self::Frictionless | Self::Within(..))
    }

    /// μ|u_t|: how much De Saxcé's velocity is more along the normal.
    pub fn shift(self, velocity: &Vector3<f64>) -> f64 {
        self.friction() * width(velocity)
    }

    /// The part of a velocity that the law says something of.
    pub fn relevant(self, velocity: &Vector3<f64>) -> Vector3<f64> {
        match self {
            Self::Frictionless | Self::Within(..) => Vector3::new(velocity.x, 0.0, 0.0),
            Self::Joint | Self::Friction(_) => *velocity,
        }
    }

    /// û.
    pub fn shifted(self, velocity: &Vector3<f64>) -> Vector3<f64> {
        Vector3::new(velocity.x + self.shift(velocity), velocity.y, velocity.z)
    }

    /// P_K.
    pub fn project(self, vector: &Vector3<f64>) -> Vector3<f64> {
        let Self::Friction(friction) = self else { return self.clamp(vector) };
        let width = width(vector);
        if width <= friction * vector.x {
            *vector
        } else if friction * width <= -vector.x {
            Vector3::zeros()
        } else {
            let height = (vector.x + friction * width) / (1.0 + friction * friction);
            let across = friction * height / width;
            Vector3::new(height, across * vector.y, across * vector.z)
        }
    }

    /// C: what is not along the normal is clamped to the friction that a load of as much as is along it allows.
    pub fn clamp(self, vector: &Vector3<f64>) -> Vector3<f64> {
        match self {
            Self::Joint => *vector,
            Self::Frictionless => Vector3::new(vector.x.max(0.0), 0.0, 0.0),
            Self::Within(lower, upper) => Vector3::new(vector.x.max(lower).min(upper), 0.0, 0.0),
            Self::Friction(_) if vector.x <= 0.0 => Vector3::zeros(),
            Self::Friction(friction) => {
                let (width, most) = (width(vector), friction * vector.x);
                let share = if width <= most { 1.0 } else { most / width };
                Vector3::new(vector.x, share * vector.y, share * vector.z)
            }
        }
    }

    /// r: how far an impulse and a velocity are from the law, ρ in kg.
    pub fn natural_map(self, impulse: &Vector3<f64>, velocity: &Vector3<f64>, mass: f64) -> Vector3<f64> {
        match self {
            Self::Joint => *velocity,
            Self::Frictionless => {
                let impulse = impulse.x / mass;
                Vector3::new(impulse - (impulse - velocity.x).max(0.0), 0.0, 0.0)
            }
            Self::Within(..) => (impulse - self.project(&(impulse - velocity * mass))) / mass,
            Self::Friction(_) => {
                let impulse = impulse / mass;
                impulse - self.project(&(impulse - self.shifted(velocity)))
            }
        }
    }
}

/// The length of a vector's last two parts. Not by `hypot`, whose care was a sixth of all time.
pub(super) fn width(vector: &Vector3<f64>) -> f64 {
    (vector.y * vector.y + vector.z * vector.z).sqrt()
}
