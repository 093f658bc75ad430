//! Where a page comes from: the command, the files with their hashes, version and date.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use sha2::{Digest, Sha256};

use crate::log::Log;
use crate::model::Model;
use crate::output::OutDir;
use crate::plot::text::escape;
use crate::standard;

/// A file as it was read.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct File {
    /// Where it is, as it was given.
    pub path: PathBuf,
    /// SHA-256 of its bytes, in hexadecimal digits.
    pub sha256: String,
}

impl File {
    /// A file's path and hash; without a hash where it can no longer be read. It may wait in a folder of
    /// results for its place.
    fn read(path: &Path, out: &OutDir) -> Self {
        let hash = match standard::is(path) {
            true => standard::input().map_or(String::new(), sha256),
            false => {
                std::fs::read(out.readable(path)).map_or(String::new(), |bytes| sha256(&bytes))
            }
        };
        Self { path: path.to_owned(), sha256: hash }
    }
}

/// SHA-256 of some bytes, in hexadecimal digits.
fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().fold(String::new(), |text, byte| text + &format!("{byte:02x}"))
}

/// Where a page comes from.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Source {
    /// The command, as it can be run again.
    pub command: String,
    /// The model.
    pub model: File,
    /// The logs.
    pub logs: Vec<File>,
    /// The folder of the results.
    pub out: PathBuf,
    /// When the page was written, in universal time; empty leaves it out.
    pub date: String,
    /// Keys that the model file says are assumed.
    pub assumed: Vec<String>,
}

impl Source {
    /// Of a model, logs and a folder, now.
    pub fn new(command: String, model: &Path, logs: &[PathBuf], out: &OutDir) -> Self {
        let text = std::fs::read_to_string(out.readable(model)).unwrap_or_default();
        Self {
            command,
            model: File::read(model, out),
            logs: logs.iter().map(|log| File::read(log, out)).collect(),
            out: out.path().to_owned(),
            date: now(),
            assumed: assumed(&text),
        }
    }

    /// Of a model and logs that are in memory; hashes are of the files that they would be written as.
    pub fn in_memory(command: String, model: &Model, logs: &[Log]) -> Self {
        let file = |path: String, text: String| File {
            path: path.into(),
            sha256: sha256(text.as_bytes()),
        };
        let log = |(k, log): (usize, &Log)| file(format!("log {}", k + 1), log.to_csv());
        Self {
            command,
            model: file(model.name.clone(), model.to_toml()),
            logs: logs.iter().enumerate().map(log).collect(),
            out: PathBuf::from("."),
            date: now(),
            assumed: Vec::new(),
        }
    }

    /// The section at the end of a page.
    pub(super) fn section(&self, page: &mut String) {
        let _ = write!(
            page,
            "<h2>Where this page comes from</h2>\n<dl><dt>command<dd><code>{}</code>\n<dt>program<dd>joint {}\n",
            escape(&self.command),
            env!("CARGO_PKG_VERSION")
        );
        let logs = self.logs.iter().map(|log| ("log", log));
        for (what, file) in [("model", &self.model)].into_iter().chain(logs) {
            let _ = writeln!(
                page,
                "<dt>{what}<dd><code>{}</code>, SHA-256 <code>{}</code>",
                escape(&file.path.display().to_string()),
                if file.sha256.is_empty() { "unknown" } else { &file.sha256 }
            );
        }
        if !self.date.is_empty() {
            let _ = writeln!(page, "<dt>date<dd class=date>{}", escape(&self.date));
        }
        page.push_str("</dl>\n");
    }
}

/// A path as a word of a command line.
pub fn quoted(path: &Path) -> String {
    let text = path.display().to_string();
    let plain = |c: char| c.is_ascii_alphanumeric() || "/._-+=:@,".contains(c);
    match !text.is_empty() && text.chars().all(plain) {
        true => text,
        false => format!("'{}'", text.replace('\'', "'\\''")),
    }
}

/// Keys of a model file whose comment says that they are assumed, with their table: `stage1.damping_nm_s_per_rad`.
fn assumed(model: &str) -> Vec<String> {
    let (mut table, mut stage, mut keys) = (String::new(), 0, Vec::new());
    for line in model.lines().map(str::trim) {
        if line.starts_with('[') {
            let name = line.trim_matches(|c| c == '[' || c == ']');
            stage += usize::from(line.starts_with("[[stage]]"));
            table = name.replacen(
                "stage",
                &format!("stage{stage}"),
                usize::from(name.starts_with("stage")),
            );
        } else if let Some((setting, comment)) = line.split_once('#')
            && comment.trim_start().starts_with("assumed")
            && let Some((key, _)) = setting.split_once('=')
        {
            keys.push(format!("{table}.{}", key.trim()));
        }
    }
    keys
}

/// Now, in universal time, to the minute; `SOURCE_DATE_EPOCH` stands in for it where it is set, so that a page
/// can be made again to the byte.
fn now() -> String {
    let set = std::env::var("SOURCE_DATE_EPOCH").ok().and_then(|text| text.parse().ok());
    let clock = || SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    date(set.unwrap_or_else(clock))
}

/// Seconds since 1970 as a date of the Gregorian calendar (Richards, Calendars, in the Explanatory Supplement to
/// the Astronomical Almanac, 2013).
fn date(seconds: u64) -> String {
    let (days, minutes) = (seconds / 86_400, seconds % 86_400 / 60);
    let julian = days + 2_440_588;
    let f = julian + 1401 + (4 * julian + 274_277) / 146_097 * 3 / 4 - 38;
    let e = 4 * f + 3;
    let h = 5 * (e % 1461 / 4) + 2;
    let day = h % 153 / 5 + 1;
    let month = (h / 153 + 2) % 12 + 1;
    let year = e / 1461 - 4716 + (14 - month) / 12;
    format!("{year}-{month:02}-{day:02} {:02}:{:02} UTC", minutes / 60, minutes % 60)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_those_of_the_calendar() {
        assert_eq!(date(0), "1970-01-01 00:00 UTC");
        assert_eq!(date(951_782_400), "2000-02-29 00:00 UTC");
        assert_eq!(date(1_795_689_960), "2026-11-26 10:46 UTC");
        assert_eq!(date(4_107_542_399), "2100-02-28 23:59 UTC");
    }

    #[test]
    fn the_hash_is_sha_256() {
        // FIPS 180-2, appendix B.1.
        assert_eq!(
            sha256(b"abc"),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
        );
    }

    #[test]
    fn what_a_model_file_assumes_is_found_by_its_comments() {
        let model = "[motor]\nphase_resistance_ohm = 1.0 # half of the terminal's\n[motor.friction]\n\
                     sigma0_nm_per_rad = 2.0 # assumed: breaks away after 1 mrad\n[[stage]]\n[stage.friction]\n\
                     [[stage]]\nstiffness_nm_per_rad = 3.0 # assumed: usual\n[stage.friction]\ncoulomb_nm = 1.0 # assumed: usual\n";
        let keys = [
            "motor.friction.sigma0_nm_per_rad",
            "stage2.stiffness_nm_per_rad",
            "stage2.friction.coulomb_nm",
        ];
        assert_eq!(assumed(model), keys);
    }

    #[test]
    fn a_path_is_one_word_for_a_shell() {
        assert_eq!(quoted(Path::new("a/b-1.csv")), "a/b-1.csv");
        assert_eq!(quoted(Path::new("it's a log.csv")), "'it'\\''s a log.csv'");
    }
}
