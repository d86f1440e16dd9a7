"""Which columns are known loads, and which readings; of several loads, the one that is meant.

Room: sniff; asked by experiment.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.readings import straightness
from footcal_cli.sniff.derived import copies, quotients
from footcal_cli.sniff.gaps import without_gaps
from footcal_cli.sniff.groups import could_be_read, readings
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, numbers_of
from footcal_cli.sniff.names import ADDED, COMMANDED, GROSS, NET, NOMINAL, words_of
from footcal_cli.sniff.plan import FORCES
from footcal_cli.sniff.units import GRAVITY_MPS2, LOADS, MASSES
from footcal_cli.sniff.weights import added_up, follow, in_two_units, moves
from footcal_cli.tables.units import conversion

_AS_ASKED = 0.95
"""How much of a measured load the one that was asked for explains."""
_OF_ALL = 0.2
"""How far the sum of readings may be from the load that all cells carry together."""
_HALF = 0.5
_AGAIN = 0.05
"""How far two columns of one load may be apart: nominal and actual masses."""
_CLOSER = 0.5
"""Of what one load leaves of a reading's variance, what a better one leaves at most."""
_EXPLAINED = 0.999
"""How much of a reading's variance a load explains that is the whole load."""
_BENT, _ALL_BUT = 0.995, 0.02
"""What a load explains at most where another column belongs to it; what their product leaves."""
_LEAST_ROWS, _AS_MANY = 6, 2
_DIFFERENT = 4
"""Loads in two units agree in so many by no chance."""
_BARE = {"g": "g", "st": "stone", "stone": "stone"}
"""Names that are a unit of a load only beside one in another unit."""


def _measured(file: FileGuess, asked: ColumnGuess, cells: list[ColumnGuess]) -> ColumnGuess | None:
    """The load that was measured, next to one that was only asked for; None without both.

    Another column in a unit of force must follow it, and a reading must remain.
    """
    if not COMMANDED & set(words_of(asked.column)):
        return None
    for column in file.of("force", "reading", "load", "unknown"):
        others = [c for c in cells if c is not column]
        if column is asked or column.unit not in FORCES or column.name.axis not in ("", "fz"):
            continue
        if column.values is not None and others and not follow(asked, [column], _AS_ASKED)[1]:
            why = f"measured, where {asked.column} was asked for"
            return column.as_quantity("load", "likely", why)
    return None


def unlike(loads: list[ColumnGuess], cells: list[ColumnGuess]) -> list[ColumnGuess]:
    """Loads that are not the first one again: in newtons, or where a unit is not said by course.

    Without units they matter where the first load alone does not explain the readings.
    """
    if len(loads) < 2 or not cells:
        return []
    first, unlike = loads[0], []
    for other in loads[1:]:
        if first.unit in LOADS and other.unit in LOADS:
            one, two = _in_newton(first), _in_newton(other)
            if np.nanmax(np.abs(one - two)) > _AGAIN * np.nanmax(np.abs(one)):
                unlike.append(other)
        elif follow(first, [other], _AS_ASKED)[1] and follow(first, cells, _EXPLAINED)[1]:
            unlike.append(other)
    return unlike


def share_the_load(loads: list[ColumnGuess], cells: list[ColumnGuess]) -> bool:
    """Whether cells that read forces carry the load together: each less, all of them as much.

    A calibrated force is not off by half: where every cell reads less than that, others carry, too.
    """
    load = loads[0]
    if len(loads) > 1 or not all(c.unit in FORCES for c in (load, *cells)):
        return False
    values = [_in_newton(c) for c in (load, *cells)]
    known, read = values[0], np.sum(values[1:], axis=0)
    good = np.isfinite(known) & np.isfinite(read)
    if good.sum() < 3 or np.ptp(known[good]) == 0:
        return False
    whole = np.polyfit(known[good], read[good], 1)[0]
    each = [np.polyfit(known[good], v[good], 1)[0] for v in values[1:]]
    return bool((abs(whole - 1) < _OF_ALL and max(each) < 1 - _OF_ALL) or max(each) < _HALF)


def _in_newton(column: ColumnGuess) -> FloatArray:
    change = conversion(column.unit or "N", "N", GRAVITY_MPS2)
    return np.asarray(change(numbers_of(column)))


def loads_and_cells(file: FileGuess) -> tuple[list[ColumnGuess], list[ColumnGuess]]:
    """Columns of known loads and of readings, without what was worked out of these."""
    loads, cells = _loads_and_cells(file)
    why = {c.column: "the load once more, in another unit" for c in cells
           if any(written_twice(load, c) for load in loads)}  # fmt: skip
    why |= {c.column: "the load times a constant" for c in copies(loads, cells)}
    why |= {c.column: "a reading by its load: a scale that was worked out"
            for c in quotients(loads, cells)}  # fmt: skip
    if not why:
        return loads, cells
    once = tuple(
        c.as_quantity("other", "likely", why[c.column]) if c.column in why else c
        for c in file.columns
    )  # fmt: skip
    return _loads_and_cells(replace(file, columns=once))


def written_twice(load: ColumnGuess, other: ColumnGuess) -> bool:
    """Whether a column is a known load in another unit, to all the digits that are printed.

    Mass times the acceleration of gravity as schools, firmwares and standards write it. What was
    measured is not so exact in every row.
    """
    if load.unit not in LOADS or other.unit not in FORCES or load.unit == other.unit:
        return False
    put, read = numbers_of(load), numbers_of(other)
    if put.size != read.size or np.unique(put[np.isfinite(put)]).size < _DIFFERENT:
        return False
    digits = next((d for d in range(7) if np.allclose(read, np.round(read, d), atol=1e-9)), 7)
    for gravity in (GRAVITY_MPS2, 9.81, 9.8, 10.0):
        one = conversion(load.unit, "N", gravity)(put)
        two = conversion(other.unit, "N", gravity)(np.array([0.5 * 10.0**-digits, *read]))
        if np.all(np.abs(one - two[1:]) <= two[0] * (1 + 1e-6) + 1e-9 * np.abs(one)):
            return True
    return False


def _loads_and_cells(file: FileGuess) -> tuple[list[ColumnGuess], list[ColumnGuess]]:
    """One force beside counts is the reference; of several loads, the one that was put on."""
    loads = [c for c in file.of("load") if c.values is not None and moves(c)]
    cells = [c for c in readings(file) if c not in loads]
    loads = [without_gaps(c, cells, file.of("label")) for c in loads]
    if not loads:
        forces = [
            c for c in file.of("force", "reading", "unknown")
            if c.unit in FORCES and c.name.axis in ("", "fz") and c.values is not None
        ]  # fmt: skip
        others = [c for c in readings(file) if c not in forces]
        others = others or [
            c for c in file.of("unknown", "reading") if c not in forces and could_be_read(c)
        ]
        plain = [c for c in file.of("force") if c.name.axis in ("", "fz")]
        if not forces and len(plain) == 1 and others and plain[0] not in others:
            forces = plain
        asked = [c for c in forces if COMMANDED & set(words_of(c.column))]
        if len(forces) == 2 and len(asked) == 1 and others:
            forces = [c for c in forces if c not in asked]
        if len(forces) == 2 and not others and any(c.unit in MASSES for c in forces):
            # a mass and a force: what takes far fewer values was put on; two sides take as many
            few, many = sorted(forces, key=lambda c: np.unique(numbers_of(c)).size)
            sizes = [np.unique(numbers_of(c)).size for c in (few, many)]
            put_on = few.unit in MASSES and 2 * sizes[0] <= sizes[1]
            if put_on and follow(few, [many], _AS_ASKED)[0]:
                others, forces = [many], [few]
        if len(forces) > 1 and others and all(c.unit in LOADS for c in forces):
            twice = [c.as_quantity("load", "likely", "a load twice") for c in forces]
            if not unlike(twice, others):
                return _closest(twice, others), others
        if len(forces) == 1 and others:
            why = "a force next to readings that are none"
            return [forces[0].as_quantity("load", "likely", why)], others
    pressures = [c for c in file.of("pressure") if c.values is not None]
    if not loads and len(pressures) == 1:
        why = "a pressure that all readings are under: its unit times an area is the load"
        # readings that are newtons already are no cells under it, as of a motor's chamber
        cells = [] if any(c.unit in FORCES for c in cells) else cells
        return ([pressures[0].as_quantity("load", "guess", why)], cells) if cells else ([], [])
    added = [c for c in loads if ADDED & set(words_of(c.column))]
    if len(loads) > len(added):
        loads = [c for c in loads if c not in added]
    elif len(added) == 1 and cells:
        loads = [added_up(added[0], cells)]
    net = [c for c in loads if NET & set(words_of(c.column))]
    if any(GROSS & set(words_of(c.column)) for c in loads):
        loads = [c for c in loads if c not in net]
    if loads:
        named = [(c, c.column.strip().lower()) for c in file.of("unknown") if c.values is not None]
        bare = [replace(c, unit=_BARE[name]) for c, name in named if name in _BARE]
        loads = [c for c in in_two_units([*loads, *bare]) if c not in bare]
    asked = [c for c in loads if COMMANDED & set(words_of(c.column))]
    if len(asked) == 1 and len(loads) == 2 and cells:
        loads = [c for c in loads if c not in asked]
    loads = _closest(loads, cells)
    if len(loads) == 1 and (put := _measured(file, loads[0], cells)) is not None:
        return [put], [c for c in cells if c.column != put.column]
    if loads and not cells:
        cells = [c for c in file.of("unknown", "force") if could_be_read(c)]
        if not cells and len(loads) == 2:
            # two weights: the one with fewer values was put on, the other was read
            loads = sorted(loads, key=lambda c: np.unique(numbers_of(c)).size)
            cells, loads = (
                [loads[1].as_quantity("reading", "guess", "a weight that was read")],
                loads[:1],
            )
    return loads, cells


def _closest(loads: list[ColumnGuess], cells: Sequence[ColumnGuess]) -> list[ColumnGuess]:
    """Loads of which the first is what was put on, where two columns tell of one load.

    Loads in two units that agree within 5 % are one. What is called nominal gives way, and so does
    one that leaves more than twice as much of the readings' variance as another.
    """
    if len(loads) < 2 or not cells or unlike(loads, list(cells)):
        return loads
    stated = [c for c in loads if c.unit in LOADS]
    if 0 < len(stated) < len(loads) != len(cells):  # how many weights, and what they weigh
        return [*_closest(stated, cells), *(c for c in loads if c not in stated)]
    if len(loads) == len(cells) or any(c.unit not in LOADS for c in loads):
        return loads
    read = [numbers_of(c) for c in cells]
    left = {}
    for load in loads:
        put = numbers_of(load)
        left[load.column] = float(np.sum([1 - straightness(put, r) for r in read
                                          if r.size == put.size]))  # fmt: skip
    named = [c for c in loads if not NOMINAL & set(words_of(c.column))] or loads
    # what changes while a load stays is a display, or a reference cell: its name must say so
    levels = np.unique(numbers_of(named[0])).size
    steady = [c for c in named if np.unique(numbers_of(c)).size <= _AS_MANY * levels]
    best = min(steady, key=lambda c: left[c.column])
    first = named[0]
    if left[best.column] < _CLOSER * left[first.column]:
        first = replace(best, why="the readings follow it closest of all loads")
    return [first, *(c for c in loads if c.column != first.column)]


def belongs_to(
    file: FileGuess, loads: Sequence[ColumnGuess], cells: Sequence[ColumnGuess]
) -> ColumnGuess | None:
    """A column whose product with the load the readings follow, and not the load; None without.

    The length of a lever: what is read is a torque. A gain, or the supply of a bridge.
    """
    used = {c.column for c in (*loads, *cells)}
    if len(loads) != 1 or not cells:
        return None
    load = numbers_of(loads[0])
    read = [numbers_of(c) for c in cells]
    if any(r.size != load.size or straightness(load, r) > _BENT for r in read):
        return None
    for column in file.columns:
        values = column.values
        if values is None or column.column in used or column.quantity in ("time", "sequence"):
            continue
        if values.size != load.size or not np.isfinite(values).all() or np.ptp(values) == 0:
            continue
        if load.size < _LEAST_ROWS:
            return None
        left = [
            (1 - straightness(load * values, r)) / (1 - straightness(load, r)) for r in read
        ]  # fmt: skip
        if np.abs(values).min() > 0 and max(left) < _ALL_BUT:
            return column
    return None
