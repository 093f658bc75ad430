//! What a filter did over a stretch of its way, kept to be gone through on another core while the filter is
//! at the next.

use super::covariance::Transition;
use super::keep::{Keep, Measured, Passed};
use super::record::Channel;

/// What happened, but for the numbers by state.
#[derive(Clone, Copy, Debug)]
enum Event {
    Began,
    Measured { sample: usize, channel: Channel, innovation: f64, variance: f64 },
    Taken { sample: usize, channel: usize, error: f64, weight: f64 },
    Passed { reversing: [f64; 2], interval: f64 },
}

/// A stretch of a filter's way, without its states and gains.
#[derive(Debug, Default)]
pub(super) struct Tape {
    events: Vec<Event>,
    /// Of every measurement in turn two numbers by state, of every interval three.
    numbers: Vec<f64>,
    /// Of every interval in turn; what is beyond them is of another stretch.
    transitions: Vec<Transition>,
    intervals: usize,
}

impl Tape {
    /// Forgets what is on it.
    pub(super) fn clear(&mut self) {
        self.events.clear();
        self.numbers.clear();
        self.intervals = 0;
    }

    /// Shows what is on it to something that watches filters of that many states.
    pub(super) fn play(&self, order: usize, keep: &mut impl Keep) {
        let mut numbers = self.numbers.chunks_exact(order.max(1));
        let mut next = || numbers.next().unwrap_or_default();
        let mut transitions = self.transitions.iter();
        for event in &self.events {
            match *event {
                Event::Began => keep.began(),
                Event::Measured { sample, channel, innovation, variance } => {
                    let (row, column) = (next(), next());
                    keep.measured(&Measured { sample, channel, row, column, innovation, variance });
                }
                Event::Taken { sample, channel, error, weight } => {
                    keep.taken(sample, channel, error, weight, &[]);
                }
                Event::Passed { reversing, interval } => {
                    let Some(transition) = transitions.next() else { return };
                    let (drive, kick, behind) = (next(), next(), next());
                    keep.passed(&Passed { transition, drive, kick, behind, reversing, interval });
                }
            }
        }
    }
}

impl Keep for Tape {
    fn taken(&mut self, sample: usize, channel: usize, error: f64, weight: f64, _: &[f64]) {
        self.events.push(Event::Taken { sample, channel, error, weight });
    }

    fn corrected(&mut self, _: &[f64]) {}

    fn began(&mut self) {
        self.events.push(Event::Began);
    }

    fn measured(&mut self, at: &Measured<'_>) {
        let Measured { sample, channel, row, column, innovation, variance } = *at;
        self.events.push(Event::Measured { sample, channel, innovation, variance });
        self.numbers.extend_from_slice(row);
        self.numbers.extend_from_slice(column);
    }

    fn passed(&mut self, over: &Passed<'_>) {
        self.events.push(Event::Passed { reversing: over.reversing, interval: over.interval });
        self.numbers.extend_from_slice(over.drive);
        self.numbers.extend_from_slice(over.kick);
        self.numbers.extend_from_slice(over.behind);
        match self.transitions.get_mut(self.intervals) {
            Some(known) => known.copy_from(over.transition),
            None => self.transitions.push(over.transition.clone()),
        }
        self.intervals += 1;
    }
}
