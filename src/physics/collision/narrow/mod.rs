//! Clipped contacts: a routine for each kind of pair of shapes, entered by [`contact_pair::touch`].

mod apart;
mod ball;
mod boxes;
pub(super) mod clipping;
mod cone;
mod cone_cone;
mod cone_polyhedron;
pub(super) mod contact_pair;
mod edge_contact;
mod ellipse;
pub(super) mod feature_sat;
mod plane;
mod polyhedra;
pub(super) mod polyhedron;
mod scale;
