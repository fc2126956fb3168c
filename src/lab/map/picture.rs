//! A map's picture: a heat map a method, side by side, with the border where runs begin to fail.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

use super::plan::MapPlan;
use crate::lab::picture::{PaintResult, Picture, TEXT, text};
use crate::lab::sweep::Record;
use crate::lab::vary::{Assignment, Measure, Scale};
use crate::lab::verdict::Verdict;

/// One map of one method.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// The method.
    pub series: String,
    /// Runs by row (y) and column (x), the first row lowest; none where nothing was measured.
    pub cells: Vec<Vec<Option<Record>>>,
}

/// All methods' maps of one kind.
pub(super) struct Sheet<'a> {
    pub plan: &'a MapPlan,
    pub maps: &'a [Map],
}

const CELL: (i32, i32) = (40, 30);
const GAP: i32 = 34;
const TOP: i32 = 74;
/// What is wider goes on below.
const MOST_WIDTH: i32 = 1400;
/// Between what is written at the columns of a map and the cells of one below it: a label and a name.
const BELOW: i32 = 74;
/// Room for the label and the legend.
const BOTTOM: i32 = 110;
/// Of a letter beside an axis and of one over a map, on average.
const LETTERS: (i32, i32) = (7, 8);

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
        self.plan.x.values().len() as i32
    }

    fn rows(&self) -> i32 {
        self.plan.y.values().len() as i32
    }

    /// Where the first map begins: names take more room than numbers.
    fn left(&self) -> i32 {
        (LETTERS.0 * longest(self.plan.y.values()) + 44).max(96)
    }

    /// Height of what is written under the columns: names do not fit side by side.
    fn values_height(&self) -> i32 {
        if self.names_stand() { LETTERS.0 * longest(self.plan.x.values()) } else { 14 }
    }

    fn names_stand(&self) -> bool {
        self.plan.x.scale == Scale::InOrder && LETTERS.0 * longest(self.plan.x.values()) > CELL.0
    }

    /// Width of a map, or of what is written over it.
    fn map_width(&self, map: &Map) -> i32 {
        (self.columns() * CELL.0).max(LETTERS.1 * map.series.chars().count() as i32)
    }

    /// The upper left corner of each map: side by side as far as there is room, then below.
    fn places(&self) -> Vec<(i32, i32)> {
        let (mut left, mut top) = (self.left(), TOP);
        let place = |map: &Map| {
            if left > self.left() && left + self.map_width(map) > MOST_WIDTH {
                (left, top) = (self.left(), top + self.map_height() + BELOW);
            }
            let place = (left, top);
            left += self.map_width(map) + GAP;
            place
        };
        self.maps.iter().map(place).collect()
    }

    /// With what is written at the columns.
    fn map_height(&self) -> i32 {
        self.rows() * CELL.1 + self.values_height()
    }

    /// Under the maps and what is written at their columns.
    fn bottom(&self) -> i32 {
        self.places().last().map_or(TOP, |place| place.1) + self.map_height()
    }

    /// The upper left corner of a cell of the map at that place.
    fn corner(&self, (left, top): (i32, i32), column: i32, row: i32) -> (i32, i32) {
        (left + column * CELL.0, top + (self.rows() - 1 - row) * CELL.1)
    }
}

/// Letters of the longest value.
fn longest(values: &[Assignment]) -> i32 {
    values.iter().map(|value| value.value.to_string().chars().count()).max().unwrap_or(0) as i32
}

impl Picture for Sheet<'_> {
    fn size(&self) -> (u32, u32) {
        let right = |(place, map): ((i32, i32), &Map)| place.0 + self.map_width(map);
        let width = self.places().into_iter().zip(self.maps).map(right).max().unwrap_or(0) + 24;
        ((width as u32).max(640), (self.bottom() + BOTTOM - 14) as u32)
    }

    fn paint<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> PaintResult<DB> {
        let title = match self.plan.measure {
            Some(measure) => format!("{}: {}", self.plan.title(), self.measured(measure)),
            None => format!("{}: where it holds and where it fails", self.plan.title()),
        };
        area.draw_text(&title, &text(19.0, &TEXT, HPos::Left, VPos::Center), (self.left(), 22))?;
        for (place, map) in self.places().into_iter().zip(self.maps) {
            if place.0 == self.left() {
                self.paint_rows(area, place)?;
            }
            self.paint_map(area, place, map)?;
        }
        self.paint_legend(area)
    }
}

impl Sheet<'_> {
    /// What is measured; the error with its unit.
    fn measured(&self, measure: &Measure) -> String {
        let mut runs = self.maps.iter().flat_map(|map| map.cells.iter().flatten().flatten());
        match runs.find(|record| !record.unit.is_empty()) {
            Some(record) if measure.name == "error" => format!("{}, {}", measure.about, record.unit),
            _ => measure.about.to_owned(),
        }
    }

    /// The values and the label beside a map.
    fn paint_rows<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>, place: (i32, i32)) -> PaintResult<DB> {
        let style = text(13.0, &TEXT, HPos::Right, VPos::Center);
        for (row, value) in (0..).zip(self.plan.y.values()) {
            let (x, y) = self.corner(place, 0, row);
            area.draw_text(&value.value.to_string(), &style, (x - 8, y + CELL.1 / 2))?;
        }
        let turned = text(14.0, &TEXT, HPos::Center, VPos::Top).transform(FontTransform::Rotate270);
        area.draw_text(&self.plan.y_label, &turned, (14, place.1 + self.rows() * CELL.1 / 2))
    }

    fn paint_map<DB: DrawingBackend>(
        &self,
        area: &DrawingArea<DB, Shift>,
        place: (i32, i32),
        map: &Map,
    ) -> PaintResult<DB> {
        let (left, top) = place;
        area.draw_text(&map.series, &text(15.0, &TEXT, HPos::Left, VPos::Center), (left, top - 16))?;
        for (row, cells) in (0..).zip(&map.cells) {
            for (column, run) in (0..).zip(cells) {
                self.paint_cell(area, self.corner(place, column, row), run.as_ref())?;
            }
        }
        self.paint_border(area, place, map)?;
        self.paint_columns(area, place)?;
        let middle = left + self.columns() * CELL.0 / 2;
        let style = text(14.0, &TEXT, HPos::Center, VPos::Top);
        area.draw_text(&self.plan.x_label, &style, (middle, top + self.map_height() + 12))
    }

    fn paint_cell<DB: DrawingBackend>(
        &self,
        area: &DrawingArea<DB, Shift>,
        (x, y): (i32, i32),
        run: Option<&Record>,
    ) -> PaintResult<DB> {
        let verdict = run.map(|record| record.verdict);
        area.draw(&Rectangle::new([(x, y), (x + CELL.0 - 1, y + CELL.1 - 1)], color(verdict).filled()))?;
        let fails = verdict == Some(Verdict::Fails);
        let written = match self.plan.measure {
            Some(measure) => run.and_then(measure.of).map(two_digits),
            None => fails.then(|| "×".to_owned()),
        };
        let style = text(13.0, if fails { &WHITE } else { &TEXT }, HPos::Center, VPos::Center);
        written.map_or(Ok(()), |written| area.draw_text(&written, &style, (x + CELL.0 / 2, y + CELL.1 / 2)))
    }

    fn paint_columns<DB: DrawingBackend>(
        &self,
        area: &DrawingArea<DB, Shift>,
        (left, top): (i32, i32),
    ) -> PaintResult<DB> {
        let under = top + self.rows() * CELL.1 + 6;
        for (column, value) in (0..).zip(self.plan.x.values()) {
            let middle = left + column * CELL.0 + CELL.0 / 2;
            let value = value.value.to_string();
            if self.names_stand() {
                let turned = text(12.0, &TEXT, HPos::Right, VPos::Center).transform(FontTransform::Rotate270);
                area.draw_text(&value, &turned, (middle, under))?;
            } else {
                area.draw_text(&value, &text(12.0, &TEXT, HPos::Center, VPos::Top), (middle, under))?;
            }
        }
        Ok(())
    }

    /// Between cells that fail and cells that do not.
    fn paint_border<DB: DrawingBackend>(
        &self,
        area: &DrawingArea<DB, Shift>,
        place: (i32, i32),
        map: &Map,
    ) -> PaintResult<DB> {
        let fails = |row: i32, column: i32| -> Option<bool> {
            let run = map.cells.get(usize::try_from(row).ok()?)?.get(usize::try_from(column).ok()?)?.as_ref()?;
            Some(run.verdict == Verdict::Fails)
        };
        let line = |from: (i32, i32), to: (i32, i32)| PathElement::new(vec![from, to], BLACK.stroke_width(3));
        for row in 0..self.rows() {
            for column in 0..self.columns() {
                let (x, y) = self.corner(place, column, row);
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
        let left = self.left();
        let y = self.bottom() + 48;
        let style = text(14.0, &TEXT, HPos::Left, VPos::Center);
        let kinds = [Verdict::Holds, Verdict::Degrades, Verdict::Fails, Verdict::Unknown];
        for (index, verdict) in (0..).zip(kinds) {
            let x = left + index * 120;
            area.draw(&Rectangle::new([(x, y), (x + 20, y + 16)], color(Some(verdict)).filled()))?;
            area.draw_text(&verdict.to_string(), &style, (x + 28, y + 8))?;
        }
        area.draw_text(&self.plan.about, &text(13.0, &TEXT, HPos::Left, VPos::Center), (left, y + 34))
    }
}

/// As short as a cell needs: `17`, `0.42`, `3e-5`, `0`.
fn two_digits(value: f64) -> String {
    let short = match value.abs() {
        0.0 => return "0".to_owned(),
        size if !(0.0095..1000.0).contains(&size) => return format!("{value:.0e}"),
        size if size < 10.0 => format!("{value:.2}"),
        _ => format!("{value:.0}"),
    };
    match short.trim_end_matches('0').trim_end_matches('.') {
        trimmed if short.contains('.') => trimmed.to_owned(),
        _ => short,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lab::map::ATLAS;

    /// Of names that are longer than their maps are wide, too.
    #[test]
    fn maps_are_as_many_side_by_side_as_there_is_room_for_and_none_covers_another() {
        let plan = ATLAS.iter().find(|map| map.name == "chain").unwrap().plan();
        let names = ["game", "a name that is twice as long as any map can be wide, and then some more of it", "steady"];
        let map = |index: usize| Map { series: names[index % names.len()].to_owned(), cells: Vec::new() };
        for count in 1..8 {
            let maps: Vec<Map> = (0..count).map(map).collect();
            let sheet = Sheet { plan: &plan, maps: &maps };
            let (width, height) = sheet.size();
            let places = sheet.places();
            for (index, (left, top)) in places.iter().enumerate() {
                assert!(left + sheet.map_width(&maps[index]) <= width as i32, "{index} of {count}");
                assert!(top + sheet.map_height() + BELOW <= height as i32, "{index} of {count}");
                for (other, (right, below)) in places.iter().enumerate().skip(index + 1) {
                    let beside = *top == *below && left + sheet.map_width(&maps[index]) < *right;
                    assert!(beside || top + sheet.map_height() + BELOW <= *below, "{index} and {other} of {count}");
                }
            }
            assert!(width as i32 <= MOST_WIDTH + 24);
        }
        let four: Vec<Map> = [0; 4].map(map).into();
        let places = Sheet { plan: &plan, maps: &four }.places();
        let lines: Vec<bool> = places.iter().map(|place| place.1 == TOP).collect();
        assert_eq!(lines, [true, true, true, false]);
    }

    #[test]
    fn numbers_fit_a_cell() {
        let written = [0.0, 0.0098, 9.4e-3, 17.3, 120.0, 0.4219, 0.5, 1.0, 3.2e-5, 12345.0, f64::NAN].map(two_digits);
        assert_eq!(written, ["0", "0.01", "9e-3", "17", "120", "0.42", "0.5", "1", "3e-5", "1e4", "NaN"]);
    }
}
