//! Questions about where bodies are, by `PhysicsQuery` and by parry, on the same bodies: a thousand of one kind each, of all
//! kinds, and of all kinds over a ground of 10 000 triangles. Each run is a thousand questions on one thread.
//!
//! `cargo bench --profile measure --no-default-features --features lab --bench queries`
//!
//! Parry is asked as Rapier's query pipeline asks it: its tree over the bodies' boxes, and its own dispatch for each pair of
//! shapes. Both know `f64`. Before the clock starts the answers are compared; where they differ, it is told how often.

use std::time::Duration;

use bevy::ecs::system::SystemState;
use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use criterion::{Criterion, criterion_group, criterion_main};
use parry3d_f64::bounding_volume::BoundingVolume;
use parry3d_f64::math::{Pose, Rotation as Rot, Vector};
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy, BvhNode};
use parry3d_f64::query::details::{NormalConstraints, ShapeCastOptions};
use parry3d_f64::query::{DefaultQueryDispatcher, QueryDispatcher};
use parry3d_f64::shape::{CompositeShape, CompositeShapeRef, SharedShape, TypedCompositeShape};
use plumb::physics::{CompoundChild, Shape, TriangleMesh};
use plumb::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

const BODIES: usize = 1000;
const QUESTIONS: usize = 1000;

/// Half the sides of the room that bodies are in, m.
const ROOM: DVec3 = DVec3::new(20.0, 5.0, 20.0);

/// How far rays and casts go and the nearest point is sought, m.
const FAR: f64 = 30.0;

/// How far answers of the two may differ, m: parry's iterations end where they change no more than about that.
const SAME: f64 = 1e-5;

const KINDS: [&str; 7] = ["balls", "boxes", "capsules", "cylinders", "cones", "hulls", "compounds"];

struct Dice(Pcg64Mcg);

impl Dice {
    fn within(&mut self, low: f64, high: f64) -> f64 {
        self.0.random_range(low..high)
    }

    fn vector(&mut self, size: DVec3) -> DVec3 {
        DVec3::from_array(size.to_array().map(|size| self.within(-size, size)))
    }

    fn rotation(&mut self) -> DQuat {
        DQuat::from_scaled_axis(self.vector(DVec3::splat(2.0)))
    }

    fn collider(&mut self, kind: usize) -> Collider {
        match kind {
            0 => Collider::sphere(self.within(0.2, 0.6)),
            1 => Collider::cuboid(self.within(0.3, 1.2), self.within(0.3, 1.2), self.within(0.3, 1.2)),
            2 => Collider::capsule(self.within(0.1, 0.4), self.within(0.2, 1.0)),
            3 => Collider::cylinder(self.within(0.2, 0.6), self.within(0.3, 1.2)),
            4 => Collider::cone(self.within(0.2, 0.7), self.within(0.4, 1.4)),
            5 => {
                let points: Vec<DVec3> =
                    (0..16).map(|_| self.vector(DVec3::ONE).normalize_or(DVec3::X) * 0.6).collect();
                Collider::convex_hull(&points).expect("points that span a volume")
            }
            _ => {
                let children = [0, 1, 3].map(|kind| CompoundChild {
                    collider: self.collider(kind),
                    position: self.vector(DVec3::splat(0.5)),
                    rotation: self.rotation(),
                });
                Collider::compound(&children).expect("solids")
            }
        }
    }
}

fn to_parry(vector: DVec3) -> Vector {
    Vector::from_array(vector.to_array())
}

fn pose(position: DVec3, rotation: DQuat) -> Pose {
    Pose { rotation: Rot::from_array(rotation.to_array()), translation: to_parry(position) }
}

/// The same shape, where it is.
fn to_parry_shape(collider: &Collider, position: DVec3, rotation: DQuat) -> (Pose, SharedShape) {
    let at = pose(position, rotation);
    match collider.shape() {
        &Shape::Sphere { radius } => (at, SharedShape::ball(radius)),
        Shape::Cuboid { size } => (at, SharedShape::cuboid(size.x / 2.0, size.y / 2.0, size.z / 2.0)),
        &Shape::Capsule { radius, length } => (at, SharedShape::capsule_y(length / 2.0, radius)),
        &Shape::Cylinder { radius, height } => (at, SharedShape::cylinder(height / 2.0, radius)),
        &Shape::Cone { radius, height } => {
            // About the middle of its height.
            let middle = position + rotation * DVec3::Y * (height / 4.0);
            (pose(middle, rotation), SharedShape::cone(height / 2.0, radius))
        }
        Shape::Hull(hull) => {
            let points: Vec<Vector> = hull.vertices().map(to_parry).collect();
            (at, SharedShape::convex_hull(&points).expect("it is a hull"))
        }
        Shape::Compound(compound) => {
            let child = |child: &CompoundChild| to_parry_shape(&child.collider, child.position, child.rotation);
            (at, SharedShape::compound(compound.children().iter().map(child).collect()))
        }
        Shape::Mesh(mesh) => {
            let vertices = mesh.vertices().map(to_parry).collect();
            (at, SharedShape::trimesh(vertices, mesh.triangles().to_vec()).expect("it is a mesh"))
        }
        Shape::HalfSpace => (at, SharedShape::halfspace(Vector::Y)),
    }
}

/// Bodies as parry has them.
struct Peer {
    bodies: Vec<(Pose, SharedShape)>,
    tree: Bvh,
}

impl Peer {
    fn new(bodies: Vec<(Pose, SharedShape)>) -> Self {
        let boxes = bodies.iter().map(|(pose, shape)| shape.compute_aabb(pose)).enumerate();
        let tree = Bvh::from_iter(BvhBuildStrategy::Binned, boxes);
        Self { bodies, tree }
    }
}

impl CompositeShape for Peer {
    fn map_part_at(
        &self,
        part: u32,
        look: &mut dyn FnMut(Option<&Pose>, &dyn parry3d_f64::shape::Shape, Option<&dyn NormalConstraints>),
    ) {
        self.map_untyped_part_at(part, look);
    }

    fn bvh(&self) -> &Bvh {
        &self.tree
    }
}

impl TypedCompositeShape for Peer {
    type PartShape = dyn parry3d_f64::shape::Shape;
    type PartNormalConstraints = ();

    fn map_typed_part_at<T>(
        &self,
        part: u32,
        mut look: impl FnMut(Option<&Pose>, &Self::PartShape, Option<&()>) -> T,
    ) -> Option<T> {
        let (pose, shape) = self.bodies.get(part as usize)?;
        Some(look(Some(pose), &*shape.0, None))
    }

    fn map_untyped_part_at<T>(
        &self,
        part: u32,
        mut look: impl FnMut(Option<&Pose>, &dyn parry3d_f64::shape::Shape, Option<&dyn NormalConstraints>) -> T,
    ) -> Option<T> {
        let (pose, shape) = self.bodies.get(part as usize)?;
        Some(look(Some(pose), &*shape.0, None))
    }
}

/// A shape that is cast from a place, or overlaps what is there.
struct Probe {
    collider: Collider,
    position: DVec3,
    rotation: DQuat,
    peer: (Pose, SharedShape),
}

impl Probe {
    fn placed(&self) -> PlacedCollider<'_> {
        PlacedCollider {
            collider: &self.collider,
            position: Position(self.position),
            rotation: Rotation(self.rotation),
        }
    }
}

/// The same bodies and questions for both.
struct Questions {
    world: World,
    peer: Peer,
    rays: Vec<Ray>,
    points: Vec<DVec3>,
    probes: Vec<Probe>,
}

impl Questions {
    fn new(kinds: &[usize], has_ground: bool) -> Self {
        let mut dice = Dice(Pcg64Mcg::seed_from_u64(1));
        let mut world = std::mem::take(headless_app().world_mut());
        let mut bodies = Vec::new();
        let mut add = |collider: Collider, position: DVec3, rotation: DQuat| {
            bodies.push(to_parry_shape(&collider, position, rotation));
            world.spawn((RigidBody::Static, collider, Position(position), Rotation(rotation)));
        };
        for body in 0..BODIES {
            add(dice.collider(kinds[body % kinds.len()]), dice.vector(ROOM), dice.rotation());
        }
        if has_ground {
            let height = |x: f64, z: f64| 0.7 * (0.9 * x).sin() * (0.8 * z).cos();
            let ground = TriangleMesh::height_field([3.0 * ROOM.x, 3.0 * ROOM.z], [100, 50], height);
            add(Collider::mesh(ground.expect("a ground")), DVec3::NEG_Y * (ROOM.y + 1.0), DQuat::IDENTITY);
        }
        step(&mut world);
        let rays = (0..QUESTIONS).map(|_| Ray { length: FAR, ..Ray::new(dice.vector(ROOM), dice.vector(DVec3::ONE)) });
        let rays: Vec<Ray> = rays.collect();
        let points = (0..QUESTIONS).map(|_| dice.vector(ROOM)).collect();
        let probe = |probe: usize| {
            let collider = dice.collider(kinds[probe % kinds.len()]);
            let (position, rotation) = (dice.vector(ROOM), dice.rotation());
            let peer = to_parry_shape(&collider, position, rotation);
            Probe { collider, position, rotation, peer }
        };
        let probes = (0..QUESTIONS).map(probe).collect();
        Self { world, peer: Peer::new(bodies), rays, points, probes }
    }
}

fn ray_of_peer(peer: &Peer, ray: &Ray) -> Option<f64> {
    let unit = ray.direction.normalize();
    let ray = parry3d_f64::query::Ray::new(to_parry(ray.origin), to_parry(unit));
    let hit = CompositeShapeRef(peer).cast_local_ray_and_get_normal(&ray, FAR, true)?;
    Some(hit.1.time_of_impact)
}

fn nearest_of_peer(peer: &Peer, point: DVec3) -> Option<f64> {
    let point = to_parry(point);
    let (_, found) = CompositeShapeRef(peer).project_local_point(point, FAR, true)?;
    Some(if found.is_inside { 0.0 } else { (found.point - point).length() })
}

fn cast_of_peer(peer: &Peer, probe: &Probe, way: DVec3) -> Option<f64> {
    let options = ShapeCastOptions::with_max_time_of_impact(FAR);
    let unit = to_parry(way.normalize());
    let (pose, shape) = &probe.peer;
    let (_, hit) = CompositeShapeRef(peer).cast_shape(&DefaultQueryDispatcher, pose, unit, &*shape.0, options)?;
    Some(hit.time_of_impact)
}

fn overlaps_of_peer(peer: &Peer, probe: &Probe) -> Vec<u32> {
    let (pose, shape) = &probe.peer;
    let bounds = shape.compute_aabb(pose);
    let near = peer.tree.leaves(|node: &BvhNode| node.aabb().intersects(&bounds));
    let touches = |other: &u32| {
        let (at, other) = &peer.bodies[*other as usize];
        DefaultQueryDispatcher
            .intersection_test(&at.inv_mul(pose), &*other.0, &*shape.0)
            .is_ok_and(|it| it.intersecting)
    };
    near.filter(touches).collect()
}

fn overlap_of_peer(peer: &Peer, probe: &Probe) -> bool {
    let (pose, shape) = &probe.peer;
    CompositeShapeRef(peer).intersects_shape(&DefaultQueryDispatcher, pose, &*shape.0).is_some()
}

/// Tells of how many questions the answers differ.
fn compare(name: &str, one: impl Iterator<Item = Option<f64>>, other: impl Iterator<Item = Option<f64>>) {
    let (mut found, mut differ) = (0, Vec::new());
    for (question, (one, other)) in one.zip(other).enumerate() {
        found += usize::from(one.is_some());
        let is_same = match (one, other) {
            (Some(one), Some(other)) => (one - other).abs() <= SAME,
            (one, other) => one == other,
        };
        if !is_same {
            differ.push((question, one, other));
        }
    }
    println!("{name}: {found} found; {} answers differ {:?}", differ.len(), &differ[..differ.len().min(5)]);
    assert!(differ.len() <= QUESTIONS / 50, "that is too many");
}

fn measure(criterion: &mut Criterion, name: &str, kinds: &[usize], has_ground: bool) {
    let Questions { mut world, peer, rays, points, probes } = Questions::new(kinds, has_ground);
    let mut state = SystemState::<PhysicsQuery>::new(&mut world);
    let query = state.get(&world).expect("all that a question needs is there");
    let all = QueryFilter::default();
    let way = |place: usize| rays[place].direction;

    let ray = |ray: &Ray| query.ray(ray, &all).map(|hit| hit.distance);
    let nearest = |&point: &DVec3| query.nearest_point(point, FAR, &all).map(|hit| hit.distance);
    let cast =
        |place: usize, probe: &Probe| query.shape_cast(&probe.placed(), way(place), FAR, &all).map(|hit| hit.distance);
    let overlaps = |probe: &Probe| query.overlap_all(&probe.placed(), &all).len();
    let overlap = |probe: &Probe| query.overlap(&probe.placed(), &all).is_some();

    compare(&format!("{name}, ray"), rays.iter().map(ray), rays.iter().map(|ray| ray_of_peer(&peer, ray)));
    compare(
        &format!("{name}, nearest point"),
        points.iter().map(nearest),
        points.iter().map(|&point| nearest_of_peer(&peer, point)),
    );
    compare(
        &format!("{name}, shape cast"),
        probes.iter().enumerate().map(|(place, probe)| cast(place, probe)),
        probes.iter().enumerate().map(|(place, probe)| cast_of_peer(&peer, probe, way(place))),
    );
    compare(
        &format!("{name}, overlaps"),
        probes.iter().map(|probe| Some(overlaps(probe) as f64)),
        probes.iter().map(|probe| Some(overlaps_of_peer(&peer, probe).len() as f64)),
    );

    let mut group = criterion.benchmark_group(name);
    group.sample_size(20).measurement_time(Duration::from_secs(1)).warm_up_time(Duration::from_millis(200));
    macro_rules! both {
        ($question:literal, $of_each:expr, $own:expr, $of_peer:expr) => {
            group.bench_function(concat!($question, ", Plumb"), |bencher| {
                bencher.iter(|| $of_each.filter(|it| $own(it)).count());
            });
            group.bench_function(concat!($question, ", parry"), |bencher| {
                bencher.iter(|| $of_each.filter(|it| $of_peer(it)).count());
            });
        };
    }
    both!("ray", rays.iter(), |it: &&Ray| ray(it).is_some(), |it: &&Ray| ray_of_peer(&peer, it).is_some());
    both!("nearest point", points.iter(), |it: &&DVec3| nearest(it).is_some(), |it: &&DVec3| nearest_of_peer(
        &peer, **it
    )
    .is_some());
    both!("shape cast", probes.iter().enumerate(), |it: &(usize, &Probe)| cast(it.0, it.1).is_some(), |it: &(
        usize,
        &Probe
    )| {
        cast_of_peer(&peer, it.1, way(it.0)).is_some()
    });
    both!("overlap", probes.iter(), |it: &&Probe| overlap(it), |it: &&Probe| overlap_of_peer(&peer, it));
    both!("all overlaps", probes.iter(), |it: &&Probe| overlaps(it) > 0, |it: &&Probe| !overlaps_of_peer(&peer, it)
        .is_empty());
    group.finish();
}

fn questions(criterion: &mut Criterion) {
    let all: Vec<usize> = (0..KINDS.len()).collect();
    measure(criterion, "all kinds over a mesh", &all, true);
    measure(criterion, "all kinds", &all, false);
    for (kind, name) in KINDS.into_iter().enumerate() {
        measure(criterion, name, &[kind], false);
    }
}

criterion_group!(benches, questions);
criterion_main!(benches);
