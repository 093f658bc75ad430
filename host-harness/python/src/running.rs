//! Long work beside the interpreter: the lock is released, and an interrupt is heard.
//!
//! A fit takes seconds to minutes. It runs in a thread of its own, so that this one can ask Python ten
//! times a second whether Ctrl-C was pressed. The search then concludes at its next step, its answer is
//! dropped, and `KeyboardInterrupt` is raised. The request is one for the whole process: every run that is
//! under way ends with it, and it is taken back when the last one has.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use host_harness::interrupt;
use pyo3::exceptions::{PyKeyboardInterrupt, PyRuntimeError};
use pyo3::prelude::*;

/// How often Python is asked.
const EVERY: Duration = Duration::from_millis(100);

static RUNNING: AtomicUsize = AtomicUsize::new(0);

/// One run under way.
struct Run;

impl Run {
    fn new() -> Self {
        RUNNING.fetch_add(1, Ordering::SeqCst);
        Self
    }
}

impl Drop for Run {
    fn drop(&mut self) {
        if RUNNING.fetch_sub(1, Ordering::SeqCst) == 1 {
            interrupt::clear();
        }
    }
}

/// What the work gives, done without the interpreter's lock.
pub(crate) fn running<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce() -> T + Send + 'static,
) -> PyResult<T> {
    let (send, receive) = channel();
    let run = Run::new();
    std::thread::spawn(move || {
        // Nobody waits any more where the interpreter has ended.
        let _ = send.send(work());
    });
    let mut asked = None;
    let (result, _receive) = {
        let mut receive = receive;
        loop {
            let waited;
            (waited, receive) = py.detach(move || (receive.recv_timeout(EVERY), receive));
            match waited {
                Ok(result) => break (Some(result), receive),
                Err(RecvTimeoutError::Disconnected) => break (None, receive),
                Err(RecvTimeoutError::Timeout) if asked.is_none() => {
                    if let Err(error) = py.check_signals() {
                        interrupt::ask();
                        asked = Some(error);
                    }
                }
                Err(RecvTimeoutError::Timeout) => {}
            }
        }
    };
    let interrupted = interrupt::asked();
    drop(run);
    match (asked, result) {
        (Some(error), _) => Err(error),
        (None, _) if interrupted => {
            Err(PyKeyboardInterrupt::new_err("another run was interrupted"))
        }
        (None, Some(result)) => Ok(result),
        (None, None) => Err(PyRuntimeError::new_err("the work ended without a result")),
    }
}
