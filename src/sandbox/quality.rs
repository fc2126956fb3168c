//! How much the picture may cost: a software renderer gets a cheaper one.

use bevy::light::ShadowFilteringMethod;
use bevy::prelude::*;
use bevy::render::renderer::RenderAdapterInfo;

/// What the picture's parts are made with.
#[derive(Resource, Clone, Copy, Debug)]
pub(super) struct Quality {
    /// Side of a shadow map, pixels.
    pub shadow_map: usize,
    pub shadow_filter: ShadowFilteringMethod,
    /// Most samples along the ground toward the horizon.
    pub anisotropy: u16,
}

const FULL: Quality = Quality { shadow_map: 4096, shadow_filter: ShadowFilteringMethod::Gaussian, anisotropy: 16 };
/// A frame of the full picture takes a software renderer seconds.
const CHEAP: Quality = Quality { shadow_map: 1024, shadow_filter: ShadowFilteringMethod::Hardware2x2, anisotropy: 1 };

pub(super) fn plugin(app: &mut App) {
    app.insert_resource(FULL).add_systems(PreStartup, choose);
}

fn choose(adapter: Option<Res<RenderAdapterInfo>>, mut quality: ResMut<Quality>) {
    // Bevy does not pass on the enum's name.
    if adapter.is_some_and(|adapter| format!("{:?}", adapter.device_type) == "Cpu") {
        *quality = CHEAP;
    }
}
