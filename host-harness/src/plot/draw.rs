//! A plot as SVG.
//!
//! The series sit in an inner drawing of their own, in its pixels; to zoom is to look at a part of
//! that drawing. So the data stand on the page once, and the plot is whole without the script.

use std::fmt::Write;

use super::axis::{Ruler, Scale};
use super::pen::Pen;
use super::text::escape;
use super::thin::range;
use super::{Mark, Plot, Series};

/// Room right of the field, above it for the title or where the page has that, and below it.
const RIGHT: f64 = 14.0;
const TITLE: f64 = 22.0;
const ABOVE: f64 = 8.0;
const BELOW: f64 = 36.0;
/// Room left of the field at least, so that fields stand in line.
const LEFT: f64 = 64.0;
/// Width of a letter, about.
const LETTER: f64 = 6.4;

impl Plot<'_> {
    /// Width and height of the drawing, pixels.
    pub(super) fn outer(&self) -> [f64; 2] {
        let [width, height] = self.size;
        [self.left() + width + RIGHT, self.top() + height + BELOW]
    }

    /// On a page: its title, legend and readout as text that wraps, and under them the drawing. Nothing where
    /// there is nothing to draw.
    pub fn svg(&self) -> String {
        let Some([x, y]) = self.rulers() else { return String::new() };
        let title = escape(&self.title);
        let mut figure = format!("<figure class=\"panel\"><figcaption><b>{title}</b>");
        if self.legend {
            figure.push_str(&self.keys());
        }
        if self.zoom {
            figure.push_str(
                "<button type=\"button\" class=\"reset\" hidden>whole range</button>\
                 <span class=\"hover\"></span>",
            );
        }
        figure.push_str("</figcaption>");
        self.drawn(&mut figure, [&x, &y], [0.0, ABOVE]);
        figure.push_str("</figure>\n");
        figure
    }

    /// So far down in another drawing, with title and legend.
    pub(super) fn at(&self, down: f64) -> String {
        let Some([x, y]) = self.rulers() else { return String::new() };
        let mut svg = String::new();
        self.drawn(&mut svg, [&x, &y], [down, self.top()]);
        svg
    }

    /// The drawing: so far down in another one, with so much room above the field.
    fn drawn(&self, svg: &mut String, [x, y]: [&Ruler; 2], [down, top]: [f64; 2]) {
        let ([width, height], left) = (self.size, self.left());
        let [outer_width, outer_height] = [left + width + RIGHT, top + height + BELOW];
        let title = escape(&self.title);
        let zoom = if self.zoom { " zoom" } else { "" };
        let log = |ruler: &Ruler| u8::from(ruler.scale == Scale::Log);
        let _ = write!(
            svg,
            "<svg class=\"plot{zoom}\" y=\"{down}\" width=\"{outer_width}\" \
             height=\"{outer_height}\" viewBox=\"0 0 {outer_width} {outer_height}\" role=\"img\" \
             aria-label=\"{title}\" data-x0=\"{:e}\" data-x1=\"{:e}\" data-xlog=\"{}\" \
             data-y0=\"{:e}\" data-y1=\"{:e}\" data-ylog=\"{}\" data-link=\"{}\" data-unit=\"{:e}\" \
             data-marked=\"{}{}\">",
            x.low,
            x.high,
            log(x),
            y.low,
            y.high,
            log(y),
            escape(self.link),
            x.per_unit(),
            if self.x.ticks.is_empty() { "" } else { "x" },
            if self.y.ticks.is_empty() { "" } else { "y" },
        );
        if top > ABOVE {
            let _ = write!(svg, "<text x=\"{left}\" y=\"14\" class=\"title\">{title}</text>");
            self.explain(svg);
        }
        svg.push_str("<g class=\"ticks\">");
        self.ticks(svg, [x, y], top);
        let _ = write!(
            svg,
            "</g><text class=\"across\" x=\"{:.0}\" y=\"{:.0}\" text-anchor=\"middle\">{}</text>\
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
            Pen { svg: &mut *svg, size: self.size, series }.draw(x, y, beside);
            svg.push_str("</g>");
        }
        let _ = writeln!(
            svg,
            "</svg><rect class=\"frame\" x=\"{left}\" y=\"{top}\" width=\"{width}\" \
             height=\"{height}\"/></svg>",
        );
    }

    /// The legend of a page.
    fn keys(&self) -> String {
        let mut text = String::from("<span class=\"names\">");
        for (series, _) in self.names() {
            let sign = match series.mark {
                Mark::Band => "band",
                Mark::Rings => "broken",
                Mark::Points | Mark::Dots => "round",
                Mark::Bars => "block",
                Mark::Broad => "broad",
                _ => "level",
            };
            let class = series.ink.class();
            let name = escape(&series.name);
            let _ = write!(text, "<span><i class=\"key {sign} {class}\"></i>{name}</span> ");
        }
        text.push_str("</span>");
        text
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
        let lines =
            self.series.iter().all(|s| matches!(s.mark, Mark::Line | Mark::Broad | Mark::Band));
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

    fn ticks(&self, svg: &mut String, [x, y]: [&Ruler; 2], top: f64) {
        let ([width, height], left) = (self.size, self.left());
        let (right, bottom) = (left + width, top + height);
        for (place, label) in x.ticks((width / 80.0).max(4.0)) {
            let (at, share) = (left + place * width, (1e4 * place).round() / 1e4);
            let whole = right + RIGHT - 0.5 * LETTER * label.chars().count() as f64;
            let _ = write!(
                svg,
                "<path d=\"M{at:.1} {top}V{bottom}\" class=\"grid\" data-of=\"x\" data-at=\"{share}\"/>\
                 <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\" data-of=\"x\" \
                 data-at=\"{share}\">{}</text>",
                at.min(whole),
                bottom + 14.0,
                escape(&label)
            );
        }
        for (place, label) in y.ticks((height / 28.0).clamp(3.0, 8.0)) {
            let at = bottom - place * height;
            let _ = write!(
                svg,
                "<path d=\"M{left} {at:.1}H{right}\" class=\"grid\" data-of=\"y\"/><text x=\"{:.1}\" \
                 y=\"{:.1}\" text-anchor=\"end\" data-of=\"y\">{}</text>",
                left - 5.0,
                at + 3.5,
                escape(&label)
            );
        }
    }
}
