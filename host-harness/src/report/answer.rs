//! The answer in everyday words, for the reader who stops there.

use super::words::{capital, effect, explained, joined, list, the, words};
use crate::discover::evidence::Budget;
use crate::discover::findings::{Answer, Findings, Verdict, Whereabouts};
use crate::plot::text::{digits, per_cent, si};

/// The headline.
pub(super) fn headline(verdict: &Verdict) -> String {
    let named = list(&verdict.effects);
    match verdict.verdict {
        Answer::Effect => format!("The model lacks {named}"),
        Answer::Adequate => "Nothing is missing that this log shows".to_owned(),
        Answer::Undecided => "This log cannot tell what the model lacks".to_owned(),
        Answer::Unknown => {
            let beside = if named.is_empty() { named } else { format!(", beside {named}") };
            let what = match verdict.budget.as_ref().filter(|budget| budget.unnamed > 0.0) {
                Some(budget) => format!(
                    "In the {} something is missing that follows {}",
                    budget.equation,
                    the(&words(&budget.unnamed_follows))
                ),
                None => "Something is missing".to_owned(),
            };
            format!("{what}, and no known effect explains it{beside}")
        }
    }
}

/// What stands below the headline, a paragraph each.
pub(super) fn paragraphs(findings: &Findings) -> Vec<String> {
    let verdict = &findings.verdict;
    match verdict.verdict {
        Answer::Undecided => {
            verdict.reasons.iter().map(|reason| format!("{}.", capital(&words(reason)))).collect()
        }
        Answer::Adequate => vec![adequate(verdict)],
        Answer::Effect => {
            let mut all = vec![format!("{} {}", what(verdict), how_sure(verdict))];
            all.extend(verdict.budget.as_ref().map(left));
            all
        }
        Answer::Unknown => {
            let mut all = vec![not_explained(verdict)];
            all.extend(possible(verdict));
            if !verdict.effects.is_empty() {
                all.push(format!("{} {}", what(verdict), how_sure(verdict)));
            }
            all
        }
    }
}

/// What the effects are.
fn what(verdict: &Verdict) -> String {
    let mut told: Vec<&str> = Vec::new();
    for own in verdict.effects.iter().filter_map(|own| explained(&own.kind)) {
        if !told.contains(&own) {
            told.push(own);
        }
    }
    match &told[..] {
        [] => String::new(),
        [one] => format!("That is {one}."),
        several => format!(
            "These are {}.",
            joined(&several.iter().map(|s| (*s).to_owned()).collect::<Vec<_>>())
        ),
    }
}

/// How sure the names are, and what they explain.
fn how_sure(verdict: &Verdict) -> String {
    let Some(least) = verdict.effects.iter().map(|own| own.confidence).reduce(f64::min) else {
        return String::new();
    };
    let one = verdict.effects.len() == 1;
    let sure = match one {
        true => format!("The name is right with a probability of {}.", per_cent(least)),
        false => format!("Each name is right with a probability of {} or more.", per_cent(least)),
    };
    match &verdict.budget {
        Some(budget) => format!(
            "{sure} Of the error that the refitted model leaves in the {} equation {} {} on samples that no \
             fit has seen.",
            budget.equation,
            if one { "it explains" } else { "they explain" },
            per_cent(budget.named),
        ),
        None => sure,
    }
}

/// What is left, and whether it matters.
fn left(budget: &Budget) -> String {
    if budget.rms_left <= 0.0 {
        return format!("What is left in the {} equation is white noise.", budget.equation);
    }
    format!(
        "What stays unexplained beside white noise is {} RMS{}.",
        si(budget.rms_left, &budget.unit, 2),
        of_drive(", ", budget.left_of_drive, "that equation")
    )
}

fn adequate(verdict: &Verdict) -> String {
    let mut text = match &verdict.budget {
        Some(budget) if budget.rms_left <= 0.0 => format!(
            "What the refitted model leaves in the {} equation, {} RMS, is white noise.",
            budget.equation,
            si(budget.rms_before, &budget.unit, 2)
        ),
        Some(budget) => format!(
            "The refitted model explains the {} equation up to {} RMS{}.",
            budget.equation,
            si(budget.rms_left, &budget.unit, 2),
            of_drive(", ", budget.left_of_drive, "it")
        ),
        None => "The refitted model explains this log.".to_owned(),
    };
    let gap = &verdict.gap;
    text += &format!(
        " On samples that no fit has seen its predictions miss by {} standard deviations of the noise, \
         where noise alone leaves {}.",
        digits(gap.after, 3),
        digits(gap.floor, 3)
    );
    text
}

/// What is not explained, and where.
fn not_explained(verdict: &Verdict) -> String {
    let Some(budget) = verdict.budget.as_ref() else {
        return format!("{}.", capital(&place(&verdict.whereabouts)));
    };
    let whole = format!(
        "In the {} equation {} RMS stay unexplained beside white noise{}.",
        budget.equation,
        si(budget.rms_left, &budget.unit, 2),
        of_drive(", ", budget.left_of_drive, "it")
    );
    match budget.unnamed > 0.0 {
        true => format!(
            "{whole} A part of it can be predicted, so it is a law without a name: {} RMS follow {}{}.",
            si(unnamed_rms(budget), &budget.unit, 2),
            the(&words(&budget.unnamed_follows)),
            of_drive(", ", budget.unnamed_of_drive, "the equation")
        ),
        false => format!(
            "{whole} It is correlated in time but follows no angle, speed, current or time that the log has."
        ),
    }
}

/// Of the unnamed part, in the unit of its equation: shares are of squares.
pub(super) fn unnamed_rms(budget: &Budget) -> f64 {
    budget.rms_before * budget.unnamed.max(0.0).sqrt()
}

fn possible(verdict: &Verdict) -> Option<String> {
    let names = verdict.possible.iter().map(|own| effect(&own.kind, &own.location));
    let names: Vec<String> = names.collect();
    (!names.is_empty()).then(|| {
        format!(
            "Possible, but not confirmed by samples that no fit has seen, and not in the improved model: {}.",
            joined(&names)
        )
    })
}

/// A remainder against what drives its equation; nothing where nothing does.
pub(super) fn of_drive(before: &str, share: Option<f64>, equation: &str) -> String {
    share.map_or(String::new(), |share| {
        format!("{before}{} of what drives {equation}", per_cent(share))
    })
}

/// To how much the model explains the equation that it misses most.
pub(crate) fn to(verdict: &Verdict) -> String {
    verdict.budget.as_ref().map_or(String::new(), |budget| match budget.rms_left > 0.0 {
        true => format!(
            ": the model explains the {} to {} RMS{}",
            budget.equation,
            si(budget.rms_left, &budget.unit, 3),
            of_drive(", ", budget.left_of_drive, "it")
        ),
        false => format!(": what is left of the {} is white noise", budget.equation),
    })
}

/// Where the gap goes, in a sentence.
pub(crate) fn budget(budget: &Budget) -> String {
    let mut text = format!(
        "Of what the refitted nominal misses in the {} equation ({} RMS on samples that no fit has seen) \
         the effects explain {}",
        budget.equation,
        si(budget.rms_before, &budget.unit, 3),
        per_cent(budget.named)
    );
    if budget.unnamed > 0.0 {
        text += &format!(
            "; {} follows {} and has no name{}",
            per_cent(budget.unnamed),
            budget.unnamed_follows,
            of_drive(": ", budget.unnamed_of_drive, "that equation")
        );
    }
    text += &format!(
        "; {} is correlated in time but follows nothing; {} is what white noise leaves.",
        per_cent(budget.coloured),
        per_cent(budget.white)
    );
    text
}

/// Where the disagreement sits.
pub(super) fn place(place: &Whereabouts) -> String {
    if place.equation.is_empty() || place.equation == "none" {
        return "no equation stands out".to_owned();
    }
    let mut text = format!("it acts on the {} equation", place.equation);
    if !place.varies_with.is_empty() {
        text.push_str(&format!(" and follows {}", the(&words(&place.varies_with))));
    }
    if !place.orders.is_empty() {
        let orders: Vec<String> = place.orders.iter().map(|order| order_of(*order)).collect();
        text.push_str(&format!(" at {} per turn", joined(&orders)));
    }
    text.push_str(&format!(", which explains {} of its variance", per_cent(place.explained)));
    text
}

/// An order: an integer where it is one.
pub(super) fn order_of(order: f64) -> String {
    if order.fract() == 0.0 { format!("{order}") } else { digits(order, 4) }
}
