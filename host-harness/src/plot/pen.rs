//! Draws one series into the field of a plot.

use std::fmt::Write;

use super::axis::Ruler;
use super::text::escape;
use super::thin::thinned;
use super::{Mark, Series};

/// A point of a series: across and up from the lower left corner as shares of the field.
type Point = [f64; 2];

/// Draws one series.
pub(super) struct Pen<'p, 's> {
    pub(super) svg: &'p mut String,
    pub(super) size: [f64; 2],
    pub(super) series: &'p Series<'s>,
}

impl Pen<'_, '_> {
    pub(super) fn draw(&mut self, x: &Ruler, y: &Ruler, beside: f64) {
        let series = self.series;
        let across: Vec<f64> = series.x.iter().map(|value| x.place(*value)).collect();
        // What lies outside an axis that says its range is cut off here, not thinned with the rest.
        let across: Vec<f64> = across
            .into_iter()
            .map(|at| if (-1e-9..=1.0 + 1e-9).contains(&at) { at } else { f64::NAN })
            .collect();
        let up: Vec<f64> = series.y.iter().map(|value| y.place(*value)).collect();
        let points = || across.iter().zip(&up).map(|(a, b)| [*a, *b]);
        let finite = |p: &Point| p.iter().all(|value| value.is_finite());
        let inside = |p: &Point| p.iter().all(|value| (-1e-9..=1.0 + 1e-9).contains(value));
        let runs = || thinned(&across, &up);
        match series.mark {
            Mark::Line | Mark::Broad => {
                let runs = runs();
                let broad = series.mark == Mark::Broad;
                self.line(if broad { "line broad" } else { "line" }, &runs);
                let lone = runs.iter().filter(|run| run.len() == 1).flatten().copied();
                self.dots("dot", lone.collect::<Vec<_>>());
            }
            Mark::Dots | Mark::Rings => {
                let ring = series.mark == Mark::Rings;
                self.line(if ring { "line dashed" } else { "line" }, &runs());
                self.dots("dot", points().filter(finite).collect::<Vec<_>>());
                if ring {
                    self.dots("dot hole", points().filter(finite).collect::<Vec<_>>());
                }
            }
            Mark::Points => self.dots("dot large", points().filter(finite).collect::<Vec<_>>()),
            Mark::Bars => {
                let ground = y.place(0.0);
                let bars = points().filter(finite).map(|[a, b]| {
                    let shifted = a + beside / self.size[0];
                    vec![[shifted, ground], [shifted, b]]
                });
                self.line("line stem", &bars.collect::<Vec<_>>());
            }
            Mark::Levels | Mark::Uprights => {
                let [a, b] = self.size.map(|length| 1.0 / length);
                let side =
                    if series.mark == Mark::Levels { [16.0 * a, 0.0] } else { [0.0, 10.0 * b] };
                let marks = points().filter(finite);
                let marks = marks
                    .map(|[a, b]| vec![[a - side[0], b - side[1]], [a + side[0], b + side[1]]]);
                self.line("thick", &marks.collect::<Vec<_>>());
            }
            Mark::Links => {
                let links = points().collect::<Vec<_>>();
                let links = links.chunks_exact(2).filter(|pair| pair.iter().all(finite));
                self.line("dotted", &links.map(<[Point]>::to_vec).collect::<Vec<_>>());
            }
            Mark::Band => {
                let high: Vec<f64> = series.high.iter().map(|value| y.place(*value)).collect();
                let (low, high) = (runs(), thinned(&across, &high));
                for (low, high) in low.into_iter().zip(high) {
                    let around = [low, high.into_iter().rev().collect()].concat();
                    self.line("area", &[around]);
                }
            }
        }
        for ([a, b], label) in points().zip(&series.labels).filter(|(p, _)| inside(p)) {
            let [a, b] = self.pixels([a, b]);
            let _ = write!(
                self.svg,
                "<text x=\"{:.1}\" y=\"{:.1}\">{}</text>",
                a + 6.0,
                b - 6.0,
                escape(label)
            );
        }
    }

    fn pixels(&self, [across, up]: Point) -> Point {
        let [width, height] = self.size;
        // Far outside is as good as further.
        [across * width, height - up.clamp(-9.0, 10.0) * height]
    }

    fn line(&mut self, class: &str, runs: &[Vec<Point>]) {
        let mut path = String::new();
        for (n, point) in runs.iter().flat_map(|run| run.iter().enumerate()) {
            let [across, up] = self.pixels(*point);
            let _ = write!(path, "{}{across:.2} {up:.2}", if n == 0 { 'M' } else { 'L' });
        }
        if !path.is_empty() {
            let name = escape(&self.series.name);
            let _ = write!(self.svg, "<path class=\"{class}\" data-name=\"{name}\" d=\"{path}\"/>");
        }
    }

    /// Dots as lines without length, which keep their shape in a drawing that is stretched.
    fn dots(&mut self, class: &str, points: Vec<Point>) {
        if points.is_empty() {
            return;
        }
        let mut path = String::new();
        let mut notes = self.series.notes.iter();
        for point in points {
            let [across, up] = self.pixels(point);
            let dot = format!("M{across:.2} {up:.2}h0");
            match notes.next() {
                Some(note) => {
                    let note = escape(note);
                    let _ = write!(
                        self.svg,
                        "<path class=\"{class}\" d=\"{dot}\"><title>{note}</title></path>"
                    );
                }
                None => path.push_str(&dot),
            }
        }
        if !path.is_empty() {
            let _ = write!(self.svg, "<path class=\"{class}\" d=\"{path}\"/>");
        }
    }
}
