//! A folder of results.

use std::fs::{self, File, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use tempfile::TempDir;

use super::place::{DONE, FILES, NEW, place, sweep};
use super::{PREFIX, is_same, missing, over_an_input, settle, unwritable};
use crate::failure::Failure;
use crate::standard;

/// A folder of results, locked against other runs for as long as this one has it.
#[derive(Debug)]
pub struct OutDir {
    path: PathBuf,
    /// Folders made for it, the deepest first; removed where no result comes.
    made: Vec<PathBuf>,
    new: Option<TempDir>,
    names: Mutex<Vec<String>>,
    _lock: Option<File>,
}

impl OutDir {
    /// A folder to write into: absent, empty, or, with `force`, one whose earlier result is replaced
    /// while every other file stays.
    ///
    /// # Errors
    /// It holds something already, another run writes there, it is not a folder, or nothing can be
    /// written there.
    pub fn new(path: &Path, force: bool) -> Result<Self, Failure> {
        if standard::is(path) {
            return Err(Failure::input(
                "--out -: the result is several files\n  help: give a folder's name",
            ));
        }
        let shown = path.display();
        if path.exists() && !path.is_dir() {
            return Err(Failure::input(format!(
                "{shown}: is a file\n  help: --out takes a folder here"
            )));
        }
        let refused = |error: io::Error| unwritable(path, &error);
        let made = missing(path);
        fs::create_dir_all(path).map_err(refused)?;
        let mut out = Self {
            path: path.to_owned(),
            made,
            new: None,
            names: Mutex::default(),
            _lock: locked(path)?,
        };
        place(path).map_err(refused)?;
        if !force {
            out.is_free()?;
        }
        sweep(path).map_err(refused)?;
        let mut builder = tempfile::Builder::new();
        builder.prefix(NEW);
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o777));
        out.new = Some(builder.tempdir_in(path).map_err(refused)?);
        Ok(out)
    }

    fn is_free(&self) -> Result<(), Failure> {
        let shown = self.path.display();
        let unreadable =
            |error: io::Error| Failure::input(format!("{shown}: cannot be read: {error}"));
        for entry in fs::read_dir(&self.path).map_err(unreadable)? {
            let name = entry.map_err(unreadable)?.file_name();
            if !name.to_string_lossy().starts_with(PREFIX) {
                return Err(Failure::input(format!(
                    "{shown}: holds a result already\n  help: choose another folder, or replace it with --force"
                )));
            }
        }
        Ok(())
    }

    /// The same if none of its files of these names is one that is read.
    ///
    /// # Errors
    /// One of them is.
    pub fn apart_from<'a>(
        self,
        inputs: impl IntoIterator<Item = &'a PathBuf>,
        names: &[&str],
    ) -> Result<Self, Failure> {
        for input in inputs {
            if names.iter().any(|name| is_same(&self.path.join(name), input)) {
                return Err(over_an_input(input));
            }
        }
        Ok(self)
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Where a file can be read from: one of this result that is not in its place yet, from where it waits.
    pub fn readable(&self, path: &Path) -> PathBuf {
        let waiting = self.new.as_ref().zip(path.strip_prefix(&self.path).ok());
        let waiting =
            waiting.map(|(new, name)| new.path().join(name)).filter(|file| file.is_file());
        waiting.unwrap_or_else(|| path.to_owned())
    }

    /// Writes one file of the result. It is in its place once the result is [finished](Self::finish).
    ///
    /// # Errors
    /// The file system refuses.
    pub fn write(&self, name: &str, contents: impl AsRef<[u8]>) -> Result<PathBuf, Failure> {
        let path = self.path.join(name);
        let Some(new) = &self.new else { return Ok(path) };
        let written = File::create(new.path().join(name)).and_then(|mut file| {
            file.write_all(contents.as_ref())?;
            file.sync_all()
        });
        written.map_err(|error| unwritable(&path, &error))?;
        self.names.lock().unwrap_or_else(PoisonError::into_inner).push(name.to_owned());
        Ok(path)
    }

    /// Puts the result in its place: all of it, or none. What only an earlier result of this program
    /// has left there is removed.
    ///
    /// # Errors
    /// The file system refuses.
    pub fn finish(mut self) -> Result<(), Failure> {
        let names = std::mem::take(self.names.get_mut().unwrap_or_else(PoisonError::into_inner));
        let Some(new) = self.new.take().filter(|_| !names.is_empty()) else { return Ok(()) };
        // A file cannot replace a folder: found out while the earlier result is whole.
        if let Some(name) = names.iter().find(|name| self.path.join(name).is_dir()) {
            let shown = self.path.join(name);
            return Err(Failure::input(format!(
                "{}: is a folder, where a file of the result goes\n  help: choose another --out",
                shown.display()
            )));
        }
        let refused = |error: io::Error| unwritable(&self.path, &error);
        let list = new.path().join(FILES);
        let listed = File::create(&list).and_then(|mut file| {
            file.write_all(names.join("\n").as_bytes())?;
            file.sync_all()
        });
        listed.map_err(refused)?;
        settle(new.path());
        fs::rename(new.path(), self.path.join(DONE)).map_err(refused)?;
        // From here on it is a result.
        let _ = new.keep();
        self.made.clear();
        settle(&self.path);
        place(&self.path).map_err(refused)
    }

    /// A folder inside this one, under the same rule as the whole.
    ///
    /// # Errors
    /// As [`OutDir::new`].
    pub fn folder(&self, name: &str, force: bool) -> Result<OutDir, Failure> {
        Self::new(&self.path.join(name), force)
    }
}

impl Drop for OutDir {
    fn drop(&mut self) {
        self.new.take();
        for folder in &self.made {
            // Only where nothing is in there.
            let _ = fs::remove_dir(folder);
        }
    }
}

/// The folder, locked; `None` where the file system knows no locks.
fn locked(path: &Path) -> Result<Option<File>, Failure> {
    // A folder cannot be opened as a file everywhere.
    let Ok(folder) = File::open(path) else { return Ok(None) };
    match folder.try_lock() {
        Ok(()) => Ok(Some(folder)),
        Err(TryLockError::WouldBlock) => Err(Failure::input(format!(
            "{}: another run writes there at this moment\n  help: wait for it, or choose another folder",
            path.display()
        ))),
        Err(TryLockError::Error(_)) => Ok(None),
    }
}
