//! Against the joints' own rows and the condition of the least, on random trees.

use bevy::prelude::Entity;
use nalgebra::{Matrix3, Vector3};

use super::super::rows::{RowBlocks, body_vector};
use super::super::world::{World, world_inertia};
use super::ReducedTrees;
use crate::physics::body::{Body, RigidBody};
use crate::physics::collision::{ContactState, Slot};
use crate::physics::constraint::row::Twist;
use crate::physics::joint::{BodyState, Frame, Hold, Joint, JointDefinition, Laws};
use crate::physics::solver::exact::MemberState;
use crate::physics::solver::linear::{BodyBlock, BodyVector, Elimination};
use crate::physics::testing::Random;

struct Tree {
    bodies: Vec<Body>,
    joints: Vec<Joint>,
}

impl World for Tree {
    fn body(&self, index: u32) -> &Body {
        &self.bodies[index as usize]
    }

    fn slot(&self, _: u32) -> &Slot {
        unreachable!("there are no contacts")
    }

    fn state(&self, _: u32) -> &ContactState {
        unreachable!("there are no contacts")
    }

    fn joint(&self, index: u32) -> &Joint {
        &self.joints[index as usize]
    }
}

/// Bodies that move.
const COUNT: u32 = 7;

/// A tree of points, hinges and rigid joints, one more joint that closes a loop, and a body that does not move, which holds
/// the tree or does not.
fn tree(random: &mut Random, is_held: bool) -> Tree {
    let mut bodies: Vec<Body> = (0..=COUNT)
        .map(|_| {
            let inertia = Vector3::from_fn(|_, _| random.within(1.0, 1.9));
            let mass = random.within(1.0, 3.0);
            Body {
                position: random.vector() * 3.0,
                rotation: random.rotation(),
                linear: random.vector(),
                angular: random.vector(),
                mass,
                inverse_mass: Vector3::repeat(1.0 / mass),
                inverse_inertia_body: inertia.map(f64::recip),
                kind: RigidBody::Dynamic,
                ..Body::new(Entity::PLACEHOLDER)
            }
        })
        .collect();
    let held = &mut bodies[COUNT as usize];
    (held.kind, held.linear, held.angular) = (RigidBody::Static, Vector3::zeros(), Vector3::zeros());
    let mut ends: Vec<[u32; 2]> = (1..COUNT).map(|body| [body / 2, body]).collect();
    ends[2].swap(0, 1);
    ends.push([2, 6]);
    if is_held {
        ends.push([3, COUNT]);
    }
    let joints = ends.iter().zip(0..).map(|(&[a, b], index)| {
        let [on_a, on_b] = [a, b].map(|body| &bodies[body as usize]);
        let (point, turn) = (random.vector() * 3.0, random.rotation());
        let frames = [on_a, on_b].map(|body| Frame {
            anchor: body.rotation.inverse() * (point - body.position),
            rotation: body.rotation.inverse() * turn,
        });
        let [free, locked] = [Hold::Free, Hold::Locked];
        let hold = [[free; 3], [free, locked, locked], [locked; 3]][index % 3];
        let rotation = Laws { hold, spring: None };
        let definition = JointDefinition { frames, translation: Laws::LOCKED, rotation, ..JointDefinition::default() };
        Joint::new(Entity::PLACEHOLDER, [a, b], definition)
    });
    let joints = joints.collect();
    Tree { bodies, joints }
}

/// Speeds of the rows of a joint at velocities, which are zero for what does not move.
fn speeds(world: &Tree, joint: u32, velocities: &[BodyVector]) -> Vec<f64> {
    let Joint { a, b, definition, .. } = world.joint(joint);
    let mut rows = Vec::new();
    definition.rows_at(&[*a, *b].map(|body| BodyState::of(world.body(body))), 0.0, &mut rows);
    let of = |body: u32| {
        velocities.get(body as usize).map_or_else(Twist::zero, |velocity| {
            let (linear, angular) = super::halves(velocity);
            Twist { linear, angular }
        })
    };
    rows.iter().map(|row| row.jacobian.dot(&of(*a), &of(*b))).collect()
}

struct Solved {
    trees: ReducedTrees,
    inertias: Vec<(f64, Matrix3<f64>)>,
    place: Vec<usize>,
    /// What rows add between bodies 1 and 5, and to body 3 alone.
    blocks: [RowBlocks; 2],
}

const ENDS: [[Option<u32>; 2]; 2] = [[Some(1), Some(5)], [None, Some(3)]];

fn solved(world: &Tree, random: &mut Random) -> Solved {
    let members: Vec<u32> = (0..COUNT).collect();
    let joints: Vec<u32> = (0..world.joints.len() as u32).collect();
    let edges = world.joints.iter().filter(|joint| joint.b < COUNT).map(|joint| [joint.a, joint.b]);
    let elimination = Elimination::new(&[6; COUNT as usize], edges, 1000).unwrap();
    let mut trees = ReducedTrees::new(world, &members, &joints, &elimination).unwrap();
    let place = members.iter().map(|&member| elimination.place(member) as usize).collect();
    trees.place(world, &members, &joints);
    trees.rest();
    let inertias: Vec<_> =
        members.iter().map(|&member| (world.body(member).mass, world_inertia(world.body(member)))).collect();
    let row = |random: &mut Random| BodyVector::from_fn(|_, _| random.within(-1.0, 1.0));
    let mut blocks = [RowBlocks::default(), RowBlocks::default()];
    for _ in 0..2 {
        let (a, b) = (row(random), row(random));
        blocks[0].add_own(0, &a, 5.0);
        blocks[0].add_own(1, &b, 5.0);
        blocks[0].add_across(&a, &b, 5.0);
        blocks[1].add_own(1, &b, 7.0);
    }
    trees.begin(&inertias);
    blocks.iter().zip(&ENDS).for_each(|(blocks, ends)| trees.add_rows(blocks, ends));
    trees.assemble();
    assert!(trees.factor());
    Solved { trees, inertias, place, blocks }
}

impl Solved {
    /// By member, as the momenta.
    fn solve(&mut self, momenta: &[BodyVector]) -> Vec<BodyVector> {
        let mut vectors = vec![BodyVector::zeros(); momenta.len()];
        self.place.iter().zip(momenta).for_each(|(&place, momentum)| vectors[place] = *momentum);
        self.trees.solve(&mut vectors);
        self.place.iter().map(|&place| vectors[place]).collect()
    }

    /// (M + K) v − p.
    fn residual(&self, velocities: &[BodyVector], momenta: &[BodyVector]) -> Vec<BodyVector> {
        let mut left: Vec<BodyVector> = (0..velocities.len())
            .map(|member| super::change_of(&self.inertias[member], &velocities[member], &momenta[member]))
            .collect();
        for (blocks, ends) in self.blocks.iter().zip(&ENDS) {
            let speed = |end: usize| ends[end].map_or_else(BodyVector::zeros, |member| velocities[member as usize]);
            let across: [BodyBlock; 2] = [blocks.across, blocks.across.transpose()];
            for end in 0..2 {
                if let Some(member) = ends[end] {
                    left[member as usize] += blocks.own[end] * speed(end) + across[end] * speed(1 - end);
                }
            }
        }
        left
    }
}

fn momenta(random: &mut Random) -> Vec<BodyVector> {
    (0..COUNT).map(|_| body_vector(&random.vector(), &random.vector())).collect()
}

#[test]
fn velocities_keep_to_the_joints_and_are_the_least_of_those_that_do() {
    let mut random = Random::new(11);
    for round in 0..6 {
        let world = tree(&mut random, round % 2 == 0);
        let mut solved = solved(&world, &mut random);
        let given = momenta(&mut random);
        let found = solved.solve(&given);
        let in_trees: Vec<u32> =
            (0..world.joints.len() as u32).filter(|&joint| solved.trees.holds(joint as usize)).collect();
        assert_eq!(
            in_trees.len(),
            COUNT as usize - usize::from(round % 2 == 1),
            "all but the one that closes the loop"
        );
        for &joint in &in_trees {
            assert!(speeds(&world, joint, &found).iter().all(|speed| speed.abs() < 1e-9), "joint {joint}");
        }
        let left = solved.residual(&found, &given);
        for _ in 0..5 {
            let other = solved.solve(&momenta(&mut random));
            let slope: f64 = other.iter().zip(&left).map(|(other, left)| other.dot(left)).sum();
            assert!(slope.abs() < 1e-9, "{slope:e}");
        }
        // What keeps it from being zero are the impulses of the joints.
        let mut by_place = left.clone();
        solved.place.iter().zip(&left).for_each(|(&place, left)| by_place[place] = *left);
        solved.trees.find_loads(&by_place);
        let mut sums = left;
        for &joint in &in_trees {
            let mut loaded = world.joint(joint).clone();
            solved.trees.store(joint as usize, &mut loaded, 1.0);
            for (end, sign) in [(0, 1.0), (1, -1.0)] {
                let member = [loaded.a, loaded.b][end];
                if member < COUNT {
                    let arm = world.body(member).rotation * loaded.anchors()[end];
                    let moment = loaded.torque + arm.cross(&loaded.force);
                    sums[member as usize] += body_vector(&loaded.force, &moment) * sign;
                }
            }
        }
        assert!(sums.iter().all(|sum| sum.norm() < 1e-9), "{sums:?}");
    }
}

#[test]
fn joints_close_their_gaps_at_the_rate_asked_for_and_curve() {
    let mut random = Random::new(12);
    let mut world = tree(&mut random, true);
    for body in &mut world.bodies[..COUNT as usize] {
        body.position += random.vector() * 1e-4;
    }
    let (members, joints): (Vec<u32>, Vec<u32>) = ((0..COUNT).collect(), (0..world.joints.len() as u32).collect());
    let mut solved = solved(&world, &mut random);
    let states = world.bodies.iter().take(COUNT as usize);
    solved.trees.states = states
        .map(|body| MemberState { position: body.position, rotation: body.rotation, ..MemberState::REST })
        .collect();
    let worst = solved.trees.find_gaps(&world, &joints, &members);
    assert!((1e-5..1e-3).contains(&worst), "{worst}");
    assert!(solved.trees.close(|_| 0.5));
    let closing = solved.solve(&[BodyVector::zeros(); COUNT as usize]);
    solved.trees.curve(&world, &members, &joints, |_| 0.1);
    let curving = solved.solve(&[BodyVector::zeros(); COUNT as usize]);
    for joint in joints.into_iter().filter(|&joint| solved.trees.holds(joint as usize)) {
        let Joint { a, b, definition, .. } = world.joint(joint);
        let mut rows = Vec::new();
        definition.rows_at(&[*a, *b].map(|body| BodyState::of(world.body(body))), 0.0, &mut rows);
        let (closing, curving) = (speeds(&world, joint, &closing), speeds(&world, joint, &curving));
        for (row, (closing, curving)) in rows.iter().zip(closing.iter().zip(curving)).take(3) {
            assert!((closing + 0.5 * row.error).abs() < 1e-6, "joint {joint}: {closing} for {}", row.error);
            assert!((curving + 0.1 * row.velocity_term).abs() < 1e-3, "joint {joint}: {curving}");
        }
    }
}
