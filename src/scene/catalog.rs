//! The built-in scenes, by name; and loading a scene by name or path.

use super::{SceneError, SceneInfo, SceneSpec, builtin, format};

/// All built-in scenes, the start scene first.
pub fn catalog() -> &'static [SceneInfo] {
    &builtin::ALL
}

/// The built-in scene of that name.
pub fn find(name: &str) -> Option<&'static SceneInfo> {
    catalog().iter().find(|scene| scene.name == name)
}

/// A scene by built-in name or path to a RON file, with parameters as given on the command line
/// (`n=40`); checked. [`is_path`] tells the one from the other.
///
/// # Errors
/// An unknown scene or parameter, a value out of range, or whatever is wrong with the file.
pub fn load(scene: &str, parameters: &[(String, f64)]) -> Result<SceneSpec, SceneError> {
    if is_path(scene) {
        return match parameters.first() {
            None => format::read(scene),
            Some((parameter, _)) => Err(SceneError::UnknownParameter {
                scene: scene.to_owned(),
                parameter: parameter.clone(),
                known: Vec::new(),
            }),
        };
    }
    let info =
        find(scene).ok_or_else(|| SceneError::UnknownScene { name: scene.to_owned(), nearest: nearest_name(scene) })?;
    info.make(&info.values(parameters)?)
}

/// Whether that is a path, and not the name of a built-in scene: it ends in `.ron` or has a path
/// separator in it.
pub fn is_path(scene: &str) -> bool {
    scene.ends_with(".ron") || scene.contains(std::path::is_separator)
}

/// The built-in name that takes the fewest edits to reach, if at most a third of it is wrong.
fn nearest_name(name: &str) -> Option<&'static str> {
    let name = name.to_lowercase();
    let (distance, nearest) =
        catalog().iter().map(|scene| (edit_distance(&name, scene.name), scene.name)).min_by_key(|&(edits, _)| edits)?;
    (distance <= nearest.chars().count().div_ceil(3)).then_some(nearest)
}

/// Levenshtein's distance: how many characters to insert, remove or replace.
fn edit_distance(from: &str, to: &str) -> usize {
    let to: Vec<char> = to.chars().collect();
    let mut row: Vec<usize> = (0..=to.len()).collect();
    for (i, a) in from.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &b) in to.iter().enumerate() {
            let replaced = diagonal + usize::from(a != b);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[to.len()]
}
