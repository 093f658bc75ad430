//! Where results go: never half a result, and never over an earlier one unasked.
//!
//! A run may take minutes and a result may have been waited for; so whether it may be written is
//! found out before the work starts, and a result appears whole or not at all: a file by one move, a
//! folder of files by one move that decides and as many that follow, which the next run would make good
//! if this one is killed between them ([`place`]).

mod dir;
mod file;
mod place;

use std::fs::{self, File};
use std::io;
use std::path::{Component, Path, PathBuf};

pub use dir::OutDir;
pub use file::OutFile;

use crate::failure::Failure;

/// What is not yet or no longer a result starts with this, so that what an interrupted run left is told
/// from one.
const PREFIX: &str = ".joint-";

/// That a path cannot be written.
fn unwritable(path: &Path, error: &io::Error) -> Failure {
    Failure::input(format!("{}: cannot be written: {error}", path.display()))
}

/// That an input would be overwritten.
fn over_an_input(path: &Path) -> Failure {
    Failure::input(format!(
        "{}: is read by this run, and would be overwritten\n  help: choose another --out",
        path.display()
    ))
}

/// Whether two paths lead to the same file; no, where one of them is not there.
fn is_same(one: &Path, other: &Path) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        let of = |path: &Path| fs::metadata(path).map(|own| (own.dev(), own.ino())).ok();
        of(one).is_some_and(|own| of(other) == Some(own))
    }
    #[cfg(not(unix))]
    {
        fs::canonicalize(one).is_ok_and(|own| fs::canonicalize(other).is_ok_and(|two| own == two))
    }
}

/// The folder that a path is in.
fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    }
}

/// The nearest folder above a path that is there.
fn nearest(path: &Path) -> &Path {
    let mut folder = folder_of(path);
    while !folder.exists() && folder != folder_of(folder) {
        folder = folder_of(folder);
    }
    folder
}

/// Whether a name is that of a file of a result: in the folder itself, and none of our own.
fn is_plain(name: &str) -> bool {
    let mut parts = Path::new(name).components();
    matches!((parts.next(), parts.next()), (Some(Component::Normal(_)), None))
        && !name.starts_with(PREFIX)
}

/// Makes what a folder's moves have changed survive a loss of power, where the system can.
fn settle(folder: &Path) {
    if let Ok(folder) = File::open(folder) {
        let _ = folder.sync_all();
    }
}

/// The folders that are missing on the way to a path, the deepest first, and it itself.
fn missing(path: &Path) -> Vec<PathBuf> {
    let absent = |own: &&Path| *own != Path::new("") && !own.exists();
    path.ancestors().take_while(absent).map(Path::to_owned).collect()
}
