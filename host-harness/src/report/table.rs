//! Prediction errors and pushes by sample, as CSV.

use std::fmt::Write as _;

use crate::discover::findings::Findings;
use crate::estimate::record::Channel;

/// `residuals.csv`: time, whether held out, prediction errors before and after in noise sigmas by
/// measured channel, and the push before and after.
pub fn residuals_csv(findings: &Findings) -> String {
    let channels: Vec<Channel> = measured(findings);
    let mut text = String::from("t_s,held_out");
    for channel in &channels {
        let column = channel.column();
        let _ = write!(text, ",{column}_before_sigma,{column}_after_sigma");
    }
    text.push_str(",push_before,push_after\n");
    let number = |text: &mut String, value: Option<&f64>| {
        text.push(',');
        if let Some(value) = value.filter(|value| value.is_finite()) {
            let _ = write!(text, "{value:.6}");
        }
    };
    let exact = |text: &mut String, value: Option<&f64>| {
        text.push(',');
        if let Some(value) = value.filter(|value| value.is_finite()) {
            let _ = write!(text, "{value:.6e}");
        }
    };
    for (k, time) in findings.time_s.iter().enumerate() {
        let held = findings.held_out.get(k).copied().unwrap_or(false);
        let _ = write!(text, "{time:.7},{}", u8::from(held));
        for channel in &channels {
            let c = *channel as usize;
            number(&mut text, findings.before.get(k).map(|row| &row[c]));
            number(&mut text, findings.after.get(k).map(|row| &row[c]));
        }
        exact(&mut text, findings.push.before.get(k));
        exact(&mut text, findings.push.after.get(k));
        text.push('\n');
    }
    text
}

/// The channels that have a value somewhere.
pub(super) fn measured(findings: &Findings) -> Vec<Channel> {
    let seen =
        |channel: &Channel| findings.before.iter().any(|row| row[*channel as usize].is_finite());
    Channel::ALL.into_iter().filter(seen).collect()
}
