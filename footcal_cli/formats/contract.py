"""What every reader gives: streams of columns, read piece by piece."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from footcal_cli.errors import missing_library
from footcal_cli.tables.units import TIMES

Array = NDArray[Any]
Arrays = dict[str, Array]
"""Columns of one length, by name."""
ClockOf = Literal["header", "log"]
"""Which stamp of a message: when it was measured, or when it was recorded."""

CHUNK_ROWS = 50_000
"""Rows that are held in memory at a time where a file can be read in pieces."""

_LONGEST_UNIT = 5
_SUFFIXES: Mapping[str, str] = {
    "n": "n", "newton": "n", "newtons": "n", "kn": "kn", "mn": "mn", "kgf": "kgf", "lbf": "lbf",
    "kg": "kg", "g": "g", "nm": "nm", "n*m": "nm", "n.m": "nm", "n·m": "nm", "n-m": "nm",
    "nmm": "nmm", "n*mm": "nmm", "n.mm": "nmm", "m": "m", "cm": "cm", "mm": "mm", "s": "s",
    "sec": "s", "seconds": "s", "ms": "ms", "us": "us", "µs": "us", "ns": "ns", "rad": "rad",
    "deg": "deg", "degrees": "deg", "rad/s": "radps", "deg/s": "degps", "m/s^2": "mps2",
    "m/s²": "mps2", "m/s2": "mps2", "degc": "degc", "°c": "degc", "celsius": "degc", "pa": "pa",
    "kpa": "kpa", "bar": "bar", "count": "counts", "counts": "counts",
}  # fmt: skip


@dataclass(frozen=True)
class Stream:
    """One table inside a foreign file.

    Parameters
    ----------
    name
        Topic, variable or group, as the file calls it.
    kind
        Message type, or what the file calls it.
    columns
        Names as they will be written.
    time
        The column of time stamps, None without one.
    clock
        What the stamps are, in words.
    chunks
        Opens the file and yields its columns piece by piece, always the same ones.
    left_out
        Fields that no column can hold, and why.
    duration_s
        From first to last sample where the file says so without being read.
    """

    name: str
    kind: str
    rows: int
    columns: tuple[str, ...]
    time: str | None
    clock: str
    chunks: Callable[[], Iterator[Arrays]]
    left_out: tuple[str, ...] = ()
    duration_s: float | None = None

    @property
    def readable(self) -> bool:
        """Whether anything of it can be written."""
        return bool(self.columns) and self.rows > 0

    @property
    def rate_hz(self) -> float | None:
        """Mean rate, None where the duration is not known."""
        if not self.duration_s or self.rows < 2:
            return None
        return (self.rows - 1) / self.duration_s


def library(name: str, extra: str, what: str) -> Any:
    """Import an optional library.

    Raises
    ------
    UsageError
        It is not installed; gives the command that installs it.
    MachineError
        It is installed, but there is no memory to load it.
    """
    try:
        return import_module(name)
    except ImportError as error:
        raise missing_library(
            name, error, f"{what} needs the package {name.split('.')[0]}",
            f"pip install 'footcal[{extra}]'",
        ) from None  # fmt: skip


def with_unit(name: str, unit: str) -> str:
    """A column name with its unit as suffix, as the source states it; unknown units are left off.

    >>> with_unit("Force.Fx1", "N")
    'Force.Fx1_n'
    """
    suffix = _SUFFIXES.get(unit.strip().lower().replace(" ", ""))
    return name if suffix is None or name.lower().endswith(f"_{suffix}") else f"{name}_{suffix}"


_VECTORS = ("m", "mm", "cm", "n", "nm", "nms", "mps", "mps2")
"""Units of three numbers that are a vector's, if no word says that they are cells."""
_QUATERNION = re.compile(r"(?i)(?:quat|rot|ori|att).*?(?P<order>xyzw|wxyz)$")
_OF_CELLS = re.compile(r"(?i)cell|zelle|cella|celda|cellule|lc|fsr|gauge|load|joint|q$")


def component_names(name: str, count: int) -> list[str]:
    """Names of the numbers of a list, its unit last: ``pos_x_m``, ``joints_0_deg``, ``data_0``.

    Three numbers in a unit of vectors are x, y and z.

    >>> component_names("pos_m", 3)
    ['pos_x_m', 'pos_y_m', 'pos_z_m']
    """
    order = _QUATERNION.search(name)
    if order and count == len("xyzw"):
        return [
            f"{name[: order.start('order')].rstrip('_.')}_{axis}" for axis in order["order"].lower()
        ]
    stem, _, unit = name.rpartition("_")
    known = unit.lower() in _SUFFIXES or unit.lower() in _VECTORS
    if not stem or not known or len(unit) > _LONGEST_UNIT:
        return [f"{name}_{i}" for i in range(count)]
    vector = count == len("xyz") and unit.lower() in _VECTORS
    axes = "xyz" if vector and not _OF_CELLS.search(stem) else map(str, range(count))
    return [f"{stem}_{axis}_{unit}" for axis in axes]


def seconds(stamps: Array, column: str) -> NDArray[np.float64]:
    """Stamps in s since the first one, whatever unit the column's name says."""
    since: NDArray[np.float64] = (stamps - stamps[:1]).astype(np.float64)
    return since * seconds_each(column)


def seconds_each(column: str) -> float:
    """The unit of time at the end of a column's name, in s; 1 where there is none."""
    return TIMES.get(column.rsplit("_", 1)[-1], 1.0)


def time_column(names: tuple[str, ...]) -> str | None:
    """The column that looks like time stamps, such as ``time_s`` or ``log.stamp``."""
    plain = {name: name.lower().rsplit(".", 1)[-1] for name in names}
    for wanted in ("time_ns", "time_s"):
        if wanted in plain.values():
            return next(name for name, short in plain.items() if short == wanted)
    for name, short in plain.items():
        if short in {"t", "time", "timestamp", "stamp"} or short.startswith(("time_", "t_")):
            return name
    return None


def number_of(word: str) -> int | float | None:
    """A word as a whole number where it is one, else as a number; None where it is none."""
    for kind in (int, float):
        try:
            return kind(word)
        except ValueError:
            pass
    return None
