//! The capture ring: raw samples at the full control rate, around a trigger.
//!
//! A debugger link carries a fraction of what the control interrupt sees. So the interrupt writes
//! every sample into a ring; the trigger lets it run on for as long as asked and then stops it, and
//! the record waits to be fetched at whatever pace the link has. A record is what `joint discover`
//! reads, so it is never overwritten before it is fetched or given up.

use heapless::Vec;

use super::{CaptureHead, MAX_SAMPLES, Message, Report, Sample, Trigger};

// Tags of their own, so that what a capture starts with is zero.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(u8)]
enum Phase {
    Idle,
    Armed { trigger: Trigger, after: u32 },
    Running { left: u32, after: u32 },
    Complete { after: u32 },
}

/// How much of the record was sent.
#[derive(Clone, Copy, Debug)]
#[repr(u8)]
enum Sent {
    /// Nothing is being sent.
    All,
    Nothing,
    Samples(u32),
}

/// A ring of `LENGTH` samples.
#[derive(Debug)]
pub struct Capture<const LENGTH: usize> {
    ring: [Sample; LENGTH],
    /// Where the next sample goes: where the oldest is, once the ring is full.
    at: usize,
    held: usize,
    phase: Phase,
    last_tick: u32,
    last_speed: f32,
    sent: Sent,
}

impl<const LENGTH: usize> Default for Capture<LENGTH> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const LENGTH: usize> Capture<LENGTH> {
    /// An empty ring that waits to be armed: all zeros, which a static of it costs no flash.
    pub const fn new() -> Self {
        const { assert!(LENGTH > 0, "a ring holds at least one sample") };
        Self {
            ring: [const { Sample { voltage_v: 0.0, current_a: 0.0, motor_counts: 0, output_counts: 0 } };
                LENGTH],
            at: 0,
            held: 0,
            phase: Phase::Idle,
            last_tick: 0,
            last_speed: 0.0,
            sent: Sent::All,
        }
    }

    /// Forgets what was captured and waits for a trigger; from it on, `after` samples are taken, at
    /// least the triggering one and at most the ring's length. What was there before fills the rest.
    pub fn arm(&mut self, trigger: Trigger, after: u32) {
        self.disarm();
        let after = after.clamp(1, LENGTH as u32);
        self.phase = Phase::Armed { trigger, after };
    }

    /// Forgets what was captured and takes nothing more.
    pub fn disarm(&mut self) {
        self.at = 0;
        self.held = 0;
        self.phase = Phase::Idle;
        self.sent = Sent::All;
    }

    /// Whether a record is complete.
    pub fn is_complete(&self) -> bool {
        matches!(self.phase, Phase::Complete { .. })
    }

    /// Takes in a control period.
    pub fn take(&mut self, report: &Report) {
        let speed = report.estimates.motor_velocity_rad_per_s;
        let reversed = speed * self.last_speed < 0.0;
        if speed != 0.0 {
            self.last_speed = speed;
        }
        if let Phase::Armed { trigger, after } = self.phase
            && match trigger {
                Trigger::Now => true,
                Trigger::CurrentAbove(amperes) => report.sample.current_a.abs() > amperes,
                Trigger::Status(mask) => report.status.meets(mask),
                Trigger::Reversal => reversed,
            }
        {
            self.phase = Phase::Running { left: after, after };
        }
        match self.phase {
            Phase::Idle | Phase::Complete { .. } => return,
            Phase::Armed { .. } => {}
            Phase::Running { left, after } => {
                self.phase = match left {
                    0 | 1 => Phase::Complete { after },
                    more => Phase::Running { left: more - 1, after },
                };
            }
        }
        self.last_tick = report.tick;
        if let Some(slot) = self.ring.get_mut(self.at) {
            *slot = report.sample;
        }
        self.at = if self.at + 1 < LENGTH { self.at + 1 } else { 0 };
        self.held = if self.held < LENGTH { self.held + 1 } else { LENGTH };
    }

    /// Starts sending the record from its beginning; nothing where it is not complete.
    pub fn fetch(&mut self) {
        if self.is_complete() {
            self.sent = Sent::Nothing;
        }
    }

    /// The next part of the record that is being sent, its head first; the same one again until it
    /// [was sent](Capture::sent), and `None` when there is no more.
    pub fn pending(&self) -> Option<Message> {
        let Phase::Complete { after } = self.phase else { return None };
        let samples = self.held as u32;
        let first = match self.sent {
            Sent::All => return None,
            Sent::Nothing => {
                return Some(Message::CaptureHead(CaptureHead {
                    samples,
                    trigger_at: samples.saturating_sub(after),
                    first_tick: self.last_tick.wrapping_sub(samples.saturating_sub(1)),
                }));
            }
            Sent::Samples(first) => first,
        };
        let (newer, older) = self.ring.split_at_checked(self.at).unwrap_or_default();
        let older = if self.held < LENGTH { &[] } else { older };
        let at = first as usize;
        let older_left = older.get(at..).unwrap_or_default();
        let newer_left = newer.get(at.saturating_sub(older.len())..).unwrap_or_default();
        let left = older_left.iter().chain(newer_left).take(MAX_SAMPLES);
        Some(Message::Samples(first, left.copied().collect::<Vec<Sample, MAX_SAMPLES>>()))
    }

    /// Goes on to the next part.
    pub fn sent(&mut self) {
        let next = match self.sent {
            Sent::All => return,
            Sent::Nothing => 0,
            Sent::Samples(first) => first + MAX_SAMPLES as u32,
        };
        let more = next < self.held as u32;
        self.sent = if more { Sent::Samples(next) } else { Sent::All };
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Quantities, Status};
    use super::*;

    const LENGTH: usize = 32;

    fn report(tick: u32) -> Report {
        let sample = Sample {
            current_a: if tick == 50 { -3.0 } else { 0.5 },
            motor_counts: tick as i32,
            ..Sample::default()
        };
        let speed = if tick < 60 { 1.0 } else { -1.0 };
        Report {
            tick,
            sample,
            status: if tick == 55 { Status::LATE } else { Status::default() },
            estimates: Quantities { motor_velocity_rad_per_s: speed, ..Quantities::default() },
            ..Report::default()
        }
    }

    fn record(trigger: Trigger, after: u32) -> Option<(CaptureHead, std::vec::Vec<i32>)> {
        let mut capture = Capture::<LENGTH>::new();
        capture.arm(trigger, after);
        for tick in 0..100 {
            capture.take(&report(tick));
        }
        sent(&mut capture)
    }

    fn sent(capture: &mut Capture<LENGTH>) -> Option<(CaptureHead, std::vec::Vec<i32>)> {
        capture.fetch();
        let (mut head, mut all) = (None, vec![]);
        while let Some(message) = capture.pending() {
            assert_eq!(capture.pending().as_ref(), Some(&message));
            capture.sent();
            match message {
                Message::CaptureHead(own) => head = Some(own),
                Message::Samples(first, samples) => {
                    assert_eq!(first as usize, all.len());
                    all.extend(samples.iter().map(|sample| sample.motor_counts));
                }
                other => panic!("{other:?}"),
            }
        }
        Some((head?, all))
    }

    #[test]
    fn the_record_stands_around_its_trigger() {
        for (trigger, at) in [
            (Trigger::CurrentAbove(2.0), 50),
            (Trigger::Status(Status::LATE), 55),
            (Trigger::Reversal, 60),
        ] {
            let (head, record) = record(trigger, 10).unwrap();
            assert_eq!((head.samples, head.trigger_at), (32, 22));
            assert_eq!(head.first_tick, at - 22);
            assert_eq!(record, (at as i32 - 22..at as i32 + 10).collect::<std::vec::Vec<i32>>());
        }
    }

    #[test]
    fn a_trigger_at_once_has_nothing_before_it_and_one_that_never_comes_no_record() {
        let (head, all) = record(Trigger::Now, 10).unwrap();
        assert_eq!(head, CaptureHead { samples: 10, trigger_at: 0, first_tick: 0 });
        assert_eq!(all, (0..10).collect::<std::vec::Vec<i32>>());
        assert_eq!(record(Trigger::Now, 1_000).unwrap().1.len(), LENGTH);
        assert_eq!(record(Trigger::CurrentAbove(9.0), 10), None);
    }

    #[test]
    fn a_record_waits_until_it_is_fetched_or_given_up() {
        let mut capture = Capture::<LENGTH>::new();
        capture.arm(Trigger::Now, 5);
        for tick in 0..100 {
            capture.take(&report(tick));
        }
        for _ in 0..2 {
            assert_eq!(sent(&mut capture).unwrap().1, [0, 1, 2, 3, 4]);
        }
        capture.disarm();
        assert_eq!(sent(&mut capture), None);
    }
}
