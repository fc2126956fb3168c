//! The components of bodies, table by table, and which rows of a table somebody wrote to.
//!
//! A row needs gathering if
//! - a component that the packed body holds was written since the last gathering, by anybody but
//!   `WriteBack`: what that wrote came from the packed body;
//! - an optional component came or went: the set of those it was gathered with differs;
//! - its `Transform` was written and differs from what Plumb wrote;
//! - the last gathering or `WriteBack` found something wrong with it.
//!
//! Ticks lie in columns of their own, so that looking at all of them is a few instructions for
//! eight bodies.

use bevy::ecs::change_detection::{ContiguousMut, ContiguousRef, Tick};
use bevy::ecs::query::QueryData;
use bevy::prelude::*;

use crate::physics::{
    BodySlot, Collider, CollisionLayers, Damping, Density, ExternalForce, GatheredWith, GravityScale, Inertia,
    LockedAxes, Mass, PoseHistory, Position, Presence, Quarantined, Refill, ReportCollisions, RigidBody, Rotation,
    Sensor, Sleeping, SurfaceMaterial, Velocity,
};

#[derive(QueryData)]
#[query_data(mutable, contiguous(all))]
pub(super) struct BodyQuery {
    pub entity: Entity,
    pub kind: Ref<'static, RigidBody>,
    pub slot: &'static mut BodySlot,
    pub gathered_with: &'static mut GatheredWith,
    pub position: &'static mut Position,
    pub rotation: &'static mut Rotation,
    pub velocity: &'static mut Velocity,
    pub transform: Ref<'static, Transform>,
    pub history: &'static mut PoseHistory,
    pub collider: Option<Ref<'static, Collider>>,
    pub density: Option<Ref<'static, Density>>,
    pub mass: Option<Ref<'static, Mass>>,
    pub inertia: Option<Ref<'static, Inertia>>,
    pub force: Option<Ref<'static, ExternalForce>>,
    pub material: Option<Ref<'static, SurfaceMaterial>>,
    pub layers: Option<Ref<'static, CollisionLayers>>,
    pub locked: Option<Ref<'static, LockedAxes>>,
    pub gravity_scale: Option<Ref<'static, GravityScale>>,
    pub damping: Option<Ref<'static, Damping>>,
    pub reports: Has<ReportCollisions>,
    pub quarantined: Option<&'static Quarantined>,
    pub parent: Has<ChildOf>,
    pub sleeping: Has<Sleeping>,
    pub sensor: Has<Sensor>,
}

/// All bodies with the same components, a slice each.
pub(super) type BodyTable<'w, 's> = BodyQueryContiguousItem<'w, 's>;

/// What counts as written by others.
#[derive(Clone, Copy)]
pub(super) struct Watch {
    pub last_run: Tick,
    pub this_run: Tick,
    /// When `WriteBack` wrote.
    pub written_back: Tick,
}

impl Watch {
    pub fn is_new(&self, tick: Tick) -> bool {
        tick.is_newer_than(self.last_run, self.this_run)
    }

    fn is_foreign(&self, tick: Tick) -> bool {
        self.is_new(tick) & (tick != self.written_back)
    }

    /// Flags the rows that others wrote. Returns whether there is one.
    fn mark(&self, ticks: &[Tick], stale: &mut [bool]) -> bool {
        // Without a branch in either loop, for the vectorizer.
        let any = ticks.iter().fold(false, |any, &tick| any | self.is_foreign(tick));
        if any {
            for (stale, &tick) in stale.iter_mut().zip(ticks) {
                *stale |= self.is_foreign(tick);
            }
        }
        any
    }
}

fn ticks<'a, T>(column: &'a Option<ContiguousRef<T>>) -> Option<&'a [Tick]> {
    column.as_ref().map(|column| column.changed_ticks_slice())
}

impl BodyTable<'_, '_> {
    /// The optional columns with values, by when each row changed.
    fn optional_columns(&self) -> [Option<&[Tick]>; 10] {
        [
            ticks(&self.collider),
            ticks(&self.density),
            ticks(&self.mass),
            ticks(&self.inertia),
            ticks(&self.force),
            ticks(&self.material),
            ticks(&self.layers),
            ticks(&self.locked),
            ticks(&self.gravity_scale),
            ticks(&self.damping),
        ]
    }

    pub fn presence(&self) -> Presence {
        let marks = [self.reports, self.quarantined.is_some(), self.parent, self.sleeping, self.sensor];
        let present = self.optional_columns().map(|column| column.is_some()).into_iter().chain(marks);
        Presence((0..).zip(present).map(|(bit, present)| u32::from(present) << bit).sum())
    }

    /// Flags the rows to gather. Returns whether there is one. `regrouped`: optional components came to some row, or went.
    pub fn find_stale(&self, watch: &Watch, regrouped: bool, stale: &mut Vec<bool>) -> bool {
        let rows = self.entity.len();
        // What is quarantined is looked at every step: it may have been mended, and it is counted.
        let all = self.quarantined.is_some() || self.parent;
        stale.reset(rows, all);
        if all {
            return true;
        }
        let mut any = regrouped;
        if regrouped {
            let present = GatheredWith(self.presence().0);
            for (stale, with) in stale.iter_mut().zip(self.gathered_with.as_ref()) {
                *stale |= *with != present;
            }
        }
        let required = [
            self.kind.changed_ticks_slice(),
            self.position.changed_ticks_slice(),
            self.rotation.changed_ticks_slice(),
            self.velocity.changed_ticks_slice(),
        ];
        for ticks in required.into_iter().chain(self.optional_columns().into_iter().flatten()) {
            any |= watch.mark(ticks, stale);
        }
        any | self.find_teleported(watch, stale)
    }

    /// Transforms are written by Plumb itself too: bits tell whose they are.
    fn find_teleported(&self, watch: &Watch, stale: &mut [bool]) -> bool {
        let ticks = self.transform.changed_ticks_slice();
        if !ticks.iter().fold(false, |any, &tick| any | watch.is_new(tick)) {
            return false;
        }
        let mut any = false;
        let histories: &[PoseHistory] = self.history.as_ref();
        for (((stale, &tick), transform), history) in stale.iter_mut().zip(ticks).zip(&*self.transform).zip(histories) {
            let teleported = watch.is_new(tick) && history.is_foreign(transform);
            *stale |= teleported;
            any |= teleported;
        }
        any
    }

    /// Whether a row's collider has changed or is new.
    pub fn is_collider_new(&self, row: usize, watch: &Watch) -> bool {
        is_new(&self.collider, row, watch)
    }

    /// Whether a row's density or mass has changed or is new.
    pub fn is_density_or_mass_new(&self, row: usize, watch: &Watch) -> bool {
        is_new(&self.density, row, watch) || is_new(&self.mass, row, watch)
    }
}

fn is_new<T>(column: &Option<ContiguousRef<T>>, row: usize, watch: &Watch) -> bool {
    ticks(column).is_some_and(|ticks| watch.is_new(ticks[row]))
}

/// Reads one row of a column that bodies need not have.
pub(super) fn optional<T: Copy>(column: &Option<ContiguousRef<T>>, row: usize) -> Option<T> {
    column.as_ref().map(|column| column[row])
}

/// Likewise, its default where they have not.
pub(super) fn or_default<T: Copy + Default>(column: &Option<ContiguousRef<T>>, row: usize) -> T {
    optional(column, row).unwrap_or_default()
}

/// Reads one row of a column.
pub(super) fn value<T: Copy>(column: &ContiguousMut<T>, row: usize) -> T {
    let values: &[T] = column.as_ref();
    values[row]
}
