//! How much the picture may cost: a software renderer gets a cheaper one.

use bevy::light::ShadowFilteringMethod;
use bevy::prelude::*;
use bevy::render::batching::gpu_preprocessing::GpuPreprocessingSupport;
use bevy::render::renderer::{RenderAdapter, RenderAdapterInfo, RenderDevice};

/// What the picture's parts are made with.
#[derive(Resource, Clone, Copy, Debug)]
pub(super) struct Quality {
    /// Side of a shadow map, pixels.
    pub shadow_map: usize,
    pub shadow_filter: ShadowFilteringMethod,
    /// Most samples along the ground toward the horizon.
    pub anisotropy: u16,
    /// Whether what draws finds out by itself which bodies are in the picture: sorting ten thousand of them for the camera and
    /// for each part of the shadows takes the CPU milliseconds a frame.
    pub draws_what_it_sees: bool,
}

const FULL: Quality = Quality {
    shadow_map: 4096,
    shadow_filter: ShadowFilteringMethod::Gaussian,
    anisotropy: 16,
    draws_what_it_sees: true,
};
/// A frame of the full picture takes a software renderer seconds.
const CHEAP: Quality =
    Quality { shadow_map: 1024, shadow_filter: ShadowFilteringMethod::Hardware2x2, anisotropy: 1, ..FULL };

pub(super) fn plugin(app: &mut App) {
    app.insert_resource(FULL).add_systems(PreStartup, choose);
}

fn choose(world: &mut World) {
    let mut quality = FULL;
    // Bevy does not pass on the enum's name.
    if world.get_resource::<RenderAdapterInfo>().is_some_and(|adapter| format!("{:?}", adapter.device_type) == "Cpu") {
        quality = CHEAP;
    }
    let is_drawn = world.contains_resource::<RenderDevice>() && world.contains_resource::<RenderAdapter>();
    quality.draws_what_it_sees = !is_drawn || GpuPreprocessingSupport::from_world(world).is_available();
    world.insert_resource(quality);
}
