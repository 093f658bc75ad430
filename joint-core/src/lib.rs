#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]
#![cfg_attr(
    not(test),
    deny(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::indexing_slicing,
        clippy::unreachable
    )
)]
//! A motor joint that runs inside the drive.
//!
//! Brushless motor as its DC equivalent, a chain of elastic gear stages, LuGre friction on every
//! inertia, and effects that a plain model misses; one step, generic over the number, that holds
//! the paper's accuracy at a drive's sample time. Equation numbers in these docs are those of "The
//! joint vibration analysis of a multi-link surgical manipulator"; docs/model.md has them with
//! their corrections, signs and units.
//!
//! Parameters in SI ([`params`]) are validated once and built into per-unit coefficients
//! ([`joint::Joint`]); the joint then steps any number of [`joint::State`]s. No allocation, no
//! panic, and an operation count that does not depend on the data.
//!
//! ```
//! use joint_core::joint::{Drive, Joint, Settings};
//! use joint_core::params::{Friction, Load, Motor};
//!
//! let motor = Motor {
//!     phase_resistance_ohm: 2.8,
//!     phase_inductance_h: 0.8e-3,
//!     torque_constant_nm_per_a: 0.11,
//!     rotor_inertia_kg_m2: 1.1e-4,
//!     friction: Friction {
//!         sigma0_nm_per_rad: 15.0,
//!         sigma1_nm_s_per_rad: 0.02,
//!         coulomb_nm: 0.006,
//!         ..Friction::default()
//!     },
//!     ..Motor::default()
//! };
//! let settings = Settings::new(Drive::Voltage, 50e-6);
//! let joint = Joint::<f32, 0>::new(&motor, &[], &Load::default(), &settings)?;
//! let mut state = joint.rest();
//! for _ in 0..2000 {
//!     joint.step(&mut state, joint.input(1.0, 0.0));
//! }
//! let speed = joint.speed(&state, 0);
//! assert!(speed > 5.0 && speed < 9.1); // below 1 V / k_t: friction takes some
//! # Ok::<(), joint_core::params::ParameterError>(())
//! ```

pub mod angle;
pub mod batch;
pub mod effect;
pub mod fixed;
pub mod friction;
pub mod gear;
pub mod joint;
pub mod lookup;
pub mod motor;
pub mod number;
pub mod observer;
pub mod pace;
pub mod params;
pub mod per_unit;
pub mod range;
pub mod scalar;
pub mod settings;
pub mod six_step;
mod state;
mod step;
pub mod telemetry;
pub mod work;
