//! The page of settings says what the doc comments say.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use plumb::physics::{Method, SETTINGS};

const HEAD: &str = "\
# Settings

What a settings file may say, `(method: exact, hz: 120)`, everything else as in the default preset. A setting that is
written, in a file or on the command line, and that the method does not read is refused. This page is made of the doc
comments in `src/physics/settings` and held to them by a test, which says where it left a new one.

";

fn page() -> String {
    let mut page = HEAD.to_owned();
    for setting in SETTINGS {
        let methods: Vec<_> = setting.methods().map(|method| format!("`{}`", method.name())).collect();
        let readers = if methods.len() == Method::ALL.len() { "every method".into() } else { methods.join(", ") };
        let with = setting.with().map(|other| format!(", with `{other}`")).unwrap_or_default();
        // Writing to a string does not fail.
        let _ = write!(page, "## {}\n\n{}\n\nRead by {readers}{with}.\n\n", setting.name, setting.help());
        for choice in setting.choices {
            let _ = writeln!(page, "- `{}`: {}", choice.name, choice.help());
        }
        page += if setting.choices.is_empty() { "" } else { "\n" };
    }
    page
}

#[test]
fn the_page_of_settings_is_up_to_date() {
    let known = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/settings.md")).unwrap_or_default();
    let page = page();
    if page.trim_end() != known.trim_end() {
        let new = Path::new(env!("CARGO_TARGET_TMPDIR")).join("settings.md");
        fs::write(&new, page).unwrap();
        panic!("docs/settings.md is to be as {}", new.display());
    }
}
