//! How far what is found is from what is true.

use joint_core::observer::Spread;

use super::run::Found;

/// What a method says of one sample, or what is true; NaN where nothing is said.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Guess {
    /// Load at the output, Nm.
    pub load: f64,
    /// Wind-up of the first stage, rad.
    pub first: f64,
    /// Wind-up of the last stage, rad.
    pub windup: f64,
    /// Friction of the joint at the motor, Nm.
    pub friction: f64,
}

impl Guess {
    /// Says nothing.
    pub const NOTHING: Guess =
        Guess { load: f64::NAN, first: f64::NAN, windup: f64::NAN, friction: f64::NAN };

    /// Of what an observer found.
    pub fn found<const N: usize>(found: &Found<N>) -> Self {
        let e = &found.estimate;
        Self::of(e.load, &e.windup, e.total_friction)
    }

    /// One standard deviation of it.
    pub fn spread<const N: usize>(spread: &Spread<f64, N>) -> Self {
        Self::of(spread.load, &spread.windup, spread.total_friction)
    }

    fn of(load: f64, windup: &[f64], friction: f64) -> Self {
        let first = windup.first().copied().unwrap_or(f64::NAN);
        let last = windup.last().copied().unwrap_or(f64::NAN);
        Self { load, first, windup: last, friction }
    }
}

/// How far one method was off on one motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Score {
    /// RMS of the load's error, share of its peak.
    pub load: f64,
    /// The same outside of the time just after a jump of the load.
    pub calm: f64,
    /// RMS of the first wind-up's error, share of its peak; NaN without stages.
    pub first: f64,
    /// RMS of the last wind-up's error, share of its peak; NaN without stages.
    pub windup: f64,
    /// RMS of the friction's error, share of its RMS.
    pub friction: f64,
    /// RMS of the error of friction and reflected load as one torque, share of its RMS.
    pub both: f64,
    /// Median time to 90 % of a step of the load, s; infinite where it is not reached in 50 ms.
    pub t90_s: f64,
    /// Share of errors within one and two standard deviations: load, last wind-up, friction; NaN for
    /// a baseline.
    pub within: [[f64; 2]; 3],
}

impl Score {
    /// Says nothing.
    pub const NONE: Self = Self {
        load: f64::NAN,
        calm: f64::NAN,
        first: f64::NAN,
        windup: f64::NAN,
        friction: f64::NAN,
        both: f64::NAN,
        t90_s: f64::NAN,
        within: [[f64::NAN; 2]; 3],
    };
}

/// Samples with the truth beside them.
#[derive(Clone, Debug)]
pub struct Judged<'a> {
    /// What is true.
    pub truth: &'a [Guess],
    /// Samples at which the load steps.
    pub jumps: &'a [usize],
    /// Time between samples, s.
    pub step_s: f64,
    /// The output's turns in a turn of the rotor.
    pub shaft: f64,
}

/// Samples at which a load steps by more than a fifth of its peak.
pub fn jumps(loads: &[f64]) -> Vec<usize> {
    let most = loads.iter().fold(0.0_f64, |most, load| most.max(load.abs()));
    let steps = loads.windows(2).enumerate();
    steps.filter(|(_, pair)| (pair[1] - pair[0]).abs() > 0.2 * most).map(|(k, _)| k + 1).collect()
}

impl Judged<'_> {
    /// The score of some guesses, with one standard deviation of each where there is one.
    pub fn score(&self, guesses: &[Guess], sigma: Option<&[Guess]>) -> Score {
        let from = self.truth.len() / 10;
        let pairs = || guesses.iter().zip(self.truth).skip(from);
        let mean = |values: &mut dyn Iterator<Item = f64>| {
            let (sum, count) = values.fold((0.0, 0.0), |(sum, n), value| (sum + value, n + 1.0));
            sum / count
        };
        let rms = |of: &dyn Fn(&Guess, &Guess) -> f64| {
            mean(&mut pairs().map(|(g, t)| of(g, t).powi(2))).sqrt()
        };
        let peak =
            |of: &dyn Fn(&Guess) -> f64| self.truth.iter().map(|t| of(t).abs()).fold(0.0, f64::max);
        let share = |of: &dyn Fn(&Guess) -> f64| match sigma {
            Some(sigma) => [1.0, 2.0].map(|many| {
                let inside = pairs().zip(&sigma[from..]);
                mean(&mut inside.map(|((g, t), s)| {
                    let error = of(g) - of(t);
                    if error.is_nan() {
                        error
                    } else {
                        f64::from(u8::from(error.abs() <= many * of(s)))
                    }
                }))
            }),
            None => [f64::NAN; 2],
        };
        let unsettled = self.unsettled();
        let calm = pairs().zip(&unsettled[from..]).filter(|(_, unsettled)| !**unsettled);
        let calm = mean(&mut calm.map(|((g, t), _)| (g.load - t.load).powi(2))).sqrt();
        let sum = |guess: &Guess| guess.friction + guess.load * self.shaft;
        let most = peak(&|t| t.load);
        Score {
            load: rms(&|g, t| g.load - t.load) / most,
            calm: calm / most,
            first: rms(&|g, t| g.first - t.first) / peak(&|t| t.first),
            windup: rms(&|g, t| g.windup - t.windup) / peak(&|t| t.windup),
            friction: rms(&|g, t| g.friction - t.friction) / rms(&|_, t| t.friction),
            both: rms(&|g, t| sum(g) - sum(t)) / rms(&|_, t| sum(t)),
            t90_s: self.rise(guesses),
            within: [share(&|g| g.load), share(&|g| g.windup), share(&|g| g.friction)],
        }
    }

    /// Where the load has just jumped: for 10 ms, on a joint sampled at 10 kHz and above for 3 ms.
    fn unsettled(&self) -> Vec<bool> {
        let settling = if self.step_s < 1.5e-4 { 3e-3 } else { 10e-3 };
        let length = (settling / self.step_s).round() as usize;
        let mut unsettled = vec![false; self.truth.len()];
        for &jump in self.jumps {
            unsettled.iter_mut().skip(jump).take(length).for_each(|so| *so = true);
        }
        unsettled
    }

    fn rise(&self, guesses: &[Guess]) -> f64 {
        if guesses.iter().all(|guess| guess.load.is_nan()) {
            return f64::NAN;
        }
        let window = (0.05 / self.step_s) as usize;
        let ends = self.jumps.iter().skip(1).copied().chain([self.truth.len()]);
        let mut times: Vec<f64> = self
            .jumps
            .iter()
            .zip(ends)
            .filter(|(jump, _)| **jump > 0 && **jump >= self.truth.len() / 10)
            .map(|(&jump, end)| {
                let before = self.truth[jump - 1].load;
                let step = self.truth[jump].load - before;
                let until = end.min(jump + window);
                let there = |k: &usize| (guesses[*k].load - before) / step >= 0.9;
                (jump..until).find(there).map_or(f64::INFINITY, |k| (k - jump) as f64 * self.step_s)
            })
            .collect();
        times.sort_by(f64::total_cmp);
        times.get(times.len() / 2).copied().unwrap_or(f64::NAN)
    }
}
