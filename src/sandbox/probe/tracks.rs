//! What probes read over the last minute, and the trails of points.

use std::collections::VecDeque;

use bevy::math::DVec3;
use bevy::prelude::*;

use super::reader::{Reader, Watched};
use crate::physics::StepStats;
use crate::sandbox::CurrentScene;
use crate::sandbox::panel::palette;
use crate::sandbox::timeline::change_places;
use crate::scene::{Probe, ProbePlot, Probes};

/// Simulation time that is kept, s.
const WINDOW: f64 = 60.0;
/// Most samples kept. Steps that come faster are merged into one sample.
const CAPACITY: usize = 3600;
/// Simulation time that a trail is long, s.
pub const TRAIL: f64 = 5.0;
/// Most points of a trail.
const MOST_POINTS: usize = 600;

/// Colors of probes, the least used first.
const COLORS: [[u8; 3]; 7] = [
    palette::SKY,
    palette::ORANGE,
    palette::GREEN,
    palette::YELLOW,
    palette::PURPLE,
    palette::VERMILION,
    [225, 225, 225],
];

/// What is known of the probes of the scene on view.
#[derive(Resource, Clone, Debug, Default)]
pub struct Tracks {
    /// One a probe, in the order of [`Probes`].
    pub tracks: Vec<Track>,
    /// One a sample, the oldest first.
    pub rows: VecDeque<Row>,
    /// Those of steps that the scene has gone back from, the next last: they are known when it comes to them again.
    ahead: Vec<Row>,
    /// When the scene started, s, by the world's clock.
    start: f64,
}

/// A probe.
#[derive(Clone, Debug)]
pub struct Track {
    /// What it reads.
    pub probe: Watched,
    /// What it is called: where it is gone, what it was called last.
    pub name: String,
    /// Of its values.
    pub unit: &'static str,
    /// sRGB.
    pub color: [u8; 3],
    /// Whether what it is of is gone.
    pub is_gone: bool,
    /// Of a trail: the step, the time, s, and where its point was then, m, the oldest first.
    pub trail: VecDeque<(u64, f64, DVec3)>,
}

/// What was read after a step, or after several that came close together.
#[derive(Clone, Debug)]
pub struct Row {
    /// Simulation time since the scene started, s: of the last of them.
    pub time: f64,
    /// The same of the first.
    began: f64,
    /// The last of them.
    step: u64,
    /// Whether the step before the first is not in the row before.
    pub breaks: bool,
    /// One a probe, not a number where there was none.
    pub values: Vec<f64>,
}

impl Track {
    /// Whether it has values over time.
    pub fn is_plotted(&self) -> bool {
        !matches!(self.probe, Probe::Trail(_))
    }

    /// Whether of values that are merged the largest is kept, so that no peak is lost; else the last.
    fn keeps_peaks(&self) -> bool {
        let peaks = [ProbePlot::Force, ProbePlot::Torque, ProbePlot::Gap, ProbePlot::Overlap, ProbePlot::StepTime];
        matches!(self.probe, Probe::Plot(_, plot) if plot.is_contact_force() || peaks.contains(&plot))
    }
}

impl Tracks {
    /// Forgets all, and counts time from this one on.
    fn begin(&mut self, start: f64) {
        *self = Self { start, ..default() };
    }

    /// Has a track for each probe and no other; those that stay keep what they have.
    fn keep(&mut self, probes: &[Watched]) {
        if self.tracks.iter().map(|track| &track.probe).eq(probes) {
            return;
        }
        let place = |probe: &Watched| self.tracks.iter().position(|track| track.probe == *probe);
        let places: Vec<_> = probes.iter().map(place).collect();
        for row in self.rows.iter_mut().chain(&mut self.ahead) {
            row.values = places.iter().map(|place| place.map_or(f64::NAN, |place| row.values[place])).collect();
        }
        let old = std::mem::take(&mut self.tracks);
        self.tracks = places.iter().flatten().map(|place| old[*place].clone()).collect();
        for (at, (probe, place)) in probes.iter().zip(&places).enumerate() {
            if place.is_none() {
                let used = |color: [u8; 3]| self.tracks.iter().filter(|track| track.color == color).count();
                let color = COLORS.into_iter().min_by_key(|color| used(*color)).unwrap_or_default();
                let (probe, name, unit, is_gone) = (*probe, String::new(), "", false);
                self.tracks.insert(at, Track { probe, name, unit, color, is_gone, trail: VecDeque::new() });
            }
        }
    }

    /// The scene went to a step, back or on.
    fn go(&mut self, step: u64) {
        change_places(&mut self.rows, &mut self.ahead, |row| row.step <= step);
        for track in &mut self.tracks {
            while track.trail.back().is_some_and(|(at, ..)| *at > step) {
                track.trail.pop_back();
            }
        }
    }

    /// Takes in what was read after a step. The time is the world's.
    fn push(&mut self, step: u64, time: f64, values: Vec<f64>) {
        self.go(step.saturating_sub(1));
        let time = time - self.start;
        while self.ahead.pop_if(|row| row.began <= time).is_some() {}
        // Short of the spacing by a rounding error is not short of it.
        let spacing = WINDOW / CAPACITY as f64 * (1.0 - 1e-6);
        let breaks = self.rows.back().is_none_or(|last| last.step + 1 != step);
        if let Some(last) = self.rows.back_mut().filter(|last| !breaks && time - last.began < spacing) {
            (last.time, last.step) = (time, step);
            for ((track, last), value) in self.tracks.iter().zip(&mut last.values).zip(values) {
                if !(track.keeps_peaks() && last.abs() > value.abs()) {
                    *last = value;
                }
            }
            return;
        }
        while self.rows.len() >= CAPACITY || self.rows.front().is_some_and(|oldest| oldest.time < time - WINDOW) {
            self.rows.pop_front();
        }
        self.rows.push_back(Row { time, began: time, step, breaks, values });
    }

    /// Takes in where the point of a trail is after a step.
    fn push_point(&mut self, track: usize, step: u64, time: f64, place: DVec3) {
        let trail = &mut self.tracks[track].trail;
        let time = time - self.start;
        // The scene went on to a moment farther off: what lies between is not known.
        if trail.back().is_some_and(|(last, ..)| last + 1 != step) {
            trail.clear();
        }
        let spacing = TRAIL / MOST_POINTS as f64 * (1.0 - 1e-6);
        let count = trail.len();
        if count > 1 && trail[count - 1].1 - trail[count - 2].1 < spacing {
            trail.pop_back();
        }
        trail.push_back((step, time, place));
        while trail.len() > MOST_POINTS || trail.front().is_some_and(|(_, oldest, _)| *oldest < time - TRAIL) {
            trail.pop_front();
        }
    }

    /// What a step told of a track, if it was the last.
    pub fn told_after(&self, step: u64, track: usize) -> Option<f64> {
        self.rows.back().filter(|row| row.step == step)?.values.get(track).copied()
    }

    /// The sample nearest to a time since the scene started, s.
    pub fn nearest(&self, time: f64) -> Option<&Row> {
        let after = self.rows.partition_point(|row| row.time < time);
        let around = [after.checked_sub(1), Some(after)];
        let rows = around.into_iter().flatten().filter_map(|place| self.rows.get(place));
        rows.min_by(|one, other| (one.time - time).abs().total_cmp(&(other.time - time).abs()))
    }

    /// The points of a track's curve between two times, in pieces without a gap.
    pub fn pieces(&self, track: usize, [from, to]: [f64; 2]) -> Vec<Vec<[f64; 2]>> {
        let mut pieces = vec![Vec::new()];
        for row in self.rows.iter().filter(|row| (from..=to).contains(&row.time)) {
            let value = row.values[track];
            if row.breaks || !value.is_finite() {
                pieces.push(Vec::new());
            }
            if value.is_finite() {
                pieces.last_mut().expect("the one that was begun").push([row.time, value]);
            }
        }
        pieces.retain(|piece| !piece.is_empty());
        pieces
    }
}

/// Runs in the step itself, where there are probes.
pub fn sample(probes: Res<Probes>, reader: Reader, mut tracks: ResMut<Tracks>) {
    tracks.keep(&probes.0);
    let (step, time) = reader.now();
    let values = probes.0.iter().map(|probe| reader.value(probe)).collect();
    tracks.push(step, time, values);
    for (at, probe) in probes.0.iter().enumerate() {
        if let Probe::Trail(point) = probe
            && let Some(place) = reader.place(point)
        {
            tracks.push_point(at, step, time, place);
        }
    }
}

/// Forgets what was set aside.
pub fn forget_ahead(mut tracks: ResMut<Tracks>) {
    tracks.ahead.clear();
}

/// Has the tracks be those of the probes and of the moment on view.
pub fn keep_up(
    scene: Option<Res<CurrentScene>>,
    stats: Res<StepStats>,
    probes: Res<Probes>,
    reader: Reader,
    mut tracks: ResMut<Tracks>,
) {
    if scene.is_some_and(|scene| scene.is_changed()) {
        tracks.begin(stats.time);
    }
    tracks.keep(&probes.0);
    tracks.go(stats.steps);
    for track in &mut tracks.tracks {
        track.is_gone = !reader.is_there(&track.probe);
        if !track.is_gone {
            (track.name, track.unit) = (reader.name(&track.probe), reader.unit(&track.probe));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::ProbeSubject;

    fn with(plots: &[ProbePlot]) -> Tracks {
        let mut tracks = Tracks::default();
        tracks.keep(&probes(plots));
        tracks
    }

    fn probes(plots: &[ProbePlot]) -> Vec<Watched> {
        plots.iter().map(|plot| Probe::Plot(ProbeSubject::Scene, *plot)).collect()
    }

    #[test]
    fn a_minute_is_kept_at_any_rate_in_bounded_memory() {
        for hz in [30.0, 60.0, 240.0, 1000.0] {
            let mut tracks = with(&[ProbePlot::Energy]);
            for step in 0..(70.0 * hz) as u64 {
                let time = step as f64 / hz;
                tracks.push(step, time, vec![time]);
                assert!(tracks.rows.len() <= CAPACITY);
            }
            let span = tracks.rows.back().unwrap().time - tracks.rows.front().unwrap().time;
            assert!((span - WINDOW).abs() < 0.1 + 1.0 / hz, "{span} s at {hz} Hz");
            assert!(tracks.rows.iter().all(|row| row.values[0] == row.time), "a value is that of its time");
            assert_eq!(tracks.pieces(0, [0.0, 100.0]).len(), 1, "no gap");
        }
    }

    #[test]
    fn merging_keeps_peaks_of_forces_and_the_last_of_the_rest() {
        let mut tracks = with(&[ProbePlot::Overlap, ProbePlot::Energy]);
        for (step, values) in [[0.1, 5.0], [0.7, 9.0], [0.2, 3.0]].into_iter().enumerate() {
            tracks.push(step as u64, 1e-3 * step as f64, values.to_vec());
        }
        assert_eq!(tracks.rows.len(), 1);
        assert_eq!(tracks.rows[0].values, [0.7, 3.0]);
    }

    #[test]
    fn going_back_sets_aside_and_going_on_leaves_a_gap() {
        let mut tracks = with(&[ProbePlot::Energy]);
        let push = |tracks: &mut Tracks, step: u64| tracks.push(step, step as f64, vec![1.0]);
        (1..=5).for_each(|step| push(&mut tracks, step));
        push(&mut tracks, 3);
        assert_eq!(tracks.rows.iter().map(|row| row.step).collect::<Vec<_>>(), [1, 2, 3]);
        push(&mut tracks, 4);
        assert_eq!(tracks.pieces(0, [0.0, 9.0]).len(), 1);
        // The scene has been at 5.
        push(&mut tracks, 7);
        assert_eq!(tracks.rows.len(), 6);
        assert_eq!(tracks.pieces(0, [0.0, 9.0]).len(), 2);
        tracks.go(2);
        assert_eq!(tracks.rows.len(), 2);
        assert_eq!(tracks.nearest(1.4).unwrap().time, 1.0);
        tracks.go(6);
        assert_eq!(tracks.rows.iter().map(|row| row.step).collect::<Vec<_>>(), [1, 2, 3, 4, 5]);
        // What is read anew takes the place of what was known.
        tracks.go(1);
        (2..=7).for_each(|step| push(&mut tracks, step));
        assert_eq!(tracks.rows.iter().map(|row| row.step).collect::<Vec<_>>(), [1, 2, 3, 4, 5, 6, 7]);
        assert!(tracks.ahead.is_empty());
    }

    #[test]
    fn a_probe_more_or_less_leaves_the_others_what_they_have() {
        let [a, b, c] = [ProbePlot::Energy, ProbePlot::Gap, ProbePlot::Overlap];
        let mut tracks = with(&[a, b]);
        tracks.push(1, 1.0, vec![1.0, 2.0]);
        let color = tracks.tracks[1].color;
        tracks.keep(&probes(&[b, c]));
        assert_eq!(tracks.rows[0].values[0], 2.0);
        assert!(tracks.rows[0].values[1].is_nan());
        assert_eq!(tracks.tracks[0].color, color);
        assert_ne!(tracks.tracks[1].color, color);
    }
}
