//! `joint import`: a log from a recording with other columns, units and separators.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use serde_json::json;

use super::{Common, Failure, Outcome};
use crate::fault::InputError;
use crate::import::dialect::Separator;
use crate::import::map::Map;
use crate::import::number::Decimal;
use crate::import::preset::Preset;
use crate::import::settings::Settings;
use crate::import::{Imported, map_file, text};

/// Make a log of a recording: other columns, units, separators
///
/// A map says which column is which signal: SIGNAL=[-]COLUMN[*COLUMN][:UNIT][ wrap=PERIOD], separated by
/// commas. Signals: t, u, i, motor, output, load, bus, temperature, reference. Units: s ms us ns, V mV,
/// A mA, rad deg rev counts/N, Nm mNm Ncm, C K F and more, each with *k /k +o -o for a sensor's scale and
/// offset. A minus turns the sign round; a product makes a voltage of duty and bus. Where a unit is left
/// out, the file's own counts (a row of units, brackets behind a name, the end of a name). Angles that
/// jump by a turn are made to go on, and that is told. docs/import.md has presets, units and factors.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Example:
  joint import run7.csv --map \"t=time_ms:ms, i=iq:A*0.866, motor=pos:counts/4096, output=out_deg:deg\" --out log.csv
  joint import run7.csv --map \"t=t:us, u=duty*vbus:V/100, motor=-pos:counts/16384 wrap=65536\" --out log.csv --save-map drive.toml
  joint import run8.csv.gz --map drive.toml --out log8.csv
  joint import vesc.csv --preset vesc --out log.csv
  joint import monitor.txt --preset simplefoc --rate 100 --out log.csv")]
pub struct Args {
    /// Recording: text between commas, semicolons, tabs, bars or spaces, compressed or not; - is standard
    /// input
    #[arg(value_name = "RAW")]
    pub raw: PathBuf,
    /// Which column is which signal, or a map file (.toml); more than one add up, later ones count
    #[arg(long, value_name = "MAP")]
    pub map: Vec<String>,
    /// Map of a known drive; --map adds to it and replaces signals of it
    #[arg(short = 'p', long, value_enum)]
    pub preset: Option<Preset>,
    /// Log to write, compressed where it ends in .gz; - is standard output
    #[arg(short = 'o', long, value_name = "LOG")]
    pub out: PathBuf,
    /// Write the map, as it was applied, to a file for the next recording
    #[arg(long, value_name = "TOML")]
    pub save_map: Option<PathBuf>,
    /// Interpolate to this rate; without it, samples stay as recorded
    #[arg(long, value_name = "HZ", value_parser = super::positive)]
    pub resample: Option<f64>,
    /// Rate of the rows, where no column is the time
    #[arg(long, value_name = "HZ", value_parser = super::positive)]
    pub rate: Option<f64>,
    /// Whether angles that jump by a turn are made to go on
    #[arg(long, value_enum)]
    pub unwrap: Option<Unwrap>,
    /// Let time begin at zero
    #[arg(long)]
    pub zero_time: bool,
    /// Leave out rows that repeat the time of the row before
    #[arg(long)]
    pub drop_repeated: bool,
    /// What separates fields, where the text does not tell: comma, semicolon, tab, bar, space
    #[arg(long, value_name = "WHAT")]
    pub separator: Option<Separator>,
    /// Decimal sign, where the text does not tell
    #[arg(long, value_enum)]
    pub decimal: Option<Decimal>,
    /// Names of the columns in their order, in the place of the text's own or where it has none
    #[arg(long, value_name = "A,B,C", value_delimiter = ',')]
    pub names: Option<Vec<String>>,
}

/// What is done with angles that jump by a turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Unwrap {
    /// They are made to go on
    Auto,
    /// They stay as they are
    Off,
}

impl Args {
    /// The map and how the recording is read: the preset's, then map files', then what is stated.
    fn map(&self) -> Result<(Option<Map>, Settings), InputError> {
        let (mut map, mut settings) = match self.preset {
            Some(preset) => preset.map().map(|(map, settings)| (Some(map), settings))?,
            None => (None, Settings::default()),
        };
        for given in &self.map {
            let (more, stated) = match given.ends_with(".toml") && !given.contains('=') {
                true => read_map(Path::new(given))?,
                false => (Map::parse(given)?, Settings::default()),
            };
            map = Some(map.unwrap_or_default().overlaid(more));
            settings = settings.overlaid(stated);
        }
        Ok((map, settings.overlaid(self.settings())))
    }

    fn settings(&self) -> Settings {
        Settings {
            separator: self.separator,
            decimal: self.decimal,
            names: self.names.clone(),
            headerless: Vec::new(),
            rate_hz: self.rate,
            resample_hz: self.resample,
            unwrap: self.unwrap.map(|unwrap| unwrap == Unwrap::Auto),
            zero_time: self.zero_time,
            drop_repeated: self.drop_repeated,
        }
    }
}

fn read_map(path: &Path) -> Result<(Map, Settings), InputError> {
    let text =
        std::fs::read_to_string(path).map_err(|error| InputError::unreadable(path, &error))?;
    map_file::parse(&text, path)
}

/// Runs the verb.
///
/// # Errors
/// A recording or a map that cannot be read, or a file that cannot be written.
pub fn run(args: &Args, common: &Common) -> Result<Outcome, Failure> {
    let file = |path: &PathBuf| common.file(path)?.apart_from([&args.raw]);
    let out = file(&args.out)?;
    let save = args.save_map.as_ref().map(file).transpose()?;
    let (map, settings) = args.map()?;
    let bar = common.progress(0, "reading");
    let text = text::read(&args.raw)?;
    let imported = crate::import::import(&text, &args.raw, map.as_ref(), &settings)?;
    bar.finish_and_clear();
    for note in &imported.notes {
        eprintln!("note: {}: {note}", args.raw.display());
    }
    let path = out.write_table(imported.log.to_csv())?;
    let saved = match save {
        Some(save) => Some(save.write(map_file::text(&imported.map, &settings))?),
        None => None,
    };
    Ok(Outcome::done(object(&imported, &path, saved.as_deref()), table(&imported, &path)))
}

/// Length of a log, s, and its median rate, Hz.
fn pace(time_s: &[f64]) -> (f64, f64) {
    let mut steps: Vec<f64> = time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    steps.sort_by(f64::total_cmp);
    let median = steps.get(steps.len() / 2).copied().unwrap_or(f64::NAN);
    (time_s.last().unwrap_or(&0.0) - time_s.first().unwrap_or(&0.0), 1.0 / median)
}

fn object(imported: &Imported, out: &Path, saved: Option<&Path>) -> serde_json::Value {
    let (seconds, rate_hz) = pace(&imported.log.time_s);
    let signals = imported.signals.iter().map(|told| {
        let told_json = json!({
            "column": told.column, "unit": told.unit, "smallest": told.smallest,
            "largest": told.largest, "missing": told.missing, "unwrapped": told.unwrapped,
        });
        (told.signal.column().to_owned(), told_json)
    });
    json!({
        "out": out, "map": saved, "samples": imported.log.len(), "seconds": seconds,
        "rate_hz": rate_hz, "signals": signals.collect::<serde_json::Map<_, _>>(),
        "notes": imported.notes,
    })
}

/// What became of each column: a wrong unit shows in the range.
fn table(imported: &Imported, out: &Path) -> String {
    let (seconds, rate_hz) = pace(&imported.log.time_s);
    let samples = imported.log.len();
    let mut text = format!(
        "{}: {samples} samples, {} s at {} Hz\n",
        out.display(),
        rounded(seconds),
        rounded(rate_hz)
    );
    let width = imported.signals.iter().map(|told| told.column.chars().count()).max().unwrap_or(0);
    for told in &imported.signals {
        let unit = told.signal.quantity().of_the_log().names[0];
        let missing = match told.missing {
            0 => String::new(),
            missing => format!(", {missing} missing"),
        };
        text.push_str(&format!(
            "  {:<19} {:width$}  {:<17} {} to {} {unit}{missing}\n",
            told.signal.column(),
            told.column,
            told.unit,
            rounded(told.smallest),
            rounded(told.largest),
        ));
    }
    text.truncate(text.trim_end().len());
    text
}

/// Four digits, as many as tell a unit from a thousand times it.
fn rounded(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let digits = 3 - value.abs().log10().floor() as i32;
    let scale = 10_f64.powi(digits.abs());
    let value = match digits >= 0 {
        true => (value * scale).round() / scale,
        false => (value / scale).round() * scale,
    };
    value.to_string()
}
