//! How the files of a result come to their places.
//!
//! They are written into a folder within the result's, [`NEW`]; one move renames it to [`DONE`], and from
//! then on the new result is the one that counts: its files are moved to their places, after those that
//! only the earlier result had are removed, and the list of its files is moved last. Who finds a
//! [`DONE`] finds a run that was killed meanwhile, and goes on from there.

use std::collections::HashSet;
use std::fs;
use std::io;
use std::path::Path;

use super::{is_plain, settle};

/// How folders of files that are not yet a result start.
pub(super) const NEW: &str = ".joint-new-";
/// The folder of files that are a result but not yet in their places.
pub(super) const DONE: &str = ".joint-done";
/// The list of the files of a result, in its folder: what a later run may remove.
pub(super) const FILES: &str = ".joint-files";

/// The files of the result in a folder, by its list.
fn listed(folder: &Path) -> HashSet<String> {
    let list = fs::read_to_string(folder.join(FILES)).unwrap_or_default();
    list.lines().filter(|name| is_plain(name)).map(str::to_owned).collect()
}

/// Moves a result that is done to its place; nothing, where there is none.
pub(super) fn place(folder: &Path) -> io::Result<()> {
    let done = folder.join(DONE);
    if !done.exists() {
        return Ok(());
    }
    if done.join(FILES).exists() {
        let new = listed(&done);
        for name in listed(folder).difference(&new) {
            match fs::remove_file(folder.join(name)) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
                _ => {}
            }
        }
        for name in new {
            match fs::rename(done.join(&name), folder.join(&name)) {
                // Moved before the run was killed.
                Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
                _ => {}
            }
        }
        fs::rename(done.join(FILES), folder.join(FILES))?;
    }
    settle(folder);
    fs::remove_dir_all(&done)
}

/// Removes what killed runs have left before they were done.
pub(super) fn sweep(folder: &Path) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let left = entry.file_name().to_string_lossy().starts_with(NEW);
        if left && entry.file_type()?.is_dir() {
            fs::remove_dir_all(entry.path())?;
        }
    }
    Ok(())
}
