//! `joint score`: how often discovery is right, over logs whose truth is known.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use indicatif::ProgressBar;
use joint_core::effect::Kind;
use rayon::ThreadPoolBuilder;
use serde_json::json;

use super::discover::{failure, write};
use super::{Common, Failure, Outcome, read_log, read_model};
use crate::discover::discover_beside;
use crate::discover::findings::Answer;
use crate::interrupt;
use crate::log::Need;
use crate::output::OutDir;
use crate::score::blind::{self, Trial};
use crate::score::families;
use crate::score::wide::{self, Rigs};
use crate::score::{Case, Row, Summary, cases, files, log_name, row, rows, table};

/// Run discover over logs whose truth is known, and score it
///
/// Writes `score.json`, and each case's verdict, model, report and residuals in a folder of its
/// own; of drawn joints those that were answered wrongly, with logs, nominal and a `truth.json`, so that
/// the folder is a set itself. An interrupt scores the cases that are done.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Example:
  joint score --set practice --out scores
  joint score --simulate 48 --out scores
  joint score --simulate 100 --draws wide --out wide
  joint score --simulate 100 --draws wide --logs-only --out set
  joint score --simulate 1600 --only adequate --out false-alarms
  joint score --join here/score.json there/score.json --out both")]
pub struct Args {
    /// Folder with `truth.json` and a folder a case, each with a log and `nominal.toml`
    #[arg(long, value_name = "DIR", required_unless_present_any = ["simulate", "join"])]
    pub set: Option<PathBuf>,
    /// Score on so many joints drawn at random instead
    #[arg(long, value_name = "N", conflicts_with = "set")]
    pub simulate: Option<u64>,
    /// How they are drawn: with one motion, one misfit and white noise; as measured joints are; the
    /// latter of the paper's joint alone; with friction of another law alone
    #[arg(long, value_enum, default_value_t = Draws::Narrow, conflicts_with_all = ["set", "join"])]
    pub draws: Draws,
    /// Which joints are drawn
    #[arg(short = 's', long, value_name = "N", default_value_t = 1, conflicts_with_all = ["set", "join"])]
    pub seed: u64,
    /// The first of the draws to run, so that several machines can share one benchmark
    #[arg(long, value_name = "N", default_value_t = 0, conflicts_with_all = ["set", "join"])]
    pub from: u64,
    /// Only cases of which this is the right answer
    #[arg(long, value_name = "ANSWER", conflicts_with = "join")]
    pub only: Option<Answer>,
    /// Score the cases of earlier results together, as of a benchmark shared over machines
    #[arg(long, value_name = "FILE", num_args = 1.., conflicts_with_all = ["set", "simulate"])]
    pub join: Vec<PathBuf>,
    /// Keep every draw with its log and answer, not those alone that were answered wrongly
    #[arg(long, requires = "simulate")]
    pub keep_all: bool,
    /// Draw only: every log with its nominal and a `truth.json`, a set for `--set`, so that several
    /// programs can be asked about the same logs
    #[arg(long, requires = "simulate", conflicts_with = "keep_all")]
    pub logs_only: bool,
    /// Folder for the result
    #[arg(short = 'o', long, value_name = "DIR")]
    pub out: PathBuf,
    /// Only cases of these kinds, and those in which nothing has a name
    #[arg(long, value_name = "KIND", value_delimiter = ',', requires = "set")]
    pub kinds: Vec<String>,
}

/// How joints are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Draws {
    /// Two seconds of one motion, LuGre friction with one misfit, white noise
    Narrow,
    /// Any length, motion, friction, disturbance and timing of the signals
    Wide,
    /// The same of the paper's joint alone
    WidePaper,
    /// Two to four seconds of any motion, white noise, and friction of another law than the model's
    Friction,
}

impl Draws {
    fn answer(self, number: u64) -> Answer {
        match self {
            Self::Narrow => blind::answer(number),
            Self::Wide | Self::WidePaper | Self::Friction => wide::answer(number),
        }
    }

    fn trial(self, seed: u64, number: u64) -> Result<Trial, Failure> {
        let trial = match self {
            Self::Narrow => blind::trial(seed, number),
            Self::Wide => wide::trial(seed, number, Rigs::All),
            Self::WidePaper => wide::trial(seed, number, Rigs::Paper),
            Self::Friction => families::trial(seed, number),
        };
        trial.map_err(|error| Failure::check(format!("draw {number}: {error}")))
    }
}

/// Runs the verb.
///
/// # Errors
/// Bad input, or a result that may not be overwritten.
pub fn run(args: &Args, common: &Common) -> Result<Outcome, Failure> {
    let out = OutDir::new(&args.out, common.force)?;
    interrupt::watch();
    let numbers = args.from..args.from + args.simulate.unwrap_or(0);
    if args.logs_only {
        return logs(args, numbers, out, common);
    }
    let rows = match (&args.set, args.simulate) {
        (Some(set), _) => of_set(set, args, &out, common)?,
        (None, Some(_)) => drawn(args, numbers, &out, common)?,
        (None, None) => joined(&args.join)?,
    };
    // An interrupted score is that of the cases before.
    let summary = Summary::of(&rows);
    let json = json!({"cases": rows, "summary": summary});
    out.write("score.json", pretty(&json)?)?;
    out.finish()?;
    Ok(Outcome::done(json, table(&rows, &summary)))
}

fn joined(paths: &[PathBuf]) -> Result<Vec<Row>, Failure> {
    let all: Result<Vec<_>, _> = paths.iter().map(|path| rows(path)).collect();
    Ok(all.map_err(Failure::input)?.concat())
}

fn of_set(set: &Path, args: &Args, out: &OutDir, common: &Common) -> Result<Vec<Row>, Failure> {
    let mut cases = cases(set, &args.kinds).map_err(Failure::input)?;
    cases.retain(|case| args.only.is_none_or(|only| only.name() == case.verdict));
    let bar = common.progress(cases.len() as u64, "score");
    let mut rows = Vec::new();
    for case in &cases {
        bar.set_message(case.case.clone());
        let (path, paths) = files(set, case);
        let model = read_model(&path)?;
        let logs: Vec<_> =
            paths.iter().map(|path| read_log(path, Need::Drive)).collect::<Result<_, _>>()?;
        let withdrawn: Vec<_> = case.withdrawn_kind().into_iter().collect();
        let hidden = ProgressBar::hidden();
        // The further records are what the names are asked of.
        let records = logs.split_at(1);
        let findings = discover_beside(&model, records, &withdrawn, &hidden).map_err(failure)?;
        if interrupt::asked() {
            break;
        }
        let kept = out.folder(&case.case, common.force)?;
        let mut paths = paths;
        let others = paths.split_off(1);
        let source = command(path, (paths, others), &kept, withdrawn).source(&kept);
        write(&kept, &findings, &logs[..1], &source)?;
        kept.finish()?;
        rows.push(row(case, &findings));
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(rows)
}

/// The numbers that are asked for.
fn asked(args: &Args, numbers: Range<u64>) -> Vec<u64> {
    let asked = |number: &u64| args.only.is_none_or(|only| args.draws.answer(*number) == only);
    numbers.filter(asked).collect()
}

/// Each trial on one core, as many at once as there are cores: nothing is lost to waiting, and the
/// seconds of a log are those of a core. What an interrupt stopped is left out.
fn abreast<T: Send>(
    numbers: &[u64],
    bar: &ProgressBar,
    one: impl Fn(u64) -> Result<T, Failure> + Sync,
) -> Result<Vec<(u64, T)>, Failure> {
    let next = AtomicUsize::new(0);
    let worker = || -> Result<Vec<(u64, T)>, Failure> {
        let mut done = Vec::new();
        while !interrupt::asked() {
            let place = next.fetch_add(1, Ordering::Relaxed);
            let Some(number) = numbers.get(place) else { break };
            let one = one(*number)?;
            if !interrupt::asked() {
                bar.inc(1);
                bar.set_message(format!("{number:04}"));
                done.push((*number, one));
            }
        }
        Ok(done)
    };
    let workers = std::thread::available_parallelism().map_or(1, usize::from);
    let mut all = std::thread::scope(|scope| {
        let started: Vec<_> = (0..workers).map(|_| scope.spawn(worker)).collect();
        let mut all = Vec::new();
        for worker in started {
            let ended = worker.join();
            all.extend(ended.map_err(|_| Failure::check("a worker of the benchmark stopped"))??);
        }
        Ok::<_, Failure>(all)
    })?;
    all.sort_by_key(|(number, _)| *number);
    bar.finish_and_clear();
    Ok(all)
}

fn drawn(
    args: &Args,
    numbers: Range<u64>,
    out: &OutDir,
    common: &Common,
) -> Result<Vec<Row>, Failure> {
    let numbers = asked(args, numbers);
    let bar = common.progress(numbers.len() as u64, "score");
    let all = abreast(&numbers, &bar, |number| {
        let pool = ThreadPoolBuilder::new().num_threads(1).build();
        let pool = pool.map_err(|error| Failure::check(error.to_string()))?;
        pool.install(|| one(args, number, out, common.force))
    })?;
    let (cases, rows): (Vec<Case>, Vec<Row>) = all.into_iter().map(|(_, done)| done).unzip();
    let kept = cases.iter().zip(&rows).filter(|(_, row)| args.keep_all || !row.right);
    let kept: Vec<&Case> = kept.map(|(case, _)| case).collect();
    out.write("truth.json", pretty(&kept)?)?;
    Ok(rows)
}

/// The draws alone, as a set.
fn logs(
    args: &Args,
    numbers: Range<u64>,
    out: OutDir,
    common: &Common,
) -> Result<Outcome, Failure> {
    let numbers = asked(args, numbers);
    let bar = common.progress(numbers.len() as u64, "draw");
    let all = abreast(&numbers, &bar, |number| {
        let trial = args.draws.trial(args.seed, number)?;
        let kept = out.folder(&trial.case.case, common.force)?;
        keep(&kept, &trial)?;
        kept.finish()?;
        Ok(trial.case)
    })?;
    let cases: Vec<Case> = all.into_iter().map(|(_, case)| case).collect();
    let truth = out.write("truth.json", pretty(&cases)?)?;
    out.finish()?;
    let told = format!("{} logs and their truth: {}\n", cases.len(), truth.display());
    Ok(Outcome::done(json!({"cases": cases}), told))
}

/// One trial of the benchmark. What was answered wrongly, or everything, is kept, to be looked into.
fn one(args: &Args, number: u64, out: &OutDir, force: bool) -> Result<(Case, Row), Failure> {
    let trial = args.draws.trial(args.seed, number)?;
    let withdrawn: Vec<_> = trial.withdrawn.into_iter().collect();
    let hidden = ProgressBar::hidden();
    // The further records are what the names are asked of.
    let records = trial.logs.split_at(1);
    let findings =
        discover_beside(&trial.nominal, records, &withdrawn, &hidden).map_err(failure)?;
    let row = row(&trial.case, &findings);
    if (args.keep_all || !row.right) && !interrupt::asked() {
        let kept = out.folder(&trial.case.case, force)?;
        let (model, mut paths) = keep(&kept, &trial)?;
        let others = paths.split_off(1);
        let source = command(model, (paths, others), &kept, withdrawn).source(&kept);
        write(&kept, &findings, records.0, &source)?;
        kept.finish()?;
    }
    Ok((trial.case, row))
}

/// A trial's nominal and logs, written.
fn keep(kept: &OutDir, trial: &Trial) -> Result<(PathBuf, Vec<PathBuf>), Failure> {
    let model = kept.write("nominal.toml", trial.nominal.to_toml())?;
    let mut paths = Vec::new();
    for (place, log) in trial.logs.iter().enumerate() {
        paths.push(kept.write(&log_name(place), log.to_csv())?);
    }
    Ok((model, paths))
}

fn pretty(value: &impl serde::Serialize) -> Result<String, Failure> {
    serde_json::to_string_pretty(value).map_err(|error| Failure::check(error.to_string()))
}

/// What would give a case's answer alone.
fn command(
    model: PathBuf,
    (log, transfer): (Vec<PathBuf>, Vec<PathBuf>),
    kept: &OutDir,
    without: Vec<Kind>,
) -> super::discover::Args {
    super::discover::Args {
        model,
        log,
        out: kept.path().to_owned(),
        transfer,
        without,
        anyway: true,
    }
}
