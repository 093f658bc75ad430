"""What the model of a motor joint misses in a log, and the model and its observer to run.

    import joint_model as jm

    nominal = jm.Model.read("nominal.toml")
    found = jm.discover("log.csv", nominal)      # or a data frame, or a dict of columns
    print(found)
    found.to_pandas()                            # one row for every effect
    jm.simulate("log.csv", found.model).plot()

A log is a path, a data frame or a mapping of columns; their names, units and signs are those of a log file:
``t_s``, ``u_v``, ``i_a``, ``motor_angle_rad``, ``output_angle_rad``, ``load_torque_nm`` and more. pandas and
matplotlib are used where they are installed and asked for. Ctrl-C ends a search; other threads run meanwhile.
"""

from ._native import JointError, Model, __version__
from ._log import Log, Table
from ._results import (
    Budget,
    Check,
    Discovery,
    Effect,
    Finding,
    Gap,
    Identification,
    Observation,
    Parameter,
    Rival,
    Simulation,
    Where,
)
from ._verbs import check, discover, identify, observe, simulate

__all__ = [
    "Budget",
    "Check",
    "Discovery",
    "Effect",
    "Finding",
    "Gap",
    "Identification",
    "JointError",
    "Log",
    "Model",
    "Observation",
    "Parameter",
    "Rival",
    "Simulation",
    "Table",
    "Where",
    "__version__",
    "check",
    "discover",
    "identify",
    "observe",
    "simulate",
]
