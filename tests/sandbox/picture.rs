//! Pictures that the sandbox wrote, and what it draws them with.

use std::path::{Path, PathBuf};

use bevy::asset::RenderAssetUsages;
use bevy::image::{CompressedImageFormats, Image, ImageSampler, ImageType};
use bevy::math::{UVec2, Vec2};

/// Without it nothing is drawn.
pub const NO_DRIVER: &str = "no software Vulkan driver (lavapipe; Debian: mesa-vulkan-drivers)";

/// Says why a test is skipped; where none may be, it fails.
pub fn skip(reason: &str) {
    assert!(std::env::var_os("PLUMB_REQUIRE_WINDOW").is_none(), "{reason}");
    println!("skipped: {reason}");
}

/// Lavapipe's manifest.
pub fn software_driver() -> Option<PathBuf> {
    let folders = ["/usr/share/vulkan/icd.d", "/etc/vulkan/icd.d", "/usr/local/share/vulkan/icd.d"];
    let files = folders.iter().filter_map(|folder| std::fs::read_dir(folder).ok()).flatten().flatten();
    files.map(|file| file.path()).find(|path| path.to_string_lossy().contains("lvp_icd"))
}

/// A picture, sRGB.
pub struct Picture(Image);

impl Picture {
    /// None while it is not yet written whole.
    pub fn read(path: &Path) -> Option<Self> {
        let bytes = std::fs::read(path).ok()?;
        let formats = CompressedImageFormats::NONE;
        let usage = RenderAssetUsages::MAIN_WORLD;
        let image =
            Image::from_buffer(&bytes, ImageType::Extension("png"), formats, true, ImageSampler::Default, usage);
        image.ok().map(Self)
    }

    pub fn size(&self) -> UVec2 {
        self.0.size()
    }

    pub fn pixels(&self) -> impl Iterator<Item = (Vec2, [u8; 3])> {
        let width = self.0.width();
        let bytes = self.0.data.as_ref().expect("pixels").chunks_exact(4).enumerate();
        bytes.map(move |(i, pixel)| {
            let i = i as u32;
            (Vec2::new((i % width) as f32, (i / width) as f32), [pixel[0], pixel[1], pixel[2]])
        })
    }

    pub fn distinct_colors(&self) -> usize {
        self.pixels().map(|(_, color)| color).collect::<std::collections::HashSet<_>>().len()
    }

    /// Of the disc that has as many pixels as are red.
    pub fn red_radius(&self, right: f32) -> f32 {
        (self.red(right).count() as f32 / std::f32::consts::PI).sqrt()
    }

    /// The places of what is red, as far to the right as that.
    fn red(&self, right: f32) -> impl Iterator<Item = Vec2> {
        let red = self.pixels().filter(move |(place, [red, green, blue])| {
            place.x < right && *red > 90 && f32::from(*red) > 2.0 * f32::from((*green).max(*blue))
        });
        red.map(|(place, _)| place)
    }

    /// The middle of what is red.
    pub fn red_spot(&self, right: f32) -> Option<Vec2> {
        let (count, sum) = self.red(right).fold((0, Vec2::ZERO), |(count, sum), place| (count + 1, sum + place));
        (count > 200).then(|| sum / count as f32)
    }
}
