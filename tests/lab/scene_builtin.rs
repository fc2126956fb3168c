//! The built-in scenes: that they are what DESIGN says, valid at both ends of every parameter, and
//! sound at the start.

use std::f64::consts::FRAC_1_SQRT_2;
use std::path::Path;

use bevy::math::DVec3;
use bevy::prelude::*;
use plumb::physics::{
    BallJoint, Collider, CollisionLayers, Gravity, Mass, Position, RenderOrigin, RigidBody, Rotation, SurfaceMaterial,
    Velocity,
};
use plumb::scene::{
    BodySpec, JointKindSpec, JointSpec, MAX_BODIES, MaterialSpec, SceneEntity, SceneInfo, SceneSpec, Subject, catalog,
    find, load,
};

/// A built-in scene with some parameters given.
fn built(name: &str, parameters: &[(&str, f64)]) -> SceneSpec {
    let parameters: Vec<_> = parameters.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
    load(name, &parameters).unwrap_or_else(|error| panic!("{error}"))
}

/// Its defaults, then each parameter at its least and at its greatest with the rest at default;
/// where the greatest is too many bodies, the greatest that is not.
fn corners(scene: &SceneInfo) -> Vec<Vec<f64>> {
    let mut corners = vec![scene.defaults()];
    for (i, parameter) in scene.parameters.iter().enumerate() {
        for extreme in [parameter.min, parameter.max] {
            let mut values = scene.defaults();
            values[i] = extreme;
            while (scene.bodies)(&values) > MAX_BODIES as f64 {
                values[i] -= 1.0;
            }
            corners.push(values);
        }
    }
    corners
}

fn body<'a>(scene: &'a SceneSpec, name: &str) -> &'a BodySpec {
    scene.bodies.iter().find(|body| body.name == name).unwrap_or_else(|| panic!("no body '{name}' in {}", scene.name))
}

#[test]
fn all_scenes_are_there_the_start_scene_first() {
    let names: Vec<_> = catalog().iter().map(|scene| scene.name).collect();
    let expected = "limbs pendulum rods chain hanging joint_grid top heavy_top incline slide_roll rolling painleve \
                    bounce spheres cradle wall stack pyramid pyramids sandwich slab column boulder wrecking_ball arch card_house \
                    dominoes pile heap terrain rain washer trees junkyard convex_pile large_world far four_bar bricard andrews arm servo stop hinge_chain bridge tower car ragdolls \
                    empty";
    assert_eq!(names.join(" "), expected);
    for scene in catalog() {
        assert!(scene.seconds > 0.0 && !scene.about.is_empty() && !scene.truth.is_empty(), "{}", scene.name);
        assert!(find(scene.name).is_some_and(|found| std::ptr::eq(found, scene)));
        for parameter in scene.parameters {
            assert!(parameter.allows(parameter.default), "{} {}", scene.name, parameter.name);
        }
    }
}

#[test]
fn every_scene_has_a_title_of_its_own_and_every_subject_some_scenes() {
    for info in catalog() {
        let same = catalog().iter().filter(|other| other.title.to_lowercase() == info.title.to_lowercase());
        assert_eq!(same.count(), 1, "{}: {}", info.name, info.title);
        assert!(info.title.starts_with(char::is_uppercase) && !info.title.contains('_'), "{}", info.title);
        assert!(info.title.len() <= 24, "{} is too long for two lines below a picture", info.title);
    }
    for (subject, title) in Subject::ALL {
        assert!(catalog().iter().any(|info| info.subject == subject), "nothing about {title}");
    }
}

#[test]
fn every_scene_is_valid_at_its_defaults_and_at_both_ends_of_each_parameter() {
    for info in catalog() {
        for values in corners(info) {
            let scene = info.make(&values).unwrap_or_else(|error| panic!("{error} {values:?}"));
            assert_eq!(scene.name, info.name);
            assert_eq!(scene.bodies.len() as f64, (info.bodies)(&values), "{} {values:?}: bodies foretold", info.name);
            assert!(scene.view.is_some(), "{}: view", info.name);
        }
    }
}

#[test]
fn anchors_of_every_joint_coincide_at_the_start() {
    for info in catalog() {
        for values in corners(info) {
            let scene = info.make(&values).unwrap_or_else(|error| panic!("{error}"));
            let by_name: std::collections::HashMap<_, _> = scene.bodies.iter().map(|b| (b.name.as_str(), b)).collect();
            let meet = scene.joints.iter().filter(|joint| !matches!(joint.kind, JointKindSpec::Distance(_)));
            for JointSpec { body_a, body_b, anchor_a, anchor_b, .. } in meet {
                let gap = by_name[body_a.as_str()].point(*anchor_a) - by_name[body_b.as_str()].point(*anchor_b);
                assert!(gap.length() <= 1e-12, "{} {values:?}: {body_a} to {body_b} {gap}", info.name);
            }
        }
    }
}

#[test]
fn body_counts_are_as_designed() {
    let count = |name, parameters: &[(&str, f64)]| built(name, parameters).bodies.len();
    assert_eq!(count("pyramid", &[("n", 40.0)]), 820 + 1);
    assert_eq!(count("pyramids", &[("n", 8.0)]), 3521);
    assert_eq!(count("joint_grid", &[("n", 100.0)]), 10_000);
    assert_eq!(count("chain", &[]), 12);
    assert_eq!(count("rods", &[("n", 5.0)]), 6);
    assert_eq!(count("stack", &[("n", 10.0)]), 11);
    assert_eq!(count("bounce", &[]), 50);
    assert_eq!(count("spheres", &[]), 217);
    assert_eq!(count("rolling", &[]), 27);
    assert_eq!(count("far", &[]), 11 + 12);
    assert_eq!(count("heap", &[("n", 30.0)]), 30 + 1);
    assert_eq!(count("terrain", &[("n", 30.0)]), 30 + 1);
    assert_eq!(count("rain", &[("n", 10.0)]), 100 + 300 * 11);
    assert_eq!(count("washer", &[("n", 20.0)]), 8000 + 2);
    assert_eq!(count("trees", &[("n", 50.0)]), 50 + 1);
    assert_eq!(count("junkyard", &[("n", 21.0), ("layers", 24.0)]), 21 * 21 * 24 + 6);
    assert_eq!(count("convex_pile", &[("layers", 80.0)]), 5120 + 1);
    assert_eq!(count("large_world", &[("n", 300.0)]), 90_000 + 100);
    assert_eq!(count("arch", &[]), 15 + 1);
    assert_eq!(count("pile", &[("n", 7.0)]), 7 + 5);
    assert_eq!(count("card_house", &[]), 15 + 1);
    assert_eq!(count("dominoes", &[]), 20 + 1);
    assert_eq!(count("painleve", &[]), 1 + 1);
    assert_eq!(count("four_bar", &[("n", 40.0)]), 41 + 40 + 1);
    assert_eq!(count("bridge", &[("load", 1.0)]), 30 + 2 + 1);
    assert_eq!(count("tower", &[]), 5 * 5 + 3);
    assert_eq!(count("ragdolls", &[("n", 10.0)]), 10 * 11 + 8 + 1);
}

#[test]
fn heaps_and_terrain_are_of_the_things_that_they_say() {
    let nouns = |name, parameters: &[(&str, f64)]| {
        let scene = built(name, parameters);
        let things = scene.bodies.iter().skip(1).map(|body| body.name.split(' ').next().expect("a noun").to_owned());
        things.collect::<Vec<_>>()
    };
    let kinds = [
        "box",
        "ball",
        "hull",
        "cone",
        "box ball hull cone",
        "cylinder",
        "capsule",
        "box ball hull cone cylinder capsule",
    ];
    for (kind, turns) in kinds.into_iter().enumerate() {
        let expected: Vec<_> = turns.split(' ').cycle().take(13).collect();
        assert_eq!(nouns("heap", &[("kind", kind as f64), ("n", 13.0)]), expected, "kind {kind}");
    }
    let on_hills = nouns("terrain", &[("n", 8.0)]);
    assert_eq!(on_hills, ["box", "ball", "hull", "cone", "capsule", "cylinder", "dumb-bell", "stool"]);
}

#[test]
fn spawning_makes_each_body_and_joint_as_described() {
    let scene = built("chain", &[("r", 1000.0)]);
    let mut world = World::new();
    world.insert_resource(RenderOrigin(DVec3::new(1.0, 2.0, 3.0)));
    let spawned = scene.spawn(&mut world);
    assert_eq!((spawned.bodies.len(), spawned.joints.len()), (scene.bodies.len(), scene.joints.len()));
    assert_eq!(world.resource::<Gravity>().0, scene.gravity);
    for (body, &entity) in scene.bodies.iter().zip(&spawned.bodies) {
        let entity = world.entity(entity);
        assert!(entity.contains::<SceneEntity>());
        assert_eq!(entity.get::<Name>().map(Name::as_str), Some(body.name.as_str()));
        assert_eq!(entity.get::<RigidBody>(), Some(&body.kind));
        assert_eq!(entity.get::<Position>(), Some(&Position(body.position)));
        assert_eq!(entity.get::<Rotation>(), Some(&Rotation(body.rotation)));
        assert_eq!(entity.get::<Velocity>(), Some(&Velocity::default()));
        assert_eq!(entity.get::<Mass>().map(|mass| mass.0), body.mass);
        assert_eq!(entity.contains::<Collider>(), body.shape.is_some());
        let drawn = entity.get::<Transform>().expect("a body has a transform").translation;
        assert_eq!(drawn, (body.position - DVec3::new(1.0, 2.0, 3.0)).as_vec3());
    }
    for (i, &entity) in spawned.joints.iter().enumerate() {
        let joint = world.get::<BallJoint>(entity).expect("a joint");
        assert_eq!([joint.body_a, joint.body_b], [spawned.bodies[i], spawned.bodies[i + 1]], "a chain");
        assert!(world.entity(entity).contains::<SceneEntity>());
    }
}

/// First row of a reference file: the position at t = 0.
fn reference_start(file: &str) -> DVec3 {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/reference").join(file);
    let text = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{file}: {error}"));
    let first = text.lines().nth(1).expect("a row under the header");
    let row: Vec<f64> = first.split(',').map(|field| field.parse().expect("a number")).collect();
    assert_eq!(row[0], 0.0);
    DVec3::new(row[1], row[2], row[3])
}

#[test]
fn rods_and_chain_start_where_their_references_do() {
    for n in [1, 2, 5] {
        let tip = DVec3::new(f64::from(n), 0.0, 0.0);
        let scene = built("rods", &[("n", f64::from(n))]);
        assert_eq!(body(&scene, &format!("rod {}", n - 1)).point(0.5 * DVec3::X), tip);
        assert_eq!(reference_start(&format!("rods-{n}.csv")), tip);
    }
    for r in [1, 100, 1000, 1_000_000] {
        let center = DVec3::new(11.0, 0.0, 0.0);
        let scene = built("chain", &[("r", f64::from(r))]);
        assert_eq!(body(&scene, "ball").position, center);
        assert_eq!(body(&scene, "ball").mass, Some(f64::from(r)));
        assert_eq!(reference_start(&format!("chain-{r}.csv")), center);
    }
}

#[test]
fn gravity_is_as_designed() {
    let ten = "rods chain hanging joint_grid stack pyramid pyramids sandwich slab column boulder wrecking_ball far heap terrain rain washer trees junkyard convex_pile large_world hinge_chain"
        .split(' ')
        .collect::<Vec<_>>();
    for info in catalog() {
        let gravity = built(info.name, &[]).gravity;
        let strength = match info.name {
            "top" | "wall" | "servo" | "andrews" => 0.0,
            name if ten.contains(&name) => 10.0,
            _ => 9.81,
        };
        assert!((gravity.length() - strength).abs() < 1e-14, "{}: {gravity}", info.name);
        if !["incline", "hinge_chain"].contains(&info.name) {
            assert_eq!(gravity, DVec3::new(0.0, -strength, 0.0), "{}", info.name);
        }
    }
    let (sin, cos) = 20_f64.to_radians().sin_cos();
    assert_eq!(built("incline", &[("theta", 20.0)]).gravity, 9.81 * DVec3::new(sin, -cos, 0.0));
    assert_eq!(built("hinge_chain", &[]).gravity, 10.0 * FRAC_1_SQRT_2 * DVec3::new(0.0, -1.0, -1.0));
    assert_eq!(built("joint_grid", &[("tilt", 20.0)]).gravity, DVec3::new(0.0, -10.0 * cos, 10.0 * sin));
}

#[test]
fn what_does_not_collide_by_design_has_no_layers() {
    let hung = ["pendulum", "rods", "chain", "hanging", "joint_grid", "top", "heavy_top"];
    let machines = ["four_bar", "bricard", "andrews", "arm", "servo", "stop", "hinge_chain"];
    for name in hung.into_iter().chain(machines) {
        let scene = built(name, &[]);
        let shapes: Vec<_> = scene.bodies.iter().filter(|body| body.shape.is_some()).collect();
        assert!(!shapes.is_empty() && shapes.iter().all(|body| body.layers == CollisionLayers::NONE), "{name}");
    }
}

#[test]
fn rolling_pairs_have_the_designed_friction_and_start_touching() {
    let scene = built("rolling", &[("angle", 60.0)]);
    let surface = |name| {
        let MaterialSpec { friction, restitution } = body(&scene, name).material;
        SurfaceMaterial { friction, restitution }
    };
    assert!((surface("slab").pair(surface("ground")).friction - 0.4).abs() < 1e-15);
    assert!((surface("slab").pair(surface("ball 0")).friction - 0.8).abs() < 1e-15);
    let (sin, cos) = 60_f64.to_radians().sin_cos();
    assert_eq!(body(&scene, "slab").force, 150.0 * DVec3::new(cos, 0.0, sin));
    assert_eq!(body(&scene, "slab").position, DVec3::new(0.0, 0.5, 0.0));
    assert_eq!(body(&scene, "ball 0").position, DVec3::new(-4.0, 1.5, -4.0), "the first ball");
    assert_eq!(body(&scene, "ball 24").position, DVec3::new(4.0, 1.5, 4.0));
}

#[test]
fn the_cradle_touches_at_rest_with_its_first_ball_lifted() {
    let scene = built("cradle", &[]);
    let ball = |i: usize| body(&scene, &format!("ball {i}")).position;
    for i in 1..4 {
        assert!((ball(i).distance(ball(i + 1)) - 0.2).abs() < 1e-15);
    }
    let (sin, cos) = 30_f64.to_radians().sin_cos();
    let pivot = body(&scene, "pivot 0").position;
    assert!(ball(0).abs_diff_eq(pivot + DVec3::new(-sin, -cos, 0.0), 1e-15));
    assert_eq!(body(&scene, "ball 0").material, MaterialSpec { friction: 0.0, restitution: 1.0 });
}

#[test]
fn balls_start_as_high_as_designed() {
    assert_eq!(body(&built("bounce", &[]), "ball 0").position, DVec3::new(-6.0, 5.0, -6.0));
    for (e, lowest) in [(0.0, 0.101), (1.0, 1.101)] {
        let scene = built("spheres", &[("e", e)]);
        let heights = scene.bodies.iter().skip(1).map(|ball| ball.position.y);
        let least = heights.fold(f64::INFINITY, f64::min);
        assert!((lowest..lowest + 0.001).contains(&least), "e = {e}: {least}");
    }
}

#[test]
fn jitter_moves_every_cube_a_little_and_the_same_way_every_time() {
    for (name, sideways) in [("stack", DVec3::new(1.0, 0.0, 1.0)), ("pyramid", DVec3::Z), ("pyramids", DVec3::Z)] {
        let (still, moved) = (built(name, &[]), built(name, &[("jitter", 0.1)]));
        assert_eq!(moved, built(name, &[("jitter", 0.1)]));
        for (from, to) in still.bodies.iter().zip(&moved.bodies).skip(1) {
            let offset = to.position - from.position;
            assert!(offset != DVec3::ZERO && offset.abs().max_element() <= 0.1 + 1e-12, "{name} {}", to.name);
            assert_eq!(offset * (DVec3::ONE - sideways), DVec3::ZERO, "{name}: only sideways");
        }
        assert_eq!(still.bodies[0], moved.bodies[0], "the ground stays");
    }
}

#[test]
fn far_is_the_scene_at_the_origin_moved() {
    let (near, far) = (built("far", &[("d", 0.0)]), built("far", &[("d", 1e7)]));
    assert_eq!(near.joints, far.joints);
    for (near, far) in near.bodies.iter().zip(&far.bodies).skip(1) {
        assert_eq!(far.position - near.position, 1e7 * DVec3::X, "{}", near.name);
    }
}

#[test]
fn limbs_has_figures_a_long_chain_and_loose_things_joined_by_like_masses() {
    let scene = built("limbs", &[]);
    let joints_of = |name: &str| scene.joints.iter().filter(|j| j.body_a == name || j.body_b == name).count();
    let part = |part: &str| scene.bodies.iter().filter(|body| body.name.ends_with(part)).count();
    assert!(part(" head") >= 2 && part(" head") == part(" chest"));
    assert_eq!(part(" foot"), 2 * part(" head"));
    assert!(scene.bodies.iter().filter(|body| body.name.starts_with("link ")).count() >= 20, "a long chain");
    let loose = |body: &&BodySpec| body.kind == RigidBody::Dynamic && joints_of(&body.name) == 0;
    assert!(scene.bodies.iter().filter(loose).count() >= 10);
    for joint in &scene.joints {
        let [a, b] = [&joint.body_a, &joint.body_b].map(|name| body(&scene, name));
        if let (Some(a), Some(b)) = (a.mass, b.mass) {
            let ratio = a.max(b) / a.min(b);
            assert!(ratio <= 8.0, "{} to {}: {ratio}", joint.body_a, joint.body_b);
        }
    }
}

#[test]
fn figures_have_hinged_elbows_and_knees_and_limits_at_every_joint() {
    for figures in [1, 3] {
        let scene = built("ragdolls", &[("n", f64::from(figures))]);
        let figures = figures as usize;
        let of_limbs = |joint: &&JointSpec| joint.limits.is_some();
        let hinged: Vec<_> = scene.joints.iter().filter(|joint| joint.kind == JointKindSpec::Hinge).collect();
        assert_eq!(hinged.len(), 4 * figures);
        for joint in hinged {
            assert!(joint.body_b.ends_with("forearm") || joint.body_b.ends_with("shin"), "{}", joint.body_b);
        }
        // All but the three strings' two ends each and the gymnast's two grips.
        let figure = |joint: &&JointSpec| {
            !["string", "bar", "link"].iter().any(|word| joint.body_a.contains(word) || joint.body_b.contains(word))
        };
        let own = scene.joints.iter().filter(figure);
        assert!(own.clone().count() >= 10 * figures && own.clone().all(|joint| of_limbs(&joint)));
    }
}

#[test]
fn a_ragdoll_is_as_heavy_and_as_tall_as_designed() {
    let scene = built("ragdolls", &[]);
    let parts = scene.bodies.iter().filter(|body| body.name.starts_with("doll"));
    let mass: f64 = parts.clone().filter_map(|part| part.mass).sum();
    assert!((mass - 70.0).abs() < 1e-12, "{mass} kg");
    assert_eq!(parts.count(), 11);
}
