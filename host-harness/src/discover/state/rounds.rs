//! The effects that were added one by one, their rivals, and how every hypothesis did.

use joint_core::effect::Kind;
use joint_core::params::Location;

use super::stage::Stage;

/// The name of an effect: its kind and its place.
pub(crate) type Name = (Kind, Location);

/// A name and what its full refit explained.
#[derive(Clone, Debug)]
pub(crate) struct Contender {
    /// The name.
    pub(crate) name: Name,
    /// What it took from minus twice the log-likelihood.
    pub(crate) gain: f64,
}

/// One effect added.
#[derive(Clone, Debug)]
pub(crate) struct Round {
    /// Its name.
    pub(crate) name: Name,
    /// What it explained.
    pub(crate) gain: f64,
    /// The others that were refitted.
    pub(crate) rivals: Vec<Contender>,
    /// The best of them, refitted.
    pub(crate) runner_up: Option<Stage>,
    /// Share of the logs drawn from this one in which it stays ahead of that one, and of nothing.
    pub(crate) stays_ahead: f64,
}

/// How a hypothesis did.
#[derive(Clone, Debug, PartialEq)]
pub struct ScoreRow {
    /// In which round of the search, from 1.
    pub round: usize,
    /// Kind and place.
    pub name: String,
    /// What its linear step would take from minus twice the log-likelihood.
    pub score: f64,
    /// What its full refit did take, where it was refitted.
    pub refitted: Option<f64>,
}

/// A name as it is shown.
pub(crate) fn title((kind, location): Name) -> String {
    format!("{} ({location})", kind.spec().kind)
}
