//! A step as a list of stages: what a method does to a group of islands, in order. Within a stage everything may be
//! done in any order and on any thread. What each stage does to bodies and constraints is in [`super::walk`].

use super::coloring::Color;
use super::constants::IMPACT_SWEEPS;
use crate::physics::contact::restitution_threshold;
use crate::physics::lanes::Lanes;
use crate::physics::settings::SolverSettings;
use crate::physics::solver::soft_terms::{Projection, SoftTerms, UNLIMITED};
use crate::physics::solver::substeps::Substeps;

/// How an update of the velocities treats position errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sweep {
    /// With the soft terms. Contacts solve friction only where surfaces come together in the step.
    Soft,
    /// With the soft terms; contacts solve friction, too.
    SoftWithFriction,
    /// Rigid and without bias; contacts solve friction, too.
    Relax,
}

/// One thing done to all of a group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stage {
    /// Bodies that no constraint holds or touches are taken through the step.
    FreeMotion,
    /// Trees of joints that no contact touches are taken through the step.
    Trees,
    /// Bodies are taken in, for so many substeps after those that are done.
    Gather { substeps: u32, done: u32 },
    /// Rows for the present poses, of when so many substeps are done.
    Prepare { color: Color, done: u32 },
    /// External forces act; in all but the first substep, the impulses of the substep before act again.
    BeginSubstep { is_first: bool },
    /// The impulses of the step before act.
    WarmStart(Color),
    /// One update.
    Solve { color: Color, sweep: Sweep },
    /// One update with the soft terms, contacts without friction. The first of a substep forgets accumulated
    /// impulses.
    SolvePositions { color: Color, is_first: bool },
    /// One update of friction alone, from zero, bounded by the normal impulses at hand.
    SolveFriction(Color),
    /// One update of the contacts with a normal impulse, until their surfaces neither part nor approach.
    SolveVelocities(Color),
    /// What a sweep changed is noted, for whoever reads residuals: sweeps are numbered; the number of one that `begins`
    /// is of the first to come.
    Trace { begins: bool, sweep: u32 },
    /// The impulses of this substep are recorded, for whoever reads forces.
    Record(Color),
    /// Positions follow velocities; `freely`: those of bodies that no impulse touched, the mean of these.
    Drift { freely: bool },
    /// Positions are moved out of their errors.
    Project(Color),
    /// What constraints added to the velocities is remembered; drag acts.
    EndSubstep,
    /// Points that come together fast part again. The sweeps over impacts of a step are numbered: but for the first of a
    /// substep, one in front of which there was none does nothing.
    Impact { color: Color, sweep: u32 },
    /// Bodies are written back.
    Scatter,
    /// Impulses are written back.
    Store(Color),
}

impl Stage {
    /// The colour that the stage works on, if it is one of constraints.
    pub fn color(self) -> Option<Color> {
        match self {
            Self::Prepare { color, .. }
            | Self::WarmStart(color)
            | Self::Solve { color, .. }
            | Self::SolvePositions { color, .. }
            | Self::SolveFriction(color)
            | Self::SolveVelocities(color)
            | Self::Record(color)
            | Self::Project(color)
            | Self::Impact { color, .. }
            | Self::Store(color) => Some(color),
            Self::FreeMotion
            | Self::Trees
            | Self::Gather { .. }
            | Self::BeginSubstep { .. }
            | Self::Drift { .. }
            | Self::EndSubstep
            | Self::Trace { .. }
            | Self::Scatter => None,
        }
    }
}

/// Numbers of a step that all groups share.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GroupTerms<L> {
    /// Length of a substep, s.
    pub h: f64,
    pub substeps: Substeps,
    /// Simulation time at the start of the step, s.
    pub time: f64,
    pub joint: SoftTerms<L>,
    pub contact: SoftTerms<L>,
    /// Of methods with [`Stage::Project`].
    pub projection: Option<Projection<L>>,
    /// Approach from which a contact bounces, m/s.
    pub restitution_speed: f64,
}

impl<L: Lanes> GroupTerms<L> {
    /// Rigid constraints without bias.
    pub fn new(settings: &SolverSettings, time: f64) -> Self {
        let h = settings.step() / f64::from(settings.substeps);
        let without_bias = SoftTerms::rigid(0.0, UNLIMITED, 0.0, h);
        Self {
            h,
            substeps: Substeps::of(settings),
            time,
            joint: without_bias,
            contact: without_bias,
            projection: None,
            restitution_speed: restitution_threshold(settings),
        }
    }
}

/// The frame of a step that all methods share: bodies are taken in, rows made; in each substep impacts, forces, and the
/// method's own stages; everything is written back. These are the numbers that a group's stages depend on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plan {
    pub substeps: u32,
    pub iterations: u32,
    /// Whether some contact may bounce.
    pub bounces: bool,
    /// Whether forces are read.
    pub records: bool,
    /// Whether residuals of sweeps are read.
    pub traces: bool,
    /// How far a body turns at most in the step, rad; none where no joint is swept.
    pub turn: Option<f64>,
}

impl Plan {
    /// Whether bodies on swept joints turn by more than that in the step, rad, so that rows of its start mislead.
    pub fn turns_over(&self, limit: f64) -> bool {
        self.turn.is_some_and(|turn| turn > limit)
    }

    /// The intervals of a step that have the same rows, as substeps done before and in the interval: the whole step,
    /// or each substep where rows are made `anew`.
    pub fn intervals(&self, anew: bool) -> impl Iterator<Item = (u32, u32)> + use<> {
        let (intervals, substeps) = if anew { (self.substeps, 1) } else { (1, self.substeps) };
        (0..intervals).map(move |interval| (interval, substeps))
    }

    /// The stages of an interval. `substep` adds those of one substep, and is told whether it is the interval's first.
    pub fn interval(
        &self,
        (done, substeps): (u32, u32),
        colors: impl Iterator<Item = Color> + Clone,
        stages: &mut Vec<Stage>,
        mut substep: impl FnMut(bool, &mut Vec<Stage>),
    ) {
        stages.push(Stage::Gather { substeps, done });
        stages.extend(colors.clone().map(|color| Stage::Prepare { color, done }));
        for index in 0..substeps {
            if self.bounces {
                self.impacts(done + index, colors.clone(), stages);
            }
            substep(index == 0, stages);
            if self.records {
                stages.extend(colors.clone().map(Stage::Record));
            }
            stages.push(Stage::EndSubstep);
        }
        stages.push(Stage::Scatter);
        stages.extend(colors.map(Stage::Store));
    }

    /// The impacts of the substep of that index in the step.
    fn impacts(&self, substep: u32, colors: impl Iterator<Item = Color> + Clone, stages: &mut Vec<Stage>) {
        let contacts = colors.filter(|color| matches!(color, Color::Contacts(_)));
        for sweep in substep * IMPACT_SWEEPS..(substep + 1) * IMPACT_SWEEPS {
            stages.extend(contacts.clone().map(|color| Stage::Impact { color, sweep }));
        }
    }

    /// Positions follow velocities.
    pub fn drift(&self, stages: &mut Vec<Stage>) {
        stages.push(Stage::Drift { freely: self.bounces });
    }

    /// The start of a substep: external forces, and in the first one the impulses of the step before.
    pub fn begin(&self, is_first: bool, colors: impl Iterator<Item = Color>, stages: &mut Vec<Stage>) {
        stages.push(Stage::BeginSubstep { is_first });
        if is_first {
            stages.extend(colors.map(Stage::WarmStart));
        }
    }

    /// As many sweeps as there are iterations.
    pub fn sweeps(&self, sweep: Sweep, colors: impl Iterator<Item = Color> + Clone, stages: &mut Vec<Stage>) {
        self.trace(true, stages);
        for _ in 0..self.iterations {
            stages.extend(colors.clone().map(|color| Stage::Solve { color, sweep }));
            self.trace(false, stages);
        }
    }

    /// After a sweep, or before the first of a solve: notes what it changed.
    pub fn trace(&self, begins: bool, stages: &mut Vec<Stage>) {
        if self.traces {
            let last = stages.iter().rev().find_map(|stage| match stage {
                Stage::Trace { begins, sweep } => Some(sweep + u32::from(!begins)),
                _ => None,
            });
            stages.push(Stage::Trace { begins, sweep: last.unwrap_or(0) });
        }
    }
}
