//! Clipped contacts: a routine for each kind of pair of shapes, entered by [`contact_pair::touch`].

mod across;
mod apart;
mod approach;
mod axis_code;
pub(super) mod ball;
mod boxes;
mod capsule;
pub(super) mod clipping;
mod cluster;
mod cone;
mod cone_cone;
mod cone_flank;
#[cfg(test)]
mod cone_oracle;
mod cone_rims;
mod cone_search;
#[cfg(test)]
mod cone_tests;
pub(super) mod contact_pair;
mod cylinder;
mod cylinder_revolved;
mod edge_contact;
mod ellipse;
mod facet;
pub(super) mod feature_sat;
mod place;
pub(super) mod place_at_any;
mod placed_cone;
mod plane;
pub(super) mod polyhedron;
mod revolved;
mod revolved_polyhedron;
mod rim;
mod shape_pair;
pub(super) mod triangle;

use across::{length_across, unit_across};
use clipping::{ClipBuffers, Faced};
use cone::Cone;
use cylinder::Cylinder;
use edge_contact::{closest, middle};
use feature_sat::{Feature, Found, Least, PairSearch};
pub(super) use polyhedron::Frame;
use polyhedron::{Convex, Cuboid, Edge, Plane, Polyhedron, Segment, first_max, nearest_on_hull};
use rim::Rim;
pub(super) use shape_pair::Scale;
use shape_pair::ShapePair;

use super::manifold::Overlap;
use crate::physics::{ContactPoint, FeatureId};
