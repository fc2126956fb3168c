//! What probes read, as a file.

use bevy::prelude::*;

use super::tracks::{Track, Tracks};
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
    let heading = |track: &Track| match track.unit {
        "" => track.name.clone(),
        unit => format!("{} [{unit}]", track.name),
    };
    let headings = plotted.iter().map(|at| heading(&tracks.tracks[*at]));
    let number = |value: f64| if value.is_finite() { format!("{value:?}") } else { String::new() };
    let rows = tracks.rows.iter().map(|row| {
        let values = plotted.iter().map(|at| number(row.values[*at]));
        std::iter::once(format!("{:?}", row.time)).chain(values).collect()
    });
    let first = std::iter::once("t".to_owned()).chain(headings).collect();
    Some(written(std::iter::once(first).chain(rows)))
}

/// As a file.
fn written(records: impl Iterator<Item = Vec<String>>) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for record in records {
        writer.write_record(record).expect("a list takes all");
    }
    String::from_utf8(writer.into_inner().expect("a list takes all")).expect("made of text")
}

#[cfg(test)]
mod tests {
    use super::written;

    #[test]
    fn names_are_quoted_where_they_must_be() {
        let cell = |name: &str| written(std::iter::once(vec![name.to_owned()]));
        assert_eq!(cell("ball y [m]"), "ball y [m]\n");
        assert_eq!(cell("a, \"b\""), "\"a, \"\"b\"\"\"\n");
    }
}
