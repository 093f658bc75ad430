//! The numbers that accept, reject or route, in one table: what decides an answer is to be read, and questioned, in
//! one place.
//!
//! Each line says what it is, its unit, and where it comes from. *derived*: from a distribution or another number of
//! this table; *convention*: the usual level of a test, or an agreed one; *physics*: what a joint, a drive or a sensor
//! can do, with room; *draws*: chosen on drawn joints whose truth was known, no more is recorded of it. A gain is a
//! difference of minus twice the log-likelihood, priors included. What is merely numerical (iterations, grids, sizes
//! of a field) stands beside its use.

/// Stages from which on a likelihood has many maxima, count; draws.
pub(crate) use crate::estimate::refit::MULTIMODAL;
/// Noise ratios (noise that a fit needs over the noise expected, 1) that the refit decides by as well.
pub(crate) use crate::estimate::refit::{ADRIFT, DOUBTED, DOUBTFUL, LOST};

// Gains.

/// Gain that counts: less is what a friction law slightly other than ours leaves; draws.
pub(crate) const LEAST_GAIN: f64 = 60.0;
/// The same on a joint of one stage at most whose noise is not doubtful: in 100 complete ones none exceeds 22; draws.
pub(crate) const LEAST_OF_SMOOTH: f64 = 40.0;
/// The same of a law of a stage in a chain of several: a fifth of the complete ones score 64 and more; draws.
pub(crate) const LEAST_OF_MULTIMODAL: f64 = 120.0;
/// Gain below which an effect has to make samples likelier that no fit has seen; 5 of those that count, draws.
pub(crate) const WEAK: f64 = 5.0 * LEAST_GAIN;
/// Gain by which one fit is behind another for its last refinement to be left out; 10 weak ones, draws.
pub(crate) const FAR_BEHIND: f64 = 10.0 * WEAK;
/// Gain of a base by its challengers' fits for another look at the round; draws.
pub(crate) const WORTH_ANOTHER: f64 = 20.0;
/// Log-likelihood that separates two effects by a factor e: other friction laws move it by some tens; draws.
pub(crate) const SEPARATION: f64 = 25.0;
/// Standard deviations of the replicates' best scores above their mean that chance does not reach, 1; draws.
pub(crate) const CHANCE_SIGMAS: f64 = 6.0;

// Noise ratios, and shares of the noise.

/// Noise ratio below which nothing is left to explain, 1; draws.
pub(crate) const CALM: f64 = 1.5;
/// Most of the noise of an inconsistent base that an effect may leave to be followed by another, 1; draws.
pub(crate) const HELPS: f64 = 0.8;
/// Share of the noise left by the annealed refit at which no other strategy is asked, 1; draws.
pub(crate) const EXPLAINED: f64 = 0.1;
/// Share of the noise that effects leave which improve nothing: the first of two as large leaves less, 1; draws.
pub(crate) const NOT_IMPROVED: f64 = 0.75;
/// Share of the rotor's noise that finer steps have to leave to be worth it by that, 1; draws.
pub(crate) const CALMER: f64 = 0.7;
/// Share of a score asked of a linear step whose noise has swallowed what is missing, 1; draws.
pub(crate) const SWALLOWED: f64 = 0.5;

// The search.

/// Effects that are added at most, count; draws.
pub(crate) const MOST_EFFECTS: usize = 4;
/// The same beside a coloured disturbance, count; draws.
pub(crate) const MOST_EFFECTS_DISTURBED: usize = 8;
/// Share of the best gain of short fits from which on an effect is refitted fully, 1; draws.
pub(crate) const RIVALLING: f64 = 0.2;
/// Share of the first effect's gain from which on a second one starts a search of its own, 1; draws.
pub(crate) const AS_MUCH: f64 = 0.9;
/// Share of the best score at inflated noise from which on an effect is fitted, 1; draws.
pub(crate) const ANNEALED_SHARE: f64 = 0.003;
/// RMS of prediction errors at inflated noise where they are nothing else, sigmas; draws.
pub(crate) const ANNEALED_NOISE: f64 = 1.05;
/// The same in the end where an effect beside others explains what is left, sigmas; draws.
pub(crate) const ANNEALED_JOINT: f64 = 1.3;
/// Share of the best annealed gain from which on an effect is refitted until it gains nothing more, 1; draws.
pub(crate) const ANNEALED_NEAR: f64 = 0.9;
/// Share of the way from the best to the worst annealed fit within which an effect comes near, 1; draws.
pub(crate) const ANNEALED_WITHIN: f64 = 0.5;
/// Share of a disturbance that an effect must explain to be begun at what a regression says, 1; draws.
pub(crate) const REGRESSED_SHARE: f64 = 0.3;
/// Share of a disturbance that a line of its spectrum must explain, 1; draws.
pub(crate) const LINE_SHARE: f64 = 0.01;
/// Share that its lines must explain together, 1; draws.
pub(crate) const LINES_TOGETHER: f64 = 0.5;
/// Share of its double below which a line is nothing itself, 1; draws.
pub(crate) const NO_LINE: f64 = 0.1;
/// Share of all that was explained from which on an effect owes none of it to the others, 1; draws.
pub(crate) const OWN_SHARE: f64 = 0.5;
/// Share of its first gain that an effect's loss has to cost to be needed without a refit, 1; draws.
pub(crate) const STILL_NEEDED: f64 = 0.1;

// Whether what is left is noise.

/// Most noise ratio of the drive, 1; draws.
pub(crate) const DRIVE_RATIO: f64 = 3.0;
/// Most noise ratio of the rotor with effects, whose laws may be slightly other than the joint's, 1; draws.
pub(crate) const TORQUE_RATIO: f64 = 4.5;
/// The same of a model to which nothing was added, 1; derived (the refit's own).
pub(crate) const PLAIN_TORQUE_RATIO: f64 = DOUBTFUL;
/// Most that an autocorrelation may exceed the replicates' beyond their scatter, 1; draws.
pub(crate) const AUTOCORRELATION: f64 = 0.1;
/// Standard deviations of the replicates' own scatter that are theirs, 1; convention.
pub(crate) const SCATTER: f64 = 2.0;
/// Most that a channel's variance may exceed the replicates', relative; draws.
pub(crate) const VARIANCE: f64 = 0.15;
/// Most RMS of errors on unseen samples over a replicate's, 1; draws.
pub(crate) const UNSEEN: f64 = 1.15;
/// The same of a chain of several stages, which lets go at another moment, 1; draws.
pub(crate) const UNSEEN_OF_MULTIMODAL: f64 = 1.25;
/// Most free-run error of a model found beside a disturbance over that of one without, and least of a model without an
/// effect over that of one with it for free runs to bear it out, or the other way round to take it back, 1; draws.
pub(crate) const FARTHEST: f64 = 2.0;

// Whether an effect is one that a joint can have.

/// Share of the largest current at which a torque must still grow with the current, 1; physics.
pub(crate) const RISING: f64 = 0.5;
/// Share of a law's end within which a value is at it, 1; draws.
pub(crate) const AT_END: f64 = 1e-3;
/// Times the drive's largest torque beyond which none acts on a joint that it moves, 1; physics.
pub(crate) const MOST_TORQUE: f64 = 10.0;
/// Share of its travel beyond which no encoder or gear is wrong by, 1; physics.
pub(crate) const MOST_ERROR: f64 = 0.25;
/// Share of a predicted sag that a measured bus must show: it is measured near the bridge, 1; physics.
pub(crate) const BUS_SHARE: f64 = 0.5;
/// Share of a predicted heating that a thermometer in the housing must show, 1; physics.
pub(crate) const TEMPERATURE_SHARE: f64 = 0.1;
/// Counts of an encoder that a joint has to move by to show more than its rounding, count; physics.
pub(crate) const COUNTS: f64 = 6.0;

// Evidence and confidence.

/// Chance that one of all hypotheses, or of all families, passes where there is nothing, 1; convention.
pub(crate) const BY_CHANCE: f64 = 0.05;
/// Correlation times of what a family leaves that are in a block, and lie between those it is fitted to and the one it
/// is asked of, count; derived (an exponential correlation falls to 0.2 % over them).
pub(crate) const APART: f64 = 3.0;
/// Standard errors beyond which lies a twentieth of a normal deviate, one-sided, 1; derived.
pub(crate) const SIGMAS: f64 = 1.645;
/// Slope of errors on what an effect changes of them at which it comes no nearer than none, 1; derived.
pub(crate) const HALFWAY: f64 = 0.5;
/// The same at which half of the squares that it changes are gained: false names stay below it; draws.
pub(crate) const MOSTLY: f64 = 0.75;
/// Share of the RMS of what drives an equation up to which a remainder does not matter, 1; convention.
pub(crate) const TOLERANCE: f64 = 0.01;
/// Most that an innovation counts for on unseen samples, sigmas: few moments of slip outweigh no others; draws.
pub(crate) const MOST_INNOVATION: f64 = 10.0;
/// Most confidence in an effect that unseen samples do not confirm, 1; convention (as likely as not).
pub(crate) const UNCONFIRMED: f64 = 0.5;
/// Odds of something unlisted against an effect that leaves noise, 1; draws.
pub(crate) const UNLISTED: f64 = 0.02;
