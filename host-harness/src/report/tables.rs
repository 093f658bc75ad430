//! The tables of the page: hypotheses, parameters, noises.

use std::fmt::Write;

use joint_core::effect::Kind;

use crate::discover::candidates::card;
use crate::discover::evidence::FreeRun;
use crate::discover::findings::{Findings, Named, NoiseRow, ParameterRow, ScoreRow};
use crate::plot::text::{digits, escape, number, per_cent, with_sigma};

/// Hypotheses of a round that stand on the page at once; the others are folded away.
const FIRST: usize = 8;
/// Hypotheses of a round that are listed at all.
const MOST: usize = 200;
/// A parameter with a relative sigma above this is not known from the log.
const VAGUE: f64 = 0.3;

/// The effects by name, and their rivals.
pub(super) fn effects(page: &mut String, effects: &[Named]) {
    if effects.is_empty() {
        return;
    }
    page.push_str(
        "<table><tr><th>effect<th>place<th>parameter<th class=n>value<th class=n>confidence\
         <th class=n>share of the gap<th class=n>ahead in logs redrawn<th>other names</tr>\n",
    );
    for effect in effects {
        let rows = effect.parameters.len().max(1);
        let rivals: Vec<String> = effect
            .rivals
            .iter()
            .map(|rival| {
                let (kind, place) = (escape(&rival.kind), escape(&rival.location));
                format!("{kind} at {place} ({})", per_cent(rival.confidence))
            })
            .collect();
        let _ = write!(
            page,
            "<tr><td rowspan={rows}><b>{}</b><td rowspan={rows}>{}",
            escape(&effect.kind),
            escape(&effect.location)
        );
        let mut parameters = effect.parameters.iter().map(|(key, value)| {
            let sigma = effect.standard_errors.get(key).copied();
            format!("<td>{}<td class=n>{}", escape(key), with_sigma(*value, sigma))
        });
        page.push_str(&parameters.next().unwrap_or_else(|| "<td><td>".to_owned()));
        let _ = writeln!(
            page,
            "<td class=n rowspan={rows}>{}<td class=n rowspan={rows}>{}<td class=n rowspan={rows}>{}\
             <td rowspan={rows}>{}</tr>",
            per_cent(effect.confidence),
            with_sigma(effect.share, Some(effect.share_error)),
            per_cent(effect.stays_ahead),
            if rivals.is_empty() { "none".to_owned() } else { rivals.join(", ") }
        );
        for row in parameters {
            let _ = writeln!(page, "<tr>{row}</tr>");
        }
    }
    page.push_str("</table>\n");
    for (name, kind) in effects.iter().filter_map(|e| Some((&e.kind, Kind::from_name(&e.kind)?))) {
        let card = card(kind);
        let _ = writeln!(
            page,
            "<p class=note><b>{}</b>: {}. It shows in {}, against {}.</p>",
            escape(name),
            escape(card.words),
            card.residual.words(),
            card.axis.words()
        );
    }
}

/// Effects that are only possible.
pub(super) fn possible(page: &mut String, possible: &[Named]) {
    if possible.is_empty() {
        return;
    }
    let told = possible.iter().map(|effect| {
        let parameters = effect
            .parameters
            .iter()
            .map(|(key, value)| format!("{} {}", escape(key), number(*value)));
        let parameters: Vec<String> = parameters.collect();
        format!(
            "<b>{}</b> at {} ({}; share of the gap {})",
            escape(&effect.kind),
            escape(&effect.location),
            parameters.join(", "),
            with_sigma(effect.share, Some(effect.share_error))
        )
    });
    let _ = writeln!(
        page,
        "<p class=note>Possible, but not confirmed by samples that no fit has seen, and not in the \
         improved model: {}.</p>",
        told.collect::<Vec<_>>().join("; ")
    );
}

/// Both models' free runs.
pub(super) fn free_run(page: &mut String, run: &FreeRun) {
    if run.signals.is_empty() {
        return;
    }
    let _ = writeln!(
        page,
        "<table><tr><th>free run, RMS error<th class=n>before<th class=n>after</tr>"
    );
    for (column, [before, after]) in &run.signals {
        let _ = writeln!(
            page,
            "<tr><td>{}<td class=n>{}<td class=n>{}</tr>",
            escape(column),
            number(*before),
            number(*after)
        );
    }
    let _ = writeln!(
        page,
        "</table><p class=note>{}, by the logged input alone, over {} stretches of up to {} s that no fit \
         has seen; in the unit of the column.</p>",
        escape(run.mode),
        run.stretches,
        digits(run.longest_s, 2)
    );
}

/// What was tried, by round, the best first.
pub(super) fn hypotheses(page: &mut String, findings: &Findings) {
    let mut rows: Vec<&ScoreRow> = findings.scores.iter().collect();
    let gain = |row: &ScoreRow| if row.score.is_finite() { row.score } else { f64::NEG_INFINITY };
    rows.sort_by(|a, b| {
        let refitted = b.refitted.is_some().cmp(&a.refitted.is_some());
        a.round.cmp(&b.round).then(refitted).then(gain(b).total_cmp(&gain(a)))
    });
    if rows.is_empty() {
        page.push_str("<p>No effect was tried.</p>\n");
    }
    const HEAD: &str = "<table><tr><th class=n>round<th>name<th class=n>score<th class=n>refitted \
                        gain</tr>\n";
    for round in rows.chunk_by(|a, b| a.round == b.round) {
        let (first, rest) = round.split_at(round.len().min(FIRST));
        page.push_str(HEAD);
        first.iter().for_each(|row| hypothesis(page, row));
        page.push_str("</table>\n");
        if !rest.is_empty() {
            let _ = write!(page, "<details><summary>{} more</summary>{HEAD}", rest.len());
            rest.iter().take(MOST).for_each(|row| hypothesis(page, row));
            page.push_str("</table></details>\n");
        }
    }
}

fn hypothesis(page: &mut String, row: &ScoreRow) {
    let refitted = row.refitted.map_or(String::new(), |gain| digits(gain, 5));
    let _ = writeln!(
        page,
        "<tr><td class=n>{}<td>{}<td class=n>{}<td class=n>{refitted}</tr>",
        row.round,
        escape(&row.name),
        digits(row.score, 5)
    );
}

/// The parameters' way through the refits.
pub(super) fn parameters(page: &mut String, rows: &[ParameterRow]) {
    page.push_str(
        "<table><tr><th>parameter<th class=n>nominal<th class=n>refitted<th class=n>improved\
         <th class=n>&plusmn; (relative sigma)<th class=n>change from nominal</tr>\n",
    );
    for row in rows {
        let change = row.improved / row.nominal - 1.0;
        let change = if change.is_finite() {
            format!("{:+.1} %", 100.0 * change)
        } else {
            number(f64::INFINITY)
        };
        let vague = if row.relative_sigma <= VAGUE { "" } else { " class=vague" };
        let sigma = if row.relative_sigma.is_finite() {
            format!("{} %", digits(100.0 * row.relative_sigma, 2))
        } else {
            number(row.relative_sigma)
        };
        let _ = writeln!(
            page,
            "<tr{vague}><td>{}<td class=n>{}<td class=n>{}<td class=n>{}<td class=n>{sigma}\
             <td class=n>{change}</tr>",
            escape(&row.key),
            number(row.nominal),
            number(row.refitted),
            number(row.improved)
        );
    }
    page.push_str("</table>\n");
}

/// The noises, as expected and as found.
pub(super) fn noises(page: &mut String, rows: &[NoiseRow]) {
    page.push_str(
        "<table><tr><th>noise<th>unit<th class=n>expected<th class=n>before<th class=n>after\
         </tr>\n",
    );
    for row in rows {
        let _ = writeln!(
            page,
            "<tr><td>{}<td>{}<td class=n>{}<td class=n>{}<td class=n>{}</tr>",
            escape(row.name),
            escape(row.unit),
            digits(row.expected, 3),
            digits(row.before, 3),
            digits(row.after, 3)
        );
    }
    page.push_str("</table>\n");
}
