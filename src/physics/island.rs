//! Islands: bodies that can influence each other in this step, through contacts or joints.
//!
//! Union–find over the bodies that move; static and kinematic bodies connect nobody. Small
//! islands are packed together into [`Islands`]' groups, so that one unit of work is worth a
//! claim; a group's constraints keep the order in which contacts and joints were found. What
//! sleeps is in no island here: [`super::sleep`] has it.

#[cfg(test)]
mod tests;

use bevy::prelude::*;

use super::grouped::Grouped;
use super::{Bodies, ContactGraph, Contacts, Joints, Keep, LaggedContacts, Refill, SolverSettings, StepStats};

/// Islands are packed until a group has this many bodies.
const BODIES_PER_GROUP: u32 = 128;

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<Islands>().keep_resource::<Islands>();
}

/// The islands of this step, packed into groups that share no body that moves.
#[derive(Resource, Default, Clone)]
pub(crate) struct Islands {
    /// Group of each body; [`Grouped::NONE`] for static ones.
    group_of: Vec<u32>,
    /// Position of each body in its group.
    local_of: Vec<u32>,
    bodies: Grouped,
    manifolds: Grouped,
    joints: Grouped,
    parent: Vec<u32>,
    size: Vec<u32>,
    constrained: Vec<bool>,
    /// Whether something that does not move by contacts and joints holds or touches an island, by its root.
    grounded: Vec<bool>,
    /// Counts every time they were found anew.
    version: u64,
    /// What they were found for: versions of contacts that last, of joints and of who sleeps.
    found_for: Option<(u64, u64, u64)>,
}

impl Islands {
    /// Changes whenever they were found anew.
    pub fn version(&self) -> u64 {
        self.version
    }

    /// Groups to solve.
    pub fn count(&self) -> usize {
        self.bodies.count()
    }

    /// The bodies that move in a group, in their order.
    pub fn bodies(&self, group: usize) -> &[u32] {
        self.bodies.of(group)
    }

    /// The manifolds of a group, in the order in which they were found.
    pub fn manifolds(&self, group: usize) -> &[u32] {
        self.manifolds.of(group)
    }

    /// The joints of a group, in their order.
    pub fn joints(&self, group: usize) -> &[u32] {
        self.joints.of(group)
    }

    /// Where a body stands in a group, if it moves there.
    pub fn local_of(&self, body: u32, group: usize) -> Option<u32> {
        (self.group_of[body as usize] == group as u32).then(|| self.local_of[body as usize])
    }

    /// The body of lowest index in the island of a body that is awake.
    pub fn root_of(&self, body: u32) -> u32 {
        self.parent[body as usize]
    }

    /// The same of any body, if there is one of that index and some constraint holds or touches the island.
    pub fn constrained_root_of(&self, body: u32) -> Option<u32> {
        let root = *self.parent.get(body as usize)?;
        self.constrained.get(root as usize)?.then_some(root)
    }

    /// Whether something that contacts and joints do not move holds or touches the island of that root.
    pub fn is_grounded(&self, root: u32) -> bool {
        self.grounded[root as usize]
    }

    /// Manifolds and joints in all groups.
    pub fn constraint_count(&self) -> (usize, usize) {
        (self.manifolds.all().len(), self.joints.all().len())
    }

    fn root(&mut self, mut body: u32) -> u32 {
        while self.parent[body as usize] != body {
            let grandparent = self.parent[self.parent[body as usize] as usize];
            self.parent[body as usize] = grandparent;
            body = grandparent;
        }
        body
    }

    /// The lower index becomes the root, so that roots do not depend on the order of unions.
    fn union(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.parent[a.max(b) as usize] = a.min(b);
    }

    /// Groups of islands in the order of their first body. Returns how many islands have a
    /// constraint.
    fn pack(&mut self, bodies: &Bodies) -> u32 {
        let n = bodies.list.len();
        self.size.reset(n, 0);
        for body in bodies.awake() {
            let root = self.root(body);
            self.parent[body as usize] = root;
            self.size[root as usize] += 1;
        }
        self.group_of.reset(n, Grouped::NONE);
        self.local_of.reset(n, 0);
        let (mut group, mut filled, mut constrained) = (0, 0, 0);
        for body in bodies.awake() {
            let root = self.parent[body as usize];
            if root == body {
                constrained += u32::from(self.constrained[body as usize]);
                let size = self.size[body as usize];
                if filled > 0 && filled + size > BODIES_PER_GROUP {
                    group += 1;
                    filled = 0;
                }
                filled += size;
            }
            // The root has the lowest index, so its group is known already.
            self.group_of[body as usize] = if root == body { group } else { self.group_of[root as usize] };
        }
        let groups = if filled > 0 { group + 1 } else { 0 };
        self.bodies.rebuild(groups, bodies.awake().map(|body| (body, self.group_of[body as usize])));
        for group in 0..groups as usize {
            for (local, &body) in self.bodies.of(group).iter().enumerate() {
                self.local_of[body as usize] = local as u32;
            }
        }
        constrained
    }
}

/// Does nothing where neither contacts that last nor joints nor who sleeps have changed: it may be run again after
/// islands fell asleep.
pub(super) fn find_islands(
    bodies: Res<Bodies>,
    joints: Res<Joints>,
    contacts: Res<Contacts>,
    graph: Option<Res<ContactGraph>>,
    lagged: Res<LaggedContacts>,
    settings: Res<SolverSettings>,
    mut islands: ResMut<Islands>,
    mut stats: ResMut<StepStats>,
) {
    let islands = &mut *islands;
    if settings.method.keeps_contacts()
        && let Some(graph) = graph
    {
        let found_for = Some((graph.version, joints.version, bodies.sleep_version));
        if islands.found_for == found_for {
            return;
        }
        islands.found_for = found_for;
        stats.islands = islands.find(&bodies, &joints, graph.touching());
    } else {
        islands.found_for = None;
        let contacts = lagged.active(&settings, &contacts);
        let pairs = contacts.manifolds.iter().map(|manifold| (manifold.pair.a, manifold.pair.b));
        stats.islands = islands.find(&bodies, &joints, (0..).zip(pairs));
    }
}

impl Islands {
    /// Finds and packs the islands that contacts, numbered, and joints make of what is awake.
    /// Returns how many have a constraint.
    fn find(
        &mut self,
        bodies: &Bodies,
        joints: &Joints,
        contacts: impl Iterator<Item = (u32, (u32, u32))> + Clone,
    ) -> u32 {
        self.version += 1;
        self.parent.refill(0..bodies.list.len() as u32);
        self.constrained.reset(bodies.list.len(), false);
        self.grounded.reset(bodies.list.len(), false);
        let dynamic = |body: u32| bodies.is_awake_dynamic(body);
        let joint_pairs = (0..).zip(joints.list.iter().map(|joint| (joint.a, joint.b)));
        for (_, (a, b)) in contacts.clone().chain(joint_pairs.clone()) {
            if dynamic(a) && dynamic(b) {
                self.union(a, b);
            }
        }
        for (_, (a, b)) in contacts.clone().chain(joint_pairs.clone()) {
            if dynamic(a) || dynamic(b) {
                let root = self.root(if dynamic(a) { a } else { b });
                self.constrained[root as usize] = true;
                self.grounded[root as usize] |= !(dynamic(a) && dynamic(b));
            }
        }
        let constrained = self.pack(bodies);
        let groups = self.count() as u32;
        let Self { group_of, manifolds, joints, .. } = self;
        let with_group = |(item, (a, b)): (u32, (u32, u32))| {
            let moved = [a, b].into_iter().find(|&body| dynamic(body));
            (item, moved.map_or(Grouped::NONE, |body| group_of[body as usize]))
        };
        manifolds.rebuild(groups, contacts.map(with_group));
        joints.rebuild(groups, joint_pairs.map(with_group));
        constrained
    }
}
