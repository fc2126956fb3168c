//! The system parameter.

use std::cell::LazyCell;
use std::cmp::Ordering;
use std::ops::ControlFlow;

use bevy::ecs::system::SystemParam;
use bevy::math::DVec3;
use bevy::prelude::*;
use nalgebra::Vector3;

use super::answers::{CastHit, Hit, PointHit, Ray, RayHit};
use super::asker::Asker;
use super::cast::Caster;
use super::filter::QueryFilter;
use super::index::{Index, IndexGuard, QueryIndex};
use super::meeting::meet;
use super::ray::enter;
use super::solid::solid_of;
use crate::physics::box_tree::Way;
use crate::physics::collision::{PartPair, PlacedCollider, has_parts, parts_within, place_up_to, touch};
use crate::physics::{Bodies, Body, PairSearch, SolverSettings, StepStats, for_each_of};

/// Rays that one thread takes at a time.
const RAYS_A_CHUNK: usize = 64;

/// Asks where bodies are: a system parameter.
///
/// ```
/// use bevy::math::DVec3;
/// use bevy::prelude::*;
/// use plumb::prelude::*;
///
/// fn look_down(query: PhysicsQuery) {
///     let ray = Ray::new(DVec3::Y * 10.0, DVec3::NEG_Y);
///     if let Some(hit) = query.ray(&ray, &QueryFilter::default()) {
///         println!("{} is {} m below", hit.entity, hit.distance);
///     }
/// }
///
/// let mut app = headless_app();
/// let ball = app.world_mut().spawn((RigidBody::Static, Collider::sphere(1.0))).id();
/// step(app.world_mut());
/// app.world_mut().run_system_cached(look_down).unwrap();
/// ```
///
/// Bodies are where the last step left them. Of hits at one distance the body with the lower entity comes first. Numbers
/// that are not finite, and a direction of no length, find nothing.
#[derive(SystemParam)]
pub struct PhysicsQuery<'w> {
    bodies: Res<'w, Bodies>,
    stats: Res<'w, StepStats>,
    settings: Res<'w, SolverSettings>,
    index: Res<'w, QueryIndex>,
}

impl PhysicsQuery<'_> {
    /// The first body that a ray meets.
    pub fn ray(&self, ray: &Ray, filter: &QueryFilter) -> Option<RayHit> {
        self.first_on(&self.index(), ray, filter)
    }

    /// All bodies that a ray meets, the nearest first, each where the ray enters it.
    pub fn ray_all(&self, ray: &Ray, filter: &QueryFilter) -> Vec<RayHit> {
        all(|take| self.along(&self.index(), ray, filter, take))
    }

    /// The first body that each of many rays meets, on as many threads as the settings allow.
    pub fn rays(&self, rays: &[Ray], filter: &QueryFilter) -> Vec<Option<RayHit>> {
        let mut hits = vec![None; rays.len()];
        let index = self.index();
        let chunks = rays.chunks(RAYS_A_CHUNK).zip(hits.chunks_mut(RAYS_A_CHUNK));
        for_each_of(self.settings.threads, chunks, |(rays, hits)| {
            for (ray, hit) in rays.iter().zip(hits) {
                *hit = self.first_on(&index, ray, filter);
            }
        });
        hits
    }

    /// The body nearest to a point, within `most`, m.
    pub fn nearest_point(&self, point: DVec3, most: f64, filter: &QueryFilter) -> Option<PointHit> {
        first(|take| self.around(point, most, filter, take))
    }

    /// All bodies within `most`, m, of a point, the nearest first.
    pub fn nearest_points(&self, point: DVec3, most: f64, filter: &QueryFilter) -> Vec<PointHit> {
        all(|take| self.around(point, most, filter, take))
    }

    /// The first body that a shape touches which moves straight on by `length`, m, along a direction. A half-space cannot
    /// be cast.
    pub fn shape_cast(
        &self,
        shape: &PlacedCollider,
        direction: DVec3,
        length: f64,
        filter: &QueryFilter,
    ) -> Option<CastHit> {
        first(|take| self.on_the_way(shape, direction, length, filter, take))
    }

    /// All bodies that a shape touches on such a way, as if the others let it pass, the first first.
    pub fn shape_cast_all(
        &self,
        shape: &PlacedCollider,
        direction: DVec3,
        length: f64,
        filter: &QueryFilter,
    ) -> Vec<CastHit> {
        all(|take| self.on_the_way(shape, direction, length, filter, take))
    }

    /// Whether a shape overlaps or touches a body; one of them.
    pub fn overlap(&self, shape: &PlacedCollider, filter: &QueryFilter) -> Option<Entity> {
        let (asker, mut found) = (Asker::new(shape)?, None);
        self.touching(&asker, filter, |other| {
            found = Some(other.entity);
            false
        });
        found
    }

    /// All bodies that a shape overlaps or touches, in the order of their entities.
    pub fn overlap_all(&self, shape: &PlacedCollider, filter: &QueryFilter) -> Vec<Entity> {
        let Some(asker) = Asker::new(shape) else { return Vec::new() };
        let mut found = Vec::new();
        self.touching(&asker, filter, |other| {
            found.push(other.entity);
            true
        });
        found.sort_unstable();
        found
    }

    /// The bodies that one overlaps or touches, itself left out.
    pub(super) fn touched_by<'q>(&'q self, body: &Body, filter: &QueryFilter) -> Vec<&'q Body> {
        let (Some(asker), mut found) = (Asker::of(body), Vec::new()) else { return Vec::new() };
        self.touching(&asker, filter, |other| {
            found.push(other);
            true
        });
        found
    }

    /// Hands the bodies that a shape overlaps or touches to `take`, its own left out, which tells whether to go on.
    fn touching<'q>(&'q self, asker: &Asker, filter: &QueryFilter, mut take: impl FnMut(&'q Body) -> bool) {
        let (index, bounds) = (self.index(), asker.bounds());
        // A triangle is touched whatever normal its mesh has there.
        let (mut search, mut points, mut parts) = (None, Vec::new(), Vec::new());
        let is_compound = asker.geometry.parts().is_some();
        let whole = LazyCell::new(|| if is_compound { None } else { asker.solid(0, &asker.position) });
        let mut touch_in = |other: &Body, parts: PartPair| {
            let part = if is_compound { asker.solid(parts.a, &asker.position) } else { None };
            if let (Some(one), Some(two)) =
                (whole.as_ref().or(part.as_ref()), solid_of(other, parts.b, &asker.position))
                && let Some(are_met) = meet(one, &two)
            {
                // A triangle has a front alone.
                return are_met && one.faces(&two.position) && two.faces(&one.position);
            }
            let search =
                search.get_or_insert_with(|| PairSearch { any_normal: true, is_sheet: true, ..PairSearch::default() });
            points.clear();
            search.last = None;
            let found = touch([asker.body(), other], parts, 0.0, search, &mut points);
            found.is_some_and(|overlap| overlap.depth >= 0.0)
        };
        let mut touches = |other: &Body| {
            if !is_compound && !has_parts(other) {
                return touch_in(other, PartPair::default());
            }
            parts_within(asker.body(), other, 0.0, &mut parts);
            parts.iter().any(|&parts| touch_in(other, parts))
        };
        let mut look = |other: u32| {
            let other = &self.bodies.list[other as usize];
            let is_met = other.entity != asker.entity && filter.admits(other) && touches(other);
            if is_met && !take(other) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        if let Some(bounds) = bounds {
            if index.unbounded.iter().try_for_each(|&plane| look(plane)).is_continue() {
                index.tree.overlapping(&bounds, look);
            }
        } else {
            // Of two half-spaces no depth tells.
            let _ = index.tree.items().try_for_each(look);
        }
    }

    /// All bodies of the last step.
    pub(super) fn bodies(&self) -> &[Body] {
        &self.bodies.list
    }

    #[inline]
    fn index(&self) -> IndexGuard<'_> {
        let version = (self.bodies.last_changed(), self.stats.steps, self.bodies.list.len());
        self.index.of(&self.bodies.list, version)
    }

    fn first_on(&self, index: &Index, ray: &Ray, filter: &QueryFilter) -> Option<RayHit> {
        first(|take| self.along(index, ray, filter, take))
    }

    /// Hands each body that a ray meets to `take`, which tells how far the ray matters from then on.
    fn along(&self, index: &Index, ray: &Ray, filter: &QueryFilter, take: &mut Take<RayHit>) {
        let Some(direction) = ray.direction.try_normalize().filter(|_| ray.origin.is_finite()) else { return };
        let (origin, unit) = (Vector3::from(ray.origin), Vector3::from(direction));
        let mut look = |index: u32, most: f64| {
            let body = &self.bodies.list[index as usize];
            let Some(geometry) = body.geometry.as_ref().filter(|_| filter.admits(body)) else { return most };
            let from = body.rotation.inverse_transform_vector(&(origin - body.position));
            let Some(entry) = enter(geometry, &from, &body.rotation.inverse_transform_vector(&unit)) else {
                return most;
            };
            if entry.distance <= most {
                let point = ray.origin + direction * entry.distance;
                let normal = (body.rotation * entry.normal).into();
                return take(RayHit { entity: body.entity, distance: entry.distance, point, normal }, most);
            }
            most
        };
        let most = index.unbounded.iter().fold(ray.length, |most, &plane| look(plane, most));
        let way = Way::new(&origin, &unit);
        index.tree.search(most, |bounds| way.enters(&bounds.low, &bounds.high), look);
    }

    /// Hands each body about a point to `take`, which tells how far matters from then on.
    fn around(&self, point: DVec3, most: f64, filter: &QueryFilter, take: &mut Take<PointHit>) {
        if !point.is_finite() {
            return;
        }
        let (index, at) = (self.index(), Vector3::from(point));
        let mut look = |index: u32, most: f64| {
            let body = &self.bodies.list[index as usize];
            let Some(geometry) = body.geometry.as_ref().filter(|_| filter.admits(body)) else { return most };
            let local = body.rotation.inverse_transform_vector(&(at - body.position));
            let (normal, height) = place_up_to(geometry, &local, body.radius, most);
            let distance = height.max(0.0);
            if distance <= most {
                let nearest = (at - body.rotation * (normal * distance)).into();
                return take(PointHit { entity: body.entity, distance, point: nearest }, most);
            }
            most
        };
        let most = index.unbounded.iter().fold(most, |most, &plane| look(plane, most));
        index.tree.search(most, |bounds| bounds.distance(&at), look);
    }

    /// Hands each body that a shape touches on its way to `take`, which tells how far matters from then on.
    fn on_the_way(
        &self,
        shape: &PlacedCollider,
        direction: DVec3,
        length: f64,
        filter: &QueryFilter,
        take: &mut Take<CastHit>,
    ) {
        let Some(mover) = Asker::new(shape).filter(|mover| mover.position.iter().all(|part| part.is_finite())) else {
            return;
        };
        let (Some(bounds), Some(direction)) = (mover.bounds(), direction.try_normalize()) else { return };
        let (index, unit) = (self.index(), Vector3::from(direction));
        let (start, mut caster) = (mover.position, Caster::new(&mover, unit));
        let mut look = |index: u32, most: f64| {
            let other = &self.bodies.list[index as usize];
            if !filter.admits(other) {
                return most;
            }
            match caster.cast(other, most) {
                Some(impact) => {
                    let (point, normal) = (impact.point.into(), impact.normal.into());
                    take(CastHit { entity: other.entity, distance: impact.distance, point, normal }, most)
                }
                None => most,
            }
        };
        let most = index.unbounded.iter().fold(length, |most, &plane| look(plane, most));
        // A box that moves meets another where its middle meets one that is larger by it.
        let way = Way::new(&start, &unit);
        let (low, high) = (bounds.low - start, bounds.high - start);
        index.tree.search(most, |other| way.enters(&(other.low - high), &(other.high - low)), look);
    }
}

/// Takes a hit, and how far matters, and tells how far matters from then on.
type Take<'t, H> = dyn FnMut(H, f64) -> f64 + 't;

/// The first of the hits that `look` hands on.
fn first<H: Hit>(look: impl FnOnce(&mut Take<H>)) -> Option<H> {
    let mut first: Option<H> = None;
    look(&mut |hit, _| {
        let nearer = first.filter(|known| order(known, &hit).is_lt()).unwrap_or(hit);
        first = Some(nearer);
        nearer.key().0
    });
    first
}

/// All hits that `look` hands on, the first first.
fn all<H: Hit>(look: impl FnOnce(&mut Take<H>)) -> Vec<H> {
    let mut hits = Vec::new();
    look(&mut |hit, most| {
        hits.push(hit);
        most
    });
    hits.sort_by(order);
    hits
}

fn order(one: &impl Hit, other: &impl Hit) -> Ordering {
    let [(distance, a), (farther, b)] = [one.key(), other.key()];
    distance.total_cmp(&farther).then(a.cmp(&b))
}
