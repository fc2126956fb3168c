//! Trajectories as CSV: one row per body and time.

use std::fs::File;
use std::io::{self, Write};
use std::path::Path;

use super::simulation::Sample;

/// Column names; the row's fields in this order.
const HEADER: [&str; 15] = ["t", "body", "x", "y", "z", "qx", "qy", "qz", "qw", "vx", "vy", "vz", "wx", "wy", "wz"];

/// Writes `t,body,x,y,z,qx,qy,qz,qw,vx,vy,vz,wx,wy,wz`, in SI, with as many digits as it takes
/// to read back the same bits.
pub struct TrajectoryWriter<W: Write> {
    csv: csv::Writer<W>,
    names: Vec<String>,
    /// Time between rows, s; none: every step.
    every: Option<f64>,
    /// Multiples of `every` written so far.
    written: u64,
}

impl TrajectoryWriter<File> {
    /// Creates the file and writes its header.
    ///
    /// # Errors
    /// The path cannot be written.
    pub fn create(path: &Path, names: Vec<String>, every: Option<f64>) -> io::Result<Self> {
        Self::new(File::create(path)?, names, every)
    }
}

impl<W: Write> TrajectoryWriter<W> {
    /// Writes to anything; `names` in the order of [`Sample::bodies`].
    ///
    /// # Errors
    /// The header cannot be written.
    pub fn new(sink: W, names: Vec<String>, every: Option<f64>) -> io::Result<Self> {
        let mut csv = csv::Writer::from_writer(sink);
        csv.write_record(HEADER)?;
        csv.flush()?;
        Ok(Self { csv, names, every, written: 0 })
    }

    /// Writes the bodies if it is time to: at the start, then at the first step that reaches
    /// each multiple of the interval.
    ///
    /// # Errors
    /// Writing failed.
    pub fn write(&mut self, sample: &Sample) -> io::Result<()> {
        if let Some(every) = self.every {
            // Step times are rounded: a step that is at the multiple counts as having reached it.
            let reached = (sample.time / every * (1.0 + 1e-12)).floor();
            if sample.step > 0 && reached < self.written as f64 {
                return Ok(());
            }
            self.written = reached as u64 + 1;
        }
        for (name, state) in self.names.iter().zip(sample.bodies) {
            let (x, q, v, w) = (state.position, state.rotation, state.linear, state.angular);
            self.csv.serialize((sample.time, name, x.x, x.y, x.z, q.x, q.y, q.z, q.w, v.x, v.y, v.z, w.x, w.y, w.z))?;
        }
        Ok(())
    }

    /// Writes what is still in memory.
    ///
    /// # Errors
    /// Writing failed.
    pub fn finish(mut self) -> io::Result<()> {
        self.csv.flush()
    }
}
