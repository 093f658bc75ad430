//! A plot as SVG.
//!
//! The series sit in an inner drawing of their own, in its pixels; to zoom is to look at a part of
//! that drawing. So the data stand on the page once, and the plot is whole without the script.

use std::fmt::Write;

use super::axis::{Ruler, Scale};
use super::text::escape;
use super::thin::{range, thinned};
use super::{Mark, Plot, Series};

/// Room right of the field, above it for the title, and below it.
const RIGHT: f64 = 14.0;
const TITLE: f64 = 22.0;
const BELOW: f64 = 36.0;
/// Room left of the field at least, so that fields stand in line.
const LEFT: f64 = 64.0;
/// Width of a letter, about.
const LETTER: f64 = 6.4;

/// A point of a series: across and up from the lower left corner as shares of the field.
type Point = [f64; 2];

impl Plot<'_> {
    /// Width and height of the drawing, pixels.
    pub(super) fn outer(&self) -> [f64; 2] {
        let [width, height] = self.size;
        [self.left() + width + RIGHT, self.top() + height + BELOW]
    }

    /// As inline SVG; nothing where there is nothing to draw.
    pub fn svg(&self) -> String {
        self.at(0.0)
    }

    /// The same so far down in another drawing.
    pub(super) fn at(&self, down: f64) -> String {
        let Some([x, y]) = self.rulers() else { return String::new() };
        let ([width, height], [outer_width, outer_height]) = (self.size, self.outer());
        let (left, top) = (self.left(), self.top());
        let title = escape(&self.title);
        let zoom = if self.zoom { " zoom" } else { "" };
        let log = |ruler: &Ruler| u8::from(ruler.scale == Scale::Log);
        let mut svg = format!(
            "<svg class=\"plot{zoom}\" y=\"{down}\" width=\"{outer_width}\" \
             height=\"{outer_height}\" viewBox=\"0 0 {outer_width} {outer_height}\" role=\"img\" \
             aria-label=\"{title}\" data-x0=\"{:e}\" data-x1=\"{:e}\" data-xlog=\"{}\" \
             data-y0=\"{:e}\" data-y1=\"{:e}\" data-ylog=\"{}\">\
             <text x=\"{left}\" y=\"14\" class=\"title\">{title}</text><g class=\"ticks\">",
            x.low,
            x.high,
            log(&x),
            y.low,
            y.high,
            log(&y),
        );
        self.ticks(&mut svg, &x, &y);
        let _ = write!(
            svg,
            "</g><text x=\"{:.0}\" y=\"{:.0}\" text-anchor=\"middle\">{}</text>\
             <text transform=\"translate(12 {:.0}) rotate(-90)\" text-anchor=\"middle\">{}</text>\
             <svg class=\"field\" x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" preserveAspectRatio=\"none\">",
            left + 0.5 * width,
            outer_height - 4.0,
            escape(&x.label),
            top + 0.5 * height,
            escape(&y.label),
        );
        for [from, to] in &self.bands {
            let [from, to] = [from, to].map(|at| x.place(*at).clamp(0.0, 1.0) * width);
            let _ = write!(
                svg,
                "<rect class=\"shade\" x=\"{from:.2}\" y=\"-9999\" width=\"{:.2}\" \
                 height=\"19998\"/>",
                (to - from).max(1.0)
            );
        }
        for (k, series) in self.series.iter().enumerate() {
            let beside = if k == 0 { -2.0 } else { 2.0 };
            let _ = write!(svg, "<g class=\"{}\">", series.ink.class());
            Pen { svg: &mut svg, size: self.size, series }.draw(&x, &y, beside);
            svg.push_str("</g>");
        }
        let _ = write!(
            svg,
            "</svg><rect class=\"frame\" x=\"{left}\" y=\"{top}\" width=\"{width}\" \
             height=\"{height}\"/>",
        );
        self.explain(&mut svg);
        let _ = writeln!(
            svg,
            "<text class=\"hover\" x=\"{:.0}\" y=\"{:.0}\" text-anchor=\"end\"></text></svg>",
            left + width,
            top - 8.0
        );
        svg
    }

    /// The axes over what is seen of the data.
    fn rulers(&self) -> Option<[Ruler; 2]> {
        let seen = |x: f64, y: f64| {
            let inside = |range: Option<[f64; 2]>, value: f64| {
                range.is_none_or(|[low, high]| value >= low && value <= high)
            };
            let placed =
                |scale: Scale, v: f64| v.is_finite() && (scale == Scale::Linear || v > 0.0);
            inside(self.x.range, x) && placed(self.x.scale, x) && placed(self.y.scale, y)
        };
        let pairs = || {
            self.series.iter().flat_map(|s| {
                let high = s.x.iter().zip(s.high.iter());
                s.x.iter().zip(s.y.iter()).chain(high).filter(|(x, y)| seen(**x, **y))
            })
        };
        let x = range(pairs().map(|(x, _)| *x))?;
        let [low, high] = range(pairs().map(|(_, y)| *y))?;
        let bars = self.series.iter().any(|s| s.mark == Mark::Bars);
        let y = if bars { [low.min(0.0), high.max(0.0)] } else { [low, high] };
        let lines = self.series.iter().all(|s| matches!(s.mark, Mark::Line | Mark::Band));
        let margin = if lines { 0.0 } else { 0.03 };
        Some([Ruler::new(&self.x, x, margin), Ruler::new(&self.y, y, 0.05)])
    }

    /// Room for what is written beside the axis up.
    fn left(&self) -> f64 {
        let letters = self.y.ticks.iter().map(|(_, text)| text.chars().count()).max();
        LEFT.max(LETTER * letters.unwrap_or(0) as f64 + 12.0)
    }

    fn top(&self) -> f64 {
        if self.legend && !self.beside() { TITLE + 17.0 } else { TITLE }
    }

    /// Whether the legend fits beside the title.
    fn beside(&self) -> bool {
        let title = 1.25 * LETTER * self.title.chars().count() as f64;
        title + self.names().map(|(_, width)| width).sum::<f64>() < self.size[0]
    }

    /// Series with a name, and how wide their names are.
    fn names(&self) -> impl Iterator<Item = (&Series<'_>, f64)> {
        let named = self.series.iter().filter(|series| !series.name.is_empty());
        named.map(|series| (series, LETTER * series.name.chars().count() as f64 + 30.0))
    }

    fn explain(&self, svg: &mut String) {
        if !self.legend {
            return;
        }
        svg.push_str("<g class=\"names\">");
        let (top, right) = (self.top() - 8.0, self.left() + self.size[0]);
        let mut at = right - self.names().map(|(_, width)| width).sum::<f64>();
        for (series, width) in self.names() {
            let (from, to) = (at + 8.0, at + 22.0);
            let class = series.ink.class();
            let sign = match series.mark {
                Mark::Band => {
                    format!("<path class=\"area\" d=\"M{from} {}h14v8h-14z\"/>", top - 8.0)
                }
                Mark::Rings => {
                    format!("<path class=\"line dashed\" d=\"M{from} {y}H{to}\"/>", y = top - 4.0)
                }
                _ => format!("<path class=\"thick\" d=\"M{from} {y}H{to}\"/>", y = top - 4.0),
            };
            let _ = write!(
                svg,
                "<g class=\"{class}\">{sign}</g><text x=\"{:.1}\" y=\"{top}\">{}</text>",
                at + 26.0,
                escape(&series.name)
            );
            at += width;
        }
        svg.push_str("</g>");
    }

    fn ticks(&self, svg: &mut String, x: &Ruler, y: &Ruler) {
        let ([width, height], left, top) = (self.size, self.left(), self.top());
        let (right, bottom) = (left + width, top + height);
        for (place, label) in x.ticks((width / 95.0).max(3.0)) {
            let at = left + place * width;
            let _ = write!(
                svg,
                "<path d=\"M{at:.1} {top}V{bottom}\" class=\"grid\"/><text x=\"{at:.1}\" \
                 y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
                bottom + 14.0,
                escape(&label)
            );
        }
        for (place, label) in y.ticks((height / 28.0).clamp(3.0, 8.0)) {
            let at = bottom - place * height;
            let _ = write!(
                svg,
                "<path d=\"M{left} {at:.1}H{right}\" class=\"grid\"/><text x=\"{:.1}\" \
                 y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                left - 5.0,
                at + 3.5,
                escape(&label)
            );
        }
    }
}

/// Draws one series.
struct Pen<'p, 's> {
    svg: &'p mut String,
    size: [f64; 2],
    series: &'p Series<'s>,
}

impl Pen<'_, '_> {
    fn draw(&mut self, x: &Ruler, y: &Ruler, beside: f64) {
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
            Mark::Line => {
                let runs = runs();
                self.line("line", &runs);
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
