//! What an effect has to gain at its place, on a joint as it is fitted so far.

use joint_core::params::Location;

use crate::discover::bounds::{
    DOUBTFUL, LEAST_GAIN, LEAST_OF_MULTIMODAL, LEAST_OF_SMOOTH, MULTIMODAL, WEAK,
};
use crate::discover::state::search::Search;

impl Search {
    /// Least that an effect at a place must explain of the model as it is.
    pub(crate) fn least_gain(&self, place: Location) -> f64 {
        least_gain(self.after.origin.stages.len(), self.noise_ratio(), place)
    }

    /// Gain below which an effect at a place is weak: samples that no fit has seen must confirm it.
    pub(crate) fn weak_gain(&self, place: Location) -> f64 {
        WEAK / LEAST_GAIN * self.least_gain(place).max(LEAST_GAIN)
    }
}

fn least_gain(stages: usize, noise_ratio: f64, place: Location) -> f64 {
    match place {
        Location::Stage(_) if stages >= MULTIMODAL => LEAST_OF_MULTIMODAL,
        _ if stages < MULTIMODAL && noise_ratio < DOUBTFUL => LEAST_OF_SMOOTH,
        _ => LEAST_GAIN,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_law_of_a_chain_of_stages_has_to_explain_more_than_one_of_a_smooth_joint() {
        let at = |stages: usize, place: Location| least_gain(stages, 1.0, place);
        let stage = Location::Stage(1);
        assert_eq!([at(2, stage), at(1, stage)], [LEAST_OF_MULTIMODAL, LEAST_OF_SMOOTH]);
        let rotor = Location::Motor;
        assert_eq!([at(2, rotor), at(0, rotor)], [LEAST_GAIN, LEAST_OF_SMOOTH]);
        assert_eq!(least_gain(0, 7.0, rotor), LEAST_GAIN);
    }
}
