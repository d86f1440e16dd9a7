"""What a log is for: the experiment, footcal's columns in it, the command, and what is missing."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, Sure, numbers_of
from footcal_cli.sniff.units import SHARES
from footcal_cli.tables.canonical import NOT_SAID as NOT_SAID
from footcal_cli.tables.pieces import add_up

_HZ = r"(\d+(?:[.,]\d+)?)\s*(k?)(?:Hz|SPS|S/s)\b"
_SAMPLED = (
    r"(?:sampl\w*|logg\w*|record\w*|rate|abtast\w*|messrate|échantillon\w*|muestreo|amostr\w*|"
    r"campion\w*|próbkow\w*|vzork\w*|näytte\w*|bemonster\w*|örnekle\w*|дискретизац\w*|采样\w*|"
    r"サンプリング\w*|^\W*(?:fr[eé]quen\w*|frecuencia|freq)(?=[\s:;=,]+\d))"
)
_SAID_RATE = re.compile(
    rf"{_SAMPLED};?[^.;\n\d]{{0,30}}{_HZ}|{_HZ}\s+(?:data\s+)?(?:sampl|rate|logg)",
    re.IGNORECASE | re.MULTILINE,
)
"""``sampled at 80 Hz``, ``80 Hz sampling``; a filter's frequency is no rate."""


@dataclass(frozen=True)
class Entry:
    """Where one of footcal's columns is found: an entry of ``[columns]``.

    Parameters
    ----------
    column
        The file's, None for a value.
    unit, value, file_name, factor, nanoseconds, wraps_at, names, only_where, missing
        As in a recipe.
    sure, why
        How sure, and by what.
    """

    column: ColumnGuess | None = None
    unit: str | None = None
    value: str | None = None
    file_name: str | None = None
    factor: float | None = None
    nanoseconds: str = ""
    wraps_at: float | None = None
    names: Mapping[str, str] = field(default_factory=dict)
    only_where: Mapping[str, str] = field(default_factory=dict)
    missing: tuple[str, ...] = ()
    sure: Sure = "likely"
    why: str = ""


def of(column: ColumnGuess, unit: str | None = None) -> Entry:
    """An entry for a column as it was guessed."""
    return Entry(
        column, unit or column.unit, nanoseconds=column.nanoseconds, sure=column.sure,
        why=column.why, wraps_at=column.wraps_at, missing=column.missing, names=column.names,
        factor=None if column.name.factor == 1.0 else column.name.factor,
    )  # fmt: skip


@dataclass(frozen=True)
class Blank:
    """Something that no log says: lines of a recipe to be filled in, and why.

    `needed` is for commands that refuse to run without it.
    """

    lines: tuple[str, ...]
    why: str
    needed: bool = True


@dataclass(frozen=True)
class LogPlan:
    """How one log, or several of one kind, are to be used.

    Parameters
    ----------
    file
        The log that the guess was made on.
    kind, why, sure
        What it is in words, by what, and how sure.
    command, role
        The command that makes a calibration of it, and its name in ``[data]``.
    entries
        Canonical column -> where.
    channels
        Load cells, for ``[robot] channels``.
    wide, wide_into
        Entries of one row, as ``[[files]] wide``.
    rate_hz
        To be counted with, where the log has no stamps.
    robot, options
        Further lines of ``[robot…]`` tables and of the command's table.
    blanks
        What is to be filled in.
    warnings
        What could be otherwise.
    feet, mounting
        Feet on six-axis transducers, and the recipe's line that says how these are turned in them.
    moving
        The same sensors where the body's motion is known, if that makes more of them.
    zeros_where
        Column -> texts of the rows in which the robot hangs.
    """

    file: FileGuess
    kind: str
    why: str
    sure: Sure
    command: str
    role: str
    entries: Mapping[str, Entry]
    channels: tuple[str, ...] = ()
    wide: Mapping[str, Mapping[str, Entry]] = field(default_factory=dict)
    wide_into: str = "channel"
    rate_hz: float | None = None
    robot: tuple[str, ...] = ()
    options: tuple[str, ...] = ()
    blanks: tuple[Blank, ...] = ()
    warnings: tuple[str, ...] = ()
    feet: tuple[str, ...] = ()
    mounting: str = ""
    moving: LogPlan | None = None
    zeros_where: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    @property
    def read(self) -> dict[str, Entry]:
        """Readings of cells, ``<cell>_counts``; of several rounds those of the first."""
        every = {**next(iter(self.wide.values()), {}), **self.entries}
        return {name: entry for name, entry in every.items() if name.endswith("_counts")}

    @property
    def ready(self) -> bool:
        """Whether the command runs as it is."""
        return not any(blank.needed for blank in self.blanks)


MASS = Blank(
    (
        "# [robot]",
        "# mass_kg =    # the whole robot or person, with all that is worn",
        "# mass_sd_kg =    # how far that may be off, or left out: 1 % of it",
    ),
    "no log says what the robot or person weighs",
)
_CAPACITY = Blank(
    ('# in [columns]: load_n = { column = "…", unit = "N", factor = … }, factor: N of one share',),
    "the unit of the load is a share, of what the log does not say",
)
UNIT_ASKED = Blank(
    ('# in [columns]: unit = "?" of load_n becomes N, kg, g, lb …',),
    "nothing says the unit of the load",
)
NO_RATE = Blank(
    ("# rate_hz = 100.0    # rows per second",),
    "the log has no time stamps; 100 Hz is assumed, which moves no static calibration", False,
)  # fmt: skip


def load_entry(load: ColumnGuess) -> tuple[Entry, tuple[Blank, ...]]:
    """The entry of known loads; their unit is asked for where nothing says it."""
    if load.unit in SHARES:
        return replace(of(load, NOT_SAID), sure="guess", why="a share"), (_CAPACITY,)
    if load.unit is not None and load.unit != "count":
        return of(load), ()
    return replace(of(load, NOT_SAID), sure="guess"), (UNIT_ASKED,)


def times(file: FileGuess, *, needed: bool) -> tuple[dict[str, Entry], float | None, list[Blank]]:
    """The entry of time stamps, or a rate to count with."""
    for column in file.of("time"):
        return {"time_s": of(column)}, None, []
    if needed and (said := rate_said(file)) is not None:
        return {}, said, []
    return ({}, 100.0, [NO_RATE]) if needed else ({}, None, [])


def rate_said(file: FileGuess) -> float | None:
    """Rows per second by the lines above the table; None where they say none, or several."""
    text = "\n".join(file.text.above)
    found = [(f[1] or f[3], f[2] or f[4]) for f in _SAID_RATE.finditer(text)]
    rates = {float(number.replace(",", ".")) * (1e3 if kilo else 1.0) for number, kilo in found}
    return rates.pop() if len(rates) == 1 and 0.0 not in rates else None


def cell_name(word: str) -> str:
    """The name of a cell that a file or a sheet calls by a word or a number."""
    return f"cell_{word}" if word.isdecimal() else word


IN_NEWTON = (
    "[robot.nameplate]    # readings are forces already, used in N; how far they may be off\n"
    "scale_n_per_count = 1.0\nscale_relative_sd = 0.05\nbias_sd_n = 5.0"
)
"""What the cells of a log are known by that has forces already."""
FORCES = ("N", "kN", "mN", "daN", "kgf", "lbf", "gf", "kg", "g", "lb")
"""Units of a reading that is a force already."""


def extras(file: FileGuess) -> dict[str, Entry]:
    """Columns that help wherever they stand."""
    found = {}
    for quantity, name in (
        ("temperature", "temperature_degc"), ("repeat", "repeat"), ("session", "session"),
    ):  # fmt: skip
        for column in file.of(quantity)[:1]:
            found[name] = of(column)
    return found


def pieces_under(load: ColumnGuess, columns: Sequence[ColumnGuess]) -> dict[str, Entry]:
    """A column of texts that says of which pieces each load is made."""
    for column in columns:
        if column.codes is None or len(column.codes) != len(numbers_of(load)):
            continue
        said = [column.words[code] if code >= 0 else "" for code in column.codes]
        if add_up(said, numbers_of(load)):
            why = "every load is the sum of these pieces"
            return {"pieces": Entry(column, sure="likely", why=why)}
    return {}


def reading_entry(column: ColumnGuess) -> Entry:
    """A cell's reading: counts, a voltage or a force."""
    unit: str | None = None
    sure: Sure = "likely"
    why = "its unit is not said: taken as it is"
    if column.counts and column.unit not in FORCES:
        sure, why = column.sure, "whole numbers: counts"
    elif column.unit in ("V", "mV", "uV", "mV/V"):
        unit, why = column.unit, "a voltage: the scale is N per volt"
    elif column.unit in FORCES:
        unit, why = column.unit, "a force that was calibrated before"
    if column.wraps_at:
        why = "counts whose negative codes were read without their sign"
    return Entry(column, unit, sure=sure, why=why, wraps_at=column.wraps_at, missing=column.missing)


_NEEDED = ("weights", "weights_together", "placements", "cop_points")
"""Kinds of logs that need a reading in every row."""
_MOSTLY = 0.5
"""A table whose readings are mostly empty is of another layout."""


def without_silent_rows(plan: LogPlan) -> LogPlan:
    """The plan for a log in which a sensor was silent in some rows: they are left out, and said."""
    if plan.role not in _NEEDED:
        return plan
    said: list[str] = []

    def gaps(name: str, entry: Entry) -> Entry:
        column = entry.column
        if column is None or column.values is None or not name.endswith("counts") or column.held:
            return entry
        silent = ~np.isfinite(column.values)
        if not silent.any() or silent.mean() > _MOSTLY:
            return entry
        said.append(f"{column.column}: {silent.sum()} of {silent.size} rows have no reading and "
                    "are left out")  # fmt: skip
        return replace(entry, missing=entry.missing or ("",))

    entries = {name: gaps(name, entry) for name, entry in plan.entries.items()}
    wide = {
        key: {name: gaps(name, entry) for name, entry in own.items()}
        for key, own in plan.wide.items()
    }
    if not said:
        return plan
    return replace(plan, entries=entries, wide=wide, warnings=(*plan.warnings, *said))
