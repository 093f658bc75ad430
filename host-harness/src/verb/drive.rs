//! Where a drive's bytes come from: a debug probe, or a file.

use std::path::PathBuf;

use joint_core::telemetry::Trigger;

use super::Failure;
use crate::fault::InputError;
use crate::probe::Recording;

/// A drive, or what it has sent.
#[derive(Clone, Debug, clap::Args)]
pub struct Source {
    /// Recorded stream of telemetry frames, instead of a probe
    #[arg(long, value_name = "FILE")]
    pub stream: Option<PathBuf>,
    /// Chip on the probe, as probe-rs names it
    #[arg(long, value_name = "NAME", conflicts_with = "stream")]
    pub chip: Option<String>,
    /// The firmware that runs on it, to find its rings
    #[arg(long, value_name = "ELF", conflicts_with = "stream")]
    pub elf: Option<PathBuf>,
}

impl Source {
    /// Listens for that long, or reads the whole stream.
    pub(super) fn monitor(&self, every: u16, seconds: f64) -> Result<Recording, Failure> {
        match self.stream()? {
            Some(recording) => Ok(recording),
            None => self.attached_monitor(every, seconds),
        }
    }

    /// Arms, waits and fetches, or reads the whole stream.
    pub(super) fn capture(
        &self,
        trigger: Trigger,
        after: u32,
        seconds: f64,
    ) -> Result<Recording, Failure> {
        match self.stream()? {
            Some(recording) => Ok(recording),
            None => self.attached_capture(trigger, after, seconds),
        }
    }

    /// What to say where nothing of use has come.
    pub(super) fn silent(&self) -> Failure {
        match &self.stream {
            Some(path) => Failure::input(format!(
                "{}: holds no greeting of a drive, or no capture\n  help: record from the start, or ask the drive to say hello",
                path.display()
            )),
            None => Failure::check("the drive has said nothing\n  help: does `drive` run on it?"),
        }
    }

    fn stream(&self) -> Result<Option<Recording>, Failure> {
        let Some(path) = &self.stream else { return Ok(None) };
        let bytes = std::fs::read(path).map_err(|error| InputError::unreadable(path, &error))?;
        let mut recording = Recording::default();
        recording.take(&bytes);
        Ok(Some(recording))
    }

    #[expect(clippy::unused_self)]
    fn attached_monitor(&self, _: u16, _: f64) -> Result<Recording, Failure> {
        Err(without_probe())
    }

    #[expect(clippy::unused_self)]
    fn attached_capture(&self, _: Trigger, _: u32, _: f64) -> Result<Recording, Failure> {
        Err(without_probe())
    }
}

/// This program has no probe in it.
pub(super) fn without_probe() -> Failure {
    Failure::input(
        "this build has no debug probe\n  help: give a recorded --stream, or build with: cargo run --release -p host-harness --features probe -- …",
    )
}
