//! The checker itself, on small crates with and without circles.

use std::collections::BTreeMap;

use super::circles::{self, Arrows};
use super::layers;
use super::tree::Tree;

fn parse(files: &[(&str, &str)]) -> Tree {
    let files: BTreeMap<String, String> = files.iter().map(|&(name, text)| (name.into(), text.into())).collect();
    let tree = Tree::parse(&files);
    assert!(tree.problems.is_empty(), "{:?}", tree.problems);
    tree
}

/// The circles as they are told.
fn told(files: &[(&str, &str)]) -> Vec<String> {
    let tree = parse(files);
    Arrows::of(&tree).circles().iter().map(ToString::to_string).collect()
}

#[test]
fn a_circle_of_two_is_told_with_its_names() {
    let found = told(&[
        ("lib.rs", "mod a; mod b;"),
        ("a.rs", "use crate::b::{Width, height}; pub struct Length;"),
        ("b.rs", "use super::a::Length; pub struct Width; pub fn height() {}"),
    ]);
    assert_eq!(
        found,
        ["2 files import each other in a circle. The shortest way round:\n    \
         src/a.rs → src/b.rs: crate::b::Width, crate::b::height\n    \
         src/b.rs → src/a.rs: super::a::Length\n"]
    );
}

#[test]
fn the_shortest_way_round_a_large_circle_comes_first() {
    let found = told(&[
        ("lib.rs", "mod a; mod b; mod c; mod d;"),
        ("a.rs", "use crate::b::B; pub struct A;"),
        ("b.rs", "use crate::c::C; use crate::d::D; pub struct B;"),
        ("c.rs", "use crate::a::A; pub struct C;"),
        ("d.rs", "use crate::b::B; pub struct D;"),
    ]);
    let lines: Vec<&str> = found[0].lines().map(str::trim).collect();
    let head = "4 files import each other in a circle. The shortest way round:";
    let short = ["src/b.rs → src/d.rs: crate::d::D", "src/d.rs → src/b.rs: crate::b::B"];
    assert_eq!(lines[..4], [head, short[0], short[1], "All arrows among them:"]);
    assert_eq!(lines.len(), 4 + 5, "{lines:?}");
}

#[test]
fn every_way_of_importing_closes_a_circle_of_three() {
    // `a → b → c`, and from `c` back to `a` in a way of its own.
    for back in [
        "use crate::a::A;",
        "use super::super::a::A;",
        "use super::A;",
        "use crate::deep::Renamed;",
        "use crate::Far as _;",
        "use crate::a; fn f() { a::f(); }",
        "use crate::a::{self}; type T = a::A;",
        "fn f() -> crate::a::A { todo!() }",
        "fn f() { use crate::a; a::f(); }",
        "fn f() { assert!(crate::a::f() == 1, \"{}\", 2); }",
        "macro_rules! m { () => { $crate::a::f() }; }",
        "macro_rules! m { () => { use crate::a::{f, A}; }; }",
        "fn f() { made!(); }",
        "impl super::super::a::Trait for u8 {}",
        "#[derive(Clone)] struct S { field: Option<Vec<crate::a::A>> }",
        "#[attribute(with = crate::a::f)] struct S;",
        "use plumb::a::A;",
        "use crate::a::Made;",
        "pub(crate) use crate::a::A;",
        "mod inner { use super::super::super::a::A; }",
    ] {
        let found = told(&[
            ("lib.rs", "mod a; mod b; mod deep; pub use a::A as Far;"),
            ("main.rs", "use plumb::Far;"),
            (
                "a.rs",
                "use crate::b::B; pub struct A; pub trait Trait {} pub fn f() -> i32 { 1 } make_struct!(Made);
                 macro_rules! unused { () => {} }",
            ),
            ("b.rs", "pub struct B(crate::deep::c::C);"),
            ("deep/mod.rs", "pub mod c; use crate::a::A; use A as Renamed; macro_rules! made { () => {} }"),
            ("deep/c.rs", back),
        ]);
        let files = if back.contains("made!") { 4 } else { 3 };
        assert_eq!(found.len(), 1, "{back}");
        assert!(found[0].starts_with(&format!("{files} files")), "{back}: {}", found[0]);
    }
}

#[test]
fn re_exports_lead_to_the_file_that_defines() {
    // `shape` re-exports both its children; `ball` needs `size` alone.
    let through = |ball: &str, shape: &str| {
        let shape = format!("mod ball; mod size; pub use ball::Ball; pub use size::Size; {shape}");
        told(&[
            ("lib.rs", "mod shape; pub use shape::Size;"),
            ("shape/mod.rs", &shape),
            ("shape/ball.rs", ball),
            ("shape/size.rs", "pub struct Size; pub fn unit() -> Size { Size }"),
        ])
    };
    let none: [String; 0] = [];
    assert_eq!(through("use super::Size; pub struct Ball;", ""), none);
    assert_eq!(through("use crate::Size; pub struct Ball;", ""), none);
    assert_eq!(
        through("use super::size::{self, Size}; pub struct Ball(size::Size);", "pub use size::unit as one;"),
        none
    );
    assert_eq!(through("pub struct Ball(super::Size);", "pub fn plugin() { ball::Ball; }"), none);
    // What the parent defines is the parent's.
    assert_eq!(through("use super::LARGEST; pub struct Ball;", "pub const LARGEST: f64 = 1.0;").len(), 1);
    assert_eq!(through("pub struct Ball; fn f() { super::plugin(); }", "pub fn plugin() {}").len(), 1);
}

#[test]
fn a_circle_through_a_re_export_is_told_by_the_files_that_define() {
    let found = told(&[
        ("lib.rs", "mod near; mod far;"),
        ("near.rs", "use crate::far::Renamed; pub struct Near;"),
        ("far/mod.rs", "mod inside; pub use inside::Far as Renamed;"),
        ("far/inside.rs", "use crate::near::Near; pub struct Far;"),
    ]);
    assert_eq!(found.len(), 1);
    assert!(found[0].contains("src/near.rs → src/far/inside.rs: crate::far::Renamed"), "{}", found[0]);
    assert!(!found[0].contains("far/mod.rs"), "{}", found[0]);
}

#[test]
fn what_is_no_arrow_closes_no_circle() {
    // `b` imports from `a`; nothing of this in `a` is an import from `b`.
    for text in [
        "",
        "use super::a::A as Same;",
        "// use crate::b::B;\nconst TEXT: &str = \"crate::b::B\";",
        "/// [`B`](crate::b::B)\npub struct Documented;",
        "#[cfg(test)] mod tests { use crate::b::B; use super::*; }",
        "#[cfg(all(test, feature = \"lab\"))] use crate::b::B;",
        "#[cfg(test)] fn f() -> crate::b::B { todo!() }",
        "impl A { #[cfg(test)] fn f() -> crate::b::B { todo!() } }",
        "#[cfg(test)] mod tests;",
        "use crate::b;",
        "pub(in crate::b) struct S;",
        "use b::B;",
        "use ::b::B;",
        "use other::b::B; type T = B;",
        "use crate::b; fn f() { enum b { B } b::B; }",
        "macro_rules! m { ($b:ident) => { $b::B }; }",
    ] {
        let found = told(
            &[
                ("lib.rs", "mod a; mod b;"),
                ("a.rs", &format!("{text} pub struct A;")),
                ("b.rs", "use crate::a::A; pub struct B(A);"),
                ("a/tests.rs", "use crate::b::B; use super::*;"),
            ][..if text.ends_with("tests;") { 4 } else { 3 }],
        );
        assert!(found.is_empty(), "{text}: {found:?}");
    }
}

#[test]
fn globs_are_refused_outside_tests() {
    let globs = |text: &str| {
        let tree = parse(&[("lib.rs", "mod a; mod b;"), ("a.rs", text), ("b.rs", "pub enum B { One }")]);
        circles::globs(&tree)
    };
    assert_eq!(globs("use super::*;"), ["src/a.rs: super::*"]);
    assert_eq!(globs("pub use crate::b::*;"), ["src/a.rs: crate::b::*"]);
    assert_eq!(globs("use crate::b::{B::*};"), ["src/a.rs: crate::b::B::*"]);
    assert_eq!(globs("use crate::b; fn f() { use b::*; }"), ["src/a.rs: b::*"]);
    let none: [String; 0] = [];
    assert_eq!(globs("use bevy::prelude::*; use ::b::*;"), none);
    assert_eq!(globs("#[cfg(test)] mod tests { use super::*; }"), none);
}

#[test]
fn files_that_cannot_be_placed_are_told() {
    let problems = |files: &[(&str, &str)]| {
        let files = files.iter().map(|&(name, text)| (name.into(), text.into())).collect();
        Tree::parse(&files).problems
    };
    assert_eq!(problems(&[("lib.rs", ""), ("a.rs", "")]), ["src/a.rs: no module declares it"]);
    assert_eq!(problems(&[("lib.rs", "mod a;")]), ["src/a.rs: declared, but not there"]);
    assert!(problems(&[("lib.rs", "fn f( {}")])[0].starts_with("src/lib.rs: "));
}

#[test]
fn every_way_of_naming_a_higher_layer_is_seen() {
    let in_physics = |text: &str| {
        layers::violations(&parse(&[
            ("lib.rs", "mod physics;"),
            ("physics/mod.rs", "mod collision;"),
            ("physics/collision.rs", text),
        ]))
    };
    for text in [
        "use crate::scene::SceneSpec;",
        "use crate::{physics::step, lab};",
        "use crate::{self as plumb_root, sandbox::launch};",
        "fn f() { crate::lab::measure(); }",
        "fn f() { assert!(crate::lab::measure()); }",
        "use super::super::scene;",
        "use super::{body, super::lab};",
        "mod tests { use super::super::super::sandbox::launch; }",
        "#[cfg(test)] mod tests { use super::super::super::sandbox::launch; }",
        "use plumb::scene::find;",
        "use bevy::render::mesh;",
        "use bevy::{prelude::*, window::Window};",
        "use ::bevy::pbr;",
        "use bevy_egui::egui;",
        "use egui;",
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
    let in_lab = |text: &str| layers::violations(&parse(&[("lib.rs", "mod lab;"), ("lab.rs", text)]));
    assert_eq!(in_lab("use crate::sandbox::launch;"), ["src/lab.rs: crate::sandbox::launch"]);
    assert_eq!(in_lab("use crate::scene; use crate::physics;"), Vec::<String>::new());
}
