//! What a joint is, in SI units, checked once.
//!
//! These are the numbers of a datasheet or a model file. They are validated here, with an error
//! that names the offender, and then turned once into the per-unit coefficients of
//! [`crate::joint`]; nothing downstream checks again. Field names are the keys of the model file
//! and carry their unit. Ranges are deliberately wide: a value is refused only where the equations
//! of docs/model.md lose their meaning.

mod error;

use core::fmt;

pub(crate) use error::Check;
pub use error::{ParameterError, Reason, Table};

/// LuGre friction on one inertia, equations (2) and (3):
/// `F = σ0 z + σ1 ż + σ2 v`, `ż = v − σ0 |v| z / g(v)`, `g(v) = α0 + α1 exp(−(v/v0)²)`.
///
/// Speeds and torques are those of the inertia itself, not reflected to the motor.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct Friction {
    /// Bristle stiffness σ0, Nm/rad.
    pub sigma0_nm_per_rad: f64,
    /// Bristle damping σ1, Nm s/rad.
    pub sigma1_nm_s_per_rad: f64,
    /// Viscous coefficient σ2, Nm s/rad.
    pub sigma2_nm_s_per_rad: f64,
    /// Coulomb level α0, Nm.
    pub coulomb_nm: f64,
    /// Stribeck excess α1 over the Coulomb level at standstill, Nm.
    pub stribeck_nm: f64,
    /// Stribeck velocity v0, rad/s.
    pub stribeck_velocity_rad_per_s: f64,
}

impl Default for Friction {
    /// No friction: every torque zero, with a Stribeck velocity of 1 rad/s that has no effect.
    fn default() -> Self {
        Self {
            sigma0_nm_per_rad: 0.0,
            sigma1_nm_s_per_rad: 0.0,
            sigma2_nm_s_per_rad: 0.0,
            coulomb_nm: 0.0,
            stribeck_nm: 0.0,
            stribeck_velocity_rad_per_s: 1.0,
        }
    }
}

/// The motor as its DC equivalent, equation (10): two phases in series carry the current.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct Motor {
    /// Resistance R of one phase, ohm. Zero is admitted where the current is the input.
    pub phase_resistance_ohm: f64,
    /// Inductance L of one phase, henry. Zero makes the current follow at once.
    pub phase_inductance_h: f64,
    /// Torque constant k_t, Nm/A, of the two conducting phases together.
    pub torque_constant_nm_per_a: f64,
    /// Back-EMF constant k_e of one phase, V s/rad. Power balance needs k_t = 2 k_e;
    /// left out, it is k_t / 2.
    pub phase_back_emf_constant_v_s_per_rad: Option<f64>,
    /// Pole pairs.
    pub pole_pairs: u32,
    /// Rotor inertia J_m, kg m².
    pub rotor_inertia_kg_m2: f64,
    /// Friction on the rotor.
    pub friction: Friction,
}

impl Default for Motor {
    fn default() -> Self {
        Self {
            phase_resistance_ohm: 0.0,
            phase_inductance_h: 0.0,
            torque_constant_nm_per_a: 0.0,
            phase_back_emf_constant_v_s_per_rad: None,
            pole_pairs: 1,
            rotor_inertia_kg_m2: 0.0,
            friction: Friction::default(),
        }
    }
}

/// One elastic gear stage: a spring with a cubic part, its damping, and the mass behind it.
///
/// The spring's argument is `x = η q_in − q_out` with η = 1/reduction; its torque
/// `T = k1 x + k3 x³ + c ẋ` acts on the output side and `η T` on the input side, equation (1).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct Stage {
    /// Input turns over output turns; negative where the stage reverses.
    pub reduction: f64,
    /// Inertia J_g of the mass behind the spring, kg m². Left out (zero) it is taken as one
    /// hundredth of what lies before it, reflected to this side: a gear without a link.
    pub inertia_kg_m2: f64,
    /// Linear stiffness k1, Nm/rad at the stage's output.
    pub stiffness_nm_per_rad: f64,
    /// Cubic stiffness k3, Nm/rad³ at the stage's output.
    pub cubic_stiffness_nm_per_rad3: f64,
    /// Damping c of the spring, Nm s/rad at the stage's output.
    pub damping_nm_s_per_rad: f64,
    /// Lead angle λ of a worm stage, rad: the mass before the spring is the worm, the one behind it
    /// the wheel. Zero: no worm. See [`crate::worm`].
    pub worm_lead_angle_rad: f64,
    /// Friction coefficient μ of a worm stage's mesh, over the cosine of the pressure angle.
    pub worm_friction_coefficient: f64,
    /// Friction on the mass behind the spring.
    pub friction: Friction,
}

impl Default for Stage {
    fn default() -> Self {
        Self {
            reduction: 1.0,
            inertia_kg_m2: 0.0,
            stiffness_nm_per_rad: 0.0,
            cubic_stiffness_nm_per_rad3: 0.0,
            damping_nm_s_per_rad: 0.0,
            worm_lead_angle_rad: 0.0,
            worm_friction_coefficient: 0.0,
            friction: Friction::default(),
        }
    }
}

/// What hangs on the last mass.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct Load {
    /// Inertia added to the last mass (the rotor where there is no stage), kg m².
    pub inertia_kg_m2: f64,
    /// Amplitude of the gravity torque, Nm: the torque `gravity_nm · sin(q_out + phase)` acts
    /// against motion.
    pub gravity_nm: f64,
    /// Phase of the gravity torque, rad.
    pub gravity_phase_rad: f64,
}

/// Where in the joint something sits. Stages count from 1 at the motor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Location {
    /// The rotor and what acts on it.
    Motor,
    /// A gear stage: its spring, or the mass behind it.
    Stage(u8),
    /// The last mass and the load on it.
    Output,
    /// The voltage path.
    Inverter,
    /// The current measurement.
    CurrentSensor,
    /// The motor encoder.
    Encoder,
    /// The encoder behind the last stage.
    OutputEncoder,
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Location::Motor => f.write_str("motor"),
            Location::Stage(k) => write!(f, "stage{k}"),
            Location::Output => f.write_str("output"),
            Location::Inverter => f.write_str("inverter"),
            Location::CurrentSensor => f.write_str("current-sensor"),
            Location::Encoder => f.write_str("encoder"),
            Location::OutputEncoder => f.write_str("output-encoder"),
        }
    }
}

impl core::str::FromStr for Location {
    type Err = ();

    fn from_str(text: &str) -> Result<Self, ()> {
        Ok(match text {
            "motor" => Location::Motor,
            "output" => Location::Output,
            "inverter" => Location::Inverter,
            "current-sensor" => Location::CurrentSensor,
            "encoder" => Location::Encoder,
            "output-encoder" => Location::OutputEncoder,
            _ => {
                let number = text.strip_prefix("stage").ok_or(())?;
                let k: u8 = number.parse().map_err(|_| ())?;
                if k == 0 || number.starts_with(['0', '+']) {
                    return Err(());
                }
                Location::Stage(k)
            }
        })
    }
}

impl Friction {
    /// Largest static level α0 + α1, Nm.
    pub fn breakaway_nm(&self) -> f64 {
        self.coulomb_nm + self.stribeck_nm
    }

    fn validate(&self, check: Check) -> Result<(), ParameterError> {
        check.not_negative("sigma0_nm_per_rad", self.sigma0_nm_per_rad)?;
        check.not_negative("sigma1_nm_s_per_rad", self.sigma1_nm_s_per_rad)?;
        check.not_negative("sigma2_nm_s_per_rad", self.sigma2_nm_s_per_rad)?;
        check.not_negative("coulomb_nm", self.coulomb_nm)?;
        check.finite("stribeck_nm", self.stribeck_nm)?;
        if self.breakaway_nm() < 0.0 {
            return Err(check.fail("stribeck_nm", self.stribeck_nm, Reason::Negative));
        }
        check.positive("stribeck_velocity_rad_per_s", self.stribeck_velocity_rad_per_s)?;
        if self.sigma0_nm_per_rad > 0.0 {
            check.positive("coulomb_nm", self.coulomb_nm)?;
        } else if self.coulomb_nm > 0.0 {
            check.positive("sigma0_nm_per_rad", self.sigma0_nm_per_rad)?;
        }
        Ok(())
    }
}

impl Motor {
    /// Back-EMF constant of one phase, V s/rad: the one given, or k_t / 2.
    pub fn back_emf_constant(&self) -> f64 {
        self.phase_back_emf_constant_v_s_per_rad.unwrap_or(self.torque_constant_nm_per_a / 2.0)
    }

    fn validate(&self) -> Result<(), ParameterError> {
        let check = Check(Table::Motor);
        check.not_negative("phase_resistance_ohm", self.phase_resistance_ohm)?;
        check.not_negative("phase_inductance_h", self.phase_inductance_h)?;
        check.positive("torque_constant_nm_per_a", self.torque_constant_nm_per_a)?;
        if let Some(value) = self.phase_back_emf_constant_v_s_per_rad {
            let key = "phase_back_emf_constant_v_s_per_rad";
            check.positive(key, value)?;
            let expected = self.torque_constant_nm_per_a / 2.0;
            if (value - expected).abs() > 0.01 * expected {
                return Err(check.fail(key, value, Reason::PowerBalance { expected }));
            }
        }
        if self.pole_pairs == 0 {
            return Err(check.fail("pole_pairs", 0.0, Reason::NotPositive));
        }
        check.positive("rotor_inertia_kg_m2", self.rotor_inertia_kg_m2)?;
        self.friction.validate(Check(Table::MotorFriction))
    }
}

impl Stage {
    fn validate(&self, number: usize) -> Result<(), ParameterError> {
        let check = Check(Table::Stage(number));
        check.finite("reduction", self.reduction)?;
        if self.reduction == 0.0 {
            return Err(check.fail("reduction", 0.0, Reason::Zero));
        }
        check.not_negative("inertia_kg_m2", self.inertia_kg_m2)?;
        check.positive("stiffness_nm_per_rad", self.stiffness_nm_per_rad)?;
        check.not_negative("cubic_stiffness_nm_per_rad3", self.cubic_stiffness_nm_per_rad3)?;
        check.not_negative("damping_nm_s_per_rad", self.damping_nm_s_per_rad)?;
        self.validate_worm(check)?;
        self.friction.validate(Check(Table::StageFriction(number)))
    }
}

impl Stage {
    /// Whether this is a worm stage.
    pub fn is_worm(&self) -> bool {
        self.worm_lead_angle_rad > 0.0
    }

    fn validate_worm(&self, check: Check) -> Result<(), ParameterError> {
        check.not_negative("worm_lead_angle_rad", self.worm_lead_angle_rad)?;
        let key = "worm_friction_coefficient";
        check.not_negative(key, self.worm_friction_coefficient)?;
        if !self.is_worm() {
            if self.worm_friction_coefficient > 0.0 {
                // Without a lead angle it would be ignored.
                check.positive("worm_lead_angle_rad", self.worm_lead_angle_rad)?;
            }
            return Ok(());
        }
        // At a quarter turn less the friction angle even the worm cannot drive.
        let most = core::f64::consts::FRAC_PI_2 - libm::atan(self.worm_friction_coefficient) - 0.01;
        if self.worm_lead_angle_rad > most {
            let reason = Reason::OutOfRange { low: 0.0, high: most };
            return Err(check.fail("worm_lead_angle_rad", self.worm_lead_angle_rad, reason));
        }
        Ok(())
    }
}

impl Load {
    fn validate(&self) -> Result<(), ParameterError> {
        let check = Check(Table::Load);
        check.not_negative("inertia_kg_m2", self.inertia_kg_m2)?;
        check.finite("gravity_nm", self.gravity_nm)?;
        check.finite("gravity_phase_rad", self.gravity_phase_rad)
    }
}

/// Checks what a joint needs beside its parameters: a resistance where the voltage is the input,
/// and a step.
pub(crate) fn validate_drive(
    motor: &Motor,
    voltage: bool,
    step_s: f64,
) -> Result<(), ParameterError> {
    let check = Check(Table::Motor);
    if voltage {
        check.positive("phase_resistance_ohm", motor.phase_resistance_ohm)?;
    }
    check.positive("step_s", step_s)
}

/// Gravity in a joint that has no laws beside the plain equations.
pub(crate) fn gravity_without_effects(load: &Load) -> ParameterError {
    Check(Table::Load).fail("gravity_nm", load.gravity_nm, Reason::NeedsEffectSet)
}

/// A worm stage in a joint that has no laws beside the plain equations.
pub(crate) fn worm_without_effects(stages: &[Stage]) -> Option<ParameterError> {
    let number = stages.iter().position(Stage::is_worm)? + 1;
    let lead = stages.get(number - 1).map_or(0.0, |stage| stage.worm_lead_angle_rad);
    Some(Check(Table::Stage(number)).fail("worm_lead_angle_rad", lead, Reason::NeedsEffectSet))
}

/// An effect that the joint has no place for, though validation let it pass.
pub(crate) fn unplaced_effect(number: usize) -> ParameterError {
    Check(Table::Effect(number)).fail("location", 0.0, Reason::NoSuchPlace)
}

/// Checks a joint of any number of stages.
///
/// # Errors
/// The first value that the equations cannot take.
pub fn validate(motor: &Motor, stages: &[Stage], load: &Load) -> Result<(), ParameterError> {
    motor.validate()?;
    for (k, stage) in stages.iter().enumerate() {
        stage.validate(k + 1)?;
    }
    for (k, stage) in stages.iter().enumerate() {
        if stage.is_worm() {
            // The mesh's friction is a level of the worm's own.
            let (friction, table) = match k.checked_sub(1).and_then(|k| stages.get(k)) {
                Some(worm) => (&worm.friction, Table::StageFriction(k)),
                None => (&motor.friction, Table::MotorFriction),
            };
            Check(table).positive("coulomb_nm", friction.coulomb_nm)?;
        }
    }
    load.validate()
}
