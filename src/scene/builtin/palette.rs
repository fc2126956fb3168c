//! Colours (sRGB) that go together and tell neighbours apart.

pub const RED: [f32; 3] = [0.86, 0.29, 0.25];
pub const ORANGE: [f32; 3] = [0.94, 0.58, 0.24];
pub const YELLOW: [f32; 3] = [0.96, 0.80, 0.38];
pub const GREEN: [f32; 3] = [0.42, 0.68, 0.42];
pub const TEAL: [f32; 3] = [0.22, 0.60, 0.62];
pub const BLUE: [f32; 3] = [0.27, 0.47, 0.73];
pub const PURPLE: [f32; 3] = [0.54, 0.40, 0.66];
pub const SKIN: [f32; 3] = [0.93, 0.76, 0.62];
pub const WOOD: [f32; 3] = [0.72, 0.53, 0.36];
pub const STEEL: [f32; 3] = [0.62, 0.66, 0.70];
pub const SLATE: [f32; 3] = [0.33, 0.38, 0.44];
pub const GROUND: [f32; 3] = [0.60, 0.63, 0.62];

/// The bright ones, to count through.
pub const BRIGHT: [[f32; 3]; 7] = [RED, ORANGE, YELLOW, GREEN, TEAL, BLUE, PURPLE];

/// The bright colour of number `i`, round and round.
pub fn bright(i: usize) -> [f32; 3] {
    BRIGHT[i % BRIGHT.len()]
}
