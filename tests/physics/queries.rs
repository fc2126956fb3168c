//! Questions about where bodies are, against other ways to find out.
//!
//! A million cases of each shape, by hand: `cargo test --no-default-features --features lab --test physics queries --
//! --ignored --nocapture`

use bevy::ecs::system::SystemState;
use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use plumb::physics::{CompoundChild, TriangleMesh};
use plumb::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::query_truth::{Solid, apart_by_search, apart_on_a_way, solids_of};
use crate::rig::*;

/// Cases of each test that compares with another way: of seconds on one core at opt-level 1.
const CASES: usize = 10_000;

/// Cases with each shape of those that are run by hand.
const MANY: usize = 1_000_000;

/// How deep a ray may graze what it is not said to meet, and how far from a surface a point may be that is on it, m. Of two
/// shapes, as a share of the sum of their sizes, the distance up to which they count as touching.
const GRAZING: f64 = 1e-9;

/// Questions about each body of a world, which is costly to make.
const QUESTIONS: usize = 20;

/// The kinds of shapes.
const KINDS: usize = 9;

/// The kinds that can be cast.
const MOVERS: [usize; 7] = [0, 1, 2, 3, 4, 5, 6];

struct Dice(Pcg64Mcg);

impl Dice {
    fn new(seed: u64) -> Self {
        Self(Pcg64Mcg::seed_from_u64(seed))
    }

    fn within(&mut self, low: f64, high: f64) -> f64 {
        self.0.random_range(low..high)
    }

    fn vector(&mut self, size: f64) -> DVec3 {
        DVec3::from_array([0; 3].map(|_| self.within(-size, size)))
    }

    fn rotation(&mut self) -> DQuat {
        let axis = loop {
            let axis = self.vector(1.0);
            if (0.01..1.0).contains(&axis.length_squared()) {
                break axis.normalize();
            }
        };
        DQuat::from_axis_angle(axis, self.within(-3.0, 3.0))
    }

    /// One of each kind of shape in turn.
    fn collider(&mut self, kind: usize) -> Collider {
        match kind % KINDS {
            0 => Collider::sphere(self.within(0.2, 1.0)),
            1 => Collider::cuboid(self.within(0.2, 2.0), self.within(0.2, 2.0), self.within(0.2, 2.0)),
            2 => Collider::cone(self.within(0.2, 1.0), self.within(0.3, 2.0)),
            3 => {
                // Of flat faces: facets that are nearly in one plane are merged, and are not where they were. So are those of
                // what is nearly flat itself.
                let sides = loop {
                    let sides =
                        [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| axis * self.within(0.3, 1.0) + self.vector(0.2));
                    let [x, y, z] = sides;
                    if x.dot(y.cross(z)) > 0.3 * x.length() * y.length() * z.length() {
                        break sides;
                    }
                };
                let points: Vec<DVec3> = match self.0.random_range(0..2) {
                    0 => sides.into_iter().flat_map(|side| [side, -side]).collect(),
                    _ => (0..8)
                        .map(|corner| (0..3).map(|axis| sides[axis] * [1.0, -1.0][corner >> axis & 1]).sum())
                        .collect(),
                };
                Collider::convex_hull(&points).expect("points that span a volume")
            }
            4 => Collider::cylinder(self.within(0.1, 0.8), self.within(0.1, 1.5)),
            5 => Collider::capsule(self.within(0.1, 0.6), self.within(0.1, 1.5)),
            6 => {
                let first = self.0.random_range(0..6);
                let children = [first, (first + 1) % 6, (first + 3) % 6].map(|kind| CompoundChild {
                    collider: self.collider(kind),
                    position: self.vector(1.0),
                    rotation: self.rotation(),
                });
                Collider::compound(&children).expect("solids")
            }
            7 => {
                // About its middle, by octants: the surface of a solid that is not convex.
                let ends = [DVec3::X, DVec3::Y, DVec3::Z]
                    .map(|axis| [axis * self.within(0.2, 1.5), -axis * self.within(0.2, 1.5)]);
                let vertices: Vec<DVec3> = ends.into_iter().flatten().collect();
                let triangle = |octant: u32| {
                    let [x, y, z] = [0, 1, 2].map(|axis| 2 * axis + (octant >> axis & 1));
                    if octant.count_ones().is_multiple_of(2) { [x, y, z] } else { [x, z, y] }
                };
                let triangles: Vec<[u32; 3]> = (0..8).map(triangle).collect();
                Collider::mesh(TriangleMesh::new(&vertices, &triangles).expect("eight triangles"))
            }
            _ => Collider::half_space(),
        }
    }
}

/// Bodies of all kinds that do not move, after a step.
struct Scattered {
    world: World,
    bodies: Vec<Entity>,
    solids: Vec<Vec<Solid>>,
}

impl Scattered {
    fn new(dice: &mut Dice, count: usize, room: f64) -> Self {
        let mut world = world_with(SolverSettings::game());
        let (mut bodies, mut solids) = (Vec::new(), Vec::new());
        for kind in 0..count {
            let (collider, at, turn) = (dice.collider(kind), dice.vector(room), dice.rotation());
            let at = if kind % KINDS == 8 { at + DVec3::NEG_Y * 3.0 * room } else { at };
            solids.push(solids_of(&collider, at, turn));
            bodies.push(world.spawn((RigidBody::Static, collider, Position(at), Rotation(turn))).id());
        }
        step(&mut world);
        Self { world, bodies, solids }
    }

    fn ask<T>(&mut self, question: impl FnOnce(PhysicsQuery, &[Entity], &[Vec<Solid>]) -> T) -> T {
        let (bodies, solids) = (&self.bodies, &self.solids);
        ask(&mut self.world, |query| question(query, bodies, solids))
    }
}

fn ask<T>(world: &mut World, question: impl FnOnce(PhysicsQuery) -> T) -> T {
    let mut state = SystemState::<PhysicsQuery>::new(world);
    question(state.get(world).expect("all that a question needs is there"))
}

/// Asks about each kind of body alone, so many times, and says which answers are not true. `question` tells whether
/// something was hit, or what is wrong with the answer.
fn ask_about_each(
    seed: u64,
    cases: usize,
    mut question: impl FnMut(&mut Dice, &PhysicsQuery, &QueryFilter, &[Solid]) -> Result<bool, String>,
) {
    let mut dice = Dice::new(seed);
    let (mut hits, mut misses, mut wrong) = ([0; KINDS], [0; KINDS], Vec::new());
    for _ in 0..cases.div_ceil(QUESTIONS) {
        let mut scattered = Scattered::new(&mut dice, KINDS, 0.5);
        scattered.ask(|query, bodies, solids| {
            for (kind, (&body, solids)) in bodies.iter().zip(solids).enumerate() {
                let only = |other: Entity| other == body;
                let filter = QueryFilter { accepts: Some(&only), ..default() };
                for _ in 0..QUESTIONS {
                    match question(&mut dice, &query, &filter, solids) {
                        Ok(true) => hits[kind] += 1,
                        Ok(false) => misses[kind] += 1,
                        Err(what) => wrong.push(format!("kind {kind}: {what}")),
                    }
                }
            }
        });
    }
    let few = &wrong[..wrong.len().min(20)];
    assert!(wrong.is_empty(), "{} of {hits:?} hits, {misses:?} misses are wrong: {few:#?}", wrong.len());
    println!("{hits:?} hits, {misses:?} misses");
    assert!(hits.iter().all(|hits| hits * 20 > cases) && misses.iter().sum::<usize>() * 4 > cases);
}

fn brief(collider: &Collider) -> String {
    format!("{:?}", collider.shape()).chars().take(80).collect()
}

fn check(is_so: bool, what: impl FnOnce() -> String) -> Result<(), String> {
    if is_so { Ok(()) } else { Err(what()) }
}

fn compare_rays(cases: usize) {
    ask_about_each(1, cases, |dice, query, filter, solids| {
        let origin = dice.vector(4.0);
        let ray = Ray { origin, direction: dice.vector(0.9) - origin * 0.9, length: dice.within(1.0, 20.0) };
        let hit = query.ray(&ray, filter);
        let is_free = |length: f64| solids.iter().all(|solid| solid.is_not_entered(&ray, length, GRAZING));
        let Some(hit) = hit else {
            check(is_free(ray.length), || format!("{ray:?} meets it"))?;
            return Ok(false);
        };
        let unit = ray.direction.normalize();
        check(hit.point.distance(ray.origin + unit * hit.distance) < 1e-12, || format!("{hit:?} is not on {ray:?}"))?;
        if hit.distance == 0.0 {
            let is_inside = solids.iter().any(|solid| solid.distance(ray.origin) <= GRAZING);
            check(is_inside && hit.normal.distance(-unit) < 1e-12, || {
                format!("{ray:?} does not begin inside: {hit:?}")
            })?;
            return Ok(true);
        }
        check(hit.normal.dot(unit) < 0.0 && hit.normal.is_normalized(), || format!("{hit:?} of {ray:?}"))?;
        check(is_free(hit.distance), || format!("{ray:?} meets it before {hit:?}"))?;
        let is_on_it = solids.iter().any(|solid| solid.has_on_its_surface(hit.point, hit.normal, GRAZING));
        check(is_on_it, || format!("{hit:?} of {ray:?} is not on its surface"))?;
        Ok(true)
    });
}

#[test]
fn rays_meet_each_shape_where_it_is_highest_over_them() {
    compare_rays(CASES / KINDS);
}

#[test]
#[ignore = "takes minutes"]
fn rays_meet_each_shape_where_it_is_highest_over_them_for_many() {
    compare_rays(MANY);
}

fn compare_nearest(cases: usize) {
    ask_about_each(2, cases, |dice, query, filter, solids| {
        let at = dice.vector(1.5);
        let hit = query.nearest_point(at, f64::INFINITY, filter).expect("it is there");
        let distances = solids.iter().map(|solid| solid.distance(at));
        let least = distances.fold(f64::INFINITY, f64::min);
        check((hit.distance - least).abs() <= GRAZING, || format!("{least} m from {at}, and not {hit:?}"))?;
        check((hit.point.distance(at) - hit.distance).abs() < 1e-12, || format!("{hit:?} is not so far from {at}"))?;
        let off = solids.iter().map(|solid| solid.distance(hit.point)).fold(f64::INFINITY, f64::min);
        check(off <= GRAZING, || format!("{hit:?} is {off} m off the body"))?;
        let within = query.nearest_point(at, hit.distance * 0.999, filter);
        check(within.is_some() == (hit.distance == 0.0), || format!("{within:?} is nearer to {at} than {hit:?}"))?;
        Ok(hit.distance > 0.0)
    });
}

#[test]
fn the_nearest_point_is_as_far_as_the_nearest_side_is() {
    compare_nearest(CASES / KINDS);
}

#[test]
#[ignore = "takes minutes"]
fn the_nearest_point_is_as_far_as_the_nearest_side_is_for_many() {
    compare_nearest(MANY);
}

/// By how much planes prove at least that all of one is apart from all of the other, a share of their sizes.
fn apart(movers: &[Solid], others: &[Solid]) -> f64 {
    least_of_pairs(movers, others, |mover, other| apart_on_a_way(mover, DVec3::ZERO, other, None))
}

/// The least that a proof finds of pairs, as a share of their sizes.
fn least_of_pairs(movers: &[Solid], others: &[Solid], proof: impl Fn(&Solid, &Solid) -> Option<f64>) -> f64 {
    let gap =
        |mover: &Solid, other: &Solid| proof(mover, other).unwrap_or(f64::NEG_INFINITY) / (mover.size() + other.size());
    let pairs = movers.iter().flat_map(|mover| others.iter().map(move |other| (mover, other)));
    pairs.map(|(mover, other)| gap(mover, other)).fold(f64::INFINITY, f64::min)
}

/// Likewise of all places on a way: by the plane that is known or by those that GJK finds, and where these prove too little, of
/// all planes that there are.
fn passes_by(movers: &[Solid], way: DVec3, others: &[Solid], known: Option<DVec3>) -> f64 {
    least_of_pairs(movers, others, |mover, other| {
        let enough = -GRAZING * (mover.size() + other.size());
        let gap = apart_on_a_way(mover, way, other, known);
        if gap.is_some_and(|gap| gap >= enough) { gap } else { apart_by_search(mover, way, other) }
    })
}

/// How far casts go in the tests, m.
const LENGTH: f64 = 8.0;

fn compare_casts(cases: usize) {
    let mut turn = 0;
    ask_about_each(3, cases, |dice, query, filter, solids| {
        turn += 1;
        let collider = dice.collider(MOVERS[turn % MOVERS.len()]);
        let (origin, rotation) = (dice.vector(5.0), dice.rotation());
        let way = (dice.vector(1.5) - origin).normalize();
        let placed = PlacedCollider { collider: &collider, position: Position(origin), rotation: Rotation(rotation) };
        comes_as_far_as_planes_prove(&placed, way, query, filter, solids)
    });
}

/// Whether a shape that is cast hits the one body that a filter accepts, of those solids, or how that is wrong.
fn comes_as_far_as_planes_prove(
    placed: &PlacedCollider,
    way: DVec3,
    query: &PhysicsQuery,
    filter: &QueryFilter,
    solids: &[Solid],
) -> Result<bool, String> {
    let (collider, origin, rotation) = (placed.collider, placed.position.0, placed.rotation.0);
    let told = || format!("{} along {way:?} from {origin:?} turned by {rotation:?}", brief(collider));
    let movers = solids_of(collider, origin, rotation);
    let Some(hit) = query.shape_cast(placed, way, LENGTH, filter) else {
        let gap = passes_by(&movers, way * LENGTH, solids, None);
        check(gap >= -GRAZING, || format!("{} touches it: {gap}", told()))?;
        return Ok(false);
    };
    if hit.distance == 0.0 {
        let gap = apart(&movers, solids);
        check(gap <= GRAZING, || format!("{} does not begin there: {hit:?}", told()))?;
        return Ok(true);
    }
    let there = solids_of(collider, origin + way * hit.distance, rotation);
    let off = |solids: &[Solid]| solids.iter().map(|it| it.distance(hit.point)).fold(f64::INFINITY, f64::min);
    let size = |solids: &[Solid]| solids.iter().map(Solid::size).fold(0.0, f64::max);
    let most_off = GRAZING * (size(&there) + size(solids));
    check(off(&there).max(off(solids)) <= most_off, || {
        format!("{hit:?} is {} m and {} m off for {}", off(&there), off(solids), told())
    })?;
    let slope = -hit.normal.dot(way);
    check(slope > 0.0 && hit.normal.is_normalized(), || format!("{hit:?} for {}", told()))?;
    let early = passes_by(&movers, way * hit.distance, solids, Some(-hit.normal));
    check(early >= -GRAZING, || format!("{early} of touching before {hit:?} for {}", told()))?;
    Ok(true)
}

#[test]
fn what_is_cast_comes_as_far_as_planes_between_prove() {
    compare_casts(CASES / KINDS);
}

#[test]
#[ignore = "takes minutes"]
fn what_is_cast_comes_as_far_as_planes_between_prove_for_many() {
    compare_casts(MANY);
}

/// Cases where the nearest features are edges that cross at a small angle, or an edge beside a face that is nearly as good:
/// of contact points the normal was that of the face, the place 1e-7 m beside the edges, and the distance as much too short.
#[test]
fn what_is_cast_touches_first_where_edges_cross_beside_faces() {
    type Placed = (Collider, [f64; 3], [f64; 4]);
    let cases: [(Placed, [f64; 3], Placed); 5] = [
        // A face was preferred to the rim of a cone.
        (
            (
                Collider::cuboid(1.7435106380210552, 1.7652712177171812, 0.6884998535521918),
                [-2.148853291915167, -1.3200222454433619, 1.1849417649597482],
                [0.2313220490274659, 0.3458843014612135, -0.35523581537092563, 0.8370553596472438],
            ),
            [0.6836633016305577, 0.2723704710980281, -0.6770663309288415],
            (
                Collider::cone(0.8880823496079848, 1.2885709477283882),
                [0.25120481497692526, 0.2476298912204824, -0.25263250968975814],
                [-0.3875320758103084, -0.08428350207083718, 0.5354874498339167, 0.7456328671452171],
            ),
        ),
        // The distance was 1.5e-6 m too short, the place as far beside.
        (
            (
                Collider::cuboid(1.6807505276096208, 1.5361532798522117, 0.50897078254623),
                [2.1414952845006248, -3.8597175751140633, 4.224988930829209],
                [0.2646625878307569, 0.6959488157133858, -0.6173804445772342, 0.25387072923730186],
            ),
            [-0.1649507869584701, 0.675992250702768, -0.7182100771164295],
            (
                Collider::cuboid(0.252349237591668, 1.8065905292549498, 0.7021937490828731),
                [-0.22614340721982162, -0.13735881501695424, -0.3242123020631713],
                [-0.07275856969699, 0.03232411127402744, -0.014973725490939265, 0.9967131633077365],
            ),
        ),
        // The normal went along with the cast.
        (
            (
                Collider::cuboid(0.21351663076515834, 1.1855518726356746, 1.7654933358678773),
                [1.2749053300479467, 2.5864981705091816, -0.8820428740049095],
                [-0.457196100032017, -0.3483715499717325, -0.25691414531114065, 0.7769196298550551],
            ),
            [-0.6322345112335408, -0.4195183827012138, 0.6513707464885444],
            (
                Collider::cuboid(1.479604136379656, 1.2296531083372312, 1.4461597554169075),
                [-0.3532394189724859, 0.10788403263808277, -0.18516992480172556],
                [0.12649204257627622, 0.2976490263739659, 0.8982901094443777, 0.29745537402763383],
            ),
        ),
        // The place was 1e-8 m beside a cone's flank.
        (
            (
                Collider::cuboid(1.6011081906302083, 0.9886735344144912, 1.1774159224960563),
                [0.7161708701678959, -2.818336074278094, -1.6050185976777054],
                [0.07727554573499289, -0.7153422351749482, -0.21856477036358474, 0.659199072937896],
            ),
            [-0.4150246698959677, 0.8079318283090907, 0.4183308310211825],
            (
                Collider::cone(0.8408044441267837, 1.781223105300078),
                [0.00018611394490730682, 0.29414193103777864, -0.14358127889714023],
                [0.8493846258936334, -0.00642536868346044, 0.3688133372210015, 0.37746681207852145],
            ),
        ),
        // A cone that is cast: its point was 5e-9 m off.
        (
            (
                Collider::cone(0.22230074775419625, 1.3823758619246749),
                [3.670351377612885, 4.856751331566427, 4.7178391908073785],
                [-0.5266703260361112, -0.33284011593234675, 0.5333930811460571, 0.572125550805655],
            ),
            [-0.5688899132690682, -0.577637981408044, -0.5854046711596622],
            (
                Collider::cuboid(1.1198284321144192, 0.528199476421321, 0.8670135193245887),
                [-0.4682077226501349, 0.37142402191296364, 0.4184492757442124],
                [0.030776491295024, 0.0006273222391587061, 0.04616826923131166, 0.9984592655519606],
            ),
        ),
    ];
    let mut wrong = Vec::new();
    for (number, ((mover, origin, turn), way, (other, place, other_turn))) in cases.into_iter().enumerate() {
        let mut world = world_with(SolverSettings::game());
        let (position, rotation) = (DVec3::from_array(place), DQuat::from_array(other_turn).normalize());
        let solids = solids_of(&other, position, rotation);
        world.spawn((RigidBody::Static, other, Position(position), Rotation(rotation)));
        step(&mut world);
        let (origin, rotation) = (DVec3::from_array(origin), DQuat::from_array(turn).normalize());
        let placed = PlacedCollider { collider: &mover, position: Position(origin), rotation: Rotation(rotation) };
        let (way, all) = (DVec3::from_array(way).normalize(), QueryFilter::default());
        let is_true = |query: PhysicsQuery| {
            comes_as_far_as_planes_prove(&placed, way, &query, &all, &solids)?;
            let hit = query.shape_cast(&placed, way, LENGTH, &all).ok_or("nothing is hit")?;
            // The plane there has all of the one on one side, and all of the other on the other.
            let there = solids_of(&mover, origin + way * hit.distance, rotation);
            let beyond = solids[0].beyond(hit.point, hit.normal).max(there[0].beyond(hit.point, -hit.normal));
            check(beyond <= GRAZING * (there[0].size() + solids[0].size()), || format!("{beyond} m beyond {hit:?}"))
        };
        wrong.extend(ask(&mut world, is_true).err().map(|what| format!("case {number}: {what}")));
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Of a mesh that is cast as of one that is cast at.
#[test]
fn a_triangle_is_touched_from_its_front_alone() {
    let corners = [DVec3::new(1.0, 0.0, 1.0), DVec3::new(-1.0, 0.0, 1.0), DVec3::new(0.0, 0.0, -1.0)];
    // Counter-clockwise seen from above, or from below.
    let triangle = |order: [u32; 3]| Collider::mesh(TriangleMesh::new(&corners, &[order]).expect("a triangle"));
    let [up, down, cuboid] = [triangle([0, 2, 1]), triangle([0, 1, 2]), Collider::cuboid(0.2, 0.4, 0.2)];
    let cases = [(&cuboid, &up, Some(1.8)), (&cuboid, &down, None), (&down, &cuboid, Some(1.8)), (&up, &cuboid, None)];
    for (number, (mover, other, distance)) in cases.into_iter().enumerate() {
        let mut world = world_with(SolverSettings::game());
        world.spawn((RigidBody::Static, other.clone(), Position(DVec3::ZERO)));
        step(&mut world);
        let placed =
            PlacedCollider { collider: mover, position: Position(DVec3::Y * 2.0), rotation: Rotation::default() };
        let hit = ask(&mut world, |query| query.shape_cast(&placed, DVec3::NEG_Y, LENGTH, &QueryFilter::default()));
        assert_eq!(hit.map(|hit| (hit.distance * 1e9).round() / 1e9), distance, "case {number}");
    }
}

fn compare_overlaps(cases: usize) {
    let mut turn = 0;
    ask_about_each(4, cases, |dice, query, filter, solids| {
        turn += 1;
        let collider = dice.collider(MOVERS[turn % MOVERS.len()]);
        let (position, rotation) = (dice.vector(2.0), dice.rotation());
        overlaps_as_planes_tell(&collider, position, rotation, query, filter, solids)
    });
}

/// Whether a shape overlaps the one body that a filter accepts, of those solids, or how that is wrong.
fn overlaps_as_planes_tell(
    collider: &Collider,
    position: DVec3,
    rotation: DQuat,
    query: &PhysicsQuery,
    filter: &QueryFilter,
    solids: &[Solid],
) -> Result<bool, String> {
    let placed = PlacedCollider { collider, position: Position(position), rotation: Rotation(rotation) };
    let least = apart(&solids_of(collider, position, rotation), solids);
    let touches = query.overlap(&placed, filter).is_some();
    check(if touches { least <= GRAZING } else { least >= -GRAZING }, || {
        format!("{} at {position} turned by {rotation} overlaps: {touches}, but is {least} apart", brief(collider))
    })?;
    Ok(touches)
}

#[test]
fn what_overlaps_has_no_plane_between() {
    compare_overlaps(CASES / KINDS);
}

#[test]
#[ignore = "takes minutes"]
fn what_overlaps_has_no_plane_between_for_many() {
    compare_overlaps(MANY);
}

/// Along normals, too, that its mesh does not have where it is touched.
#[test]
fn what_is_round_overlaps_a_mesh_from_all_sides() {
    let mut dice = Dice::new(6);
    let mut touched = 0;
    for _ in 0..40 {
        Scattered::new(&mut dice, KINDS, 0.5).ask(|query, bodies, solids| {
            let mesh = 7;
            let only = |other: Entity| other == bodies[mesh];
            let filter = QueryFilter { accepts: Some(&only), ..default() };
            for turn in 0..400 {
                let collider = dice.collider([2, 4, 5][turn % 3]);
                let (position, rotation) = (dice.vector(1.0), dice.rotation());
                let told = overlaps_as_planes_tell(&collider, position, rotation, &query, &filter, &solids[mesh]);
                let touches = told.unwrap_or_else(|wrong| panic!("{wrong}"));
                touched += u32::from(touches);
            }
        });
    }
    assert!((4000..12000).contains(&touched), "{touched} of 16000 touch it");
}

/// Questions about so many bodies at once, against each of them alone.
fn compare_among_many(worlds: u64) {
    for (seed, count) in (0..worlds).flat_map(|seed| [1, 3, 30, 300].map(|count| (seed, count))) {
        let mut dice = Dice::new(5 + seed);
        let mut scattered = Scattered::new(&mut dice, count, 6.0);
        let rays: Vec<Ray> = (0..50).map(|_| Ray::new(dice.vector(12.0), dice.vector(1.0))).collect();
        let kind = MOVERS[(seed as usize + 1) % MOVERS.len()];
        let (collider, rotation) = (dice.collider(kind), Rotation(dice.rotation()));
        scattered.ask(|query, bodies, _| {
            let all = QueryFilter::default();
            for ray in &rays {
                let place = PlacedCollider { collider: &collider, position: Position(ray.origin), rotation };
                let (mut by_ray, mut by_cast, mut nearest, mut touched) = (vec![], vec![], vec![], vec![]);
                for &body in bodies {
                    let only = |other: Entity| other == body;
                    let alone = QueryFilter { accepts: Some(&only), ..default() };
                    by_ray.extend(query.ray(ray, &alone));
                    by_cast.extend(query.shape_cast(&place, ray.direction, 30.0, &alone));
                    nearest.extend(query.nearest_point(ray.origin, 5.0, &alone));
                    touched.extend(query.overlap(&place, &alone));
                }
                by_ray.sort_by(|a, b| a.distance.total_cmp(&b.distance).then(a.entity.cmp(&b.entity)));
                by_cast.sort_by(|a, b| a.distance.total_cmp(&b.distance).then(a.entity.cmp(&b.entity)));
                nearest.sort_by(|a, b| a.distance.total_cmp(&b.distance).then(a.entity.cmp(&b.entity)));
                touched.sort_unstable();
                assert_eq!(query.ray(ray, &all), by_ray.first().copied());
                assert_eq!(query.ray_all(ray, &all), by_ray);
                assert_eq!(
                    query.shape_cast(&place, ray.direction, 30.0, &all).map(|hit| hit.entity),
                    by_cast.first().map(|hit| hit.entity)
                );
                assert_eq!(query.shape_cast_all(&place, ray.direction, 30.0, &all), by_cast);
                assert_eq!(query.nearest_point(ray.origin, 5.0, &all), nearest.first().copied());
                assert_eq!(query.nearest_points(ray.origin, 5.0, &all), nearest);
                assert_eq!(query.overlap_all(&place, &all), touched);
            }
        });
    }
}

#[test]
fn among_many_the_first_is_that_of_each_alone() {
    compare_among_many(1);
}

#[test]
#[ignore = "takes minutes"]
fn among_many_the_first_is_that_of_each_alone_in_many_worlds() {
    compare_among_many(100);
}

#[test]
fn many_rays_on_threads_find_what_each_finds() {
    let mut dice = Dice::new(6);
    let Scattered { mut world, .. } = Scattered::new(&mut dice, 200, 6.0);
    world.resource_mut::<SolverSettings>().threads = 4;
    let rays: Vec<Ray> = (0..1000).map(|_| Ray::new(dice.vector(12.0), dice.vector(1.0))).collect();
    ask(&mut world, |query| {
        let all = QueryFilter::default();
        let alone: Vec<Option<RayHit>> = rays.iter().map(|ray| query.ray(ray, &all)).collect();
        assert!(alone.iter().flatten().count() > 100);
        assert_eq!(query.rays(&rays, &all), alone);
    });
}

#[test]
fn after_each_step_answers_are_of_where_bodies_are_by_every_method() {
    for (name, settings) in presets() {
        let mut world = world_with(settings);
        let ball = body(&mut world, Collider::sphere(0.5), DVec3::Y * 10.0);
        let down = Ray::new(DVec3::Y * 20.0, DVec3::NEG_Y);
        for _ in 0..30 {
            step(&mut world);
            let top = position(&world, ball).y + 0.5;
            let hit = ask(&mut world, |query| query.ray(&down, &QueryFilter::default())).expect("it is below");
            assert!(hit.entity == ball && (20.0 - hit.distance - top).abs() < 1e-9, "{name}: {hit:?}, {top}");
        }
        assert!(position(&world, ball).y < 9.0, "{name}: it did not fall");
    }
}

#[test]
fn a_filter_leaves_out_what_it_says() {
    let mut world = weightless(SolverSettings::game());
    let at = |x: f64| (Collider::sphere(0.5), Position(DVec3::X * x));
    let own = CollisionLayers { memberships: 0b10, filters: 0b10 };
    let near = world.spawn((RigidBody::Static, at(2.0))).id();
    let layered = world.spawn((RigidBody::Dynamic, at(4.0), own)).id();
    let moved = world.spawn((RigidBody::Kinematic, at(6.0))).id();
    let deaf = world.spawn((RigidBody::Static, at(8.0), CollisionLayers::NONE)).id();
    world.spawn((RigidBody::Static, at(1.0), Sensor));
    step(&mut world);
    let ray = Ray::new(DVec3::ZERO, DVec3::X);
    let is_far = |entity: Entity| entity == deaf;
    let only_own = CollisionLayers { memberships: 0b10, filters: u32::MAX };
    let all = QueryFilter::default();
    let filters = [
        (all, vec![near, layered, moved, deaf]),
        (QueryFilter { kind: Some(RigidBody::Kinematic), ..all }, vec![moved]),
        (QueryFilter { without: &[near, moved], ..all }, vec![layered, deaf]),
        (QueryFilter { accepts: Some(&is_far), ..all }, vec![deaf]),
        (QueryFilter { layers: Some(only_own), ..all }, vec![near, layered, moved]),
        (QueryFilter { layers: Some(CollisionLayers { filters: 0b01, ..only_own }), ..all }, vec![near, moved]),
    ];
    ask(&mut world, |query| {
        for (place, (filter, expected)) in filters.iter().enumerate() {
            let found: Vec<Entity> = query.ray_all(&ray, filter).iter().map(|hit| hit.entity).collect();
            assert_eq!(found, *expected, "filter {place}");
        }
    });
}

#[test]
fn what_makes_no_sense_finds_nothing() {
    let mut world = weightless(SolverSettings::game());
    let ball = body(&mut world, Collider::sphere(1.0), DVec3::ZERO);
    step(&mut world);
    let (all, collider) = (QueryFilter::default(), Collider::cuboid(0.1, 0.1, 0.1));
    let nowhere = [DVec3::NAN, DVec3::INFINITY, DVec3::new(0.0, f64::NAN, 0.0)];
    ask(&mut world, |query| {
        for bad in nowhere {
            let placed = PlacedCollider { collider: &collider, position: Position(bad), rotation: Rotation::default() };
            assert_eq!(query.ray(&Ray::new(bad, DVec3::X), &all), None);
            assert_eq!(query.ray(&Ray::new(DVec3::X * -5.0, bad), &all), None);
            assert_eq!(query.nearest_point(bad, 9.0, &all), None);
            assert_eq!(query.shape_cast(&placed, DVec3::X, 9.0, &all), None);
            assert_eq!(query.overlap(&placed, &all), None);
            let here = PlacedCollider { position: Position(DVec3::X * -5.0), ..placed };
            assert_eq!(query.shape_cast(&here, bad, 9.0, &all), None);
        }
        assert_eq!(query.ray(&Ray::new(DVec3::X * -5.0, DVec3::ZERO), &all), None);
        let short = Ray { length: f64::NAN, ..Ray::new(DVec3::X * -5.0, DVec3::X) };
        assert_eq!(query.ray(&short, &all), None);
        // And a ray that begins inside is at its end.
        let inside = query.ray(&Ray::new(DVec3::X * 0.3, DVec3::Y), &all).expect("it is in it");
        assert_eq!((inside.entity, inside.distance, inside.normal), (ball, 0.0, DVec3::NEG_Y));
    });
}
