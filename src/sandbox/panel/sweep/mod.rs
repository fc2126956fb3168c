//! A sweep in the window: one setting, or one parameter of the scene, over its values, and any quantity that is measured of
//! it, as `plumb chart --vary` has them. It is run by a process of its own; a click on the curve takes a value.

mod plot;
mod run;
mod section;

pub(super) use run::plugin;
pub(super) use section::show;
