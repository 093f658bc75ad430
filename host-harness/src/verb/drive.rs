//! Where a drive's bytes come from: a file that holds them, a debug probe at a board, or a debug
//! server that passes them on.

use std::path::PathBuf;

use joint_core::telemetry::{Command, Trigger};

use super::Failure;
use crate::fault::InputError;
use crate::probe::wire::{self, Next, Wire};
use crate::probe::{Chip, Recording};

/// A drive, or what it has sent.
#[derive(Clone, Debug, clap::Args)]
#[group(required = true, multiple = false)]
pub struct Source {
    /// Recorded stream of telemetry frames
    #[arg(long, value_name = "FILE")]
    pub stream: Option<PathBuf>,
    /// Debug server that passes on RTT channel 1, as OpenOCD's `rtt server start 9090 1`
    #[arg(long, value_name = "HOST:PORT")]
    pub connect: Option<String>,
    /// Board at a debug probe, by its chip; needs the feature `probe`. PROBE_RS_PROBE chooses
    /// among probes: VID:PID[:SERIAL]
    #[arg(long, value_enum)]
    pub chip: Option<Chip>,
}

impl Source {
    /// Listens for that long, or reads the whole stream.
    pub(super) fn monitor(&self, every: u16, seconds: f64) -> Result<Recording, Failure> {
        self.record(&[Command::Hello, Command::Rate(every)], seconds, &mut |_| Next::More)
    }

    /// Arms, waits and fetches, or reads the whole stream.
    pub(super) fn capture(
        &self,
        trigger: Trigger,
        after: u32,
        seconds: f64,
    ) -> Result<Recording, Failure> {
        let commands = [Command::Hello, Command::Arm { trigger, after }];
        self.record(&commands, seconds, &mut |recording| match recording.capture_is_whole() {
            Some(true) => Next::Enough,
            // What is not complete yet is not sent; asking again does no harm.
            None => Next::Ask(Command::Fetch),
            Some(false) => Next::More,
        })
    }

    /// What to say where nothing of use has come.
    pub(super) fn silent(&self) -> Failure {
        let from = match (&self.connect, self.chip) {
            (Some(server), _) => server.clone(),
            (None, chip) => chip.map_or(String::new(), |chip| chip.name().to_owned()),
        };
        match &self.stream {
            Some(path) => Failure::input(format!(
                "{}: holds no greeting of a drive, or no capture\n  help: record from the start",
                path.display()
            )),
            None => Failure::check(format!(
                "{from}: nothing has come in time\n  help: does `drive` run, and does a server between pass on channel 1?"
            )),
        }
    }

    fn record(
        &self,
        commands: &[Command],
        seconds: f64,
        next: &mut dyn FnMut(&Recording) -> Next,
    ) -> Result<Recording, Failure> {
        let mut recording = Recording::default();
        if let Some(path) = &self.stream {
            let bytes =
                std::fs::read(path).map_err(|error| InputError::unreadable(path, &error))?;
            recording.take(&bytes);
            return Ok(recording);
        }
        let (name, mut wire) = match (&self.connect, self.chip) {
            (Some(server), _) => {
                let stream = wire::server(server)
                    .map_err(|why| Failure::check(format!("{server}: {why}")))?;
                (server.as_str(), Box::new(stream) as Box<dyn Wire>)
            }
            (None, Some(chip)) => (chip.name(), live(chip)?),
            (None, None) => return Ok(recording),
        };
        wire::listen(&mut *wire, commands, seconds, next, &mut recording)
            .map_err(|why| Failure::check(format!("{name}: {why}")))?;
        Ok(recording)
    }
}

/// A board at a debug probe.
#[cfg(feature = "probe")]
fn live(chip: Chip) -> Result<Box<dyn Wire>, Failure> {
    use crate::probe::board::{Board, probe};
    probe(None)
        .and_then(|probe| Board::attach(probe, chip)?.live())
        .map(|live| Box::new(live) as Box<dyn Wire>)
        .map_err(|why| Failure::check(format!("{}: {why}", chip.name())))
}

#[cfg(not(feature = "probe"))]
fn live(_: Chip) -> Result<Box<dyn Wire>, Failure> {
    Err(no_probe())
}

/// What to say where debug probes are not built in.
#[cfg(not(feature = "probe"))]
pub(super) fn no_probe() -> Failure {
    Failure::input(
        "this `joint` is built without debug probes\n  help: build it with them: cargo build --release -p host-harness --features probe",
    )
}
