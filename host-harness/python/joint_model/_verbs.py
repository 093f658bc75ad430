"""What `joint` does, on logs and models in memory."""

from __future__ import annotations

import json
import warnings
from collections.abc import Iterable
from typing import Union

from . import _native
from ._log import Log, Table, native
from ._native import Model
from ._results import Check, Discovery, Finding, Identification, Observation, Simulation

Logs = Union[Log, list[Log], tuple[Log, ...]]
"""One log, or several."""


def _read(log: Log, level: int = 4) -> _native.Log:
    own = native(log)
    _warn(own.warnings, level)
    return own


def _all(logs: Logs) -> list[_native.Log]:
    # No comprehension: before Python 3.12 it is a frame of its own.
    own = []
    for log in logs if isinstance(logs, (list, tuple)) else [logs]:
        own.append(_read(log, level=5))
    return own


def _warn(texts: Iterable[str], level: int = 3) -> None:
    """At the line that called a verb, which is so many frames up."""
    for text in texts:
        warnings.warn(text, stacklevel=level)


def check(log: Log, model: Model) -> Check:
    """Whether a model and a log speak of the same joint, in the same units; without a fit.

    Raises JointError where the log itself cannot be read.
    """
    raw = json.loads(_native.check(model, _read(log)))
    names = ("check", "severity", "message", "help", "row")
    findings = [Finding(**{name: own.get(name) for name in names}) for own in raw["findings"]]
    return Check(findings, raw["excitation"])


def discover(
    log: Logs,
    model: Model,
    *,
    transfer: Logs = (),
    without: Iterable[str] = (),
    anyway: bool = False,
) -> Discovery:
    """Finds, names and adds what a model misses in a log, or in several of the same joint.

    ``transfer`` are other records of the joint, to which nothing is fitted but the level of friction and the noise:
    effects that they speak against are only possible, and ``transfer_t`` of those that stay tells by how much.
    ``without`` are kinds of effects that are not considered. ``anyway`` goes on where log and model cannot
    both be right. Raises JointError for bad input, KeyboardInterrupt for Ctrl-C.
    """
    verdict, improved, residuals, report, told = _native.discover(
        model, (_all(log), _all(transfer)), list(without), anyway
    )
    _warn(told)
    return Discovery(improved, report, json.loads(verdict), Table(dict(residuals)))


def identify(log: Log, model: Model, *, anyway: bool = False) -> Identification:
    """Refits a model to a log, with standard errors and what the log cannot determine.

    Raises JointError for bad input, KeyboardInterrupt for Ctrl-C.
    """
    raw, refitted, report, told = _native.identify(model, _read(log), anyway)
    _warn(told)
    return Identification(refitted, report, json.loads(raw))


def simulate(
    log: Log,
    model: Model,
    *,
    method: str = "embedded",
    scalar: str = "f64",
    step_us: float | None = None,
    from_rest: bool = False,
) -> Simulation:
    """Runs a model on a log's inputs, from the log's first state, or from rest.

    ``method`` is embedded (the step of the drive) or reference; ``scalar`` is f64, f32 or fixed. A column
    ``motor_angle_rad`` of zeros is enough where there is no measurement. Raises JointError for bad input.
    """
    columns, notes = _native.simulate(model, _read(log), method, scalar, step_us, from_rest)
    _warn(notes)
    return Simulation(dict(columns))


def observe(
    log: Log, model: Model, *, scalar: str = "f32", rated_load_nm: float | None = None
) -> Observation:
    """Runs the observer of a drive over a log: friction, wind-up, load torque, and how sure it is.

    ``rated_load_nm`` is the largest load expected at the output; without it, the log's voltages tell one.
    """
    columns, status = _native.observe(model, _read(log), scalar, rated_load_nm)
    return Observation(dict(columns), status)
