//! A page that opens offline, and a picture that stands alone: both with the one stylesheet.

use super::Plot;
use super::text::escape;

const PLOT_STYLE: &str = include_str!("plot.css");
const PAGE_STYLE: &str = include_str!("page.css");
const ZOOM: &str = include_str!("zoom.js");

/// A page of this title; the body is HTML.
pub fn page(title: &str, body: &str) -> String {
    format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width\"><title>{}</title>\
         <style>{PLOT_STYLE}{PAGE_STYLE}</style></head><body>\n{body}\n\
         <script>{ZOOM}</script></body></html>\n",
        escape(title)
    )
}

/// Plots one above the other as an SVG file.
pub fn picture(plots: &[Plot<'_>]) -> String {
    let width = plots.iter().map(|plot| plot.outer()[0]).fold(0.0, f64::max);
    let (mut drawn, mut down) = (String::new(), 0.0);
    for plot in plots {
        drawn.push_str(&plot.at(down));
        down += plot.outer()[1] + GAP;
    }
    let height = (down - GAP).max(0.0);
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\"><style>{PLOT_STYLE}</style>\
         <rect class=\"sheet\" width=\"100%\" height=\"100%\"/>\n{drawn}</svg>\n"
    )
}

/// Between two plots of a picture, pixels.
const GAP: f64 = 8.0;
