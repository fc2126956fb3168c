//! A map's picture: a heat map a method, side by side, with the border where runs begin to fail.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

use super::atlas::MapInfo;
use crate::lab::picture::{PaintResult, Picture, TEXT, text};
use crate::lab::verdict::Verdict;

/// One map of one method.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// The method.
    pub series: &'static str,
    /// Verdicts by row (y) and column (x), the first row lowest; none where nothing was measured.
    pub cells: Vec<Vec<Option<Verdict>>>,
}

/// All methods' maps of one kind.
pub(super) struct Sheet<'a> {
    pub info: &'a MapInfo,
    pub maps: &'a [Map],
}

const CELL: (i32, i32) = (40, 30);
const LEFT: i32 = 96;
const GAP: i32 = 34;
const TOP: i32 = 74;
const BOTTOM: i32 = 110;

/// Told apart by their lightness too.
fn color(verdict: Option<Verdict>) -> RGBColor {
    match verdict {
        Some(Verdict::Holds) => RGBColor(214, 236, 246),
        Some(Verdict::Degrades) => RGBColor(240, 200, 90),
        Some(Verdict::Fails) => RGBColor(176, 58, 46),
        Some(Verdict::Unknown) => RGBColor(200, 200, 200),
        None => WHITE,
    }
}

impl Sheet<'_> {
    fn columns(&self) -> i32 {
        self.info.x.values.len() as i32
    }

    fn rows(&self) -> i32 {
        self.info.y.values.len() as i32
    }

    fn map_left(&self, index: usize) -> i32 {
        LEFT + index as i32 * (self.columns() * CELL.0 + GAP)
    }

    /// The upper left corner of a cell.
    fn corner(&self, map: usize, column: i32, row: i32) -> (i32, i32) {
        (self.map_left(map) + column * CELL.0, TOP + (self.rows() - 1 - row) * CELL.1)
    }
}

impl Picture for Sheet<'_> {
    fn size(&self) -> (u32, u32) {
        let width = self.map_left(self.maps.len()) - GAP + 24;
        ((width as u32).max(640), (TOP + self.rows() * CELL.1 + BOTTOM) as u32)
    }

    fn paint<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> PaintResult<DB> {
        let title = format!("{}: where it holds and where it fails", self.info.title());
        area.draw_text(&title, &text(19.0, &TEXT, HPos::Left, VPos::Center), (LEFT, 22))?;
        self.paint_rows(area)?;
        for (index, map) in self.maps.iter().enumerate() {
            self.paint_map(area, index, map)?;
        }
        self.paint_legend(area)
    }
}

impl Sheet<'_> {
    fn paint_rows<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> PaintResult<DB> {
        let style = text(13.0, &TEXT, HPos::Right, VPos::Center);
        for (row, &value) in (0..).zip(self.info.y.values) {
            let (x, y) = self.corner(0, 0, row);
            area.draw_text(&number(value), &style, (x - 8, y + CELL.1 / 2))?;
        }
        let turned = text(14.0, &TEXT, HPos::Center, VPos::Top).transform(FontTransform::Rotate270);
        area.draw_text(self.info.y.label, &turned, (14, TOP + self.rows() * CELL.1 / 2))
    }

    fn paint_map<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>, index: usize, map: &Map) -> PaintResult<DB> {
        let left = self.map_left(index);
        area.draw_text(map.series, &text(15.0, &TEXT, HPos::Left, VPos::Center), (left, TOP - 16))?;
        for (row, cells) in (0..).zip(&map.cells) {
            for (column, &verdict) in (0..).zip(cells) {
                let (x, y) = self.corner(index, column, row);
                let cell = [(x, y), (x + CELL.0 - 1, y + CELL.1 - 1)];
                area.draw(&Rectangle::new(cell, color(verdict).filled()))?;
                if verdict == Some(Verdict::Fails) {
                    let style = text(13.0, &WHITE, HPos::Center, VPos::Center);
                    area.draw_text("×", &style, (x + CELL.0 / 2, y + CELL.1 / 2))?;
                }
            }
        }
        self.paint_border(area, index, map)?;
        let bottom = TOP + self.rows() * CELL.1;
        let style = text(12.0, &TEXT, HPos::Center, VPos::Top);
        for (column, &value) in (0..).zip(self.info.x.values) {
            area.draw_text(&number(value), &style, (left + column * CELL.0 + CELL.0 / 2, bottom + 6))?;
        }
        let middle = left + self.columns() * CELL.0 / 2;
        area.draw_text(self.info.x.label, &text(14.0, &TEXT, HPos::Center, VPos::Top), (middle, bottom + 26))
    }

    /// Between cells that fail and cells that do not.
    fn paint_border<DB: DrawingBackend>(
        &self,
        area: &DrawingArea<DB, Shift>,
        index: usize,
        map: &Map,
    ) -> PaintResult<DB> {
        let fails = |row: i32, column: i32| -> Option<bool> {
            let verdict = (*map.cells.get(usize::try_from(row).ok()?)?.get(usize::try_from(column).ok()?)?)?;
            Some(verdict == Verdict::Fails)
        };
        let line = |from: (i32, i32), to: (i32, i32)| PathElement::new(vec![from, to], BLACK.stroke_width(3));
        for row in 0..self.rows() {
            for column in 0..self.columns() {
                let (x, y) = self.corner(index, column, row);
                let Some(here) = fails(row, column) else { continue };
                if fails(row, column + 1).is_some_and(|there| there != here) {
                    area.draw(&line((x + CELL.0, y), (x + CELL.0, y + CELL.1)))?;
                }
                if fails(row + 1, column).is_some_and(|there| there != here) {
                    area.draw(&line((x, y), (x + CELL.0, y)))?;
                }
            }
        }
        Ok(())
    }

    fn paint_legend<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> PaintResult<DB> {
        let y = TOP + self.rows() * CELL.1 + 62;
        let style = text(14.0, &TEXT, HPos::Left, VPos::Center);
        let kinds = [Verdict::Holds, Verdict::Degrades, Verdict::Fails, Verdict::Unknown];
        for (index, verdict) in (0..).zip(kinds) {
            let x = LEFT + index * 120;
            area.draw(&Rectangle::new([(x, y), (x + 20, y + 16)], color(Some(verdict)).filled()))?;
            area.draw_text(&verdict.to_string(), &style, (x + 28, y + 8))?;
        }
        area.draw_text(self.info.about, &text(13.0, &TEXT, HPos::Left, VPos::Center), (LEFT, y + 34))
    }
}

/// `30`, `1e5`, `0.5`.
fn number(value: f64) -> String {
    if value != 0.0 && !(1e-2..1e4).contains(&value.abs()) { format!("{value:e}") } else { format!("{value}") }
}
