//! A viscous torque that saturates: T = T_L tanh(σ2 v / T_L).
//!
//! A lubricant bears no more than a limiting shear stress, so that the torque of a fast joint stops
//! growing; T_L in Nm. At small speeds it is σ2 v. Source: Gecim and Winer, "Lubricant limiting
//! shear stress effect on EHD film thickness", J. Lubrication Technology 102 (1980).

/// The torque, Nm: `viscous` is σ2 v, `limit` T_L, none where it is zero.
#[inline]
pub fn torque(viscous: f64, limit: f64) -> f64 {
    if limit > 0.0 { limit * (viscous / limit).tanh() } else { viscous }
}
