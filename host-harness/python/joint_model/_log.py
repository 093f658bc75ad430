"""Columns: what a log is given as, and what results are made of."""

from __future__ import annotations

import os
from array import array
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Union

from . import _native

if TYPE_CHECKING:
    import pandas


def _bytes(name: str, values: Any) -> bytes:
    """The values as the bytes of f64; None and a missing value of pandas are no number."""
    if hasattr(values, "to_numpy"):
        values = values.to_numpy(dtype="float64", na_value=float("nan"))
    if hasattr(values, "__array__"):
        import numpy

        values = numpy.ascontiguousarray(values, dtype="float64")
        if values.ndim != 1:
            raise _native.JointError(f"column {name}: has {values.ndim} dimensions, not one")
        return values.tobytes()
    try:
        return array("d", (float("nan") if value is None else value for value in values)).tobytes()
    except TypeError as error:
        raise _native.JointError(f"column {name}: is no column of numbers: {error}") from error


def _is_numeric(values: Any) -> bool:
    kind = getattr(getattr(values, "dtype", None), "kind", "f")
    return kind in "fiub"


class Table(Mapping[str, "array[float]"]):
    """Named columns of equal length, in their order.

    ``table["t_s"]`` is an ``array.array`` of doubles, which numpy and matplotlib take as it is.
    """

    def __init__(self, columns: Mapping[str, Any]) -> None:
        self._columns: dict[str, array[float]] = {}
        for name, values in columns.items():
            column = array("d")
            column.frombytes(values if isinstance(values, bytes) else _bytes(name, values))
            self._columns[name] = column
        lengths = {len(column) for column in self._columns.values()}
        if len(lengths) > 1:
            raise _native.JointError(
                "columns differ in length: "
                + ", ".join(f"{name} {len(column)}" for name, column in self._columns.items())
            )

    @classmethod
    def _of(cls, pairs: list[tuple[str, bytes]]) -> Table:
        return cls(dict(pairs))

    def __getitem__(self, name: str) -> array[float]:
        return self._columns[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    @property
    def samples(self) -> int:
        """Number of rows."""
        return len(next(iter(self._columns.values()), ()))

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.samples} samples: {', '.join(self)})"

    def to_pandas(self) -> pandas.DataFrame:
        """A data frame of the columns; needs pandas."""
        import pandas

        return pandas.DataFrame({name: list(column) for name, column in self.items()})

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Writes the columns as `joint` reads them; a value that is no number is an empty field."""
        rows = zip(*self._columns.values())
        with open(path, "w", encoding="utf-8", newline="\n") as file:
            file.write(",".join(self) + "\n")
            for row in rows:
                file.write(",".join("" if value != value else repr(value) for value in row) + "\n")


Log = Union[str, os.PathLike[str], Mapping[str, Any], "pandas.DataFrame", Table]
"""A log: a path, a data frame, or a mapping of columns."""


def native(log: Log) -> _native.Log:
    """The log, checked; columns that are no numbers are left out, as unknown ones are."""
    if isinstance(log, (str, os.PathLike)):
        return _native.Log.read(Path(log))
    if isinstance(log, Table):
        return _native.Log.of([(name, column.tobytes()) for name, column in log.items()])
    if not (hasattr(log, "items") and hasattr(log, "__getitem__")):
        raise TypeError(f"a log is a path, a data frame or a mapping of columns, not {type(log).__name__}")
    numeric = {str(name): values for name, values in log.items() if _is_numeric(values)}
    table = Table(numeric)
    return _native.Log.of([(name, column.tobytes()) for name, column in table.items()])
