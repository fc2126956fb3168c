//! What there is to choose from.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::described::choices;
use super::{Choice, Choices};

choices! {
    /// How contact and joint rows are solved: on the forces of each (sub)step, as `pgs`, `cg_pgs`, `nncg` and
    /// `joint_space` do, or on velocities with contacts that last.
    pub enum Method {
        /// Projected Gauss–Seidel on the force-level rows with λ from zero (Catto 2005).
        ProjectedGaussSeidel = "pgs",
        /// The same sweeps, primed by conjugate residuals on the rows that no bound holds, where the sweeps alone are
        /// slow (Morales, Nocedal and Smelyanskiy 2008).
        PrimedGaussSeidel = "cg_pgs",
        /// Conjugate directions with the same sweep for a gradient (Silcowitz, Niebe and Erleben 2010).
        NonsmoothConjugateGradient = "nncg",
        /// Joints solved directly in each substep, and the sweeps over contacts move what is joined as one (contacts in
        /// joint space).
        JointSpace = "joint_space",
        /// Substeps with soft constraints: impulses solved with springs, then relaxed without (Catto 2024); trees of
        /// joints exactly.
        SoftStep = "soft_step",
        /// Impulses on velocities, warm started, then positions moved out of their errors on their own (Catto 2006).
        /// Wants 10 iterations and a slop.
        SequentialImpulses = "sequential_impulses",
        /// Positions of small substeps solved with compliance, velocities from how far they moved (Müller et al. 2020).
        /// Wants 8 substeps or more.
        Xpbd = "xpbd",
        /// Joints by their exact forces, J M⁻¹ Jᵀ λ = b solved directly in each stage of an integrator that converges,
        /// all in `f64`. What is in reach of something goes by a step of second order instead, whose contacts obey
        /// Signorini's condition and Coulomb's cone to 1e-10 m/s; what bounces does so at the time at which it lands.
        Exact = "exact",
    }

    /// How force-level methods make poses of velocities.
    pub enum Integrator {
        /// v += h a, then x += h v with the new v. One solve a (sub)step.
        Euler = "euler",
        /// Kick by h/2, drift by h, kick by h/2. Two solves a (sub)step.
        VelocityVerlet = "velocity_verlet",
    }

    /// How the exact method steps what touches nothing.
    pub enum ExactIntegrator {
        /// Gauss's collocation method, implicit and symmetric: of order 8 where nothing is stiff, of order 6 where
        /// something is, and Radau's of order 5, which damps, where a step is far too long for oscillations of light
        /// links under load.
        Gauss = "gauss",
        /// RATTLE: kicks and free flight, symmetric, of order 2.
        Rattle = "rattle",
    }

    /// How contacts are found.
    pub enum ContactModel {
        /// As in the 2009 engine, anew in each step: bounding spheres swept along x and sorted, one separating axis test
        /// over a set of axes, and for points the extreme vertices of each shape toward the other, moved onto the
        /// contact plane, all with the same depth.
        ExtremeVertices = "extreme_vertices",
        /// As `extreme_vertices`, but one point only: the foremost of these vertices that lies in the other shape. What
        /// the 2009 document advises against.
        SinglePoint = "single_point",
        /// Pairs from a tree of boxes a little larger than their bodies, each in a slot for as long as it is near; for
        /// points the incident face clipped to the reference face, each with its own depth; at most 4, chosen to keep
        /// the deepest one and the area.
        Clipping = "clipping",
    }

    /// How friction is solved.
    pub enum FrictionModel {
        /// No friction rows.
        Off = "off",
        /// One row along the slip at the start of the step, |λ| ≤ μ m_c g: the 2009 engine's. Of force-level methods:
        /// the others take it for the next one.
        OneTangent = "one_tangent",
        /// Of force-level methods two rows, each bounded by μ times the contact's own normal force, which is updated each
        /// sweep; of impulse methods a disc of μ times the manifold's normal impulse, and a twist; of the exact one
        /// Coulomb's cone.
        TwoTangents = "two_tangents",
    }

    /// The scalar in which rows are built and solved. Poses are `f64` either way.
    pub enum Precision {
        /// Single precision, on quantities relative to each body.
        F32 = "f32",
        /// Double precision.
        F64 = "f64",
    }
}

impl ContactModel {
    /// Whether contacts are found in the 2009 engine's way, however many points are kept.
    pub(crate) fn is_of_2009(self) -> bool {
        self != Self::Clipping
    }
}

impl Method {
    /// Whether it sweeps over rows of forces, as the 2009 engine does.
    pub(crate) fn is_force_level(self) -> bool {
        matches!(
            self,
            Self::ProjectedGaussSeidel | Self::PrimedGaussSeidel | Self::NonsmoothConjugateGradient | Self::JointSpace
        )
    }

    /// Whether contacts last from step to step, with their impulses, instead of being found and
    /// forgotten.
    pub(crate) fn keeps_contacts(self) -> bool {
        !self.is_force_level() && self != Self::Exact
    }
}
