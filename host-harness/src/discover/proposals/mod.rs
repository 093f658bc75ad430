//! What proposes an effect.
//!
//! Every proposal scores all hypotheses in its own way, refits the best of them, and hands back what each gained. It
//! decides nothing: what is added, `search` decides by the `checks`. A base that is near is asked by one linear step
//! ([`linear_step`]). One that cannot be refitted around what is missing is asked at inflated process noise
//! ([`annealed`]), or beside a disturbance state ([`disturbance_state`]), from which effects are regressed
//! ([`disturbance_regression`]) and lines read ([`line_spectrum`]).

pub(crate) mod annealed;
pub(crate) mod chance;
pub(crate) mod disturbance_regression;
pub(crate) mod disturbance_state;
pub(crate) mod line_spectrum;
pub(crate) mod linear_step;
pub(crate) mod proposed;
pub(crate) mod refits;
pub(crate) mod score_test;
pub(crate) mod scored;
