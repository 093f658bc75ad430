//! The part of a record that fits look at while they are on the way to others.
//!
//! At inflated process noise a few thousand samples tell as much as a fit on the way needs; the one
//! that it leads to takes all. So stretches of what is fitted to, over the whole record, are run alone.

use super::record::Record;

/// Some stretches of a record, all of which are fitted to.
#[derive(Clone, Debug)]
pub struct Scout {
    pub(super) record: Record,
    pub(super) mask: Vec<f64>,
}
