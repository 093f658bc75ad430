"""Validates an FMU by FMPy and runs it on a log's inputs; writes its outputs at the log's times.

    python fmpy_run.py joint.fmu log.csv out.csv

Half way the state is serialised, the run goes on, and is then repeated from the bytes: both halves must be
the same to the bit.
"""

import csv
import sys

import fmpy
from fmpy.fmi2 import FMU2Slave
from fmpy.validation import validate_fmu

problems = validate_fmu(sys.argv[1])
if problems:
    sys.exit("\n".join(problems))
description = fmpy.read_model_description(sys.argv[1])
references = {variable.name: variable.valueReference for variable in description.modelVariables}
outputs = [variable.name for variable in description.modelVariables if variable.causality == "output"]
with open(sys.argv[2], encoding="utf-8") as file:
    rows = [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]
interval = rows[1]["t_s"] - rows[0]["t_s"]
unpacked = fmpy.extract(sys.argv[1])
unit = FMU2Slave(
    guid=description.guid,
    unzipDirectory=unpacked,
    modelIdentifier=description.coSimulation.modelIdentifier,
    instanceName="joint",
)
unit.instantiate()
unit.setupExperiment(startTime=rows[0]["t_s"])
unit.enterInitializationMode()
unit.exitInitializationMode()


def run(some):
    found = []
    for row in some:
        found.append(unit.getReal([references[name] for name in outputs]))
        inputs = [references["voltage_v"], references["load_torque_nm"]]
        unit.setReal(inputs, [row["u_v"], row["load_torque_nm"]])
        unit.doStep(currentCommunicationPoint=row["t_s"], communicationStepSize=interval)
    return found


half = len(rows) // 2
found = run(rows[:half])
state = unit.getFMUState()
kept = unit.serializeFMUState(state)
unit.freeFMUState(state)
rest = run(rows[half:])
again = unit.deserializeFMUState(kept)
unit.setFMUState(again)
if run(rows[half:]) != rest:
    sys.exit("the run from the serialised state is another one")
unit.freeFMUState(again)
unit.terminate()
unit.freeInstance()
with open(sys.argv[3], "w", encoding="utf-8") as file:
    print("t_s", *outputs, sep=",", file=file)
    for row, values in zip(rows, found + rest):
        print(repr(row["t_s"]), *map(repr, values), sep=",", file=file)
