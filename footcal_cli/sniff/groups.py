"""Columns that belong together: axes of a transducer, an attitude, the cells of the feet."""

from __future__ import annotations

import re
import unicodedata
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, numbers_of
from footcal_cli.sniff.names import FORCE, TORQUE, words_of
from footcal_cli.sniff.units import LOADS, NO_READING, VOLTAGES, split_unit

AXES = ("fx", "fy", "fz", "tx", "ty", "tz")
AT_THE_FOOT = re.compile(r"foot|ankle|sole", re.IGNORECASE)
_VECTORS = "|".join(sorted((w for w in FORCE | TORQUE if len(w) > 1), key=len, reverse=True))
_BEFORE_AXIS = re.compile(
    rf"(.*?)[\W_]*(?:(?:{_VECTORS})[\W_]*v?[xyz]|[fmt][\W_]?[xyz])(?![a-z])", re.IGNORECASE
)


_READ_IN = (*LOADS, *VOLTAGES, "mV/V")
_BRACKETS = re.compile(r"\s*\[[^\[\]]*[^\W\d][^\[\]]*\]\s*$")
_FOLLOWED = 0.98
"""How much of the variance of what a transducer read the wrench of a rig explains."""
_MANY = 20
"""Rows in which a reading knows more than two numbers."""
_SHIFTED = 5.0
"""What two plates bear together varies by so much less than what goes from one to the other."""


def transducers_by_stem(file: FileGuess) -> dict[str, dict[str, ColumnGuess]]:
    """Complete six-axis transducers by what stands before the axes in their names."""
    groups: dict[str, dict[str, ColumnGuess]] = {}
    for column in file.of("force"):
        if column.name.axis in AXES:
            groups.setdefault(_stem(column.column), {}).setdefault(column.name.axis, column)
    return {stem: axes for stem, axes in groups.items() if stem and set(axes) == set(AXES)}


def wrenches(file: FileGuess) -> dict[str, dict[str, ColumnGuess]]:
    """Complete six-axis transducers by name: axis -> column."""
    groups: dict[tuple[str, str], dict[str, ColumnGuess]] = {}
    for column in file.of("force"):
        if column.name.axis in AXES:
            groups.setdefault((column.name.address, ""), {}).setdefault(column.name.axis, column)
            if AT_THE_FOOT.search(column.column):
                own = groups.setdefault((column.name.address, "foot"), {})
                own.setdefault(column.name.axis, column)
    whole = {key: g for key, g in groups.items() if set(g) == set(AXES)}
    numbered = transducers_by_stem(file)
    if len(numbered) > len({name for name, _ in whole}) and not any(foot for _, foot in whole):
        return numbered  # L1 L2 L3 are three legs, not one left foot
    # of two transducers in a leg the one at the foot feels the ground
    return {
        owner_of(name): whole.get((name, "foot"), group)
        for (name, _), group in whole.items()
    }  # fmt: skip


def follows(felt: Mapping[str, ColumnGuess], put: Mapping[str, ColumnGuess]) -> bool:
    """Whether six axes of one wrench explain each of another, crosstalk and offsets included."""
    x, y = (np.column_stack([numbers_of(own[axis]) for axis in AXES]) for own in (put, felt))
    good = np.isfinite(x).all(axis=1) & np.isfinite(y).all(axis=1)
    if put is felt or good.sum() <= 2 * len(AXES):
        return False
    x, y = (v[good] - v[good].mean(axis=0) for v in (x, y))
    left = y - x @ np.linalg.lstsq(x, y, rcond=None)[0]
    return bool(np.all((left**2).sum(axis=0) < (1.0 - _FOLLOWED) * (y**2).sum(axis=0)))


def _stem(column: str) -> str:
    """Name of a transducer in front of its axes: ``L1`` of ``L1_Fx [N]``."""
    found = _BEFORE_AXIS.match(column)
    return owner_of(found[1]) if found and found[1].strip("_. /") else ""


def owner_of(address: str) -> str:
    """Name of a transducer, fit for a recipe."""
    return re.sub(r"\W+", "_", address).strip("_") or "sensor"


def matrix(file: FileGuess) -> dict[str, tuple[ColumnGuess, str | None]]:
    """Canonical columns of a rotation matrix -> column."""
    found = {c.name.axis: c for c in file.of("matrix")}
    zero = any("0" in axis for axis in found)
    wanted = [f"{i}{j}" for i in range(3) for j in range(3)]
    if not zero:
        wanted = [f"{i}{j}" for i in range(1, 4) for j in range(1, 4)]
    if not all(axis in found for axis in wanted):
        return {}
    made = [f"body_r{i}{j}" for i in range(1, 4) for j in range(1, 4)]
    return {name: (found[axis], None) for name, axis in zip(made, wanted, strict=True)}


def angle_unit(columns: Mapping[str, ColumnGuess]) -> str:
    """Radians or degrees, by the names and else by the largest angle."""
    for column in columns.values():
        if column.unit in ("rad", "deg"):
            return column.unit
    angles = [c.values for c in columns.values() if c.values is not None]
    largest = max(float(np.nanmax(np.abs(one))) for one in angles)
    return "deg" if largest > 2 * np.pi else "rad"


def one_owner(columns: Iterable[ColumnGuess], axes: Iterable[str]) -> dict[str, ColumnGuess]:
    """The first complete set of axes of one owner; body and base before others."""
    groups: dict[str, dict[str, ColumnGuess]] = {}
    for column in columns:
        groups.setdefault(column.name.address, {}).setdefault(column.name.axis, column)
    whole = {name: g for name, g in groups.items() if set(axes) <= set(g)}
    for name in sorted(
        whole, key=lambda n: not re.search(r"body|base|imu|torso|tool|tcp|sensor", n)
    ):
        return {axis: whole[name][axis] for axis in axes}
    return {}


def readings(file: FileGuess) -> list[ColumnGuess]:
    """Columns taken for readings of cells: those called so, else those nothing else explains.

    What knows 0 and 1 alone is a flag.
    """
    return [c for c in _readings(file) if not _is_flag(c)]


def _is_flag(column: ColumnGuess) -> bool:
    """Whether a column of many rows holds 0 and 1 alone."""
    known = np.unique(_finite(column))
    return bool(known.size == 2 and np.all(known == [0.0, 1.0]) and _finite(column).size > _MANY)


def _readings(file: FileGuess) -> list[ColumnGuess]:
    named = _parts([c for c in file.of("reading") if could_be_read(c)])
    plain = _parts([c for c in file.of("force") if c.name.axis in ("", "fz")])
    unknown = [c for c in file.of("unknown") if could_be_read(c) and _finite(c).size]
    alive = Counter(_kind(c) for c in unknown if np.ptp(_finite(c)) > 0)
    # what stands still among cells is a dead one
    unknown = [c for c in unknown if np.ptp(_finite(c)) > 0 or alive[_kind(c)] > 1]
    if named:
        own = {_without_its_letter(c.column) for c in named}
        named += [
            c for c in unknown
            if _without_its_letter(c.column) in own and c.counts == named[0].counts
        ]  # fmt: skip
        unknown = [c for c in unknown if c not in named]
        placed = [c for c in unknown if c.name.side or c.name.place]
        return [*named, *placed] if placed and not any(c.name.side for c in named) else named
    counts = [c for c in unknown if c.counts and c.name.side]
    if plain and {c.name.side for c in counts} == {"left", "right"}:
        return counts  # L1 … R4, on a plate
    if plain and not wrenches(file):
        return plain
    return unknown


def _kind(column: ColumnGuess) -> tuple[object, ...] | str:
    """What columns of one kind share that differ in their side or place; its name without one."""
    name = column.name
    if not (name.side or name.place):
        return column.column
    return bool(name.side), bool(name.place), re.sub(r"\d", "", name.owner), column.unit


def _without_its_letter(name: str) -> tuple[str, bool]:
    """A name without what its siblings differ by, a letter or number: A, B; ch_1, ch_2; dA, dB."""
    ends = r"(\d+)|(?<![A-Za-z])[A-Za-z]|(?<=[a-z])[A-Z]"
    found = re.fullmatch(rf"(.*?)(?:{ends})", split_unit(name)[0].strip())
    return (found[1], found[2] is not None) if found else (name, False)


def could_be_read(column: ColumnGuess) -> bool:
    """Whether a column can be the reading of a load cell: numbers in no other quantity's unit."""
    return column.values is not None and column.unit not in NO_READING


def _parts(columns: list[ColumnGuess]) -> list[ColumnGuess]:
    """Readings without the totals of a foot whose parts stand there too."""
    totals = [c for c in columns if {"total", "sum"} & set(words_of(c.column))]
    return [c for c in columns if c not in totals] if len(totals) < len(columns) / 2 else columns


def _finite(column: ColumnGuess) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    assert column.values is not None, "asked of numbers only"
    return column.values[np.isfinite(column.values)]


def channel_names(columns: Iterable[ColumnGuess]) -> dict[str, ColumnGuess]:
    """Readings by the name of their channel: the address where it tells them apart."""
    columns = list(columns)
    unit = re.sub(r"\W+", "_", bracketed_end([c.column for c in columns]).lower()).rstrip("_")
    addresses = [c.name.address.removesuffix(unit) for c in columns]
    if all(addresses) and len(set(addresses)) == len(addresses):
        names = [a if not a[0].isdigit() else f"cell_{a}" for a in addresses]
    else:
        names = [slug(split_unit(c.column)[0] if c.unit in _READ_IN else c.column) for c in columns]
    if len({*names}) < len(names):  # of letters that no recipe's key has the numbers are left
        numbers = [re.findall(r"\d+", split_unit(c.column)[0])[-1:] for c in columns]
        counted = ["_".join([c.name.address.rpartition("_")[0] or c.name.address, *n])
                   for c, n in zip(columns, numbers, strict=True)]  # fmt: skip
        names = counted if all(numbers) and len({*counted}) == len(names) else names
    elif any(n.startswith(f"{m}_") for n in names for m in names) and not any(
        c.name.side or c.name.place for c in columns
    ):  # kg_a beside kg_b: a letter was taken for a word
        whole = [slug(c.column) for c in columns]
        names = whole if len({*whole}) == len(names) else names
    twice = Counter(names)
    names = [n if twice[n] == 1 else f"{n}_{i + 1}" for i, n in enumerate(names)]
    return dict(zip(names, columns, strict=True))


def bracketed_end(names: Sequence[str]) -> str:
    """The brackets at the end of each of several names: a unit, known or not; else empty."""
    ends = {found[0] if (found := _BRACKETS.search(name)) else "" for name in names}
    return ends.pop() if len(ends) == 1 < len(names) else ""


def slug(name: str) -> str:
    """A name as part of a recipe's key, without its unit or the word for a reading."""
    letters = "".join(
        c for c in unicodedata.normalize("NFKD", name) if not unicodedata.combining(c)
    )
    plain = re.sub(r"[^A-Za-z0-9]+", "_", letters).strip("_").lower()  # Méta is meta
    plain = without_unit(plain) or "cell"
    return f"cell_{plain}" if plain[0].isdigit() else plain


def without_unit(name: str) -> str:
    """A cell's name without the word for its reading: ``links_1_counts`` is ``links_1``."""
    return re.sub(r"(?:_(?:counts|cnt|cts|n|adc|raw|data))+$", "", name)


def are_two_plates(columns: Sequence[ColumnGuess]) -> bool:
    """Whether twelve columns are two plates: what each bears changes, and their sum hardly does."""
    if len(columns) != 2 * len(AXES):
        return False
    for at in (2, 5):  # forces first, or moments
        one, other = numbers_of(columns[at]), numbers_of(columns[at + len(AXES)])
        whole, shifted = one + other, min(float(np.nanstd(one)), float(np.nanstd(other)))
        if _SHIFTED * np.nanstd(whole) < min(shifted, abs(float(np.nanmean(whole)))):
            return True
    return False
