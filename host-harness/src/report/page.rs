//! `report.html`: one file, nothing loaded from elsewhere.

use std::fmt::Write as _;

use super::plot::{Series, escape, number, plot};
use super::table::measured;
use crate::discover::findings::{Answer, Findings};

const STYLE: &str = include_str!("style.css");
const SCRIPT: &str = include_str!("zoom.js");

/// The page.
pub fn html(findings: &Findings) -> String {
    let mut page = format!(
        "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\"><title>{0}</title><style>{STYLE}</style></head><body><main><h1>{0}</h1>",
        escape(&format!("What the model of {} misses", findings.nominal.name))
    );
    answer(&mut page, findings);
    gap(&mut page, findings);
    place(&mut page, findings);
    errors(&mut page, findings);
    tables(&mut page, findings);
    let _ = write!(
        page,
        "<h2>The improved model</h2><pre>{}</pre></main><script>{SCRIPT}</script></body></html>",
        escape(&findings.improved.to_toml())
    );
    page
}

fn answer(page: &mut String, findings: &Findings) {
    let verdict = &findings.verdict;
    let sentence = match verdict.verdict {
        Answer::Effect => {
            "Something is missing, it has a name, and with it the model explains the log."
        }
        Answer::Adequate => "Nothing is missing that this log shows.",
        Answer::Unknown if verdict.effects.is_empty() => {
            "Something is missing that no listed effect explains."
        }
        Answer::Unknown => "What follows was found, but something else is missing as well.",
    };
    let _ = write!(page, "<p class=\"answer\">{sentence}</p>");
    for effect in &verdict.effects {
        let _ = write!(
            page,
            "<p class=\"name\"><b>{}</b> at {} <span class=\"soft\">confidence {:.2}</span></p><table><tr><th>parameter</th><th>value</th><th>±</th></tr>",
            escape(&effect.kind),
            escape(&effect.location),
            effect.confidence
        );
        for (key, value) in &effect.parameters {
            let sigma = effect.standard_errors.get(key).map_or("fixed".to_owned(), |s| number(*s));
            let _ = write!(
                page,
                "<tr><td>{}</td><td>{}</td><td>{sigma}</td></tr>",
                escape(key),
                number(*value)
            );
        }
        page.push_str("</table>");
        if !effect.rivals.is_empty() {
            let rivals: Vec<String> = effect
                .rivals
                .iter()
                .map(|r| format!("{} at {} ({:.2})", r.kind, r.location, r.confidence))
                .collect();
            let _ =
                write!(page, "<p class=\"soft\">Other names: {}</p>", escape(&rivals.join(", ")));
        }
    }
    page.push_str("<ul>");
    for reason in &verdict.reasons {
        let _ = write!(page, "<li>{}</li>", escape(reason));
    }
    let _ = write!(page, "</ul><p><b>Next:</b> {}</p>", escape(&verdict.next_experiment));
}

fn gap(page: &mut String, findings: &Findings) {
    let gap = &findings.verdict.gap;
    let _ = write!(
        page,
        "<h2>The gap</h2><p>Prediction errors in {}: the refitted nominal, the improved model, and what noise alone leaves.</p><table class=\"gap\"><tr><th>signal</th><th>before</th><th>after</th><th>floor</th><th></th></tr>",
        escape(gap.unit)
    );
    let whole = ("all".to_owned(), [gap.before, gap.after, gap.floor]);
    let rows = std::iter::once(whole).chain(gap.signals.clone());
    for (name, [before, after, floor]) in rows {
        // Decades above the floor, so that a gap of hundreds and one of a tenth both show.
        let reach = |value: f64| 100.0 * ((value / floor).max(1.0).log10() / 3.0).clamp(0.0, 1.0);
        let _ = write!(
            page,
            "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td class=\"bar\"><i class=\"before\" style=\"width:{:.1}%\"></i><i class=\"after\" style=\"width:{:.1}%\"></i></td></tr>",
            escape(&name),
            number(before),
            number(after),
            number(floor),
            reach(before).max(0.6),
            reach(after).max(0.6)
        );
    }
    page.push_str(
        "</table><p class=\"soft\">Bars: distance above the floor, three decades wide.</p>",
    );
}

fn place(page: &mut String, findings: &Findings) {
    let (place, push) = (&findings.verdict.whereabouts, &findings.push);
    if push.before.is_empty() {
        return;
    }
    let orders: Vec<String> = place.orders.iter().map(|order| number(*order)).collect();
    let along = if place.varies_with.is_empty() {
        String::new()
    } else {
        format!(", along {} ({:.0} % of it)", place.varies_with, 100.0 * place.explained)
    };
    let lines = if orders.is_empty() {
        String::new()
    } else {
        format!(" Orders per turn of the motor, strongest first: {}.", orders.join(", "))
    };
    let _ = write!(
        page,
        "<h2>Where they disagree</h2><p>A slow push on the <b>{}</b> would help the refitted nominal most{}.{}</p>",
        escape(&push.equation),
        escape(&along),
        escape(&lines)
    );
    let title = format!("push, {}", push.unit);
    let series = |xs: &[f64], before: &[f64], after: &[f64]| {
        let points = |ys: &[f64]| xs.iter().copied().zip(ys.iter().copied()).collect();
        [
            Series { class: "before", name: "before", points: points(before) },
            Series { class: "after", name: "with the effects", points: points(after) },
        ]
    };
    let shape = &findings.shape;
    if !shape.centres.is_empty() {
        let lines = series(&shape.centres, &shape.before, &shape.after);
        page.push_str(&plot(&shape.coordinate, &title, &lines, &[]));
    }
    let lines = series(&findings.time_s, &push.before, &push.after);
    page.push_str(&plot("t_s", &title, &lines, &[]));
}

fn errors(page: &mut String, findings: &Findings) {
    page.push_str(
        "<h2>Prediction errors</h2><p>One sample ahead, in noise sigmas. Shaded: parts that neither fit nor choice has seen. Drag to zoom, double-click to go back.</p>",
    );
    let shaded = held_out(findings);
    for channel in measured(findings) {
        let c = channel as usize;
        let points = |rows: &[[f64; 3]]| -> Vec<(f64, f64)> {
            findings.time_s.iter().copied().zip(rows.iter().map(|row| row[c])).collect()
        };
        let lines = [
            Series { class: "before", name: "before", points: points(&findings.before) },
            Series { class: "after", name: "with the effects", points: points(&findings.after) },
        ];
        page.push_str(&plot("t_s", &format!("{}, sigmas", channel.column()), &lines, &shaded));
    }
}

fn held_out(findings: &Findings) -> Vec<(f64, f64)> {
    let mut ranges: Vec<(f64, f64)> = Vec::new();
    let mut inside = false;
    for (time, held) in findings.time_s.iter().zip(&findings.held_out) {
        match (held, inside) {
            (true, false) => ranges.push((*time, *time)),
            (true, true) => {
                if let Some(last) = ranges.last_mut() {
                    last.1 = *time;
                }
            }
            _ => {}
        }
        inside = *held;
    }
    ranges
}

fn tables(page: &mut String, findings: &Findings) {
    if !findings.scores.is_empty() {
        page.push_str("<h2>Names that were tried</h2><p>What each would take from minus twice the log-likelihood: by one linear step, and after a full refit.</p><table><tr><th>round</th><th>name</th><th>linear</th><th>refitted</th></tr>");
        for row in &findings.scores {
            let refitted = row.refitted.map_or(String::new(), number);
            let _ = write!(
                page,
                "<tr><td>{}</td><td>{}</td><td>{}</td><td>{refitted}</td></tr>",
                row.round,
                escape(&row.name),
                number(row.score)
            );
        }
        page.push_str("</table>");
    }
    page.push_str("<h2>Parameters</h2><table><tr><th>parameter</th><th>nominal</th><th>refitted</th><th>improved</th><th>± relative</th></tr>");
    for row in &findings.parameters {
        let _ = write!(
            page,
            "<tr><td>{}</td><td>{:.4e}</td><td>{:.4e}</td><td>{:.4e}</td><td>{:.4}</td></tr>",
            escape(&row.key),
            row.nominal,
            row.refitted,
            row.improved,
            row.relative_sigma
        );
    }
    page.push_str("</table><h2>Noise</h2><table><tr><th>where</th><th>expected</th><th>before</th><th>after</th><th>unit</th></tr>");
    for row in &findings.noises {
        let _ = write!(
            page,
            "<tr><td>{}</td><td>{:.3e}</td><td>{:.3e}</td><td>{:.3e}</td><td>{}</td></tr>",
            escape(row.name),
            row.expected,
            row.before,
            row.after,
            escape(row.unit)
        );
    }
    page.push_str("</table>");
}
