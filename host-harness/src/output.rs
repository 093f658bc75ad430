//! Where results go: never half a file, and never over an earlier result unasked.
//!
//! A run may take minutes and a result may have been waited for; so whether it may be written is
//! asked before the work starts, and each file appears whole under its name or not at all.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::log::compressed;
use crate::verb::Failure;

/// Temporary files start with this, so that what an interrupted run left is told from a result.
const PREFIX: &str = ".joint-";

/// A folder of results.
#[derive(Clone, Debug)]
pub struct OutDir {
    path: PathBuf,
}

impl OutDir {
    /// A folder to write into: absent, empty, or, with `force`, one whose files of the same names
    /// are replaced while every other file stays.
    ///
    /// # Errors
    /// It holds something already, or it is not a folder.
    pub fn new(path: &Path, force: bool) -> Result<Self, Failure> {
        let shown = path.display();
        let unreadable =
            |error: io::Error| Failure::input(format!("{shown}: cannot be read: {error}"));
        match fs::read_dir(path) {
            Ok(entries) => {
                for entry in entries {
                    let name = entry.map_err(unreadable)?.file_name();
                    if !force && !name.to_string_lossy().starts_with(PREFIX) {
                        return Err(Failure::input(format!(
                            "{shown}: holds a result already\n  help: choose another folder, or replace it with --force"
                        )));
                    }
                }
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(error) if error.kind() == io::ErrorKind::NotADirectory => {
                return Err(Failure::input(format!(
                    "{shown}: is a file\n  help: --out takes a folder here"
                )));
            }
            Err(error) => return Err(unreadable(error)),
        }
        Ok(Self { path: path.to_owned() })
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes one file of the result, whole; the folder is made where it is missing.
    ///
    /// # Errors
    /// The file system refuses.
    pub fn write(&self, name: &str, contents: impl AsRef<[u8]>) -> Result<PathBuf, Failure> {
        let path = self.path.join(name);
        put(&path, contents.as_ref(), true)?;
        Ok(path)
    }

    /// A folder inside this one, under the same rule as the whole.
    ///
    /// # Errors
    /// It holds something already, or it is not a folder.
    pub fn folder(&self, name: &str, force: bool) -> Result<OutDir, Failure> {
        Self::new(&self.path.join(name), force)
    }
}

/// A single file of results.
#[derive(Clone, Debug)]
pub struct OutFile {
    path: PathBuf,
    force: bool,
}

impl OutFile {
    /// A file to write: absent, or, with `force`, one to replace.
    ///
    /// # Errors
    /// It is there already, or it is a folder.
    pub fn new(path: &Path, force: bool) -> Result<Self, Failure> {
        let shown = path.display();
        if path.is_dir() {
            return Err(Failure::input(format!(
                "{shown}: is a folder\n  help: --out takes a file here"
            )));
        }
        if !force && path.symlink_metadata().is_ok() {
            return Err(already_there(path));
        }
        Ok(Self { path: path.to_owned(), force })
    }

    /// Writes a table, compressed where the file's name ends in `.gz`.
    ///
    /// # Errors
    /// As [`OutFile::write`].
    pub fn write_table(&self, text: String) -> Result<PathBuf, Failure> {
        match self.path.extension().is_some_and(|extension| extension == "gz") {
            true => self.write(compressed(&text)),
            false => self.write(text),
        }
    }

    /// Writes the file, whole.
    ///
    /// # Errors
    /// The file system refuses, or another has written the file meanwhile.
    pub fn write(&self, contents: impl AsRef<[u8]>) -> Result<PathBuf, Failure> {
        put(&self.path, contents.as_ref(), self.force)?;
        Ok(self.path.clone())
    }
}

fn already_there(path: &Path) -> Failure {
    let shown = path.display();
    Failure::input(format!(
        "{shown}: is there already\n  help: choose another name, or replace it with --force"
    ))
}

/// Writes beside the target and moves into place.
fn put(path: &Path, contents: &[u8], replace: bool) -> Result<(), Failure> {
    let refused = |error: io::Error| {
        Failure::input(format!("{}: cannot be written: {error}", path.display()))
    };
    let folder = match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    fs::create_dir_all(folder).map_err(refused)?;
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX);
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut file = builder.tempfile_in(folder).map_err(refused)?;
    file.write_all(contents).and_then(|()| file.as_file().sync_all()).map_err(refused)?;
    let placed = if replace { file.persist(path) } else { file.persist_noclobber(path) };
    placed.map(drop).map_err(|error| match error.error.kind() {
        io::ErrorKind::AlreadyExists => already_there(path),
        _ => refused(error.error),
    })
}
