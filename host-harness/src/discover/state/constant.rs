//! What a constant torque explains where gravity is named.

use joint_core::effect::Kind;

use crate::discover::bounds::LEAST_GAIN;

/// What a constant torque explains in gravity's place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Constant {
    /// The kind in whose place it stands.
    pub(crate) of: Kind,
    /// What it takes from minus twice the log-likelihood, less what gravity takes.
    pub(crate) lead: f64,
    /// Its torque on the rotor, Nm.
    pub(crate) torque_nm: f64,
}

impl Constant {
    /// Whether gravity cannot be named beside it: what the record shows of gravity's own is less than a
    /// name must explain.
    pub(crate) fn undecided(&self) -> bool {
        self.lead > -LEAST_GAIN
    }

    /// What it says of gravity, in a sentence; `gravity` is what that takes.
    pub(crate) fn told(&self, gravity: f64) -> String {
        let Self { lead, torque_nm, .. } = self;
        let gain = gravity + lead;
        let says = match () {
            () if self.lead >= 0.0 => "nothing shows that the pull changes with the angle",
            () if self.undecided() => "the travel hardly tells them apart",
            () => "the pull is seen to change with the angle",
        };
        format!(
            "a constant torque of {torque_nm:.3e} Nm on the rotor in the place of gravity takes {gain:.0}: {says}"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gravity_has_to_explain_something_beside_a_constant() {
        let undecided =
            |lead: f64| Constant { of: Kind::Gravity, lead, torque_nm: 1.0 }.undecided();
        let near = 0.9 * LEAST_GAIN;
        assert_eq!([near, -near, -2.0 * near].map(undecided), [true, true, false]);
    }
}
