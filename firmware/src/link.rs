//! The task's side of the telemetry: messages to frames, frames to commands.
//!
//! It runs below the control interrupt and may be late; what it cannot get rid of it drops whole,
//! with a sequence number, so that the reader sees the gap.

use heapless::mpmc::Queue;
use joint_core::telemetry::frame::{Reader, encode};
use joint_core::telemetry::{Command, Message};

/// A queue of messages.
///
/// The crate deprecates its constructor because a producer that is interrupted may make others
/// fail for as long; here only the task is ever interrupted, and what then finds no room is dropped
/// and counted like anything else.
#[expect(deprecated)]
pub const fn messages() -> Messages {
    Messages::new()
}

/// A queue of commands; as [`messages`].
#[expect(deprecated)]
pub const fn commands() -> Commands {
    Commands::new()
}

/// Messages that wait for the task: 8 ms of reports at the default rate.
pub type Messages = Queue<Message, 8>;
/// Commands that wait for the interrupt.
pub type Commands = Queue<Command, 8>;

/// The sending and receiving end.
#[derive(Debug, Default)]
pub struct Link {
    sequence: u32,
    reader: Reader,
}

impl Link {
    /// Sends one waiting message as a frame; `write` takes it whole, or says that it did not. False
    /// where there was none.
    pub fn send(&mut self, messages: &Messages, write: impl FnOnce(&[u8]) -> bool) -> bool {
        let Some(message) = messages.dequeue() else { return false };
        let frame = encode(&message, self.sequence);
        self.sequence = self.sequence.wrapping_add(1);
        // A frame that is not taken is seen as a gap in the sequence.
        let _ = write(&frame);
        true
    }

    /// Takes in a byte and passes on the command that it completes; one that finds no room is lost.
    pub fn receive(&mut self, byte: u8, commands: &Commands) {
        let mut frame = self.reader.push(byte);
        while let Some(found) = frame {
            if let Message::Command(command) = found.message {
                let _ = commands.enqueue(command);
            }
            frame = self.reader.rest();
        }
    }
}
