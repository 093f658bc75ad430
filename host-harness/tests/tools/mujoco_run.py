"""Runs an exported MuJoCo model on a log's inputs; writes what its sensors show at the log's times.

    python mujoco_run.py joint.xml log.csv out.csv
"""

import csv
import math
import sys

import mujoco

model = mujoco.MjModel.from_xml_path(sys.argv[1])
data = mujoco.MjData(model)
columns = [model.sensor(k).name for k in range(model.nsensor)]
with open(sys.argv[2], encoding="utf-8") as file:
    rows = [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]
interval = rows[1]["t_s"] - rows[0]["t_s"]
steps = math.ceil(interval / model.opt.timestep - 1e-9)
model.opt.timestep = interval / steps
drive, load = model.actuator("voltage_v"), model.actuator("load_torque")
# Actuators of friction take no control.
inputs = [model.actuator_ctrladr[own.id] for own in (drive, load)]
# Of the motor's own states the current comes last.
current = model.actuator_actadr[drive.id] + model.actuator_actnum[drive.id] - 1
mujoco.mj_forward(model, data)
with open(sys.argv[3], "w", encoding="utf-8") as file:
    print("t_s", *columns, "current_a", sep=",", file=file)
    for row in rows:
        sensors = [repr(float(data.sensor(name).data[0])) for name in columns]
        print(repr(row["t_s"]), *sensors, repr(float(data.act[current])), sep=",", file=file)
        data.ctrl[inputs[0]], data.ctrl[inputs[1]] = row["u_v"], row["load_torque_nm"]
        for _ in range(steps):
            mujoco.mj_step(model, data)
