//! The documents say what is there. In `docs/architecture.md` a path in backticks is followed by what that file defines,
//! in the form `src/physics/plugin.rs` `fn step`, until the next path or the end of the paragraph, list item or row.

use std::fs;
use std::path::Path;

/// What paths of this repository begin with.
const FOLDERS: [&str; 6] = ["src/", "tests/", "docs/", "assets/", "benches/", "peers/"];

/// What a name is told to be.
const KINDS: [&str; 6] = ["fn", "struct", "enum", "trait", "const", "static"];

/// Most hops of a way that can be told.
const MOST_HOPS: usize = 10;

fn read(path: &str) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    fs::read_to_string(root.join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

fn exists(path: &str) -> bool {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path).exists()
}

/// Paragraphs, list items and rows of a table, each on one line.
fn blocks(text: &str) -> Vec<String> {
    let mut blocks = vec![String::new()];
    for line in text.lines() {
        let is_item = line.starts_with("- ") || line.starts_with('|') || number_of(line).is_some();
        if line.trim().is_empty() || is_item {
            blocks.push(String::new());
        }
        let block = blocks.last_mut().expect("never empty");
        block.push_str(line.trim());
        block.push(' ');
    }
    blocks
}

/// The number of a numbered list item.
fn number_of(line: &str) -> Option<usize> {
    line.split_once(". ")?.0.parse().ok()
}

/// What stands in backticks.
fn spans(text: &str) -> impl Iterator<Item = &str> {
    text.split('`').skip(1).step_by(2)
}

fn is_path(span: &str) -> bool {
    FOLDERS.iter().any(|folder| span.starts_with(folder))
}

/// The kind and the name where a span is one.
fn definition(span: &str) -> Option<(&str, &str)> {
    span.split_once(' ').filter(|(kind, name)| KINDS.contains(kind) && !name.contains(' '))
}

/// Whether a source has a line, comments aside, that defines it.
fn defines(source: &str, kind: &str, name: &str) -> bool {
    let wanted = format!("{kind} {name}");
    source.lines().filter(|line| !line.trim_start().starts_with("//")).any(|line| {
        line.match_indices(&wanted).any(|(at, _)| {
            let is_word = |c: char| c.is_alphanumeric() || c == '_';
            !line[..at].ends_with(is_word) && !line[at + wanted.len()..].starts_with(is_word)
        })
    })
}

/// Paths that do not exist, names that their file does not define, names without a file.
fn untrue(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    for block in blocks(text) {
        let mut file = None;
        for span in spans(&block) {
            if is_path(span) {
                file = Some(span);
                if !exists(span) {
                    found.push(format!("`{span}` does not exist"));
                }
            } else if let Some((kind, name)) = definition(span) {
                match file {
                    None => found.push(format!("`{span}` has no file before it: {block}")),
                    Some(file) if !file.ends_with(".rs") => found.push(format!("`{file}` `{span}`: no file of Rust")),
                    Some(file) if exists(file) && !defines(&read(file), kind, name) => {
                        found.push(format!("`{file}` does not define `{span}`"));
                    }
                    Some(_) => {}
                }
            }
        }
    }
    found
}

/// Links of a document to files that are not there; the document lies in `folder`.
fn broken_links(text: &str, folder: &str) -> Vec<String> {
    let targets = text.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(target, _)| target);
    let files = targets.filter(|target| !target.contains("://")).map(|target| target.split('#').next().unwrap_or(""));
    files.filter(|file| !exists(&format!("{folder}{file}"))).map(str::to_owned).collect()
}

/// The numbered items under a heading.
fn hops(text: &str, heading: &str) -> Vec<String> {
    let section = text.split(&format!("\n{heading}\n")).nth(1).unwrap_or_else(|| panic!("no heading '{heading}'"));
    let section = section.split("\n#").next().unwrap_or(section);
    blocks(section).into_iter().filter(|block| number_of(block).is_some()).collect()
}

#[test]
fn what_the_architecture_names_is_there() {
    let problems = untrue(&read("docs/architecture.md"));
    assert!(problems.is_empty(), "docs/architecture.md:\n{}", problems.join("\n"));
}

#[test]
fn the_ways_of_a_contact_and_of_a_joint_are_short_and_name_a_function_at_each_hop() {
    let text = read("docs/architecture.md");
    for heading in ["## The way of one contact", "## The way of one joint"] {
        let hops = hops(&text, heading);
        assert!((5..=MOST_HOPS).contains(&hops.len()), "{heading}: {} hops", hops.len());
        for hop in hops {
            let names_file = spans(&hop).any(|span| is_path(span) && span.ends_with(".rs"));
            assert!(names_file && spans(&hop).any(|span| definition(span).is_some()), "{heading}: {hop}");
        }
    }
}

#[test]
fn files_and_folders_in_the_picture_are_there() {
    let picture = read("docs/architecture.svg");
    let texts = picture.split("</text>").filter_map(|text| text.rsplit_once('>')).map(|(_, text)| text);
    let words = texts.flat_map(|text| text.split(|c: char| c.is_whitespace() || [':', ',', ';'].contains(&c)));
    let paths: Vec<_> = words.filter(|word| word.ends_with('/') || word.ends_with(".rs")).collect();
    assert!(paths.len() > 10, "only {} paths found", paths.len());
    for path in paths {
        assert!(exists(path) || exists(&format!("src/physics/{path}")), "docs/architecture.svg: {path} does not exist");
    }
}

#[test]
fn links_of_the_documents_lead_somewhere() {
    for (document, folder) in [
        ("README.md", ""),
        ("docs/architecture.md", "docs/"),
        ("docs/accuracy.md", "docs/"),
        ("docs/performance.md", "docs/"),
    ] {
        let broken = broken_links(&read(document), folder);
        assert!(broken.is_empty(), "{document}: no such file: {}", broken.join(", "));
    }
    assert!(read("README.md").contains("](docs/architecture.md)"), "README.md does not link docs/architecture.md");
}

#[test]
fn what_is_not_there_is_told() {
    assert!(defines("    pub(crate) fn step(&self) {", "fn", "step"));
    for other in ["fn steps() {", "// fn step() is elsewhere", "struct step;"] {
        assert!(!defines(other, "fn", "step"), "{other}");
    }
    let file = "src/physics/plugin.rs";
    assert_eq!(untrue(&format!("`{file}` `fn step` and\n`struct PhysicsPlugin`")), Vec::<String>::new());
    assert_eq!(untrue("1. `src/nowhere.rs`: a hop\n   on two lines").len(), 1);
    assert_eq!(untrue(&format!("`{file}` `fn stop`")).len(), 1);
    // The next item does not go on with the last one's file.
    assert_eq!(untrue(&format!("- `{file}` `fn step`\n- `fn step`")).len(), 1);
    assert_eq!(untrue("`src/physics/` `fn step`").len(), 1);
    assert_eq!(broken_links("[a](nowhere.md#there), [b](#here), [c](https://x.org/y)", "docs/"), ["nowhere.md"]);
}
