//! The frame of a step that all impulse methods share: bodies are taken in, rows made, forces act, the method's own
//! stages, bounces, everything is written back.

use super::stage::{Color, Stage, Sweep};

/// What the stages of a group's step depend on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plan {
    pub substeps: u32,
    pub iterations: u32,
    /// Whether some contact may bounce, or forces are read.
    pub notes: bool,
    /// How far a body turns at most in the step, rad; none where no joint is swept.
    pub turn: Option<f64>,
}

impl Plan {
    /// Whether bodies on swept joints turn by more than that in the step, rad, so that rows of its start mislead.
    pub fn turns_over(&self, far: f64) -> bool {
        self.turn.is_some_and(|turn| turn > far)
    }

    /// The parts of a step that have the same rows, as substeps done before and in the part: one, or as many as
    /// there are substeps.
    pub fn parts(&self, rows_anew: bool) -> impl Iterator<Item = (u32, u32)> + use<> {
        let (parts, substeps) = if rows_anew { (self.substeps, 1) } else { (1, self.substeps) };
        (0..parts).map(move |part| (part, substeps))
    }

    /// A part of a step, of whose substeps `substep` gives what follows on the forces; the first one is told.
    pub fn part(
        &self,
        (done, substeps): (u32, u32),
        colors: impl Iterator<Item = Color> + Clone,
        stages: &mut Vec<Stage>,
        mut substep: impl FnMut(bool, &mut Vec<Stage>),
    ) {
        stages.push(Stage::Gather { substeps, done });
        stages.extend(colors.clone().map(Stage::Prepare));
        for index in 0..substeps {
            substep(index == 0, stages);
            if self.notes {
                stages.extend(colors.clone().map(Stage::Note));
            }
            stages.push(Stage::End);
        }
        if self.notes {
            stages.extend(colors.clone().map(Stage::Bounce));
        }
        stages.push(Stage::Scatter);
        stages.extend(colors.map(Stage::Store));
    }

    /// As many sweeps as there are iterations.
    pub fn sweeps(&self, sweep: Sweep, colors: impl Iterator<Item = Color> + Clone, stages: &mut Vec<Stage>) {
        for _ in 0..self.iterations {
            stages.extend(colors.clone().map(|color| Stage::Solve { color, sweep }));
        }
    }
}
