//! The sparse block factorisation against `faer`'s sparse LDLᵀ, on the matrices of two scenes and a heap.
//!
//! `cargo bench --profile measure --no-default-features --features lab --bench factorisation`
//!
//! Of joints J M⁻¹ Jᵀ, 3 × 3 blocks on the graph of the joints, as the exact method has it; of contacts M + Σ ρJᵀJ, 6 × 6
//! blocks on the graph of the bodies, as the direct method has it. Geometry and connections are the scene's, masses and
//! inertias one: the work depends on the structure alone. Both sides find their own order of elimination, once, and then
//! factor and solve again and again, on one thread.

use std::collections::HashMap;

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use criterion::{Criterion, criterion_group, criterion_main};
use faer::Conj;
use faer::Par;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::ldlt::factor::LdltRegularization;
use faer::sparse::linalg::cholesky::{CholeskySymbolicParams, LdltRef, SymmetricOrdering, factorize_symbolic_cholesky};
use faer::sparse::{SparseColMat, Triplet};
use faer::{MatMut, Side};
use linear::elimination::Elimination;
use linear::ldl::BlockLdl;
use linear::pivot::{Inverse, Pivot, Triangular};
use nalgebra::{Matrix3, SMatrix, Vector3};
use plumb::physics::ContactForces;
use plumb::prelude::*;

// The factorisation stands on its own: it is compiled into this benchmark, so that nothing of it need be public.
#[allow(dead_code)]
#[path = "../src/physics/solver/linear"]
mod linear {
    pub mod elimination;
    pub mod layout;
    pub mod ldl;
    pub mod ordering;
    pub mod pivot;
}

// Its tests do not run here, so that what they import is unused.
#[allow(dead_code, unused_imports)]
#[path = "../src/physics"]
mod physics {
    pub mod bit_set;
}

/// Added to the diagonal of J M⁻¹ Jᵀ, as the exact method does where loops make rows redundant.
const SHIFT: f64 = 1e-6;
/// Weight ρ of the rows of contacts over a body's mass, as in the direct method.
const WEIGHT: f64 = 1e4;

/// Blocks of a symmetric matrix of R rows each: on the diagonal, and one for each edge a < b, rows of b.
struct Blocks<const R: usize> {
    diagonal: Vec<SMatrix<f64, R, R>>,
    edges: HashMap<[u32; 2], SMatrix<f64, R, R>>,
}

impl<const R: usize> Blocks<R> {
    fn add(&mut self, a: u32, b: u32, block: SMatrix<f64, R, R>) {
        let (key, block) = if a < b { ([a, b], block.transpose()) } else { ([b, a], block) };
        *self.edges.entry(key).or_insert_with(SMatrix::zeros) += block;
    }
}

fn world(scene: &str, parameters: &[(&str, f64)]) -> App {
    let parameters: Vec<_> = parameters.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
    let spec = plumb::scene::load(scene, &parameters).expect("a built-in scene");
    let mut app = headless_app();
    spec.spawn(app.world_mut());
    step(app.world_mut());
    app
}

/// Bodies that move, with their poses.
fn bodies(app: &mut App) -> HashMap<Entity, (u32, Vector3<f64>)> {
    let mut query = app.world_mut().query::<(Entity, &RigidBody, &Position)>();
    let moving = query.iter(app.world()).filter(|(_, body, _)| **body == RigidBody::Dynamic);
    let mut list: Vec<_> = moving.map(|(entity, _, position)| (entity, position.0)).collect();
    list.sort_unstable_by_key(|(entity, _)| *entity);
    let place =
        |(index, (entity, at)): (usize, (Entity, DVec3))| (entity, (index as u32, Vector3::new(at.x, at.y, at.z)));
    list.into_iter().enumerate().map(place).collect()
}

/// J M⁻¹ Jᵀ of a scene's ball joints.
fn joints(scene: &str, parameters: &[(&str, f64)]) -> Blocks<3> {
    let mut app = world(scene, parameters);
    let bodies = bodies(&mut app);
    let mut query = app.world_mut().query::<&BallJoint>();
    let joints: Vec<BallJoint> = query.iter(app.world()).copied().collect();
    // Joints at each body: index, arm, sign.
    let mut at: HashMap<u32, Vec<(u32, Matrix3<f64>, f64)>> = HashMap::new();
    for (index, joint) in (0..).zip(&joints) {
        for (body, anchor, sign) in [(joint.body_a, joint.anchor_a, -1.0), (joint.body_b, joint.anchor_b, 1.0)] {
            if let Some(&(place, _)) = bodies.get(&body) {
                let arm = Vector3::new(anchor.x, anchor.y, anchor.z).cross_matrix();
                at.entry(place).or_default().push((index, arm, sign));
            }
        }
    }
    let mut blocks = Blocks { diagonal: vec![Matrix3::zeros(); joints.len()], edges: HashMap::new() };
    for list in at.values() {
        for (place, (one, arm, sign)) in list.iter().enumerate() {
            blocks.diagonal[*one as usize] += Matrix3::identity() * (1.0 + SHIFT) - arm * arm;
            for (other, other_arm, other_sign) in &list[..place] {
                blocks.add(*one, *other, (Matrix3::identity() - arm * other_arm) * (sign * other_sign));
            }
        }
    }
    blocks
}

/// Boxes of 0.3 to 0.8 m, dropped in layers of five by five between four walls, after ten seconds.
fn heap(count: usize) -> App {
    let mut app = headless_app();
    app.init_resource::<ContactForces>();
    let world = app.world_mut();
    world.spawn((RigidBody::Static, Collider::half_space()));
    for (x, z) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)] {
        let size = DVec3::new(0.5 + 6.0 * f64::abs(z), 10.0, 0.5 + 6.0 * f64::abs(x));
        let wall = Collider::cuboid(size.x, size.y, size.z);
        world.spawn((RigidBody::Static, wall, Position(DVec3::new(3.0 * x, 5.0, 3.0 * z))));
    }
    for index in 0..count {
        // The fractional parts of multiples of an irrational number fill [0, 1) evenly.
        let random = |multiple: f64| (multiple * (index + 1) as f64 * 0.618_033_988_749).fract();
        let [x, y, z] = [1.0, 1.7, 2.9].map(|multiple| 0.3 + 0.5 * random(multiple));
        let place = DVec3::new((index % 5) as f64 - 2.0, 1.0 + (index / 25) as f64, (index / 5 % 5) as f64 - 2.0);
        let turn = DQuat::from_axis_angle(DVec3::new(x, y, z).normalize(), 6.0 * random(3.7));
        world.spawn((RigidBody::Dynamic, Collider::cuboid(x, y, z), Position(place), Rotation(turn)));
    }
    (0..600).for_each(|_| step(app.world_mut()));
    app
}

/// M + Σ ρJᵀJ of the contacts of a world.
fn contacts(mut app: App) -> Blocks<6> {
    let bodies = bodies(&mut app);
    let mut blocks = Blocks { diagonal: vec![SMatrix::identity(); bodies.len()], edges: HashMap::new() };
    for contact in &app.world().resource::<ContactForces>().0 {
        let point = Vector3::new(contact.point.x, contact.point.y, contact.point.z);
        let sides = [(contact.a, -1.0), (contact.b, 1.0)].map(|(entity, sign)| {
            bodies.get(&entity).map(|(place, centre)| {
                let mut jacobian = SMatrix::<f64, 3, 6>::zeros();
                jacobian.fixed_columns_mut::<3>(0).fill_with_identity();
                jacobian.fixed_columns_mut::<3>(3).copy_from(&-(point - centre).cross_matrix());
                (*place, jacobian * sign)
            })
        });
        for (place, jacobian) in sides.iter().flatten() {
            blocks.diagonal[*place as usize] += WEIGHT * jacobian.tr_mul(jacobian);
        }
        if let [Some((a, of_a)), Some((b, of_b))] = &sides {
            blocks.add(*a, *b, WEIGHT * of_a.tr_mul(of_b));
        }
    }
    blocks
}

/// Times of both on one matrix.
fn compare<const R: usize, P: Pivot<f64> + Clone + Default>(criterion: &mut Criterion, name: &str, blocks: &Blocks<R>) {
    let count = blocks.diagonal.len();
    let elimination = Elimination::new(&vec![R as u8; count], blocks.edges.keys().copied(), usize::MAX);
    let elimination = elimination.expect("no bound on the work");
    let mut ldl = BlockLdl::<f64, P>::default();
    let mut fill = || {
        ldl.clear(&elimination);
        for (node, block) in blocks.diagonal.iter().enumerate() {
            ldl.diagonal_mut::<R>(elimination.place(node as u32) as usize).copy_from(block);
        }
        for (&[a, b], block) in &blocks.edges {
            ldl.add(elimination.block(b, a), block);
        }
        ldl.clone()
    };
    let mut factor = fill();
    let original = factor.clone();
    assert!(factor.factor(&elimination));

    let entry = |row: usize, column: usize, value: f64| Triplet::new(row, column, value);
    let mut triplets = Vec::new();
    for (node, block) in blocks.diagonal.iter().enumerate() {
        for (row, column) in (0..R).flat_map(|row| (0..=row).map(move |column| (row, column))) {
            triplets.push(entry(R * node + row, R * node + column, block[(row, column)]));
        }
    }
    for (&[a, b], block) in &blocks.edges {
        for (row, column) in (0..R).flat_map(|row| (0..R).map(move |column| (row, column))) {
            triplets.push(entry(R * b as usize + row, R * a as usize + column, block[(row, column)]));
        }
    }
    let matrix = SparseColMat::<usize, f64>::try_new_from_triplets(R * count, R * count, &triplets);
    let matrix = matrix.expect("places within the matrix");
    let parameters = CholeskySymbolicParams::default();
    let symbolic = factorize_symbolic_cholesky(matrix.symbolic(), Side::Lower, SymmetricOrdering::Amd, parameters);
    let symbolic = symbolic.expect("memory");
    let mut values = vec![0.0; symbolic.len_val()];
    let scratch = symbolic.factorize_numeric_ldlt_scratch::<f64>(Par::Seq, Default::default());
    let mut memory = MemBuffer::new(scratch.or(symbolic.solve_in_place_scratch::<f64>(1, Par::Seq)));
    println!(
        "{name}: {count} blocks of {R} rows, {} blocks below the diagonal of the factor; faer keeps {} numbers, this {}",
        elimination.below(),
        symbolic.len_val(),
        R * R * (count + elimination.below()),
    );

    let mut group = criterion.benchmark_group(name);
    group.bench_function("factor: blocks", |bencher| {
        bencher.iter(|| {
            factor.clone_from(&original);
            factor.factor(&elimination)
        });
    });
    group.bench_function("factor: faer", |bencher| {
        bencher.iter(|| {
            let stack = MemStack::new(&mut memory);
            let none = LdltRegularization::default();
            let lower = matrix.as_ref();
            symbolic
                .factorize_numeric_ldlt(&mut values, lower, Side::Lower, none, Par::Seq, stack, Default::default())
                .is_ok()
        });
    });
    let mut x = vec![1.0; R * count];
    group.bench_function("solve: blocks", |bencher| {
        bencher.iter(|| {
            x.fill(1.0);
            factor.solve(&elimination, &mut x[..]);
        });
    });
    let mut y = vec![1.0; R * count];
    group.bench_function("solve: faer", |bencher| {
        bencher.iter(|| {
            y.fill(1.0);
            let ldlt = LdltRef::new(&symbolic, &values);
            let side = MatMut::from_column_major_slice_mut(&mut y, R * count, 1);
            ldlt.solve_in_place_with_conj(Conj::No, side, Par::Seq, MemStack::new(&mut memory));
        });
    });
    group.finish();
    let largest = y.iter().fold(0.0, |most: f64, y| most.max(y.abs()));
    for node in 0..count {
        let place = elimination.place(node as u32) as usize;
        for row in 0..R {
            let (one, other) = (x[R * place + row], y[R * node + row]);
            assert!((one - other).abs() < 1e-6 * largest, "{name}: {one}, faer {other}");
        }
    }
}

fn factorisations(criterion: &mut Criterion) {
    compare::<3, Triangular>(criterion, "joint_grid 30", &joints("joint_grid", &[("n", 30.0)]));
    compare::<3, Triangular>(criterion, "limbs", &joints("limbs", &[]));
    compare::<6, Inverse>(criterion, "heap of 200 boxes", &contacts(heap(200)));
}

criterion_group!(benches, factorisations);
criterion_main!(benches);
