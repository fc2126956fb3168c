//! A race on one sheet: how far apart, how wrong, how dear, over one axis of time.

use std::ops::Range;
use std::path::Path;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

use super::outcome::{Course, Moment, Outcome, Race};
use crate::lab::picture::{
    FAINT, PaintResult, Picture, PictureError, TEXT, decades, mark, number, round_step, text, ticks, write,
};

const SIZE: (u32, u32) = (1000, 760);
const LEFT: i32 = 92;
const RIGHT: i32 = 270;
const TOP: i32 = 46;
const BOTTOM: i32 = 56;
const BETWEEN: i32 = 26;
/// Smaller values are drawn here: below it nobody sees a difference, and an axis would be of zeros.
const FLOOR: f64 = 1e-12;
/// Decades that a panel shows below its largest value at most.
const MOST_DECADES: f64 = 12.0;

/// Everything on one sheet.
struct Sheet<'a> {
    race: &'a Race,
    outcome: &'a Outcome,
}

impl Outcome {
    /// Draws it to `path` with the extensions `.svg` and `.png`.
    ///
    /// # Errors
    /// The files cannot be written.
    pub fn draw(&self, race: &Race, path: &Path) -> Result<(), PictureError> {
        write(&Sheet { race, outcome: self }, path)
    }
}

/// One quantity over time.
struct Panel {
    label: &'static str,
    of: fn(&Moment) -> f64,
}

const PANELS: [Panel; 3] = [
    Panel { label: "distance, m", of: |moment| moment.distance },
    Panel { label: "overlap or joint gap, m", of: |moment| moment.overlap.max(moment.joint_gap) },
    Panel { label: "cost of a step, ms", of: |moment| moment.ms_per_step },
];

impl Picture for Sheet<'_> {
    fn size(&self) -> (u32, u32) {
        SIZE
    }

    fn paint<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> PaintResult<DB> {
        let Race { scene, from, .. } = self.race;
        let title = format!("{} from {from} s on: distances are from {}", scene.name, self.outcome.base);
        area.draw_text(&title, &text(19.0, &TEXT, HPos::Left, VPos::Center), (LEFT, TOP / 2))?;
        let all = SIZE.1 as i32 - TOP - BOTTOM - BETWEEN * (PANELS.len() as i32 - 1);
        let height = all / PANELS.len() as i32;
        for (place, panel) in (0..).zip(&PANELS) {
            let top = TOP + place * (height + BETWEEN);
            self.paint_panel(area, panel, top..top + height)?;
        }
        let below = text(14.0, &TEXT, HPos::Center, VPos::Top);
        let middle = (LEFT + SIZE.0 as i32 - RIGHT) / 2;
        area.draw_text("time since the race began, s", &below, (middle, SIZE.1 as i32 - BOTTOM + 28))?;
        self.paint_legend(area)
    }
}

impl Sheet<'_> {
    fn x(&self, time: f64) -> i32 {
        let share = (time / self.race.seconds).clamp(0.0, 1.0);
        LEFT + (share * f64::from(SIZE.0 as i32 - RIGHT - LEFT)).round() as i32
    }

    fn paint_panel<DB: DrawingBackend>(
        &self,
        area: &DrawingArea<DB, Shift>,
        panel: &Panel,
        rows: Range<i32>,
    ) -> PaintResult<DB> {
        let right = SIZE.0 as i32 - RIGHT;
        let moments = self.outcome.courses.iter().flat_map(|course| &course.moments);
        let values: Vec<f64> = moments.map(panel.of).filter(|value| *value > FLOOR && value.is_finite()).collect();
        let range = decades(values.into_iter(), 0.1);
        let range = range.start.max(range.end / 10_f64.powf(MOST_DECADES))..range.end;
        let y = |value: f64| {
            let share = (value / range.start).ln() / (range.end / range.start).ln();
            rows.end - (share.clamp(0.0, 1.0) * f64::from(rows.end - rows.start)).round() as i32
        };
        for value in ticks(&range) {
            area.draw(&PathElement::new(vec![(LEFT, y(value)), (right, y(value))], FAINT.stroke_width(1)))?;
            let style = text(12.0, &TEXT, HPos::Right, VPos::Center);
            area.draw_text(&number(value), &style, (LEFT - 8, y(value)))?;
        }
        for time in round_times(self.race.seconds) {
            let x = self.x(time);
            area.draw(&PathElement::new(vec![(x, rows.start), (x, rows.end)], FAINT.stroke_width(1)))?;
            let style = text(12.0, &TEXT, HPos::Center, VPos::Top);
            area.draw_text(&format!("{time}"), &style, (x, rows.end + 5))?;
        }
        for (index, course) in self.outcome.courses.iter().enumerate() {
            let color = mark(index).0;
            let seen = |moment: &&Moment| (panel.of)(moment).is_finite();
            let place = |moment: &Moment| (self.x(moment.time), y((panel.of)(moment).max(range.start)));
            let line: Vec<(i32, i32)> = course.moments.iter().filter(seen).map(place).collect();
            area.draw(&PathElement::new(line, color.stroke_width(2)))?;
            if let Some((time, _)) = course.failed {
                let x = self.x(time);
                area.draw(&PathElement::new(vec![(x, rows.start), (x, rows.end)], color.mix(0.6).stroke_width(1)))?;
                for slope in [1, -1] {
                    let middle = rows.start + 8;
                    let ends = vec![(x - 5, middle - 5 * slope), (x + 5, middle + 5 * slope)];
                    area.draw(&PathElement::new(ends, color.stroke_width(2)))?;
                }
            }
        }
        area.draw(&Rectangle::new([(LEFT, rows.start), (right, rows.end)], TEXT.stroke_width(1)))?;
        let turned = text(13.0, &TEXT, HPos::Center, VPos::Top).transform(FontTransform::Rotate270);
        area.draw_text(panel.label, &turned, (12, (rows.start + rows.end) / 2))
    }

    fn paint_legend<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> PaintResult<DB> {
        let x = SIZE.0 as i32 - RIGHT + 20;
        let mut y = TOP + 12;
        for (index, course) in self.outcome.courses.iter().enumerate() {
            let line = PathElement::new(vec![(x, y), (x + 22, y)], mark(index).0.stroke_width(3));
            area.draw(&line)?;
            area.draw_text(&course.name, &text(15.0, &TEXT, HPos::Left, VPos::Center), (x + 30, y))?;
            for said in self.said(course) {
                y += 18;
                area.draw_text(&said, &text(12.0, &TEXT, HPos::Left, VPos::Center), (x + 30, y))?;
            }
            y += 28;
        }
        Ok(())
    }

    fn said(&self, course: &Course) -> Vec<String> {
        let mut said = Vec::new();
        if let Some(time) = course.parted {
            said.push(format!("{} m apart at {time:.2} s", self.race.apart));
        }
        match &course.failed {
            Some((time, reason)) => said.extend([format!("× fails at {time:.2} s:"), reason.clone()]),
            None => said.push("does not fail".to_owned()),
        }
        said
    }
}

/// Up to some ten round times.
fn round_times(seconds: f64) -> Vec<f64> {
    let step = round_step(seconds / 10.0);
    // One rounding each: 0.3 and not 0.30000000000000004.
    let per = (1.0 / step).round();
    let time = |index: u32| if step < 1.0 { f64::from(index) / per } else { f64::from(index) * step };
    (0..).map(time).take_while(|time| *time <= seconds * (1.0 + 1e-9)).collect()
}

#[cfg(test)]
mod tests {
    use super::round_times;

    #[test]
    fn times_are_round_and_few() {
        assert_eq!(round_times(5.0), [0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0]);
        assert_eq!(round_times(20.0).len(), 11);
        assert_eq!(round_times(0.3).last(), Some(&0.3));
    }
}
