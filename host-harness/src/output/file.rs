//! A single file of results.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::{PREFIX, folder_of, is_same, nearest, over_an_input, unwritable};
use crate::failure::Failure;
use crate::log::compressed;
use crate::standard;

/// A single file of results.
#[derive(Clone, Debug)]
pub struct OutFile {
    path: PathBuf,
    force: bool,
}

impl OutFile {
    /// A file to write: absent, or, with `force`, one to replace; `-` is standard output.
    ///
    /// # Errors
    /// It is there already, it is a folder or a device, or nothing can be written there.
    pub fn new(path: &Path, force: bool) -> Result<Self, Failure> {
        if standard::is(path) {
            return Ok(Self { path: path.to_owned(), force });
        }
        let shown = path.display();
        if path.is_dir() {
            return Err(Failure::input(format!(
                "{shown}: is a folder\n  help: --out takes a file here"
            )));
        }
        if path.exists() && !path.is_file() {
            return Err(Failure::input(format!(
                "{shown}: is no file that can be replaced\n  help: --out takes a file here"
            )));
        }
        if !force && path.symlink_metadata().is_ok() {
            return Err(already_there(path));
        }
        tempfile::Builder::new()
            .prefix(PREFIX)
            .tempfile_in(nearest(path))
            .map_err(|error| unwritable(path, &error))?;
        Ok(Self { path: path.to_owned(), force })
    }

    /// The same if it is none of the files that are read.
    ///
    /// # Errors
    /// It is one of them.
    pub fn apart_from<'a>(
        self,
        inputs: impl IntoIterator<Item = &'a PathBuf>,
    ) -> Result<Self, Failure> {
        match inputs.into_iter().any(|input| is_same(&self.path, input)) {
            true => Err(over_an_input(&self.path)),
            false => Ok(self),
        }
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

    /// Writes the file, whole: beside its place, and then moved there.
    ///
    /// # Errors
    /// The file system refuses, or another has written the file meanwhile.
    pub fn write(&self, contents: impl AsRef<[u8]>) -> Result<PathBuf, Failure> {
        let path = &self.path;
        let refused = |error: io::Error| unwritable(path, &error);
        if standard::is(path) {
            standard::write(contents.as_ref()).map_err(refused)?;
            return Ok(path.clone());
        }
        let folder = folder_of(path);
        fs::create_dir_all(folder).map_err(refused)?;
        let mut builder = tempfile::Builder::new();
        builder.prefix(PREFIX);
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let mut file = builder.tempfile_in(folder).map_err(refused)?;
        file.write_all(contents.as_ref())
            .and_then(|()| file.as_file().sync_all())
            .map_err(refused)?;
        let placed = if self.force { file.persist(path) } else { file.persist_noclobber(path) };
        placed.map_err(|error| match error.error.kind() {
            io::ErrorKind::AlreadyExists => already_there(path),
            _ => refused(error.error),
        })?;
        super::settle(folder);
        Ok(path.clone())
    }
}

fn already_there(path: &Path) -> Failure {
    let shown = path.display();
    Failure::input(format!(
        "{shown}: is there already\n  help: choose another name, or replace it with --force"
    ))
}
