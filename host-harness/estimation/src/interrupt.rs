//! Stopping early without losing what was found: the first interrupt asks the search to conclude,
//! the second quits.

use std::sync::atomic::{AtomicBool, Ordering};

static ASKED: AtomicBool = AtomicBool::new(false);

/// Turns interrupts into a request from now on.
pub fn watch() {
    // A handler that is there already, or a system without any, leaves interrupts as they are.
    let _ = ctrlc::set_handler(|| {
        if ASKED.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
        eprintln!("concluding from what is known so far; interrupt again to quit at once");
    });
}

/// Asks to stop: what a program does that has its own handler of interrupts.
pub fn ask() {
    ASKED.store(true, Ordering::Relaxed);
}

/// Takes the request back, for the next run in the same process.
pub fn clear() {
    ASKED.store(false, Ordering::Relaxed);
}

/// Whether the user asked to stop.
pub fn asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}
