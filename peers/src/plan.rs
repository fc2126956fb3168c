//! What is to be measured, and what came of it.

use std::io::{IsTerminal, stderr};

use crate::engine::{EngineKind, Settings};
use crate::record::Row;
use crate::scene::Scene;

/// What to measure.
pub struct Plan {
    pub scenes: Vec<Scene>,
    pub engines: Vec<EngineKind>,
    pub settings: Settings,
    /// Whether the scenes are those of Box3D's benchmark.
    pub suite: bool,
    /// How often the engines take turns.
    pub rounds: u32,
    /// Time to simulate; none: the command's own choice for each scene.
    pub seconds: Option<f64>,
}

impl Plan {
    /// Says what is being measured, on a terminal.
    pub fn progress(&self, scene: &Scene) {
        if stderr().is_terminal() {
            eprintln!("measuring {scene}");
        }
    }
}

/// What was measured.
#[derive(Default)]
pub struct Report {
    pub rows: Vec<Row>,
    /// Tables to read.
    pub text: String,
}

impl Report {
    /// Says once which engines cannot do a scene and why.
    pub fn note_refusals(&mut self, scene: &Scene, rows: &[Row]) {
        for row in rows.iter().filter(|row| !row.note.is_empty()) {
            let line = format!("{} cannot do {scene}: {}\n", row.engine, row.note);
            if !self.text.contains(&line) {
                self.text += &line;
            }
        }
    }
}
