//! Colours, marks and text of all pictures.

use std::sync::Once;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::register_font as register;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::paint::PaintResult;

/// Colours that the colour-blind tell apart (Okabe and Ito 2008), each with a mark of its own, so
/// that a picture in grey can be read too.
const MARKS: [(RGBColor, Mark); 8] = [
    (RGBColor(0, 114, 178), Mark::Disc),
    (RGBColor(213, 94, 0), Mark::Triangle),
    (RGBColor(0, 158, 115), Mark::Square),
    (RGBColor(204, 121, 167), Mark::Cross),
    (RGBColor(230, 159, 0), Mark::Diamond),
    (RGBColor(86, 180, 233), Mark::Ring),
    (RGBColor(120, 100, 20), Mark::Plus),
    (RGBColor(90, 90, 90), Mark::Bar),
];

/// How far the shapes are shifted against the colours each time the colours have been used up.
const SHIFT: usize = 3;

/// Colour and shape of the curve of that number: no two of the first 64 share both.
pub fn mark(index: usize) -> (RGBColor, Mark) {
    let (color, _) = MARKS[index % MARKS.len()];
    let (_, shape) = MARKS[(index + SHIFT * (index / MARKS.len())) % MARKS.len()];
    (color, shape)
}

/// Of text and axes.
pub const TEXT: RGBColor = RGBColor(40, 40, 40);

/// Of grid lines.
pub const FAINT: RGBColor = RGBColor(226, 226, 226);

/// The shape of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// A filled circle.
    Disc,
    /// A filled triangle.
    Triangle,
    /// A filled square.
    Square,
    /// ×.
    Cross,
    /// A filled square on its corner.
    Diamond,
    /// An open circle.
    Ring,
    /// +.
    Plus,
    /// A bar.
    Bar,
}

/// What text is set in: a name that viewers of vector pictures know too.
const FONT: &str = "sans-serif";

/// Makes a font of that name known to plotters, once a process: measuring text needs it, and
/// bitmaps are set in it.
pub(super) fn register_font() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        // Fails for a malformed font only, and text would be missing from every picture.
        let registered = register(FONT, FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT);
        assert!(registered.is_ok(), "the font of this program is well-formed");
    });
}

/// Text of a size in pixels.
pub fn text(size: f64, color: &'static RGBColor, horizontal: HPos, vertical: VPos) -> TextStyle<'static> {
    TextStyle::from((FONT, size)).color(color).pos(Pos::new(horizontal, vertical))
}

/// Draws a mark at a pixel.
pub fn draw_mark<DB: DrawingBackend>(
    area: &DrawingArea<DB, Shift>,
    (x, y): (i32, i32),
    (color, mark): (RGBColor, Mark),
    faint: bool,
) -> PaintResult<DB> {
    let color = color.mix(if faint { 0.22 } else { 0.9 });
    let fill = color.filled();
    let line = color.stroke_width(2);
    let polygon =
        |corners: &[(i32, i32)]| Polygon::new(corners.iter().map(|(i, j)| (x + i, y + j)).collect::<Vec<_>>(), fill);
    let path = |ends: [(i32, i32); 2]| PathElement::new(ends.map(|(i, j)| (x + i, y + j)).to_vec(), line);
    match mark {
        Mark::Disc => area.draw(&Circle::new((x, y), 4, fill)),
        Mark::Ring => area.draw(&Circle::new((x, y), 4, line)),
        Mark::Triangle => area.draw(&polygon(&[(0, -5), (5, 4), (-5, 4)])),
        Mark::Square => area.draw(&polygon(&[(-4, -4), (4, -4), (4, 4), (-4, 4)])),
        Mark::Diamond => area.draw(&polygon(&[(0, -6), (6, 0), (0, 6), (-6, 0)])),
        Mark::Cross => {
            area.draw(&path([(-4, -4), (4, 4)]))?;
            area.draw(&path([(-4, 4), (4, -4)]))
        }
        Mark::Plus => {
            area.draw(&path([(-5, 0), (5, 0)]))?;
            area.draw(&path([(0, -5), (0, 5)]))
        }
        Mark::Bar => area.draw(&polygon(&[(-5, -2), (5, -2), (5, 2), (-5, 2)])),
    }
}

#[cfg(test)]
mod tests {
    use super::mark;

    #[test]
    fn no_two_curves_look_the_same() {
        for one in 0..64 {
            assert!((0..one).all(|other| mark(other) != mark(one)), "{one}");
        }
    }
}
