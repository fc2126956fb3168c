//! What can be drawn.

use plotters::coord::Shift;
use plotters::prelude::*;

/// What plotters fails with.
pub type PaintResult<DB> = Result<(), DrawingAreaErrorKind<<DB as DrawingBackend>::ErrorType>>;

/// Something that can be drawn.
pub trait Picture {
    /// Width and height, pixels.
    fn size(&self) -> (u32, u32);

    /// Draws it on a white area of that size.
    fn paint<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> PaintResult<DB>;
}
