//! `plumb export`.

use std::fs;
use std::path::Path;

use crate::scene;

use super::arguments::ExportArguments;
use super::outcome::{CommandError, Outcome, print};

pub(super) fn export(arguments: &ExportArguments) -> Result<Outcome, CommandError> {
    let scene = scene::load(&arguments.scene, &arguments.parameters.list)?;
    let folder = arguments.out.as_deref().map(|file| file.parent().unwrap_or(Path::new("")));
    let text = format!("// {}\n{}", origin(arguments), scene.to_ron(folder)?);
    match &arguments.out {
        None => print(&text)?,
        Some(file) => fs::write(file, text).map_err(CommandError::unwritable(file))?,
    }
    Ok(Outcome::Done)
}

/// The command that makes it again, on one line whatever it quotes.
fn origin(arguments: &ExportArguments) -> String {
    let parameters = arguments.parameters.list.iter().map(|(name, value)| format!(" -p {name}={value}"));
    format!("plumb export {}{}", arguments.scene.escape_debug(), parameters.collect::<String>())
}
