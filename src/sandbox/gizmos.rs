//! Contacts, joints, bounds and velocities, drawn over the picture.
//!
//! All are drawn where the bodies are drawn: interpolated, relative to
//! [`RenderOrigin`](crate::physics::RenderOrigin). What the solver must report for them is asked
//! for only while it is shown.

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_egui::egui;

use super::Selection;
use super::any_joint::{IsJoint, WholeJoint, WholeJointItem};
use super::glyphs::Placed;
use super::in_front::in_front;
use super::panel::{Quantity, palette, toggle};
use super::probe::reads_contact_forces;
use super::why::Painted;
use crate::physics::{Collider, ContactForces, Gravity, Mass, RenderOrigin, RigidBody, StepStats, Velocity};
use crate::scene::{JointComponent, Probes, SceneEntity};

/// What is drawn over the picture.
#[derive(Resource, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[reflect(Resource, Debug, Default, PartialEq)]
pub struct ShownGizmos {
    /// Contact points with normals and forces.
    pub contacts: bool,
    /// Joints, colored by what they carry.
    pub joints: bool,
    /// Bounding spheres.
    pub bounds: bool,
    /// Linear and angular velocities.
    pub velocities: bool,
}

/// Lines in front of all bodies.
#[derive(Default, Reflect, GizmoConfigGroup)]
struct Overlay;

/// What joints are drawn as, in front of other lines.
#[derive(Default, Reflect, GizmoConfigGroup)]
struct Glyphs;

/// The dark rim of a glyph, behind it: a red line is seen on a red body too.
#[derive(Default, Reflect, GizmoConfigGroup)]
struct Rims;

pub(super) fn plugin(app: &mut App) {
    in_front::<Overlay>(app, 0.98, 1.8);
    in_front::<Rims>(app, 0.99, 5.0);
    in_front::<Glyphs>(app, 1.0, 2.6);
    app.init_resource::<ShownGizmos>().add_systems(PreUpdate, switch_contact_forces).add_systems(
        PostUpdate,
        (
            draw_contacts.run_if(|shown: Res<ShownGizmos>| shown.contacts),
            draw_joints.run_if(|shown: Res<ShownGizmos>, painted: Res<Painted>, selection: Res<Selection>| {
                shown.joints || painted.has_joints() || selection.joint.is_some()
            }),
            draw_bounds.run_if(|shown: Res<ShownGizmos>| shown.bounds),
            draw_velocities.run_if(|shown: Res<ShownGizmos>| shown.velocities),
        ),
    );
}

fn switch_contact_forces(
    mut commands: Commands,
    shown: Res<ShownGizmos>,
    probes: Res<Probes>,
    forces: Option<Res<ContactForces>>,
) {
    match (shown.contacts || reads_contact_forces(&probes), forces.is_some()) {
        (true, false) => commands.init_resource::<ContactForces>(),
        (false, true) => commands.remove_resource::<ContactForces>(),
        _ => {}
    }
}

/// The section of the panel.
pub(super) fn show(
    InMut(ui): InMut<egui::Ui>,
    gravity: Res<Gravity>,
    bodies: Query<(&RigidBody, &Collider, &Mass)>,
    mut shown: ResMut<ShownGizmos>,
) {
    let mut edited = *shown;
    let toggles = [
        (
            &mut edited.contacts,
            "contacts",
            "each contact point with its normal (blue) and the force (red) on the upper body, on the second where neither \
             is above: the impulse of the step over its length",
        ),
        (
            &mut edited.joints,
            "joints",
            "each joint with lines to the centers of mass that it moves; color by what it carries: green nothing, red as \
             much as it bears, or ten times an average body's weight where it bears anything, white until a step has told; \
             arcs and ticks are limits, yellow arrows motors, gray joints broken",
        ),
        (
            &mut edited.velocities,
            "velocities",
            "linear (yellow), the way of a quarter second; angular (purple), along \
             the axis, a radius per half turn a second",
        ),
        (&mut edited.bounds, "bounding spheres", "what the broad phase sees"),
    ];
    ui.horizontal_wrapped(|ui| {
        for (shown, label, about) in toggles {
            if ui.add(toggle(ui, *shown, label)).on_hover_text(about).clicked() {
                *shown = !*shown;
            }
        }
    });
    shown.set_if_neq(edited);
    if shown.contacts {
        let Measure { size, weight } = Measure::of(&bodies, &gravity);
        let (length, force) = (Quantity::text(f64::from(size), "m"), Quantity::text(weight, "N"));
        ui.weak(format!("a red arrow of {length} is {force}")).on_hover_text("as much as a body weighs in the mean");
    }
}

/// What lengths and forces are measured against, so that arrows fit the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Measure {
    /// Mean bounding radius of the moving bodies, m.
    size: f32,
    /// Mean weight of the moving bodies, N; without gravity what they would weigh on Earth.
    weight: f64,
}

impl Measure {
    fn of(bodies: &Query<(&RigidBody, &Collider, &Mass)>, gravity: &Gravity) -> Self {
        let mut count = 0.0;
        let (mut radii, mut masses) = (0.0, 0.0);
        for (kind, collider, mass) in bodies {
            if *kind == RigidBody::Dynamic {
                count += 1.0;
                radii += collider.bounding_radius();
                masses += mass.0;
            }
        }
        if count == 0.0 {
            return Self { size: 0.5, weight: 9.81 };
        }
        let g = if gravity.length() > 0.0 { gravity.length() } else { 9.81 };
        Self { size: (radii / count) as f32, weight: masses / count * g }
    }

    /// The arrow of a force: as long as a body's radius where it equals a body's weight, and never
    /// more than twenty of them.
    fn arrow(&self, force: DVec3) -> Vec3 {
        (force / self.weight).clamp_length_max(20.0).as_vec3() * self.size
    }

    /// How loaded something is, 0 to 1: 1 at ten times an average weight, where the square root
    /// leaves small loads visible.
    fn load(&self, force: f64) -> f32 {
        (force / (10.0 * self.weight)).sqrt().clamp(0.0, 1.0) as f32
    }

    /// How loaded a joint is, 0 to 1: 1 where it breaks, or, of one that bears anything, as [`Self::load`] has it, its
    /// torque over a length. None: no step has told yet.
    fn share(&self, joint: &WholeJointItem, stats: &StepStats, length: f64) -> Option<f32> {
        let load = joint.known_load(stats)?;
        let (force, torque) = (load.force.length(), load.torque.length());
        Some(match joint.breakable {
            Some(strength) => (force / strength.force).max(torque / strength.torque).min(1.0) as f32,
            None => self.load(force.max(torque / length)),
        })
    }

    /// Of the glyph of a joint between bodies of those shapes: no larger than the smaller one.
    fn glyph_size(&self, ends: [Option<&Collider>; 2]) -> f32 {
        let radii = ends.into_iter().flatten().map(|collider| collider.bounding_radius() as f32);
        radii.filter(|radius| *radius > 0.0).fold(self.size, f32::min)
    }
}

/// Shorter than this, an arrow has no direction to draw, m.
const SHORTEST: f32 = 1e-4;

fn arrow(gizmos: &mut Gizmos<Overlay>, from: Vec3, along: Vec3, color: Color, tip: f32) {
    if along.is_finite() && along.length() > SHORTEST {
        gizmos.arrow(from, from + along, color).with_tip_length(tip.min(along.length() * 0.4));
    }
}

fn color([r, g, b]: [u8; 3]) -> Color {
    Color::srgb_u8(r, g, b)
}

fn draw_contacts(
    mut gizmos: Gizmos<Overlay>,
    forces: Option<Res<ContactForces>>,
    origin: Res<RenderOrigin>,
    gravity: Res<Gravity>,
    bodies: Query<(&RigidBody, &Collider, &Mass)>,
) {
    let Some(forces) = forces else { return };
    let measure = Measure::of(&bodies, &gravity);
    let up = (-gravity.0).normalize_or(DVec3::Y);
    for contact in &forces.0 {
        let point = (contact.point - origin.0).as_vec3();
        let kept = if upholds_b(contact.normal, up) { 1.0 } else { -1.0 };
        let normal = (kept * contact.normal).as_vec3();
        let facing = Isometry3d::new(point, Quat::from_rotation_arc(Vec3::Z, normal));
        gizmos.circle(facing, 0.06 * measure.size, color(palette::SKY)).resolution(10);
        gizmos.line(point, point + normal * 0.3 * measure.size, color(palette::SKY));
        arrow(&mut gizmos, point, measure.arrow(kept * contact.force), color(palette::VERMILION), 0.12 * measure.size);
    }
}

/// Whether of a contact that normal, from A to B, is drawn with the force on B; else both are turned round. So that all
/// arrows of a pile point one way, whichever of two bodies is A: at the one that is carried.
fn upholds_b(normal: DVec3, up: DVec3) -> bool {
    normal.dot(up) > -LEVEL
}

/// Sine of the angle to the horizontal from which on one of two bodies carries the other.
const LEVEL: f64 = 1e-3;

fn draw_joints(
    (mut gizmos, mut rims, mut glyphs): (Gizmos<Overlay>, Gizmos<Rims>, Gizmos<Glyphs>),
    joints: Query<(Entity, WholeJoint), IsJoint>,
    (painted, shown, selection): (Res<Painted>, Res<ShownGizmos>, Res<Selection>),
    poses: Query<(&RigidBody, &Transform, Option<&Collider>)>,
    gravity: Res<Gravity>,
    stats: Res<StepStats>,
    bodies: Query<(&RigidBody, &Collider, &Mass)>,
) {
    let measure = Measure::of(&bodies, &gravity);
    let down = gravity.0.normalize_or(DVec3::NEG_Y).as_vec3();
    let are_all_drawn = shown.joints || painted.has_joints();
    for (entity, joint) in &joints {
        if !are_all_drawn && selection.joint != Some(entity) {
            continue;
        }
        let Some(component) = joint.joint.component() else { continue };
        let Ok(ends) = poses.get_many(component.bodies()) else { continue };
        let size = measure.glyph_size(ends.map(|(.., collider)| collider));
        let load = measure.share(&joint, &stats, f64::from(size));
        let tint = match joint.broken {
            Some(_) => color(BROKEN),
            // The picture's legend tells of all joints.
            None if painted.has_joints() => color(painted.joint(entity).unwrap_or(UNKNOWN)),
            None => load.map_or(color(UNKNOWN), shade),
        };
        let placed = Placed { joint: &joint, poses: ends.map(|end| *end.1), size, tint, down, time: stats.time };
        let Some([at_a, at_b]) = placed.anchors() else { continue };
        for (points, color) in placed.strokes() {
            if points.iter().all(|point| point.is_finite()) {
                rims.linestrip(points.iter().copied(), RIM);
                glyphs.linestrip(points, color);
            }
        }
        let held_at_a_point = !matches!(component, JointComponent::Slider(_) | JointComponent::Distance(_));
        if matches!(component, JointComponent::Ball(_) | JointComponent::Generic(_)) {
            gizmos.sphere(at_b, size * (0.08 + 0.16 * load.unwrap_or_default()), tint).resolution(12);
        }
        if held_at_a_point && joint.broken.is_none() {
            gizmos.line(at_a, at_b, color(palette::PURPLE)); // as long as the joint is torn apart
        }
        for ((kind, pose, _), at) in ends.into_iter().zip([at_a, at_b]) {
            if *kind == RigidBody::Dynamic {
                gizmos.line(pose.translation, at, tint);
            }
        }
    }
}

/// The lines that each joint is drawn as, its points first; of bodies alone whose joints are drawn as dots, those.
pub(super) fn strokes_of_joints(
    In(bodies): In<Vec<Entity>>,
    joints: Query<(Entity, WholeJoint), (IsJoint, With<SceneEntity>)>,
    (shown, selection): (Res<ShownGizmos>, Res<Selection>),
    poses: Query<(&Transform, Option<&Collider>)>,
    gravity: Res<Gravity>,
    stats: Res<StepStats>,
    all: Query<(&RigidBody, &Collider, &Mass)>,
) -> Vec<(Entity, Vec<Vec<Vec3>>)> {
    let measure = Measure::of(&all, &gravity);
    let down = gravity.0.normalize_or(DVec3::NEG_Y).as_vec3();
    let mut seen = Vec::new();
    for (entity, joint) in &joints {
        let Some(component) = joint.joint.component() else { continue };
        let has_glyph = shown.joints || selection.joint == Some(entity);
        if !has_glyph && !component.bodies().iter().any(|end| bodies.contains(end)) {
            continue;
        }
        let Ok(ends) = poses.get_many(component.bodies()) else { continue };
        let size = measure.glyph_size(ends.map(|(_, collider)| collider));
        let (poses, tint, time) = (ends.map(|(pose, _)| *pose), Color::WHITE, stats.time);
        let placed = Placed { joint: &joint, poses, size, tint, down, time };
        let Some(points) = placed.anchors() else { continue };
        let mut strokes: Vec<Vec<Vec3>> = points.into_iter().map(|point| vec![point]).collect();
        if has_glyph {
            strokes.extend(placed.strokes().into_iter().map(|(points, _)| points));
        }
        seen.push((entity, strokes));
    }
    seen
}

/// Of a joint that holds no longer, and of one whose load no step has told yet.
const BROKEN: [u8; 3] = [130; 3];
const UNKNOWN: [u8; 3] = [235; 3];

/// Of the rim of a glyph.
const RIM: Color = Color::srgba(0.05, 0.06, 0.08, 0.75);

/// From green, nothing, to red, all that it bears.
fn shade(load: f32) -> Color {
    let (idle, loaded) = (color(palette::GREEN).to_linear(), color(palette::VERMILION).to_linear());
    Color::from(idle.mix(&loaded, load))
}

fn draw_bounds(mut gizmos: Gizmos<Overlay>, bodies: Query<(&Collider, &Transform), With<RigidBody>>) {
    for (collider, pose) in &bodies {
        let radius = collider.bounding_radius();
        if radius.is_finite() {
            gizmos.sphere(pose.to_isometry(), radius as f32, color(palette::SKY).with_alpha(0.35)).resolution(24);
        }
    }
}

fn draw_velocities(mut gizmos: Gizmos<Overlay>, bodies: Query<(&RigidBody, &Collider, &Velocity, &Transform)>) {
    for (kind, collider, velocity, pose) in &bodies {
        if *kind == RigidBody::Static {
            continue;
        }
        let radius = collider.bounding_radius() as f32;
        let linear = velocity.linear.as_vec3() * 0.25;
        arrow(&mut gizmos, pose.translation, linear, color(palette::YELLOW), 0.25 * radius);
        let angular = velocity.angular.as_vec3() * radius / std::f32::consts::PI;
        arrow(&mut gizmos, pose.translation, angular, color(palette::PURPLE), 0.25 * radius);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn switches() -> App {
        let mut app = App::new();
        app.init_resource::<ShownGizmos>().init_resource::<Probes>().add_systems(PreUpdate, switch_contact_forces);
        app
    }

    #[test]
    fn contact_forces_exist_only_while_shown() {
        let mut app = switches();
        for shown in [false, true, false] {
            app.world_mut().resource_mut::<ShownGizmos>().contacts = shown;
            app.update();
            assert_eq!(app.world().contains_resource::<ContactForces>(), shown);
        }
    }

    #[test]
    fn the_arrow_of_a_contact_is_at_the_body_that_is_carried() {
        let tilted = DVec3::new(0.3, 0.9, 0.0);
        assert!(upholds_b(tilted, DVec3::Y) && !upholds_b(-tilted, DVec3::Y));
        // Level ones keep their own way, but for rounding.
        assert!(upholds_b(DVec3::X, DVec3::Y) && upholds_b(-DVec3::X, DVec3::Y));
        assert!(upholds_b(DVec3::new(1.0, -1e-9, 0.0), DVec3::Y));
    }

    #[test]
    fn arrows_grow_with_the_force_and_stay_in_the_picture() {
        let measure = Measure { size: 0.5, weight: 100.0 };
        assert!(measure.arrow(DVec3::Y * 100.0).abs_diff_eq(Vec3::Y * 0.5, 1e-6));
        assert!(measure.arrow(DVec3::Y * 1e9).abs_diff_eq(Vec3::Y * 10.0, 1e-5));
        assert_eq!(measure.arrow(DVec3::ZERO), Vec3::ZERO);
        assert_eq!(measure.load(0.0), 0.0);
        assert_eq!(measure.load(1e12), 1.0);
    }
}
