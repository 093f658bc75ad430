//! What a discovery found, for people: a page to read in a minute, and its numbers as a table.
//!
//! The page is one file without any link, so that it can be mailed, archived and opened offline.

mod csv;

use crate::discover::findings::Findings;

/// The page `report.html`.
pub fn html(findings: &Findings) -> String {
    format!("<!doctype html><pre>{:?}</pre>", findings.verdict.verdict)
}

/// The table `residuals.csv`.
pub fn residuals_csv(findings: &Findings) -> String {
    csv::table(findings)
}
