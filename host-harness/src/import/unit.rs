//! Units of a recorder's columns.
//!
//! What a drive records is in milliseconds, counts and milliamperes as often as in SI units, and a
//! wrong unit looks like wrong physics. So a unit is stated, belongs to one quantity, and may carry
//! the scale and offset of the sensor: `A*1.22`, `counts/4096`, `C-1.5`.

use std::f64::consts::{PI, TAU};

/// What a column measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Time, in s.
    Time,
    /// Voltage, in V.
    Voltage,
    /// Current, in A.
    Current,
    /// Angle, in rad.
    Angle,
    /// Torque, in Nm.
    Torque,
    /// Temperature, in °C.
    Temperature,
}

impl Quantity {
    /// Its word.
    pub fn word(self) -> &'static str {
        match self {
            Quantity::Time => "time",
            Quantity::Voltage => "voltage",
            Quantity::Current => "current",
            Quantity::Angle => "angle",
            Quantity::Torque => "torque",
            Quantity::Temperature => "temperature",
        }
    }

    /// The unit that a log has it in.
    pub fn of_the_log(self) -> Unit {
        let first = UNITS.iter().find(|unit| unit.quantity == self);
        // Every quantity has a row in the table.
        *first.unwrap_or(&UNITS[0])
    }

    /// The first names of its units, for a message.
    pub fn names(self) -> String {
        let own = UNITS.iter().filter(|unit| unit.quantity == self);
        own.map(|unit| unit.names[0]).collect::<Vec<_>>().join(", ")
    }
}

/// A unit: the log's number is `(x + before) · by / over` of the column's number `x`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// What it measures.
    pub quantity: Quantity,
    /// The ways in which it is written.
    pub names: &'static [&'static str],
    before: f64,
    by: f64,
    over: f64,
}

const fn unit(
    quantity: Quantity,
    names: &'static [&'static str],
    [before, by, over]: [f64; 3],
) -> Unit {
    Unit { quantity, names, before, by, over }
}

/// Every unit; the first of a quantity is the log's. Factors below one are divisions by a whole
/// number, so that 1.5 ms is the double nearest to 0.0015 s.
const UNITS: [Unit; 30] = [
    unit(Quantity::Time, &["s", "sec", "second", "seconds"], [0.0, 1.0, 1.0]),
    unit(Quantity::Time, &["ms", "msec", "millis", "milliseconds"], [0.0, 1.0, 1e3]),
    unit(Quantity::Time, &["us", "µs", "μs", "usec", "micros", "microseconds"], [0.0, 1.0, 1e6]),
    unit(Quantity::Time, &["ns", "nsec", "nanoseconds"], [0.0, 1.0, 1e9]),
    unit(Quantity::Time, &["min", "minutes"], [0.0, 60.0, 1.0]),
    unit(Quantity::Voltage, &["V", "volt", "volts"], [0.0, 1.0, 1.0]),
    unit(Quantity::Voltage, &["mV"], [0.0, 1.0, 1e3]),
    unit(Quantity::Current, &["A", "amp", "amps", "ampere"], [0.0, 1.0, 1.0]),
    unit(Quantity::Current, &["mA"], [0.0, 1.0, 1e3]),
    unit(Quantity::Current, &["uA", "µA", "μA"], [0.0, 1.0, 1e6]),
    unit(Quantity::Angle, &["rad", "radian", "radians"], [0.0, 1.0, 1.0]),
    unit(Quantity::Angle, &["mrad"], [0.0, 1.0, 1e3]),
    unit(Quantity::Angle, &["deg", "°", "degree", "degrees"], [0.0, PI, 180.0]),
    unit(Quantity::Angle, &["arcmin"], [0.0, PI, 10_800.0]),
    unit(Quantity::Angle, &["arcsec"], [0.0, PI, 648_000.0]),
    unit(Quantity::Angle, &["rev", "revs", "turn", "turns", "rot", "rotations"], [0.0, TAU, 1.0]),
    unit(Quantity::Angle, &[COUNTS, "count", "cts", "ticks", "inc"], [0.0, TAU, 1.0]),
    unit(Quantity::Torque, &["Nm", "N.m", "N·m", "N m"], [0.0, 1.0, 1.0]),
    unit(Quantity::Torque, &["mNm", "mN.m", "mN·m", "mN m"], [0.0, 1.0, 1e3]),
    unit(Quantity::Torque, &["uNm", "µNm", "μNm"], [0.0, 1.0, 1e6]),
    unit(Quantity::Torque, &["kNm"], [0.0, 1e3, 1.0]),
    unit(Quantity::Torque, &["Ncm", "N.cm", "N·cm", "N cm"], [0.0, 1.0, 1e2]),
    // The avoirdupois pound-force of 4.4482216152605 N at an inch of 0.0254 m; 16 ounces to a pound.
    unit(Quantity::Torque, &["ozin", "oz.in", "oz·in"], [0.0, 4.448_221_615_260_5 * 0.0254, 16.0]),
    unit(Quantity::Torque, &["lbin", "lb.in", "lbf.in"], [0.0, 4.448_221_615_260_5 * 0.0254, 1.0]),
    unit(Quantity::Torque, &["lbft", "lb.ft", "lbf.ft"], [0.0, 4.448_221_615_260_5 * 0.3048, 1.0]),
    unit(Quantity::Temperature, &["C", "°C", "degC", "celsius"], [0.0, 1.0, 1.0]),
    unit(Quantity::Temperature, &["mC"], [0.0, 1.0, 1e3]),
    unit(Quantity::Temperature, &["K", "kelvin"], [-273.15, 1.0, 1.0]),
    unit(Quantity::Temperature, &["F", "°F", "degF"], [-32.0, 5.0, 9.0]),
    unit(Quantity::Temperature, &["dC"], [0.0, 1.0, 1e1]),
];

/// Counts of an encoder: turns, once they are divided by the counts of a turn.
const COUNTS: &str = "counts";

impl Unit {
    /// A unit of a quantity by one of its names.
    pub fn find(quantity: Quantity, name: &str) -> Option<Unit> {
        UNITS.iter().find(|unit| unit.quantity == quantity && unit.names.contains(&name)).copied()
    }

    /// Whether any quantity has a unit of this name.
    pub fn is_known(name: &str) -> bool {
        UNITS.iter().any(|unit| unit.names.contains(&name))
    }

    fn si(&self, value: f64) -> f64 {
        (value + self.before) * self.by / self.over
    }
}

/// What is done to a column's number before its unit is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Step {
    Times(f64),
    Over(f64),
    Plus(f64),
    Minus(f64),
}

/// A unit with the scale and offset of a sensor, as it is written: `counts/4096`.
#[derive(Clone, Debug, PartialEq)]
pub struct Scaling {
    unit: Unit,
    steps: Vec<Step>,
    text: String,
}

impl Scaling {
    /// The plain unit of a name; counts alone are none.
    pub fn plain(quantity: Quantity, name: &str) -> Option<Self> {
        let unit = Unit::find(quantity, name)?;
        let known = unit.names[0] != COUNTS;
        known.then(|| Self { unit, steps: Vec::new(), text: unit.names[0].to_owned() })
    }

    /// The unit that a log has the quantity in.
    pub fn of_the_log(quantity: Quantity) -> Self {
        let unit = quantity.of_the_log();
        Self { unit, steps: Vec::new(), text: unit.names[0].to_owned() }
    }

    /// Reads `UNIT`, followed by any number of `*k`, `/k`, `+o` and `-o`, done from left to right.
    ///
    /// # Errors
    /// What is wrong with it, and what to do.
    pub fn parse(quantity: Quantity, text: &str) -> Result<Self, (String, String)> {
        let end = text.find(['*', '/', '+', '-']).unwrap_or(text.len());
        let (name, mut rest) = text.split_at(end);
        let name = name.trim();
        let unit = Unit::find(quantity, name).ok_or_else(|| unknown(quantity, name))?;
        let mut steps = Vec::new();
        while let Some(operation) = rest.chars().next() {
            let step = match operation {
                '*' => Step::Times,
                '/' => Step::Over,
                '+' => Step::Plus,
                '-' => Step::Minus,
                _ => {
                    let what = format!("`{rest}` is not understood in `{text}`");
                    return Err((what, "after a unit come *k, /k, +o and -o".to_owned()));
                }
            };
            let number = &rest[operation.len_utf8()..];
            let (value, length) = leading_number(number).ok_or_else(|| {
                let what = format!("`{operation}` must be followed by a number in `{text}`");
                (what, "write for example A*1.22, counts/4096 or C-1.5".to_owned())
            })?;
            steps.push(step(value));
            if matches!(steps.last(), Some(Step::Times(0.0) | Step::Over(0.0))) {
                let what = format!("a factor of zero in `{text}`");
                return Err((what, "give a factor other than zero".to_owned()));
            }
            rest = number[length..].trim_start();
        }
        if unit.names[0] == COUNTS && !steps.iter().any(|step| matches!(step, Step::Over(_))) {
            return Err((
                format!("`{text}` does not say how many counts make a turn"),
                "write counts/N, with N the counts of a turn after quadrature".to_owned(),
            ));
        }
        Ok(Self { unit, steps, text: text.trim().to_owned() })
    }

    /// As it was written.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Whether it is a unit and nothing more, and which.
    pub fn unit_alone(&self) -> Option<Unit> {
        self.steps.is_empty().then_some(self.unit)
    }

    /// The log's number for a column's number.
    pub fn si(&self, value: f64) -> f64 {
        let stepped = self.steps.iter().fold(value, |value, step| match step {
            Step::Times(k) => value * k,
            Step::Over(k) => value / k,
            Step::Plus(o) => value + o,
            Step::Minus(o) => value - o,
        });
        self.unit.si(stepped)
    }
}

fn unknown(quantity: Quantity, name: &str) -> (String, String) {
    let help = format!("units of {} are: {}", quantity.word(), quantity.names());
    if let Some(other) = UNITS.iter().find(|unit| unit.names.contains(&name)) {
        let (other, own) = (other.quantity.word(), quantity.word());
        return (format!("`{name}` is a unit of {other}, and this is {}", article(own)), help);
    }
    let alike = UNITS.iter().filter(|unit| unit.quantity == quantity);
    let alike = alike.flat_map(|unit| unit.names).find(|own| own.eq_ignore_ascii_case(name));
    let help = alike.map_or(help, |alike| format!("write {alike}: case matters"));
    let what =
        if name.is_empty() { "a unit is missing".into() } else { format!("unknown unit `{name}`") };
    (what, help)
}

fn article(word: &str) -> String {
    if word.starts_with('a') { format!("an {word}") } else { format!("a {word}") }
}

/// The number that a text begins with, and its length.
fn leading_number(text: &str) -> Option<(f64, usize)> {
    let start = text.len() - text.trim_start().len();
    let digit = |c: char| c.is_ascii_digit() || c == '.';
    let mut end = start + text[start..].find(|c| !digit(c)).unwrap_or(text.len() - start);
    let exponent = text[end..].strip_prefix(['e', 'E']);
    if let Some(exponent) = exponent {
        let unsigned = exponent.trim_start_matches(['+', '-']);
        let digits = unsigned.find(|c: char| !c.is_ascii_digit()).unwrap_or(unsigned.len());
        if digits > 0 && exponent.len() - unsigned.len() <= 1 {
            end += 1 + exponent.len() - unsigned.len() + digits;
        }
    }
    let value = text[start..end].parse::<f64>().ok().filter(|value| value.is_finite())?;
    Some((value, end))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn si(quantity: Quantity, text: &str, value: f64) -> f64 {
        Scaling::parse(quantity, text).unwrap_or_else(|(what, _)| panic!("{what}")).si(value)
    }

    #[test]
    fn every_name_of_a_unit_belongs_to_one_unit() {
        for (k, unit) in UNITS.iter().enumerate() {
            for name in unit.names {
                let other = UNITS[k + 1..].iter().find(|other| other.names.contains(name));
                assert!(other.is_none(), "{name}");
                assert!(!name.contains(['*', '/', '+', '-', ':', ',']), "{name}");
            }
        }
    }

    /// Exact: a division by a power of ten and the literal are both the nearest double.
    #[test]
    fn decimal_units_give_the_double_that_is_nearest() {
        assert_eq!(si(Quantity::Time, "ms", 1.7), 0.0017);
        assert_eq!(si(Quantity::Time, "us", 250.0), 0.00025);
        assert_eq!(si(Quantity::Current, "mA", -340.0), -0.34);
        assert_eq!(si(Quantity::Torque, "mNm", 20.0), 0.02);
        assert_eq!(si(Quantity::Temperature, "K", 273.15), 0.0);
        assert_eq!(si(Quantity::Temperature, "F", 212.0), 100.0);
        assert_eq!(si(Quantity::Angle, "deg", 180.0), PI);
        assert_eq!(si(Quantity::Angle, "turns", 0.5), PI);
    }

    #[test]
    fn scale_and_offset_are_applied_from_left_to_right_before_the_unit() {
        assert_eq!(si(Quantity::Angle, "counts/4096", 1024.0), TAU / 4.0);
        assert_eq!(si(Quantity::Angle, "counts-1024/4096", 1024.0), 0.0);
        assert_eq!(si(Quantity::Current, "A*2+1", 3.0), 7.0);
        assert_eq!(si(Quantity::Current, "A+1*2", 3.0), 8.0);
        assert_eq!(si(Quantity::Current, "mA*1e3", 3.0), 3.0);
        assert_eq!(si(Quantity::Current, "A*1e-3*2", 500.0), 1.0);
        assert_eq!(si(Quantity::Current, "A*1.5e+2-2", 1.0), 148.0);
        assert_eq!(si(Quantity::Angle, "deg - 90", 90.0), 0.0);
    }

    #[test]
    fn what_is_no_unit_of_the_quantity_is_refused_with_those_that_are() {
        let refused = |quantity, text| Scaling::parse(quantity, text).unwrap_err();
        let (what, help) = refused(Quantity::Angle, "mA");
        assert_eq!(what, "`mA` is a unit of current, and this is an angle");
        assert!(help.contains("rad") && help.contains("counts"), "{help}");
        assert_eq!(refused(Quantity::Current, "ma").1, "write mA: case matters");
        assert_eq!(refused(Quantity::Voltage, "").0, "a unit is missing");
        assert!(refused(Quantity::Angle, "counts").0.contains("how many counts"));
        assert!(refused(Quantity::Current, "A*").0.contains("followed by a number"));
        assert!(refused(Quantity::Current, "A/0").0.contains("factor of zero"));
        assert!(refused(Quantity::Current, "A*2x").0.contains("`x` is not understood"));
        assert!(Scaling::plain(Quantity::Angle, "counts").is_none());
    }
}
