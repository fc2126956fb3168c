//! A race in rows.

use std::fmt::Write;

use super::outcome::{Moment, Outcome};

impl Outcome {
    /// Every moment of every runner, one a row.
    pub fn csv(&self) -> String {
        let mut text = "t,runner,distance_m,angle_rad,energy_J,joint_gap_m,overlap_m,ms_per_step\n".to_owned();
        for course in &self.courses {
            for moment in &course.moments {
                let Moment { time, distance, angle, energy, joint_gap, overlap, ms_per_step } = moment;
                let name = course.name.replace(['"', ',', '\n'], " ");
                let row = writeln!(
                    text,
                    "{time},{name},{distance:e},{angle:e},{energy:e},{joint_gap:e},{overlap:e},{ms_per_step:e}"
                );
                row.expect("a string takes all");
            }
        }
        text
    }
}
