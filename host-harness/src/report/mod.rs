//! What a discovery found, for people: a page to read in a minute, and its numbers as a table.
//!
//! The page is one file without any link, so that it can be mailed, archived and opened offline.

mod answer;
mod csv;
mod gap;
mod page;
mod tables;

#[cfg(test)]
mod tests;

pub(crate) use answer::{budget, to};

use crate::discover::findings::Findings;

/// The page `report.html`.
pub fn html(findings: &Findings) -> String {
    page::page(findings)
}

/// The table `residuals.csv`.
pub fn residuals_csv(findings: &Findings) -> String {
    csv::table(findings)
}
