//! Problems to solve: still structures and moving ones, with what is known of each.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::{ConeBody, ConeContact, ConeJoint, ConeOutcome, ConeSolver, PerPoint, Velocity};
use crate::physics::testing::Random;

type V = Vector3<f64>;

/// The step of the problems, s, and gravity, m/s².
pub const STEP: f64 = 1.0 / 60.0;
/// See [`STEP`].
pub const GRAVITY: f64 = 9.81;

/// What residual is asked for, m/s.
pub const TOLERANCE: f64 = 1e-10;

/// What a solve takes.
#[derive(Clone, Default)]
pub struct Problem {
    pub bodies: Vec<ConeBody>,
    pub places: Vec<V>,
    pub free: Vec<Velocity>,
    pub contacts: Vec<ConeContact>,
    pub joints: Vec<ConeJoint>,
    /// From the centres of mass to each joint.
    pub joint_arms: Vec<[V; 2]>,
    pub bias: PerPoint,
}

/// Inverse inertia of a box.
fn box_inertia(mass: f64, size: V, turn: &UnitQuaternion<f64>) -> Matrix3<f64> {
    let square = size.component_mul(&size);
    let inertia = V::new(square.y + square.z, square.x + square.z, square.x + square.y) * (mass / 12.0);
    let turn = turn.to_rotation_matrix().into_inner();
    turn * Matrix3::from_diagonal(&inertia.map(|i| 1.0 / i)) * turn.transpose()
}

impl Problem {
    pub fn body(&mut self, place: V, mass: f64, inverse_inertia: Matrix3<f64>) -> u32 {
        self.bodies.push(ConeBody { inverse_mass: V::repeat(1.0 / mass), inverse_inertia });
        self.places.push(place);
        self.free.push([V::new(0.0, -GRAVITY * STEP, 0.0), V::zeros()]);
        self.bodies.len() as u32 - 1
    }

    pub fn cuboid(&mut self, place: V, mass: f64, size: V, turn: UnitQuaternion<f64>) -> u32 {
        let inertia = box_inertia(mass, size, &turn);
        self.body(place, mass, inertia)
    }

    pub fn ball(&mut self, place: V, mass: f64, radius: f64) -> u32 {
        self.body(place, mass, Matrix3::from_diagonal_element(2.5 / (mass * radius * radius)))
    }

    fn arm(&self, body: Option<u32>, point: V) -> V {
        body.map_or(point, |body| point - self.places[body as usize])
    }

    pub fn contact(&mut self, a: Option<u32>, b: Option<u32>, point: V, normal: V, friction: f64) {
        let arms = [self.arm(a, point), self.arm(b, point)];
        self.contacts.push(ConeContact { bodies: [a, b], arms, normal: normal.normalize(), friction });
        self.bias.contacts.push(V::zeros());
    }

    pub fn joint(&mut self, a: Option<u32>, b: Option<u32>, point: V) {
        let arms = [self.arm(a, point), self.arm(b, point)];
        self.joints.push(ConeJoint::ball([a, b], &arms));
        self.joint_arms.push(arms);
        self.bias.joints.push(V::zeros());
    }

    /// Four contacts at the corners of a level rectangle, b on a.
    fn face(&mut self, a: Option<u32>, b: Option<u32>, centre: V, half: [f64; 2], friction: f64) {
        for (x, z) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            self.contact(a, b, centre + V::new(x * half[0], 0.0, z * half[1]), V::y(), friction);
        }
    }

    /// No guess.
    pub fn no_impulses(&self) -> PerPoint {
        PerPoint { contacts: vec![V::zeros(); self.contacts.len()], joints: vec![V::zeros(); self.joints.len()] }
    }

    /// Velocities, impulses and outcome from a guess.
    pub fn solve(&self, solver: &mut ConeSolver, impulses: &mut PerPoint) -> (Vec<Velocity>, ConeOutcome) {
        solver.set(&self.bodies, &self.contacts, &self.joints);
        let mut velocities = self.free.clone();
        let outcome = solver.solve(&mut velocities, &self.bias, impulses, TOLERANCE, 0.0);
        (velocities, outcome)
    }

    /// Adds random velocities of this size to those given.
    pub fn shaken(mut self, size: f64, seed: u64) -> Self {
        let mut random = Random::new(seed);
        for [linear, angular] in &mut self.free {
            *linear += 0.5 * size * random.vector();
            *angular += 0.5 * size * random.vector();
        }
        self
    }
}

/// A column of unit cubes of 1000 kg, the upper of a given ratio of mass to the one below it.
pub fn column(count: usize, friction: f64) -> Problem {
    let mut problem = Problem::default();
    for level in 0..count {
        let below = level.checked_sub(1).map(|level| level as u32);
        let place = V::new(0.0, level as f64 + 0.5, 0.0);
        let cube = problem.cuboid(place, 1000.0, V::repeat(1.0), UnitQuaternion::identity());
        problem.face(below, Some(cube), V::new(0.0, level as f64, 0.0), [0.5, 0.5], friction);
    }
    problem
}

/// Two cubes of 1 kg carry a slab of so many kg.
pub fn sandwich(ratio: f64) -> Problem {
    let mut problem = Problem::default();
    for x in [-1.0, 1.0] {
        let cube = problem.cuboid(V::new(x, 0.5, 0.0), 1.0, V::repeat(1.0), UnitQuaternion::identity());
        problem.face(None, Some(cube), V::new(x, 0.0, 0.0), [0.5, 0.5], 0.6);
    }
    let slab = problem.cuboid(V::new(0.0, 2.0, 0.0), ratio, V::new(4.0, 2.0, 2.0), UnitQuaternion::identity());
    for cube in 0..2 {
        problem.face(Some(cube), Some(slab), V::new(2.0 * f64::from(cube) - 1.0, 1.0, 0.0), [0.5, 0.5], 0.6);
    }
    problem
}

/// A wall of rows of so many cubes, one fewer each; the cubes of a row touch if it is said.
pub fn wall(base: usize, touching: bool) -> Problem {
    let mut problem = Problem::default();
    let mut below = 0;
    for row in 0..base {
        let first = problem.bodies.len() as u32;
        for index in 0..base - row {
            let place = V::new(index as f64 + 0.5 * row as f64, row as f64 + 0.5, 0.0);
            let cube = problem.cuboid(place, 1000.0, V::repeat(1.0), UnitQuaternion::identity());
            let under = place - V::new(0.0, 0.5, 0.0);
            if row == 0 {
                problem.face(None, Some(cube), under, [0.5, 0.5], 0.6);
            } else {
                for side in 0..2 {
                    let at = under + V::new(0.5 * f64::from(side) - 0.25, 0.0, 0.0);
                    problem.face(Some(below + index as u32 + side), Some(cube), at, [0.25, 0.5], 0.6);
                }
            }
            if touching && index > 0 {
                for (y, z) in [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)] {
                    problem.contact(Some(cube - 1), Some(cube), place + V::new(-0.5, y, z), V::x(), 0.6);
                }
            }
        }
        below = first;
    }
    problem
}

/// A box 2×½×1 on a slope of this tangent, in the slope's axes: gravity is turned.
pub fn incline(tangent: f64, friction: f64) -> Problem {
    let mut problem = Problem::default();
    let slab = problem.cuboid(V::new(0.0, 0.25, 0.0), 1000.0, V::new(2.0, 0.5, 1.0), UnitQuaternion::identity());
    problem.face(None, Some(slab), V::zeros(), [1.0, 0.5], friction);
    let angle = tangent.atan();
    problem.free[0][0] = V::new(angle.sin(), -angle.cos(), 0.0) * GRAVITY * STEP;
    problem
}

/// A slab pushed aslant with 25 balls on it.
pub fn rolling(heading: f64) -> Problem {
    let mut problem = Problem::default();
    let slab = problem.cuboid(V::new(0.0, 0.5, 0.0), 10.0, V::new(20.0, 1.0, 20.0), UnitQuaternion::identity());
    problem.face(None, Some(slab), V::zeros(), [10.0, 10.0], 0.4);
    problem.free[0][0] += V::new(heading.cos(), 0.0, heading.sin()) * (150.0 / 10.0 * STEP);
    for x in -2..=2 {
        for z in -2..=2 {
            let at = 2.0 * V::new(f64::from(x), 0.0, f64::from(z)) + V::y();
            let ball = problem.ball(at + 0.5 * V::y(), 1.0, 0.5);
            problem.contact(Some(slab), Some(ball), at, V::y(), 0.8);
        }
    }
    problem
}

/// A semicircle of voussoirs between radii 4 and 5 m, 1 m deep.
pub fn arch(count: usize, friction: f64) -> Problem {
    let mut problem = Problem::default();
    let part = std::f64::consts::PI / count as f64;
    for index in 0..=count {
        let (a, b) = (index.checked_sub(1).map(|a| a as u32), (index < count).then_some(index as u32));
        if index < count {
            let middle = (index as f64 + 0.5) * part;
            let place = 4.5 * V::new(-middle.cos(), middle.sin(), 0.0);
            let turn = UnitQuaternion::from_axis_angle(&V::z_axis(), -middle);
            problem.cuboid(place, 4.5 * part * 1000.0, V::new(1.0, 4.5 * part, 1.0), turn);
        }
        let (sin, cos) = (index as f64 * part).sin_cos();
        for (radius, z) in [(4.0, -0.5), (5.0, -0.5), (5.0, 0.5), (4.0, 0.5)] {
            problem.contact(a, b, V::new(-radius * cos, radius * sin, z), V::new(sin, cos, 0.0), friction);
        }
    }
    problem
}

/// Storeys of leaning cards 1×0.04×0.7 m of 28 kg, with decks between.
pub fn card_house(storeys: usize, friction: f64) -> Problem {
    let mut problem = Problem::default();
    let (sin, cos) = 20f64.to_radians().sin_cos();
    let size = V::new(0.04, 1.0, 0.7);
    let pitch = 1.0;
    let mut decks: Vec<(f64, u32)> = Vec::new();
    for storey in 0..storeys {
        let base = storey as f64 * (cos + 0.04);
        let count = storeys - storey;
        let mut tops = Vec::new();
        for pair in 0..count {
            let apex = pitch * (pair as f64 + 0.5 * storey as f64);
            let mut pair_cards = [0; 2];
            for (side, sign) in [-1.0, 1.0].into_iter().enumerate() {
                let foot = apex + sign * sin;
                let turn = UnitQuaternion::from_axis_angle(&V::z_axis(), sign * 20f64.to_radians());
                let place = V::new(0.5 * (apex + foot) + sign * 0.02, base + 0.5 * cos, 0.0);
                let card = problem.cuboid(place, 28.0, size, turn);
                pair_cards[side] = card;
                let under = decks.iter().min_by(|a, b| (a.0 - foot).abs().total_cmp(&(b.0 - foot).abs())).map(|d| d.1);
                for z in [-0.35, 0.35] {
                    problem.contact(under, Some(card), V::new(foot, base, z), V::y(), friction);
                }
            }
            for z in [-0.35, 0.35] {
                let point = V::new(apex, base + cos, z);
                problem.contact(Some(pair_cards[0]), Some(pair_cards[1]), point, V::x(), friction);
            }
            tops.push((apex, pair_cards));
        }
        decks.clear();
        for pair in tops.windows(2) {
            let middle = 0.5 * (pair[0].0 + pair[1].0);
            let place = V::new(middle, base + cos + 0.02, 0.0);
            let deck = problem.cuboid(place, 28.0, V::new(1.0, 0.04, 0.7), UnitQuaternion::identity());
            for (apex, cards) in pair {
                let card = if *apex < middle { cards[1] } else { cards[0] };
                for z in [-0.35, 0.35] {
                    let x = apex + 0.02 * (middle - apex).signum();
                    problem.contact(Some(card), Some(deck), V::new(x, base + cos, z), V::y(), friction);
                }
            }
            decks.push((middle, deck));
        }
    }
    problem
}

/// A rod 1 m long at 60° to the ground, its lower end sliding at 5 m/s away from where it leans.
pub fn painleve(friction: f64) -> Problem {
    let mut problem = Problem::default();
    let (sin, cos) = 60f64.to_radians().sin_cos();
    let turn = UnitQuaternion::from_axis_angle(&V::z_axis(), 60f64.to_radians());
    let rod = problem.cuboid(V::new(0.5 * cos, 0.5 * sin, 0.0), 1.0, V::new(1.0, 0.02, 0.02), turn);
    problem.contact(None, Some(rod), V::zeros(), V::y(), friction);
    problem.free[0][0].x = -5.0;
    problem
}

/// Bodies on a disturbed lattice, touching their neighbours anyhow.
pub fn pile(side: usize, friction: impl Fn(f64) -> f64, spread: f64, seed: u64) -> Problem {
    let mut random = Random::new(seed);
    let mut problem = Problem::default();
    let index = |x: usize, y: usize, z: usize| (x + side * (z + side * y)) as u32;
    for y in 0..side {
        for z in 0..side {
            for x in 0..side {
                let place = V::new(x as f64, y as f64 + 0.5, z as f64) + 0.15 * random.vector();
                let turn = UnitQuaternion::new(1.5 * random.vector());
                let mass = (spread * (random.unit() - 0.5)).exp();
                problem.cuboid(place, mass, V::repeat(0.6) + random.vector() * 0.25, turn);
            }
        }
    }
    for y in 0..side {
        for z in 0..side {
            for x in 0..side {
                let one = index(x, y, z);
                let others = [
                    (x + 1 < side).then(|| index(x + 1, y, z)),
                    (y + 1 < side).then(|| index(x, y + 1, z)),
                    (z + 1 < side).then(|| index(x, y, z + 1)),
                ];
                for other in others.into_iter().flatten() {
                    let between = problem.places[other as usize] - problem.places[one as usize];
                    let normal = between.normalize() + 0.2 * random.vector();
                    for _ in 0..1 + (3.0 * random.unit()) as usize {
                        let point = problem.places[one as usize] + 0.5 * between + 0.2 * random.vector();
                        problem.contact(Some(one), Some(other), point, normal, friction(random.unit()));
                    }
                }
                if y == 0 {
                    let under = problem.places[one as usize].component_mul(&V::new(1.0, 0.0, 1.0));
                    for _ in 0..1 + (4.0 * random.unit()) as usize {
                        let mut point = under + 0.3 * random.vector();
                        point.y = 0.0;
                        problem.contact(None, Some(one), point, V::y(), friction(random.unit()));
                    }
                }
            }
        }
    }
    problem.shaken(0.5, seed + 1)
}

/// Rods joined end to end, lying on the ground, on two points each.
pub fn chain(count: usize) -> Problem {
    let mut problem = Problem::default();
    for index in 0..count {
        let place = V::new(index as f64 + 0.5, 0.1, 0.0);
        let rod = problem.cuboid(place, 1.0, V::new(1.0, 0.2, 0.2), UnitQuaternion::identity());
        problem.face(None, Some(rod), V::new(index as f64 + 0.5, 0.0, 0.0), [0.5, 0.1], 0.6);
        if index > 0 {
            problem.joint(Some(rod - 1), Some(rod), V::new(index as f64, 0.1, 0.0));
        }
    }
    problem
}
