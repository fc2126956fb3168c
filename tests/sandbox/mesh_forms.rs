//! What is built of a mesh: its hull, its pieces or its surface; and hills.

use bevy::math::DVec3;
use bevy::prelude::*;
use plumb::physics::{Position, RigidBody, Shape, Velocity};
use plumb::sandbox::{Blueprint, Hills, MeshForm, Notice, Page, SandboxAction};
use plumb::scene::{BodySpec, ShapeSpec};

use crate::eyes::{alarms, click_on, open_eyes, reads, seen};
use crate::stage::Stage;

const GROUND: &str = r#"(
    bodies: [(name: "ground", kind: Static, shape: HalfSpace)],
    view: (eye: (0, 5, 8), target: (0, 0, 0)),
)"#;

const BOWL: &str = "plumb:bowl.obj";

fn choose(stage: &mut Stage, form: MeshForm) {
    stage.act(SandboxAction::ChooseMesh { file: BOWL.into(), scale: 1.0, form });
}

/// Adds a body where that point of the ground is seen.
fn add(stage: &mut Stage, point: DVec3, name: &str) -> Entity {
    let place = stage.seen_at(point);
    stage.move_to(place);
    stage.act(SandboxAction::SpawnBody);
    let notice = stage.world().resource::<Notice>().clone();
    let world = stage.world();
    let mut bodies = world.query_filtered::<(Entity, &Name), With<RigidBody>>();
    let found = bodies.iter(world).find(|(_, own)| own.as_str() == name).map(|(entity, _)| entity);
    found.unwrap_or_else(|| panic!("no {name}: {notice:?}"))
}

fn place(stage: &mut Stage, body: Entity) -> DVec3 {
    stage.world().get::<Position>(body).unwrap().0
}

/// Adds a bowl of that form, drops a ball into it from above its middle, and tells where that lies two seconds later over the
/// ground, m.
fn height_of_ball_in(form: MeshForm) -> (Stage, f64) {
    let mut stage = Stage::open_paused(GROUND);
    choose(&mut stage, form);
    let bowl = add(&mut stage, DVec3::ZERO, "bowl");
    let middle = place(&mut stage, bowl);
    let ball = BodySpec::new("ball", ShapeSpec::Sphere { radius: 0.2 }, DVec3::new(middle.x, 1.2, middle.z));
    let ball = ball.spawn(stage.world());
    stage.act(SandboxAction::TogglePause);
    stage.frames(120);
    let height = place(&mut stage, ball).y;
    (stage, height)
}

#[test]
fn a_bowl_in_pieces_holds_a_ball_and_its_hull_does_not() {
    let (mut stage, in_pieces) = height_of_ball_in(MeshForm::Pieces(16));
    assert!(in_pieces < 0.5, "its rim is at 0.67 m, the ball at {in_pieces} m");
    stage.replays();
    let (_, on_hull) = height_of_ball_in(MeshForm::Hull);
    assert!(!(0.3..0.8).contains(&on_hull), "it lies on the lid or rolled off it: {on_hull} m");
}

#[test]
fn a_surface_is_fixed_and_holds_a_ball() {
    let (mut stage, height) = height_of_ball_in(MeshForm::Surface { two_sided: true });
    assert!(height < 0.5, "the ball is at {height} m");
    let world = stage.world();
    let mut bodies = world.query::<(&Name, &RigidBody, &plumb::physics::Collider)>();
    let (_, kind, collider) = bodies.iter(world).find(|(name, ..)| name.as_str() == "bowl").expect("a bowl");
    assert_eq!(*kind, RigidBody::Static);
    assert!(matches!(collider.shape(), Shape::Mesh(_)));
    stage.replays();
}

#[test]
fn the_form_is_chosen_in_the_panel() {
    let mut stage = Stage::open_paused(GROUND);
    open_eyes(&mut stage, Page::Build);
    click_on(&mut stage, "bowl", "Build");
    let form = |stage: &mut Stage| {
        let shape = stage.world().resource::<Blueprint>().shape.clone();
        let (file, scale, form) = MeshForm::of(&shape).expect("of a mesh");
        assert_eq!((file, scale), (BOWL, 1.0));
        form
    };
    assert_eq!(form(&mut stage), MeshForm::Hull);
    click_on(&mut stage, "pieces", "Build");
    assert_eq!(form(&mut stage), MeshForm::Pieces(16));
    for text in ["at most ", "16"] {
        seen(&mut stage, text, "Build");
    }
    click_on(&mut stage, "surface", "Build");
    assert_eq!(form(&mut stage), MeshForm::Surface { two_sided: false });
    assert!(reads(&mut stage, "fixed: a surface has no mass"));
    click_on(&mut stage, "two-sided", "Build");
    assert_eq!(form(&mut stage), MeshForm::Surface { two_sided: true });
    click_on(&mut stage, "hull", "Build");
    assert_eq!(form(&mut stage), MeshForm::Hull);
    // Another shape puts other rows there.
    click_on(&mut stage, "hills", "Build");
    assert!(Hills::are(&stage.world().resource::<Blueprint>().shape));
    seen(&mut stage, "wavelength ", "Build");
    assert_eq!(alarms(&mut stage), 0);
}

#[test]
fn a_form_that_cannot_be_had_is_told_and_the_last_one_stays() {
    let mut stage = Stage::open_paused(GROUND);
    choose(&mut stage, MeshForm::Pieces(4));
    let shape = stage.world().resource::<Blueprint>().shape.clone();
    for (asked, words) in [
        (SandboxAction::ChooseMesh { file: BOWL.into(), scale: 1.0, form: MeshForm::Pieces(1) }, "from 2 to 64, is 1"),
        (
            SandboxAction::ChooseMesh { file: BOWL.into(), scale: 1.0, form: MeshForm::Pieces(65) },
            "from 2 to 64, is 65",
        ),
        (
            SandboxAction::ChooseMesh {
                file: "no.obj".into(),
                scale: 1.0,
                form: MeshForm::Surface { two_sided: false },
            },
            "no.obj cannot be read",
        ),
        (SandboxAction::ChooseHills(Hills { squares: 1, ..default() }), "hills: squares must be from 2 to 200"),
    ] {
        stage.act(asked);
        let Notice::Error(said) = stage.world().resource::<Notice>().clone() else { panic!("{words}: was taken") };
        assert!(said.contains(words) && said.lines().count() == 1, "{said}");
        assert_eq!(stage.world().resource::<Blueprint>().shape, shape);
    }
}

#[test]
fn hills_stand_on_the_ground_fixed_and_are_taken_back() {
    let mut stage = Stage::open_paused(GROUND);
    stage.act(SandboxAction::ChooseHills(Hills { size: [4.0, 3.0], height: 0.5, wavelength: 2.0, squares: 20 }));
    let hills = add(&mut stage, DVec3::new(0.3, 0.0, 0.2), "hills");
    let at = place(&mut stage, hills);
    assert!(at.distance(DVec3::new(0.3, 0.0, 0.2)) < 0.02 && at.y > 0.0, "{at}");
    assert_eq!(stage.world().get::<RigidBody>(hills), Some(&RigidBody::Static));
    // On the top in their middle, and in the valley beside it.
    stage.world().resource_mut::<Blueprint>().shape = ShapeSpec::Cuboid { size: DVec3::splat(0.2) };
    let top = add(&mut stage, at + DVec3::Y * 0.5, "box");
    let height = place(&mut stage, top).y;
    assert!((0.6..0.65).contains(&height), "it is not just above the top: {height} m");
    let ball = BodySpec::new("ball", ShapeSpec::Sphere { radius: 0.1 }, at + DVec3::new(0.0, 1.0, 1.0));
    let ball = ball.spawn(stage.world());
    stage.act(SandboxAction::TogglePause);
    stage.frames(90);
    let height = place(&mut stage, ball).y;
    assert!((0.1..0.4).contains(&height), "it fell through, or stays on a slope: {height} m");
    assert!(stage.world().get::<Velocity>(hills).is_none_or(|velocity| *velocity == Velocity::default()));
    stage.replays();
    for _ in 0..2 {
        stage.act(SandboxAction::Undo);
    }
    let world = stage.world();
    assert_eq!(world.query::<&RigidBody>().iter(world).count(), 2, "the ground and the ball");
}

#[test]
fn hills_are_not_built_over_what_stands_there() {
    let mut stage = Stage::open_paused(
        r#"(bodies: [
            (name: "ground", kind: Static, shape: HalfSpace),
            (name: "post", kind: Static, shape: Sphere(radius: 0.2), position: (1.8, 0.2, 0)),
            (name: "lamp", kind: Static, shape: Sphere(radius: 0.2), position: (-1, 2, 0)),
        ], view: (eye: (0, 5, 8), target: (0, 0, 0)))"#,
    );
    stage.act(SandboxAction::ChooseHills(Hills { size: [4.0, 3.0], height: 0.5, wavelength: 2.0, squares: 20 }));
    let place = stage.seen_at(DVec3::ZERO);
    stage.move_to(place);
    stage.act(SandboxAction::SpawnBody);
    let Notice::Error(said) = stage.world().resource::<Notice>().clone() else { panic!("they are built over a post") };
    assert_eq!(said, "post is where hills would be: move it away, or point elsewhere");
    // Beside the post and under the lamp there is room.
    add(&mut stage, DVec3::new(-0.7, 0.0, 0.0), "hills");
}
