//! Plots for every page and picture: what is to be drawn is said here once, and drawn in one way.
//!
//! A [`Plot`] is a panel: two axes and series of points. It becomes inline SVG on a page ([`page`]), or,
//! alone or above others, a picture of its own ([`picture`]). Colours are names that the stylesheet
//! resolves, for light and dark; the same stylesheet goes into pages and pictures. On a page a script
//! zooms; without it every plot is whole.

mod axis;
mod draw;
mod legend;
mod page;
mod pen;
mod stack;
#[cfg(test)]
mod tests;
pub mod text;
mod thin;

pub use axis::{Axis, Scale};
pub use legend::{Legend, legend};
pub use page::{page, picture};
pub use stack::{Part, stack};
pub use thin::bands;

use std::borrow::Cow;

/// What colours a series.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ink {
    /// The model before.
    Before,
    /// The model after.
    After,
    /// A level that nothing can pass, or the truth.
    Text,
    /// What stands back.
    Soft,
    /// What stands back further: noise.
    Faint,
    /// What is not explained, or breaks a bound.
    Wrong,
    /// One of many, told apart by number.
    Nth(usize),
}

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// A line through the points, thinned to what a screen shows.
    Line,
    /// A broad line, under which others may lie.
    Broad,
    /// A line with a dot at each point.
    Dots,
    /// A dashed line with a ring at each point.
    Rings,
    /// Large dots, nothing between them.
    Points,
    /// A bar from zero to each point.
    Bars,
    /// A short level line at each point.
    Levels,
    /// A short upright line at each point.
    Uprights,
    /// A dotted line between each two points.
    Links,
    /// The area between the points and [`Series::high`].
    Band,
}

/// A series of a plot.
#[derive(Clone, Debug)]
pub struct Series<'a> {
    /// What the legend and the readout call it.
    pub name: Cow<'a, str>,
    /// Its colour.
    pub ink: Ink,
    /// How it is drawn.
    pub mark: Mark,
    /// Values across; a point with a value that is not finite is left out.
    pub x: Cow<'a, [f64]>,
    /// Values up.
    pub y: Cow<'a, [f64]>,
    /// The upper side of a [`Mark::Band`].
    pub high: Cow<'a, [f64]>,
    /// Text beside the points, where there is any.
    pub labels: Vec<String>,
    /// What a point says when it is pointed at, where it says anything.
    pub notes: Vec<String>,
}

impl<'a> Series<'a> {
    /// A series without labels.
    pub fn new(
        name: impl Into<Cow<'a, str>>,
        ink: Ink,
        mark: Mark,
        x: impl Into<Cow<'a, [f64]>>,
        y: impl Into<Cow<'a, [f64]>>,
    ) -> Self {
        Self {
            name: name.into(),
            ink,
            mark,
            x: x.into(),
            y: y.into(),
            high: Cow::Borrowed(&[]),
            labels: Vec::new(),
            notes: Vec::new(),
        }
    }

    /// The area between two rows of values.
    pub fn band(
        name: impl Into<Cow<'a, str>>,
        ink: Ink,
        x: impl Into<Cow<'a, [f64]>>,
        [low, high]: [Vec<f64>; 2],
    ) -> Self {
        Self { high: high.into(), ..Self::new(name, ink, Mark::Band, x, low) }
    }
}

/// A panel.
#[derive(Clone, Debug)]
pub struct Plot<'a> {
    /// What it shows.
    pub title: Cow<'a, str>,
    /// The axis across.
    pub x: Axis<'a>,
    /// The axis up.
    pub y: Axis<'a>,
    /// Width and height of the field, pixels.
    pub size: [f64; 2],
    /// Parts of the axis across that are shaded.
    pub bands: Vec<[f64; 2]>,
    /// The series, the hindmost first.
    pub series: Vec<Series<'a>>,
    /// Whether a legend stands over the field.
    pub legend: bool,
    /// Whether it can be zoomed, on a page.
    pub zoom: bool,
    /// Plots of a page with the same name here show the same range across; empty for one alone.
    pub link: &'a str,
}

impl<'a> Plot<'a> {
    /// A panel as wide as a page, without a legend.
    pub fn new(title: impl Into<Cow<'a, str>>, x: Axis<'a>, y: Axis<'a>) -> Self {
        let (bands, series) = (Vec::new(), Vec::new());
        let (title, size) = (title.into(), WIDE);
        Self { title, x, y, size, bands, series, legend: false, zoom: true, link: "" }
    }

    /// The same of this width and height.
    #[must_use]
    pub fn sized(self, width: f64, height: f64) -> Self {
        Self { size: [width, height], ..self }
    }

    /// The same, zoomed together with all others of this name.
    #[must_use]
    pub fn linked(self, link: &'a str) -> Self {
        Self { link, ..self }
    }

    /// The same with a legend.
    #[must_use]
    pub fn explained(self) -> Self {
        Self { legend: true, ..self }
    }
}

/// A field as wide as a page.
const WIDE: [f64; 2] = [952.0, 190.0];
