//! Recordings: a file runs again to the last bit, says where it does not, and is refused in one line where it is not whole.

use std::path::Path;

use bevy::math::DVec3;
use bevy::prelude::*;
use plumb::lab::recording::{Difference, MOST_BODIES, Recording, Replay};
use plumb::lab::{Plan, Simulation};
use plumb::physics::{Breakable, BrokenJoint, ContactForces, History, Mass, SolverSettings, Velocity, bury, step};
use plumb::prelude::*;
use plumb::scene::BodySpec;

const MEMORY: usize = 512 << 20;

fn plan(scene: &str, parameters: &[(&str, f64)], settings: SolverSettings, seconds: f64) -> Plan {
    let parameters: Vec<_> = parameters.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
    Plan::new(scene, &parameters, settings, Some(seconds)).unwrap()
}

fn recorded(plan: &Plan) -> Recording {
    let mut recording = Recording::of_plan(plan).unwrap();
    let mut simulation = Simulation::new(plan.scene.clone(), plan.settings);
    recording.note(&simulation);
    for _ in 0..plan.steps {
        simulation.step();
        recording.note(&simulation);
    }
    recording
}

/// Through a file.
fn through_a_file(recording: &Recording) -> Recording {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.plumb");
    let bytes = recording.write(&path).unwrap();
    assert_eq!(std::fs::metadata(&path).unwrap().len(), bytes as u64);
    let read = Recording::read(&path).unwrap();
    assert_eq!(&read, recording);
    read
}

fn replay(recording: &Recording) -> Replay {
    recording.replay(Path::new("a.plumb"), |_| ()).unwrap()
}

#[test]
fn what_ran_by_itself_runs_again_the_same() {
    for (scene, parameters) in [
        ("limbs", &[][..]),
        ("car", &[]),
        ("heap", &[("kind", 4.0), ("n", 60.0)]),
        ("tower", &[]),
        ("arm", &[]),
        ("card_house", &[]),
    ] {
        for settings in [SolverSettings::game(), SolverSettings::classic()] {
            let recording = through_a_file(&recorded(&plan(scene, parameters, settings, 0.5)));
            assert_eq!(replay(&recording), Replay { steps: 30, differs: None }, "{scene}");
        }
    }
}

/// A world in which somebody does this and that.
fn disturbed() -> (Simulation, Recording) {
    let plan = plan("limbs", &[], SolverSettings::game(), 1.0);
    let mut simulation = Simulation::new(plan.scene.clone(), plan.settings);
    simulation.keep_history(MEMORY);
    let entities = simulation.entities().clone();
    let world = simulation.world_mut();
    let named = |world: &mut World, name: &str| {
        let mut names = world.query::<(Entity, &Name)>();
        names.iter(world).find(|(_, found)| found.as_str() == name).expect("it is there").0
    };
    (0..10).for_each(|_| step(world));
    let hand = named(world, "ann left hand");
    world.get_mut::<Velocity>(hand).unwrap().linear += DVec3::new(2.0, 1.0, -0.3);
    step(world);
    // A drag.
    let handle = world.spawn((Name::new("handle"), RigidBody::Kinematic, Position(DVec3::new(0.0, 2.0, 0.0)))).id();
    let softness = Softness { frequency: 5.0, damping_ratio: 1.0, max_force: 300.0 };
    let grip = world.spawn(BallJoint::new(handle, hand).with_softness(softness)).id();
    world.entity_mut(hand).insert(Damping { linear: 0.0, angular: 3.0 });
    for place in 0..15 {
        world.get_mut::<Position>(handle).unwrap().0.x = 0.03 * f64::from(place);
        step(world);
    }
    bury(world, grip);
    bury(world, handle);
    world.entity_mut(hand).remove::<Damping>();
    // A body, a hull, a joint between them that breaks; one that goes; other settings.
    let ball = (RigidBody::Dynamic, Collider::sphere(0.2), Position(DVec3::new(0.0, 3.0, 0.5)), Mass(2.0));
    let ball = world.spawn(ball).id();
    step(world);
    let gem = named(world, "gem");
    let gem = world.get::<Collider>(gem).unwrap().clone();
    let gem = world.spawn((RigidBody::Dynamic, gem, Position(DVec3::new(0.4, 3.0, 0.5)))).id();
    let joint = HingeJoint::new(ball, gem).with_anchors(DVec3::X * 0.2, -DVec3::X * 0.2);
    let joint = world.spawn((joint, Breakable::at_force(1.0).at_once())).id();
    (0..10).for_each(|_| step(world));
    assert!(world.get::<BrokenJoint>(joint).is_some(), "nothing broke");
    let rock = named(world, "rock");
    let crate_0 = named(world, "crate 0");
    let spec = BodySpec::of_entity(world, crate_0).unwrap();
    bury(world, rock);
    bury(world, crate_0);
    world.insert_resource(Gravity(DVec3::new(1.0, -3.0, 0.0)));
    (0..5).for_each(|_| step(world));
    spec.spawn_at(world, crate_0);
    (0..5).for_each(|_| step(world));
    world.insert_resource(SolverSettings { substeps: 7, ..SolverSettings::sequential_impulses() });
    (0..12).for_each(|_| step(world));
    let recording = Recording::of_world(world, &plan.scene, &entities).unwrap();
    (simulation, recording)
}

#[test]
fn what_hands_did_is_done_again_and_the_world_is_left_as_it_was() {
    let (mut simulation, recording) = disturbed();
    let before = simulation.state_hash();
    assert_eq!(recording.prints.last().unwrap().world, before);
    let recording = through_a_file(&recording);
    assert!(recording.deeds.len() >= 20, "{:?}", recording.deeds);
    assert_eq!(replay(&recording), Replay { steps: recording.steps(), differs: None });
    let entities = simulation.entities().clone();
    let scene = simulation.scene().clone();
    let again = Recording::of_world(simulation.world_mut(), &scene, &entities).unwrap();
    assert_eq!(again, recording);
    assert_eq!(simulation.state_hash(), before);
}

#[test]
fn the_first_step_and_body_that_differ_are_told() {
    let (_, recording) = disturbed();
    // Without the push on a hand, the figure is elsewhere one step later, and nobody else.
    let mut other = recording.clone();
    assert_eq!(other.deeds.remove(0).0, 10);
    let Replay { steps, differs } = replay(&other);
    let Difference { step, body } = differs.expect("another course");
    assert_eq!((steps, step), (11, 11));
    assert!(body.as_ref().is_some_and(|body| body.starts_with("ann ")), "{body:?}");
    // What only the solver knows.
    let mut other = recording.clone();
    other.prints[7].world ^= 1;
    assert_eq!(replay(&other).differs, Some(Difference { step: 7, body: None }));
    // Another step.
    let mut other = recording;
    other.settings = other.settings.replacen("substeps:4", "substeps:5", 1);
    assert_eq!(replay(&other).differs.expect("other substeps").step, 1);
}

#[test]
fn more_bodies_than_one_tells_apart_have_one_fingerprint() {
    let recording = recorded(&plan("heap", &[("n", 1001.0)], SolverSettings::game(), 0.05));
    assert!(recording.prints[0].bodies.is_empty());
    let few = recorded(&plan("heap", &[("n", 100.0)], SolverSettings::game(), 0.05));
    assert!((100..MOST_BODIES).contains(&few.prints[0].bodies.len()));
    let recording = through_a_file(&recording);
    assert_eq!(replay(&recording), Replay { steps: 3, differs: None });
}

#[test]
fn a_history_that_has_lost_its_start_is_not_recorded() {
    let plan = plan("stack", &[], SolverSettings::game(), 1.0);
    let mut simulation = Simulation::new(plan.scene.clone(), plan.settings);
    simulation.keep_history(0);
    // When it takes a keyframe is up to the clock.
    let starts_at = |simulation: &mut Simulation| simulation.world_mut().resource::<History>().reach()[0];
    for _ in 0..200 {
        (0..2000).for_each(|_| simulation.step());
        if starts_at(&mut simulation) > 0 {
            break;
        }
    }
    let entities = simulation.entities().clone();
    let error = Recording::of_world(simulation.world_mut(), &plan.scene, &entities).unwrap_err().to_string();
    assert!(error.contains("is not kept any more"), "{error}");
}

#[test]
fn bad_files_are_refused_in_a_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.plumb");
    let text = recorded(&plan("stack", &[], SolverSettings::game(), 0.1)).text();
    let said = |text: &str| {
        std::fs::write(&path, text).unwrap();
        let outcome = Recording::read(&path).and_then(|recording| recording.replay(&path, |_| ()));
        let error = outcome.unwrap_err().to_string();
        assert!(error.contains("a.plumb") && !error.contains('\n'), "{error}");
        error
    };
    assert!(said("").contains("is no recording"));
    assert!(said("(bodies: [])").contains("is no recording"));
    assert!(said(&text.replacen("recording 1", "recording 2", 1)).contains("of format 2"));
    for share in 1..40 {
        let length = text.len() * share / 40;
        let error = said(&text[..length]);
        assert!(error.contains("in the middle") || error.contains("is no recording") || error.contains("of format"));
    }
    assert!(said(&text.replacen("print ", "point ", 1)).contains(": expected a line of"));
    let line = text.lines().position(|line| line.starts_with("print ")).unwrap() + 1;
    let one = text.lines().nth(line - 1).unwrap();
    assert!(said(&text.replacen(one, "print 12zz 00", 1)).contains(&format!(":{line}: no fingerprints")));
    let deed = |deed: &str| said(&text.replacen(one, &format!("{one}\ndeeds {deed}"), 1));
    assert!(
        deed("(written: [(77, [(\"Position\", \"((1,2,3))\")])])")
            .contains(&format!(":{}: there is no entity 77", line + 1))
    );
    assert!(deed("(written: [(0, [(\"Positron\", \"((1,2,3))\")])])").contains("nothing is called Positron"));
    assert!(deed("(written: [(0, [(\"Position\", \"(1,2\")])])").contains("Position"));
    assert!(deed("nonsense").contains(&format!(":{}:", line + 1)));
    assert!(deed("(resources: [(\"Mass\", \"(1.0)\")])").contains("no resource"));
    assert!(said(&text.replacen("reads nothing", "reads minds", 1)).contains("'forces' or 'nothing'"));
    assert!(said(&text.replacen("hz:60", "hz:-60", 1)).contains("hz"));
    assert!(said(&text.replacen("settings (", "settings )", 1)).contains(":"));
}

/// The last bits of what rests depend on whether its forces are read: that is recorded, too.
#[test]
fn what_was_read_is_read_again() {
    let plan = plan("stack", &[], SolverSettings::game(), 0.5);
    let mut recording = Recording::of_plan(&plan).unwrap();
    let mut simulation = Simulation::new(plan.scene.clone(), plan.settings);
    simulation.world_mut().init_resource::<ContactForces>();
    for _ in 0..30 {
        recording.note(&simulation);
        simulation.step();
    }
    let mut recording = through_a_file(&recording);
    assert!(recording.reads_forces);
    assert_eq!(replay(&recording), Replay { steps: 29, differs: None });
    recording.reads_forces = false;
    assert!(replay(&recording).differs.is_some());
}
