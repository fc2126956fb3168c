//! One joint's limits, motor, friction and strength, to be changed while it works.
//!
//! Angles are shown in degrees, and kept in rad.

use std::f64::consts::{FRAC_PI_4, PI, TAU};
use std::ops::RangeInclusive;

use bevy_egui::egui;

use super::super::JointChange;
use super::super::any_joint::WholeJointItem;
use super::super::motor_keys::short_name;
use super::entry::{number, refuse};
use super::theme::{Quantity, without_negative_zero};
use crate::physics::{
    Breakable, DistanceLaw, JointAxes, JointAxis, JointFriction, JointLimits, JointMotor, LimitRange, MotorTarget,
    Softness, StepStats,
};
use crate::scene::{JointComponent, MotorKeys};

/// The width that labels before sliders have.
const LABEL: f32 = 58.0;

/// What a new motor gives at most, N or N·m: it moves a limb, and tears at nothing.
const NEW_FORCE: f64 = 100.0;
/// What a new strength is, and the most that a new spring gives, N.
const NEW_STRENGTH: f64 = 1000.0;
/// How far new limits let a joint go either way, rad or m.
const NEW_ANGLE: f64 = FRAC_PI_4;
const NEW_DISTANCE: f64 = 0.5;

/// How the coordinate of a joint is shown.
#[derive(Clone, Copy)]
struct Unit {
    /// What a value is multiplied with.
    factor: f64,
    value: &'static str,
    rate: &'static str,
    force: &'static str,
    stiffness: &'static str,
    damping: &'static str,
    /// How far sliders for values go either way, as shown.
    reach: f64,
}

const DEGREES: Unit = Unit {
    factor: 180.0 / PI,
    value: "°",
    rate: " rad/s",
    force: " N·m",
    stiffness: " N·m/rad",
    damping: " N·m·s/rad",
    reach: 360.0,
};
const METERS: Unit =
    Unit { factor: 1.0, value: " m", rate: " m/s", force: " N", stiffness: " N/m", damping: " N·s/m", reach: 10.0 };

impl Unit {
    fn of(axis: Option<JointAxis>) -> Self {
        if axis.is_some_and(JointAxis::is_angle) { DEGREES } else { METERS }
    }
}

/// The numbers of a joint that stands at that coordinate after the last step, and what shall change.
pub(super) fn show(
    ui: &mut egui::Ui,
    joint: &WholeJointItem,
    value: Option<f64>,
    stats: &StepStats,
) -> Option<JointChange> {
    let component = joint.joint.component()?;
    let unit = Unit::of(joint.axis());
    coordinate(ui, joint, value, unit);
    load(ui, joint, stats);
    let is_ball = matches!(component, JointComponent::Ball(_));
    let has_range = joint.axis().is_some() && !is_ball;
    let mut change = None;
    let mut take = |asked: Option<JointChange>| change = change.take().or(asked);
    match component {
        JointComponent::Distance(joint) => take(length(ui, joint.length)),
        JointComponent::Ball(joint) => take(softness(ui, joint.softness)),
        _ => {}
    }
    if has_range {
        let stands_at = value.unwrap_or_default();
        take(limits(ui, joint.limits.copied(), stands_at, unit));
        take(motor(ui, joint, stands_at, unit));
    }
    if is_ball {
        take(swing_twist(ui, joint.limits.copied()));
    }
    if has_range || is_ball {
        take(friction(ui, joint.friction.copied(), if is_ball { DEGREES } else { unit }));
    }
    take(strength(ui, joint.breakable.copied()));
    if joint.broken.is_some() && ui.small_button("mend").on_hover_text("let it hold again what it held").clicked() {
        change = Some(JointChange::Broken(None));
    }
    change
}

/// Where it stands, and how fast that changes.
fn coordinate(ui: &mut egui::Ui, joint: &WholeJointItem, value: Option<f64>, unit: Unit) {
    if let Some(value) = value {
        let rate = joint.coordinate.map(|coordinate| format!("  {}{}", decimals(coordinate.rate), unit.rate));
        let what = if matches!(joint.axis(), Some(JointAxis::Swing)) { "swing" } else { "stands at" };
        ui.monospace(format!("{what} {}{}{}", decimals(value * unit.factor), unit.value, rate.unwrap_or_default()));
    }
}

fn decimals(value: f64) -> String {
    without_negative_zero(format!("{value:.3}"))
}

/// What it carries.
fn load(ui: &mut egui::Ui, joint: &WholeJointItem, stats: &StepStats) {
    ui.monospace(load_text(joint, stats))
        .on_hover_text("force and torque about its point in the last step, and the share of its strength");
}

fn load_text(joint: &WholeJointItem, stats: &StepStats) -> String {
    if joint.broken.is_some() {
        return "broken".to_owned();
    }
    let Some(load) = joint.known_load(stats) else { return "carries: the next step tells".to_owned() };
    let (force, torque) = (load.force.length(), load.torque.length());
    let mut text = format!("carries {}", Quantity::text(force, "N"));
    if torque > 0.0 {
        text += &format!(", {}", Quantity::text(torque, "N·m"));
    }
    if let Some(strength) = joint.breakable {
        text += &format!("  {:.0} %", 100.0 * (force / strength.force).max(torque / strength.torque));
    }
    text
}

/// A number, how it is shown and what it may be.
#[derive(Clone)]
struct Number {
    suffix: &'static str,
    /// What it is multiplied with to be shown.
    factor: f64,
    /// Where the slider goes, as shown; more can be typed.
    slider: RangeInclusive<f64>,
    /// What may be typed, not multiplied.
    limits: RangeInclusive<f64>,
    /// Whether the slider spans decades.
    logarithmic: bool,
}

impl Number {
    /// Any value of a joint's coordinate; the slider goes about the turn in which the joint stands.
    fn value(unit: Unit, stands_at: f64) -> Self {
        let turn = if unit.factor == 1.0 { 0.0 } else { (stands_at / TAU).round() * 360.0 };
        let slider = turn - unit.reach..=turn + unit.reach;
        let limits = f64::NEG_INFINITY..=f64::INFINITY;
        Self { suffix: unit.value, factor: unit.factor, slider, limits, logarithmic: unit.factor == 1.0 }
    }

    /// Any rate of a joint's coordinate.
    fn rate(unit: Unit) -> Self {
        Self { suffix: unit.rate, factor: 1.0, slider: -100.0..=100.0, logarithmic: true, ..Self::value(unit, 0.0) }
    }

    /// What is 0 or more, by decades.
    fn amount(suffix: &'static str, most: f64) -> Self {
        Self { suffix, factor: 1.0, slider: 0.0..=most, limits: 0.0..=f64::INFINITY, logarithmic: true }
    }

    /// What is more than 0, by decades.
    fn positive(suffix: &'static str, slider: RangeInclusive<f64>) -> Self {
        Self { slider, limits: 1e-9..=f64::INFINITY, ..Self::amount(suffix, 1.0) }
    }

    fn share(most: f64, limit: f64) -> Self {
        Self { slider: 0.0..=most, limits: 0.0..=limit, logarithmic: false, ..Self::amount("", most) }
    }

    fn within(self, limits: RangeInclusive<f64>) -> Self {
        Self { limits, ..self }
    }

    /// Its slider; tells whether it was changed.
    fn show(self, ui: &mut egui::Ui, value: &mut f64) -> bool {
        let mut shown = *value * self.factor;
        let (context, suffix) = (ui.ctx().clone(), self.suffix);
        let slider = egui::Slider::new(&mut shown, self.slider)
            .suffix(self.suffix)
            .logarithmic(self.logarithmic)
            .smallest_positive(0.01)
            .clamping(egui::SliderClamping::Never)
            .update_while_editing(false)
            .custom_parser(move |text| number(&context, text, suffix))
            .max_decimals(3);
        let changed = ui.add(slider).changed();
        if changed {
            let asked = shown / self.factor;
            *value = asked.max(*self.limits.start()).min(*self.limits.end());
            // A slider that is dragged beyond a limit stops there, and no more need be said.
            if *value != asked && !ui.input(|input| input.pointer.any_down()) {
                let [asked, taken] = [shown, *value * self.factor].map(|number| (number * 1e6).round() / 1e6);
                refuse(ui.ctx(), format!("{asked}{suffix} is out of range: {taken}{suffix} is taken"));
            }
        }
        changed
    }
}

/// A line with a label; tells whether its contents were changed.
fn line(ui: &mut egui::Ui, label: &str, about: &str, contents: impl FnOnce(&mut egui::Ui) -> bool) -> bool {
    let line = |ui: &mut egui::Ui| {
        let layout = egui::Layout::left_to_right(egui::Align::Center);
        ui.allocate_ui_with_layout(egui::vec2(LABEL, ui.spacing().interact_size.y), layout, |ui| {
            ui.set_min_width(LABEL);
            let label = ui.label(label);
            if !about.is_empty() {
                label.on_hover_text(about);
            }
        });
        contents(ui)
    };
    ui.horizontal(line).inner
}

/// A bound that may be infinite: a box that is ticked where it is not.
fn bound(ui: &mut egui::Ui, label: &str, value: &mut f64, new: f64, suffix: &'static str) -> bool {
    line(ui, label, "", |ui| {
        let mut bounded = value.is_finite();
        let mut changed = ui.checkbox(&mut bounded, "").on_hover_text("without it, any").changed();
        if changed {
            *value = if bounded { new } else { f64::INFINITY };
        }
        if bounded {
            ui.spacing_mut().slider_width -= 24.0;
            changed |= Number::positive(suffix, 0.01..=1e6).show(ui, value);
        } else {
            ui.weak("any");
        }
        changed
    })
}

/// A box with a label, and, where it is ticked, below it what it stands for. `new` is what ticking it makes.
fn part<T: Copy>(
    ui: &mut egui::Ui,
    label: &str,
    about: &str,
    part: Option<T>,
    new: T,
    contents: impl FnOnce(&mut egui::Ui, &mut T) -> bool,
) -> Option<Option<T>> {
    let mut is_there = part.is_some();
    let ticked = ui.checkbox(&mut is_there, label).on_hover_text(about).changed();
    let mut edited = part.unwrap_or(new);
    let changed = is_there && ui.indent(label, |ui| contents(ui, &mut edited)).inner;
    (ticked || changed).then_some(is_there.then_some(edited))
}

fn limits(ui: &mut egui::Ui, limits: Option<JointLimits>, center: f64, unit: Unit) -> Option<JointChange> {
    let reach = if unit.factor == 1.0 { NEW_DISTANCE } else { NEW_ANGLE };
    let new = JointLimits::range(center - reach, center + reach);
    let edited = part(ui, "limits", "how far it may go", limits, new, |ui, limits| {
        let LimitRange::Range { min, max } = &mut limits.range else { return false };
        let (least, most) = (*min, *max);
        let low = Number::value(unit, center).within(f64::NEG_INFINITY..=most);
        let high = Number::value(unit, center).within(least..=f64::INFINITY);
        let back = "share of its speed that it goes back with";
        line(ui, "from", "", |ui| low.show(ui, min))
            | line(ui, "to", "", |ui| high.show(ui, max))
            | line(ui, "bounce", back, |ui| Number::share(1.0, 1.0).show(ui, &mut limits.restitution))
    })?;
    Some(JointChange::Limits(edited))
}

fn swing_twist(ui: &mut egui::Ui, limits: Option<JointLimits>) -> Option<JointChange> {
    let new = JointLimits::swing_twist(FRAC_PI_4, [-FRAC_PI_4, FRAC_PI_4], JointAxes::World(bevy::math::DVec3::X));
    let about = "how far it may swing and twist; new ones are about the world's x";
    let edited = part(ui, "limits", about, limits, new, |ui, limits| {
        let LimitRange::SwingTwist { swing, min, max, .. } = &mut limits.range else { return false };
        let within = 0.999 * PI;
        let (least, most) = (*min, *max);
        let angle = |limits| Number { slider: -180.0..=180.0, ..Number::value(DEGREES, 0.0).within(limits) };
        let swings = Number { slider: 0.0..=180.0, ..angle(0.001..=within) };
        line(ui, "swing", "", |ui| swings.show(ui, swing))
            | line(ui, "twist from", "", |ui| angle(-within..=most).show(ui, min))
            | line(ui, "to", "", |ui| angle(least..=within).show(ui, max))
    })?;
    Some(JointChange::Limits(edited))
}

fn motor(ui: &mut egui::Ui, joint: &WholeJointItem, value: f64, unit: Unit) -> Option<JointChange> {
    let mut keys_changed = None;
    let new = JointMotor::new(MotorTarget::Speed(1.0)).with_max_force(NEW_FORCE);
    let edited = part(ui, "motor", "drives it", joint.motor.copied(), new, |ui, motor| {
        let kind = ui.horizontal(|ui| target_kind(ui, &mut motor.target, value)).inner;
        let target = match joint.keys {
            Some(keys) if motor.target.value().is_some() => {
                keys_changed = key_targets(ui, keys, &motor.target, unit, value);
                false
            }
            _ => target_value(ui, &mut motor.target, unit, value),
        };
        let spring = target_spring(ui, &mut motor.target, unit);
        kind | target | spring | bound(ui, "at most", &mut motor.max_force, NEW_FORCE, unit.force)
    });
    let keys_changed = keys_changed.map(|keys| JointChange::Keys(Some(keys)));
    edited.map(JointChange::Motor).or(keys_changed)
}

/// Whether it goes for a speed or for a position.
fn target_kind(ui: &mut egui::Ui, target: &mut MotorTarget, value: f64) -> bool {
    let before = *target;
    let to_position = MotorTarget::Position { target: value, frequency: 2.0, damping_ratio: 1.0 };
    for (label, new) in [("speed", MotorTarget::Speed(0.0)), ("position", to_position)] {
        let chosen = std::mem::discriminant(&new) == std::mem::discriminant(target);
        if ui.selectable_label(chosen, label).clicked() && !chosen {
            *target = new;
        }
    }
    match target {
        MotorTarget::Spring { .. } => _ = ui.weak("spring"),
        MotorTarget::Motion(_) => _ = ui.weak("prescribed in time"),
        MotorTarget::Speed(_) | MotorTarget::Position { .. } => {}
    }
    *target != before
}

fn target_value(ui: &mut egui::Ui, target: &mut MotorTarget, unit: Unit, stands_at: f64) -> bool {
    match target {
        MotorTarget::Speed(rate) => line(ui, "speed", "", |ui| Number::rate(unit).show(ui, rate)),
        MotorTarget::Position { target, .. } | MotorTarget::Spring { target, .. } => {
            line(ui, "target", "", |ui| Number::value(unit, stands_at).show(ui, target))
        }
        MotorTarget::Motion(_) => false,
    }
}

/// How hard it goes for a position.
fn target_spring(ui: &mut egui::Ui, target: &mut MotorTarget, unit: Unit) -> bool {
    match target {
        MotorTarget::Position { frequency, damping_ratio, .. } => hardness(ui, frequency, damping_ratio),
        MotorTarget::Spring { stiffness, damping, .. } => {
            stiffness_and_damping(ui, stiffness, damping, [unit.stiffness, unit.damping])
        }
        MotorTarget::Speed(_) | MotorTarget::Motion(_) => false,
    }
}

fn hardness(ui: &mut egui::Ui, frequency: &mut f64, damping_ratio: &mut f64) -> bool {
    line(ui, "frequency", "", |ui| Number::positive(" Hz", 0.1..=100.0).show(ui, frequency))
        | line(ui, "damping", "damping ratio: 1 is critical", |ui| {
            Number::share(2.0, f64::INFINITY).show(ui, damping_ratio)
        })
}

fn stiffness_and_damping(ui: &mut egui::Ui, stiffness: &mut f64, damping: &mut f64, units: [&'static str; 2]) -> bool {
    line(ui, "stiffness", "", |ui| Number::amount(units[0], 1e6).show(ui, stiffness))
        | line(ui, "damping", "", |ui| Number::amount(units[1], 1e5).show(ui, damping))
}

/// What the target is while each key is held, and while none is.
fn key_targets(
    ui: &mut egui::Ui,
    keys: &MotorKeys,
    target: &MotorTarget,
    unit: Unit,
    stands_at: f64,
) -> Option<MotorKeys> {
    let mut edited = keys.clone();
    let [forward, back] = keys.keys.clone();
    let mut changed = false;
    let values = edited.values.iter_mut().chain([&mut edited.rest]);
    for (name, value) in [forward.as_str(), back.as_str(), "no key"].into_iter().zip(values) {
        let number = match target {
            MotorTarget::Speed(_) => Number::rate(unit),
            _ => Number::value(unit, stands_at),
        };
        changed |= line(ui, short_name(name), "its target while this key is held", |ui| number.show(ui, value));
    }
    changed.then_some(edited)
}

fn friction(ui: &mut egui::Ui, friction: Option<JointFriction>, unit: Unit) -> Option<JointChange> {
    let about = "dry friction against its motion";
    let edited = part(ui, "friction", about, friction, JointFriction(1.0), |ui, friction| {
        line(ui, "at most", "", |ui| Number::amount(unit.force, 1e5).show(ui, &mut friction.0))
    })?;
    Some(JointChange::Friction(edited))
}

fn strength(ui: &mut egui::Ui, breakable: Option<Breakable>) -> Option<JointChange> {
    let about = "the force and the torque that it bears before it breaks";
    let new = Breakable::at_force(NEW_STRENGTH);
    let edited = part(ui, "breaks", about, breakable, new, |ui, breakable| {
        bound(ui, "force", &mut breakable.force, NEW_STRENGTH, " N")
            | bound(ui, "torque", &mut breakable.torque, NEW_STRENGTH, " N·m")
    })?;
    Some(JointChange::Strength(edited))
}

fn length(ui: &mut egui::Ui, law: DistanceLaw) -> Option<JointChange> {
    let mut edited = law;
    let meters = || Number { slider: 0.01..=METERS.reach, ..Number::positive(METERS.value, 0.0..=1.0) };
    let from_nothing = |most| Number { slider: 0.0..=METERS.reach, ..meters().within(0.0..=most) };
    match &mut edited {
        DistanceLaw::Range { min, max } if *min == *max => {
            if line(ui, "length", "", |ui| meters().show(ui, min)) {
                *max = *min;
            }
        }
        DistanceLaw::Range { min, max } => {
            let (least, most) = (min.max(1e-9), *max);
            line(ui, "at least", "", |ui| from_nothing(most).show(ui, min));
            line(ui, "at most", "", |ui| meters().within(least..=f64::INFINITY).show(ui, max));
        }
        DistanceLaw::Spring { rest, stiffness, damping } => {
            line(ui, "at rest", "its length without a force", |ui| from_nothing(f64::INFINITY).show(ui, rest));
            stiffness_and_damping(ui, stiffness, damping, [METERS.stiffness, METERS.damping]);
        }
    }
    (edited != law).then_some(JointChange::Length(edited))
}

fn softness(ui: &mut egui::Ui, softness: Option<Softness>) -> Option<JointChange> {
    let new = Softness { frequency: 5.0, damping_ratio: 1.0, max_force: NEW_STRENGTH };
    let edited = part(ui, "soft", "a damped spring instead of a rigid joint", softness, new, |ui, spring| {
        hardness(ui, &mut spring.frequency, &mut spring.damping_ratio)
            | line(ui, "at most", "", |ui| Number::positive(" N", 0.01..=1e6).show(ui, &mut spring.max_force))
    })?;
    Some(JointChange::Softness(edited))
}

#[cfg(test)]
mod tests {
    use bevy::math::DVec3;
    use bevy::prelude::*;

    use super::*;
    use crate::physics::{BallJoint, DistanceJoint, FixedJoint, HingeJoint, JointLoad, SliderJoint};
    use crate::sandbox::any_joint::WholeJoint;

    const A: Entity = Entity::PLACEHOLDER;

    /// What is asked for where the pointer clicks at a place, if it does.
    fn ask(world: &mut World, joint: Entity, click: Option<egui::Pos2>) -> Option<JointChange> {
        let context = egui::Context::default();
        let mut query = world.query::<WholeJoint>();
        let item = query.get(world, joint).unwrap();
        let mut asked = None;
        let button = |pos, pressed| egui::Event::PointerButton {
            pos,
            button: egui::PointerButton::Primary,
            pressed,
            modifiers: egui::Modifiers::NONE,
        };
        let frames = match click {
            Some(pos) => {
                vec![vec![egui::Event::PointerMoved(pos)], vec![button(pos, true)], vec![button(pos, false)], vec![]]
            }
            None => vec![vec![]; 2],
        };
        for events in frames {
            let input = egui::RawInput { events, ..Default::default() };
            let _ = context.run_ui(input, |ui| {
                let change = show(ui, &item, Some(0.3), &StepStats::default());
                asked = asked.take().or(change);
            });
        }
        asked
    }

    #[test]
    fn what_is_typed_and_is_no_number_is_said_in_one_line() {
        let context = egui::Context::default();
        for (text, expected) in
            [("3", Some(3.0)), (" -4.5 N·m", Some(-4.5)), ("−1", Some(-1.0)), ("inf", Some(f64::INFINITY))]
        {
            assert_eq!(number(&context, text, " N·m"), expected);
            assert_eq!(super::super::entry::take_refused(&context), None);
        }
        for text in ["abc", "", "nan", "1,5"] {
            assert_eq!(number(&context, text, " N·m"), None);
            let said = super::super::entry::take_refused(&context).expect("a line");
            assert!(said.contains(text) && said.lines().count() == 1, "{said}");
        }
    }

    #[test]
    fn sliders_reach_the_limits_of_a_joint_that_has_turned() {
        for turns in [-3.0, 0.0, 2.7] {
            let slider = Number::value(DEGREES, turns * TAU).slider;
            let stands_at = 360.0 * turns;
            assert!(slider.contains(&(stands_at - 45.0)) && slider.contains(&(stands_at + 45.0)), "{slider:?}");
        }
    }

    fn hinge(world: &mut World) -> Entity {
        let limits = JointLimits::range(-1.0, 1.0);
        let motor = JointMotor::new(MotorTarget::Speed(2.0)).with_max_force(10.0);
        let parts = (limits, motor, JointFriction(1.0), Breakable::at_force(100.0), JointLoad::default());
        world.spawn((HingeJoint::new(A, A), parts)).id()
    }

    #[test]
    fn what_nobody_touches_asks_for_nothing() {
        let mut world = World::new();
        let swing = JointLimits::swing_twist(0.5, [-0.1, 0.1], JointAxes::World(DVec3::X));
        let joints = [
            hinge(&mut world),
            world.spawn((BallJoint::new(A, A), swing)).id(),
            world.spawn((SliderJoint::new(A, A), JointLimits::range(f64::NEG_INFINITY, 1.0))).id(),
            world.spawn(FixedJoint::new(A, A)).id(),
            world.spawn(DistanceJoint::rod(A, A, 1.0)).id(),
            world.spawn(DistanceJoint::range(A, A, 0.5, f64::INFINITY)).id(),
            world.spawn(DistanceJoint::spring(A, A, 1.0, 10.0, 0.0)).id(),
        ];
        for joint in joints {
            assert_eq!(ask(&mut world, joint, None), None);
        }
    }

    #[test]
    fn every_part_can_be_ticked_off() {
        let mut world = World::new();
        let joint = hinge(&mut world);
        let clicks = (0..200).map(|row| egui::pos2(14.0, 3.0 * row as f32));
        let asked: Vec<_> = clicks.filter_map(|click| ask(&mut world, joint, Some(click))).collect();
        for off in [
            JointChange::Limits(None),
            JointChange::Motor(None),
            JointChange::Friction(None),
            JointChange::Strength(None),
        ] {
            assert!(asked.contains(&off), "{off:?} is not among {asked:?}");
        }
    }
}
