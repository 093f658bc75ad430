//! Line plots as SVG: few points, round ticks, nothing loaded from elsewhere.

use std::fmt::Write as _;

const WIDTH: f64 = 920.0;
const HEIGHT: f64 = 230.0;
const LEFT: f64 = 74.0;
const RIGHT: f64 = 12.0;
const TOP: f64 = 12.0;
const BOTTOM: f64 = 42.0;
/// Columns of pixels that a series is thinned to; each keeps its lowest and highest point.
const COLUMNS: usize = 900;

/// One line.
pub(super) struct Series<'a> {
    /// Class of the line, which gives its colour.
    pub(super) class: &'a str,
    /// Its name in the legend.
    pub(super) name: &'a str,
    /// Its points, in order of x; those that are not numbers are left out.
    pub(super) points: Vec<(f64, f64)>,
}

/// A plot with its axes; `shaded` are ranges of x in the background.
pub(super) fn plot(
    x_title: &str,
    y_title: &str,
    series: &[Series<'_>],
    shaded: &[(f64, f64)],
) -> String {
    let all = || series.iter().flat_map(|s| s.points.iter()).filter(|p| finite(p));
    let (x0, x1) = span(all().map(|p| p.0));
    let (y0, y1) = span(all().map(|p| p.1));
    let across = |x: f64| LEFT + (x - x0) / (x1 - x0) * (WIDTH - LEFT - RIGHT);
    let up = |y: f64| HEIGHT - BOTTOM - (y - y0) / (y1 - y0) * (HEIGHT - TOP - BOTTOM);
    let mut svg = format!(
        "<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" data-x0=\"{x0}\" data-x1=\"{x1}\">"
    );
    for (from, to) in shaded {
        let (a, b) = (across(from.max(x0)), across(to.min(x1)));
        let (width, height) = ((b - a).max(0.0), HEIGHT - TOP - BOTTOM);
        let _ = write!(
            svg,
            "<rect class=\"held\" x=\"{a:.1}\" y=\"{TOP}\" width=\"{width:.1}\" height=\"{height:.1}\"/>"
        );
    }
    for tick in ticks(y0, y1, 5) {
        let y = up(tick);
        let _ = write!(
            svg,
            "<line class=\"grid\" x1=\"{LEFT}\" x2=\"{:.1}\" y1=\"{y:.1}\" y2=\"{y:.1}\"/><text x=\"{:.1}\" y=\"{:.1}\" class=\"tick end\">{}</text>",
            WIDTH - RIGHT,
            LEFT - 6.0,
            y + 4.0,
            number(tick)
        );
    }
    for tick in ticks(x0, x1, 9) {
        let x = across(tick);
        let _ = write!(
            svg,
            "<line class=\"grid\" x1=\"{x:.1}\" x2=\"{x:.1}\" y1=\"{TOP}\" y2=\"{:.1}\"/><text x=\"{x:.1}\" y=\"{:.1}\" class=\"tick middle\">{}</text>",
            HEIGHT - BOTTOM,
            HEIGHT - BOTTOM + 15.0,
            number(tick)
        );
    }
    for line in series {
        let mut path = String::new();
        for (k, (x, y)) in thinned(&line.points, x0, x1).iter().enumerate() {
            let _ =
                write!(path, "{}{:.1} {:.1}", if k == 0 { 'M' } else { 'L' }, across(*x), up(*y));
        }
        let _ = write!(
            svg,
            "<path class=\"{}\" d=\"{path}\"><title>{}</title></path>",
            line.class,
            escape(line.name)
        );
    }
    let _ = write!(
        svg,
        "<text class=\"title middle\" x=\"{:.1}\" y=\"{:.1}\">{}</text><text class=\"title middle\" transform=\"translate(13 {:.1}) rotate(-90)\">{}</text></svg>",
        (LEFT + WIDTH - RIGHT) / 2.0,
        HEIGHT - 8.0,
        escape(x_title),
        (TOP + HEIGHT - BOTTOM) / 2.0,
        escape(y_title)
    );
    let mut legend = String::new();
    for line in series {
        let _ = write!(legend, "<span class=\"key {}\"></span>{} ", line.class, escape(line.name));
    }
    format!("<figure>{svg}<figcaption>{legend}</figcaption></figure>")
}

fn finite(point: &&(f64, f64)) -> bool {
    point.0.is_finite() && point.1.is_finite()
}

/// Least and greatest, with a little room where they meet.
fn span(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) =
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    if !low.is_finite() || !high.is_finite() {
        return (0.0, 1.0);
    }
    if high - low > 1e-300 { (low, high) } else { (low - 1.0, high + 1.0) }
}

/// Round numbers between two values, about that many.
fn ticks(low: f64, high: f64, about: usize) -> Vec<f64> {
    let rough = (high - low) / about as f64;
    let power = 10_f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|s| *s >= rough);
    let step = step.unwrap_or(10.0 * power);
    let first = (low / step).ceil() as i64;
    let last = (high / step).floor() as i64;
    if last - first > 50 {
        return Vec::new();
    }
    (first..=last).map(|k| k as f64 * step).collect()
}

/// Lowest and highest point of every column, in the order in which they come.
fn thinned(points: &[(f64, f64)], x0: f64, x1: f64) -> Vec<(f64, f64)> {
    let column = |x: f64| (((x - x0) / (x1 - x0) * COLUMNS as f64) as usize).min(COLUMNS);
    let mut kept: Vec<(f64, f64)> = Vec::new();
    let mut bin: Option<(usize, [(f64, f64); 2])> = None;
    let close = |kept: &mut Vec<(f64, f64)>, [low, high]: [(f64, f64); 2]| {
        let (first, second) = if low.0 <= high.0 { (low, high) } else { (high, low) };
        kept.push(first);
        if first != second {
            kept.push(second);
        }
    };
    for point in points.iter().filter(finite) {
        let own = column(point.0);
        match &mut bin {
            Some((number, [low, high])) if *number == own => {
                if point.1 < low.1 {
                    *low = *point;
                }
                if point.1 > high.1 {
                    *high = *point;
                }
            }
            _ => {
                if let Some((_, ends)) = bin {
                    close(&mut kept, ends);
                }
                bin = Some((own, [*point; 2]));
            }
        }
    }
    if let Some((_, ends)) = bin {
        close(&mut kept, ends);
    }
    kept
}

/// A number in few digits.
pub(super) fn number(value: f64) -> String {
    if !value.is_finite() {
        return "–".to_owned();
    }
    let size = value.abs();
    if size != 0.0 && !(1e-3..1e5).contains(&size) {
        return format!("{value:.3e}");
    }
    let text = format!("{value:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Text that is safe in a page.
pub(super) fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
