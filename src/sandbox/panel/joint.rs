//! One joint's limits, motor, friction and strength, to be changed while it works.
//!
//! Angles are shown in degrees, and kept in rad.

use std::f64::consts::{FRAC_PI_4, PI};
use std::ops::RangeInclusive;

use bevy_egui::egui;

use super::super::JointChange;
use super::super::any_joint::WholeJointItem;
use super::theme::Quantity;
use crate::physics::{
    Breakable, DistanceLaw, JointAxes, JointAxis, JointFriction, JointLimits, JointMotor, LimitRange, MotorTarget,
    Softness,
};
use crate::scene::{JointComponent, MotorKeys};

/// Any number.
const ANY: RangeInclusive<f64> = f64::NEG_INFINITY..=f64::INFINITY;
/// What is 0 or more, and what must be more.
const NOT_NEGATIVE: RangeInclusive<f64> = 0.0..=f64::INFINITY;
const POSITIVE: RangeInclusive<f64> = 1e-9..=f64::INFINITY;

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
    /// What a drag by a pixel changes, as shown.
    speed: f64,
}

const DEGREES: Unit = Unit {
    factor: 180.0 / PI,
    value: "°",
    rate: " rad/s",
    force: " N·m",
    stiffness: " N·m/rad",
    damping: " N·m·s/rad",
    speed: 0.5,
};
const METERS: Unit =
    Unit { factor: 1.0, value: " m", rate: " m/s", force: " N", stiffness: " N/m", damping: " N·s/m", speed: 0.005 };

impl Unit {
    fn of(axis: Option<JointAxis>) -> Self {
        if axis.is_some_and(JointAxis::is_angle) { DEGREES } else { METERS }
    }
}

/// The numbers of a joint that stands at that coordinate, and what shall change.
pub(super) fn show(ui: &mut egui::Ui, joint: &WholeJointItem, value: Option<f64>) -> Option<JointChange> {
    let component = joint.joint.component()?;
    let unit = Unit::of(joint.axis());
    readings(ui, joint, value, unit);
    let is_ball = matches!(component, JointComponent::Ball(_));
    let has_range = joint.axis().is_some() && !is_ball;
    let mut change = None;
    egui::Grid::new("joint").num_columns(2).spacing([8.0, 3.0]).show(ui, |ui| {
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
    });
    if joint.broken.is_some() && ui.small_button("mend").on_hover_text("let it hold again what it held").clicked() {
        change = Some(JointChange::Broken(None));
    }
    change
}

/// Where it stands and what it carries.
fn readings(ui: &mut egui::Ui, joint: &WholeJointItem, value: Option<f64>, unit: Unit) {
    if let Some(value) = value {
        let rate = joint.coordinate.map(|coordinate| format!("  {:.3}{}", coordinate.rate, unit.rate));
        let what = if matches!(joint.axis(), Some(JointAxis::Swing)) { "swing" } else { "stands at" };
        ui.monospace(format!("{what} {:.3}{}{}", value * unit.factor, unit.value, rate.unwrap_or_default()));
    }
    let Some(load) = joint.load else { return };
    let (force, torque) = (load.force.length(), load.torque.length());
    let mut text = format!("carries {}", Quantity::text(force, "N"));
    if torque > 0.0 {
        text += &format!(", {}", Quantity::text(torque, "N·m"));
    }
    if let Some(strength) = joint.breakable {
        text += &format!("  {:.0} %", 100.0 * (force / strength.force).max(torque / strength.torque));
    }
    if joint.broken.is_some() {
        text = "broken".to_owned();
    }
    ui.monospace(text)
        .on_hover_text("force and torque about its point in the last step, and the share of its strength");
}

/// A number that is shown times a factor; tells whether it was changed.
fn number(
    ui: &mut egui::Ui,
    value: &mut f64,
    suffix: &str,
    factor: f64,
    speed: f64,
    range: RangeInclusive<f64>,
) -> bool {
    let mut shown = *value * factor;
    let range = range.start() * factor..=range.end() * factor;
    let drag = egui::DragValue::new(&mut shown).suffix(suffix).speed(speed).range(range).max_decimals(3);
    let changed = ui.add(drag.update_while_editing(false)).changed();
    if changed {
        *value = shown / factor;
    }
    changed
}

/// A number without a scale of its own: it is dragged by a hundredth of itself.
fn amount(ui: &mut egui::Ui, value: &mut f64, suffix: &str, range: RangeInclusive<f64>) -> bool {
    let speed = (0.01 * value.abs()).max(1e-3);
    number(ui, value, suffix, 1.0, speed, range)
}

/// A bound that may be infinite: a box that is ticked where it is not.
fn bound(ui: &mut egui::Ui, value: &mut f64, new: f64, suffix: &str) -> bool {
    let mut bounded = value.is_finite();
    let mut changed = ui.checkbox(&mut bounded, "").on_hover_text("without it, any").changed();
    if changed {
        *value = if bounded { new } else { f64::INFINITY };
    }
    if bounded {
        changed |= amount(ui, value, suffix, POSITIVE);
    } else {
        ui.weak("any");
    }
    changed
}

/// A row of the grid: a box with a label, and, where it is ticked, what it stands for. `new` is what ticking it makes.
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
    let changed = is_there && ui.vertical(|ui| contents(ui, &mut edited)).inner;
    ui.end_row();
    (ticked || changed).then_some(is_there.then_some(edited))
}

fn limits(ui: &mut egui::Ui, limits: Option<JointLimits>, center: f64, unit: Unit) -> Option<JointChange> {
    let reach = if unit.factor == 1.0 { NEW_DISTANCE } else { NEW_ANGLE };
    let new = JointLimits::range(center - reach, center + reach);
    let edited = part(ui, "limits", "how far it may go", limits, new, |ui, limits| {
        let LimitRange::Range { min, max } = &mut limits.range else { return false };
        ui.horizontal(|ui| {
            let (least, most) = (*min, *max);
            let low = number(ui, min, unit.value, unit.factor, unit.speed, f64::NEG_INFINITY..=most);
            ui.label("to");
            let high = number(ui, max, unit.value, unit.factor, unit.speed, least..=f64::INFINITY);
            ui.label("e").on_hover_text("share of its speed that it goes back with");
            low | high | number(ui, &mut limits.restitution, "", 1.0, 0.01, 0.0..=1.0)
        })
        .inner
    })?;
    Some(JointChange::Limits(edited))
}

fn swing_twist(ui: &mut egui::Ui, limits: Option<JointLimits>) -> Option<JointChange> {
    let new = JointLimits::swing_twist(FRAC_PI_4, [-FRAC_PI_4, FRAC_PI_4], JointAxes::World(bevy::math::DVec3::X));
    let about = "how far it may swing and twist; new ones are about the world's x";
    let edited = part(ui, "limits", about, limits, new, |ui, limits| {
        let LimitRange::SwingTwist { swing, min, max, .. } = &mut limits.range else { return false };
        let within = 0.999 * PI;
        let angle = |ui: &mut egui::Ui, angle: &mut f64, range| {
            number(ui, angle, DEGREES.value, DEGREES.factor, DEGREES.speed, range)
        };
        let swings = ui.horizontal(|ui| {
            ui.label("swing");
            angle(ui, swing, 0.001..=within)
        });
        let twists = ui.horizontal(|ui| {
            ui.label("twist");
            let (least, most) = (*min, *max);
            angle(ui, min, -within..=most) | angle(ui, max, least..=within)
        });
        swings.inner | twists.inner
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
                keys_changed = key_targets(ui, keys, &motor.target, unit);
                false
            }
            _ => ui.horizontal(|ui| target_value(ui, &mut motor.target, unit)).inner,
        };
        let spring = ui.horizontal(|ui| target_spring(ui, &mut motor.target, unit)).inner;
        let most = ui.horizontal(|ui| {
            ui.label("at most");
            bound(ui, &mut motor.max_force, NEW_FORCE, unit.force)
        });
        kind | target | spring | most.inner
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

fn target_value(ui: &mut egui::Ui, target: &mut MotorTarget, unit: Unit) -> bool {
    match target {
        MotorTarget::Speed(rate) => number(ui, rate, unit.rate, 1.0, 0.02, ANY),
        MotorTarget::Position { target, .. } | MotorTarget::Spring { target, .. } => {
            number(ui, target, unit.value, unit.factor, unit.speed, ANY)
        }
        MotorTarget::Motion(_) => false,
    }
}

/// How hard it goes for a position.
fn target_spring(ui: &mut egui::Ui, target: &mut MotorTarget, unit: Unit) -> bool {
    match target {
        MotorTarget::Position { frequency, damping_ratio, .. } => {
            amount(ui, frequency, " Hz", POSITIVE) | ratio(ui, damping_ratio)
        }
        MotorTarget::Spring { stiffness, damping, .. } => {
            amount(ui, stiffness, unit.stiffness, NOT_NEGATIVE) | amount(ui, damping, unit.damping, NOT_NEGATIVE)
        }
        MotorTarget::Speed(_) | MotorTarget::Motion(_) => false,
    }
}

fn ratio(ui: &mut egui::Ui, damping_ratio: &mut f64) -> bool {
    ui.label("ζ").on_hover_text("damping ratio: 1 is critical");
    number(ui, damping_ratio, "", 1.0, 0.01, NOT_NEGATIVE)
}

/// What the target is while each key is held, and while none is.
fn key_targets(ui: &mut egui::Ui, keys: &MotorKeys, target: &MotorTarget, unit: Unit) -> Option<MotorKeys> {
    let mut edited = keys.clone();
    let [forward, back] = keys.keys.clone();
    let mut changed = false;
    let values = edited.values.iter_mut().chain([&mut edited.rest]);
    for (name, value) in [forward.as_str(), back.as_str(), "no key"].into_iter().zip(values) {
        ui.horizontal(|ui| {
            ui.label(name);
            changed |= match target {
                MotorTarget::Speed(_) => number(ui, value, unit.rate, 1.0, 0.02, ANY),
                _ => number(ui, value, unit.value, unit.factor, unit.speed, ANY),
            };
        });
    }
    changed.then_some(edited)
}

fn friction(ui: &mut egui::Ui, friction: Option<JointFriction>, unit: Unit) -> Option<JointChange> {
    let about = "dry friction against its motion";
    let edited = part(ui, "friction", about, friction, JointFriction(1.0), |ui, friction| {
        amount(ui, &mut friction.0, unit.force, NOT_NEGATIVE)
    })?;
    Some(JointChange::Friction(edited))
}

fn strength(ui: &mut egui::Ui, breakable: Option<Breakable>) -> Option<JointChange> {
    let about = "the force and the torque that it bears before it breaks";
    let new = Breakable::at_force(NEW_STRENGTH);
    let edited = part(ui, "breaks", about, breakable, new, |ui, breakable| {
        let force = ui.horizontal(|ui| bound(ui, &mut breakable.force, NEW_STRENGTH, " N"));
        let torque = ui.horizontal(|ui| bound(ui, &mut breakable.torque, NEW_STRENGTH, " N·m"));
        force.inner | torque.inner
    })?;
    Some(JointChange::Strength(edited))
}

fn length(ui: &mut egui::Ui, law: DistanceLaw) -> Option<JointChange> {
    let mut edited = law;
    ui.label("length");
    ui.vertical(|ui| match &mut edited {
        DistanceLaw::Range { min, max } if *min == *max => {
            if number(ui, min, METERS.value, 1.0, METERS.speed, POSITIVE) {
                *max = *min;
            }
        }
        DistanceLaw::Range { min, max } => {
            let (least, most) = (*min, *max);
            ui.horizontal(|ui| {
                number(ui, min, METERS.value, 1.0, METERS.speed, 0.0..=most);
                ui.label("to");
                number(ui, max, METERS.value, 1.0, METERS.speed, least.max(*POSITIVE.start())..=f64::INFINITY);
            });
        }
        DistanceLaw::Spring { rest, stiffness, damping } => {
            number(ui, rest, METERS.value, 1.0, METERS.speed, NOT_NEGATIVE);
            amount(ui, stiffness, METERS.stiffness, NOT_NEGATIVE);
            amount(ui, damping, METERS.damping, NOT_NEGATIVE);
        }
    });
    ui.end_row();
    (edited != law).then_some(JointChange::Length(edited))
}

fn softness(ui: &mut egui::Ui, softness: Option<Softness>) -> Option<JointChange> {
    let new = Softness { frequency: 5.0, damping_ratio: 1.0, max_force: NEW_STRENGTH };
    let edited = part(ui, "soft", "a damped spring instead of a rigid joint", softness, new, |ui, spring| {
        let hard = ui
            .horizontal(|ui| amount(ui, &mut spring.frequency, " Hz", POSITIVE) | ratio(ui, &mut spring.damping_ratio));
        let most = ui.horizontal(|ui| {
            ui.label("at most");
            amount(ui, &mut spring.max_force, " N", POSITIVE)
        });
        hard.inner | most.inner
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
                let change = show(ui, &item, Some(0.3));
                asked = asked.take().or(change);
            });
        }
        asked
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
        let clicks = (0..120).map(|row| egui::pos2(14.0, 3.0 * row as f32));
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
