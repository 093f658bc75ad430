//! The gap at a glance: before, after and floor per signal, as dots on one logarithmic axis.

use std::fmt::Write;

use crate::discover::findings::Gap;
use crate::plot::text::{escape, number};
use crate::plot::{Axis, Ink, Mark, Plot, Series};

const WIDTH: f64 = 414.0;
const ROW: f64 = 30.0;

/// The gap as a plot and a table.
pub(super) fn section(page: &mut String, gap: &Gap) {
    let mut rows = vec![("all signals", [gap.before, gap.after, gap.floor])];
    rows.extend(gap.signals.iter().map(|(name, values)| (name.as_str(), *values)));
    let _ = write!(page, "<div class=\"side\">{}", dots(&rows, gap.unit).svg());
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

/// The rows from the top down, each at half its height.
fn dots<'a>(rows: &[(&'a str, [f64; 3])], unit: &'a str) -> Plot<'a> {
    let count = rows.len() as f64;
    let up = |k: usize| count - 0.5 - k as f64;
    let names = rows.iter().enumerate().map(|(k, (name, _))| (up(k), (*name).to_owned()));
    let names = Axis::linear("", "").within([0.0, count]).marked(names.collect());
    let ups: Vec<f64> = (0..rows.len()).map(up).collect();
    let series = |which: usize, name: &'static str, ink, mark| {
        let values: Vec<f64> = rows.iter().map(|(_, values)| values[which]).collect();
        let notes = values.iter().map(|value| format!("{name} {}", number(*value)));
        let notes = notes.collect();
        Series { notes, ..Series::new(name, ink, mark, values, ups.clone()) }
    };
    let ways = rows.iter().enumerate().flat_map(|(k, (_, v))| [(v[0], up(k)), (v[1], up(k))]);
    let (from, to): (Vec<f64>, Vec<f64>) = ways.unzip();
    Plot {
        zoom: false,
        series: vec![
            Series::new("", Ink::Soft, Mark::Links, from, to),
            series(2, "floor", Ink::Text, Mark::Uprights),
            series(0, "before", Ink::Before, Mark::Points),
            series(1, "after", Ink::After, Mark::Points),
        ],
        ..Plot::new("Gap by signal", Axis::log(unit, ""), names).sized(WIDTH, ROW * count)
    }
}
