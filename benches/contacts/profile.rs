//! The performance profile (Dolan & Moré 2002): of each solver, the share of problems that it solves within so many times the
//! time of the one that is fastest there.

use std::path::Path;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

use crate::picture::{FAINT, PaintResult, Picture, PictureError, TEXT, draw_mark, mark, number, text, ticks, write};
use crate::table::MEDIAN_OF;
use crate::watch::WANTED;
use crate::{Solver, Timed};

const SIZE: (u32, u32) = (860, 460);
const LEFT: i32 = 76;
const RIGHT: i32 = 210;
const TOP: i32 = 46;
const BOTTOM: i32 = 56;

/// Draws it to `path` with the extensions `.svg` and `.png`.
pub fn draw(timed: &[Timed], path: &Path) -> Result<(), PictureError> {
    let best = |timed: &Timed| timed.seen.iter().filter_map(|seen| seen.times[MEDIAN_OF]).fold(f64::INFINITY, f64::min);
    let ratios = |solver: usize| {
        let of = |timed: &Timed| Some(timed.seen[solver].times[MEDIAN_OF]? / best(timed));
        let mut ratios: Vec<f64> = timed.iter().filter_map(of).collect();
        ratios.sort_by(f64::total_cmp);
        ratios
    };
    let curves: Vec<Vec<f64>> = (0..Solver::ALL.len()).map(ratios).collect();
    let last = curves.iter().flatten().fold(10.0, |most: f64, ratio| most.max(*ratio));
    write(&Profile { curves, count: timed.len(), last }, path)
}

struct Profile {
    /// Of each solver, in the order of [`Solver::ALL`], its times over the best of those it solved, ascending.
    curves: Vec<Vec<f64>>,
    /// Problems.
    count: usize,
    /// The largest ratio.
    last: f64,
}

impl Profile {
    fn at(&self, ratio: f64, share: f64) -> (i32, i32) {
        let (right, bottom) = (SIZE.0 as i32 - RIGHT, SIZE.1 as i32 - BOTTOM);
        let along = ratio.ln() / self.last.ln();
        let x = f64::from(LEFT) + along * f64::from(right - LEFT);
        (x as i32, (f64::from(bottom) - share * f64::from(bottom - TOP)) as i32)
    }
}

impl Picture for Profile {
    fn size(&self) -> (u32, u32) {
        SIZE
    }

    fn paint<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> PaintResult<DB> {
        let title = format!("{} contact problems solved to {:e} m/s", self.count, WANTED[MEDIAN_OF]);
        area.draw_text(&title, &text(18.0, &TEXT, HPos::Left, VPos::Top), (LEFT, 14))?;
        for tick in ticks(&(1.0..self.last * 1.001)) {
            let ends = [0.0, 1.0].map(|share| self.at(tick, share));
            area.draw(&PathElement::new(ends.to_vec(), FAINT))?;
            let (x, y) = ends[0];
            area.draw_text(&number(tick), &text(13.0, &TEXT, HPos::Center, VPos::Top), (x, y + 8))?;
        }
        for fifth in 0..=5 {
            let share = f64::from(fifth) / 5.0;
            let ends = [1.0, self.last].map(|ratio| self.at(ratio, share));
            area.draw(&PathElement::new(ends.to_vec(), FAINT))?;
            let (x, y) = ends[0];
            area.draw_text(&format!("{} %", 20 * fifth), &text(13.0, &TEXT, HPos::Right, VPos::Center), (x - 8, y))?;
        }
        let below = text(13.0, &TEXT, HPos::Center, VPos::Bottom);
        let (middle, _) = self.at(self.last.sqrt(), 0.0);
        area.draw_text("time over that of the fastest on the problem, at most", &below, (middle, SIZE.1 as i32 - 8))?;
        for (index, (curve, solver)) in self.curves.iter().zip(Solver::ALL).enumerate() {
            let (color, _) = mark(index);
            let share = |solved: usize| solved as f64 / self.count as f64;
            let mut steps = vec![self.at(1.0, 0.0)];
            for (solved, ratio) in curve.iter().enumerate() {
                steps.extend([self.at(*ratio, share(solved)), self.at(*ratio, share(solved + 1))]);
            }
            let end = self.at(self.last, share(curve.len()));
            steps.push(end);
            area.draw(&PathElement::new(steps, color.stroke_width(2)))?;
            draw_mark(area, end, mark(index), false)?;
            let y = TOP + 12 + 28 * index as i32;
            let x = SIZE.0 as i32 - RIGHT + 24;
            area.draw(&PathElement::new(vec![(x, y), (x + 22, y)], color.stroke_width(2)))?;
            draw_mark(area, (x + 11, y), mark(index), false)?;
            area.draw_text(solver.name(), &text(14.0, &TEXT, HPos::Left, VPos::Center), (x + 32, y))?;
        }
        Ok(())
    }
}
