//! An axis: its quantity and unit, where values stand along it, and round numbers beside it.

use std::borrow::Cow;

use super::text::{PREFIXES, digits};

/// How values run along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Evenly.
    Linear,
    /// By powers of ten; what is not above zero has no place.
    Log,
}

/// An axis as it is asked for.
#[derive(Clone, Debug)]
pub struct Axis<'a> {
    /// The quantity.
    pub quantity: Cow<'a, str>,
    /// Its unit, empty where it has none. A unit of the SI takes a prefix with small and large values.
    pub unit: &'a str,
    /// Its scale.
    pub scale: Scale,
    /// From where to where it runs; over the data where nothing is said.
    pub range: Option<[f64; 2]>,
    /// What is written beside it, and where; round numbers where nothing is said.
    pub ticks: Vec<(f64, String)>,
}

impl<'a> Axis<'a> {
    /// An even axis over the data.
    pub fn linear(quantity: impl Into<Cow<'a, str>>, unit: &'a str) -> Self {
        let (scale, range, ticks) = (Scale::Linear, None, Vec::new());
        Self { quantity: quantity.into(), unit, scale, range, ticks }
    }

    /// A logarithmic axis over the data.
    pub fn log(quantity: impl Into<Cow<'a, str>>, unit: &'a str) -> Self {
        Self { scale: Scale::Log, ..Self::linear(quantity, unit) }
    }

    /// The same over this range alone.
    #[must_use]
    pub fn within(self, range: impl Into<Option<[f64; 2]>>) -> Self {
        Self { range: range.into(), ..self }
    }

    /// The same with this written beside it.
    #[must_use]
    pub fn marked(self, ticks: Vec<(f64, String)>) -> Self {
        Self { ticks, ..self }
    }
}

/// Units that take a prefix.
const PREFIXED: [&str; 9] = ["s", "A", "V", "Nm", "Nm at the motor", "W", "J", "rad", "rad/s"];

/// The prefix for values up to this one. None from a tenth to ten thousand.
fn prefix(unit: &str, largest: f64) -> (&'static str, f64) {
    if !PREFIXED.contains(&unit) || (0.1..1e4).contains(&largest) || largest == 0.0 {
        return ("", 1.0);
    }
    let fits = PREFIXES.iter().rev().find(|(_, factor)| largest >= 0.999 * factor);
    *fits.unwrap_or(&PREFIXES[0])
}

/// An axis that is laid out: everything in the unit that is written beside it, and for a logarithmic
/// one in powers of ten.
pub(super) struct Ruler {
    pub(super) low: f64,
    pub(super) high: f64,
    pub(super) scale: Scale,
    pub(super) label: String,
    per_unit: f64,
    ticks: Vec<(f64, String)>,
}

impl Ruler {
    /// Lays an axis over values from the least to the greatest, with a share of the length left free
    /// at both ends where the axis says no range of its own.
    pub(super) fn new(axis: &Axis<'_>, values: [f64; 2], margin: f64) -> Self {
        let [from, to] = axis.range.unwrap_or(values);
        let (prefix, factor) = prefix(axis.unit, from.abs().max(to.abs()));
        let scaled = |value: f64| match axis.scale {
            Scale::Linear => value / factor,
            Scale::Log => (value / factor).log10(),
        };
        let ends = [scaled(from), scaled(to)];
        let [low, high] = if axis.range.is_some() { ends } else { widened(ends, margin) };
        let unit = if axis.unit.is_empty() { "" } else { ", " };
        let label = format!("{}{unit}{prefix}{}", axis.quantity, axis.unit);
        let ticks = axis.ticks.iter().map(|(at, text)| (scaled(*at), text.clone())).collect();
        Self { low, high, scale: axis.scale, label, per_unit: 1.0 / factor, ticks }
    }

    /// How much of what is written beside it one plain unit is.
    pub(super) fn per_unit(&self) -> f64 {
        self.per_unit
    }

    /// Where a value stands, 0 at the lower end and 1 at the upper; not finite where it has no place.
    pub(super) fn place(&self, value: f64) -> f64 {
        let scaled = value * self.per_unit;
        let scaled = if self.scale == Scale::Log { scaled.log10() } else { scaled };
        (scaled - self.low) / (self.high - self.low)
    }

    /// What is written beside it, by place; about so many.
    pub(super) fn ticks(&self, about: f64) -> Vec<(f64, String)> {
        let span = [self.low, self.high];
        let ticks = match self.scale {
            _ if !self.ticks.is_empty() => self.ticks.clone(),
            Scale::Linear => even(span, about),
            Scale::Log => decades(span, about),
        };
        let place = |at: f64| (at - self.low) / (self.high - self.low);
        ticks.into_iter().map(|(at, text)| (place(at), text)).collect()
    }
}

fn widened([low, high]: [f64; 2], share: f64) -> [f64; 2] {
    let span = high - low;
    let least = 1e-9 * low.abs().max(high.abs()).max(1e-20);
    let margin = if span > least { share * span } else { least.max(0.5 * low.abs()) };
    [low - margin, high + margin]
}

/// Round values inside a range, about so many, with their labels.
fn even([low, high]: [f64; 2], about: f64) -> Vec<(f64, String)> {
    let raw = (high - low) / about;
    let power = 10.0_f64.powf(raw.log10().floor());
    let factors = [1.0, 2.0, 5.0, 10.0];
    let step = power * factors.into_iter().find(|f| f * power >= 0.999 * raw).unwrap_or(10.0);
    let decimals = (-step.log10().floor()).clamp(0.0, 20.0) as usize;
    let tiny = low.abs().max(high.abs()) < 1e-3 || high.abs().max(low.abs()) >= 1e6;
    let first = (low / step).ceil();
    let ticks: Vec<(f64, String)> = (0..=(3.0 * about) as usize)
        .map(|k| (first + k as f64) * step)
        .take_while(|value| *value <= high + 1e-9 * step)
        .map(|value| {
            let value = if value.abs() < 1e-9 * step { 0.0 } else { value };
            let label = match value {
                0.0 => "0".to_owned(),
                _ if tiny => digits(value, 3),
                _ => format!("{value:.decimals$}"),
            };
            (value, label)
        })
        .collect();
    // One number alone says nothing of the scale.
    if ticks.len() < 2 && about < 20.0 { even([low, high], 2.0 * about) } else { ticks }
}

/// Powers of ten between two logarithms, and 2 and 5 times them where there are few; at most about twice so many
/// powers.
fn decades([low, high]: [f64; 2], about: f64) -> Vec<(f64, String)> {
    let within: &[i32] = if high - low > 3.5 { &[1] } else { &[1, 2, 5] };
    let apart = ((high - low) / (2.0 * about)).ceil().max(1.0) as i32;
    (low.floor() as i32..=high.floor() as i32)
        .filter(|power| power % apart == 0)
        .flat_map(|power| within.iter().map(move |factor| (*factor, power)))
        .map(|(factor, power)| (f64::from(factor).log10() + f64::from(power), factor, power))
        .filter(|(at, ..)| (low - 1e-9..=high + 1e-9).contains(at))
        .map(|(at, factor, power)| (at, power_of_ten(factor, power)))
        .collect()
}

/// `factor · 10^power` as it is read.
fn power_of_ten(factor: i32, power: i32) -> String {
    if (-3..=3).contains(&power) {
        let decimals = (-power).max(0) as usize;
        return format!("{:.decimals$}", f64::from(factor) * 10.0_f64.powi(power));
    }
    let raised: String = power
        .to_string()
        .chars()
        .map(|letter| match letter.to_digit(10) {
            Some(digit) => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][digit as usize],
            None => '⁻',
        })
        .collect();
    let times = if factor == 1 { String::new() } else { format!("{factor}·") };
    format!("{times}10{raised}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(ticks: Vec<(f64, String)>) -> Vec<String> {
        ticks.into_iter().map(|(_, text)| text).collect()
    }

    #[test]
    fn the_ends_of_a_range_are_the_ends_of_the_axis() {
        let log = Ruler::new(&Axis::log("error", "%").within([1e-5, 1e3]), [0.0; 2], 0.1);
        assert!(log.place(1e-5).abs() < 1e-12 && (log.place(1e3) - 1.0).abs() < 1e-12);
        assert!((log.place(0.1) - 0.5).abs() < 1e-12);
        assert!(!log.place(0.0).is_finite() && !log.place(-1.0).is_finite());
        let linear = Ruler::new(&Axis::linear("t", "s"), [1.0, 3.0], 0.5);
        assert_eq!((linear.place(0.0), linear.place(2.0), linear.place(4.0)), (0.0, 0.5, 1.0));
    }

    #[test]
    fn small_and_large_values_of_a_unit_take_its_prefix_and_shares_do_not() {
        let of = |unit, to| Ruler::new(&Axis::linear("x", unit), [0.0, to], 0.0).label;
        assert_eq!(of("rad", 3e-3), "x, mrad");
        assert_eq!(of("Nm", 2e-8), "x, nNm");
        assert_eq!(of("s", 0.1), "x, s");
        assert_eq!(of("rad/s", 6000.0), "x, rad/s");
        assert_eq!(of("rad/s", 2e4), "x, krad/s");
        assert_eq!(of("", 1e-7), "x");
        assert_eq!(of("A", 1e-12), "x, nA");
        // Both ends and what lies between are in the unit that is written.
        let ruler = Ruler::new(&Axis::linear("x", "rad"), [0.0, 4e-3], 0.0);
        assert_eq!(texts(ruler.ticks(4.0)), ["0", "1", "2", "3", "4"]);
        assert_eq!(ruler.place(1e-3), 0.25);
    }

    #[test]
    fn an_even_axis_has_two_numbers_at_least() {
        assert_eq!(texts(even([-0.9, 0.95], 3.0)), ["-0.5", "0", "0.5"]);
    }

    #[test]
    fn ticks_of_a_logarithmic_axis_are_powers_of_ten_and_within_few_of_them_2_and_5() {
        assert_eq!(texts(decades([-5.0, -1.0], 8.0)), ["10⁻⁵", "10⁻⁴", "0.001", "0.01", "0.1"]);
        assert_eq!(texts(decades([0.0, 1.0], 8.0)), ["1", "2", "5", "10"]);
        // Thirteen powers and room for six.
        assert_eq!(texts(decades([-8.0, 5.0], 3.0)), ["10⁻⁶", "0.001", "1", "1000"]);
        assert_eq!(power_of_ten(2, 6), "2·10⁶");
    }
}
