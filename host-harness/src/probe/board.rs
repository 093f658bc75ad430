//! A board at a debug probe: its flash and its RTT channels.

use std::path::Path;
use std::time::Duration;

use probe_rs::flashing::{DownloadOptions, ElfLoader, ElfOptions, FlashLoader, build_loader};
use probe_rs::probe::list::Lister;
use probe_rs::probe::{DebugProbeSelector, Probe};
use probe_rs::rtt::{Rtt, ScanRegion, try_attach_to_rtt};
use probe_rs::{Permissions, Session};

use super::Wire;
use super::chip::Chip;

/// The RTT channel of telemetry up and of commands down.
const CHANNEL: usize = 1;
/// How long a drive may take to start.
const START: Duration = Duration::from_secs(2);
/// How long to wait where a ring is empty or full.
const PAUSE: Duration = Duration::from_millis(1);
/// How often a full ring is tried again.
const TRIES: u32 = 1000;

/// A board whose probe is attached.
#[derive(Debug)]
pub struct Board {
    session: Session,
    chip: Chip,
}

/// The probe of this selector (`VID:PID[:SERIAL]`), by default of the variable that the tools of
/// probe-rs read, or the only one there is.
///
/// # Errors
/// There is none, more than one, or it cannot be opened.
pub fn probe(selector: Option<&str>) -> Result<Probe, String> {
    let lister = Lister::new();
    let variable = std::env::var("PROBE_RS_PROBE").ok();
    if let Some(text) = selector.or(variable.as_deref()) {
        let selector: DebugProbeSelector =
            text.parse().map_err(|error| format!("probe {text}: {error}"))?;
        return lister.open(selector).map_err(|error| chain(&error));
    }
    let found = lister.list_all();
    match &found[..] {
        [] => Err("no debug probe is connected, or this user may not open it".to_owned()),
        [only] => only.open().map_err(|error| chain(&error)),
        more => {
            let list: Vec<String> = more.iter().map(|probe| format!("\n  {probe}")).collect();
            Err(format!("{} probes: choose one with PROBE_RS_PROBE{}", more.len(), list.concat()))
        }
    }
}

/// Names of the probes that are connected.
pub fn connected() -> Vec<String> {
    Lister::new().list_all().iter().map(ToString::to_string).collect()
}

impl Board {
    /// Attaches to the chip.
    ///
    /// # Errors
    /// It is not there, or another.
    pub fn attach(probe: Probe, chip: Chip) -> Result<Self, String> {
        let session =
            probe.attach(chip.name(), Permissions::default()).map_err(|error| chain(&error))?;
        Ok(Self { session, chip })
    }

    /// Programs and verifies what is given, then starts the program; what is not written to keeps
    /// its flash. With `dry_run` nothing is written or started.
    ///
    /// # Errors
    /// It does not fit the chip, or the chip does not take it.
    pub fn program(
        &mut self,
        elf: Option<&Path>,
        block: Option<&[u8]>,
        dry_run: bool,
    ) -> Result<(), String> {
        let loader = self.loader(elf, block)?;
        let mut options = DownloadOptions::default();
        (options.verify, options.dry_run) = (true, dry_run);
        loader.commit(&mut self.session, options).map_err(|error| chain(&error))?;
        if !dry_run {
            let mut core = self.session.core(0).map_err(|error| chain(&error))?;
            core.reset().map_err(|error| chain(&error))?;
        }
        Ok(())
    }

    /// What would be written, by address.
    ///
    /// # Errors
    /// It does not fit the chip.
    pub fn plan(
        &mut self,
        elf: Option<&Path>,
        block: Option<&[u8]>,
    ) -> Result<Vec<(u64, Vec<u8>)>, String> {
        let loader = self.loader(elf, block)?;
        Ok(loader.data().map(|(address, bytes)| (address, bytes.to_vec())).collect())
    }

    fn loader(&mut self, elf: Option<&Path>, block: Option<&[u8]>) -> Result<FlashLoader, String> {
        let mut loader = match elf {
            Some(elf) => {
                build_loader(&mut self.session, elf, ElfLoader(ElfOptions::default()), None)
                    .map_err(|error| format!("{}: {}", elf.display(), chain(&error)))?
            }
            None => self.session.target().flash_loader(),
        };
        let page = self.chip.page_address();
        let inside = |(address, bytes): (u64, &[u8])| address + bytes.len() as u64 <= page;
        if elf.is_some() && !loader.data().all(inside) {
            return Err("the program reaches into the parameter page: it is another chip's".into());
        }
        if let Some(block) = block {
            loader.add_data(page, block).map_err(|error| chain(&error))?;
        }
        Ok(loader)
    }

    /// The drive's channels, once its program has made them.
    ///
    /// # Errors
    /// The program has none.
    pub fn live(mut self) -> Result<Live, String> {
        let mut core = self.session.core(0).map_err(|error| chain(&error))?;
        let rtt = try_attach_to_rtt(&mut core, START, &ScanRegion::Ram)
            .map_err(|error| format!("{}: is `drive` running?", chain(&error)))?;
        drop(core);
        Ok(Live { session: self.session, rtt })
    }
}

/// A drive's channels at a probe.
#[derive(Debug)]
pub struct Live {
    session: Session,
    rtt: Rtt,
}

impl Wire for Live {
    fn send(&mut self, mut bytes: &[u8]) -> Result<(), String> {
        let mut core = self.session.core(0).map_err(|error| chain(&error))?;
        let channel = self.rtt.down_channel(CHANNEL).ok_or("the drive takes no commands")?;
        for _ in 0..TRIES {
            let sent = channel.write(&mut core, bytes).map_err(|error| chain(&error))?;
            bytes = &bytes[sent..];
            if bytes.is_empty() {
                return Ok(());
            }
            std::thread::sleep(PAUSE);
        }
        Err("the drive takes no commands: it has stopped".to_owned())
    }

    fn receive(&mut self, buffer: &mut [u8]) -> Result<Option<usize>, String> {
        let mut core = self.session.core(0).map_err(|error| chain(&error))?;
        let channel = self.rtt.up_channel(CHANNEL).ok_or("the drive sends no telemetry")?;
        let count = channel.read(&mut core, buffer).map_err(|error| chain(&error))?;
        if count == 0 {
            std::thread::sleep(PAUSE);
        }
        Ok(Some(count))
    }
}

/// An error with what caused it.
fn chain(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        text = format!("{text}: {error}");
        cause = error.source();
    }
    text
}
