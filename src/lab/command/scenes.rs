//! `plumb scenes`.

use std::fmt::Write;

use crate::scene::{Parameter, SceneInfo, catalog};

use super::outcome::{CommandError, Outcome, print};

pub(super) fn list() -> Result<Outcome, CommandError> {
    print(&listing(catalog()))?;
    Ok(Outcome::Done)
}

/// Three columns: scene and parameters, their values, what they mean.
fn listing(scenes: &[SceneInfo]) -> String {
    let parameters = || scenes.iter().flat_map(|scene| scene.parameters);
    let name_width = parameters().map(|parameter| parameter.name.len() + 2).chain(scenes.iter().map(|s| s.name.len()));
    let name_width = name_width.max().unwrap_or(0) + 2;
    let value_width = parameters().map(|parameter| values(parameter).chars().count()).max().unwrap_or(0) + 2;
    let mut text = String::new();
    for scene in scenes {
        // Writing to a string does not fail.
        let _ = writeln!(text, "{:name_width$}{}: {}", scene.name, scene.title, scene.about);
        let _ = writeln!(text, "{:name_width$}known: {}", "", scene.truth);
        for parameter in scene.parameters {
            let values = values(parameter);
            let _ = writeln!(
                text,
                "{:name_width$}{values:value_width$}{}",
                format!("  {}", parameter.name),
                parameter.about
            );
        }
    }
    text
}

/// `40 (a whole number from 1 to 200)`.
fn values(parameter: &Parameter) -> String {
    format!("{} ({})", parameter.default, parameter.range())
}
