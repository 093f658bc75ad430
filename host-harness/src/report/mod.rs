//! What a discovery or a refit found, for people: a page to read in a minute, and its numbers as a table.
//!
//! The page is one file without any link, so that it can be mailed, archived and opened offline. Every number on
//! it is the search's own, or a free run's of the models that it names; nothing is estimated here.

mod answer;
mod csv;
mod disagree;
mod free;
mod gap;
mod next;
mod page;
mod parameters;
mod refit;
mod rivals;
mod source;
mod spectrum;
mod words;

#[cfg(test)]
mod browser;
#[cfg(test)]
mod tests;

pub(crate) use answer::{budget, to};
pub use refit::{Refit, refit};
pub use source::{File, Source, quoted};

use crate::discover::findings::Findings;
use crate::log::Log;

/// The page `report.html` of a discovery in these logs.
pub fn html(findings: &Findings, logs: &[Log], source: &Source) -> String {
    page::page(findings, logs, source)
}

/// The table `residuals.csv`.
pub fn residuals_csv(findings: &Findings) -> String {
    csv::table(findings)
}
