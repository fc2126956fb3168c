//! Against dense solutions, conservation and finite differences, on random trees.

mod position;
mod singular;
mod structure;
mod velocity;

use nalgebra::{DMatrix, DVector, Matrix3, UnitQuaternion, Vector3};

use super::tree::NONE;
use super::{JointTree, partition};
use crate::physics::constraint::row::Twist;
use crate::physics::testing::Random;

/// Bodies with ball joints, and a plain copy of what the tree is told.
#[derive(Clone)]
struct Assembly {
    moves: Vec<bool>,
    inverse_masses: Vec<Vector3<f64>>,
    inverse_inertias: Vec<Matrix3<f64>>,
    twists: Vec<Twist<f64>>,
    joints: Vec<[u32; 2]>,
    arms: Vec<[Vector3<f64>; 2]>,
    separations: Vec<Vector3<f64>>,
    targets: Vec<Vector3<f64>>,
}

impl Assembly {
    fn new() -> Self {
        Self {
            moves: Vec::new(),
            inverse_masses: Vec::new(),
            inverse_inertias: Vec::new(),
            twists: Vec::new(),
            joints: Vec::new(),
            arms: Vec::new(),
            separations: Vec::new(),
            targets: Vec::new(),
        }
    }

    /// Of that mass and a size of about 1 m, neither round nor aligned.
    fn body(&mut self, mass: f64, random: &mut Random) -> u32 {
        let rotation = random.rotation().to_rotation_matrix().into_inner();
        let principal = Vector3::from_fn(|_, _| random.within(2.0, 10.0) / mass);
        self.moves.push(true);
        self.inverse_masses.push(Vector3::repeat(1.0 / mass));
        self.inverse_inertias.push(rotation * Matrix3::from_diagonal(&principal) * rotation.transpose());
        self.twists.push(Twist { linear: random.vector(), angular: random.vector() });
        self.moves.len() as u32 - 1
    }

    /// Does not move on account of joints, but may have a velocity.
    fn fixed(&mut self, random: &mut Random) -> u32 {
        let body = self.body(1.0, random);
        self.moves[body as usize] = false;
        self.inverse_masses[body as usize] = Vector3::zeros();
        self.inverse_inertias[body as usize] = Matrix3::zeros();
        body
    }

    fn join(&mut self, a: u32, b: u32, random: &mut Random) {
        let (a, b) = if random.unit() < 0.5 { (a, b) } else { (b, a) };
        self.joints.push([a, b]);
        self.arms.push([random.vector(), random.vector()]);
        self.separations.push(random.vector() * 0.01);
        self.targets.push(random.vector());
    }

    /// `n` bodies, each hung from one that `parent` chooses among those before.
    fn tree(n: u32, random: &mut Random, parent: impl Fn(u32, &mut Random) -> u32) -> Self {
        let mut assembly = Self::new();
        for body in 0..n {
            assembly.body(random.within(0.2, 5.0), random);
            if body > 0 {
                let parent = parent(body, random);
                assembly.join(parent, body, random);
            }
        }
        assembly
    }

    fn pin(&mut self, body: u32, random: &mut Random) {
        let fixed = self.fixed(random);
        self.join(fixed, body, random);
    }

    fn lock(&mut self, body: usize, linear: usize, angular: usize) {
        self.inverse_masses[body][linear] = 0.0;
        self.inverse_inertias[body].column_mut(angular).fill(0.0);
        self.inverse_inertias[body].row_mut(angular).fill(0.0);
    }

    /// Trees of the joints, factored.
    fn trees(&self) -> Vec<JointTree> {
        let partition = partition(&self.joints, &self.moves);
        assert!(partition.left_over.is_empty());
        let mut trees = partition.trees;
        for tree in &mut trees {
            self.prepare(tree);
        }
        trees
    }

    fn prepare(&self, tree: &mut JointTree) {
        for local in 0..tree.moving() {
            let body = tree.bodies()[local] as usize;
            tree.set_inertia(local, self.inverse_masses[body], self.inverse_inertias[body]);
        }
        for local in 0..tree.joints().len() {
            let joint = tree.joints()[local] as usize;
            let [arm_a, arm_b] = self.arms[joint];
            tree.set_arms(local, arm_a, arm_b);
        }
        tree.factor();
    }

    fn of_joints<T: Copy>(tree: &JointTree, values: &[T]) -> Vec<T> {
        tree.joints().iter().map(|&joint| values[joint as usize]).collect()
    }

    /// Solves velocities by trees; the impulses on each b.
    fn solve(&mut self) -> Vec<Vector3<f64>> {
        let mut impulses = vec![Vector3::repeat(f64::NAN); self.joints.len()];
        for mut tree in self.trees() {
            let mut twists: Vec<_> = tree.bodies().iter().map(|&body| self.twists[body as usize]).collect();
            let targets = Self::of_joints(&tree, &self.targets);
            tree.solve_velocities(&mut twists, &targets);
            for (&body, twist) in tree.bodies().iter().zip(&twists) {
                self.twists[body as usize] = *twist;
            }
            for (local, &joint) in tree.joints().iter().enumerate() {
                impulses[joint as usize] = tree.impulse(local);
            }
        }
        impulses
    }

    /// Positions of the centres of mass at which every joint of a tree is closed.
    fn closed_positions(&self) -> Vec<Vector3<f64>> {
        let mut positions: Vec<Option<Vector3<f64>>> = vec![None; self.moves.len()];
        positions[0] = Some(Vector3::zeros());
        while positions.contains(&None) {
            for (&[a, b], arms) in self.joints.iter().zip(&self.arms) {
                let (a, b) = (a as usize, b as usize);
                match (positions[a], positions[b]) {
                    (Some(at), None) => positions[b] = Some(at + arms[0] - arms[1]),
                    (None, Some(at)) => positions[a] = Some(at + arms[1] - arms[0]),
                    _ => {}
                }
            }
        }
        positions.into_iter().flatten().collect()
    }

    /// Moves and turns one body: its arms and the separations of its joints follow.
    fn turn(&mut self, body: u32, linear: Vector3<f64>, rotation: &UnitQuaternion<f64>) {
        for (joint, bodies) in self.joints.iter().enumerate() {
            for (side, sign) in [(0, -1.0), (1, 1.0)] {
                if bodies[side] == body {
                    let turned = rotation * self.arms[joint][side];
                    self.separations[joint] += (linear + turned - self.arms[joint][side]) * sign;
                    self.arms[joint][side] = turned;
                }
            }
        }
    }

    /// J and M⁻¹, dense.
    fn dense(&self) -> (DMatrix<f64>, DMatrix<f64>) {
        let (rows, columns) = (3 * self.joints.len(), 6 * self.moves.len());
        let mut jacobian = DMatrix::zeros(rows, columns);
        for (joint, (bodies, arms)) in self.joints.iter().zip(&self.arms).enumerate() {
            for (side, sign) in [(0, -1.0), (1, 1.0)] {
                let column = 6 * bodies[side] as usize;
                jacobian.fixed_view_mut::<3, 3>(3 * joint, column).copy_from(&(Matrix3::identity() * sign));
                let cross = -arms[side].cross_matrix() * sign;
                jacobian.fixed_view_mut::<3, 3>(3 * joint, column + 3).copy_from(&cross);
            }
        }
        let mut inverse_mass = DMatrix::zeros(columns, columns);
        for body in 0..self.moves.len() {
            let linear = Matrix3::from_diagonal(&self.inverse_masses[body]);
            inverse_mass.fixed_view_mut::<3, 3>(6 * body, 6 * body).copy_from(&linear);
            inverse_mass.fixed_view_mut::<3, 3>(6 * body + 3, 6 * body + 3).copy_from(&self.inverse_inertias[body]);
        }
        (jacobian, inverse_mass)
    }

    fn velocities(&self) -> DVector<f64> {
        let all = self.twists.iter().flat_map(|twist| twist.linear.iter().chain(twist.angular.iter()).copied());
        DVector::from_iterator(6 * self.twists.len(), all)
    }

    /// Impulses by a dense solution of the same system.
    fn dense_impulses(&self) -> DVector<f64> {
        let (jacobian, inverse_mass) = self.dense();
        let matrix = &jacobian * inverse_mass * jacobian.transpose();
        let targets = self.targets.iter().flat_map(|target| target.iter().copied());
        let targets = DVector::from_iterator(3 * self.joints.len(), targets);
        matrix.cholesky().expect("independent rows").solve(&(targets - jacobian * self.velocities()))
    }

    /// max |b − J V| over the joints.
    fn velocity_error(&self) -> f64 {
        let velocity = |body: u32, arm: &Vector3<f64>| {
            let twist = &self.twists[body as usize];
            twist.linear + twist.angular.cross(arm)
        };
        let errors = self
            .joints
            .iter()
            .zip(&self.arms)
            .zip(&self.targets)
            .map(|((&[a, b], arms), target)| (velocity(b, &arms[1]) - velocity(a, &arms[0]) - target).norm());
        errors.fold(0.0, f64::max)
    }
}

/// Trees that between them have every kind of joint: chains, stars, hubs beside hubs, links at the
/// root, several components, pins on leaves, links and hubs.
fn assemblies(random: &mut Random) -> Vec<Assembly> {
    let mut list = vec![
        Assembly::tree(2, random, |_, _| 0),
        Assembly::tree(3, random, |body, _| body - 1),
        Assembly::tree(11, random, |body, _| body - 1),
        Assembly::tree(12, random, |body, _| body - 1),
        Assembly::tree(9, random, |_, _| 0),
        Assembly::tree(15, random, |body, _| (body - 1) / 2),
        Assembly::tree(20, random, |body, _| body.saturating_sub(3)),
    ];
    for _ in 0..20 {
        list.push(Assembly::tree(20, random, |body, random| (random.unit() * f64::from(body)) as u32));
    }
    for (index, assembly) in list.iter_mut().enumerate() {
        let last = assembly.moves.len() as u32 - 1;
        match index % 4 {
            0 => {}
            1 => assembly.pin(0, random),
            2 => {
                assembly.pin(0, random);
                assembly.pin(last, random);
            }
            _ => {
                // A second component, and a body that nothing holds.
                assembly.body(1.0, random);
                let (a, b) = (assembly.body(2.0, random), assembly.body(3.0, random));
                assembly.join(a, b, random);
                assembly.pin(last / 2, random);
            }
        }
    }
    list
}
