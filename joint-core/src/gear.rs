//! The spring of one gear stage, `T = k1 x + k3 x³ + c ẋ`, equation (1), reflected to the motor.

use crate::batch::batch;
use crate::number::Number;
use crate::params::Stage;

/// How a format sums a deflection, and takes the tangent of a hardening spring.
pub trait Deflection: Number {
    /// The deflection after it grew by a product, and what rounding has taken of it so far: a float
    /// keeps nothing, since it rounds by a share of the sum.
    #[inline(always)]
    fn drifted(self, lost: Self, change: Self, gain: Self::Gain) -> (Self, Self) {
        (self + change.times(gain), lost)
    }
    /// Three times it.
    #[inline(always)]
    fn thrice(self) -> Self {
        self + self + self
    }
}

impl Deflection for f32 {
    #[inline(always)]
    fn thrice(self) -> f32 {
        self * 3.0
    }
}

impl Deflection for f64 {}

/// Constants of one stage's spring, per-unit and reflected to the motor.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub struct Spring<S: Number> {
    linear: S,
    /// Root of the cubic stiffness: a deflection's square may not fit the number's range.
    cubic: S::Gain,
    damping: S::Gain,
    /// Share of the relative speed that damping takes in half a step, on the mass before and after.
    before: S::Gain,
    after: S::Gain,
}

batch!(Spring<Deflection>: linear, cubic, damping, before, after);

impl<S: Deflection> Spring<S> {
    /// From SI: `shaft` is the ratio of the spring's output side to the motor; `inertia` are the
    /// reflected inertias before and after it.
    pub(crate) fn new(
        stage: &Stage,
        shaft: f64,
        half_step: f64,
        [torque, speed, angle]: [f64; 3],
        inertia: [f64; 2],
    ) -> Self {
        let square = shaft * shaft;
        let linear = stage.stiffness_nm_per_rad * square;
        let cubic = stage.cubic_stiffness_nm_per_rad3 * square * square;
        let [before, after] = inertia;
        let mobility = 1.0 / before + 1.0 / after;
        let taken = -libm::expm1(-stage.damping_nm_s_per_rad * square * half_step * mobility);
        Self {
            linear: S::from_f64(linear * angle / torque),
            cubic: S::gain(angle * libm::sqrt(cubic * angle / torque)),
            damping: S::gain(stage.damping_nm_s_per_rad * square * speed / torque),
            before: S::gain(taken / (before * mobility)),
            after: S::gain(taken / (after * mobility)),
        }
    }

    /// Elastic torque.
    #[inline(always)]
    pub(crate) fn torque(&self, deflection: S) -> S {
        self.secant(deflection).nearest(deflection)
    }

    /// Elastic torque over deflection.
    #[inline(always)]
    fn secant(&self, deflection: S) -> S {
        let bent = deflection.times(self.cubic);
        self.linear + bent * bent
    }

    /// Whether there is a damper.
    pub(crate) fn is_damped(&self) -> bool {
        self.before != S::Gain::default()
    }

    /// Torque of the damper at a relative speed.
    #[inline(always)]
    pub(crate) fn damping_torque(&self, relative: S) -> S {
        relative.times(self.damping)
    }

    /// Derivative of the elastic torque with the deflection.
    #[inline(always)]
    pub(crate) fn slope(&self, deflection: S) -> S {
        let bent = deflection.times(self.cubic);
        let hardened = bent * bent;
        self.linear + hardened.thrice()
    }

    /// Lets the damper act for half a step on the speeds before and after it, where there is contact.
    #[inline(always)]
    pub(crate) fn damp(&self, before: &mut S, after: &mut S, contact: S) {
        let touching = S::ZERO.below(contact);
        if !S::anywhere(touching) {
            return;
        }
        let relative = S::choose(touching, *before - *after, S::ZERO);
        *before = *before - relative.times(self.before);
        *after = *after + relative.times(self.after);
    }
}

/// Tangent stiffness of a stage's spring under a torque, Nm/rad.
pub(crate) fn tangent(stage: &Stage, torque: f64) -> f64 {
    let x = deflection(stage, torque);
    stage.stiffness_nm_per_rad + 3.0 * stage.cubic_stiffness_nm_per_rad3 * x * x
}

/// Deflection of a stage's spring under a torque, rad at its output.
pub(crate) fn deflection(stage: &Stage, torque: f64) -> f64 {
    let (k1, k3) = (stage.stiffness_nm_per_rad, stage.cubic_stiffness_nm_per_rad3);
    let mut x = torque / k1;
    for _ in 0..20 {
        x -= (k1 * x + k3 * x * x * x - torque) / (k1 + 3.0 * k3 * x * x);
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A gear of 2:1 with all units one: at the motor a spring is a quarter as stiff, a cubic one a
    /// sixteenth.
    fn spring(stage: &Stage) -> Spring<f64> {
        Spring::new(stage, 0.5, 0.25, [1.0; 3], [1.0, 4.0])
    }

    fn stage() -> Stage {
        Stage {
            stiffness_nm_per_rad: 8.0,
            cubic_stiffness_nm_per_rad3: 48.0,
            damping_nm_s_per_rad: 4.0,
            ..Stage::default()
        }
    }

    #[test]
    fn a_spring_gives_equation_1_its_slope_and_its_dampers_torque() {
        let spring = spring(&stage());
        // 2 x + 3 x³ + ẋ; a few roundings of a root.
        for x in [-1.5, -0.2, 0.0, 0.7, 2.0] {
            assert!((spring.torque(x) - (2.0 * x + 3.0 * x * x * x)).abs() < 1e-13, "{x}");
            assert!((spring.slope(x) - (2.0 + 9.0 * x * x)).abs() < 1e-13, "{x}");
            assert_eq!(spring.damping_torque(x), x);
        }
    }

    #[test]
    fn units_scale_a_spring() {
        let spring = Spring::<f64>::new(&stage(), 0.5, 0.25, [10.0, 3.0, 0.1], [1.0, 4.0]);
        let x = 0.8;
        assert!((spring.torque(x) - 0.1 * (2.0 * 0.1 * x + 3.0 * (0.1 * x).powi(3))).abs() < 1e-15);
        assert!((spring.damping_torque(x) - 0.3 * x).abs() < 1e-15);
    }

    /// The relative speed falls by e^(−c h (1/J₁ + 1/J₂)), the momentum stays.
    #[test]
    fn a_damper_decays_the_relative_speed_exactly_and_keeps_the_momentum() {
        let spring = spring(&stage());
        assert!(spring.is_damped());
        let (mut before, mut after) = (3.0, -1.0);
        spring.damp(&mut before, &mut after, 1.0);
        assert!((before - after - 4.0 * (-0.25_f64 * 1.25).exp()).abs() < 1e-14);
        assert!((before + 4.0 * after - (3.0 - 4.0)).abs() < 1e-14);
    }

    #[test]
    fn without_contact_or_damper_nothing_is_damped() {
        let (mut before, mut after) = (3.0, -1.0);
        spring(&stage()).damp(&mut before, &mut after, 0.0);
        assert_eq!((before, after), (3.0, -1.0));
        let undamped = spring(&Stage { damping_nm_s_per_rad: 0.0, ..stage() });
        assert!(!undamped.is_damped());
        undamped.damp(&mut before, &mut after, 1.0);
        assert_eq!((before, after), (3.0, -1.0));
    }

    #[test]
    fn a_torque_deflects_a_spring_by_the_root_of_its_law() {
        for torque in [-30.0, -0.01, 0.0, 2.0, 400.0] {
            let x = deflection(&stage(), torque);
            assert!(
                (8.0 * x + 48.0 * x * x * x - torque).abs() <= 1e-13 * torque.abs(),
                "{torque}"
            );
            assert!((tangent(&stage(), torque) - (8.0 + 144.0 * x * x)).abs() < 1e-12, "{torque}");
        }
    }

    #[test]
    fn thrice_is_three_times_in_every_format() {
        assert_eq!((0.7_f32.thrice(), 0.7_f64.thrice()), (2.1, 0.7 + 0.7 + 0.7));
        assert_eq!(2.0_f64.drifted(0.5, 3.0, 0.25), (2.75, 0.5));
    }
}
