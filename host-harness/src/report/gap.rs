//! Where the gap goes, as a bar: what each effect explains, what follows something without a name, what follows
//! nothing, and what is noise.

use std::fmt::Write;

use super::answer::{of_drive, unnamed_rms};
use super::words::{effect, the, words};
use crate::discover::evidence::Budget;
use crate::discover::findings::{Answer, Gap, Named, Verdict};
use crate::plot::text::{digits, escape, per_cent, si, si_with_sigma};
use crate::plot::{Ink, Part, stack};

/// Colours of effects: those that no other part has.
const INKS: [usize; 5] = [0, 2, 4, 5, 7];

/// The figures of the first screen.
pub(super) fn tiles(page: &mut String, verdict: &Verdict) {
    let mut tile = |figure: String, text: String| {
        let _ =
            writeln!(page, "<div><b>{}</b><small>{}</small></div>", escape(&figure), escape(&text));
    };
    if let Some(least) = verdict.effects.iter().map(|own| own.confidence).reduce(f64::min) {
        let text = match verdict.effects.len() {
            1 => "probability that the name is right",
            _ => "probability of the least certain name",
        };
        tile(per_cent(least), text.to_owned());
    }
    if let Some(budget) = &verdict.budget {
        if verdict.verdict == Answer::Unknown && budget.unnamed > 0.0 {
            let follows = the(&words(&budget.unnamed_follows));
            let text = format!(
                "RMS of {} has no name and follows {follows}{}",
                budget.equation,
                of_drive(": ", budget.unnamed_of_drive, "it")
            );
            tile(si(unnamed_rms(budget), &budget.unit, 2), text);
        }
        if !verdict.effects.is_empty() {
            let text =
                "of what the refitted model misses is explained, on samples that no fit has seen";
            tile(per_cent(budget.named), text.to_owned());
        }
        match budget.rms_left > 0.0 {
            true => {
                let text = format!(
                    "RMS of {} stays unexplained beside white noise{}",
                    budget.equation,
                    of_drive(": ", budget.left_of_drive, "it")
                );
                tile(si(budget.rms_left, &budget.unit, 2), text);
            }
            false => {
                let text = format!("RMS of {} is left, all of it white noise", budget.equation);
                tile(si(budget.rms_after, &budget.unit, 2), text);
            }
        }
    }
    let gap = &verdict.gap;
    let text = format!(
        "prediction error in standard deviations of the noise, on samples that no fit has seen; noise alone \
         leaves {}",
        digits(gap.floor, 3)
    );
    match verdict.effects.is_empty() {
        true => tile(digits(gap.after, 3), text),
        false => tile(format!("{} → {}", digits(gap.before, 3), digits(gap.after, 3)), text),
    }
}

/// The budget as a bar with its table.
pub(super) fn budget(page: &mut String, verdict: &Verdict) {
    let Some(budget) = &verdict.budget else { return };
    let _ = writeln!(
        page,
        "<h2>Where the error goes</h2>\n<p>The refitted model misses {} RMS in the {} equation, on samples \
         that no fit has seen. Shares are of its square, so that they add up.</p>",
        escape(&si(budget.rms_before, &budget.unit, 3)),
        escape(&budget.equation)
    );
    page.push_str(&stack(&["part", "share", "RMS"], &parts(verdict, budget)));
    let gone = 1.0 - budget.named;
    if gone > 1.0 {
        let _ = writeln!(
            page,
            "<p class=note>With the effects the model misses more there than without ({} RMS).</p>",
            escape(&si(budget.rms_after, &budget.unit, 3))
        );
    }
}

/// An effect's share with its standard error.
pub(super) fn share(own: &Named) -> String {
    match own.share_error.is_finite() && own.share_error > 0.0 {
        true => si_with_sigma(100.0 * own.share, Some(100.0 * own.share_error), "%"),
        false => format!("{:.1} %", 100.0 * own.share),
    }
}

fn parts(verdict: &Verdict, budget: &Budget) -> Vec<Part> {
    let rms = |share: f64| si(budget.rms_before * share.max(0.0).sqrt(), &budget.unit, 2);
    let mut all: Vec<Part> = Vec::new();
    for (k, own) in verdict.effects.iter().enumerate() {
        all.push(Part {
            name: effect(&own.kind, &own.location),
            ink: Ink::Nth(INKS[k % INKS.len()]),
            share: own.share,
            cells: vec![share(own), rms(own.share)],
        });
    }
    let mut part = |name: String, ink: Ink, share: f64| {
        let cells = vec![format!("{:.1} %", 100.0 * share), rms(share)];
        all.push(Part { name, ink, share, cells });
    };
    let follows = match budget.unnamed > 0.0 {
        true => format!("without a name, follows {}", the(&words(&budget.unnamed_follows))),
        false => "predictable, without a name".to_owned(),
    };
    part(follows, Ink::Wrong, budget.unnamed);
    part("correlated in time, follows nothing".to_owned(), Ink::Soft, budget.coloured);
    part("white noise of sensors and torque".to_owned(), Ink::Faint, budget.white);
    all
}

/// The gap by signal, as a table.
pub(super) fn signals(page: &mut String, gap: &Gap) {
    let _ = writeln!(
        page,
        "<h3>Prediction errors by signal</h3>\n<div class=wide><table><tr><th>{}<th class=n>refitted\
         <th class=n>improved<th class=n>noise alone</tr>",
        escape(gap.unit)
    );
    let all = [("all signals", [gap.before, gap.after, gap.floor])];
    let rows = gap.signals.iter().map(|(name, values)| (name.as_str(), *values));
    for (name, values) in all.into_iter().chain(rows) {
        let [before, after, floor] = values.map(|value| digits(value, 3));
        let _ = writeln!(
            page,
            "<tr><td>{}<td class=n>{before}<td class=n>{after}<td class=n>{floor}</tr>",
            escape(&words(name))
        );
    }
    page.push_str("</table></div>\n");
}
