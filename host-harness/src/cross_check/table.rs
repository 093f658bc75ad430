//! The cross-check as text: per scenario and run the worst state, and every broken bound; what is a study
//! of forced micro-steps says so in the place of a bound.

use std::fmt;

use super::{CrossCheck, Row};

impl fmt::Display for CrossCheck {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{:<12} {:<17} {:<6} {:>7} {:>5}  {:>9} {:>8}  worst state",
            "scenario", "method", "scalar", "step µs", "micro", "error %", "bound %"
        )?;
        for rows in runs(&self.rows) {
            let Some(row) = worst(rows) else { continue };
            write!(
                f,
                "{:<12} {:<17} {:<6} {:>7} {:>5}  {:>9.4} ",
                row.scenario,
                row.method,
                row.scalar,
                row.step_us,
                row.micro_steps,
                100.0 * row.relative_rms
            )?;
            match row.bound {
                Some(bound) => write!(f, "{:>8}", format!("{:.2}", 100.0 * bound))?,
                None => write!(f, "{:>8}", if row.chosen { "-" } else { "study" })?,
            }
            let mark = if rows.iter().all(Row::holds) { "" } else { "  BROKEN" };
            writeln!(f, "  {}{mark}", row.state)?;
        }
        if let Some(speed) = &self.speed {
            let [explicit, stiff] = speed.ratios();
            writeln!(
                f,
                "\n0.1 s of the joint: embedded {:.3} ms (worst state {:.2} %), explicit reference \
                 at 0.1 µs {:.0} ms ({explicit:.0} times), implicit one at the same error {:.1} ms \
                 ({stiff:.0} times)",
                1e3 * speed.embedded_s,
                100.0 * speed.embedded_error,
                1e3 * speed.explicit_s,
                1e3 * speed.stiff_s,
            )?;
        }
        write!(f, "\n{}", self.verdict())?;
        for row in self.broken() {
            let bound = 100.0 * row.bound.unwrap_or(f64::NAN);
            write!(
                f,
                "\n  {} {} {} {} µs, {} micro-steps, {}: {:.4} % > {bound:.3} %",
                row.scenario,
                row.method,
                row.scalar,
                row.step_us,
                row.micro_steps,
                row.state,
                100.0 * row.relative_rms
            )?;
        }
        Ok(())
    }
}

impl CrossCheck {
    /// Whether every bound holds, in a sentence.
    pub(super) fn verdict(&self) -> String {
        let count = |of: fn(&Row) -> bool| self.rows.iter().filter(|row| of(row)).count();
        let (broken, all) = (count(|row| !row.holds()), self.rows.len());
        if broken > 0 {
            return format!("{broken} of {all} rows break their bound:");
        }
        let (bound, study) = (count(|row| row.bound.is_some()), count(|row| !row.chosen));
        format!(
            "every bound holds ({bound} of {all} rows have one; {study} are a study of forced \
             micro-steps, which is promised nothing)"
        )
    }
}

/// The rows run by run.
fn runs(rows: &[Row]) -> impl Iterator<Item = &[Row]> {
    rows.chunk_by(|a, b| {
        (a.scenario, a.method, a.scalar, a.micro_steps)
            == (b.scenario, b.method, b.scalar, b.micro_steps)
            && a.step_us == b.step_us
    })
}

/// The row nearest to its bound or furthest past it.
fn worst(rows: &[Row]) -> Option<&Row> {
    let share = |row: &Row| row.relative_rms / row.bound.unwrap_or(1.0);
    rows.iter().max_by(|a, b| share(a).total_cmp(&share(b)))
}
