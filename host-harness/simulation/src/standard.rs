//! Standard input and output in the place of a file, by the name `-`.
//!
//! A log is read more than once: for its samples, for the line that a message points at, and for its hash.
//! Standard input is there once, so its bytes are kept. Standard output holds one thing, so that whoever
//! reads it gets a whole file or one object and nothing between.

use std::io::{self, Read, Write};
use std::path::Path;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::log::MOST_BYTES;

static INPUT: OnceLock<Result<Vec<u8>, (io::ErrorKind, String)>> = OnceLock::new();
static OUTPUT_TAKEN: AtomicBool = AtomicBool::new(false);

/// Whether a path stands for standard input or output.
pub fn is(path: &Path) -> bool {
    path == Path::new("-")
}

/// What messages call a file that is read.
pub fn name(path: &Path) -> String {
    if is(path) { "standard input".to_owned() } else { path.display().to_string() }
}

/// The bytes of standard input, to its end; no more than one past the largest log.
///
/// # Errors
/// It cannot be read.
pub fn input() -> io::Result<&'static [u8]> {
    let read = || {
        let mut bytes = Vec::new();
        let all = io::stdin().lock().take(MOST_BYTES + 1).read_to_end(&mut bytes);
        all.map(|_| bytes).map_err(|error| (error.kind(), error.to_string()))
    };
    match INPUT.get_or_init(read) {
        Ok(bytes) => Ok(bytes),
        Err((kind, what)) => Err(io::Error::new(*kind, what.clone())),
    }
}

/// Takes standard output for a file; false where another has it.
pub fn take_output() -> bool {
    !OUTPUT_TAKEN.swap(true, Ordering::Relaxed)
}

/// Whether standard output holds a file.
pub fn is_output_taken() -> bool {
    OUTPUT_TAKEN.load(Ordering::Relaxed)
}

/// Writes a file to standard output; a reader that has gone away is no error of ours.
pub fn write(contents: &[u8]) -> io::Result<()> {
    let mut output = io::stdout().lock();
    match output.write_all(contents).and_then(|()| output.flush()) {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        other => other,
    }
}
