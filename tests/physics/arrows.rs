//! The arrow rule: `sandbox → lab → scene → physics`, and no renderer below the sandbox. Read
//! from the sources, since a single crate's modules could name each other freely.

use std::fs;
use std::path::{Path, PathBuf};

/// The layers, each with those it must not name.
const FORBIDDEN: [(&str, &[&str]); 3] =
    [("physics", &["scene", "lab", "sandbox"]), ("scene", &["lab", "sandbox"]), ("lab", &["sandbox"])];

/// The parts of Bevy that the physics plugin stands on; all else is a renderer, a window or
/// their plumbing.
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

#[test]
fn arrows_point_one_way() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut checked = [0; FORBIDDEN.len()];
    let mut broken = Vec::new();
    for (slot, (layer, _)) in FORBIDDEN.iter().enumerate() {
        for file in sources(&root.join(layer)) {
            let relative = file.strip_prefix(&root).unwrap();
            let text = fs::read_to_string(&file).unwrap();
            broken.extend(violations(&module_of(relative), &text).into_iter().map(|path| (file.clone(), path)));
            checked[slot] += 1;
        }
    }
    assert!(broken.is_empty(), "{broken:#?}");
    assert!(checked.iter().all(|&files| files > 3), "files not found: {checked:?}");
}

#[test]
fn every_way_of_naming_a_higher_layer_is_seen() {
    let in_physics = |text: &str| violations(&["physics".into(), "collision".into()], text);
    for text in [
        "use crate::scene::SceneSpec;",
        "use crate::{physics::step, lab};",
        "use crate::{self as plumb_root, sandbox::launch};",
        "fn f() { crate::lab::measure(); }",
        "use super::super::scene;",
        "use super::{body, super::lab};",
        "mod tests { use super::super::super::sandbox::launch; }",
        "use plumb::scene::find;",
        "use bevy::render::mesh;",
        "use bevy::{prelude::*, window::Window};",
        "use ::bevy::pbr;",
        "use bevy_egui::egui;",
        "fn f() -> egui_plot::Plot { todo!() }",
    ] {
        assert_eq!(in_physics(text).len(), 1, "{text}: {:?}", in_physics(text));
    }
    for text in [
        "use super::scene;",
        "use crate::physics::{self, step};",
        "use bevy::{prelude::*, ecs::entity::MapEntities, math::{DQuat, DVec3}};",
        "// use crate::scene;\n/* crate::lab /* crate::lab */ */",
        "const TEXT: &str = \"use crate::scene; \\\" crate::lab\"; const C: char = '\"'; fn f<'a>(x: &'a str) {}",
        "const TEXT: &str = r#\"\"use crate::scene;\"#;",
        "mod tests { use super::super::body; } use super::bodies;",
    ] {
        assert_eq!(in_physics(text), Vec::<String>::new(), "{text}");
    }
    let in_lab = |text: &str| violations(&["lab".into(), "run".into()], text);
    assert_eq!(in_lab("use crate::sandbox::launch;").len(), 1);
    assert_eq!(in_lab("use crate::scene; use crate::physics;"), Vec::<String>::new());
}

/// All `.rs` files below a folder.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files.extend(sources(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
    files
}

/// `physics/collision/mod.rs` is `[physics, collision]`.
fn module_of(file: &Path) -> Vec<String> {
    let mut module: Vec<String> =
        file.with_extension("").iter().map(|part| part.to_string_lossy().into_owned()).collect();
    module.pop_if(|last| last == "mod");
    module
}

/// The paths in a module's text that its layer must not name.
fn violations(module: &[String], text: &str) -> Vec<String> {
    let layer = module[0].as_str();
    let forbidden = FORBIDDEN.iter().find(|(name, _)| *name == layer).map_or(&[][..], |(_, forbidden)| *forbidden);
    let is_broken = |path: &Vec<String>| match path[0].as_str() {
        "crate" | "plumb" => path.get(1).is_some_and(|name| forbidden.contains(&name.as_str())),
        "bevy" => path.get(1).is_some_and(|name| !BEVY_WITHOUT_PICTURES.contains(&name.as_str())),
        name => PICTURE_CRATES.contains(&name),
    };
    paths(module, &tokens(text)).into_iter().filter(is_broken).map(|path| path.join("::")).collect()
}

/// Names and punctuation; comments, strings and characters left out.
fn tokens(text: &str) -> Vec<String> {
    let mut tokens = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let taken = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            block_comment(rest)
        } else if let Some(hashes) = raw_string(rest) {
            let close = format!("\"{}", "#".repeat(hashes));
            let open = hashes + 2;
            rest[open..].find(&close).map_or(rest.len(), |end| open + end + close.len())
        } else if first == '"' {
            quoted(rest, '"')
        } else if first == '\'' && is_character(rest) {
            quoted(rest, '\'')
        } else if rest.starts_with("::") {
            tokens.push("::".into());
            2
        } else if first.is_alphanumeric() || first == '_' {
            let end = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
            tokens.push(rest[..end].into());
            end
        } else {
            if !first.is_whitespace() {
                tokens.push(first.into());
            }
            first.len_utf8()
        };
        rest = &rest[taken..];
    }
    tokens
}

fn block_comment(text: &str) -> usize {
    let (mut depth, mut at) = (0, 0);
    loop {
        let rest = &text[at..];
        if rest.starts_with("/*") {
            (depth, at) = (depth + 1, at + 2);
        } else if rest.starts_with("*/") {
            (depth, at) = (depth - 1, at + 2);
        } else {
            at += rest.chars().next().map_or(1, char::len_utf8);
        }
        if depth == 0 || at >= text.len() {
            return at.min(text.len());
        }
    }
}

/// Number of `#` of the raw string that starts here.
fn raw_string(text: &str) -> Option<usize> {
    let after = text.strip_prefix('r')?;
    let hashes = after.len() - after.trim_start_matches('#').len();
    after[hashes..].starts_with('"').then_some(hashes)
}

/// A character and not a lifetime: closed by a quote after one character or an escape.
fn is_character(text: &str) -> bool {
    let mut characters = text.chars().skip(1);
    characters.next() == Some('\\') || characters.next() == Some('\'')
}

/// Length of a quoted literal with escapes.
fn quoted(text: &str, quote: char) -> usize {
    let mut escaped = false;
    for (at, character) in text.char_indices().skip(1) {
        if character == quote && !escaped {
            return at + character.len_utf8();
        }
        escaped = character == '\\' && !escaped;
    }
    text.len()
}

/// Every path in the text, from the crate's root (`crate::…`) or an outer crate.
fn paths(module: &[String], tokens: &[String]) -> Vec<Vec<String>> {
    let mut found = Vec::new();
    // Modules written in this file, with the depth of their braces.
    let mut inner: Vec<(String, usize)> = Vec::new();
    let mut depth = 0;
    let mut at = 0;
    while at < tokens.len() {
        match tokens[at].as_str() {
            "{" => {
                depth += 1;
                if at >= 2 && tokens[at - 2] == "mod" {
                    inner.push((tokens[at - 1].clone(), depth));
                }
            }
            "}" => {
                inner.pop_if(|(_, opened)| *opened == depth);
                depth -= 1;
            }
            _ if is_name(&tokens[at]) && tokens.get(at + 1).is_some_and(|next| next == "::") => {
                let here: Vec<String> =
                    module.iter().cloned().chain(inner.iter().map(|(name, _)| name.clone())).collect();
                at = path_tree(tokens, at, &[], &here, &mut found);
                continue;
            }
            _ => {}
        }
        at += 1;
    }
    found
}

/// Keywords that may stand before a path from an outer crate, `::bevy::pbr`.
const KEYWORDS: [&str; 9] = ["as", "dyn", "for", "impl", "in", "mut", "return", "use", "where"];

fn is_name(token: &str) -> bool {
    token.starts_with(|first: char| first.is_alphabetic() || first == '_') && !KEYWORDS.contains(&token)
}

/// Reads `a::b::{c, d::e}` from `at` on, adds its leaves and returns where it ends.
fn path_tree(
    tokens: &[String],
    mut at: usize,
    prefix: &[String],
    here: &[String],
    found: &mut Vec<Vec<String>>,
) -> usize {
    let mut path = prefix.to_vec();
    while let Some(token) = tokens.get(at) {
        if token == "{" && !path.is_empty() {
            at += 1;
            while tokens.get(at).is_some_and(|token| token != "}") {
                at = path_tree(tokens, at, &path, here, found).max(at + 1);
            }
            return at + 1;
        }
        if !is_name(token) && token != "*" {
            break;
        }
        path.push(token.clone());
        at += 1;
        if tokens.get(at).is_none_or(|next| next != "::") {
            break;
        }
        at += 1;
    }
    if !path.is_empty() {
        found.push(from_root(path, here));
    }
    at
}

/// `super::super::x` in `[physics, collision]` is `crate::x`.
fn from_root(path: Vec<String>, here: &[String]) -> Vec<String> {
    if !["super", "self"].contains(&path[0].as_str()) {
        return path;
    }
    let mut absolute: Vec<String> = std::iter::once("crate".into()).chain(here.iter().cloned()).collect();
    for name in path {
        match name.as_str() {
            "super" => {
                absolute.pop();
            }
            "self" => {}
            _ => absolute.push(name),
        }
    }
    absolute
}
