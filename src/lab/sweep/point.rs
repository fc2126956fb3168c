//! One run of a sweep, and which of them a machine does.

use std::hash::Hasher;
use std::str::FromStr;

use xxhash_rust::xxh3::Xxh3;

use crate::lab::settings_file::settings_to_ron;
use crate::lab::{Plan, PlanError};
use crate::physics::SolverSettings;

/// What to run.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// A built-in scene or the path of a RON file.
    pub scene: String,
    /// Its parameters that differ from their defaults.
    pub parameters: Vec<(String, f64)>,
    /// The solver's settings.
    pub settings: SolverSettings,
    /// Time to simulate, s.
    pub seconds: f64,
    /// The curve it belongs to.
    pub series: String,
}

impl Point {
    /// `n=5 tilt=30`.
    pub fn parameters_text(&self) -> String {
        let parameters: Vec<_> = self.parameters.iter().map(|(name, value)| format!("{name}={value}")).collect();
        parameters.join(" ")
    }

    /// The run.
    ///
    /// # Errors
    /// No such scene or parameter, or a length that makes no run.
    pub fn plan(&self) -> Result<Plan, PlanError> {
        Plan::new(&self.scene, &self.parameters, self.settings, Some(self.seconds))
    }

    /// 16 hex digits over everything that the result depends on but the program itself.
    pub fn key(&self) -> String {
        let mut hasher = Xxh3::new();
        let settings = settings_to_ron(&self.settings);
        for part in [&self.scene, &self.parameters_text(), &settings] {
            hasher.write(part.as_bytes());
            hasher.write_u8(0);
        }
        hasher.write_u64(self.seconds.to_bits());
        format!("{:016x}", hasher.finish())
    }
}

/// The share of a sweep that one machine does: `2/8` is the second of eight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// From 1.
    index: u64,
    count: u64,
}

impl Shard {
    /// All of it.
    pub const ALL: Self = Self { index: 1, count: 1 };

    /// Whether it has a point of that key. Keys are hashes, so that dear and cheap points spread
    /// evenly.
    pub fn has(self, key: &str) -> bool {
        let number = u64::from_str_radix(key, 16).unwrap_or(0);
        number % self.count == self.index - 1
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parse = |text: &str| text.parse::<u64>().ok().filter(|&number| number > 0);
        match text.split_once('/').map(|(index, count)| (parse(index), parse(count))) {
            Some((Some(index), Some(count))) if index <= count => Ok(Self { index, count }),
            _ => Err("a shard is given as I/N, I from 1 to N, like 2/8".into()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(n: f64) -> Point {
        Point {
            scene: "stack".into(),
            parameters: vec![("n".into(), n)],
            settings: SolverSettings::default(),
            seconds: 2.0,
            series: "a".into(),
        }
    }

    #[test]
    fn keys_tell_points_apart_and_curves_do_not() {
        let other_settings = Point { settings: SolverSettings { iterations: 11, ..Default::default() }, ..point(5.0) };
        let others = [point(6.0), Point { seconds: 3.0, ..point(5.0) }, other_settings];
        for other in others {
            assert_ne!(point(5.0).key(), other.key());
        }
        assert_eq!(point(5.0).key(), Point { series: "b".into(), ..point(5.0) }.key());
    }

    #[test]
    fn shards_share_out_every_point_once() {
        let shards: Vec<Shard> = (1..=3).map(|index| format!("{index}/3").parse().unwrap()).collect();
        for n in 1..100 {
            let key = point(f64::from(n)).key();
            assert_eq!(shards.iter().filter(|shard| shard.has(&key)).count(), 1);
        }
        for bad in ["", "1", "0/3", "4/3", "1/0", "a/b", "-1/3"] {
            assert!(bad.parse::<Shard>().is_err(), "{bad}");
        }
    }
}
