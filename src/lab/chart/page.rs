//! The page that shows all charts.

use std::fmt::Write as _;
use std::io;
use std::path::Path;

/// One chart on the page.
pub struct Entry {
    /// The picture's file stem.
    pub stem: String,
    /// Over it.
    pub title: String,
    /// What to see on it, in a sentence or two.
    pub remark: String,
    /// Runs that are not on it, each with its reason.
    pub dropped: Vec<String>,
}

/// Writes `index.html` into the folder of the pictures.
///
/// # Errors
/// The file cannot be written.
pub fn write_page(folder: &Path, entries: &[Entry]) -> io::Result<()> {
    std::fs::write(folder.join("index.html"), page(entries))
}

const HEAD: &str = r#"<!doctype html>
<html lang="en">
<meta charset="utf-8">
<title>Plumb: error against cost</title>
<style>
body { font: 16px/1.5 sans-serif; color: #282828; max-width: 980px; margin: 2em auto; padding: 0 1em; }
img { width: 100%; border: 1px solid #e2e2e2; }
h2 { margin-top: 2.5em; }
details { color: #555; font-size: 14px; }
</style>
<h1>Error against cost</h1>
<p>Every point is one run of a scene: to the left is cheaper, further down is nearer to the scene's
answer. Black rings and the black line mark the front: settings that no other beats on both. Faint
points failed the scene. Numbers behind the pictures: <a href="points.csv">points.csv</a>.</p>
"#;

fn page(entries: &[Entry]) -> String {
    let mut page = HEAD.to_owned();
    for Entry { stem, title, remark, dropped } in entries {
        let [title, remark] = [title, remark].map(|text| escape(text));
        // Writing to a string does not fail.
        let _ = write!(page, "<h2 id=\"{stem}\">{title}</h2>\n<p>{remark}</p>\n");
        let _ = writeln!(page, "<img src=\"{stem}.svg\" alt=\"error against cost: {title}\">");
        if !dropped.is_empty() {
            let _ = writeln!(page, "<details><summary>{} runs that failed</summary>\n<ul>", dropped.len());
            for reason in dropped {
                let _ = writeln!(page, "<li>{}</li>", escape(reason));
            }
            page.push_str("</ul></details>\n");
        }
    }
    page.push_str("</html>\n");
    page
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
