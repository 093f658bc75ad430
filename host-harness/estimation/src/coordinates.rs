//! What a fit moves: parameters of the joint, and the sizes of effects.

use nalgebra::DVector;

use super::parameters::Quantity;
use joint_simulation::model::Model;

/// One direction in which a model can be moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Coordinate {
    /// A parameter of the joint.
    Parameter(Quantity),
    /// A value of one of the model's effects, additive.
    Effect {
        /// Which effect of the model.
        effect: usize,
        /// Which of its values.
        value: usize,
        /// Size at which the value starts to matter: scale of differences and steps.
        scale: f64,
        /// One sigma of the prior, centred where the fit's origin has it.
        sigma: f64,
    },
    /// Both parts of a sine of one of the model's effects, as amplitude·cos and amplitude·sin: the
    /// amplitude's value is followed by the phase's.
    Phasor {
        /// Which effect of the model.
        effect: usize,
        /// Which value is the amplitude.
        amplitude: usize,
        /// Whether this is the sine part.
        sine: bool,
        /// Size at which the amplitude starts to matter.
        scale: f64,
        /// One sigma of the prior.
        sigma: f64,
    },
}

/// One over the square of each coordinate's prior sigma.
pub fn precision(coordinates: &[Coordinate]) -> DVector<f64> {
    let precision = coordinates.iter().map(|c| c.prior_sigma().powi(-2));
    DVector::from_iterator(coordinates.len(), precision)
}

impl Coordinate {
    /// Moves a model by a step in this coordinate.
    pub fn shift(&self, model: &mut Model, step: f64) {
        match *self {
            Coordinate::Parameter(quantity) => quantity.shift(model, step),
            Coordinate::Effect { effect, value, scale, .. } => {
                let spec = model.effects[effect].kind.spec().parameters[value];
                let slot = &mut model.effects[effect].values[value];
                *slot = (*slot + step * scale).clamp(spec.low, spec.high);
            }
            Coordinate::Phasor { effect, amplitude, sine, scale, .. } => {
                let most = model.effects[effect].kind.spec().parameters[amplitude].high;
                let values = &mut model.effects[effect].values;
                let (size, phase) = (values[amplitude], values[amplitude + 1]);
                let (mut cos, mut sin) = (size * phase.cos(), size * phase.sin());
                if sine {
                    sin += step * scale;
                } else {
                    cos += step * scale;
                }
                values[amplitude] = cos.hypot(sin).min(most);
                if values[amplitude] > 0.0 {
                    values[amplitude + 1] = sin.atan2(cos);
                }
            }
        }
    }

    /// How far `to` lies from `from`.
    pub fn distance(&self, from: &Model, to: &Model) -> f64 {
        match *self {
            Coordinate::Parameter(quantity) => quantity.distance(from, to),
            _ => self.part(to) - self.part(from),
        }
    }

    /// The coordinate's own value in units of its scale; zero where the effect is not there.
    fn part(&self, model: &Model) -> f64 {
        match *self {
            Coordinate::Parameter(quantity) => quantity.get(model),
            Coordinate::Effect { effect, value, scale, .. } => {
                model.effects.get(effect).map_or(0.0, |effect| effect.values[value] / scale)
            }
            Coordinate::Phasor { effect, amplitude, sine, scale, .. } => {
                model.effects.get(effect).map_or(0.0, |effect| {
                    let (size, phase) = (effect.values[amplitude], effect.values[amplitude + 1]);
                    size * if sine { phase.sin() } else { phase.cos() } / scale
                })
            }
        }
    }

    /// One sigma of the prior, in the coordinate's unit.
    pub fn prior_sigma(&self) -> f64 {
        match *self {
            Coordinate::Parameter(quantity) => quantity.prior_sigma(),
            Coordinate::Effect { sigma, .. } | Coordinate::Phasor { sigma, .. } => sigma,
        }
    }

    /// Which effect of the model it moves, if it does.
    pub fn effect(&self) -> Option<usize> {
        match *self {
            Coordinate::Parameter(_) => None,
            Coordinate::Effect { effect, .. } | Coordinate::Phasor { effect, .. } => Some(effect),
        }
    }

    /// Whether it moves this value of this effect of the model.
    pub fn is_of(&self, of: usize, number: usize) -> bool {
        matches!(*self, Coordinate::Effect { effect, value, .. } if (effect, value) == (of, number))
    }

    /// The same coordinate in a model without its effect number `gone`; `None` if it is that
    /// effect's.
    pub fn without_effect(&self, gone: usize) -> Option<Self> {
        let mut copy = *self;
        match &mut copy {
            Coordinate::Parameter(_) => {}
            Coordinate::Effect { effect, .. } | Coordinate::Phasor { effect, .. } => {
                if *effect == gone {
                    return None;
                }
                if *effect > gone {
                    *effect -= 1;
                }
            }
        }
        Some(copy)
    }

    /// A step kept within what one linear step may be trusted with: a parameter changes by at most
    /// two thirds, an effect by as much as it asks for.
    pub fn limited(&self, step: f64) -> f64 {
        match self {
            Coordinate::Parameter(_) => step.clamp(-0.5, 0.5),
            _ => step,
        }
    }

    /// Step of the differences that take its derivative.
    pub fn difference_step(&self) -> f64 {
        match self {
            Coordinate::Parameter(_) => 1e-3,
            Coordinate::Effect { .. } | Coordinate::Phasor { .. } => 1e-2,
        }
    }
}

#[cfg(test)]
mod tests {
    use joint_core::effect::{EffectParameters, Kind};
    use joint_core::params::Location;

    use super::*;
    use joint_simulation::demo::actuator;

    #[test]
    fn an_amplitude_never_leaves_the_range_of_its_law() {
        let mut model = actuator();
        let line = EffectParameters::new(Kind::PositionDependentFriction, Location::Motor);
        model.effects.push(line.with("order", 3.0));
        let part =
            Coordinate::Phasor { effect: 0, amplitude: 0, sine: true, scale: 0.05, sigma: 10.0 };
        part.shift(&mut model, 1e6);
        assert_eq!(model.effects[0].values[..2], [0.95, std::f64::consts::FRAC_PI_2]);
        part.shift(&mut model, -4.0);
        assert!((model.effects[0].values[0] - 0.75).abs() < 1e-12);
    }
}
