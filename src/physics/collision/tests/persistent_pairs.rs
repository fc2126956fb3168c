use std::collections::{BTreeMap, BTreeSet};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use nalgebra::{UnitQuaternion, Vector3};

use crate::physics::collision::broad::bounding_tree::BoundingBox;
use crate::physics::collision::broad::fat_box::{Extent, Placement};
use crate::physics::collision::broad::pair_slots::PairSlot;
use crate::physics::collision::broad::persistent_pairs::{BoundedBodies, Bounds, PairChanges, PersistentPairs};
use crate::physics::collision::manifold::Pair;
use crate::physics::testing::Random;

#[derive(Clone, Copy, PartialEq)]
enum Shape {
    Nothing,
    Cuboid(Vector3<f64>),
    HalfSpace,
}

#[derive(Clone)]
struct TestBody {
    shape: Shape,
    dynamic: bool,
    layers: u32,
    at: Placement,
    spin: Vector3<f64>,
}

#[derive(Default)]
struct World {
    bodies: Vec<TestBody>,
    joined: BTreeSet<(u32, u32)>,
    boxes_computed: AtomicUsize,
    looked_at: AtomicUsize,
    asked: Mutex<Vec<(u32, u32)>>,
}

impl BoundedBodies for World {
    fn placement(&self, body: u32) -> Placement {
        self.looked_at.fetch_add(1, Ordering::Relaxed);
        self.bodies[body as usize].at
    }

    fn bounds(&self, body: u32) -> Bounds {
        self.boxes_computed.fetch_add(1, Ordering::Relaxed);
        let TestBody { shape, dynamic, at, .. } = &self.bodies[body as usize];
        match shape {
            Shape::Nothing => Bounds::None,
            Shape::HalfSpace => Bounds::HalfSpace { normal: at.rotation * Vector3::y(), point: at.position },
            Shape::Cuboid(half) => {
                let reach = at.rotation.to_rotation_matrix().into_inner().abs() * half;
                let bounds = BoundingBox { low: at.position - reach, high: at.position + reach };
                Bounds::Within(Extent { bounds, radius: half.norm(), moves: *dynamic })
            }
        }
    }

    fn may_pair(&self, a: u32, b: u32) -> bool {
        self.asked.lock().unwrap().push((a, b));
        let (one, other) = (&self.bodies[a as usize], &self.bodies[b as usize]);
        (one.dynamic || other.dynamic) && one.layers & other.layers != 0 && !self.joined.contains(&(a.min(b), a.max(b)))
    }
}

fn still(position: Vector3<f64>) -> Placement {
    Placement { position, rotation: UnitQuaternion::identity(), travel: Vector3::zeros(), turn: 0.0 }
}

impl World {
    fn add(&mut self, shape: Shape, position: Vector3<f64>, dynamic: bool) -> u32 {
        let at = still(position);
        self.bodies.push(TestBody { shape, dynamic, layers: 1, at, spin: Vector3::zeros() });
        self.bodies.len() as u32 - 1
    }

    fn all(&self) -> std::ops::Range<u32> {
        0..self.bodies.len() as u32
    }

    /// Cards to slabs, moving and turning, some static, over two half-spaces, one of them tilted.
    fn random(random: &mut Random, count: usize, origin: Vector3<f64>) -> Self {
        let mut world = Self::default();
        for _ in 0..2 {
            world.add(Shape::HalfSpace, origin + Vector3::new(0.0, -4.0, 0.0), false);
        }
        world.bodies[1].at.rotation = UnitQuaternion::from_scaled_axis(Vector3::new(0.3, 0.0, 1.2));
        for _ in 0..count {
            let body = random_body(random, origin);
            world.bodies.push(body);
        }
        world
    }

    fn step(&mut self, random: &mut Random, origin: &Vector3<f64>) {
        for body in self.bodies.iter_mut().filter(|body| body.dynamic) {
            body.at.position += body.at.travel;
            body.at.rotation = UnitQuaternion::from_scaled_axis(body.spin) * body.at.rotation;
            let pull = -0.002 * (body.at.position - origin) + 0.01 * random.vector();
            body.at.travel = 0.98 * body.at.travel + 0.1 * pull;
        }
    }

    fn meet(&self, a: u32, b: u32, boxes: &[BoundingBox]) -> bool {
        let (one, other) = (&self.bodies[a as usize], &self.bodies[b as usize]);
        let (box_a, box_b) = (&boxes[a as usize], &boxes[b as usize]);
        match (one.shape, other.shape) {
            (Shape::Nothing, _) | (_, Shape::Nothing) | (Shape::HalfSpace, Shape::HalfSpace) => false,
            (Shape::HalfSpace, _) => is_below(&one.at, box_b),
            (_, Shape::HalfSpace) => is_below(&other.at, box_a),
            _ => (0..3).all(|k| box_a.low[k] <= box_b.high[k] && box_b.low[k] <= box_a.high[k]),
        }
    }

    /// All pairs, by the definition.
    fn brute_force(&self, boxes: &[BoundingBox]) -> BTreeSet<Pair> {
        let mut pairs = BTreeSet::new();
        for b in self.all() {
            for a in (0..b).filter(|&a| self.meet(a, b, boxes) && self.may_pair(a, b)) {
                let b_first = self.bodies[b as usize].shape == Shape::HalfSpace;
                pairs.insert(if b_first { Pair { a: b, b: a } } else { Pair { a, b } });
            }
        }
        pairs
    }

    fn swept_boxes(&self) -> Vec<BoundingBox> {
        let swept = |body: u32| match self.bounds(body) {
            Bounds::Within(extent) => extent.swept(&self.placement(body)),
            _ => BoundingBox::EMPTY,
        };
        self.all().map(swept).collect()
    }
}

/// Whether a corner of the box is below the plane.
fn is_below(plane: &Placement, bounds: &BoundingBox) -> bool {
    let normal = plane.rotation * Vector3::y();
    (0..8).any(|corner| {
        let corner = Vector3::from_fn(|k, _| if corner >> k & 1 == 0 { bounds.low[k] } else { bounds.high[k] });
        normal.dot(&(corner - plane.position)) <= 0.0
    })
}

fn random_body(random: &mut Random, origin: Vector3<f64>) -> TestBody {
    let half = random.vector().map(|v| 0.02 * 100.0_f64.powf(v * v));
    let shape = if random.unit() < 0.05 { Shape::Nothing } else { Shape::Cuboid(half) };
    let mut at = still(origin + 6.0 * random.vector());
    at.rotation = UnitQuaternion::from_scaled_axis(3.0 * random.vector());
    let dynamic = random.unit() < 0.8;
    let mut spin = Vector3::zeros();
    if dynamic {
        at.travel = 0.05 * random.vector();
        // A third of them does not turn.
        spin = 0.1 * (random.unit() - 0.33).max(0.0) * random.vector();
        at.turn = spin.norm();
    }
    let layers = if random.unit() < 0.2 { 2 } else { 3 };
    TestBody { shape, dynamic, layers, at, spin }
}

/// A mirror that lives off the reported changes alone.
#[derive(Default)]
struct Mirror(BTreeMap<PairSlot, Pair>);

impl Mirror {
    fn remove(&mut self, removed: &[(PairSlot, Pair)]) {
        for (slot, pair) in removed {
            assert_eq!(self.0.remove(slot), Some(*pair), "removed a pair that was not there");
        }
    }

    fn apply(&mut self, changes: &PairChanges, pairs: &PersistentPairs) {
        self.remove(&changes.removed);
        for &slot in &changes.added {
            let pair = pairs.pairs().get(slot).expect("an added pair exists");
            assert_eq!(self.0.insert(slot, pair), None, "slot {slot:?} given twice");
        }
        assert!(self.0.iter().map(|(&slot, &pair)| (slot, pair)).eq(pairs.pairs().iter()));
        assert_eq!(self.0.len(), pairs.pairs().len());
        assert!(self.0.keys().all(|slot| (slot.0 as usize) < pairs.pairs().slot_count()));
    }
}

/// The set is that of the fat boxes, and has every pair of the swept boxes.
fn check(world: &World, pairs: &PersistentPairs, context: &str) {
    pairs.check();
    let set: BTreeSet<Pair> = pairs.pairs().iter().map(|(_, pair)| pair).collect();
    assert_eq!(set.len(), pairs.pairs().len(), "{context}: a pair is there twice");
    let fat: Vec<_> = world.all().map(|body| pairs.fat_box(body)).collect();
    assert_eq!(set, world.brute_force(&fat), "{context}: fat boxes");
    let swept = world.brute_force(&world.swept_boxes());
    assert!(swept.is_subset(&set), "{context}: {:?} missing", swept.difference(&set).collect::<Vec<_>>());
    for body in world.all() {
        let listed: BTreeSet<_> = pairs.pairs().of_body(body).map(|(slot, _)| slot).collect();
        let expected = pairs.pairs().iter().filter(|(_, pair)| pair.a == body || pair.b == body);
        assert_eq!(listed, expected.map(|(slot, _)| slot).collect(), "{context}: list of {body}");
    }
}

fn started(world: &World) -> (PersistentPairs, PairChanges, Mirror) {
    let (mut pairs, mut changes, mut mirror) = Default::default();
    start(world, &mut pairs, &mut changes, &mut mirror);
    (pairs, changes, mirror)
}

fn start(world: &World, pairs: &mut PersistentPairs, changes: &mut PairChanges, mirror: &mut Mirror) {
    world.all().for_each(|body| pairs.renew(body));
    pairs.update(world, 0..0, 1, changes);
    mirror.apply(changes, pairs);
}

#[test]
fn the_set_equals_brute_force_over_random_motion() {
    for origin in [Vector3::zeros(), Vector3::new(1e7, -3e6, 5e6)] {
        let mut random = Random::new(42);
        let mut world = World::random(&mut random, 120, origin);
        let (mut pairs, mut changes, mut mirror) = started(&world);
        check(&world, &pairs, "start");
        let (mut moved, mut added) = (0, 0);
        for step in 0..400 {
            world.step(&mut random, &origin);
            pairs.update(&world, world.all(), 1, &mut changes);
            mirror.apply(&changes, &pairs);
            check(&world, &pairs, &format!("step {step}"));
            moved += pairs.moved_count();
            added += changes.added.len();
        }
        // Something happens, yet most bodies stay in their boxes from step to step.
        assert!(moved > 400 && moved < 400 * 120 / 2 && added > 100, "{moved} moved, {added} added");
    }
}

#[test]
fn spawning_despawning_teleports_and_new_filters_keep_the_set_exact() {
    let mut random = Random::new(9);
    let mut world = World::random(&mut random, 90, Vector3::zeros());
    let (mut pairs, mut changes, mut mirror) = started(&world);
    for step in 0..400 {
        world.step(&mut random, &Vector3::zeros());
        match step % 8 {
            0 => {
                world.bodies.push(random_body(&mut random, Vector3::zeros()));
                pairs.renew(world.bodies.len() as u32 - 1);
            }
            1 => {
                let gone = [random.index(world.bodies.len()), random.index(world.bodies.len())];
                despawn(&mut world, &mut pairs, &mut mirror, &gone[..1 + step / 8 % 2]);
            }
            2 => {
                let body = random.index(world.bodies.len());
                world.bodies[body].at.position = 6.0 * random.vector();
                pairs.renew(body as u32);
            }
            3 => {
                // Into nothing, a half-space, or a cuboid; or other layers.
                let body = random.index(world.bodies.len());
                let was = world.bodies[body].at;
                world.bodies[body] = random_body(&mut random, Vector3::zeros());
                if random.unit() < 0.1 {
                    world.bodies[body].shape = Shape::HalfSpace;
                    world.bodies[body].dynamic = false;
                }
                world.bodies[body].at.position = was.position;
                pairs.renew(body as u32);
            }
            4 | 5 => {
                // A teleport that nobody told of is still a move, of what may move.
                let body = random.index(world.bodies.len());
                world.bodies[body].at.position = 6.0 * random.vector();
                if !world.bodies[body].dynamic {
                    pairs.renew(body as u32);
                }
            }
            6 => join(&mut world, &mut pairs, &mut random),
            _ => {
                // Half-spaces may move by themselves.
                world.bodies[0].at.position.y += 0.5 * random.vector().y;
                let all = world.bodies.len();
                pairs.renew(random.index(all) as u32);
            }
        }
        pairs.update(&world, world.all(), 1, &mut changes);
        mirror.apply(&changes, &pairs);
        check(&world, &pairs, &format!("step {step}"));
    }
}

/// Joins some pairs and parts others.
fn join(world: &mut World, pairs: &mut PersistentPairs, random: &mut Random) {
    for _ in 0..20 {
        let there: Vec<Pair> = pairs.pairs().iter().map(|(_, pair)| pair).collect();
        let Pair { a, b } = there[random.index(there.len())];
        world.joined.insert((a.min(b), a.max(b)));
        pairs.reconsider(b, a);
    }
    while world.joined.len() > 30 {
        let Some((a, b)) = world.joined.pop_first() else { break };
        pairs.reconsider(a, b);
    }
}

fn despawn(world: &mut World, pairs: &mut PersistentPairs, mirror: &mut Mirror, gone: &[usize]) {
    let mut next = 0..;
    let new_index: Vec<Option<u32>> =
        world.all().map(|body| if gone.contains(&(body as usize)) { None } else { next.next() }).collect();
    let mut removed = Vec::new();
    pairs.remap(&new_index, &mut removed);
    mirror.remove(&removed);
    let renamed = |body: u32| new_index[body as usize];
    for pair in mirror.0.values_mut() {
        *pair = Pair { a: renamed(pair.a).expect("kept"), b: renamed(pair.b).expect("kept") };
    }
    world.joined = world.joined.iter().filter_map(|&(a, b)| Some((renamed(a)?, renamed(b)?))).collect();
    let mut kept = new_index.iter();
    world.bodies.retain(|_| kept.next().is_some_and(Option::is_some));
}

#[test]
fn coinciding_and_point_like_bodies_all_pair() {
    for half in [0.0, 0.5] {
        let mut world = World::default();
        for _ in 0..300 {
            world.add(Shape::Cuboid(Vector3::repeat(half)), Vector3::repeat(1.0), true);
        }
        let (pairs, ..) = started(&world);
        assert_eq!(pairs.pairs().len(), 300 * 299 / 2);
        pairs.check();
    }
}

#[test]
fn nothing_is_done_where_nothing_leaves_its_box() {
    let mut random = Random::new(1);
    let mut world = World::default();
    world.add(Shape::HalfSpace, Vector3::zeros(), false);
    for row in 0..1000 {
        let at = Vector3::new(f64::from(row % 40), f64::from(row / 40) + 0.5, 0.0);
        world.add(Shape::Cuboid(Vector3::repeat(0.5)), at, true);
    }
    let (mut pairs, mut changes, _) = started(&world);
    let places: Vec<_> = world.bodies.iter().map(|body| body.at).collect();
    world.asked.lock().unwrap().clear();
    world.boxes_computed.store(0, Ordering::Relaxed);
    for _ in 0..50 {
        for (body, place) in world.bodies.iter_mut().zip(&places).skip(1) {
            body.at.position = place.position + 0.005 * random.vector();
            body.at.rotation = UnitQuaternion::from_scaled_axis(0.004 * random.vector());
            body.at.travel = 0.005 * random.vector();
        }
        pairs.update(&world, 1..1001, 1, &mut changes);
        assert_eq!(pairs.moved_count(), 0);
    }
    let boxes = world.boxes_computed.load(Ordering::Relaxed);
    assert_eq!((boxes, world.asked.lock().unwrap().len()), (0, 0));
}

#[test]
fn what_touches_nothing_or_stands_is_not_looked_at() {
    let mut world = World::default();
    for place in 0..10 {
        let at = 3.0 * Vector3::repeat(f64::from(place));
        world.add(Shape::Nothing, at, true);
        world.add(Shape::Cuboid(Vector3::repeat(0.5)), at, false);
    }
    world.add(Shape::Cuboid(Vector3::repeat(0.5)), Vector3::new(-3.0, 0.0, 0.0), true);
    let (mut pairs, mut changes, _) = started(&world);
    world.looked_at.store(0, Ordering::Relaxed);
    pairs.update(&world, world.all(), 1, &mut changes);
    assert_eq!(world.looked_at.load(Ordering::Relaxed), 1, "what moves and may touch");
}

/// `may_pair` is asked when two boxes begin to overlap and not again while they do.
#[test]
fn a_pair_that_may_not_be_is_asked_about_once() {
    let mut world = World::default();
    world.add(Shape::Cuboid(Vector3::repeat(0.5)), Vector3::zeros(), true);
    world.add(Shape::Cuboid(Vector3::repeat(0.5)), Vector3::new(0.9, 0.0, 0.0), true);
    world.joined.insert((0, 1));
    let (mut pairs, mut changes, _) = started(&world);
    for step in 0..20 {
        world.bodies[0].at.position.x -= 0.01;
        world.bodies[1].at.position.z = 0.2 * f64::from(step % 2);
        pairs.update(&world, 0..2, 1, &mut changes);
    }
    assert_eq!(*world.asked.lock().unwrap(), [(0, 1)]);
    assert_eq!(pairs.pairs().len(), 0);
}

#[test]
fn two_runs_give_the_same_slots_whatever_the_tree_went_through() {
    let run = |shaken: bool| {
        let mut random = Random::new(77);
        let mut world = World::random(&mut random, 150, Vector3::zeros());
        let (mut pairs, mut changes) = (PersistentPairs::default(), PairChanges::default());
        let mut mirror = Mirror::default();
        if shaken {
            // Another past of the tree: bodies came one by one, last first, where they could not touch.
            let there = std::mem::take(&mut world.bodies);
            world.bodies = there.clone();
            for (index, body) in world.bodies.iter_mut().enumerate().skip(2) {
                body.at.position = Vector3::new(100.0 * index as f64, 1e4, 0.0);
            }
            world.bodies[1].shape = Shape::Nothing;
            for body in world.all().rev() {
                pairs.renew(body);
                pairs.update(&world, 0..0, 1, &mut changes);
                assert!(changes.added.is_empty());
            }
            world.bodies = there;
        }
        start(&world, &mut pairs, &mut changes, &mut mirror);
        let mut history = Vec::new();
        for _ in 0..100 {
            world.step(&mut random, &Vector3::zeros());
            pairs.update(&world, world.all(), 1, &mut changes);
            history.push((changes.removed.clone(), changes.added.clone()));
        }
        (history, pairs.pairs().iter().collect::<Vec<_>>())
    };
    assert_eq!(run(false), run(false));
    assert_eq!(run(false), run(true));
}

/// A new box for the ground, with a thousand pairs, costs the bodies' lists nothing.
#[test]
fn static_bodies_do_not_pair_and_have_no_margin() {
    let mut world = World::default();
    world.add(Shape::Cuboid(Vector3::new(50.0, 1.0, 50.0)), Vector3::new(0.0, -1.0, 0.0), false);
    for place in 0..100 {
        world.add(Shape::Cuboid(Vector3::repeat(0.5)), Vector3::new(f64::from(place % 10), 0.5, 0.0), place >= 50);
    }
    // Just above the ground: within its own margin, 5 % of √3/2 m; the ground has none.
    world.add(Shape::Cuboid(Vector3::repeat(0.5)), Vector3::new(30.0, 0.54, 0.0), true);
    world.add(Shape::Cuboid(Vector3::repeat(0.5)), Vector3::new(40.0, 0.55, 0.0), true);
    let (pairs, ..) = started(&world);
    assert_eq!(pairs.pairs().of_body(0).count(), 51);
    assert_eq!(pairs.fat_box(0).high.y, 0.0);
    check(&world, &pairs, "start");
}
