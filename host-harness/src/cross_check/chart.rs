//! Where a number stands in a panel with logarithmic axes, and the line through several.

use std::fmt::Write;

/// A panel in an SVG, and the powers of ten along its axes.
pub(super) struct Chart {
    pub(super) width: f64,
    pub(super) height: f64,
    pub(super) left: f64,
    pub(super) right: f64,
    pub(super) top: f64,
    pub(super) bottom: f64,
    pub(super) across: (f64, f64),
    pub(super) up: (f64, f64),
}

impl Chart {
    /// Right end of the panel.
    pub(super) fn end(&self) -> f64 {
        self.width - self.right
    }

    /// Lower end of the panel.
    pub(super) fn floor(&self) -> f64 {
        self.height - self.bottom
    }

    /// Place of a value along the panel.
    pub(super) fn x(&self, value: f64) -> f64 {
        let (low, high) = self.across;
        self.left + (value.log10() - low) / (high - low) * (self.end() - self.left)
    }

    /// Height of a value, kept inside the panel.
    pub(super) fn y(&self, value: f64) -> f64 {
        let (low, high) = self.up;
        let share = (value.log10().clamp(low, high) - low) / (high - low);
        self.floor() - share * (self.floor() - self.top)
    }

    /// The `d` of a path through points.
    pub(super) fn path(&self, points: impl Iterator<Item = (f64, f64)>) -> String {
        let mut path = String::new();
        for (k, (value, error)) in points.enumerate() {
            let command = if k == 0 { 'M' } else { 'L' };
            let _ = write!(path, "{command}{:.1} {:.1}", self.x(value), self.y(error));
        }
        path
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ends_of_the_axes_are_the_corners() {
        let chart = Chart {
            width: 100.0,
            height: 80.0,
            left: 10.0,
            right: 20.0,
            top: 5.0,
            bottom: 15.0,
            across: (1.0, 3.0),
            up: (-2.0, 0.0),
        };
        assert_eq!((chart.x(10.0), chart.y(0.01)), (10.0, 65.0));
        assert_eq!((chart.x(1000.0), chart.y(1.0)), (80.0, 5.0));
        assert_eq!(chart.y(1e-9), chart.floor());
        assert_eq!(chart.path([(10.0, 1.0), (100.0, 0.1)].into_iter()), "M10.0 5.0L45.0 35.0");
    }
}
