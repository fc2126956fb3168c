//! What matrices and vectors over bodies are made of.

use nalgebra::{SMatrix, SVector};

/// A block of two bodies' velocities, linear and angular.
pub(crate) type BodyBlock = SMatrix<f64, 6, 6>;
/// A velocity, a momentum or a wrench of one body: linear, angular.
pub(crate) type BodyVector = SVector<f64, 6>;
