//! Nothing that collides overlaps when a built-in scene starts. The check is the tests' own: a
//! separating direction found by support points alone, without the collision code.

use std::collections::HashSet;

use bevy::math::DVec3;
use plumb::scene::{BodySpec, ChildSpec, SceneSpec, ShapeSpec, catalog, find};

/// Rounding of positions up to 1e8 m from the origin, and touching faces.
const TOLERANCE: f64 = 1e-7;

/// The farthest point of a bounded body along `direction`.
fn support(body: &BodySpec, direction: DVec3) -> DVec3 {
    let local = body.rotation.inverse() * direction;
    let point = match &body.shape {
        Some(ShapeSpec::Sphere { radius }) => *radius * local.normalize_or_zero(),
        Some(ShapeSpec::Cuboid { size }) => 0.5 * *size * local.signum(),
        Some(ShapeSpec::Capsule { radius, length }) => {
            *radius * local.normalize_or_zero() + DVec3::Y * (0.5 * length).copysign(local.y)
        }
        Some(ShapeSpec::Cylinder { radius, height }) => {
            *radius * DVec3::new(local.x, 0.0, local.z).normalize_or_zero()
                + DVec3::Y * (0.5 * height).copysign(local.y)
        }
        Some(ShapeSpec::Cone { radius, height }) => {
            let rim = *radius * DVec3::new(local.x, 0.0, local.z).normalize_or_zero() - 0.25 * height * DVec3::Y;
            let apex = 0.75 * height * DVec3::Y;
            if local.dot(apex) > local.dot(rim) { apex } else { rim }
        }
        Some(shape @ (ShapeSpec::Hull(_) | ShapeSpec::Mesh(_))) => {
            // That of pieces is the hull of the whole, about their centre.
            let (hull, center) = match shape {
                ShapeSpec::Mesh(mesh) => (mesh.hull(), mesh.center()),
                _ => shape.convex_hull().map(|hull| (hull, hull.center())).expect("it has a hull"),
            };
            let local = hull.axes().inverse() * local;
            let farthest = hull.vertices().max_by(|a, b| a.dot(local).total_cmp(&b.dot(local)));
            hull.center() + hull.axes() * farthest.expect("a hull has vertices") - center
        }
        Some(ShapeSpec::HalfSpace | ShapeSpec::Compound(_) | ShapeSpec::Surface(_)) | None => DVec3::ZERO,
    };
    body.position + body.rotation * point
}

/// How far apart two bodies are along a direction; negative where their shadows on it overlap.
fn gap(a: &BodySpec, b: &BodySpec, direction: DVec3) -> f64 {
    let direction = direction.normalize_or_zero();
    (support(b, -direction) - support(a, direction)).dot(direction)
}

/// Whether some direction separates two bodies: their own axes and the line of centres first, then
/// toward the point of their difference that is nearest to zero (Frank and Wolfe 1956).
fn apart(a: &BodySpec, b: &BodySpec) -> bool {
    let axes = [a, b].into_iter().flat_map(|body| [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| body.rotation * axis));
    let mut candidates = axes.flat_map(|axis| [axis, -axis]).chain([b.position - a.position]);
    if candidates.any(|direction| gap(a, b, direction) >= -TOLERANCE) {
        return true;
    }
    let mut nearest = b.position - a.position;
    for _ in 0..2000 {
        if nearest.length() < TOLERANCE {
            return false;
        }
        if gap(a, b, nearest) >= -TOLERANCE {
            return true;
        }
        let toward_zero = support(b, -nearest) - support(a, nearest) - nearest;
        let along = (-nearest.dot(toward_zero) / toward_zero.length_squared()).clamp(0.0, 1.0);
        nearest += along * toward_zero;
    }
    false
}

/// What a body is made of: the parts of a compound, each as a body of its name, or itself.
fn solids(body: &BodySpec) -> Vec<BodySpec> {
    let Some(ShapeSpec::Compound(compound)) = &body.shape else { return vec![body.clone()] };
    let center = compound.compound().center();
    let part = |child: &ChildSpec| BodySpec {
        shape: Some(child.shape.clone()),
        position: body.point(child.position - center),
        rotation: body.rotation * child.rotation,
        ..body.clone()
    };
    compound.children().iter().map(part).collect()
}

/// The names of every pair that may collide and overlaps.
fn overlaps(scene: &SceneSpec) -> Vec<String> {
    let joined: HashSet<(&str, &str)> = scene
        .joints
        .iter()
        .filter(|joint| !joint.collide)
        .flat_map(|joint| [(&*joint.body_a, &*joint.body_b), (&*joint.body_b, &*joint.body_a)])
        .collect();
    let solid: Vec<BodySpec> = scene.bodies.iter().filter(|body| body.shape.is_some()).flat_map(solids).collect();
    let mut found = Vec::new();
    for (i, a) in solid.iter().enumerate() {
        for b in &solid[i + 1..] {
            let clear = match (&a.shape, &b.shape) {
                _ if a.name == b.name || joined.contains(&(&a.name, &b.name)) || !a.layers.interact(b.layers) => true,
                (Some(ShapeSpec::HalfSpace), _) => support(b, DVec3::NEG_Y).y >= a.position.y - TOLERANCE,
                (Some(one), Some(other)) => {
                    let reach = one.bounding_radius() + other.bounding_radius();
                    a.position.distance(b.position) >= reach || apart(a, b)
                }
                _ => true,
            };
            if !clear {
                found.push(format!("{} and {}", a.name, b.name));
            }
        }
    }
    found
}

#[test]
fn nothing_that_collides_overlaps_at_the_start() {
    for info in catalog() {
        let mut settings = vec![info.defaults()];
        if let Some(jitter) = info.parameters.iter().position(|parameter| parameter.name == "jitter") {
            settings.push(info.defaults());
            settings[1][jitter] = info.parameters[jitter].max;
        }
        for values in settings {
            let scene = info.make(&values).unwrap_or_else(|error| panic!("{error}"));
            assert_eq!(overlaps(&scene), Vec::<String>::new(), "{} {values:?}", info.name);
        }
    }
}

/// Asserts that two bodies of a scene touch: apart along `direction` by no more than rounding.
#[track_caller]
fn assert_touch(scene: &SceneSpec, a: &str, b: &str, direction: DVec3) {
    let body = |name: &str| scene.bodies.iter().find(|body| body.name == name).unwrap_or_else(|| panic!("no {name}"));
    let gap = gap(body(a), body(b), direction);
    assert!(gap.abs() < 1e-14, "{a} and {b} are {gap} m apart");
}

#[test]
fn voussoirs_share_their_faces_and_stand_on_the_ground() {
    let scene = find("arch").expect("a scene").make(&[]).expect("no parameters");
    for joint in 1..15 {
        let (a, b) = (format!("voussoir {}", joint - 1), format!("voussoir {joint}"));
        let (sin, cos) = (f64::from(joint) * 12_f64.to_radians()).sin_cos();
        assert_touch(&scene, &a, &b, DVec3::new(sin, cos, 0.0));
    }
    for springing in [1, 15] {
        assert!(support(&scene.bodies[springing], DVec3::NEG_Y).y.abs() < 1e-14);
    }
    assert!((support(&scene.bodies[8], DVec3::Y).y - 5.0 * 6_f64.to_radians().cos()).abs() < 1e-14, "the crown");
}

#[test]
fn cards_touch_the_ground_the_decks_and_each_other() {
    let scene = find("card_house").expect("a scene").make(&[]).expect("no parameters");
    let lean = 20_f64.to_radians();
    let face = DVec3::new(lean.cos(), -lean.sin(), 0.0);
    for (storey, pairs) in [(0, 3), (1, 2), (2, 1)] {
        for pair in 0..pairs {
            let [left, right] = ["left", "right"].map(|side| format!("{side} card {storey}.{pair}"));
            // Edge on edge: both inner faces separate them, and so does what lies between.
            for direction in [face, DVec3::X, face * DVec3::new(1.0, -1.0, 1.0)] {
                assert_touch(&scene, &left, &right, direction);
            }
            for card in [&left, &right] {
                let body = scene.bodies.iter().find(|body| body.name == **card).expect("a card");
                let floor = if storey == 0 { 0.0 } else { storey as f64 * (lean.cos() + 0.04 * lean.sin() + 0.04) };
                assert!((support(body, DVec3::NEG_Y).y - floor).abs() < 1e-14, "{card}");
            }
            if pair + 1 < pairs {
                let deck = format!("deck {storey}.{pair}");
                let next = format!("left card {storey}.{}", pair + 1);
                assert_touch(&scene, &right, &deck, DVec3::Y);
                assert_touch(&scene, &next, &deck, DVec3::Y);
                if pair > 0 {
                    assert_touch(&scene, &format!("deck {storey}.{}", pair - 1), &deck, DVec3::X);
                }
            }
        }
    }
}

#[test]
fn the_overlap_check_tells_touching_from_overlapping() {
    let cube = |x: f64| BodySpec::new("cube", ShapeSpec::Cuboid { size: DVec3::ONE }, DVec3::new(x, 0.0, 0.0));
    let cone = |x: f64| BodySpec::new("cone", ShapeSpec::Cone { radius: 0.5, height: 1.0 }, DVec3::new(x, 0.0, 0.0));
    assert!(apart(&cube(0.0), &cube(1.0)) && !apart(&cube(0.0), &cube(0.999)));
    assert!(apart(&cube(0.0), &cone(1.0)) && !apart(&cube(0.0), &cone(0.999)));
    // Edge on edge, both turned by 45° about y: separated by no face of either, only across.
    let turned = |at: DVec3, about: DVec3| {
        let rotation = bevy::math::DQuat::from_axis_angle(about, std::f64::consts::FRAC_PI_4);
        BodySpec::new("cube", ShapeSpec::Cuboid { size: DVec3::ONE }, at).with_rotation(rotation)
    };
    let touching = 2.0_f64.sqrt();
    let edge = turned(DVec3::ZERO, DVec3::X);
    assert!(apart(&edge, &turned(touching * 1.001 * DVec3::Y, DVec3::Z)));
    assert!(!apart(&edge, &turned(touching * 0.999 * DVec3::Y, DVec3::Z)));
}
