//! What probes read, as a file.

use std::fmt::Write;

use bevy::prelude::*;

use super::tracks::Tracks;
use crate::lab::write_whole;
use crate::sandbox::screenshot::next_free_path;
use crate::sandbox::state::report;

/// Writes it to the next free `plumb-N.csv` in the working directory.
pub fn save(world: &mut World) {
    let outcome = match text(world.resource::<Tracks>()) {
        None => Err("no probe has read anything yet: right click on a body, and let the scene run".into()),
        Some(text) => {
            let path = next_free_path("csv");
            let shown = std::path::absolute(&path).unwrap_or_else(|_| path.clone());
            match write_whole(&path, &text) {
                Ok(()) => Ok(format!("saved {}", shown.display())),
                Err(error) => Err(format!("{}: cannot be written: {error}", shown.display())),
            }
        }
    };
    report(world, outcome);
}

/// A column for the time and one a probe that has values, with enough digits to read back the same bits; nothing stands
/// where nothing is known.
fn text(tracks: &Tracks) -> Option<String> {
    let plotted: Vec<usize> = (0..tracks.tracks.len()).filter(|at| tracks.tracks[*at].is_plotted()).collect();
    if plotted.is_empty() || tracks.rows.is_empty() {
        return None;
    }
    let mut text = String::from("t");
    for at in &plotted {
        let track = &tracks.tracks[*at];
        let unit = if track.unit.is_empty() { String::new() } else { format!(" [{}]", track.unit) };
        text += ",";
        text += &quoted(&format!("{}{unit}", track.name));
    }
    for row in &tracks.rows {
        write!(text, "\n{:?}", row.time).expect("a string takes all");
        for at in &plotted {
            text += ",";
            if row.values[*at].is_finite() {
                write!(text, "{:?}", row.values[*at]).expect("a string takes all");
            }
        }
    }
    Some(text + "\n")
}

/// As a cell.
fn quoted(name: &str) -> String {
    if name.contains(['"', ',', '\n', '\r']) { format!("\"{}\"", name.replace('"', "\"\"")) } else { name.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::quoted;

    #[test]
    fn names_are_quoted_where_they_must_be() {
        assert_eq!(quoted("ball y [m]"), "ball y [m]");
        assert_eq!(quoted("a, \"b\""), "\"a, \"\"b\"\"\"");
    }
}
