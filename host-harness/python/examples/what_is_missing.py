# %% [markdown]
# # What does my model miss?
#
# A joint is made here, so that the truth is known: a small 9:1 actuator with cogging that its nominal model
# lacks. In your own work the log comes from a drive, by `joint import`, and the model from a datasheet, by
# `joint new`.

# %%
import math
import random

import joint_model as jm

NOMINAL = """
name = "arm"
[motor]
phase_resistance_ohm = 0.42
phase_inductance_h = 0.21e-3
torque_constant_nm_per_a = 0.085
pole_pairs = 7
rotor_inertia_kg_m2 = 4.1e-5
[motor.friction]
sigma0_nm_per_rad = 14.0
sigma1_nm_s_per_rad = 0.012
sigma2_nm_s_per_rad = 9e-5
coulomb_nm = 0.014
stribeck_nm = 0.006
stribeck_velocity_rad_per_s = 3.0
[[stage]]
reduction = 9.0
inertia_kg_m2 = 0.0042
stiffness_nm_per_rad = 260.0
damping_nm_s_per_rad = 0.04
[load]
inertia_kg_m2 = 0.004
[sensor]
sample_time_s = 0.0002
motor_encoder_counts_per_rev = 16384
output_encoder_counts_per_rev = 65536
current_noise_a = 0.02
"""
HIDDEN = """
[[effect]]
kind = "cogging"
location = "motor"
order = 14
amplitude_nm = 0.008
phase_rad = 0.5
"""
nominal = jm.Model.from_toml(NOMINAL)
truth = jm.Model.from_toml(NOMINAL + HIDDEN)

# %% [markdown]
# ## A log
# Slow and fast motion with reversals; encoders with counts, a current with noise.

# %%
STEP_S, SAMPLES = 2e-4, 10_000
time = [STEP_S * k for k in range(SAMPLES)]
voltage = [
    3.0 * math.sin(2 * math.pi * 0.9 * t) + 2.0 * math.sin(2 * math.pi * (2 + 6 * t) * t)
    for t in time
]
still = [0.0] * SAMPLES
drive = {"t_s": time, "u_v": voltage, "i_a": still, "motor_angle_rad": still, "output_angle_rad": still}
run = jm.simulate(drive, truth, from_rest=True)

noise = random.Random(7)


def counted(angles, counts):
    return [math.floor(angle / (2 * math.pi) * counts) * 2 * math.pi / counts for angle in angles]


log = {
    "t_s": time,
    "u_v": voltage,
    "i_a": [current + noise.gauss(0, 0.02) for current in run["i_a"]],
    "motor_angle_rad": counted(run["motor_angle_rad"], 16384),
    "output_angle_rad": counted(run["output_angle_rad"], 65536),
}

# %% [markdown]
# ## Do model and log speak of the same joint?

# %%
checked = jm.check(log, nominal)
print("passed" if checked.passed else checked.findings)

# %% [markdown]
# ## What is missing

# %%
found = jm.discover(log, nominal)
print(found)

# %% [markdown]
# ## The improved model, and what an observer would make of the log

# %%
seen = jm.observe(log, found.model)
print(found.model)
print(f"load torque at the end: {seen['load_torque_nm'][-1]:.4f} ± {seen['load_torque_nm_std'][-1]:.4f} Nm")
