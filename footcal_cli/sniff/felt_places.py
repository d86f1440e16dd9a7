r"""Where a known weight lay on a foot, by what its cells felt, whatever the columns are called.

Room: sniff; asked by experiment. All cells share the load: with reading :math:`r_i` of cell i at
:math:`x_i`, :math:`\sum_i a_i r_i = F + b` and :math:`\sum_i a_i x_i r_i = F x + c`. A column x
that the readings explain so, and the load alone does not, is a place.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.sniff.derived import SCATTERS
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, numbers_of
from footcal_cli.sniff.names import words_of
from footcal_cli.sniff.shared_weight import LEAST_CELLS
from footcal_cli.sniff.units import split_unit
from footcal_cli.sniff.which_cell import one_cell_moves

_READ = ("reading", "unknown", "force", "pressure", "label", "other")
_STILL = 0.05
"""Spread of a zero over that of the reading it belongs to, at most."""
_FELT, _ADDS = 0.99, 0.5
"""Share of a moment that the readings explain at least; what a correction of a place leaves of
the rest at most."""
_ALIKE = 4.0
"""Ratio of the scales of a foot's cells, at most."""
_SPARE = 3
"""Rows more than unknowns."""
_IN_MM = 2.0
"""Metres in which no place on a foot is: such numbers are millimetres."""


def less_zeros(file: FileGuess) -> FileGuess:
    """A table in which readings stand next to the zeros that were read before: these taken off.

    Names of both end alike (``z1 … z4`` and ``k1 … k4``); zeros hardly move, and are near the
    readings. Only where a load or a place stands in the table: streams have no zero in each row.
    """
    if not file.of("load", "hole", "placement"):
        return file
    groups = [g for g in _of_one_stem(file) if len(g) >= LEAST_CELLS]
    for zeros in groups:
        for read in groups:
            if read is zeros or read.keys() != zeros.keys():
                continue
            pairs = [(zeros[k], read[k]) for k in read]
            if all(_zero_of(zero, reading) for zero, reading in pairs):
                after = [
                    c for g in groups if g is not zeros and g.keys() == read.keys()
                    and all(_zero_of(g[k], read[k]) for k in g) for c in g.values()
                ]  # fmt: skip
                return _taken_off(file, pairs, after)
    return file


def _zero_of(zero: ColumnGuess, reading: ColumnGuess) -> bool:
    before, after = numbers_of(zero), numbers_of(reading)
    if before.size != after.size or zero.counts != reading.counts or zero.unit != reading.unit:
        return False
    way = float(np.nanstd(after))
    near = abs(np.nanmedian(before) - np.nanmedian(after)) < np.ptp(after[np.isfinite(after)])
    return bool(0.0 < np.nanstd(before) < _STILL * way and near)


def _taken_off(
    file: FileGuess, pairs: Sequence[tuple[ColumnGuess, ColumnGuess]], after: Sequence[ColumnGuess]
) -> FileGuess:
    """The table with the first zero of each pair taken off, and without zeros read `after`."""
    less = {
        reading.column: replace(
            reading, values=numbers_of(reading) - numbers_of(zero), minus=zero.column,
            name=replace(reading.name, quantity="reading"),
            why=f"a reading; {zero.column} is its zero",
        )
        for zero, reading in pairs
    }  # fmt: skip
    less |= {z.column: z.as_quantity("other", "likely", f"zero of {r.column}") for z, r in pairs}
    less |= {
        z.column: z.as_quantity("other", "likely", "a zero that was read after") for z in after
    }
    return replace(file, columns=tuple(less.get(c.column, c) for c in file.columns))


def _of_one_stem(file: FileGuess) -> list[dict[str, ColumnGuess]]:
    """Columns of numbers whose names differ in a number or in what stands behind a line."""
    found: dict[str, dict[str, ColumnGuess]] = {}
    for column in file.columns:
        if column.values is None or column.quantity not in _READ:
            continue
        name = split_unit(column.column)[0].strip().lower()
        if SCATTERS & {*words_of(name)}:
            continue  # of what was averaged
        parts = re.fullmatch(r"(.*?)[_\W]*(\d+)", name) or re.fullmatch(r"(.*?)[_\W]+(\w+)", name)
        if parts is not None:
            found.setdefault(parts[1], {})[parts[2]] = column
    return list(found.values())


def felt_places(
    file: FileGuess, load: ColumnGuess
) -> tuple[Mapping[str, ColumnGuess], list[ColumnGuess]] | None:
    """Columns of a weight's x and y by the moment that cells felt, and these; None without.

    Parameters
    ----------
    load
        The weight that was put on.
    """
    put = numbers_of(load)
    if file.of("com", "foot_position", "time") or put.size != file.rows:
        return None
    groups = [list(g.values()) for g in _of_one_stem(file)]
    for cells in groups:
        read = np.column_stack([numbers_of(c) for c in cells])
        enough = len(cells) >= LEAST_CELLS and file.rows >= len(cells) + 1 + _SPARE
        if not enough or not _carry(put, read) or one_cell_moves(load, cells):
            continue
        others = [
            c for c in file.columns
            if c.values is not None and c not in cells and c.column != load.column
            and c.values.size == file.rows and c.quantity != "temperature"
        ]  # fmt: skip
        felt = {c.column: _felt(put, numbers_of(c), read) for c in others}
        places = [c for c in others if felt[c.column] > _FELT]
        axes = _axes(places, felt, put)
        if axes is not None:
            spare = [c for c in others if c not in axes.values()]
            better = {a: _correction(c, spare, put, read) for a, c in axes.items()}
            for one, other in ("xy", "yx"):
                if better[one] is None and (known := better[other]) is not None:
                    twin = re.sub(f"(?i){other}(?![a-z])", one, known.column)
                    better[one] = next((c for c in spare if c.column == twin), None)
            return {a: _as_place(c, a, better[a]) for a, c in axes.items()}, cells
    return None


def _explained(target: FloatArray, by: FloatArray, without: FloatArray) -> float:
    """Share of the variance of a target that columns explain beside others; NaN rows left out."""
    good = np.isfinite(np.column_stack([target, by, without])).all(axis=1)
    if good.sum() < by.shape[1] + without.shape[1] + _SPARE:
        return 0.0
    alone, both = without[good], np.column_stack([without, by])[good]
    left, least = (
        float(np.sum((target[good] - x @ np.linalg.lstsq(x, target[good], rcond=None)[0]) ** 2))
        for x in (alone, both)
    )
    return 1.0 - least / left if left > 1e-12 * float(np.sum(target[good] ** 2)) else 0.0


def _carry(put: FloatArray, read: FloatArray) -> bool:
    """Whether readings share a load: what they carry adds up to it, by scales of one size."""
    good = np.isfinite(put) & np.isfinite(read).all(axis=1)
    put, read = put[good], read[good]
    if len(put) < read.shape[1] + 1 + _SPARE or not np.all(np.ptp(read, axis=0) > 0):
        return False
    if np.ptp(put) > 0:
        columns = np.column_stack([read, np.ones(len(put))])
        each = np.linalg.lstsq(columns, put, rcond=None)[0]
        left = put - columns @ each
        scale = each[:-1]
        if np.mean(left**2) > (1.0 - _FELT) * np.var(put):
            return False
    else:  # the same weight everywhere: what is nearest to constant
        off = (read - read.mean(axis=0)) / read.std()
        scale = np.linalg.svd(off, full_matrices=False)[2][-1]
        if np.mean((off @ scale) ** 2) > (1.0 - _FELT) * np.mean(off**2):
            return False
    size = np.abs(scale)
    return bool(np.ptp(np.sign(scale)) == 0 and size.max() < _ALIKE * size.min())


def _felt(put: FloatArray, at: FloatArray, read: FloatArray) -> float:
    """How much of the moment of a load at a place the readings explain beside the load."""
    return _explained(put * at, read, np.column_stack([np.ones(put.size), put]))


def _axes(
    places: Sequence[ColumnGuess], felt: Mapping[str, float], put: FloatArray
) -> dict[str, ColumnGuess] | None:
    """Which columns are x and y, by their names or their order; None without two."""
    named = {axis: [c for c in places if _letter(c) == axis] for axis in "xy"}
    best = {a: max(own, key=lambda c: felt[c.column]) for a, own in named.items() if own}
    if len(best) < 2 and len(places) == 2 and not best:
        best = dict(zip("xy", places, strict=True))
    if len(best) < 2:
        return None
    x, y = (numbers_of(best[a]) * put for a in "xy")
    base = np.column_stack([np.ones(put.size), put])
    return best if _explained(y, x[:, None], base) < _FELT else None


def _letter(column: ColumnGuess) -> str:
    found = re.findall(r"(?<![a-z])([xy])(?![a-z])", split_unit(column.column)[0].lower())
    return found[-1] if found else ""


def _correction(
    place: ColumnGuess, others: Sequence[ColumnGuess], put: FloatArray, read: FloatArray
) -> ColumnGuess | None:
    """The column that says how far from a place the weight lay, if there is one."""
    at = numbers_of(place)
    left = 1.0 - _felt(put, at, read)
    for other in others:
        more = numbers_of(other)
        smaller = 0.0 < np.nanmax(np.abs(more)) < np.nanmax(np.abs(at))
        if smaller and 1.0 - _felt(put, at + more, read) < _ADDS * left:
            return other
    return None


def _as_place(place: ColumnGuess, axis: str, more: ColumnGuess | None) -> ColumnGuess:
    at = numbers_of(place)
    unit = place.unit or ("mm" if np.nanmax(np.abs(at)) > _IN_MM else "m")
    found = replace(
        place, name=replace(place.name, quantity="hole", axis=axis), unit=unit, sure="likely",
        why="the cells felt the load there",
    )  # fmt: skip
    if more is None:
        return found
    why = f"{found.why}, {more.column} on top"
    values, plus = at + np.nan_to_num(numbers_of(more)), {more.column: more.unit or unit}
    return replace(found, values=values, plus=plus, why=why)
