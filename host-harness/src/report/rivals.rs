//! The other names, and why they lost; then everything that was tried.

use std::fmt::Write;

use super::words::effect;
use crate::discover::findings::{Findings, Named, Rival, ScoreRow};
use crate::plot::text::{digits, escape, per_cent};

/// Hypotheses of a round that are listed at most.
const MOST: usize = 60;
/// Share of the winner's improvement below which a rival explains little of what it does.
const LITTLE: f64 = 0.5;

/// The rivals of each effect.
pub(super) fn section(page: &mut String, effects: &[Named]) {
    if effects.is_empty() {
        return;
    }
    if effects.iter().all(|own| own.rivals.is_empty()) {
        page.push_str("<h2>Rivals</h2>\n<p>No other effect on the list comes near.</p>\n");
        return;
    }
    page.push_str(
        "<h2>Rivals, and why they lost</h2>\n<p>Every effect on the list was fitted in the same place as the \
         one found. The improvement of the fit is 2 Δ log-likelihood; 3.8 is what chance gives one parameter \
         once in twenty times.</p>\n<div class=wide><table class=cards><tr><th>found<th>rival<th class=n>improves the fit by\
         <th class=n>probability<th>why it lost</tr>\n",
    );
    for own in effects {
        let name = effect(&own.kind, &own.location);
        let found = escape(&format!("{name}, by {}", digits(own.gain, 4)));
        if own.rivals.is_empty() {
            let _ = writeln!(page, "<tr><td>{found}<td colspan=4>no other name comes near</tr>");
        }
        for rival in &own.rivals {
            let _ = writeln!(
                page,
                "<tr><td>{found}<td data-h=rival>{}<td class=n data-h=\"improves the fit by\">{}\
                 <td class=n data-h=probability>{}<td data-h=\"why it lost\">{}</tr>",
                escape(&effect(&rival.kind, &rival.location)),
                digits(rival.gain, 4),
                per_cent(rival.confidence),
                why(own, rival)
            );
        }
    }
    page.push_str("</table></div>\n");
}

/// Why a rival lost, from what both improve the fit by.
fn why(own: &Named, rival: &Rival) -> String {
    let share = rival.gain / own.gain;
    match share {
        share if !share.is_finite() => "it could not be fitted".to_owned(),
        share if share <= 0.0 => "it does not improve the fit".to_owned(),
        share if share < LITTLE => {
            format!("it improves the fit only {} as much", per_cent(share))
        }
        share if share < 1.0 => format!(
            "close: {} of the improvement; the name found stays ahead in {} of the logs drawn anew",
            per_cent(share),
            per_cent(own.stays_ahead)
        ),
        _ => "it fits as well here, but does not hold in the other tests".to_owned(),
    }
}

/// What was tried, by round, the best first, folded away.
pub(super) fn tried(page: &mut String, findings: &Findings) {
    let mut rows: Vec<&ScoreRow> = findings.scores.iter().collect();
    let gain = |row: &ScoreRow| if row.score.is_finite() { row.score } else { f64::NEG_INFINITY };
    rows.sort_by(|a, b| {
        let refitted = b.refitted.is_some().cmp(&a.refitted.is_some());
        a.round.cmp(&b.round).then(refitted).then(gain(b).total_cmp(&gain(a)))
    });
    if rows.is_empty() {
        return;
    }
    let _ = writeln!(
        page,
        "<details><summary>What was tried, by round: {} hypotheses</summary><p class=note>Promise: by how much \
         the linear step would improve the fit (2 Δ log-likelihood). Refitted: by how much the full refit did, \
         where there was one.</p>",
        rows.len()
    );
    for round in rows.chunk_by(|a, b| a.round == b.round) {
        let _ = writeln!(
            page,
            "<table><tr><th>round {}<th class=n>promise<th class=n>refitted</tr>",
            round[0].round
        );
        for row in round.iter().take(MOST) {
            let refitted = row.refitted.map_or(String::new(), |gain| digits(gain, 4));
            let _ = writeln!(
                page,
                "<tr><td>{}<td class=n>{}<td class=n>{refitted}</tr>",
                escape(&row.name),
                digits(row.score, 4)
            );
        }
        page.push_str("</table>\n");
        if round.len() > MOST {
            let _ = writeln!(page, "<p class=note>and {} more</p>", round.len() - MOST);
        }
    }
    page.push_str("</details>\n");
}

/// Why the answer is what it is, in the search's own sentences.
pub(super) fn reasons(page: &mut String, findings: &Findings) {
    if findings.verdict.reasons.is_empty() {
        return;
    }
    page.push_str("<details><summary>Why, step by step</summary><ul>");
    for reason in &findings.verdict.reasons {
        let _ = write!(page, "<li>{}</li>", escape(reason));
    }
    page.push_str("</ul></details>\n");
}
