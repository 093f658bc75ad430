//! Where a drive's bytes come from: a file that holds them, or a debug server that passes them on.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use joint_core::telemetry::frame::encode;
use joint_core::telemetry::{Command, Message, Trigger};

use super::Failure;
use crate::fault::InputError;
use crate::probe::Recording;

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
        match (&self.stream, &self.connect) {
            (Some(path), _) => Failure::input(format!(
                "{}: holds no greeting of a drive, or no capture\n  help: record from the start",
                path.display()
            )),
            (None, server) => Failure::check(format!(
                "{}: nothing has come in time\n  help: does `drive` run, and does the server pass on channel 1?",
                server.as_deref().unwrap_or_default()
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
        } else if let Some(server) = &self.connect {
            listen(server, commands, seconds, next, &mut recording)
                .map_err(|error| Failure::check(format!("{server}: {error}")))?;
        }
        Ok(recording)
    }
}

/// What to do after something has come.
enum Next {
    More,
    Enough,
    Ask(Command),
}

/// How often a command is repeated that may not be heard yet.
const AGAIN: Duration = Duration::from_millis(200);

fn listen(
    server: &str,
    commands: &[Command],
    seconds: f64,
    next: &mut dyn FnMut(&Recording) -> Next,
    recording: &mut Recording,
) -> std::io::Result<()> {
    let mut stream = TcpStream::connect(server)?;
    stream.set_read_timeout(Some(Duration::from_millis(50)))?;
    let mut sequence = 0;
    let mut send = |stream: &mut TcpStream, command: Command| {
        sequence += 1;
        stream.write_all(&encode(&Message::Command(command), sequence))
    };
    for command in commands {
        send(&mut stream, *command)?;
    }
    let (start, mut asked) = (Instant::now(), Instant::now());
    let mut buffer = [0; 4096];
    while start.elapsed().as_secs_f64() < seconds {
        match stream.read(&mut buffer) {
            Ok(0) => break,
            Ok(count) => recording.take(&buffer[..count]),
            Err(error)
                if matches!(
                    error.kind(),
                    std::io::ErrorKind::WouldBlock | std::io::ErrorKind::TimedOut
                ) => {}
            Err(error) => return Err(error),
        }
        match next(recording) {
            Next::More => {}
            Next::Enough => break,
            Next::Ask(command) if asked.elapsed() > AGAIN => {
                asked = Instant::now();
                send(&mut stream, command)?;
            }
            Next::Ask(_) => {}
        }
    }
    Ok(())
}
