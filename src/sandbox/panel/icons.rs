//! Pictures on buttons, drawn of lines: they look alike, whatever fonts there are.

use bevy_egui::egui;

/// A line of a picture, in shares of its square from the top left.
pub enum Stroke {
    /// From point to point.
    Way(&'static [[f32; 2]]),
    /// A circle about a point, and its radius.
    Ring([f32; 2], f32),
    /// A disc about a point, and its radius.
    Dot([f32; 2], f32),
}

use Stroke::{Dot, Ring, Way};

/// A picture.
pub type Icon = &'static [Stroke];

pub const DRAG: Icon = &[Way(&[
    [0.3, 0.14],
    [0.3, 0.78],
    [0.45, 0.63],
    [0.55, 0.87],
    [0.66, 0.82],
    [0.56, 0.59],
    [0.76, 0.57],
    [0.3, 0.14],
])];
pub const MOVE: Icon = &[
    Way(&[[0.5, 0.08], [0.5, 0.92]]),
    Way(&[[0.08, 0.5], [0.92, 0.5]]),
    Way(&[[0.4, 0.2], [0.5, 0.08], [0.6, 0.2]]),
    Way(&[[0.4, 0.8], [0.5, 0.92], [0.6, 0.8]]),
    Way(&[[0.2, 0.4], [0.08, 0.5], [0.2, 0.6]]),
    Way(&[[0.8, 0.4], [0.92, 0.5], [0.8, 0.6]]),
];
pub const TURN: Icon = &[
    Way(&[
        [0.84, 0.5],
        [0.79, 0.68],
        [0.67, 0.79],
        [0.5, 0.84],
        [0.33, 0.79],
        [0.21, 0.67],
        [0.16, 0.5],
        [0.21, 0.33],
        [0.33, 0.21],
        [0.5, 0.16],
        [0.67, 0.21],
        [0.76, 0.29],
    ]),
    Way(&[[0.58, 0.3], [0.77, 0.3], [0.77, 0.11]]),
];
pub const SCALE: Icon = &[
    Way(&[[0.12, 0.56], [0.44, 0.56], [0.44, 0.88], [0.12, 0.88], [0.12, 0.56]]),
    Way(&[[0.52, 0.48], [0.86, 0.14]]),
    Way(&[[0.64, 0.14], [0.86, 0.14], [0.86, 0.36]]),
];
pub const PUSH: Icon = &[
    Way(&[[0.08, 0.5], [0.48, 0.5]]),
    Way(&[[0.34, 0.36], [0.48, 0.5], [0.34, 0.64]]),
    Way(&[[0.56, 0.3], [0.92, 0.3], [0.92, 0.7], [0.56, 0.7], [0.56, 0.3]]),
];
pub const THROW: Icon = &[
    Ring([0.74, 0.34], 0.16),
    Way(&[[0.1, 0.88], [0.24, 0.66], [0.46, 0.48]]),
    Way(&[[0.34, 0.9], [0.44, 0.72], [0.6, 0.6]]),
];
pub const BALL: Icon = &[Ring([0.5, 0.5], 0.32)];
pub const BOX: Icon = &[Way(&[[0.2, 0.2], [0.8, 0.2], [0.8, 0.8], [0.2, 0.8], [0.2, 0.2]])];
pub const CAPSULE: Icon = &[Way(&[
    [0.28, 0.36],
    [0.30, 0.28],
    [0.34, 0.20],
    [0.42, 0.16],
    [0.50, 0.14],
    [0.58, 0.16],
    [0.66, 0.20],
    [0.70, 0.28],
    [0.72, 0.36],
    [0.72, 0.64],
    [0.70, 0.72],
    [0.66, 0.80],
    [0.58, 0.84],
    [0.50, 0.86],
    [0.42, 0.84],
    [0.34, 0.80],
    [0.30, 0.72],
    [0.28, 0.64],
    [0.28, 0.36],
])];
pub const CYLINDER: Icon = &[Way(&[
    [0.24, 0.28],
    [0.32, 0.20],
    [0.5, 0.16],
    [0.68, 0.20],
    [0.76, 0.28],
    [0.68, 0.36],
    [0.5, 0.40],
    [0.32, 0.36],
    [0.24, 0.28],
    [0.24, 0.72],
    [0.32, 0.80],
    [0.5, 0.84],
    [0.68, 0.80],
    [0.76, 0.72],
    [0.76, 0.28],
])];
pub const CONE: Icon = &[Way(&[[0.5, 0.14], [0.82, 0.82], [0.18, 0.82], [0.5, 0.14]])];
pub const GEM: Icon = &[
    Way(&[[0.5, 0.14], [0.84, 0.36], [0.72, 0.8], [0.28, 0.8], [0.16, 0.36], [0.5, 0.14]]),
    Way(&[[0.16, 0.36], [0.5, 0.48], [0.84, 0.36]]),
    Way(&[[0.5, 0.48], [0.5, 0.8]]),
];
pub const BAR: Icon = &[
    Way(&[[0.14, 0.7], [0.68, 0.14], [0.86, 0.3], [0.32, 0.86], [0.14, 0.7]]),
    Dot([0.29, 0.72], 0.07),
    Dot([0.71, 0.29], 0.07),
];
pub const BALL_JOINT: Icon =
    &[Ring([0.5, 0.5], 0.15), Dot([0.5, 0.5], 0.06), Way(&[[0.1, 0.8], [0.38, 0.6]]), Way(&[[0.62, 0.4], [0.9, 0.2]])];
pub const HINGE: Icon = &[
    Way(&[[0.5, 0.1], [0.5, 0.9]]),
    Way(&[[0.5, 0.26], [0.12, 0.26], [0.12, 0.74], [0.5, 0.74]]),
    Way(&[[0.5, 0.38], [0.88, 0.38], [0.88, 0.62], [0.5, 0.62]]),
];
pub const SLIDER: Icon = &[
    Way(&[[0.08, 0.66], [0.92, 0.66]]),
    Way(&[[0.3, 0.66], [0.3, 0.34], [0.7, 0.34], [0.7, 0.66]]),
    Way(&[[0.18, 0.4], [0.08, 0.5], [0.18, 0.6]]),
    Way(&[[0.82, 0.4], [0.92, 0.5], [0.82, 0.6]]),
];
pub const FIXED: Icon = &[
    Way(&[[0.12, 0.16], [0.6, 0.16], [0.6, 0.6], [0.12, 0.6], [0.12, 0.16]]),
    Way(&[[0.4, 0.4], [0.88, 0.4], [0.88, 0.84], [0.4, 0.84], [0.4, 0.4]]),
];
pub const ROD: Icon = &[Way(&[[0.2, 0.72], [0.8, 0.28]]), Dot([0.2, 0.72], 0.1), Dot([0.8, 0.28], 0.1)];
pub const ROPE: Icon = &[
    Way(&[[0.14, 0.3], [0.22, 0.52], [0.36, 0.68], [0.5, 0.73], [0.64, 0.68], [0.78, 0.52], [0.86, 0.3]]),
    Dot([0.14, 0.3], 0.09),
    Dot([0.86, 0.3], 0.09),
];
pub const SPRING: Icon = &[Way(&[
    [0.06, 0.5],
    [0.18, 0.5],
    [0.26, 0.3],
    [0.38, 0.7],
    [0.5, 0.3],
    [0.62, 0.7],
    [0.74, 0.3],
    [0.82, 0.5],
    [0.94, 0.5],
])];
pub const PIN: Icon = &[Ring([0.5, 0.32], 0.17), Way(&[[0.5, 0.49], [0.5, 0.84]]), Way(&[[0.28, 0.84], [0.72, 0.84]])];
pub const CUT: Icon = &[
    Ring([0.28, 0.76], 0.12),
    Ring([0.72, 0.76], 0.12),
    Way(&[[0.35, 0.66], [0.68, 0.12]]),
    Way(&[[0.65, 0.66], [0.32, 0.12]]),
];
pub const MEASURE: Icon = &[
    Way(&[[0.1, 0.3], [0.1, 0.7]]),
    Way(&[[0.9, 0.3], [0.9, 0.7]]),
    Way(&[[0.1, 0.5], [0.9, 0.5]]),
    Way(&[[0.22, 0.4], [0.1, 0.5], [0.22, 0.6]]),
    Way(&[[0.78, 0.4], [0.9, 0.5], [0.78, 0.6]]),
];

pub const PHOTO: Icon = &[
    Way(&[
        [0.1, 0.3],
        [0.32, 0.3],
        [0.4, 0.18],
        [0.6, 0.18],
        [0.68, 0.3],
        [0.9, 0.3],
        [0.9, 0.8],
        [0.1, 0.8],
        [0.1, 0.3],
    ]),
    Ring([0.5, 0.54], 0.16),
];
pub const HELP: Icon = &[
    Way(&[[0.32, 0.34], [0.36, 0.22], [0.5, 0.16], [0.64, 0.22], [0.68, 0.36], [0.58, 0.48], [0.5, 0.55], [0.5, 0.68]]),
    Dot([0.5, 0.84], 0.06),
];

/// Draws it into a square.
pub fn paint(painter: &egui::Painter, icon: Icon, square: egui::Rect, color: egui::Color32) {
    let side = square.width();
    let at = |[x, y]: [f32; 2]| square.min + egui::vec2(x, y) * side;
    let line = egui::Stroke::new(1.6, color);
    for stroke in icon {
        match stroke {
            Way(points) => _ = painter.line(points.iter().map(|point| at(*point)).collect(), line),
            Ring(middle, radius) => _ = painter.circle_stroke(at(*middle), radius * side, line),
            Dot(middle, radius) => _ = painter.circle_filled(at(*middle), radius * side, color),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_fill_their_square_and_stay_in_it() {
        for icon in [
            DRAG, MOVE, TURN, SCALE, PUSH, THROW, BALL, BOX, CAPSULE, CYLINDER, CONE, GEM, BAR, BALL_JOINT, HINGE,
            SLIDER, FIXED, ROD, ROPE, SPRING, PIN, CUT, MEASURE,
        ] {
            let points = icon.iter().flat_map(|stroke| match stroke {
                Way(points) => points.to_vec(),
                Ring([x, y], r) | Dot([x, y], r) => vec![[x - r, y - r], [x + r, y + r]],
            });
            let points: Vec<[f32; 2]> = points.collect();
            let ends = |axis: usize| {
                points
                    .iter()
                    .map(|point| point[axis])
                    .fold((1.0, 0.0), |(low, high): (f32, f32), x| (low.min(x), high.max(x)))
            };
            let [across, down] = [ends(0), ends(1)];
            assert!([across, down].iter().all(|(low, high)| *low >= 0.049 && *high <= 0.951), "{across:?} {down:?}");
            assert!((across.1 - across.0).max(down.1 - down.0) > 0.55, "{across:?} {down:?}");
        }
    }
}
