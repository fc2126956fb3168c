//! What can be drawn of a run: columns of the CSV.

use crate::lab::sweep::Record;

/// One column of the records.
#[derive(Debug)]
pub struct Measure {
    /// Its name in the CSV.
    pub name: &'static str,
    /// What it is, with its unit where that is always the same.
    pub about: &'static str,
    /// Its value; none where it was not measured.
    pub of: fn(&Record) -> Option<f64>,
}

/// All of them.
pub static MEASURES: [Measure; 13] = [
    Measure { name: "error", about: "error", of: |record| record.error },
    Measure { name: "cost", about: "cost, ms for a simulated second", of: Record::cost },
    Measure { name: "ms_per_step", about: "time of a step, ms", of: |record| record.ms_per_step },
    Measure {
        name: "row_updates",
        about: "row updates in the last step",
        of: |record| Some(record.row_updates as f64),
    },
    Measure { name: "pairs", about: "pairs tested in the last step", of: |record| Some(f64::from(record.pairs)) },
    Measure {
        name: "axes_tested",
        about: "axes tested in the last step",
        of: |record| Some(record.axes_tested as f64),
    },
    Measure { name: "joint_error", about: "joints part by, m", of: |record| record.joint_error },
    Measure { name: "penetration", about: "deepest overlap, m", of: |record| record.penetration },
    Measure { name: "sink", about: "bodies sink by, m", of: |record| record.sink },
    Measure { name: "drift", about: "bodies move by, m", of: |record| record.drift },
    Measure { name: "jitter", about: "bodies tremble at, m/s", of: |record| record.jitter },
    Measure { name: "energy_drift", about: "energy drifts by, of its scale", of: |record| record.energy_drift },
    Measure { name: "force_error", about: "error of the forces, of the weight", of: |record| record.force_error },
];

impl PartialEq for Measure {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl Measure {
    /// The one of that name.
    ///
    /// # Errors
    /// There is none, with those there are.
    pub fn find(name: &str) -> Result<&'static Self, String> {
        MEASURES.iter().find(|measure| measure.name == name).ok_or_else(|| {
            let names: Vec<&str> = MEASURES.iter().map(|measure| measure.name).collect();
            format!("the measures are {}", names.join(", "))
        })
    }
}
