//! The residuals as a table, so that every plot of the report can be drawn again elsewhere.

use std::fmt::Write;

use crate::discover::findings::Findings;
use crate::estimate::record::Channel;

/// The channels that were measured: those with a residual anywhere.
pub(super) fn measured(findings: &Findings) -> Vec<Channel> {
    Channel::ALL
        .into_iter()
        .filter(|channel| {
            let mut rows = findings.before.iter().chain(&findings.after);
            rows.any(|row| !row[*channel as usize].is_nan())
        })
        .collect()
}

/// The table: one row per sample; a field is empty where there is no value.
pub(super) fn table(findings: &Findings) -> String {
    let channels = measured(findings);
    let mut text = String::from("t_s,held_out");
    for channel in &channels {
        let column = channel.column();
        let _ = write!(text, ",{column}_before_sigma,{column}_after_sigma");
    }
    text.push_str(",push_before,push_after\n");
    for (k, time) in findings.time_s.iter().enumerate() {
        let held_out = findings.held_out.get(k).copied().unwrap_or(false);
        let _ = write!(text, "{time},{}", u8::from(held_out));
        for channel in &channels {
            for rows in [&findings.before, &findings.after] {
                field(&mut text, rows.get(k).map(|row| row[*channel as usize]));
            }
        }
        field(&mut text, findings.disturbance.before.get(k).copied());
        field(&mut text, findings.disturbance.after.get(k).copied());
        text.push('\n');
    }
    text
}

fn field(text: &mut String, value: Option<f64>) {
    text.push(',');
    if let Some(value) = value.filter(|value| value.is_finite()) {
        let _ = write!(text, "{value}");
    }
}
