//! Joints whose load somebody looks at: those alone carry it.

use bevy::prelude::*;

use super::any_joint::IsJoint;
use super::gizmos::ShownGizmos;
use super::looked_at::LookedAt;
use super::probe::read_loads;
use super::why::ColorBy;
use crate::physics::{JointLoad, StepStats};
use crate::scene::{Probes, SpawnedScene};

/// Joints of which the panel shows numbers.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub(super) struct ReadJoints {
    /// Those that are open in the list.
    pub open: Vec<Entity>,
    /// The one that is plotted.
    pub plotted: Option<Entity>,
}

impl ReadJoints {
    /// The scene was spawned anew: its joints are other entities now.
    pub fn follow(&mut self, before: &SpawnedScene, now: &SpawnedScene) {
        let place = self.plotted.and_then(|plotted| before.joints.iter().position(|joint| *joint == plotted));
        self.plotted = place.and_then(|place| now.joints.get(place).copied());
    }

    /// With those whose load probes read.
    fn all(&self, probes: &Probes) -> Vec<Entity> {
        self.open.iter().copied().chain(self.plotted).chain(read_loads(probes)).collect()
    }
}

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<ReadJoints>().init_resource::<Probes>().add_systems(PreUpdate, switch_joint_loads);
}

fn switch_joint_loads(
    mut commands: Commands,
    shown: Res<ShownGizmos>,
    by: Res<ColorBy>,
    read: Res<ReadJoints>,
    probes: Res<Probes>,
    stats: Res<StepStats>,
    without: Query<Entity, (IsJoint, Without<JointLoad>)>,
    with: Query<Entity, (IsJoint, With<LookedAt>)>,
) {
    let marked = || (JointLoad::default(), LookedAt::from_now(&stats));
    let begin = |joint: Entity| _ = commands.entity(joint).insert(marked());
    let are_all_read = shown.joints || *by == ColorBy::Load;
    if are_all_read {
        without.iter().for_each(begin);
    } else {
        let mut read = read.all(&probes);
        read.retain(|joint| without.contains(*joint));
        read.sort_unstable();
        read.dedup();
        read.into_iter().for_each(begin);
    }
    if !are_all_read && (shown.is_changed() || by.is_changed() || read.is_changed() || probes.is_changed()) {
        let read = read.all(&probes);
        for joint in with.iter().filter(|joint| !read.contains(joint)) {
            commands.entity(joint).remove::<(JointLoad, LookedAt)>();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::any_joint::WholeJoint;
    use super::*;
    use crate::physics::{BallJoint, HingeJoint};

    fn switches() -> App {
        let mut app = App::new();
        app.init_resource::<ShownGizmos>().init_resource::<ColorBy>().init_resource::<StepStats>();
        plugin(&mut app);
        app
    }

    fn carries_load(app: &App, joint: Entity) -> bool {
        app.world().entity(joint).contains::<JointLoad>()
    }

    #[test]
    fn joints_carry_their_load_only_while_shown_and_so_do_later_ones() {
        let mut app = switches();
        let ball = BallJoint::new(Entity::PLACEHOLDER, Entity::PLACEHOLDER);
        let first = app.world_mut().spawn(ball).id();
        app.update();
        assert!(!carries_load(&app, first));

        app.world_mut().resource_mut::<ShownGizmos>().joints = true;
        app.update();
        let second = app.world_mut().spawn(HingeJoint::new(Entity::PLACEHOLDER, Entity::PLACEHOLDER)).id();
        app.update();
        assert!([first, second].iter().all(|joint| carries_load(&app, *joint)));

        app.world_mut().resource_mut::<ShownGizmos>().joints = false;
        app.update();
        assert!(![first, second].iter().any(|joint| carries_load(&app, *joint)));
    }

    #[test]
    fn a_joint_that_the_panel_shows_carries_its_load_alone() {
        let mut app = switches();
        let spawn = |app: &mut App| {
            let hinge = HingeJoint::new(Entity::PLACEHOLDER, Entity::PLACEHOLDER);
            app.world_mut().spawn(hinge).id()
        };
        let joints = [spawn(&mut app), spawn(&mut app), spawn(&mut app)];
        let own = app.world_mut().spawn((BallJoint::new(joints[0], joints[1]), JointLoad::default())).id();
        *app.world_mut().resource_mut::<ReadJoints>() = ReadJoints { open: vec![joints[0]], plotted: Some(joints[1]) };
        app.update();
        assert_eq!(joints.map(|joint| carries_load(&app, joint)), [true, true, false]);

        *app.world_mut().resource_mut::<ReadJoints>() = ReadJoints::default();
        app.update();
        assert_eq!(joints.map(|joint| carries_load(&app, joint)), [false; 3]);
        assert!(carries_load(&app, own), "what an application added stays");
    }

    #[test]
    fn a_load_is_known_once_a_step_has_told_it() {
        let mut app = switches();
        let joint = app.world_mut().spawn(BallJoint::new(Entity::PLACEHOLDER, Entity::PLACEHOLDER)).id();
        app.world_mut().resource_mut::<ReadJoints>().open.push(joint);
        let is_known = |app: &mut App| {
            app.update();
            let stats = *app.world().resource::<StepStats>();
            let mut joints = app.world_mut().query::<WholeJoint>();
            joints.get(app.world(), joint).unwrap().known_load(&stats).is_some()
        };
        assert!(!is_known(&mut app) && !is_known(&mut app), "nothing has been stepped");
        app.world_mut().resource_mut::<StepStats>().steps += 1;
        assert!(is_known(&mut app));
        // What an application asks to be told is its own to judge.
        let own = BallJoint::new(joint, joint);
        let own = app.world_mut().spawn((own, JointLoad::default())).id();
        let mut joints = app.world_mut().query::<WholeJoint>();
        let stats = StepStats::default();
        assert!(joints.get(app.world(), own).unwrap().known_load(&stats).is_some());
    }
}
