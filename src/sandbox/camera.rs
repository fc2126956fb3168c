//! The orbit camera: where it starts, when it listens, and the origin of what it draws.

use bevy::app::{RunFixedMainLoop, RunFixedMainLoopSystems};
use bevy::camera::SubCameraView;
use bevy::math::DVec3;
use bevy::prelude::*;
use bevy::window::PrimaryWindow;
use bevy_egui::input::EguiWantsInput;
use bevy_egui::{EguiContextSettings, EguiPostUpdateSet, PrimaryEguiContext};
use bevy_panorbit_camera::{PanOrbitCamera, PanOrbitCameraSystemSet};

use super::held::Drag;
use super::light;
use super::quality::Quality;
use super::state::Covered;
use crate::physics::RenderOrigin;
use crate::scene::{SceneSpec, ShapeSpec, ViewSpec};

/// Distance of the camera's focus from Bevy's origin, m, beyond which the origin moves to it:
/// `f32` is exact to 0.06 mm there.
const REBASE_DISTANCE: f32 = 1000.0;

pub(super) fn plugin(app: &mut App) {
    app.add_systems(Startup, spawn_camera)
        .add_systems(RunFixedMainLoop, keep_origin_near.in_set(RunFixedMainLoopSystems::BeforeFixedMainLoop))
        .add_systems(Update, center_beside_panel)
        .add_systems(PostUpdate, listen.after(EguiPostUpdateSet::ProcessOutput).before(PanOrbitCameraSystemSet));
}

/// What sees: light and ground go by where it stands.
pub(super) fn eye(quality: &Quality) -> impl Bundle {
    (
        Camera3d::default(),
        Transform::from_xyz(0.0, 4.0, 12.0).looking_at(Vec3::Y, Vec3::Y),
        PanOrbitCamera {
            button_orbit: MouseButton::Right,
            button_pan: MouseButton::Middle,
            touch_enabled: false,
            use_real_time: true,
            zoom_lower_limit: 0.3,
            zoom_upper_limit: Some(1000.0),
            ..default()
        },
        quality.shadow_filter,
        light::air(),
    )
}

fn spawn_camera(mut commands: Commands, quality: Res<Quality>) {
    commands.spawn((
        eye(&quality),
        PrimaryEguiContext,
        // What the pointer is on is asked of egui at each press, at the very place of the press:
        // its hits for picking are a frame old.
        EguiContextSettings { capture_pointer_input: false, ..default() },
    ));
}

/// Where to look at a scene from, world, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Framing {
    pub eye: DVec3,
    pub target: DVec3,
}

impl Framing {
    /// As the scene says, or so that all its bodies are in the picture.
    pub fn of(spec: &SceneSpec) -> Self {
        if let Some(view) = spec.view {
            return Self { eye: view.eye, target: view.target };
        }
        let (low, high) = bounds(spec);
        let radius = (0.5 * (high - low).length()).max(0.5);
        let target = 0.5 * (low + high);
        Self { eye: target + DVec3::new(0.35, 0.3, 1.0).normalize() * (2.8 * radius), target }
    }
}

/// The box around all bodies but the ground.
pub(super) fn bounds(spec: &SceneSpec) -> (DVec3, DVec3) {
    let spheres = spec.bodies.iter().filter_map(|body| {
        let radius = match &body.shape {
            Some(ShapeSpec::HalfSpace | ShapeSpec::Surface(_)) => return None,
            Some(shape) => shape.bounding_radius(),
            None => 0.0,
        };
        Some((body.position - radius, body.position + radius))
    });
    spheres.reduce(|(low, high), (a, b)| (low.min(a), high.max(b))).unwrap_or((DVec3::splat(-2.0), DVec3::splat(2.0)))
}

/// Where the camera is and what it orbits, if there is one.
pub(super) fn view(world: &mut World) -> Option<ViewSpec> {
    let origin = world.resource::<RenderOrigin>().0;
    let (camera, pose) = world.query::<(&PanOrbitCamera, &Transform)>().single(world).ok()?;
    let view = ViewSpec { eye: origin + pose.translation.as_dvec3(), target: origin + camera.focus.as_dvec3() };
    (view.eye != view.target).then_some(view)
}

/// Puts the camera there at once.
pub(super) fn look(world: &mut World, framing: Framing) {
    let origin =
        if framing.target.length() > f64::from(REBASE_DISTANCE) { framing.target.round() } else { DVec3::ZERO };
    world.resource_mut::<RenderOrigin>().0 = origin;
    let focus = (framing.target - origin).as_vec3();
    let offset = (framing.eye - framing.target).as_vec3();
    let radius = offset.length().max(0.3);
    let (yaw, pitch) = (offset.x.atan2(offset.z), (offset.y / radius).clamp(-1.0, 1.0).asin());
    for (mut camera, mut transform) in world.query::<(&mut PanOrbitCamera, &mut Transform)>().iter_mut(world) {
        *transform = Transform::from_translation(focus + offset).looking_at(focus, Vec3::Y);
        camera.target_focus = focus;
        camera.target_radius = radius;
        camera.target_yaw = yaw;
        camera.target_pitch = pitch;
        camera.focus = focus;
        camera.radius = Some(radius);
        camera.yaw = Some(yaw);
        camera.pitch = Some(pitch);
        camera.initialized = true;
        camera.force_update = true;
    }
}

/// Puts the middle of the view in the middle of what panel and plots leave free: the view proper is that part, and the
/// picture goes on beside it.
fn center_beside_panel(covered: Res<Covered>, mut camera: Single<&mut Camera, With<Camera3d>>) {
    let Some(size) = camera.physical_target_size() else { return };
    let scale = camera.target_scaling_factor().unwrap_or(1.0);
    let covered = (Vec2::new(covered.right, covered.bottom) * scale).as_uvec2();
    let free = size.saturating_sub(covered);
    let view = (free != size && free.cmpgt(size / 4).all()).then_some(SubCameraView {
        full_size: free,
        offset: Vec2::ZERO,
        size,
    });
    if camera.sub_camera_view != view {
        camera.sub_camera_view = view;
    }
}

/// The camera rests while a body is dragged and while the pointer is egui's. A motion that began
/// beside the panel goes on across it.
fn listen(drag: Res<Drag>, egui: Res<EguiWantsInput>, mut cameras: Query<&mut PanOrbitCamera>) {
    let listens = !drag.is_active() && !egui.wants_pointer_input() && !egui.is_popup_open();
    for mut camera in &mut cameras {
        if camera.enabled != listens {
            camera.enabled = listens;
        }
        if drag.is_active() {
            stop(&mut camera);
        }
    }
}

/// Ends any motion that is still being smoothed.
fn stop(camera: &mut PanOrbitCamera) {
    camera.target_focus = camera.focus;
    camera.target_radius = camera.radius.unwrap_or(camera.target_radius);
    camera.target_yaw = camera.yaw.unwrap_or(camera.target_yaw);
    camera.target_pitch = camera.pitch.unwrap_or(camera.target_pitch);
}

/// Moves [`RenderOrigin`] to the focus once that is far from it. Bodies follow when their
/// transforms are written, after the fixed loop.
pub(super) fn keep_origin_near(
    mut origin: ResMut<RenderOrigin>,
    camera: Single<(&mut PanOrbitCamera, &mut Transform, &mut GlobalTransform)>,
) {
    let (mut camera, mut transform, mut global) = camera.into_inner();
    if camera.target_focus.length() <= REBASE_DISTANCE {
        return;
    }
    let shift = camera.target_focus.round();
    origin.0 += shift.as_dvec3();
    camera.target_focus -= shift;
    camera.focus -= shift;
    transform.translation -= shift;
    *global = GlobalTransform::from(*transform);
}

/// A ray from the camera, world, m.
#[derive(Clone, Copy, Debug)]
pub(super) struct Aim {
    pub origin: DVec3,
    /// Unit.
    pub direction: DVec3,
    /// From the camera to what it orbits.
    pub distance: f64,
    /// Whether it goes through the pointer.
    pub by_pointer: bool,
}

/// Where in the window a point of the world is seen, logical pixels.
pub(super) fn seen_at(
    In(point): In<DVec3>,
    camera: Single<(&Camera, &GlobalTransform), With<Camera3d>>,
    origin: Res<RenderOrigin>,
) -> Option<Vec2> {
    let (camera, transform) = *camera;
    camera.world_to_viewport(transform, (point - origin.0).as_vec3()).ok()
}

/// Through the pointer, or through the middle of what the panel leaves free of the picture where
/// the pointer is on the panel.
pub(super) fn aim(
    camera: Single<(&Camera, &GlobalTransform, &PanOrbitCamera)>,
    window: Single<&Window, With<PrimaryWindow>>,
    egui: Res<EguiWantsInput>,
    covered: Res<Covered>,
    origin: Res<RenderOrigin>,
) -> Option<Aim> {
    let (camera, transform, orbit) = *camera;
    let pointer = window.cursor_position().filter(|_| !egui.is_pointer_over_area());
    let middle = || Some((camera.logical_viewport_size()? - Vec2::new(covered.right, covered.bottom)) / 2.0);
    let ray = camera.viewport_to_world(transform, pointer.or_else(middle)?).ok()?;
    Some(Aim {
        origin: origin.0 + transform.translation().as_dvec3(), // the ray starts on the near plane
        direction: ray.direction.as_dvec3().normalize(),
        distance: f64::from(orbit.target_radius),
        by_pointer: pointer.is_some(),
    })
}
