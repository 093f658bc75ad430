//! Plots as SVG: panels one above the other, as the paper stacks its a), b) and c).

use std::fmt::Write;

use crate::report::plot::ticks;
use crate::report::series::{range, thinned};
use crate::report::text::escape;

const WIDTH: f64 = 760.0;
const LEFT: f64 = 78.0;
const RIGHT: f64 = 30.0;
const TOP: f64 = 26.0;
const HEIGHT: f64 = 220.0;
const BOTTOM: f64 = 44.0;
const COLOURS: [&str; 5] = ["#111111", "#0072b2", "#d55e00", "#009e73", "#cc79a7"];

const STYLE: &str = "text{font:12px sans-serif;fill:#222}.title{font-weight:bold}\
    .grid{stroke:#e2e2e2;fill:none}.frame{stroke:#666;fill:none}.line{fill:none;stroke-width:1.3}";

/// A named line.
pub struct Line {
    /// What it is.
    pub name: String,
    /// Across.
    pub x: Vec<f64>,
    /// Up.
    pub y: Vec<f64>,
}

/// How the axes of a panel run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axes {
    /// Evenly.
    Linear,
    /// By powers of ten, with a dot at each point.
    Logarithmic,
}

/// One panel.
pub struct Panel {
    /// What it shows.
    pub title: String,
    /// Quantity and unit across.
    pub across: &'static str,
    /// Quantity and unit up.
    pub up: &'static str,
    /// Part of the horizontal axis that is shown; all where there is none.
    pub window: Option<[f64; 2]>,
    /// Axes.
    pub axes: Axes,
    /// Lines, the hindmost first.
    pub lines: Vec<Line>,
}

/// The panels as one drawing.
pub fn svg(panels: &[Panel]) -> String {
    let each = TOP + HEIGHT + BOTTOM;
    let (width, height) = (LEFT + WIDTH + RIGHT, each * panels.len() as f64);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\"><style>{STYLE}</style>\
         <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>"
    );
    for (k, panel) in panels.iter().enumerate() {
        let _ = write!(out, "<g transform=\"translate({LEFT} {})\">", TOP + each * k as f64);
        panel.draw(&mut out, k);
        out.push_str("</g>");
    }
    out.push_str("</svg>\n");
    out
}

impl Panel {
    fn scaled(&self, value: f64) -> f64 {
        if self.axes == Axes::Logarithmic { value.log10() } else { value }
    }

    fn points(&self, line: &Line) -> (Vec<f64>, Vec<f64>) {
        let pairs = line.x.iter().zip(&line.y).map(|(x, y)| (self.scaled(*x), self.scaled(*y)));
        let seen = |x: f64| self.window.is_none_or(|[low, high]| x >= low && x <= high);
        pairs.filter(|(x, y)| y.is_finite() && seen(*x)).unzip()
    }

    fn draw(&self, out: &mut String, number: usize) {
        let lines: Vec<(Vec<f64>, Vec<f64>)> = self.lines.iter().map(|l| self.points(l)).collect();
        let x = range(lines.iter().flat_map(|(x, _)| x.iter().copied()));
        let y = range(lines.iter().flat_map(|(_, y)| y.iter().copied()));
        let (Some(x), Some(y)) = (x, y) else { return };
        let wide = |[low, high]: [f64; 2], share: f64| {
            let margin = (share * (high - low)).max(1e-9 * high.abs()).max(1e-12);
            [low - margin, high + margin]
        };
        let margin = if self.axes == Axes::Logarithmic { 0.03 } else { 0.0 };
        let (x, y) = (wide(x, margin), wide(y, 0.06));
        let across = |value: f64| (value - x[0]) / (x[1] - x[0]) * WIDTH;
        let up = |value: f64| HEIGHT - (value - y[0]) / (y[1] - y[0]) * HEIGHT;
        for (value, label) in self.ticks(x, 10.0) {
            let at = across(value);
            let _ = write!(
                out,
                "<path class=\"grid\" d=\"M{at:.1} 0V{HEIGHT}\"/>\
                 <text x=\"{at:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{label}</text>",
                HEIGHT + 15.0
            );
        }
        for (value, label) in self.ticks(y, 6.0) {
            let at = up(value);
            let _ = write!(
                out,
                "<path class=\"grid\" d=\"M0 {at:.1}H{WIDTH}\"/>\
                 <text x=\"-5\" y=\"{:.1}\" text-anchor=\"end\">{label}</text>",
                at + 4.0
            );
        }
        let letter = char::from(b'a' + (number % 26) as u8);
        let _ = write!(
            out,
            "<clipPath id=\"p{number}\"><rect width=\"{WIDTH}\" height=\"{HEIGHT}\"/></clipPath>\
             <rect class=\"frame\" width=\"{WIDTH}\" height=\"{HEIGHT}\"/>\
             <text class=\"title\" x=\"0\" y=\"-9\">{letter}) {}</text>\
             <text x=\"{:.0}\" y=\"{:.0}\" text-anchor=\"middle\">{}</text>\
             <text transform=\"translate(-62 {:.0}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
            escape(&self.title),
            WIDTH / 2.0,
            HEIGHT + 34.0,
            escape(self.across),
            HEIGHT / 2.0,
            escape(self.up)
        );
        let mut legend = WIDTH;
        for (k, line) in self.lines.iter().enumerate().rev() {
            let colour = COLOURS[k % COLOURS.len()];
            let _ = write!(
                out,
                "<text x=\"{legend:.0}\" y=\"-9\" text-anchor=\"end\" style=\"fill:{colour}\">\
                 &#9632; {}</text>",
                escape(&line.name)
            );
            legend -= 7.0 * line.name.chars().count() as f64 + 26.0;
        }
        for (k, (xs, ys)) in lines.iter().enumerate() {
            let colour = COLOURS[k % COLOURS.len()];
            let mut path = String::new();
            let mut dots = String::new();
            for run in thinned(xs, ys) {
                for (n, [px, py]) in run.iter().enumerate() {
                    let command = if n == 0 { 'M' } else { 'L' };
                    let _ = write!(path, "{command}{:.2} {:.2}", across(*px), up(*py));
                    if self.axes == Axes::Logarithmic {
                        let _ = write!(
                            dots,
                            "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"3\" fill=\"{colour}\"/>",
                            across(*px),
                            up(*py)
                        );
                    }
                }
            }
            let _ = write!(
                out,
                "<g clip-path=\"url(#p{number})\"><path class=\"line\" stroke=\"{colour}\" \
                 d=\"{path}\"/>{dots}</g>"
            );
        }
    }

    fn ticks(&self, span: [f64; 2], about: f64) -> Vec<(f64, String)> {
        if self.axes == Axes::Linear {
            return ticks(span, about);
        }
        let decades = span[0].ceil() as i32..=span[1].floor() as i32;
        decades
            .map(|power| {
                let label = match power {
                    -3..=3 => format!("{}", 10.0_f64.powi(power)),
                    _ => format!("1e{power}"),
                };
                (f64::from(power), label)
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panel_shows_its_window_and_escapes_its_names() {
        let line =
            Line { name: "a<b".to_owned(), x: vec![0.0, 1.0, 2.0], y: vec![5.0, 7.0, 900.0] };
        let panel = Panel {
            title: "speed".to_owned(),
            across: "t, s",
            up: "rad/s",
            window: Some([0.0, 1.0]),
            axes: Axes::Linear,
            lines: vec![line],
        };
        let drawing = svg(&[panel]);
        assert!(drawing.contains("a&lt;b") && !drawing.contains("a<b"));
        // What lies outside the window stretches no axis.
        assert!(!drawing.contains("900") && drawing.contains("a) speed"));
    }
}
