//! What each kind of joint is drawn as: lines, in the places where its bodies are drawn.
//!
//! A hinge is its axis, with an arc over the angles that it may have and a needle at the one it has; a slider its way,
//! with a carriage; a spring a coil, a slack rope an arch, a fixed joint a cross in a box, the limits of a ball joint a
//! cone. A motor is an arrow the way it drives, or, where it goes for a position, a mark there and an arrow towards it.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use bevy::prelude::*;

use super::any_joint::WholeJointItem;
use super::panel::palette;
use crate::physics::{DistanceLaw, JointAxis, JointMotor, LimitRange, MotorTarget};
use crate::scene::JointComponent;

/// Lines through points, and their color.
pub type Stroke = (Vec<Vec3>, Color);

/// Lines to a half turn.
const ARC: f32 = 24.0;
/// Turns of a coil, and lines to each.
const TURNS: usize = 8;
const PER_TURN: usize = 12;
/// Lines to an arch.
const ARCH: usize = 16;
/// A needle's length in the size of its glyph.
const NEEDLE: f32 = 0.7;
/// Nearer to its target than this, rad or m, a motor has nowhere to go.
const ARRIVED: f64 = 1e-3;

/// A joint in the picture.
pub struct Placed<'a, 'w, 's> {
    pub joint: &'a WholeJointItem<'w, 's>,
    /// Of A and of B.
    pub poses: [Transform; 2],
    /// How large its glyph is, m.
    pub size: f32,
    /// What tells its load.
    pub tint: Color,
    /// Where things fall.
    pub down: Vec3,
    /// Simulation time, s.
    pub time: f64,
}

/// What a motor asks of the coordinate.
#[derive(Clone, Copy)]
enum Drive {
    Rate(f64),
    To(f64),
}

impl Drive {
    fn of(motor: &JointMotor, time: f64) -> Self {
        match motor.target {
            MotorTarget::Speed(rate) => Self::Rate(rate),
            MotorTarget::Position { target, .. } | MotorTarget::Spring { target, .. } => Self::To(target),
            MotorTarget::Motion(motion) => Self::To(motion.at_time(time)[0]),
        }
    }

    /// Forward 1, back −1, or neither, from where the coordinate is.
    fn sign(self, value: f64) -> f32 {
        let (way, least) = match self {
            Self::Rate(rate) => (rate, 0.0),
            Self::To(target) => (target - value, ARRIVED),
        };
        if way.abs() > least { way.signum() as f32 } else { 0.0 }
    }
}

impl Placed<'_, '_, '_> {
    /// The joint's point on A and on B.
    pub fn anchors(&self) -> Option<[Vec3; 2]> {
        let anchors = self.joint.joint.component()?.anchors();
        Some([0, 1].map(|end| self.poses[end].translation + self.poses[end].rotation * anchors[end].as_vec3()))
    }

    /// Its glyph; a ball joint without limits has none.
    pub fn strokes(&self) -> Vec<Stroke> {
        let mut sketch = Sketch { strokes: Vec::new(), size: self.size, tint: self.tint };
        let (Some(component), Some([at_a, at_b])) = (self.joint.joint.component(), self.anchors()) else {
            return sketch.strokes;
        };
        match component {
            JointComponent::Distance(joint) => sketch.distance(joint.length, [at_a, at_b], self.down),
            JointComponent::Fixed(_) => sketch.fixed(at_b, self.frame()),
            _ => self.sketch_axis(&mut sketch, [at_a, at_b]),
        }
        sketch.strokes
    }

    fn frame(&self) -> Quat {
        self.frames().map_or(Quat::IDENTITY, |[a, _]| a)
    }

    fn frames(&self) -> Option<[Quat; 2]> {
        let frames = self.joint.frames(self.poses.map(|pose| pose.rotation.as_dquat().normalize()))?;
        Some(frames.map(|frame| frame.as_quat().normalize()))
    }

    /// What moves along or about an axis.
    fn sketch_axis(&self, sketch: &mut Sketch, [at_a, at_b]: [Vec3; 2]) {
        let (Some(axis), Some([frame_a, frame_b])) = (self.joint.axis(), self.frames()) else { return };
        let poses = self.poses.map(|pose| (pose.translation.as_dvec3(), pose.rotation.as_dquat().normalize()));
        let value = self.joint.value(poses).unwrap_or_default();
        let drive = self.joint.motor.map(|motor| Drive::of(motor, self.time));
        let limits = self.joint.limits.map(|limits| limits.range);
        let bounds = match limits {
            Some(LimitRange::Range { min, max } | LimitRange::SwingTwist { min, max, .. }) => [min, max],
            None => [f64::NEG_INFINITY, f64::INFINITY],
        };
        match (axis, limits) {
            (JointAxis::Twist, _) => {
                let along = frame_a * Vec3::X;
                let out = (self.poses[1].translation - at_b).reject_from_normalized(along);
                // A wheel's centre is on its axis.
                let needle = if out.length() > 0.1 * self.size { out.normalize() } else { frame_b * Vec3::Y };
                let dial = Dial { center: at_b, axis: along, needle };
                sketch.hinge(&dial, value, bounds, drive);
            }
            (JointAxis::Swing, Some(LimitRange::SwingTwist { swing, .. })) => {
                sketch.cone(at_b, [frame_a * Vec3::X, frame_b * Vec3::X], swing as f32);
            }
            (JointAxis::X | JointAxis::Y | JointAxis::Z, _) => {
                let along = [Vec3::X, Vec3::Y, Vec3::Z][axis as usize];
                sketch.slider([at_a, at_b], frame_a, frame_a * along, value, bounds, drive);
            }
            _ => {}
        }
    }
}

/// The plane in which a hinge turns; angles count from the needle, which turns with B.
struct Dial {
    center: Vec3,
    axis: Vec3,
    needle: Vec3,
}

impl Dial {
    fn at(&self, angle: f32, radius: f32) -> Vec3 {
        self.center + Quat::from_axis_angle(self.axis, angle) * self.needle * radius
    }
}

/// A glyph in the making.
struct Sketch {
    strokes: Vec<Stroke>,
    size: f32,
    tint: Color,
}

impl Sketch {
    fn line(&mut self, from: Vec3, to: Vec3) {
        self.strokes.push((vec![from, to], self.tint));
    }

    fn arc(&mut self, dial: &Dial, from: f32, sweep: f32, radius: f32, color: Color) {
        let pieces = (ARC * sweep.abs() / PI).ceil().max(1.0);
        let points = (0..=pieces as usize).map(|i| dial.at(from + sweep * i as f32 / pieces, radius));
        self.strokes.push((points.collect(), color));
    }

    /// A head at that end of a line of a length, in the plane across `normal`.
    fn head(&mut self, tip: Vec3, along: Vec3, normal: Vec3, color: Color, length: f32) {
        let (along, across) = (along.normalize_or_zero(), along.cross(normal).normalize_or_zero());
        let reach = (0.18 * self.size).min(0.6 * length);
        let wing = |side: f32| tip - (along + across * (0.5 * side)) * reach;
        self.strokes.push((vec![wing(1.0), tip, wing(-1.0)], color));
    }

    /// The axis, a needle, the arc of what angles it may have, and an arrow round the axis.
    fn hinge(&mut self, dial: &Dial, value: f64, bounds: [f64; 2], drive: Option<Drive>) {
        let (size, radius) = (self.size, 0.6 * self.size);
        self.line(dial.center - dial.axis * size, dial.center + dial.axis * size);
        self.strokes.push((vec![dial.center, dial.at(0.0, NEEDLE * size)], color(palette::SKY)));
        let offsets = bounds.map(|bound| (bound - value) as f32);
        for offset in offsets.into_iter().filter(|offset| offset.is_finite()) {
            self.line(dial.center, dial.at(offset, radius));
        }
        if offsets.iter().all(|offset| offset.is_finite()) {
            // More than a turn would be drawn twice.
            self.arc(dial, offsets[0], (offsets[1] - offsets[0]).min(TAU), radius, self.tint);
        }
        let Some(drive) = drive else { return };
        let (sign, drives) = (drive.sign(value), color(palette::YELLOW));
        let radius = 0.4 * size;
        let [from, sweep] = match drive {
            Drive::Rate(_) => [-0.75 * PI * sign.signum(), 1.5 * PI * sign.signum()],
            Drive::To(target) => {
                let target = (target - value) as f32;
                // Beyond the needle, which lies there once it has arrived.
                self.strokes.push((vec![dial.at(target, NEEDLE * size), dial.at(target, 0.95 * size)], drives));
                [0.0, target.clamp(-TAU, TAU)]
            }
        };
        self.arc(dial, from, sweep, radius, drives);
        if sign != 0.0 {
            let (tip, behind) = (dial.at(from + sweep, radius), dial.at(from + sweep - FRAC_PI_2 * sign, radius));
            // The tangent: a quarter turn behind, the radius points along it.
            self.head(tip, dial.center - behind, dial.axis, drives, radius * sweep.abs());
        }
    }

    /// The way that it may go, a carriage where it is, and an arrow along the way.
    fn slider(
        &mut self,
        [at_a, at_b]: [Vec3; 2],
        frame: Quat,
        along: Vec3,
        value: f64,
        bounds: [f64; 2],
        drive: Option<Drive>,
    ) {
        let across = along.any_orthonormal_vector();
        let place = |value: f64| at_a + along * value as f32;
        let reach = f64::from(1.5 * self.size);
        let ends = [bounds[0].max(value.min(0.0) - reach), bounds[1].min(value.max(0.0) + reach)];
        self.line(place(ends[0]), place(ends[1]));
        for bound in bounds.into_iter().filter(|bound| bound.is_finite()) {
            let tick = across * 0.25 * self.size;
            self.line(place(bound) - tick, place(bound) + tick);
        }
        self.cube(at_b, frame, 0.16 * self.size);
        let Some(drive) = drive else { return };
        let (sign, drives, beside) = (drive.sign(value), color(palette::YELLOW), across * 0.25 * self.size);
        if let Drive::To(target) = drive {
            self.strokes.push((vec![place(target) - beside, place(target) + beside], drives));
        }
        let tip = match drive {
            Drive::To(target) => place(target) + beside,
            Drive::Rate(_) => at_b + beside + along * (0.9 * sign * self.size),
        };
        if sign != 0.0 {
            self.strokes.push((vec![at_b + beside, tip], drives));
            self.head(tip, along * sign, along.cross(across), drives, tip.distance(at_b + beside));
        }
    }

    /// A cross in a box.
    fn fixed(&mut self, at: Vec3, frame: Quat) {
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            let arm = frame * axis * 0.3 * self.size;
            self.line(at - arm, at + arm);
        }
        self.cube(at, frame, 0.18 * self.size);
    }

    fn cube(&mut self, at: Vec3, frame: Quat, half: f32) {
        let corner = |x: f32, y: f32, z: f32| at + frame * (Vec3::new(x, y, z) * half);
        for z in [-1.0, 1.0] {
            let square = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0)];
            self.strokes.push((square.map(|(x, y)| corner(x, y, z)).to_vec(), self.tint));
        }
        for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            self.line(corner(x, y, -1.0), corner(x, y, 1.0));
        }
    }

    /// The cone that B's axis stays in, and that axis.
    fn cone(&mut self, at: Vec3, [of_a, of_b]: [Vec3; 2], swing: f32) {
        let length = 0.8 * self.size;
        self.strokes.push((vec![at, at + of_b * length], color(palette::SKY)));
        if !swing.is_finite() {
            return;
        }
        let rim = Quat::from_axis_angle(of_a.any_orthonormal_vector(), swing) * of_a;
        let dial = Dial { center: at, axis: of_a, needle: rim };
        self.arc(&dial, 0.0, TAU, length, self.tint);
        for quarter in 0..4 {
            self.line(at, dial.at(FRAC_PI_2 * quarter as f32, length));
        }
    }

    fn distance(&mut self, length: DistanceLaw, [a, b]: [Vec3; 2], down: Vec3) {
        let apart = a.distance(b);
        match length {
            DistanceLaw::Spring { .. } => self.coil(a, b),
            DistanceLaw::Range { min, max } if min < max => {
                let direction = (b - a).normalize_or(Vec3::Y);
                let across = direction.any_orthonormal_vector() * 0.12 * self.size;
                for bound in [min, max].into_iter().filter(|bound| *bound > 0.0 && bound.is_finite()) {
                    let at = a + direction * bound as f32;
                    self.line(at - across, at + across);
                }
                match max as f32 - apart {
                    slack if slack > 0.01 * apart && slack.is_finite() => self.arch([a, b], slack, down),
                    _ => self.line(a, b),
                }
            }
            DistanceLaw::Range { .. } => self.line(a, b),
        }
    }

    /// A rope with so much slack: a parabola of its length hangs √(3/8 · distance · slack) below, as long as that is
    /// little; one doubled up hangs by half its length.
    fn arch(&mut self, [a, b]: [Vec3; 2], slack: f32, down: Vec3) {
        let apart = a.distance(b);
        let sag = (0.375 * apart * slack).sqrt().max(0.5 * slack);
        let point = |i: usize| {
            let share = i as f32 / ARCH as f32;
            a.lerp(b, share) + down * (4.0 * sag * share * (1.0 - share))
        };
        self.strokes.push(((0..=ARCH).map(point).collect(), self.tint));
    }

    fn coil(&mut self, a: Vec3, b: Vec3) {
        let (along, apart) = ((b - a).normalize_or(Vec3::Y), a.distance(b));
        let (across, beside) = along.any_orthonormal_pair();
        let radius = (0.15 * self.size).min(0.3 * apart);
        let last = TURNS * PER_TURN;
        let turn = |i: usize| {
            let (sin, cos) = (TAU * i as f32 / PER_TURN as f32).sin_cos();
            a + along * (apart * (0.1 + 0.8 * i as f32 / last as f32)) + (across * cos + beside * sin) * radius
        };
        let points = std::iter::once(a).chain((0..=last).map(turn)).chain([b]).collect();
        self.strokes.push((points, self.tint));
    }
}

fn color([r, g, b]: [u8; 3]) -> Color {
    Color::srgb_u8(r, g, b)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sketch() -> Sketch {
        Sketch { strokes: Vec::new(), size: 1.0, tint: Color::WHITE }
    }

    fn dial() -> Dial {
        Dial { center: Vec3::ZERO, axis: Vec3::Z, needle: Vec3::X }
    }

    /// The head's tip, and the middle of its wings.
    fn head(strokes: &[Stroke]) -> (Vec3, Vec3) {
        let points = &strokes.last().unwrap().0;
        (points[1], points[0].midpoint(points[2]))
    }

    #[test]
    fn the_arc_of_a_hinge_stays_with_a_while_b_turns() {
        // B stands at 30°, and may go from −15° to 75°: 45° either way.
        let mut sketch = sketch();
        let bounds = [-15.0_f64, 75.0].map(f64::to_radians);
        sketch.hinge(&dial(), 30_f64.to_radians(), bounds, None);
        let arc = &sketch.strokes.last().unwrap().0;
        for (end, angle) in [(arc[0], -PI / 4.0), (arc[arc.len() - 1], PI / 4.0)] {
            let expected = Vec3::new(angle.cos(), angle.sin(), 0.0) * 0.6;
            assert!(end.distance(expected) < 1e-5, "{end} is not {expected}");
        }
    }

    #[test]
    fn the_arrow_of_a_motor_points_the_way_that_it_drives() {
        for speed in [2.0, -2.0] {
            let mut sketch = sketch();
            sketch.hinge(&dial(), 0.0, [f64::NEG_INFINITY, f64::INFINITY], Some(Drive::Rate(speed)));
            let (tip, wings) = head(&sketch.strokes);
            let turns = (tip - wings).dot(Vec3::Z.cross(tip)) * speed as f32;
            assert!(turns > 0.0, "{speed} rad/s: the tip at {tip}, the wings at {wings}");

            let mut sketch = self::sketch();
            let ends = [Vec3::ZERO; 2];
            let bounds = [f64::NEG_INFINITY, f64::INFINITY];
            sketch.slider(ends, Quat::IDENTITY, Vec3::X, 0.0, bounds, Some(Drive::To(speed)));
            let (tip, wings) = head(&sketch.strokes);
            assert!((tip - wings).x * speed as f32 > 0.0);
            assert!((tip.x - speed as f32).abs() < 1e-6, "it ends at the target");
        }
        assert_eq!(Drive::Rate(0.0).sign(1.0), 0.0);
        assert_eq!(Drive::To(1.0).sign(1.0), 0.0);
    }

    #[test]
    fn a_motor_that_has_arrived_is_marked_beyond_the_needle() {
        let mut sketch = sketch();
        sketch.hinge(&dial(), 1.0, [f64::NEG_INFINITY, f64::INFINITY], Some(Drive::To(1.0)));
        let of = |tint: [u8; 3]| sketch.strokes.iter().find(|stroke| stroke.1 == color(tint)).unwrap().0.clone();
        let (needle, mark) = (of(palette::SKY), of(palette::YELLOW));
        assert!(mark[0].distance(needle[1]) < 1e-6, "it begins at {} and the needle ends at {}", mark[0], needle[1]);
        assert!(mark[1].length() > 1.2 * needle[1].length());
    }

    #[test]
    fn the_head_of_a_short_arrow_is_shorter_than_the_arrow() {
        for target in [0.02_f64, -0.3, 2.0] {
            let mut sketch = sketch();
            sketch.hinge(&dial(), 0.0, [f64::NEG_INFINITY, f64::INFINITY], Some(Drive::To(target)));
            let (tip, wings) = head(&sketch.strokes);
            assert!(tip.distance(wings) < 0.4 * target.abs() as f32, "{target} rad");
        }
    }

    #[test]
    fn coils_and_arches_begin_and_end_at_the_anchors() {
        let (a, b) = (Vec3::new(1.0, 2.0, 3.0), Vec3::new(2.0, 2.0, 3.0));
        for length in
            [DistanceLaw::Spring { rest: 1.0, stiffness: 1.0, damping: 0.0 }, DistanceLaw::Range { min: 0.0, max: 1.5 }]
        {
            let mut sketch = sketch();
            sketch.distance(length, [a, b], Vec3::NEG_Y);
            let points = &sketch.strokes.last().unwrap().0;
            assert!(points[0].distance(a) < 1e-6 && points[points.len() - 1].distance(b) < 1e-6, "{length:?}");
        }
    }

    #[test]
    fn a_slack_rope_hangs_about_as_long_as_it_is() {
        let (a, b) = (Vec3::ZERO, Vec3::X);
        let mut sketch = sketch();
        sketch.arch([a, b], 0.1, Vec3::NEG_Y);
        let points = &sketch.strokes[0].0;
        let length: f32 = points.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
        assert!((length - 1.1).abs() < 0.02, "it is drawn {length} m long");
        assert!(points.iter().all(|point| point.y <= 0.0));
    }
}
