//! Plumb's solver and factorisation, which stand on their own: compiled into this benchmark, so that nothing of them need be
//! public. The folders' own `mod.rs` name tests too, which stand on more.

#[path = "../../src/physics/bit_set.rs"]
mod bit_set;
#[path = "../../src/physics/refill.rs"]
mod refill;
#[path = "../../src/physics/solve_trace.rs"]
mod solve_trace;

#[path = "../../src/physics/solver/cone"]
pub mod cone {
    mod constants;
    mod deadline;
    mod iterate;
    mod law;
    mod linear;
    mod newton;
    mod point;
    mod problem;
    mod proximal;
    mod solver;

    use super::linear::{BlockLdl, BlockLu, BodyBlock, BodyVector, Elimination, Inverse};
    use deadline::Deadline;
    use iterate::Iterate;
    use law::Law;
    use point::{ConePoint, root};
    pub(crate) use problem::{ConeBody, ConeContact, ConeJoint, PerPoint, PointJacobian};
    use problem::{ConeEnd, ConeOutcome, Velocity, relative_velocity};
    pub(crate) use solver::ConeSolver;
}

#[path = "../../src/physics/solver/linear"]
pub mod linear {
    mod elimination;
    mod layout;
    mod ldl;
    mod lu;
    mod ordering;
    mod pivot;

    pub(crate) use elimination::Elimination;
    pub(crate) use layout::{BodyBlock, BodyVector};
    pub(crate) use ldl::BlockLdl;
    pub(crate) use lu::BlockLu;
    pub(crate) use pivot::Inverse;
}

pub(crate) use refill::Refill;
pub(crate) use solve_trace::Residuals;
