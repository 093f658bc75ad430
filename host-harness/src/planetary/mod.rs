//! The full model of a planetary stage, of which equation (1) is the reduction.
//!
//! After Eritenel and Parker, "Modal properties of three-dimensional helical planetary gears" (2009):
//! sun, ring, carrier and p planets, each with three translations and three rotations, 6 (3 + p)
//! degrees of freedom, 42 at p = 4. Every elastic part is a spring along one direction between two
//! bodies, so the stiffness is a sum of `k b bᵀ`. Host only: the drive runs the reduction. Friction
//! and gyroscopic terms are left out, as in the paper's citation; planets are spaced evenly.

mod gear;
mod modes;
mod reduction;

pub use gear::{Body, Gear, Stiffness};
pub use modes::{Mode, ModeKind, modes};
pub use reduction::{Reduction, Soft, reduction};
