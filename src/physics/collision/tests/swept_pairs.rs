use std::collections::{BTreeMap, BTreeSet};

use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use super::super::contact_graph::reachable_gap;
use super::super::pair_slots::PairSlot;
use super::super::persistent_pairs::PairChanges;
use super::super::swept_pairs::SweptPairs;
use super::{KINDS, body, random, random_rotation, random_vector, upright};
use crate::physics::body::Body;
use crate::physics::body::RigidBody;
use crate::physics::collision::manifold::Pair;
use crate::physics::joint::JoinedPairs;
use crate::physics::settings::{BroadPhase, SolverSettings};
use crate::physics::shape::Collider;

fn settings() -> SolverSettings {
    SolverSettings { broad_phase: BroadPhase::SweepAndSort, ..SolverSettings::game() }
}

/// Balls, boxes and cones over a half-space, at rest to very fast.
fn random_bodies(random: &mut Pcg64Mcg, count: usize) -> Vec<Body> {
    let mut bodies = vec![upright(&Collider::half_space(), [0.0, -6.0, 0.0])];
    bodies[0].kind = RigidBody::Static;
    bodies.extend((0..count).map(|_| {
        let collider = KINDS[random.random_range(0..3)](random);
        let mut body = body(&collider, random_vector(random, 12.0), random_rotation(random));
        body.kind = [RigidBody::Dynamic, RigidBody::Dynamic, RigidBody::Static, RigidBody::Kinematic]
            [random.random_range(0..4)];
        let fast = [0.0, 1.0, 100.0][random.random_range(0..3)];
        if body.kind != RigidBody::Static {
            body.linear = random_vector(random, fast);
            body.angular = random_vector(random, 0.1 * fast);
        }
        body
    }));
    bodies
}

fn may_pair(one: &Body, other: &Body) -> bool {
    one.kind == RigidBody::Dynamic || other.kind == RigidBody::Dynamic
}

/// Every pair whose bounding spheres are within the gap up to which contact points are sought.
fn reachable(bodies: &[Body], joined: &JoinedPairs) -> BTreeSet<Pair> {
    let mut pairs = BTreeSet::new();
    for b in 1..bodies.len() {
        let (ground, other) = (&bodies[0], &bodies[b]);
        let gap = other.radius + reachable_gap(ground, other, other.radius, &settings());
        if may_pair(ground, other) && other.position.y - ground.position.y <= gap {
            pairs.insert(Pair { a: 0, b: b as u32 });
        }
        for (a, one) in bodies.iter().enumerate().take(b).skip(1) {
            let gap = reachable_gap(one, other, one.radius.min(other.radius), &settings());
            let distance = (one.position - other.position).norm() - one.radius - other.radius;
            if may_pair(one, other) && distance <= gap && !joined.contains(a as u32, b as u32) {
                pairs.insert(Pair { a: a as u32, b: b as u32 });
            }
        }
    }
    pairs
}

/// The pairs with their slots, as somebody knows them who is only told the changes.
#[derive(Default)]
struct Told(BTreeMap<u32, Pair>);

impl Told {
    fn take(&mut self, swept: &SweptPairs, changes: &PairChanges) {
        for (PairSlot(slot), pair) in &changes.removed {
            assert_eq!(self.0.remove(slot), Some(*pair));
        }
        for &PairSlot(slot) in &changes.added {
            let pair = swept.pairs().get(PairSlot(slot)).unwrap();
            assert!(self.0.insert(slot, pair).is_none());
        }
        let all: BTreeMap<_, _> = swept.pairs().iter().map(|(slot, pair)| (slot.0, pair)).collect();
        assert_eq!(self.0, all);
    }

    fn pairs(&self) -> BTreeSet<Pair> {
        self.0.values().copied().collect()
    }
}

#[test]
fn pairs_told_by_their_changes_are_those_of_a_search_from_nothing_and_miss_none_in_reach() {
    let mut random = random(31);
    let mut bodies = random_bodies(&mut random, 150);
    let (mut swept, mut told, mut changes) = (SweptPairs::default(), Told::default(), PairChanges::default());
    let mut joined = JoinedPairs::default();
    let (mut kept, mut moved) = (0, 0);
    for round in 0..60 {
        if round == 20 {
            joined.rebuild((1..149).step_by(2).map(|a| (a, a + 1)));
        }
        let before = told.0.clone();
        swept.update(&bodies, &joined, &settings(), &mut changes);
        told.take(&swept, &changes);
        let (mut afresh, mut all) = (SweptPairs::default(), Told::default());
        afresh.update(&bodies, &joined, &settings(), &mut changes);
        all.take(&afresh, &changes);
        assert_eq!(told.pairs(), all.pairs(), "round {round}");
        let missing: Vec<_> = reachable(&bodies, &joined).difference(&told.pairs()).copied().collect();
        assert!(missing.is_empty(), "round {round}: {missing:?}");
        // A pair that stays keeps its slot.
        let slot_of: BTreeMap<Pair, u32> = before.iter().map(|(&slot, &pair)| (pair, slot)).collect();
        for (slot, pair) in &told.0 {
            kept += usize::from(slot_of.get(pair) == Some(slot));
            moved += usize::from(slot_of.get(pair).is_some_and(|known| known != slot));
        }
        for body in bodies.iter_mut().filter(|body| body.kind != RigidBody::Static) {
            body.position += body.linear * 1e-3;
            body.linear -= body.position * 0.05;
        }
    }
    assert!(kept > 1000, "{kept} pairs stayed: too few to prove it");
    assert_eq!(moved, 0);
}

#[test]
fn renewed_bodies_get_new_slots_and_gone_ones_lose_theirs() {
    let mut random = random(32);
    let mut bodies = random_bodies(&mut random, 60);
    let (mut swept, mut told, mut changes) = (SweptPairs::default(), Told::default(), PairChanges::default());
    let joined = JoinedPairs::default();
    swept.update(&bodies, &joined, &settings(), &mut changes);
    told.take(&swept, &changes);
    let renewed = told.pairs().iter().next_back().unwrap().b;
    let had = told.pairs().iter().filter(|pair| pair.a == renewed || pair.b == renewed).count();
    swept.renew(renewed);
    swept.update(&bodies, &joined, &settings(), &mut changes);
    assert_eq!([changes.removed.len(), changes.added.len()], [had, had]);
    told.take(&swept, &changes);
    // Every third body goes; pairs of the others keep their slots under new names.
    let mut next = 0..;
    let new_index: Vec<Option<u32>> = (0..61).map(|body| (body % 3 != 2).then(|| next.next().unwrap())).collect();
    let mut place = 0..61;
    bodies.retain(|_| new_index[place.next().unwrap()].is_some());
    let mut removed = Vec::new();
    swept.remap(&new_index, &mut removed);
    for (PairSlot(slot), pair) in &removed {
        assert_eq!(told.0.remove(slot), Some(*pair));
    }
    for pair in told.0.values_mut() {
        let [a, b] = [pair.a, pair.b].map(|body| new_index[body as usize].unwrap());
        *pair = Pair { a, b };
    }
    swept.update(&bodies, &joined, &settings(), &mut changes);
    assert!(changes.removed.is_empty() && changes.added.is_empty(), "{changes:?}");
    told.take(&swept, &changes);
}
