//! Why things are as they are: bodies, joints and contact points in the color of a quantity, with a legend in the picture,
//! and how the solves of the last step came to their ends and what its phases took, as plots.

mod color_by;
mod legend;
mod legend_area;
mod paint;
mod phases;
mod points;
mod quantity;
mod residuals;
mod scale;
mod section;
mod watched;

pub use color_by::ColorBy;
pub use paint::Painted;
pub(super) use section::show;

use bevy::prelude::*;

pub(super) fn plugin(app: &mut App) {
    app.add_plugins((color_by::plugin, paint::plugin, points::plugin, legend_area::plugin))
        .add_plugins((watched::plugin, phases::plugin));
}
