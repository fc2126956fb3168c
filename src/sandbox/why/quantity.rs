//! The quantities: what color each body, joint and contact point has by each, and the legend that says so.

use bevy::ecs::entity::EntityHashMap;
use bevy::math::DVec3;
use bevy::prelude::*;

use super::color_by::ColorBy;
use super::legend::{Chip, Key, Legend};
use super::scale::{Rgb, Scale, categories, category, mix};
use crate::physics::{BodyDetails, SolverSettings, StepStats, body_details, contact_details, joint_details};
use crate::sandbox::any_joint::{IsJoint, WholeJoint};
use crate::sandbox::panel::{Quantity, name_of};

/// Of bodies that do not move, and of those that the quantity says nothing of.
pub const GRAY: Rgb = [120, 123, 128];
/// Of who sleeps, is about to, and is awake.
const ASLEEP: Rgb = [92, 112, 150];
const AWAKE: Rgb = [240, 138, 60];
/// Of what nothing was spent on.
const LEFT_ALONE: Rgb = [74, 78, 88];

/// Overlaps and gaps, m.
const LENGTHS: std::ops::RangeInclusive<f64> = 1e-6..=1e-1;
/// Solves of each row.
const SOLVES: std::ops::RangeInclusive<f64> = 1.0..=1e3;
/// How many islands or colors the legend names.
const NAMED: usize = 7;

/// The colors by a quantity.
#[derive(Clone, Debug, Default)]
pub struct Colors {
    /// Of bodies; all others are gray.
    pub bodies: EntityHashMap<Rgb>,
    /// Of joints.
    pub joints: EntityHashMap<Rgb>,
    /// Of contact points, in the world, m.
    pub points: Vec<(DVec3, Rgb)>,
    /// What they mean.
    pub legend: Legend,
}

/// The colors of all that is there.
pub fn colors(world: &mut World, by: ColorBy) -> Colors {
    match by {
        ColorBy::Nothing => Colors::default(),
        ColorBy::Overlap => overlap(world),
        ColorBy::JointGap => joint_gap(world),
        ColorBy::Load => load(world),
        ColorBy::Island => island(world),
        ColorBy::GraphColor => graph_color(world),
        ColorBy::Asleep => asleep(world),
        ColorBy::Effort => effort(world),
    }
}

/// Each body that moves, in the color of the largest of its values, or of none.
fn worst(world: &World, values: impl Iterator<Item = (Entity, f64)>, scale: &Scale, none: Rgb) -> EntityHashMap<Rgb> {
    let mut largest = EntityHashMap::<f64>::default();
    for (body, value) in values {
        let known = largest.entry(body).or_insert(value);
        *known = known.max(value);
    }
    let of_body = |body: &BodyDetails| largest.get(&body.body).map_or(none, |value| scale.color(*value));
    body_details(world).iter().map(|body| (body.body, of_body(body))).collect()
}

fn overlap(world: &World) -> Colors {
    let scale = Scale::logarithmic(LENGTHS, "m");
    let contacts = contact_details(world);
    let deepest = contacts.iter().map(|contact| contact.depth).fold(0.0, f64::max);
    let of_bodies = contacts.iter().flat_map(|contact| [(contact.a, contact.depth), (contact.b, contact.depth)]);
    let bodies = worst(world, of_bodies, &scale, scale.color(0.0));
    let points = contacts.iter().map(|contact| (contact.point, scale.color(contact.depth))).collect();
    let notes = vec![format!("deepest {}", Quantity::text(deepest, "m")), "gray: does not move".into()];
    Colors { bodies, points, legend: Legend { title: "overlap", key: Key::Scale(scale), notes }, ..default() }
}

fn joint_gap(world: &World) -> Colors {
    let scale = Scale::logarithmic(LENGTHS, "m");
    let found = joint_details(world);
    let largest = found.iter().map(|joint| joint.gap).fold(0.0, f64::max);
    let of_bodies = found.iter().flat_map(|joint| joint.bodies.map(|body| (body, joint.gap)));
    let bodies = worst(world, of_bodies, &scale, GRAY);
    let joints = found.iter().map(|joint| (joint.joint, scale.color(joint.gap))).collect();
    let largest = format!("largest {}", Quantity::text(largest, "m"));
    let notes = if found.is_empty() {
        vec!["no joints".into()]
    } else {
        vec![largest, "gray: no joint, or does not move".into()]
    };
    Colors { bodies, joints, legend: Legend { title: "joint gap", key: Key::Scale(scale), notes }, ..default() }
}

fn load(world: &mut World) -> Colors {
    let scale = Scale::percent();
    let stats = *world.resource::<StepStats>();
    let mut joints = world.query_filtered::<(Entity, WholeJoint), IsJoint>();
    let known = joints.iter(world).filter(|(_, joint)| joint.broken.is_none());
    let known = known.filter_map(|(entity, joint)| {
        let load = joint.known_load(&stats)?;
        let ends = joint.joint.component()?.bodies();
        Some((entity, ends, load.force.length(), load.torque.length(), joint.breakable.copied()))
    });
    let known: Vec<_> = known.collect();
    let unbreakable = known.iter().filter(|(.., breakable)| breakable.is_none());
    let largest = unbreakable.map(|(_, _, force, ..)| *force).filter(|force| force.is_finite()).fold(0.0, f64::max);
    let (mut has_strength, mut has_none) = (false, false);
    let mut shares = Vec::with_capacity(known.len());
    for (entity, ends, force, torque, breakable) in &known {
        let share = match breakable {
            Some(strength) => (force / strength.force).max(torque / strength.torque),
            None if largest > 0.0 => force / largest,
            None => 0.0,
        };
        *if breakable.is_some() { &mut has_strength } else { &mut has_none } = true;
        shares.push((*entity, *ends, share));
    }
    let of_bodies = shares.iter().flat_map(|(_, ends, share)| ends.map(|body| (body, *share)));
    let bodies = worst(world, of_bodies, &scale, GRAY);
    let joints = shares.iter().map(|(joint, _, share)| (*joint, scale.color(*share))).collect();
    let mut notes = Vec::new();
    if has_strength {
        notes.push("of what a joint bears".into());
    }
    if has_none {
        notes.push(format!("of the largest force, {}, of joints that cannot break", Quantity::text(largest, "N")));
    }
    notes.push(if shares.is_empty() {
        "no joints, or no step yet".into()
    } else {
        "gray: no joint, or does not move".into()
    });
    Colors { bodies, joints, legend: Legend { title: "joint load", key: Key::Scale(scale), notes }, ..default() }
}

fn island(world: &World) -> Colors {
    let details = body_details(world);
    let mut sizes: Vec<(Entity, usize, bool)> = Vec::new();
    let mut places = EntityHashMap::<usize>::default();
    let mut bodies = EntityHashMap::default();
    for body in &details {
        let Some(root) = body.island else {
            bodies.insert(body.body, GRAY);
            continue;
        };
        let place = *places.entry(root).or_insert(sizes.len());
        if place == sizes.len() {
            sizes.push((root, 0, body.is_asleep));
        }
        sizes[place].1 += 1;
    }
    // Each by the body that stands for it, the oldest first.
    let colors = categories(sizes.iter().map(|(root, ..)| root.index().index()));
    let color_of = |root: &Entity| colors[places[root]];
    bodies.extend(details.iter().filter_map(|body| Some((body.body, color_of(&body.island?)))));
    sizes.sort_by_key(|(_, size, _)| std::cmp::Reverse(*size));
    let chips = sizes.iter().take(NAMED).map(|(root, size, is_asleep)| {
        let name = name_of(world.get::<Name>(*root), *root);
        let others = if *size > 1 { format!(" and {} more", size - 1) } else { String::new() };
        let asleep = if *is_asleep { ", asleep" } else { "" };
        Chip { color: color_of(root), text: format!("{name}{others}{asleep}") }
    });
    let mut chips: Vec<_> = chips.collect();
    chips.push(Chip { color: GRAY, text: "touches nothing, or does not move".into() });
    let more = sizes.len().saturating_sub(NAMED);
    let notes = match (sizes.len(), more) {
        (0, _) => vec!["no islands".into()],
        (1, _) => vec!["1 island".into()],
        (count, 0) => vec![format!("{count} islands")],
        (count, more) => vec![format!("{count} islands, {more} of them not named here")],
    };
    Colors { bodies, legend: Legend { title: "island", key: Key::Chips(chips), notes }, ..default() }
}

fn graph_color(world: &World) -> Colors {
    let settings = world.resource::<SolverSettings>();
    let bodies = body_details(world).iter().map(|body| (body.body, GRAY)).collect();
    if !settings.method.keeps_contacts() {
        let notes = vec!["this method solves row after row: its graph has no colors".into()];
        return Colors {
            bodies,
            legend: Legend { title: "graph color", key: Key::Chips(Vec::new()), notes },
            ..default()
        };
    }
    let color = |place: Option<u32>| place.map_or(LEFT_ALONE, category);
    let (contacts, found) = (contact_details(world), joint_details(world));
    let points = contacts.iter().map(|contact| (contact.point, color(contact.color))).collect();
    let joints = found.iter().map(|joint| (joint.joint, color(joint.color))).collect();
    let mut counts: Vec<[usize; 2]> = Vec::new();
    let places = contacts.iter().map(|contact| (contact.color, 0)).chain(found.iter().map(|joint| (joint.color, 1)));
    for (place, kind) in places {
        let Some(place) = place.map(|place| place as usize) else { continue };
        counts.resize(counts.len().max(place + 1), [0; 2]);
        counts[place][kind] += 1;
    }
    let said = |[points, joints]: &[usize; 2]| match (points, joints) {
        (points, 0) => format!("{points} points"),
        (0, joints) => format!("{joints} joints"),
        (points, joints) => format!("{points} points, {joints} joints"),
    };
    let named = counts.iter().take(NAMED).enumerate();
    let chip =
        |(place, counts)| Chip { color: category(place as u32), text: format!("{}: {}", place + 1, said(counts)) };
    let mut chips: Vec<_> = named.map(chip).collect();
    chips.push(Chip { color: LEFT_ALONE, text: "not swept: solved directly, or asleep".into() });
    let notes = match counts.len() {
        0 => vec!["nothing was swept in the last step".into()],
        count => vec![format!("{count} colors, one after the other")],
    };
    Colors { bodies, joints, points, legend: Legend { title: "graph color", key: Key::Chips(chips), notes } }
}

fn asleep(world: &World) -> Colors {
    let settings = world.resource::<SolverSettings>();
    let details = body_details(world);
    let color = |body: &BodyDetails| match body.is_asleep {
        true => ASLEEP,
        // Half-way at most: who is about to sleep is still awake.
        false => mix(AWAKE, ASLEEP, 0.6 * body.calm as f32),
    };
    let bodies = details.iter().map(|body| (body.body, color(body))).collect();
    let sleeping = details.iter().filter(|body| body.is_asleep).count();
    let chips = vec![
        Chip { color: ASLEEP, text: format!("asleep: {sleeping}") },
        Chip { color: mix(AWAKE, ASLEEP, 0.6), text: "about to fall asleep".into() },
        Chip { color: AWAKE, text: format!("awake: {}", details.len() - sleeping) },
        Chip { color: GRAY, text: "does not move".into() },
    ];
    let may_sleep = settings.method.keeps_contacts() && settings.impulse.sleep_speed.is_some();
    let notes = if may_sleep { Vec::new() } else { vec!["with these settings nothing sleeps".into()] };
    Colors { bodies, legend: Legend { title: "asleep", key: Key::Chips(chips), notes }, ..default() }
}

fn effort(world: &World) -> Colors {
    let scale = Scale::logarithmic(SOLVES, "");
    let details = body_details(world);
    let color = |body: &BodyDetails| if body.solves > 0.0 { scale.color(body.solves) } else { LEFT_ALONE };
    let bodies = details.iter().map(|body| (body.body, color(body))).collect();
    let most = details.iter().map(|body| body.solves).fold(0.0, f64::max);
    let left = details.iter().filter(|body| body.solves == 0.0).count();
    let notes = vec![format!("most {most:.0}"), format!("dark gray: left alone ({left})")];
    Colors { bodies, legend: Legend { title: "solves of each row", key: Key::Scale(scale), notes }, ..default() }
}
