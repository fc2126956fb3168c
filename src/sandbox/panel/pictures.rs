//! Pictures of the built-in scenes, 192 × 120 pixels each.
//!
//! They are made by the program itself: `assets/gallery/make.py PLUMB [NAME ...]` films the moment that its table names, scales it
//! down and leaves it few colors. A new scene is added to the list below, and to that table where its start is not its best.

use std::collections::HashMap;

use bevy::asset::RenderAssetUsages;
use bevy::image::{CompressedImageFormats, ImageSampler, ImageType};
use bevy::prelude::*;
use bevy_egui::egui;

/// `NAME.png` of each.
macro_rules! pictures {
    ($($name:literal)*) => { &[$(($name, include_bytes!(concat!("../../../assets/gallery/", $name, ".png")))),*] };
}

/// In the order of the scenes.
#[rustfmt::skip]
const PICTURES: &[(&str, &[u8])] = pictures![
    "limbs" "pendulum" "rods" "chain" "hanging" "joint_grid" "top" "heavy_top" "incline" "slide_roll" "rolling" "painleve"
    "bounce" "spheres" "cradle" "wall" "stack" "pyramid" "pyramids" "sandwich" "slab" "column" "boulder" "wrecking_ball" "arch"
    "card_house" "dominoes" "pile" "heap" "terrain" "rain" "washer" "trees" "junkyard" "convex_pile" "large_world" "far" "four_bar" "bricard" "andrews" "arm" "servo" "stop" "hinge_chain" "bridge"
    "tower" "car" "ragdolls" "empty"
];

/// Height over width.
pub(super) const ASPECT: f32 = 120.0 / 192.0;

/// Those that were looked at so far, as egui has them.
#[derive(Default)]
pub(super) struct Pictures(HashMap<&'static str, Option<egui::TextureHandle>>);

impl Pictures {
    /// The picture of a scene, if there is one: it is decoded when it is first seen.
    pub fn of(&mut self, name: &'static str, context: &egui::Context) -> Option<egui::TextureId> {
        let load = || Some(context.load_texture(name, decode(name)?, egui::TextureOptions::LINEAR));
        self.0.entry(name).or_insert_with(load).as_ref().map(egui::TextureHandle::id)
    }
}

fn decode(name: &str) -> Option<egui::ColorImage> {
    let (_, bytes) = PICTURES.iter().find(|(own, _)| *own == name)?;
    let png = ImageType::Extension("png");
    let usages = RenderAssetUsages::MAIN_WORLD;
    let image =
        Image::from_buffer(bytes, png, CompressedImageFormats::NONE, true, ImageSampler::Default, usages).ok()?;
    let pixels = image.try_into_dynamic().ok()?.to_rgba8();
    let size = [pixels.width() as usize, pixels.height() as usize];
    Some(egui::ColorImage::from_rgba_unmultiplied(size, &pixels))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::catalog;

    #[test]
    fn every_scene_has_a_picture_and_they_are_small() {
        for scene in catalog() {
            let picture = decode(scene.name).unwrap_or_else(|| panic!("no picture of {}", scene.name));
            assert_eq!(picture.size, [192, 120], "{}", scene.name);
            let first = picture.pixels[0];
            assert!(picture.pixels.iter().any(|pixel| *pixel != first), "{} is blank", scene.name);
        }
        assert_eq!(PICTURES.len(), catalog().len(), "a picture of no scene");
        for (name, bytes) in PICTURES {
            assert!(bytes.len() <= 10_000, "{name}: {} bytes", bytes.len());
        }
    }
}
