//! Numbers as a datasheet prints them, with or without their unit: `4.2`, `4.2mNm/A`, `624/35`.

/// A kind of number on a datasheet: its units, the first the one that is meant where none is written.
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    /// Name and factor to SI of each unit.
    pub units: &'static [(&'static str, f64)],
}

const RPM: f64 = std::f64::consts::PI / 30.0;
const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// Resistance, ohm.
pub const RESISTANCE: Kind =
    Kind { units: &[("ohm", 1.0), ("Ω", 1.0), ("mohm", 1e-3), ("mΩ", 1e-3)] };
/// Inductance, mH.
pub const INDUCTANCE: Kind =
    Kind { units: &[("mH", 1e-3), ("uH", 1e-6), ("µH", 1e-6), ("H", 1.0)] };
/// Speed constant, rpm/V.
pub const SPEED_CONSTANT: Kind = Kind { units: &[("rpm/V", RPM), ("rad/s/V", 1.0)] };
/// Torque constant, mNm/A.
pub const TORQUE_CONSTANT: Kind =
    Kind { units: &[("mNm/A", 1e-3), ("Nm/A", 1.0), ("Ncm/A", 1e-2)] };
/// Inertia, g cm².
pub const INERTIA: Kind = Kind {
    units: &[
        ("gcm2", 1e-7),
        ("g cm2", 1e-7),
        ("gcm²", 1e-7),
        ("kgm2", 1.0),
        ("kg m2", 1.0),
        ("kgcm2", 1e-4),
        ("gm2", 1e-3),
    ],
};
/// Current, mA.
pub const CURRENT: Kind = Kind { units: &[("mA", 1e-3), ("A", 1.0)] };
/// Speed, rpm.
pub const SPEED: Kind = Kind { units: &[("rpm", RPM), ("rad/s", 1.0)] };
/// Voltage, V.
pub const VOLTAGE: Kind = Kind { units: &[("V", 1.0), ("mV", 1e-3)] };
/// Torque, Nm.
pub const TORQUE: Kind = Kind { units: &[("Nm", 1.0), ("mNm", 1e-3), ("Ncm", 1e-2)] };
/// Angle, degrees.
pub const ANGLE: Kind = Kind {
    units: &[
        ("deg", DEGREE),
        ("°", DEGREE),
        ("arcmin", DEGREE / 60.0),
        ("rad", 1.0),
        ("mrad", 1e-3),
    ],
};
/// Torsional stiffness, Nm/rad.
pub const STIFFNESS: Kind =
    Kind { units: &[("Nm/rad", 1.0), ("Nm/deg", 1.0 / DEGREE), ("Nm/arcmin", 60.0 / DEGREE)] };
/// Inertia of a load, kg m².
pub const LOAD_INERTIA: Kind = Kind {
    units: &[("kgm2", 1.0), ("kg m2", 1.0), ("gcm2", 1e-7), ("kgcm2", 1e-4), ("gm2", 1e-3)],
};
/// Time, ms.
pub const TIME: Kind = Kind { units: &[("ms", 1e-3), ("s", 1.0), ("us", 1e-6), ("µs", 1e-6)] };
/// Counts of an encoder per turn.
pub const COUNTS: Kind = Kind { units: &[("counts", 1.0), ("lines", 4.0), ("cpt", 4.0)] };

impl Kind {
    /// Reads a number above zero, in SI units.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn read(self, text: &str) -> Result<f64, String> {
        let text = text.trim();
        let end = text.find(|c: char| !(c.is_ascii_digit() || ".+-eE".contains(c)));
        // The e of an exponent is a digit's; that of a unit is not: none begins with it.
        let (number, unit) = text.split_at(end.unwrap_or(text.len()));
        let unit = unit.trim();
        let factor = match unit {
            "" => self.units.first(),
            unit => self.units.iter().find(|(name, _)| *name == unit),
        };
        let Some((_, factor)) = factor else {
            let names: Vec<&str> = self.units.iter().map(|(name, _)| *name).collect();
            return Err(format!("unknown unit `{unit}`: write one of {}", names.join(", ")));
        };
        match number.parse::<f64>() {
            Ok(value) if value.is_finite() && value > 0.0 => Ok(value * factor),
            Ok(_) => Err("must be a number above zero".to_owned()),
            Err(_) => Err(format!("`{text}` is not a number with a unit")),
        }
    }
}

/// A gear's ratio of input turns over output turns: `16`, `624/35`, `4.8:1`, negative where it reverses.
///
/// # Errors
/// It is no ratio, or it is zero.
pub fn ratio(text: &str) -> Result<f64, String> {
    let (over, under) = text.split_once(['/', ':']).unwrap_or((text, "1"));
    let number = |part: &str| part.trim().parse::<f64>().ok().filter(|value| value.is_finite());
    match (number(over), number(under)) {
        (Some(over), Some(under)) if over != 0.0 && under != 0.0 => Ok(over / under),
        _ => Err(format!("`{text}` is no ratio: write 16, 624/35 or 4.8:1")),
    }
}

/// An efficiency as a share, given as `0.75`, `75` or `75%`.
///
/// # Errors
/// It is none between 0 and 1.
pub fn efficiency(text: &str) -> Result<f64, String> {
    let percent = text.trim().strip_suffix('%');
    let value = percent.unwrap_or(text).trim().parse::<f64>().ok();
    let share =
        value.map(|value| if percent.is_some() || value > 1.0 { value / 100.0 } else { value });
    share
        .filter(|share| *share > 0.0 && *share <= 1.0)
        .ok_or_else(|| format!("`{text}` is no efficiency: write 75, 75% or 0.75"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One rounding each of the number, the factor and their product.
    fn same(own: Result<f64, String>, expected: f64) {
        let own = own.unwrap();
        assert!((own / expected - 1.0).abs() < 3.0 * f64::EPSILON, "{own} for {expected}");
    }

    #[test]
    fn a_number_without_a_unit_is_in_the_datasheets_own() {
        same(INERTIA.read("181"), 1.81e-5);
        same(TORQUE_CONSTANT.read("25.5"), 0.0255);
        same(SPEED_CONSTANT.read("374"), 374.0 * std::f64::consts::PI / 30.0);
        same(INDUCTANCE.read("0.56"), 0.56e-3);
        same(CURRENT.read("1e2"), 0.1);
    }

    #[test]
    fn a_unit_that_is_written_counts() {
        same(INERTIA.read("1.81e-5 kgm2"), 1.81e-5);
        same(TORQUE_CONSTANT.read("0.0255Nm/A"), 0.0255);
        same(INDUCTANCE.read("560uH"), 0.56e-3);
        same(STIFFNESS.read("1Nm/arcmin"), 60.0 * 180.0 / std::f64::consts::PI);
        same(COUNTS.read("1024 lines"), 4096.0);
        assert!(INERTIA.read("181 gcm").unwrap_err().contains("gcm2"));
        assert!(INERTIA.read("-1").is_err() && INERTIA.read("0").is_err());
        assert!(INERTIA.read("many").is_err() && INERTIA.read("").is_err());
    }

    #[test]
    fn a_ratio_is_a_fraction_or_a_decimal() {
        assert_eq!(ratio("624/35"), Ok(624.0 / 35.0));
        assert_eq!(ratio("4.8:1"), Ok(4.8));
        assert_eq!(ratio("-16"), Ok(-16.0));
        for bad in ["", "0", "1/0", "a/b", "1/2/3"] {
            assert!(ratio(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn an_efficiency_is_a_share_or_percent() {
        for text in ["75", "75%", "75 %", "0.75"] {
            assert_eq!(efficiency(text), Ok(0.75));
        }
        assert!(efficiency("0").is_err() && efficiency("101").is_err());
    }
}
