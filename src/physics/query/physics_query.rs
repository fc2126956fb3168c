//! The system parameter.

use std::cmp::Ordering;
use std::sync::Arc;

use bevy::ecs::system::SystemParam;
use bevy::math::DVec3;
use bevy::prelude::*;
use nalgebra::Vector3;

use super::answers::{CastHit, PointHit, Ray, RayHit};
use super::cast::{Buffers, cast};
use super::filter::QueryFilter;
use super::index::{Index, QueryIndex, box_of};
use super::ray::enter;
use crate::physics::collision::{PlacedCollider, place, touch};
use crate::physics::{Bodies, Body, BoundingBox, PairSearch, SolverSettings, StepStats, for_each_of};

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
        let mut hits = Vec::new();
        self.along(&self.index(), ray, filter, |hit, most| {
            hits.push(hit);
            most
        });
        hits.sort_by(|one, other| order((one.distance, one.entity), (other.distance, other.entity)));
        hits
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
        let mut nearest: Option<PointHit> = None;
        self.around(point, most, filter, |hit, most| {
            let key = (hit.distance, hit.entity);
            if nearest.is_none_or(|known| order(key, (known.distance, known.entity)).is_lt()) {
                nearest = Some(hit);
            }
            nearest.map_or(most, |nearest| nearest.distance)
        });
        nearest
    }

    /// All bodies within `most`, m, of a point, the nearest first.
    pub fn nearest_points(&self, point: DVec3, most: f64, filter: &QueryFilter) -> Vec<PointHit> {
        let mut hits = Vec::new();
        self.around(point, most, filter, |hit, most| {
            hits.push(hit);
            most
        });
        hits.sort_by(|one, other| order((one.distance, one.entity), (other.distance, other.entity)));
        hits
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
        let mut first: Option<CastHit> = None;
        self.on_the_way(shape, direction, length, filter, |hit, most| {
            let key = (hit.distance, hit.entity);
            if first.is_none_or(|known| order(key, (known.distance, known.entity)).is_lt()) {
                first = Some(hit);
            }
            first.map_or(most, |first| first.distance)
        });
        first
    }

    /// All bodies that a shape touches on such a way, as if the others let it pass, the first first.
    pub fn shape_cast_all(
        &self,
        shape: &PlacedCollider,
        direction: DVec3,
        length: f64,
        filter: &QueryFilter,
    ) -> Vec<CastHit> {
        let mut hits = Vec::new();
        self.on_the_way(shape, direction, length, filter, |hit, most| {
            hits.push(hit);
            most
        });
        hits.sort_by(|one, other| order((one.distance, one.entity), (other.distance, other.entity)));
        hits
    }

    /// Whether a shape overlaps or touches a body; one of them.
    pub fn overlap(&self, shape: &PlacedCollider, filter: &QueryFilter) -> Option<Entity> {
        self.overlap_all(shape, filter).into_iter().next()
    }

    /// All bodies that a shape overlaps or touches, in the order of their entities.
    pub fn overlap_all(&self, shape: &PlacedCollider, filter: &QueryFilter) -> Vec<Entity> {
        let Some(body) = shape.body() else { return Vec::new() };
        let mut found: Vec<Entity> = self.touched_by(&body, filter).map(|other| other.entity).collect();
        found.sort_unstable();
        found
    }

    /// The bodies that one overlaps or touches, itself left out.
    pub(super) fn touched_by(&self, body: &Body, filter: &QueryFilter) -> impl Iterator<Item = &Body> {
        let index = self.index();
        let mut found = Vec::new();
        if let Some(bounds) = box_of(body) {
            let distance = |other: &BoundingBox| if bounds.overlaps(other) { 0.0 } else { f64::INFINITY };
            index.tree.search(0.0, distance, |other, most| {
                found.push(other);
                most
            });
            found.extend(&index.unbounded);
        } else if body.geometry.is_some() {
            index.tree.search(
                0.0,
                |_| 0.0,
                |other, most| {
                    found.push(other);
                    most
                },
            );
        }
        let (mut search, mut points) = (PairSearch::default(), Vec::new());
        found.retain(|&other| {
            let other = &self.bodies.list[other as usize];
            if other.entity == body.entity || !filter.admits(other) {
                return false;
            }
            points.clear();
            search.last = None;
            touch(body, other, 0.0, &mut search, &mut points).is_some_and(|overlap| overlap.depth >= 0.0)
        });
        found.into_iter().map(|other| &self.bodies.list[other as usize])
    }

    /// All bodies of the last step.
    pub(super) fn bodies(&self) -> &[Body] {
        &self.bodies.list
    }

    fn index(&self) -> Arc<Index> {
        let version = (self.bodies.last_changed(), self.stats.steps, self.bodies.list.len());
        self.index.of(&self.bodies.list, version)
    }

    fn first_on(&self, index: &Index, ray: &Ray, filter: &QueryFilter) -> Option<RayHit> {
        let mut first: Option<RayHit> = None;
        self.along(index, ray, filter, |hit, most| {
            let key = (hit.distance, hit.entity);
            if first.is_none_or(|known| order(key, (known.distance, known.entity)).is_lt()) {
                first = Some(hit);
            }
            first.map_or(most, |first| first.distance)
        });
        first
    }

    /// Hands each body that a ray meets to `take`, which tells how far the ray matters from then on.
    fn along(&self, index: &Index, ray: &Ray, filter: &QueryFilter, mut take: impl FnMut(RayHit, f64) -> f64) {
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
    fn around(&self, point: DVec3, most: f64, filter: &QueryFilter, mut take: impl FnMut(PointHit, f64) -> f64) {
        if !point.is_finite() {
            return;
        }
        let (index, at) = (self.index(), Vector3::from(point));
        let mut look = |index: u32, most: f64| {
            let body = &self.bodies.list[index as usize];
            let Some(geometry) = body.geometry.as_ref().filter(|_| filter.admits(body)) else { return most };
            let local = body.rotation.inverse_transform_vector(&(at - body.position));
            let (normal, height) = place(geometry, &local, body.radius);
            let distance = height.max(0.0);
            if distance <= most {
                let nearest = (at - body.rotation * (normal * distance)).into();
                return take(PointHit { entity: body.entity, distance, point: nearest }, most);
            }
            most
        };
        let most = index.unbounded.iter().fold(most, |most, &plane| look(plane, most));
        let distance = |bounds: &BoundingBox| (at - at.sup(&bounds.low).inf(&bounds.high)).norm();
        index.tree.search(most, distance, look);
    }

    /// Hands each body that a shape touches on its way to `take`, which tells how far matters from then on.
    fn on_the_way(
        &self,
        shape: &PlacedCollider,
        direction: DVec3,
        length: f64,
        filter: &QueryFilter,
        mut take: impl FnMut(CastHit, f64) -> f64,
    ) {
        let Some(mover) = shape.body().filter(|body| body.position.iter().all(|part| part.is_finite())) else { return };
        let (Some(bounds), Some(direction)) = (box_of(&mover), direction.try_normalize()) else { return };
        let (index, unit) = (self.index(), Vector3::from(direction));
        let mut buffers = Buffers::default();
        let mut look = |index: u32, most: f64| {
            let other = &self.bodies.list[index as usize];
            if !filter.admits(other) {
                return most;
            }
            match cast(&mover, other, &unit, most, &mut buffers) {
                Some(impact) => {
                    let (point, normal) = (impact.point.into(), impact.normal.into());
                    take(CastHit { entity: other.entity, distance: impact.distance, point, normal }, most)
                }
                None => most,
            }
        };
        let most = index.unbounded.iter().fold(length, |most, &plane| look(plane, most));
        // A box that moves meets another where its middle meets one that is larger by it.
        let way = Way::new(&mover.position, &unit);
        let (low, high) = (bounds.low - mover.position, bounds.high - mover.position);
        index.tree.search(most, |other| way.enters(&(other.low - high), &(other.high - low)), look);
    }
}

fn order((one, a): (f64, Entity), (other, b): (f64, Entity)) -> Ordering {
    one.total_cmp(&other).then(a.cmp(&b))
}

/// A ray as boxes are tested against it.
struct Way {
    origin: Vector3<f64>,
    /// One over each part of the direction.
    inverse: Vector3<f64>,
}

impl Way {
    fn new(origin: &Vector3<f64>, direction: &Vector3<f64>) -> Self {
        // Finite, so that nothing times it is a number.
        let inverse = direction.map(|part| if part.abs() < 1e-300 { 1e300_f64.copysign(part) } else { part.recip() });
        Self { origin: *origin, inverse }
    }

    /// How far along the ray a box begins, 0 inside, infinite where it is missed (Kay and Kajiya 1986).
    fn enters(&self, low: &Vector3<f64>, high: &Vector3<f64>) -> f64 {
        let one = (low - self.origin).component_mul(&self.inverse);
        let other = (high - self.origin).component_mul(&self.inverse);
        let (first, last) = (one.inf(&other).max().max(0.0), one.sup(&other).min());
        if first <= last { first } else { f64::INFINITY }
    }
}
