//! What one variation does: curves over its values, a panel for each measure.

use std::ops::Range;
use std::path::{Path, PathBuf};

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

use super::measure::Measure;
use super::study::{Candidate, Study};
use super::variation::{Scale, Variation};
use crate::lab::chart::Subject;
use crate::lab::picture::{
    FAINT, PaintResult, Picture, PictureError, TEXT, decades, draw_mark, mark, number, text, ticks, write,
};
use crate::lab::sweep::{Point, Record};
use crate::lab::verdict::Verdict;

/// A study over one variation.
#[derive(Clone, Debug, PartialEq)]
pub struct Curves {
    /// What is run.
    pub study: Study,
    /// What varies along the curves.
    pub x: Variation,
}

/// What came of a candidate.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// The candidate's name.
    pub name: String,
    /// A run for each value; none where nothing was measured.
    pub runs: Vec<Option<Record>>,
}

impl Curves {
    /// The runs, by candidate and value.
    pub fn points(&self) -> Vec<Point> {
        self.study.candidates.iter().flat_map(|candidate| self.points_of(candidate)).collect()
    }

    fn points_of<'a>(&'a self, candidate: &'a Candidate) -> impl Iterator<Item = Point> + 'a {
        self.x.values().iter().map(|value| self.study.point(candidate, &[*value]))
    }

    /// The curves, from the records of [`points`](Self::points).
    pub fn curves(&self, records: &[Record]) -> Vec<Curve> {
        let run = |point: Point| {
            let key = point.key();
            records.iter().find(|record| record.key == key).cloned()
        };
        let curve = |candidate: &Candidate| Curve {
            name: candidate.name.clone(),
            runs: self.points_of(candidate).map(run).collect(),
        };
        self.study.candidates.iter().map(curve).collect()
    }

    /// Draws a panel for each measure and tells the picture's path, `SCENE-by-NAME.svg`; a `.png` lies beside it.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn draw(
        &self,
        records: &[Record],
        measures: &[&'static Measure],
        folder: &Path,
    ) -> Result<PathBuf, PictureError> {
        let Study { scene, parameters, .. } = &self.study;
        let subject = Subject { scene: scene.clone(), parameters: parameters.clone() };
        // A dot in a parameter's value is no extension.
        let stem = subject.stem().replace('.', "_");
        let path = folder.join(format!("{stem}-by-{}{}.svg", self.x.name(), self.study.compared()));
        let sheet = Sheet { title: subject.title(), x: &self.x, curves: &self.curves(records), measures };
        write(&sheet, &path)?;
        Ok(path)
    }
}

struct Sheet<'a> {
    title: String,
    x: &'a Variation,
    curves: &'a [Curve],
    measures: &'a [&'static Measure],
}

const WIDTH: i32 = 860;
const LEFT: i32 = 92;
const TOP: i32 = 46;
const PANEL: i32 = 230;
const GAP: i32 = 26;
/// Room under the last panel for the values and the label.
const BOTTOM: i32 = 62;
/// Of a letter of the legend, on average.
const LETTER: i32 = 8;
/// Of a letter of a value along the axis.
const VALUE_LETTER: i32 = 7;
/// Least distance between two numbers along the axis.
const NUMBERS_APART: i32 = 40;
/// Least distance of two numbers beside an axis.
const LINES_APART: i32 = 14;

impl Picture for Sheet<'_> {
    fn size(&self) -> (u32, u32) {
        let height = TOP + self.measures.len() as i32 * (PANEL + GAP) - GAP + BOTTOM + self.second_line();
        let legend = TOP + 22 * (self.curves.len() as i32 + 2);
        ((WIDTH + self.legend_width()) as u32, height.max(legend) as u32)
    }

    fn paint<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> PaintResult<DB> {
        let title = format!("{} over {}", self.title, self.x.name());
        area.draw_text(&title, &text(19.0, &TEXT, HPos::Left, VPos::Center), (LEFT, TOP / 2))?;
        for (index, measure) in self.measures.iter().enumerate() {
            let top = TOP + index as i32 * (PANEL + GAP);
            Panel { sheet: self, measure, top, range: self.range(measure) }.paint(area)?;
        }
        self.paint_values(area)?;
        self.paint_legend(area)
    }
}

impl Sheet<'_> {
    fn legend_width(&self) -> i32 {
        let longest = self.curves.iter().map(|curve| curve.name.chars().count()).max().unwrap_or(0);
        (longest as i32 * LETTER).max(130) + 30
    }

    /// Where a value of the variation is drawn.
    fn x(&self, index: usize) -> i32 {
        const MARGIN: f64 = 0.04;
        let (first, last) = (self.x.place(0), self.x.place(self.x.values().len() - 1));
        let share = if last > first { (self.x.place(index) - first) / (last - first) } else { 0.5 };
        let share = MARGIN + share * (1.0 - 2.0 * MARGIN);
        LEFT + (share * f64::from(WIDTH - LEFT)).round() as i32
    }

    /// Of the measure, wide enough for all that is positive; what failed does not widen it without limit.
    fn range(&self, measure: &Measure) -> Range<f64> {
        /// A run that failed may be off by so many times as much as the worst that did not.
        const FAILED: f64 = 1e3;
        /// In decades; zeros lie on the border.
        const MARGIN: f64 = 0.2;
        let values = |failed: bool| {
            let runs = self.curves.iter().flat_map(|curve| curve.runs.iter().flatten());
            let of_kind = runs.filter(move |record| (record.verdict > Verdict::Degrades) == failed);
            of_kind.filter_map(measure.of).filter(|value| value.is_finite() && *value > 0.0)
        };
        let worst = values(false).fold(0.0, f64::max);
        let limit = if worst > 0.0 { FAILED * worst } else { f64::INFINITY };
        decades(values(false).chain(values(true).filter(move |value| *value <= limit)), MARGIN)
    }

    fn bottom(&self) -> i32 {
        TOP + self.measures.len() as i32 * (PANEL + GAP) - GAP
    }

    /// The values that are written: of numbers the first, the last, and as many as there is room for; names all.
    fn written(&self) -> Vec<usize> {
        let last = self.x.values().len() - 1;
        if self.x.scale == Scale::InOrder {
            return (0..=last).collect();
        }
        let mut written = vec![0];
        for index in 1..=last {
            let free = self.x(written[written.len() - 1]) + NUMBERS_APART;
            let has_room = index == last || self.x(index) + NUMBERS_APART <= self.x(last);
            if self.x(index) >= free && has_room {
                written.push(index);
            }
        }
        written
    }

    /// Names that do not fit side by side take turns in two lines: how much lower the second is.
    fn second_line(&self) -> i32 {
        const LINE: i32 = 16;
        let longest = self.x.values().iter().map(|value| value.value.to_string().chars().count()).max().unwrap_or(0);
        let apart = (WIDTH - LEFT) / self.x.values().len() as i32;
        if self.x.scale == Scale::InOrder && longest as i32 * VALUE_LETTER > apart { LINE } else { 0 }
    }

    fn paint_values<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> PaintResult<DB> {
        let style = text(13.0, &TEXT, HPos::Center, VPos::Top);
        for (turn, index) in self.written().into_iter().enumerate() {
            let lower = if turn % 2 == 1 { self.second_line() } else { 0 };
            let value = self.x.values()[index].value.to_string();
            area.draw_text(&value, &style, (self.x(index), self.bottom() + 8 + lower))?;
        }
        let place = ((LEFT + WIDTH) / 2, self.bottom() + 32 + self.second_line());
        area.draw_text(self.x.label(), &text(14.0, &TEXT, HPos::Center, VPos::Top), place)
    }

    fn paint_legend<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> PaintResult<DB> {
        let x = WIDTH + 22;
        let style = text(14.0, &TEXT, HPos::Left, VPos::Center);
        let mut y = TOP + 14;
        for (index, curve) in self.curves.iter().enumerate() {
            draw_mark(area, (x, y), mark(index), false)?;
            area.draw_text(&curve.name, &style, (x + 14, y))?;
            y += 22;
        }
        y += 8;
        draw_mark(area, (x, y), (TEXT, mark(0).1), true)?;
        area.draw_text("faint: the run fails", &style, (x + 14, y))
    }
}

/// One measure.
struct Panel<'a> {
    sheet: &'a Sheet<'a>,
    measure: &'a Measure,
    top: i32,
    range: Range<f64>,
}

impl Panel<'_> {
    fn values(&self) -> impl Iterator<Item = f64> {
        let runs = self.sheet.curves.iter().flat_map(|curve| curve.runs.iter().flatten());
        runs.filter_map(self.measure.of)
    }

    /// What is not positive lies on the lower border, what is too large on the upper.
    fn y(&self, value: f64) -> i32 {
        let bottom = self.top + PANEL;
        if value <= 0.0 {
            return bottom;
        }
        let share = (value / self.range.start).ln() / (self.range.end / self.range.start).ln();
        bottom - (share.clamp(0.0, 1.0) * f64::from(PANEL)).round() as i32
    }

    fn paint<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> PaintResult<DB> {
        let line = FAINT.stroke_width(1);
        let bottom = self.top + PANEL;
        for index in 0..self.sheet.x.values().len() {
            let x = self.sheet.x(index);
            area.draw(&PathElement::new(vec![(x, self.top), (x, bottom)], line))?;
        }
        let beside = text(13.0, &TEXT, HPos::Right, VPos::Center);
        let has_zero = self.values().any(|value| value <= 0.0);
        for value in ticks(&self.range) {
            let y = self.y(value);
            area.draw(&PathElement::new(vec![(LEFT, y), (WIDTH, y)], line))?;
            if !has_zero || y + LINES_APART <= bottom {
                area.draw_text(&number(value), &beside, (LEFT - 8, y))?;
            }
        }
        if has_zero {
            area.draw_text("0", &beside, (LEFT - 8, bottom))?;
        }
        area.draw(&Rectangle::new([(LEFT, self.top), (WIDTH, bottom)], TEXT.stroke_width(1)))?;
        let turned = text(14.0, &TEXT, HPos::Center, VPos::Top).transform(FontTransform::Rotate270);
        area.draw_text(&self.label(), &turned, (12, (self.top + bottom) / 2))?;
        let mut drawn = 0;
        for (index, curve) in self.sheet.curves.iter().enumerate() {
            drawn += self.paint_curve(area, index, curve)?;
        }
        if drawn == 0 {
            let style = text(14.0, &TEXT, HPos::Center, VPos::Center);
            area.draw_text("not measured", &style, ((LEFT + WIDTH) / 2, (self.top + bottom) / 2))?;
        }
        Ok(())
    }

    /// With the unit, where it is the scene's.
    fn label(&self) -> String {
        let mut runs = self.sheet.curves.iter().flat_map(|curve| curve.runs.iter().flatten());
        match runs.find(|record| !record.unit.is_empty()) {
            Some(record) if self.measure.name == "error" => format!("{}, {}", self.measure.about, record.unit),
            _ => self.measure.about.to_owned(),
        }
    }

    /// Tells how many points it has.
    fn paint_curve<DB: DrawingBackend>(
        &self,
        area: &DrawingArea<DB, Shift>,
        index: usize,
        curve: &Curve,
    ) -> Result<usize, DrawingAreaErrorKind<DB::ErrorType>> {
        let mark = mark(index);
        let place = |(column, run): (usize, &Option<Record>)| {
            let run = run.as_ref()?;
            let value = (self.measure.of)(run).filter(|value| !value.is_nan())?;
            Some(((self.sheet.x(column), self.y(value)), run.verdict > Verdict::Degrades))
        };
        let places: Vec<_> = curve.runs.iter().enumerate().filter_map(place).collect();
        let line: Vec<(i32, i32)> = places.iter().map(|(place, _)| *place).collect();
        area.draw(&PathElement::new(line, mark.0.mix(0.5).stroke_width(1)))?;
        for &(place, failed) in &places {
            draw_mark(area, place, mark, failed)?;
        }
        Ok(places.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sheet(x: &Variation) -> Sheet<'_> {
        Sheet { title: String::new(), x, curves: &[], measures: &[] }
    }

    #[test]
    fn numbers_along_the_axis_do_not_touch_and_its_ends_are_written() {
        for text in ["baumgarte=0.05:1:lin:20", "iterations=1:1000:log:40", "drag=0,0.1,1,2,3", "hz=60", "slop=0,1"] {
            let x = Variation::parse(text, None).unwrap();
            let sheet = sheet(&x);
            let written = sheet.written();
            let (first, last) = (written[0], written[written.len() - 1]);
            assert_eq!((first, last), (0, x.values().len() - 1), "{text}");
            for pair in written.windows(2) {
                let apart = sheet.x(pair[1]) - sheet.x(pair[0]);
                assert!(apart >= NUMBERS_APART, "{text}: {apart} between {} and {}", pair[0], pair[1]);
            }
        }
    }

    #[test]
    fn long_names_take_turns_in_two_lines() {
        let of = |text: &str| sheet(&Variation::parse(text, None).unwrap()).second_line();
        assert_eq!(of("contacts=extreme_vertices,single_point,clipping"), 0);
        assert_eq!(of("correction_speed=1,2,3,4,5,6,7,None"), 0);
        assert!(of("method=pgs,cg_pgs,nncg,joint_space,soft_step,sequential_impulses,xpbd,exact") > 0);
    }
}
