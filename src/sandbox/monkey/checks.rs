//! What must hold whatever a monkey does. Each check says what does not.

use std::collections::HashSet;
use std::path::Path;

use bevy::ecs::resource::IsResource;
use bevy::ecs::system::SystemIdMarker;
use bevy::prelude::*;
use rand_pcg::Pcg64Mcg;

use super::deeds::{moment_up_to, pause};
use crate::lab::recording::Recording;
use crate::lab::{Simulation, state_hash, widest_gap_of_limb};
use crate::physics::{
    History, Position, Quarantined, RigidBody, Rotation, SolverSettings, StepStats, Velocity, left_over,
};
use crate::sandbox::recordings::so_far;
use crate::sandbox::{CurrentScene, Hands, SandboxAction};
use crate::scene::{JointSpec, SceneSpec};

/// Steps that a saved scene and what it was saved from are compared over.
const STEPS_AFTER_LOADING: usize = 3;
/// Steps in which nobody does anything before the joints are looked at.
const REST: usize = 60;
/// Share of the smaller of the two joined bodies by which a joint may be off then.
const MOST_GAP: f64 = 0.1;

pub(super) type Check = Result<(), String>;

/// All numbers are finite, and nothing had to be set aside but those bodies, to which what `may_be` is added.
pub(super) fn is_finite(hands: &mut Hands, aside: &mut HashSet<Entity>, may_be: bool) -> Check {
    let world = hands.world();
    let mut bodies = world.query::<(&Position, &Rotation, &Velocity)>();
    let is_finite = |(at, turned, v): (&Position, &Rotation, &Velocity)| {
        at.is_finite() && turned.is_finite() && v.linear.is_finite() && v.angular.is_finite()
    };
    if !bodies.iter(world).all(is_finite) {
        return Err("a pose or a velocity is not finite".into());
    }
    let mut quarantined = world.query::<(NameOrEntity, &Quarantined)>();
    for (name, quarantined) in quarantined.iter(world) {
        if may_be {
            aside.insert(name.entity);
        } else if !aside.contains(&name.entity) {
            return Err(format!("{name} was set aside: {}", quarantined.reason));
        }
    }
    Ok(())
}

/// The greatest speed of a body, m/s or rad/s.
pub(super) fn fastest(hands: &mut Hands) -> f64 {
    let world = hands.world();
    let mut bodies = world.query::<&Velocity>();
    bodies.iter(world).map(|v| v.linear.length().max(v.angular.length())).fold(0.0, f64::max)
}

/// Back to an earlier moment and on again step by step: the world is the same to the last bit, and nothing is kept of what
/// is gone.
pub(super) fn goes_back_and_on(hands: &mut Hands, random: &mut Pcg64Mcg) -> Check {
    pause(hands, true);
    hands.frames(1);
    let (head, before) = (step(hands), state_hash(hands.app.world()));
    let to = moment_up_to(hands, random, head);
    hands.act(SandboxAction::GoTo { step: to });
    if step(hands) != to {
        return Err(format!("step {to} cannot be gone back to: the world is at {}", step(hands)));
    }
    while step(hands) < head {
        let last = step(hands);
        hands.act(SandboxAction::StepOnce);
        if step(hands) <= last {
            return Err(format!("no step comes after {last}"));
        }
    }
    if state_hash(hands.app.world()) != before {
        return Err(format!("back to step {to} and on to {head} is another world"));
    }
    // What went since the last step is known to the next.
    let history = hands.app.world().get_resource::<History>();
    if to < head
        && !history.is_some_and(|history| history.acts().any(|step| step == head))
        && let Some(left) = left_over(hands.app.world())
    {
        return Err(left);
    }
    pause(hands, false);
    Ok(())
}

/// The scene as it stands, saved and loaded: the file says the same again, bodies are where they were, and it goes on as what
/// it was saved from would.
pub(super) fn saves_and_loads(hands: &mut Hands, settings: &SolverSettings) -> Check {
    let saved = SceneSpec::of_world(hands.world(), "saved");
    let text = saved.to_ron(None).map_err(|error| format!("the scene cannot be saved: {error}"))?;
    let loaded = SceneSpec::from_ron(&text, "saved").map_err(|error| format!("the saved scene: {error}"))?;
    if loaded.to_ron(None).ok().as_ref() != Some(&text) {
        return Err("the saved scene is another once it is loaded".into());
    }
    let [mut one, mut other] = [saved.in_order_of_a_file(), loaded].map(|scene| Simulation::new(scene, *settings));
    for after in 0..=STEPS_AFTER_LOADING {
        if one.state_hash() != other.state_hash() {
            let bodies = one.scene().bodies.iter().zip(one.sample().bodies).zip(other.sample().bodies);
            let first = bodies.into_iter().find(|((_, one), other)| one != other);
            let first = first.map_or(String::new(), |((body, _), _)| format!(", first '{}'", body.name));
            return Err(format!("{after} steps after loading, the saved scene is another{first}"));
        }
        one.step();
        other.step();
    }
    Ok(())
}

/// A second after hands let go, the joints of the scene hold that no joint of the monkey's has to do with: what came back where
/// others are by now, and is pinned, may have no place to be. By sweeps over forces joints need not hold, as their maps show.
pub(super) fn joints_hold(hands: &mut Hands, settings: &SolverSettings) -> Check {
    if settings.method.is_force_level() {
        return Ok(());
    }
    let Some(scene) = hands.app.world().get_resource::<CurrentScene>().map(|current| current.spec.clone()) else {
        return Ok(());
    };
    hands.frames(REST);
    let simulation = Simulation::new(SceneSpec::of_world(hands.world(), "now"), *settings);
    let meddled = meddled_with(simulation.scene(), &scene);
    let is_own = |joint: &JointSpec| !meddled.contains(&joint.body_a) && !meddled.contains(&joint.body_b);
    match widest_gap_of_limb(&simulation, is_own) {
        Some((joint, gap)) if gap > MOST_GAP => Err(format!(
            "{joint} is off by {gap:.2} of the smaller body that it holds, {REST} steps after the last hand let go"
        )),
        _ => Ok(()),
    }
}

/// The moving bodies that hang together with a joint which the scene did not have at first.
fn meddled_with(now: &SceneSpec, first: &SceneSpec) -> HashSet<String> {
    let moves: HashSet<&String> =
        now.bodies.iter().filter(|body| body.kind == RigidBody::Dynamic).map(|body| &body.name).collect();
    let ends = |joint: &JointSpec| [joint.body_a.clone(), joint.body_b.clone()];
    let was_there: HashSet<_> = first.joints.iter().map(ends).collect();
    let mut meddled: HashSet<String> =
        now.joints.iter().map(ends).filter(|ends| !was_there.contains(ends)).flatten().collect();
    meddled.retain(|body| moves.contains(body));
    loop {
        let before = meddled.len();
        for joint in &now.joints {
            let ends = ends(joint);
            if ends.iter().any(|end| meddled.contains(end)) {
                meddled.extend(ends.into_iter().filter(|end| moves.contains(end)));
            }
        }
        if meddled.len() == before {
            return meddled;
        }
    }
}

/// What happened is a recording that runs again to the last bit; the recording.
pub(super) fn is_a_recording(hands: &mut Hands) -> Result<Recording, String> {
    let recording = record(hands)?;
    let replay = recording.replay(Path::new("the recording"), |_| ()).map_err(|error| error.to_string())?;
    match replay.differs {
        None => Ok(recording),
        Some(differs) => Err(format!("its recording comes out otherwise at step {}{}", differs.step, differs.first())),
    }
}

/// What happened since the scene began.
pub(super) fn record(hands: &mut Hands) -> Result<Recording, String> {
    so_far(hands.world()).ok_or("there is no scene")?.map_err(|error| error.to_string())
}

/// Everything that there is, but for what Bevy makes once of each resource and of each system that is called by hand.
pub(super) fn count_entities(hands: &mut Hands) -> usize {
    let world = hands.world();
    world.query_filtered::<Entity, (Without<IsResource>, Without<SystemIdMarker>)>().iter(world).count()
}

pub(super) fn step(hands: &Hands) -> u64 {
    hands.app.world().resource::<StepStats>().steps
}
