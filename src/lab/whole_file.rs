//! Files that are there whole or not at all.

use std::fs::{self, File};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

/// A file under another name beside its place, which is removed again where it does not come to that.
pub struct Draft {
    place: PathBuf,
    draft: PathBuf,
}

impl Draft {
    /// Begins the file that is to be at that place; what is written goes to the file that is handed back, or to
    /// [`path`](Self::path).
    ///
    /// # Errors
    /// The place names no file, or the file cannot be made.
    pub fn begin(place: &Path) -> io::Result<(Self, File)> {
        let name = place.file_name().ok_or_else(|| io::Error::new(ErrorKind::InvalidInput, "names no file"))?;
        // Of the same kind, by the end of its name.
        let draft = place.with_file_name(format!(".{}.{}", std::process::id(), name.to_string_lossy()));
        let file = File::create(&draft)?;
        Ok((Self { place: place.to_owned(), draft }, file))
    }

    /// Where it is until it has its place.
    pub fn path(&self) -> &Path {
        &self.draft
    }

    /// Where it is to be.
    pub fn place(&self) -> &Path {
        &self.place
    }

    /// Puts it there: whoever reads meanwhile sees the old file or the new one.
    ///
    /// # Errors
    /// The system refuses.
    pub fn finish(&self) -> io::Result<()> {
        fs::rename(&self.draft, &self.place)
    }
}

impl Drop for Draft {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.draft); // it has its place, or none
    }
}

/// Writes a text file under another name beside it, then puts it in its place: whoever reads
/// meanwhile, and whoever looks after a failure, sees the old text or the new one.
///
/// # Errors
/// The path names no file, or the folder or the file cannot be written.
pub fn write_whole(path: &Path, text: &str) -> io::Result<()> {
    let (draft, mut file) = Draft::begin(path)?;
    file.write_all(text.as_bytes())?;
    file.sync_all()?;
    draft.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<_> = entries.collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_is_replaced_and_nothing_is_left_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.ron");
        for text in ["the first, which is longer", "the second"] {
            write_whole(&path, text).unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), text);
            assert_eq!(names(folder.path()), ["a.ron"]);
        }
    }

    #[test]
    fn a_failure_leaves_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        let taken = folder.path().join("taken");
        fs::create_dir(&taken).unwrap();
        fs::write(taken.join("inside"), "").unwrap();
        write_whole(&taken, "text").unwrap_err();
        assert_eq!(names(folder.path()), ["taken"]);
        write_whole(&folder.path().join("no/such/folder.ron"), "text").unwrap_err();
        write_whole(Path::new("/"), "text").unwrap_err();
    }
}
