//! Numbers and names on their way into the page: nothing unescaped, nothing that is no number.

/// What stands in the place of a number that there is none of.
const NONE: &str = "&ndash;";

/// Text as it may stand in HTML, inside quotes as well.
pub fn escape(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            other => safe.push(other),
        }
    }
    safe
}

/// A number in so many significant digits.
pub fn digits(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return NONE.to_owned();
    }
    if value == 0.0 {
        return "0".to_owned();
    }
    let places = digits.saturating_sub(1);
    let rounded = format!("{value:.places$e}");
    let (mantissa, exponent) = rounded.split_once('e').unwrap_or((&rounded, "0"));
    let power: i32 = exponent.parse().unwrap_or(0);
    if (-3..6).contains(&power) {
        let decimals = (places as i32 - power).max(0) as usize;
        format!("{value:.decimals$}")
    } else {
        format!("{mantissa}e{power}")
    }
}

/// A number in four significant digits.
pub fn number(value: f64) -> String {
    digits(value, 4)
}

/// A value with its sigma: as many digits as the sigma warrants.
pub fn with_sigma(value: f64, sigma: Option<f64>) -> String {
    let Some(sigma) = sigma.filter(|sigma| sigma.is_finite() && *sigma > 0.0) else {
        return number(value);
    };
    let ratio = (value / sigma).abs().max(1.0).log10().floor();
    let shown = if ratio.is_finite() { (ratio as usize + 2).min(8) } else { 4 };
    format!("{} &plusmn; {}", digits(value, shown), digits(sigma, 2))
}

/// A share in per cent; near one or zero it says so instead of rounding to it.
pub fn per_cent(share: f64) -> String {
    match share {
        share if !share.is_finite() => NONE.to_owned(),
        share if share > 0.99 && share < 1.0 => "over 99 %".to_owned(),
        share if share > 0.0 && share < 0.001 => "under 0.1 %".to_owned(),
        share if share > 0.0 && share < 0.0095 => format!("{:.1} %", 100.0 * share),
        share => format!("{:.0} %", 100.0 * share),
    }
}

/// Units that a prefix may stand before, by how they begin.
const PREFIXED: [&str; 9] = ["A", "V", "Nm", "rad", "s", "Ω", "H", "W", "J"];
pub(super) const PREFIXES: [(&str, f64); 7] =
    [("n", 1e-9), ("µ", 1e-6), ("m", 1e-3), ("", 1.0), ("k", 1e3), ("M", 1e6), ("G", 1e9)];

/// A unit for values of this size, with its prefix, and how much of the plain unit it is. Small moments of
/// inertia are in g cm², as datasheets have them.
fn scaled(size: f64, unit: &str) -> (String, f64) {
    let first = unit.split(['/', ' ']).next().unwrap_or_default();
    if unit == "kg m²" && size > 0.0 && size < 0.1 {
        let small = size < 1e-4;
        return if small { ("g cm²".to_owned(), 1e-7) } else { ("kg cm²".to_owned(), 1e-4) };
    }
    if !PREFIXED.contains(&first) || !size.is_finite() || size == 0.0 {
        return (unit.to_owned(), 1.0);
    }
    let fits = PREFIXES.iter().rev().find(|(_, factor)| size >= 0.9995 * factor);
    let (prefix, factor) = fits.unwrap_or(&PREFIXES[0]);
    (format!("{prefix}{unit}"), *factor)
}

/// A value of a unit with so many significant digits and the prefix that fits: `2.90 mNm`.
pub fn si(value: f64, unit: &str, significant: usize) -> String {
    let (unit, factor) = scaled(value.abs(), unit);
    let number = rounded(value / factor, significant);
    if unit.is_empty() { number } else { format!("{number} {unit}") }
}

/// A value and its standard error in one unit, as far as the error tells: `2.90 ± 0.04 mNm`.
pub fn si_with_sigma(value: f64, sigma: Option<f64>, unit: &str) -> String {
    let Some(sigma) = sigma.filter(|sigma| sigma.is_finite() && *sigma > 0.0) else {
        return si(value, unit, 3);
    };
    if !value.is_finite() {
        return NONE_TEXT.to_owned();
    }
    let (unit, factor) = scaled(value.abs().max(sigma), unit);
    let (value, sigma) = (value / factor, sigma / factor);
    let last = sigma.log10().floor() as i32
        - i32::from(sigma / 10.0_f64.powf(sigma.log10().floor()) < 3.0);
    let told = match (-9..=5).contains(&last) {
        true => format!("{value:.0$} ± {sigma:.0$}", last.min(0).unsigned_abs() as usize),
        false => format!("{} ± {}", rounded(value, 4), rounded(sigma, 2)),
    };
    if unit.is_empty() { told } else { format!("{told} {unit}") }
}

/// A value in as many digits as its interval allows, without it: `284.65 mΩ`.
pub fn si_within(value: f64, [low, high]: [f64; 2], unit: &str) -> String {
    let sigma = 0.25 * (high - low);
    let told = si_with_sigma(value, Some(sigma), unit);
    match told.split_once(" ± ") {
        Some((number, rest)) => {
            let unit = rest.split_once(' ').map_or("", |(_, unit)| unit);
            if unit.is_empty() { number.to_owned() } else { format!("{number} {unit}") }
        }
        None => told,
    }
}

/// A range of a quantity in one unit: `2.82 to 2.98 mNm`.
pub fn si_range([low, high]: [f64; 2], unit: &str) -> String {
    if !low.is_finite() || !high.is_finite() {
        return NONE_TEXT.to_owned();
    }
    let (unit, factor) = scaled(low.abs().max(high.abs()), unit);
    let (low, high) = (low / factor, high / factor);
    let told = match (high - low) > 0.0 {
        true => {
            let decimals = (1.0 - (high - low).log10().floor()).clamp(0.0, 9.0) as usize;
            format!("{low:.decimals$} to {high:.decimals$}")
        }
        false => rounded(low, 3),
    };
    if unit.is_empty() { told } else { format!("{told} {unit}") }
}

/// What stands in the place of a number that there is none of, in text that is escaped.
const NONE_TEXT: &str = "–";

/// A number in so many significant digits, as text; whole numbers of more digits stand as they are.
fn rounded(value: f64, significant: usize) -> String {
    match value {
        value if !value.is_finite() => NONE_TEXT.to_owned(),
        value if value.abs() >= 10.0_f64.powi(significant as i32) && value.abs() < 1e5 => {
            format!("{value:.0}")
        }
        value => digits(value, significant),
    }
}

/// The unit of a key or column that ends in one, and the key without it: `coulomb_nm` is `coulomb` in Nm.
pub fn unit_of(key: &str) -> (&str, &'static str) {
    let fits = UNITS.iter().find(|(ending, _)| key.ends_with(ending));
    fits.map_or((key, ""), |(ending, unit)| (&key[..key.len() - ending.len()], *unit))
}

/// Endings of keys and their units, the longer ones first.
const UNITS: [(&str, &str); 14] = [
    ("_nm_s_per_rad", "Nm s/rad"),
    ("_nm_per_rad3", "Nm/rad³"),
    ("_nm_per_rad", "Nm/rad"),
    ("_nm_per_a", "Nm/A"),
    ("_rad_per_s", "rad/s"),
    ("_nm_s2", "Nm s²"),
    ("_kg_m2", "kg m²"),
    ("_ohm", "Ω"),
    ("_rad", "rad"),
    ("_nm", "Nm"),
    ("_s", "s"),
    ("_a", "A"),
    ("_v", "V"),
    ("_h", "H"),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_take_the_prefix_that_fits_and_as_many_digits_as_their_error_allows() {
        assert_eq!(si(2.9048e-3, "Nm", 3), "2.90 mNm");
        assert_eq!(si(-1.1e-5, "Nm at the motor", 2), "-11 µNm at the motor");
        assert_eq!(si(4.1e-5, "kg m²", 3), "410 g cm²");
        assert_eq!(si(6e-3, "kg m²", 3), "60.0 kg cm²");
        assert_eq!(si(0.0, "rad", 3), "0 rad");
        assert_eq!(si(12_345.0, "", 3), "12345");
        assert_eq!(si(f64::NAN, "V", 3), "– V");
        assert_eq!(si_with_sigma(2.9048, Some(0.0412), "rad"), "2.90 ± 0.04 rad");
        assert_eq!(si_with_sigma(2.9048e-3, Some(1.3e-5), "Nm"), "2.905 ± 0.013 mNm");
        assert_eq!(si_with_sigma(7.83, None, "V"), "7.83 V");
        assert_eq!(si_with_sigma(5.0, Some(800.0), "Nm/rad"), "5 ± 800 Nm/rad");
        assert_eq!(si_within(0.284_652, [0.284_55, 0.284_76], "Ω"), "284.65 mΩ");
        assert_eq!(si_within(3.0, [3.0, 3.0], ""), "3.00");
        assert_eq!(si_range([0.99e-3, 1.01e-3], "Nm"), "0.990 to 1.010 mNm");
    }

    #[test]
    fn a_key_tells_its_unit() {
        assert_eq!(unit_of("sigma2_nm_s_per_rad"), ("sigma2", "Nm s/rad"));
        assert_eq!(unit_of("i_a"), ("i", "A"));
        assert_eq!(unit_of("order"), ("order", ""));
    }
}
