//! A plot as inline SVG: axes with ticks, bands, lines, dots and stems, and the marks by which the
//! page's script zooms it.
//!
//! The lines sit in an inner drawing of their own, in its pixels; to zoom is to look at a part of
//! that drawing. So the data stand on the page once, and the plot is whole without the script.

use std::fmt::Write;

use super::series::{range, thinned};
use super::text::escape;

const WIDTH: f64 = 960.0;
const LEFT: f64 = 62.0;
const RIGHT: f64 = 12.0;
const TOP: f64 = 22.0;
const BOTTOM: f64 = 36.0;

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mark {
    /// A line.
    Line,
    /// A line with a dot at each point.
    Dots,
    /// A stem from zero to each point.
    Stems,
}

/// A series of a plot.
pub(super) struct Series<'a> {
    /// Its name, which is its style as well: `before` or `after`.
    pub(super) name: &'static str,
    /// Across.
    pub(super) x: &'a [f64],
    /// Up.
    pub(super) y: &'a [f64],
}

/// A plot.
pub(super) struct Plot<'a> {
    /// What it shows.
    pub(super) title: &'a str,
    /// Quantity and unit across.
    pub(super) across: &'a str,
    /// Quantity and unit up.
    pub(super) up: &'a str,
    /// Height of the field, pixels.
    pub(super) height: f64,
    /// How the series are drawn.
    pub(super) mark: Mark,
    /// Shaded parts.
    pub(super) bands: &'a [[f64; 2]],
    /// The series, the hindmost first.
    pub(super) series: &'a [Series<'a>],
}

impl Plot<'_> {
    /// Draws it; nothing where there is nothing to draw.
    pub(super) fn draw(&self, page: &mut String) {
        let drawn = |s: &Series<'_>, axis: usize| {
            let points = s.x.iter().zip(s.y).filter(|(x, y)| x.is_finite() && y.is_finite());
            range(points.map(|(x, y)| if axis == 0 { *x } else { *y }))
        };
        let total = |axis| range(self.series.iter().filter_map(|s| drawn(s, axis)).flatten());
        let (Some(x), Some(y)) = (total(0), total(1)) else {
            return;
        };
        let x = if self.mark == Mark::Line { widened(x, 0.0) } else { widened(x, 0.02) };
        let zero = if self.mark == Mark::Stems { 0.0 } else { y[0] };
        let y = widened([y[0].min(zero), y[1].max(zero)], 0.05);
        let (outer_width, outer_height) = (WIDTH + LEFT + RIGHT, self.height + TOP + BOTTOM);
        let _ = write!(
            page,
            "<svg class=plot viewBox=\"0 0 {outer_width} {outer_height}\" role=img \
             aria-label=\"{title}\" data-x0={:e} data-x1={:e} data-y0={:e} data-y1={:e}>\
             <text x={LEFT} y=14 class=title>{title}</text><g class=ticks>",
            x[0],
            x[1],
            y[0],
            y[1],
            title = escape(self.title)
        );
        self.ticks(page, x, y);
        let _ = write!(
            page,
            "</g><text x={:.0} y={:.0} text-anchor=middle>{}</text>\
             <text transform=\"translate(12 {:.0}) rotate(-90)\" text-anchor=middle>{}</text>\
             <svg class=field x={LEFT} y={TOP} width={WIDTH} height={height} \
             viewBox=\"0 0 {WIDTH} {height}\" preserveAspectRatio=none>",
            LEFT + 0.5 * WIDTH,
            outer_height - 4.0,
            escape(self.across),
            TOP + 0.5 * self.height,
            escape(self.up),
            height = self.height
        );
        for [from, to] in self.bands {
            let (from, to) = (place(*from, x, WIDTH), place(*to, x, WIDTH));
            let _ = write!(
                page,
                "<rect class=band x={from:.2} y=-9999 width={:.2} height=19998 />",
                (to - from).max(1.0)
            );
        }
        for (k, series) in self.series.iter().enumerate() {
            self.series(page, series, k, x, y);
        }
        let _ = writeln!(
            page,
            "</svg><rect class=frame x={LEFT} y={TOP} width={WIDTH} height={} />\
             <text class=hover x={:.0} y=14 text-anchor=end></text></svg>",
            self.height,
            LEFT + WIDTH
        );
    }

    fn series(&self, page: &mut String, series: &Series<'_>, k: usize, x: [f64; 2], y: [f64; 2]) {
        let runs = thinned(series.x, series.y);
        let at = |p: &[f64; 2]| (place(p[0], x, WIDTH), self.height - place(p[1], y, self.height));
        let (mut line, mut dots) = (String::new(), String::new());
        let ground = self.height - place(0.0, y, self.height);
        for run in &runs {
            for (n, point) in run.iter().enumerate() {
                let (across, up) = at(point);
                if self.mark == Mark::Stems {
                    let beside = across + if k == 0 { -2.0 } else { 2.0 };
                    let _ = write!(line, "M{beside:.2} {ground:.2}L{beside:.2} {up:.2}");
                    continue;
                }
                let command = if n == 0 { 'M' } else { 'L' };
                let _ = write!(line, "{command}{across:.2} {up:.2}");
                if self.mark == Mark::Dots || run.len() == 1 {
                    let _ = write!(dots, "M{across:.2} {up:.2}h0");
                }
            }
        }
        let stem = if self.mark == Mark::Stems { " stem" } else { "" };
        let name = series.name;
        let _ = write!(page, "<path class=\"line {name}{stem}\" data-name={name} d=\"{line}\" />");
        if !dots.is_empty() {
            let _ = write!(page, "<path class=\"dot {name}\" d=\"{dots}\" />");
        }
    }

    fn ticks(&self, page: &mut String, x: [f64; 2], y: [f64; 2]) {
        let (right, bottom) = (LEFT + WIDTH, TOP + self.height);
        for (value, label) in ticks(x, 10.0) {
            let across = LEFT + place(value, x, WIDTH);
            let _ = write!(
                page,
                "<path d=\"M{across:.1} {TOP}V{bottom}\" class=grid /><text x={across:.1} y={:.1} \
                 text-anchor=middle>{label}</text>",
                bottom + 14.0
            );
        }
        for (value, label) in ticks(y, 5.0) {
            let up = bottom - place(value, y, self.height);
            let _ = write!(
                page,
                "<path d=\"M{LEFT} {up:.1}H{right}\" class=grid /><text x={:.1} y={:.1} \
                 text-anchor=end>{label}</text>",
                LEFT - 5.0,
                up + 3.5
            );
        }
    }
}

fn widened([low, high]: [f64; 2], share: f64) -> [f64; 2] {
    let span = high - low;
    let least = 1e-9 * low.abs().max(high.abs()).max(1e-20);
    let margin = if span > least { share * span } else { least.max(0.5 * low.abs()) };
    [low - margin, high + margin]
}

fn place(value: f64, [low, high]: [f64; 2], length: f64) -> f64 {
    (value - low) / (high - low) * length
}

/// Round values inside a range, about so many, with their labels.
pub(crate) fn ticks([low, high]: [f64; 2], about: f64) -> Vec<(f64, String)> {
    let raw = (high - low) / about;
    let power = 10.0_f64.powf(raw.log10().floor());
    let factors = [1.0, 2.0, 5.0, 10.0];
    let step = power * factors.into_iter().find(|f| f * power >= 0.999 * raw).unwrap_or(10.0);
    let decimals = (-step.log10().floor()).clamp(0.0, 20.0) as usize;
    let tiny = low.abs().max(high.abs()) < 1e-3 || high.abs().max(low.abs()) >= 1e6;
    let first = (low / step).ceil();
    (0..=(3.0 * about) as usize)
        .map(|k| (first + k as f64) * step)
        .take_while(|value| *value <= high + 1e-9 * step)
        .map(|value| {
            let value = if value.abs() < 1e-9 * step { 0.0 } else { value };
            let label = match value {
                0.0 => "0".to_owned(),
                _ if tiny => super::text::digits(value, 3),
                _ => format!("{value:.decimals$}"),
            };
            (value, label)
        })
        .collect()
}
