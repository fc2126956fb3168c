//! Which file may import which: the layers `sandbox → lab → scene → physics`, no renderer below the sandbox, and no two
//! files that import each other, directly or round a corner. Read from the sources, since the modules of a single crate
//! could name each other freely.

mod circles;
mod layers;
mod planted;
mod tree;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::LazyLock;

use circles::Arrows;
use tree::Tree;

/// The crate, parsed once for all tests.
static CRATE: LazyLock<Tree> = LazyLock::new(|| {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = BTreeMap::new();
    collect(&root, &root, &mut files);
    Tree::parse(&files)
});

/// All `.rs` files below a folder, by their path from the root.
fn collect(root: &Path, folder: &Path, files: &mut BTreeMap<String, String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            collect(root, &path, files);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let name: Vec<_> = path.strip_prefix(root).unwrap().iter().map(|part| part.to_string_lossy()).collect();
            files.insert(name.join("/"), fs::read_to_string(&path).unwrap());
        }
    }
}

#[test]
fn every_file_is_read() {
    assert!(CRATE.problems.is_empty(), "{}", CRATE.problems.join("\n"));
    assert!(CRATE.files.len() > 200, "only {} files found", CRATE.files.len());
}

#[test]
fn layers_point_one_way() {
    let broken = layers::violations(&CRATE);
    assert!(broken.is_empty(), "a layer names what is above it:\n{}", broken.join("\n"));
}

#[test]
fn names_of_the_crate_are_imported_one_by_one() {
    let globs = circles::globs(&CRATE);
    assert!(globs.is_empty(), "a glob hides which file is imported; list the names instead:\n{}", globs.join("\n"));
}

#[test]
fn no_files_import_each_other_in_a_circle() {
    let told: Vec<String> = Arrows::of(&CRATE).circles().iter().map(ToString::to_string).collect();
    assert!(told.is_empty(), "{}", told.join("\n"));
}
