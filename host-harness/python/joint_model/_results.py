"""Results as objects with types; ``raw`` is the object that `joint` writes, with all that it holds."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import _plot
from ._log import Table
from ._native import Model

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure


def _known(kind: type[Any], raw: dict[str, Any]) -> Any:
    """The fields that are known; results may have more."""
    return kind(**{name: raw[name] for name in kind.__dataclass_fields__})


@dataclass(frozen=True)
class Rival:
    """Another name that was considered for an effect."""

    kind: str
    location: str
    confidence: float


@dataclass(frozen=True)
class Effect:
    """An effect that the nominal model lacks."""

    kind: str
    location: str
    parameters: dict[str, float]
    """In SI units, by the keys of model files."""
    standard_errors: dict[str, float]
    """One standard error of those that were fitted."""
    confidence: float
    """Probability that the name is right."""
    share: float
    """Part of what the refitted nominal misses on unseen samples, 0 to 1."""
    share_error: float
    borne_out: float | None
    """How much of what it changes of the prediction errors unseen samples bear out, given all other effects: 1 where it
    is what the fit says. None where they were not asked."""
    borne_out_error: float | None
    transfer_t: float | None
    """Gain on the records of ``transfer`` over its standard error, given all other effects; None without any,
    and for what is only possible."""
    rivals: list[Rival]

    @classmethod
    def _of(cls, raw: dict[str, Any]) -> Effect:
        rivals = [Rival(own["kind"], own["location"], own["confidence"]) for own in raw["rivals"]]
        own = ("kind", "location", "parameters", "standard_errors", "confidence", "share", "share_error")
        told = ("borne_out", "borne_out_error", "transfer_t")
        return cls(**{name: raw[name] for name in own}, **{name: raw.get(name) for name in told}, rivals=rivals)


@dataclass(frozen=True)
class Where:
    """Where the refitted nominal and the log disagree."""

    equation: str
    varies_with: str
    orders: list[float]
    explained: float


@dataclass(frozen=True)
class Gap:
    """How far predictions miss on samples that no fit has seen, in sigmas of the noise."""

    before: float
    after: float
    floor: float
    unit: str
    signals: dict[str, list[float]]
    """Before, after and floor by column of the log."""


@dataclass(frozen=True)
class Budget:
    """Where what the refitted nominal misses goes: shares that add up to one."""

    named: float
    unnamed: float
    coloured: float
    white: float
    unit: str
    rms_before: float


@dataclass(frozen=True)
class Parameter:
    """A parameter before and after a refit."""

    key: str
    nominal: float
    value: float
    standard_error: float
    determined: bool
    """Whether the log tells it; if not, it is assumed."""


@dataclass(frozen=True)
class Finding:
    """What the check of a model against a log found."""

    check: str
    severity: str
    """error, warning or note"""
    message: str
    help: str
    row: int | None


@dataclass(frozen=True)
class Check:
    """Whether a model and a log speak of the same joint."""

    findings: list[Finding]
    excitation: dict[str, Any]

    @property
    def passed(self) -> bool:
        """Whether no finding is an error."""
        return all(finding.severity != "error" for finding in self.findings)

    def to_pandas(self) -> pandas.DataFrame:
        """One row for every finding; needs pandas."""
        import pandas

        return pandas.DataFrame([vars(finding) for finding in self.findings])


@dataclass(frozen=True)
class _Reported:
    model: Model
    """The refitted model, with the effects that were found."""
    report_html: str = field(repr=False)
    """The page that `joint` writes; opens without a network."""
    raw: dict[str, Any] = field(repr=False)

    def save_report(self, path: str | os.PathLike[str]) -> None:
        """Writes the page."""
        Path(path).write_text(self.report_html, encoding="utf-8")


@dataclass(frozen=True)
class Discovery(_Reported):
    """What a model misses in logs of its joint."""

    residuals: Table = field(repr=False)
    """Prediction errors by sample, before and after, and the disturbance that they ask for."""

    @property
    def verdict(self) -> str:
        """effect, adequate, unknown or undecided"""
        return self.raw["verdict"]

    @property
    def effects(self) -> list[Effect]:
        """What was found and added to the model, the most certain first."""
        return [Effect._of(own) for own in self.raw["effects"]]

    @property
    def possible(self) -> list[Effect]:
        """What explains something, but not beyond doubt; it is not in the model."""
        return [Effect._of(own) for own in self.raw["possible"]]

    @property
    def where(self) -> Where:
        """Where the refitted nominal and the log disagree."""
        return _known(Where, self.raw["where"])

    @property
    def gap(self) -> Gap:
        """How far predictions miss."""
        return _known(Gap, self.raw["gap"])

    @property
    def budget(self) -> Budget | None:
        """Where what the refitted nominal misses goes."""
        budget = self.raw["budget"]
        return None if budget is None else _known(Budget, budget)

    @property
    def next_experiment(self) -> str:
        """What to measure next."""
        return self.raw["next_experiment"]

    @property
    def reasons(self) -> list[str]:
        """Why the answer is what it is."""
        return self.raw["reasons"]

    @property
    def seconds(self) -> float:
        """Wall time."""
        return self.raw["seconds"]

    def __str__(self) -> str:
        lines = [self.verdict]
        for effect in self.effects:
            share = f"{100 * effect.share:.0f} ± {100 * effect.share_error:.0f} % of the gap"
            t = effect.transfer_t
            elsewhere = "" if t is None else f", t {t:.1f} on other records"
            lines.append(
                f"  {effect.kind} ({effect.location}), confidence {effect.confidence:.2f}, {share}{elsewhere}"
            )
        lines += [f"  possible: {own.kind} ({own.location})" for own in self.possible]
        lines += [f"  - {reason}" for reason in self.reasons]
        return "\n".join([*lines, f"next: {self.next_experiment}"])

    def to_pandas(self) -> pandas.DataFrame:
        """One row for every effect, those that are only possible behind; needs pandas."""
        import pandas

        rows = []
        for added, effects in ((True, self.effects), (False, self.possible)):
            for effect in effects:
                row = dict(vars(effect))
                row["rivals"] = [f"{own.kind} ({own.location})" for own in effect.rivals]
                rows.append({**row, "added": added})
        columns = [*Effect.__dataclass_fields__, "added"]
        return pandas.DataFrame(rows, columns=columns)

    def plot(self) -> Figure:
        """Prediction errors by sample, before and after; needs matplotlib."""
        return _plot.residuals(self.residuals)


@dataclass(frozen=True)
class Identification(_Reported):
    """A model refitted to a log."""

    @property
    def parameters(self) -> list[Parameter]:
        """Every parameter that was refitted."""
        return [_known(Parameter, {"key": key, **own}) for key, own in self.raw["parameters"].items()]

    @property
    def noise(self) -> dict[str, Any]:
        """Noises as the log shows them."""
        return self.raw["noise"]

    def to_pandas(self) -> pandas.DataFrame:
        """One row for every parameter; needs pandas."""
        import pandas

        return pandas.DataFrame([vars(own) for own in self.parameters]).set_index("key")

    def plot(self) -> Figure:
        """Every parameter over its nominal, with one standard error; needs matplotlib."""
        return _plot.parameters(self.parameters)


class Simulation(Table):
    """The columns of the log, simulated current and angles for the measured ones, and every state."""

    def plot(self) -> Figure:
        """Input, angles, speeds and wind-up over time; needs matplotlib."""
        return _plot.columns(self)


class Observation(Table):
    """What the observer on a drive makes of a log, with one standard deviation by column ``*_std``."""

    def __init__(self, columns: Mapping[str, Any], status: list[str]) -> None:
        super().__init__(columns)
        self.status = status
        """By sample: ok, or what is special, joined by +."""

    def to_pandas(self) -> pandas.DataFrame:
        """A data frame of the columns and the status; needs pandas."""
        return super().to_pandas().assign(status=self.status)

    def plot(self) -> Figure:
        """Every estimate over time with its band of two standard deviations; needs matplotlib."""
        return _plot.columns(self)
