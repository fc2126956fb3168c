//! One work–precision chart.

use std::ops::Range;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

use super::pareto::front;
use crate::lab::picture::{FAINT, PaintResult, Picture, TEXT, decades, draw_mark, mark, number, text, ticks};

/// Everything on one chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// Over the picture.
    pub title: String,
    /// What the error is, with its unit.
    pub error_label: String,
    /// No error is known better than this: smaller ones are drawn here.
    pub floor: f64,
    /// Curves in the order of the legend.
    pub curves: Vec<Curve>,
}

/// The points of one method.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// In the legend.
    pub name: String,
    /// Its colour and mark, an index into the marks of all pictures.
    pub mark: usize,
    /// Measured points.
    pub dots: Vec<Dot>,
}

/// One measured point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dot {
    /// Wall-clock time for a simulated second, ms.
    pub cost: f64,
    /// Distance from the answer.
    pub error: f64,
    /// Whether the run held up; others are drawn faint and are no part of a front.
    pub holds: bool,
}

const SIZE: (u32, u32) = (960, 560);
const LEFT: i32 = 92;
const RIGHT: i32 = 230;
const TOP: i32 = 46;
const BOTTOM: i32 = 62;

impl Chart {
    /// Costs and errors of the points that held up, no error below the floor.
    fn held(&self) -> Vec<(f64, f64)> {
        let dots = self.curves.iter().flat_map(|curve| &curve.dots).filter(|dot| dot.holds);
        dots.map(|dot| (dot.cost, dot.error.max(self.floor))).collect()
    }
}

impl Picture for Chart {
    fn size(&self) -> (u32, u32) {
        SIZE
    }

    fn paint<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> PaintResult<DB> {
        let axes = Axes::of(self);
        area.draw_text(&self.title, &text(19.0, &TEXT, HPos::Left, VPos::Center), (LEFT, TOP / 2))?;
        axes.paint(area, &self.error_label)?;
        if self.floor > axes.error.start {
            let y = axes.y(self.floor);
            let line = PathElement::new(vec![(axes.left, y), (axes.right, y)], TEXT.mix(0.5).stroke_width(1));
            area.draw(&line)?;
            // At the cheap end: what comes down to the line is dear as a rule.
            let style = text(12.0, &TEXT, HPos::Left, VPos::Bottom);
            area.draw_text("the answer's own uncertainty", &style, (axes.left + 4, y - 2))?;
        }
        self.paint_front(area, &axes)?;
        for curve in &self.curves {
            self.paint_curve(area, &axes, curve)?;
        }
        self.paint_legend(area)
    }
}

impl Chart {
    /// The front: a step along cost and error, as nothing lies below it, and rings on its points.
    fn paint_front<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>, axes: &Axes) -> PaintResult<DB> {
        let held = self.held();
        let corners: Vec<(i32, i32)> = front(&held).into_iter().map(|index| axes.at(held[index])).collect();
        let mut steps = Vec::new();
        for (index, &(x, y)) in corners.iter().enumerate() {
            if index > 0 {
                steps.push((x, corners[index - 1].1));
            }
            steps.push((x, y));
        }
        area.draw(&PathElement::new(steps, BLACK.mix(0.55).stroke_width(2)))?;
        corners.into_iter().try_for_each(|corner| area.draw(&Circle::new(corner, 8, BLACK.mix(0.55).stroke_width(1))))
    }

    /// The points of a method and, through what none of its own points beats, a line.
    fn paint_curve<DB: DrawingBackend>(
        &self,
        area: &DrawingArea<DB, Shift>,
        axes: &Axes,
        curve: &Curve,
    ) -> PaintResult<DB> {
        let mark = mark(curve.mark);
        let place = |dot: &Dot| (dot.cost, dot.error.max(self.floor));
        let held: Vec<(f64, f64)> = curve.dots.iter().filter(|dot| dot.holds).map(place).collect();
        let line: Vec<(i32, i32)> = front(&held).into_iter().map(|index| axes.at(held[index])).collect();
        area.draw(&PathElement::new(line, mark.0.mix(0.6).stroke_width(1)))?;
        let drawable = |dot: &&Dot| dot.cost > 0.0 && dot.cost.is_finite() && dot.error.is_finite();
        curve.dots.iter().filter(drawable).try_for_each(|dot| draw_mark(area, axes.at(place(dot)), mark, !dot.holds))
    }

    fn paint_legend<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> PaintResult<DB> {
        let x = SIZE.0 as i32 - RIGHT + 26;
        let style = text(14.0, &TEXT, HPos::Left, VPos::Center);
        let mut y = TOP + 14;
        for curve in &self.curves {
            draw_mark(area, (x, y), mark(curve.mark), false)?;
            area.draw_text(&curve.name, &style, (x + 14, y))?;
            y += 22;
        }
        y += 10;
        area.draw(&Circle::new((x, y), 8, BLACK.mix(0.55).stroke_width(1)))?;
        area.draw_text("front: nothing is cheaper", &style, (x + 14, y))?;
        area.draw_text("and nearer to the answer", &style, (x + 14, y + 18))?;
        y += 46;
        let (_, shape) = mark(0);
        draw_mark(area, (x, y), (TEXT, shape), true)?;
        area.draw_text("faint: the run fails", &style, (x + 14, y))
    }
}

/// Two logarithmic axes.
struct Axes {
    cost: Range<f64>,
    error: Range<f64>,
    left: i32,
    right: i32,
    top: i32,
    bottom: i32,
}

impl Axes {
    /// Wide enough for every point; failed runs may lie far off and do not widen it by more than
    /// a decade.
    fn of(chart: &Chart) -> Self {
        let held = chart.held();
        let dots = || chart.curves.iter().flat_map(|curve| &curve.dots);
        let errors: Vec<f64> = if held.is_empty() {
            dots().map(|dot| dot.error.max(chart.floor)).collect()
        } else {
            held.iter().map(|point| point.1).collect()
        };
        Self {
            cost: decades(dots().map(|dot| dot.cost), 0.15),
            error: decades(errors.into_iter(), 0.35),
            left: LEFT,
            right: SIZE.0 as i32 - RIGHT,
            top: TOP,
            bottom: SIZE.1 as i32 - BOTTOM,
        }
    }

    fn x(&self, cost: f64) -> i32 {
        let share = (cost / self.cost.start).ln() / (self.cost.end / self.cost.start).ln();
        self.left + (share.clamp(0.0, 1.0) * f64::from(self.right - self.left)).round() as i32
    }

    /// Errors beyond the range are drawn on its border.
    fn y(&self, error: f64) -> i32 {
        let share = (error / self.error.start).ln() / (self.error.end / self.error.start).ln();
        self.bottom - (share.clamp(0.0, 1.0) * f64::from(self.bottom - self.top)).round() as i32
    }

    fn at(&self, (cost, error): (f64, f64)) -> (i32, i32) {
        (self.x(cost), self.y(error))
    }

    fn paint<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>, error_label: &str) -> PaintResult<DB> {
        let line = FAINT.stroke_width(1);
        for cost in ticks(&self.cost) {
            let x = self.x(cost);
            area.draw(&PathElement::new(vec![(x, self.top), (x, self.bottom)], line))?;
            let style = text(13.0, &TEXT, HPos::Center, VPos::Top);
            area.draw_text(&number(cost), &style, (x, self.bottom + 8))?;
        }
        for error in ticks(&self.error) {
            let y = self.y(error);
            area.draw(&PathElement::new(vec![(self.left, y), (self.right, y)], line))?;
            let style = text(13.0, &TEXT, HPos::Right, VPos::Center);
            area.draw_text(&number(error), &style, (self.left - 8, y))?;
        }
        let frame = [(self.left, self.top), (self.right, self.bottom)];
        area.draw(&Rectangle::new(frame, TEXT.stroke_width(1)))?;
        let middle = (self.left + self.right) / 2;
        let below = text(14.0, &TEXT, HPos::Center, VPos::Top);
        area.draw_text("cost: wall-clock time for a simulated second, ms", &below, (middle, self.bottom + 32))?;
        let turned = text(14.0, &TEXT, HPos::Center, VPos::Top).transform(FontTransform::Rotate270);
        area.draw_text(error_label, &turned, (12, (self.top + self.bottom) / 2))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_hold_what_held_and_number_it() {
        let dot = |cost, error, holds| Dot { cost, error, holds };
        let curve = |dots| Curve { name: String::new(), mark: 0, dots };
        let chart = Chart {
            title: String::new(),
            error_label: String::new(),
            floor: 1e-9,
            curves: vec![curve(vec![dot(0.5, 1e-3, true), dot(80.0, 0.0, true), dot(2.0, 1e30, false)])],
        };
        let axes = Axes::of(&chart);
        assert!(axes.error.contains(&1e-9) && axes.error.contains(&1e-3) && axes.error.end < 1e-2);
        assert!(axes.x(0.5) > axes.left && axes.x(80.0) < axes.right && axes.x(0.5) < axes.x(80.0));
        assert!(axes.y(1e-9) > axes.y(1e-3) && axes.y(1e30) == axes.top);
    }
}
