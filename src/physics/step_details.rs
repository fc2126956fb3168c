//! What the last step made of each body, contact point and joint: read between steps, for whoever wants to see why things
//! are as they are. To read it changes nothing, and nothing is kept for it.

use bevy::math::DVec3;
use bevy::prelude::*;

use super::{
    Bodies, ContactGraph, Contacts, ExactGroups, ImpulseGroups, IslandSolvers, Islands, Joint, Joints, Sleep,
    SolverSettings, StepStats,
};

/// What the last step made of a body that contacts and joints can move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyDetails {
    /// The body.
    pub body: Entity,
    /// The oldest body of its island, which stands for it; none where no contact and no joint holds or touches the body.
    pub island: Option<Entity>,
    /// Whether it sleeps.
    pub is_asleep: bool,
    /// How much of the time is over for which its island must be calm to fall asleep, 0 to 1.
    pub calm: f64,
    /// How often its rows were solved: by sweeps, factorisations or evaluations. 0 where it was left alone: it sleeps, has no
    /// rows, or nothing had changed since the step before.
    pub solves: f64,
}

/// A contact point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactDetails {
    /// One body.
    pub a: Entity,
    /// The other.
    pub b: Entity,
    /// World position, m: where contacts last, where the bodies are now, else where the step found it.
    pub point: DVec3,
    /// Overlap there, m; negative: a gap that may close.
    pub depth: f64,
    /// Where in the order of solving its color of the constraint graph comes; none: it was not swept by colors.
    pub color: Option<u32>,
}

/// A joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointDetails {
    /// The joint.
    pub joint: Entity,
    /// Its bodies.
    pub bodies: [Entity; 2],
    /// How far what it holds rigidly is apart, m; where it holds no point at a point, the largest row, m or rad.
    pub gap: f64,
    /// Where in the order of solving its color of the constraint graph comes; none: it was not swept by colors.
    pub color: Option<u32>,
}

/// Of all bodies that contacts and joints can move, in the order in which they became bodies. None before the first step.
pub fn body_details(world: &World) -> Vec<BodyDetails> {
    let resources = (world.get_resource::<Bodies>(), world.get_resource::<Islands>(), world.get_resource::<Sleep>());
    let (Some(bodies), Some(islands), Some(sleep)) = resources else { return Vec::new() };
    let (settings, stats) = (world.resource::<SolverSettings>(), world.resource::<StepStats>());
    let solves = solves(world, bodies, islands, settings);
    let details = |(index, solves): (u32, f64)| {
        let body = &bodies.list[index as usize];
        let is_asleep = bodies.asleep.contains(index);
        let root = if is_asleep { sleep.root_of(index) } else { islands.constrained_root_of(index) };
        let calm = if is_asleep { 1.0 } else { sleep.calm_share(index, stats.steps, settings.step()) };
        body.is_dynamic().then(|| BodyDetails {
            body: body.entity,
            island: root.and_then(|root| bodies.list.get(root as usize)).map(|root| root.entity),
            is_asleep,
            calm,
            solves: if is_asleep || root.is_none() { 0.0 } else { solves },
        })
    };
    (0..).zip(solves).filter_map(details).collect()
}

/// How often the rows of each body were solved.
fn solves(world: &World, bodies: &Bodies, islands: &Islands, settings: &SolverSettings) -> Vec<f64> {
    let mut solves = vec![0.0; bodies.list.len()];
    let mut set = |(body, times): (u32, f64)| {
        if let Some(own) = solves.get_mut(body as usize) {
            *own = times;
        }
    };
    let whole = |(body, times): (u32, u32)| (body, f64::from(times));
    if settings.method.keeps_contacts() {
        if let Some(groups) = world.get_resource::<ImpulseGroups>() {
            groups.details(islands, settings).solves.into_iter().map(whole).for_each(&mut set);
        }
    } else if settings.method.is_force_level() {
        let solvers = world.get_resource::<IslandSolvers>();
        for solver in solvers.iter().flat_map(|solvers| &solvers.list[..solvers.used]) {
            let (members, times) = solver.solves();
            members.for_each(|body| set((body, times)));
        }
    } else if let Some(groups) = world.get_resource::<ExactGroups>() {
        groups.solves().map(whole).for_each(&mut set);
    }
    solves
}

/// Of all contact points, sleeping ones included.
pub fn contact_details(world: &World) -> Vec<ContactDetails> {
    let resources = (world.get_resource::<Bodies>(), world.get_resource::<Islands>());
    let (Some(bodies), Some(islands)) = resources else { return Vec::new() };
    let settings = world.resource::<SolverSettings>();
    let entity = |body: u32| bodies.list.get(body as usize).map(|body| body.entity);
    if settings.method.keeps_contacts() {
        let (Some(graph), Some(groups)) = (world.get_resource::<ContactGraph>(), world.get_resource::<ImpulseGroups>())
        else {
            return Vec::new();
        };
        let colors = by_index(graph.slots.len(), groups.details(islands, settings).contacts);
        let points = graph.points(bodies).filter_map(|(slot, pair, point)| {
            let (a, b) = (entity(pair.a)?, entity(pair.b)?);
            let color = colors[slot as usize];
            Some(ContactDetails { a, b, point: point.point.into(), depth: point.depth, color })
        });
        return points.collect();
    }
    let Some(contacts) = world.get_resource::<Contacts>() else { return Vec::new() };
    let of_manifolds = contacts.manifolds.iter().filter_map(|manifold| {
        let (a, b) = (entity(manifold.pair.a)?, entity(manifold.pair.b)?);
        let points = contacts.points_of(manifold).iter();
        Some(points.map(move |point| {
            let (point, depth) = (point.point.into(), point.depth);
            ContactDetails { a, b, point, depth, color: None }
        }))
    });
    of_manifolds.flatten().collect()
}

/// Of all joints that hold, in the order in which they were made.
pub fn joint_details(world: &World) -> Vec<JointDetails> {
    let resources = (world.get_resource::<Bodies>(), world.get_resource::<Joints>(), world.get_resource::<Islands>());
    let (Some(bodies), Some(joints), Some(islands)) = resources else { return Vec::new() };
    let (settings, stats) = (world.resource::<SolverSettings>(), world.resource::<StepStats>());
    let groups = world.get_resource::<ImpulseGroups>().filter(|_| settings.method.keeps_contacts());
    let colors = groups.map(|groups| groups.details(islands, settings).joints).unwrap_or_default();
    let colors = by_index(joints.list.len(), colors);
    let mut first = 0;
    let of_pieces = joints.list.chunk_by(|one, next| one.entity == next.entity).filter_map(|pieces| {
        let colors = &colors[first..first + pieces.len()];
        first += pieces.len();
        let Joint { entity, a, b, .. } = pieces[0];
        let [a, b] = [bodies.list.get(a as usize)?, bodies.list.get(b as usize)?];
        let gaps = pieces.iter().map(|piece| piece.definition.separation([a, b], stats.time));
        Some(JointDetails {
            joint: entity,
            bodies: [a.entity, b.entity],
            gap: gaps.fold(0.0, f64::max),
            color: colors.iter().flatten().min().copied(),
        })
    });
    of_pieces.collect()
}

/// The colors of so many constraints, from pairs of index and color; of one that has several the first.
fn by_index(count: usize, pairs: Vec<(u32, u32)>) -> Vec<Option<u32>> {
    let mut colors = vec![None; count];
    for (index, color) in pairs {
        if let Some(own) = colors.get_mut(index as usize) {
            *own = Some(own.map_or(color, |own: u32| own.min(color)));
        }
    }
    colors
}
