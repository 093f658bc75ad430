//! Which samples are fitted to, and which no fit sees.

use crate::estimate::record::Record;

/// Blocks of a log, and those that are held out.
const BLOCKS: usize = 10;
const HELD_OUT: [usize; 3] = [3, 6, 9];

/// The samples of a record, whole blocks of every log.
pub(crate) struct Split {
    /// Whether no fit sees a sample, nor any choice but that of a weak name.
    pub(crate) held_out: Vec<bool>,
    /// One where a sample is fitted to.
    pub(crate) fitted: Vec<f64>,
    /// One where it is held out.
    pub(crate) tested: Vec<f64>,
}

impl Split {
    /// Of a record.
    pub(crate) fn of(record: &Record) -> Self {
        let mut held_out = vec![false; record.len()];
        for (number, start) in record.starts.iter().enumerate() {
            let end = record.starts.get(number + 1).copied().unwrap_or(record.len());
            for (k, held) in held_out.iter_mut().enumerate().take(end).skip(*start) {
                *held = HELD_OUT.contains(&((k - start) * BLOCKS / (end - start)));
            }
        }
        let fitted = held_out.iter().map(|held| if *held { 0.0 } else { 1.0 }).collect();
        let tested = held_out.iter().map(|held| if *held { 1.0 } else { 0.0 }).collect();
        Self { held_out, fitted, tested }
    }
}
