"""A column as a file holds it, before anything is converted.

Room: tables; made by logfiles, turned by pivot, read by sources, values and sniff.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from footcal_cli.core.parameters import BoolArray, FloatArray

RawKind = Literal["number", "truth", "text", "stamp", "duration"]


@dataclass(frozen=True)
class RawColumn:
    """A column as the file holds it.

    Parameters
    ----------
    kind
        ``stamp`` counts nanoseconds since 1970 (UTC), ``duration`` nanoseconds.
    values
        Shape (n,): integers or floats, booleans, strings, or nanoseconds (int64).
    empty
        Where the cell is empty, shape (n,).
    lines
        Line of every row in a text file, shape (n,); None for Parquet.
    said
        Whether the recipe's `pattern` or `names` wrote these texts: then they may be numbers.
    """

    kind: RawKind
    values: NDArray[Any]
    empty: BoolArray
    lines: NDArray[np.int64] | None = None
    said: bool = False

    @property
    def silent(self) -> BoolArray:
        """Where there is no value: an empty cell, or one that is no number, shape (n,)."""
        if self.values.dtype.kind != "f":
            return self.empty
        return np.asarray(self.empty | np.isnan(self.values), dtype=np.bool_)

    def of_rows(self, kept: BoolArray) -> RawColumn:
        """The column at some of its rows, shape (n,)."""
        lines = None if self.lines is None else self.lines[kept]
        return replace(self, values=self.values[kept], empty=self.empty[kept], lines=lines)

    def lasting(self, rows: int) -> RawColumn:
        """The column with each of its rows so many times."""
        again = np.repeat(np.arange(len(self.values)), rows)
        lines = None if self.lines is None else self.lines[again]
        return replace(self, values=self.values[again], empty=self.empty[again], lines=lines)

    def row(self, position: int) -> str:
        """A row for people: lines of a text file, rows of Parquet counted from 1."""
        return f"row {position + 1}" if self.lines is None else f"line {self.lines[position]}"


_BETWEEN_STANCES_S = 2.0
"""Nobody noted how long the robot moved; long enough for two stances to be two."""


def counted(rows: int, rate_hz: float, row_lasts: int) -> FloatArray:
    """Seconds of so many rows, shape (rows,); a pause between stances of a row each."""
    count = np.arange(rows, dtype=np.float64)
    pause = _BETWEEN_STANCES_S * (count // row_lasts) if row_lasts > 1 else 0.0
    return count / rate_hz + pause
