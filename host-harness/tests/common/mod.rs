//! What several of these tests begin with.

/// A motor with one gear.
pub(crate) const MODEL: &str = "[motor]
phase_resistance_ohm = 0.5
phase_inductance_h = 1e-4
torque_constant_nm_per_a = 0.1
rotor_inertia_kg_m2 = 1e-5
[motor.friction]
sigma0_nm_per_rad = 10
sigma1_nm_s_per_rad = 0.01
coulomb_nm = 0.01
[[stage]]
reduction = 10
inertia_kg_m2 = 1e-3
stiffness_nm_per_rad = 300
";
