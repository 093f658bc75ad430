//! The workflow: where a model and a log disagree, what is missing, and by how much the gap shrinks
//! when it is added. docs/discovery.md is the method; these are its steps and where each stands.
//!
//! 1. Refit of the nominal: `estimate::refit`; how the log was stamped, `nuisances/timing`.
//! 2. Score test of every hypothesis: `proposals/score_test`, of what the `candidates` propose.
//! 3. Threshold of what chance reaches: `proposals/chance`.
//! 4. Full refit of the best, one effect at a time: `search`, from `proposals`, by `checks`; then what may look like a
//!    missing effect and is none: `nuisances`.
//! 5. Unseen samples: `evidence/unseen`, `checks/confirmed`.
//! 6. Goodness of fit, whether the rest is noise: `checks/goodness_of_fit`.
//! 7. Gap: `answer/gap`.
//! 8. Where: `answer/whereabouts`, from `evidence/disturbance`.
//! 9. In proportion: `evidence`.
//! 10. Answer: `answer/decision`, `answer/confidence`.
//! 11. Next experiment: `answer/experiment`.
//!
//! Dependencies run one way, and there is no circle of files:
//! `answer` → `nuisances` → `search` → `proposals` → `checks` → `evidence` → `state` → `candidates` → `bounds`.
//! Every file may use what stands further right. `bounds` is the table of the numbers that accept, reject or route;
//! [`answer`] reads as the whole workflow on one page, and `search` as the sketch of the search.

pub mod answer;
mod bounds;
pub mod candidates;
pub mod checks;
mod error;
pub mod evidence;
mod nuisances;
mod proposals;
mod search;
mod state;
#[cfg(test)]
mod trial;

pub use answer::{discover, discover_beside, experiment, findings};
pub use candidates::hidden;
pub use checks::goodness_of_fit;
pub use error::DiscoverError;
