"""Plots by matplotlib, which is imported where one is asked for."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ._log import Table

# A column's quantity by the end of its name, in the order in which they are drawn.
_UNITS = {
    "_v": "V",
    "_a": "A",
    "_rad": "rad",
    "_rad_per_s": "rad/s",
    "_nm": "Nm",
}


def _unit(name: str) -> str | None:
    ends = [end for end in _UNITS if name.endswith(end)]
    return _UNITS[max(ends, key=len)] if ends else None


def _figure(rows: int) -> tuple[Figure, Sequence[Any]]:
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(
        rows, 1, sharex=True, squeeze=False, layout="constrained", figsize=(8, 1 + 1.9 * rows)
    )
    return figure, list(axes[:, 0])


def columns(table: Table) -> Figure:
    """Columns of one quantity together, each with a band of two standard deviations where it has one."""
    import numpy

    time = numpy.asarray(table["t_s"])
    groups: dict[str, list[str]] = {}
    for name in table:
        unit = _unit(name)
        if unit is not None and name != "t_s":
            # Angles of a rotor and wind-up behind a gear differ by orders of magnitude.
            key = f"wind-up, {unit}" if "windup" in name else unit
            groups.setdefault(key, []).append(name)
    figure, axes = _figure(len(groups))
    for axis, (label, names) in zip(axes, groups.items()):
        for name in names:
            values = numpy.asarray(table[name])
            (line,) = axis.plot(time, values, linewidth=0.9, label=name)
            if f"{name}_std" in table:
                band = 2 * numpy.asarray(table[f"{name}_std"])
                axis.fill_between(time, values - band, values + band, alpha=0.2, color=line.get_color())
        axis.set_ylabel(label)
        axis.legend(fontsize="x-small", loc="upper right")
    axes[-1].set_xlabel("time, s")
    return figure


def residuals(table: Table) -> Figure:
    """Prediction errors before and after, a row for every channel; unseen samples are shaded."""
    import numpy

    time = numpy.asarray(table["t_s"])
    channels = [name.removesuffix("_before_sigma") for name in table if name.endswith("_before_sigma")]
    figure, axes = _figure(max(len(channels), 1))
    for axis, channel in zip(axes, channels):
        for when in ("before", "after"):
            axis.plot(time, table[f"{channel}_{when}_sigma"], linewidth=0.7, label=when)
        axis.fill_between(
            time, 0, 1, where=numpy.asarray(table["held_out"]) > 0, alpha=0.1, color="gray",
            transform=axis.get_xaxis_transform(), label="no fit has seen",
        )
        axis.set_ylabel(f"{channel}\nnoise sigmas")
        axis.legend(fontsize="x-small", loc="upper right")
    axes[-1].set_xlabel("time, s")
    return figure


def parameters(rows: Sequence[Any]) -> Figure:
    """Parameters over their nominal values; those that the log does not tell are hollow."""
    from matplotlib import pyplot

    shown = [row for row in rows if row.nominal != 0]
    figure, axis = pyplot.subplots(layout="constrained", figsize=(8, 1 + 0.25 * len(shown)))
    for place, row in enumerate(reversed(shown)):
        error = abs(row.standard_error / row.nominal) if row.determined else None
        axis.errorbar(
            row.value / row.nominal, place, xerr=error, fmt="o", color="C0",
            markerfacecolor="C0" if row.determined else "none",
        )
    axis.axvline(1, color="gray", linewidth=0.8)
    axis.set_yticks(range(len(shown)), [row.key for row in reversed(shown)], fontsize="small")
    axis.set_xlabel("refitted over nominal")
    return figure
