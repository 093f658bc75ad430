//! Talking with a running drive: commands down, frames up, whatever carries them.

use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use joint_core::telemetry::frame::encode;
use joint_core::telemetry::{Command, Message};

use super::Recording;

/// What carries bytes to and from a drive.
pub trait Wire {
    /// Sends all of it.
    ///
    /// # Errors
    /// The drive cannot be reached.
    fn send(&mut self, bytes: &[u8]) -> Result<(), String>;

    /// Takes what has come; waits a little where nothing has. `None`: nothing more will come.
    ///
    /// # Errors
    /// The drive cannot be reached.
    fn receive(&mut self, buffer: &mut [u8]) -> Result<Option<usize>, String>;
}

impl Wire for TcpStream {
    fn send(&mut self, bytes: &[u8]) -> Result<(), String> {
        self.write_all(bytes).map_err(|error| error.to_string())
    }

    fn receive(&mut self, buffer: &mut [u8]) -> Result<Option<usize>, String> {
        match self.read(buffer) {
            Ok(0) => Ok(None),
            Ok(count) => Ok(Some(count)),
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {
                Ok(Some(0))
            }
            Err(error) => Err(error.to_string()),
        }
    }
}

/// A debug server's stream.
///
/// # Errors
/// It cannot be reached.
pub fn server(address: &str) -> Result<TcpStream, String> {
    let stream = TcpStream::connect(address).map_err(|error| error.to_string())?;
    stream.set_read_timeout(Some(Duration::from_millis(50))).map_err(|error| error.to_string())?;
    Ok(stream)
}

/// What to do after something has come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Next {
    /// Listen on.
    More,
    /// All is there.
    Enough,
    /// Ask for it, now and then, until it comes.
    Ask(Command),
}

/// How often a command is repeated that may not be heard yet.
const AGAIN: Duration = Duration::from_millis(200);

/// Sends the commands and takes what comes, for that long or until there is enough.
///
/// # Errors
/// The drive cannot be reached.
pub fn listen(
    wire: &mut dyn Wire,
    commands: &[Command],
    seconds: f64,
    next: &mut dyn FnMut(&Recording) -> Next,
    recording: &mut Recording,
) -> Result<(), String> {
    let mut sequence = 0;
    let mut send = |wire: &mut dyn Wire, command: Command| {
        sequence += 1;
        wire.send(&encode(&Message::Command(command), sequence))
    };
    for command in commands {
        send(wire, *command)?;
    }
    let (start, mut asked) = (Instant::now(), Instant::now());
    let mut buffer = [0; 4096];
    while start.elapsed().as_secs_f64() < seconds {
        match wire.receive(&mut buffer)? {
            None => break,
            Some(count) => recording.take(&buffer[..count]),
        }
        match next(recording) {
            Next::More => {}
            Next::Enough => break,
            Next::Ask(command) if asked.elapsed() > AGAIN => {
                asked = Instant::now();
                send(wire, command)?;
            }
            Next::Ask(_) => {}
        }
    }
    Ok(())
}
