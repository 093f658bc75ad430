//! The answer in a sentence, for the reader who stops there.

use crate::discover::evidence::Budget;
use crate::discover::findings::{Answer, Findings, Named, Verdict, Whereabouts};
use crate::plot::text::{escape, number, per_cent, with_sigma};

/// The headline, as HTML.
pub(super) fn sentence(findings: &Findings) -> String {
    let verdict = &findings.verdict;
    let named: Vec<String> = verdict.effects.iter().map(name).collect();
    let named = named.join("; and ");
    match verdict.verdict {
        Answer::Effect => format!("The model misses {named}."),
        Answer::Adequate => format!("Nothing is missing that this log shows{}.", to(verdict)),
        Answer::Undecided => "This log cannot tell what the model misses.".to_owned(),
        Answer::Unknown if named.is_empty() => format!(
            "Something is missing that no listed effect explains: {}.",
            place(&verdict.whereabouts)
        ),
        Answer::Unknown => format!(
            "The model misses {named}; yet something else is missing as well, which no listed \
             effect explains: {}.",
            place(&verdict.whereabouts)
        ),
    }
}

/// To how much the model explains the equation that it misses most.
pub(crate) fn to(verdict: &Verdict) -> String {
    verdict.budget.as_ref().map_or(String::new(), |budget| {
        format!(
            ": the model explains the {} to {} of what drives it ({} {} RMS)",
            budget.equation,
            per_cent(budget.left_of_drive),
            number(budget.rms_left),
            budget.unit
        )
    })
}

/// How far predictions missed, as HTML.
pub(super) fn gap(findings: &Findings) -> String {
    if findings.verdict.verdict == Answer::Undecided {
        return escape(&findings.verdict.reasons.join("; "));
    }
    let gap = &findings.verdict.gap;
    format!(
        "Predictions of the refitted model miss by {} before and {} after; noise alone leaves {} \
         ({}).",
        number(gap.before),
        number(gap.after),
        number(gap.floor),
        escape(gap.unit)
    )
}

/// Where the gap goes, in a sentence.
pub(crate) fn budget(budget: &Budget) -> String {
    let mut text = format!(
        "Of what the refitted nominal misses in the {} equation ({} {} RMS on samples that no fit has \
         seen) the effects explain {}",
        budget.equation,
        number(budget.rms_before),
        budget.unit,
        per_cent(budget.named)
    );
    if budget.unnamed > 0.0 {
        text += &format!(
            "; {} follows {} and has no name ({} of what drives that equation)",
            per_cent(budget.unnamed),
            budget.unnamed_follows,
            per_cent(budget.unnamed_of_drive)
        );
    }
    text += &format!(
        "; {} is correlated in time but follows nothing; {} is what white noise leaves.",
        per_cent(budget.coloured),
        per_cent(budget.white)
    );
    text
}

/// Where the disagreement sits, as HTML.
pub(super) fn place(place: &Whereabouts) -> String {
    if place.equation.is_empty() {
        return "no equation stands out".to_owned();
    }
    let mut text = format!("it acts on <b>{}</b>", escape(&place.equation));
    if !place.varies_with.is_empty() {
        let follows = escape(&place.varies_with);
        text.push_str(&format!(" and follows <b>{follows}</b>"));
    }
    if !place.orders.is_empty() {
        let orders: Vec<String> = place.orders.iter().map(|order| number_of(*order)).collect();
        text.push_str(&format!(" at {} per turn", orders.join(", ")));
    }
    text.push_str(&format!(" ({} of its variance)", per_cent(place.explained)));
    text
}

/// An order: an integer where it is one.
pub(super) fn number_of(order: f64) -> String {
    if order.fract() == 0.0 { format!("{order}") } else { number(order) }
}

fn name(effect: &Named) -> String {
    let parameters: Vec<String> = effect
        .parameters
        .iter()
        .map(|(key, value)| {
            let sigma = effect.standard_errors.get(key).copied();
            format!("{} {}", escape(key), with_sigma(*value, sigma))
        })
        .collect();
    let colon = if parameters.is_empty() { "" } else { ": " };
    format!(
        "<b>{}</b> at <b>{}</b> (confidence {}){colon}{}",
        escape(&effect.kind),
        escape(&effect.location),
        per_cent(effect.confidence),
        parameters.join(", ")
    )
}
