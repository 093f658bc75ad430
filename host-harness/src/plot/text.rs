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

/// A share in per cent; near one it says so instead of rounding to it.
pub fn per_cent(share: f64) -> String {
    match share {
        share if !share.is_finite() => NONE.to_owned(),
        share if share > 0.99 && share < 1.0 => "over 99 %".to_owned(),
        share => format!("{:.0} %", 100.0 * share),
    }
}
