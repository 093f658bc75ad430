//! The gap at a glance: before, after and floor per signal, as dots on one logarithmic axis.

use std::fmt::Write;

use super::series::range;
use super::text::{escape, number};
use crate::discover::findings::Gap;

const WIDTH: f64 = 560.0;
const LEFT: f64 = 130.0;
const RIGHT: f64 = 16.0;
const ROW: f64 = 30.0;
const TOP: f64 = 8.0;
/// Ticks of a logarithmic axis within a decade.
const WITHIN: [f64; 3] = [1.0, 2.0, 5.0];

/// The gap as a plot and a table.
pub(super) fn section(page: &mut String, gap: &Gap) {
    let mut rows = vec![("all signals", [gap.before, gap.after, gap.floor])];
    rows.extend(gap.signals.iter().map(|(name, values)| (name.as_str(), *values)));
    page.push_str("<div class=side>");
    dots(page, &rows, gap.unit);
    page.push_str(
        "<table><tr><th>signal<th class=n>before<th class=n>after<th class=n>floor</tr>\n",
    );
    for (name, values) in &rows {
        let [before, after, floor] = values.map(number);
        let _ = writeln!(
            page,
            "<tr><td>{}<td class=n>{before}<td class=n>{after}<td class=n>{floor}</tr>",
            escape(name)
        );
    }
    let _ = writeln!(page, "</table></div><p class=note>{}</p>", escape(gap.unit));
}

fn dots(page: &mut String, rows: &[(&str, [f64; 3])], unit: &str) {
    let shown = |value: &f64| value.is_finite() && *value > 0.0;
    let values = rows.iter().flat_map(|(_, values)| *values).filter(shown);
    let Some([low, high]) = range(values) else {
        return;
    };
    let (low, high) = ((low / 1.25).ln(), (high * 1.25).ln());
    let across = |value: f64| LEFT + (value.ln() - low) / (high - low) * (WIDTH - LEFT - RIGHT);
    let bottom = TOP + ROW * rows.len() as f64;
    let _ = write!(
        page,
        "<svg class=gap viewBox=\"0 0 {WIDTH} {:.0}\" role=img aria-label=\"gap by signal\">",
        bottom + 34.0
    );
    for (value, label) in decades(low, high) {
        let x = across(value);
        let _ = write!(
            page,
            "<path d=\"M{x:.1} {TOP}V{bottom}\" class=grid /><text x={x:.1} y={:.1} \
             text-anchor=middle>{label}</text>",
            bottom + 13.0
        );
    }
    for (k, (name, values)) in rows.iter().enumerate() {
        let y = TOP + ROW * (k as f64 + 0.5);
        let _ = write!(
            page,
            "<text x={:.0} y={:.1} text-anchor=end>{}</text>",
            LEFT - 8.0,
            y + 3.5,
            escape(name)
        );
        let [before, after, floor] = *values;
        if shown(&before) && shown(&after) {
            let (from, to) = (across(before), across(after));
            let _ = write!(page, "<path class=way d=\"M{from:.1} {y:.1}H{to:.1}\" />");
        }
        if shown(&floor) {
            let x = across(floor);
            let _ = write!(
                page,
                "<path class=floor d=\"M{x:.1} {:.1}v20\"><title>floor {}</title></path>",
                y - 10.0,
                number(floor)
            );
        }
        for (class, value) in [("before", before), ("after", after)] {
            if shown(&value) {
                let _ = write!(
                    page,
                    "<circle class={class} cx={:.1} cy={y:.1} r=6><title>{class} {}</title>\
                     </circle>",
                    across(value),
                    number(value)
                );
            }
        }
    }
    let _ = writeln!(
        page,
        "<text x={:.0} y={:.0} text-anchor=middle>{}</text></svg>",
        0.5 * (LEFT + WIDTH - RIGHT),
        bottom + 29.0,
        escape(unit)
    );
}

/// Ticks between two logarithms: 1, 2, 5 per decade, or only decades where there are many.
fn decades(low: f64, high: f64) -> Vec<(f64, String)> {
    let ten = std::f64::consts::LN_10;
    let (first, last) = ((low / ten).floor() as i32, (high / ten).ceil() as i32);
    let within = if last - first > 4 { &WITHIN[..1] } else { &WITHIN[..] };
    (first..=last)
        .flat_map(|decade| within.iter().map(move |factor| (decade, factor)))
        .map(|(decade, factor)| factor * 10.0_f64.powi(decade))
        .filter(|value| (low..=high).contains(&value.ln()))
        .map(|value| (value, super::text::digits(value, 1)))
        .collect()
}
