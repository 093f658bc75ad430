"""Validates an FMU of FMI 2.0 or 3.0 by FMPy and runs it on a log's inputs; writes its outputs at the log's times.

    python fmpy_run.py joint.fmu log.csv out.csv

Half way the state is serialised, the run goes on, and is then repeated from the bytes: both halves must be
the same to the bit. A library of FMI 3.0 must have every function that the standard's header declares.
"""

import csv
import re
import sys
from pathlib import Path

import fmpy
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave
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
is_third = description.fmiVersion.startswith("3.")
unit = (FMU3Slave if is_third else FMU2Slave)(
    guid=description.guid,
    unzipDirectory=unpacked,
    modelIdentifier=description.coSimulation.modelIdentifier,
    instanceName="joint",
)
unit.instantiate()
start = rows[0]["t_s"]
if is_third:
    header = Path(fmpy.__file__).parent / "c-code" / "fmi3Functions.h"
    declared = re.findall(r"FMI3_Export \w+TYPE +(\w+);", header.read_text(encoding="utf-8"))
    missing = [name for name in declared if not hasattr(unit.dll, name)]
    if missing or len(declared) < 70:
        sys.exit(f"{len(declared)} functions, missing: {missing}")
    unit.enterInitializationMode(startTime=start, stopTime=start + interval * len(rows))
    get, put = unit.getFloat64, unit.setFloat64
else:
    unit.setupExperiment(startTime=start)
    unit.enterInitializationMode()
    get, put = unit.getReal, unit.setReal
unit.exitInitializationMode()


def run(some):
    found = []
    for row in some:
        found.append(get([references[name] for name in outputs]))
        inputs = [references["voltage_v"], references["load_torque_nm"]]
        put(inputs, [row["u_v"], row["load_torque_nm"]])
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
