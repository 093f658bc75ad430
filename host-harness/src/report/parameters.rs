//! Parameters of the joint and of the effects, with intervals; those that the log does not tell are marked.

use std::fmt::Write;

use super::gap::share;
use super::words::{capital, effect, explained, kind, parameter, place};
use crate::discover::findings::{Named, NoiseRow, ParameterRow};
use crate::plot::text::{
    digits, escape, per_cent, si, si_range, si_with_sigma, si_within, unit_of,
};

/// Standard errors on either side that hold 95 %.
const NORMAL_95: f64 = 1.96;

/// The parameters of a joint: as given, refitted and improved. `assumed` are keys that the model file itself
/// says are assumed; `improved` is whether there is an improved model beside the refitted one.
pub(super) fn table(page: &mut String, rows: &[ParameterRow], assumed: &[String], improved: bool) {
    let third = if improved { "<th class=n>improved" } else { "" };
    let _ = writeln!(
        page,
        "<h2>Parameters</h2>\n<div class=wide><table class=cards><tr><th>parameter<th class=n>given<th class=n>refitted{third}\
         <th class=n>interval of 95 %<th class=n>change</tr>"
    );
    for row in rows {
        let (name, unit) = parameter(&row.key);
        let guessed = assumed.contains(&row.key);
        let mark = match (row.determined, guessed) {
            (true, _) => "",
            (false, true) => " <span class=tag>assumed, also in the model file</span>",
            (false, false) => " <span class=tag>assumed</span>",
        };
        let given = match guessed {
            true => format!("{} <span class=tag>assumed</span>", escape(&si(row.nominal, unit, 3))),
            false => escape(&si(row.nominal, unit, 3)),
        };
        let value = |value: f64| escape(&si(value, unit, 3));
        let told = escape(&si_within(row.improved, row.interval, unit));
        let values = match improved {
            true => format!(
                "<td class=n data-h=refitted>{}<td class=n data-h=improved>{told}",
                value(row.refitted)
            ),
            false => format!("<td class=n data-h=refitted>{told}"),
        };
        let _ = writeln!(
            page,
            "<tr{} title=\"{}\"><td>{}{mark}<td class=n data-h=given>{given}{values}<td class=n data-h=\"interval of 95 %\">{}\
             <td class=n data-h=change>{}</tr>",
            if row.determined { "" } else { " class=vague" },
            escape(&row.key),
            escape(&name),
            escape(&si_range(row.interval, unit)),
            change(row.nominal, row.improved)
        );
    }
    page.push_str(
        "</table></div>\n<p class=note>Assumed: the log does not tell it. Its uncertainty is hardly smaller than before \
         the fit, so that the interval is mostly that of the assumption, even where the value has moved along with \
         others.</p>\n",
    );
}

fn change(from: f64, to: f64) -> String {
    let change = to / from - 1.0;
    match change.is_finite() {
        true => format!("{:+.1} %", 100.0 * change),
        false => "–".to_owned(),
    }
}

/// The effects found, a table each.
pub(super) fn effects(page: &mut String, effects: &[Named]) {
    if effects.is_empty() {
        return;
    }
    page.push_str("<h2>What was found</h2>\n");
    for own in effects {
        let _ = writeln!(page, "<h3>{}</h3>", escape(&capital(&effect(&own.kind, &own.location))));
        if let Some(words) = explained(&own.kind) {
            let _ = writeln!(page, "<p>{}.</p>", escape(&capital(words)));
        }
        let share = share(own);
        let _ = writeln!(
            page,
            "<p class=note>Right with a probability of {}. It explains {share} of what the refitted model misses. \
             Samples that no fit has seen bear out {} of what it changes there{}, and in {} of \
             the logs drawn anew from this one it stays ahead of every other name.</p>",
            per_cent(own.confidence),
            borne_out(own),
            own.transfer_t.map_or(String::new(), |t| format!(
                ", on other records it improves the fit by {} times its standard error",
                digits(t, 2)
            )),
            per_cent(own.stays_ahead)
        );
        values(page, own);
    }
}

/// What repeats without a name.
pub(super) fn unnamed(page: &mut String, maps: &[Named]) {
    for own in maps {
        let _ = writeln!(
            page,
            "<h2>What repeats without a name</h2>\n<p>{} is in the improved model. It says what is there without \
             saying why, and takes {} of what the refitted model misses; samples that no fit has seen bear out \
             {} of what it changes there.</p>",
            escape(&capital(&effect(&own.kind, &own.location))),
            share(own),
            borne_out(own)
        );
        values(page, own);
    }
}

/// How much of an effect unseen samples bear out, ± one standard error.
fn borne_out(own: &Named) -> String {
    match (own.borne_out, own.borne_out_error) {
        (Some(value), Some(error)) => format!("{:.0} ± {:.0} %", 100.0 * value, 100.0 * error),
        _ => "nothing".to_owned(),
    }
}

/// The parameters of an effect.
fn values(page: &mut String, own: &Named) {
    page.push_str(
        "<div class=wide><table class=cards><tr><th>parameter<th class=n>value, ± one standard error<th class=n>interval of \
         95 %</tr>\n",
    );
    for (key, value) in &own.parameters {
        let (name, unit) = unit_of(key);
        let sigma = own.standard_errors.get(key).copied();
        let interval = sigma.map_or("held".to_owned(), |sigma| {
            si_range([value - NORMAL_95 * sigma, value + NORMAL_95 * sigma], unit)
        });
        let _ = writeln!(
            page,
            "<tr title=\"{}\"><td>{}<td class=n data-h=\"value, ± one standard error\">{}<td class=n data-h=\"interval of 95 %\">{}</tr>",
            escape(key),
            escape(&name.replace('_', " ")),
            escape(&si_with_sigma(*value, sigma, unit)),
            escape(&interval)
        );
    }
    page.push_str("</table></div>\n");
    for (key, knots) in &own.knots {
        let (name, unit) = unit_of(key);
        let knots: Vec<String> = knots.iter().map(|knot| si(*knot, unit, 3)).collect();
        let _ = writeln!(
            page,
            "<p class=note>{} at even knots: {}.</p>",
            escape(&capital(&name.replace('_', " "))),
            escape(&knots.join(", "))
        );
    }
}

/// Effects that are only possible.
pub(super) fn possible(page: &mut String, possible: &[Named]) {
    if possible.is_empty() {
        return;
    }
    page.push_str(
        "<h2>Possible, not confirmed</h2>\n<p>These improve the fit, but samples that no fit has seen do not \
         bear them out; they are not in the improved model.</p>\n<div class=wide><table><tr><th>effect\
         <th>parameters<th class=n>confidence</tr>\n",
    );
    for own in possible {
        let values = own.parameters.iter().map(|(key, value)| {
            let (name, unit) = unit_of(key);
            format!("{} {}", name.replace('_', " "), si(*value, unit, 2))
        });
        let values: Vec<String> = values.collect();
        let _ = writeln!(
            page,
            "<tr><td>{} {}<td>{}<td class=n>{}</tr>",
            escape(&kind(&own.kind)),
            escape(&place(&own.location)),
            escape(&values.join(", ")),
            per_cent(own.confidence)
        );
    }
    page.push_str("</table></div>\n");
}

/// The noises, as expected and as found.
pub(super) fn noises(page: &mut String, rows: &[NoiseRow], improved: bool) {
    let third = if improved { "<th class=n>improved" } else { "" };
    let _ = writeln!(
        page,
        "<details><summary>Noise of sensors and equations</summary><div class=wide><table><tr><th>noise\
         <th class=n>expected<th class=n>refitted{third}</tr>"
    );
    for row in rows {
        let value = |value: f64| escape(&si(value, row.unit, 2));
        let improved =
            if improved { format!("<td class=n>{}", value(row.after)) } else { String::new() };
        let _ = writeln!(
            page,
            "<tr><td>{}<td class=n>{}<td class=n>{}{improved}</tr>",
            escape(&super::words::words(row.name)),
            value(row.expected),
            value(row.before)
        );
    }
    page.push_str("</table></div></details>\n");
}
