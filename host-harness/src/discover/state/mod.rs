//! What a search knows: fitted models, the effects that were added, and the evidence so far.
//!
//! Data without rules. What proposes an effect, what refuses one and in which order they are asked stands in
//! `proposals`, `checks` and `search`, which all read and write these.

pub(crate) mod constant;
pub(crate) mod progress;
pub(crate) mod rounds;
pub(crate) mod search;
pub(crate) mod stage;
