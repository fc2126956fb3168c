//! The layers and what each must not name, in its tests neither.

use super::tree::{Mention, Tree};

/// The layers, each with those it must not name.
const FORBIDDEN: [(&str, &[&str]); 3] =
    [("physics", &["scene", "lab", "sandbox"]), ("scene", &["lab", "sandbox"]), ("lab", &["sandbox"])];

/// The parts of Bevy that the physics plugin stands on; all else is a renderer, a window or their plumbing.
const BEVY_WITHOUT_PICTURES: [&str; 10] =
    ["app", "ecs", "math", "platform", "prelude", "reflect", "tasks", "time", "transform", "utils"];

/// Crates that draw, open windows or read input.
const PICTURE_CRATES: [&str; 9] = [
    "bevy_egui",
    "bevy_panorbit_camera",
    "bevy_pbr",
    "bevy_render",
    "bevy_window",
    "bevy_winit",
    "egui",
    "egui_plot",
    "wgpu",
];

/// Each path that a layer must not name, with the file that names it.
pub fn violations(tree: &Tree) -> Vec<String> {
    let mut found = Vec::new();
    for mention in &tree.mentions {
        let module = &tree.modules[mention.module];
        let Some((_, forbidden)) =
            FORBIDDEN.iter().find(|(layer, _)| module.path.first().is_some_and(|it| it == layer))
        else {
            continue;
        };
        let path = from_root(mention, &module.path);
        let is_broken = match path[0].as_str() {
            "crate" | "plumb" => path.get(1).is_some_and(|name| forbidden.contains(&name.as_str())),
            "bevy" => path.get(1).is_some_and(|name| !BEVY_WITHOUT_PICTURES.contains(&name.as_str())),
            name => PICTURE_CRATES.contains(&name),
        };
        if is_broken {
            found.push(format!("src/{}: {}", tree.files[module.file], path.join("::")));
        }
    }
    found
}

/// `super::super::x` in `[physics, collision]` is `crate::x`.
fn from_root(mention: &Mention, here: &[String]) -> Vec<String> {
    if mention.from_outside || !["super", "self"].contains(&mention.path[0].as_str()) {
        return mention.path.clone();
    }
    let mut absolute: Vec<String> = std::iter::once("crate".into()).chain(here.iter().cloned()).collect();
    for name in &mention.path {
        match name.as_str() {
            "super" => {
                absolute.pop();
            }
            "self" => {}
            _ => absolute.push(name.clone()),
        }
    }
    absolute
}
