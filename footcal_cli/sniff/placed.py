"""A known weight at places of a foot: holes by their coordinates, or by names alone.

Room: sniff; asked by experiment. All cells of the foot are read at each placement, and
share the load: reading ``i`` at hole ``h`` is ``b_i + s_ih F``, another slope for each hole.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray
from footcal_cli.core.readings import straightness
from footcal_cli.sniff.cells import WEIGHTS, WHERE
from footcal_cli.sniff.groups import channel_names, slug
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, codes_of, numbers_of
from footcal_cli.sniff.names import without_side
from footcal_cli.sniff.plan import (
    FORCES,
    IN_NEWTON,
    NOT_SAID,
    Blank,
    Entry,
    LogPlan,
    extras,
    load_entry,
    of,
    reading_entry,
    times,
)
from footcal_cli.sniff.shared_weight import loaded_places, share_one_weight
from footcal_cli.sniff.side_by_side import by_rounds
from footcal_cli.sniff.units import split_unit
from footcal_cli.sniff.which_cell import as_label, followers, named_alike, one_cell_moves

_LEAST = 3
"""So many cells share a load, on so many holes."""
_FOLLOWS, _EXPLAINED = 0.95, 0.98
"""What the load explains of a reading under weights of its own; what load and hole explain here."""
NOTHING_ON = "empty"
"""What an empty cell of a column of holes means."""
ASKED = NOT_SAID
"""The place of a hole that no log says."""
HOLES = Blank(
    ('# in [columns]: each "?" of hole_x_m and hole_y_m becomes the place of that hole, in mm from',
     "# the foot's origin, x forward, y left; or give init a sheet: hole,x_mm,y_mm"),
    "no log says where the holes are",
)  # fmt: skip

WEIGHT = Blank(
    ('# in [columns]: each "?" of load_n becomes what was put on the holes, in kg',),
    "no log says what the weight on the holes weighs",
)


def at_holes(
    file: FileGuess, holes: Mapping[str, ColumnGuess], load: ColumnGuess,
    cells: Sequence[ColumnGuess],
) -> LogPlan | None:  # fmt: skip
    """The plan for a known weight on holes of a foot; None where nothing says on which.

    Parameters
    ----------
    holes
        Columns of the holes' x and y; empty without.
    load, cells
        What was put on, and the readings of all cells.
    """
    if len(cells) < _LEAST:
        return None
    if {"x", "y"} <= set(holes):
        hole_m = np.stack([numbers_of(holes[a]) for a in "xy"], axis=1)
        nowhere = ~np.isfinite(hole_m).all(axis=1)
        bare = bool(nowhere.any()) and not np.nan_to_num(numbers_of(load))[nowhere].any()
        hole_m[nowhere & bare] = 0.0
        points = [
            column for column in file.of("placement", "sequence", "repeat")
            if one_place_each(column, hole_m)
        ]  # fmt: skip
        places = {f"hole_{a}_m": of(holes[a], holes[a].unit or "m") for a in "xy"}
        if bare:  # nothing lies on the foot, and so nowhere
            why = "nowhere while nothing lies on the foot"
            places = {
                n: replace(e, names={**e.names, "": "0"}, why=f"{e.why}; {why}")
                for n, e in places.items()
            }
        return _plan(file, points[0] if points else None, places, load, cells)
    label = _on_holes(file, load, cells)
    if label is None:
        return None
    own = next(c for c in file.columns if c.column == label.column)
    cells = [c for c in cells if c.column != label.column]
    empty = _always_empty(label, numbers_of(load))
    words = sorted(label.words, key=lambda word: (len(word), word))
    names = {word: "0" if word in empty else ASKED for word in words}
    free = f"; {', '.join(sorted(empty))}: the empty foot, its zeros" * bool(empty)
    entry = Entry(own, "mm", names=names, sure="guess", why=HOLES.why + free)
    plan = _plan(file, own, {f"hole_{a}_m": entry for a in "xy"}, load, cells)
    return replace(plan, blanks=(HOLES, *plan.blanks))


def by_one_weight(
    file: FileGuess, holes: Mapping[str, ColumnGuess], cells: Sequence[ColumnGuess]
) -> LogPlan | None:
    """The plan for one weight on holes of a foot, which no column weighs; None where it is none.

    A column is called a hole, or places stand in the log, and the cells share one weight.

    Parameters
    ----------
    holes
        Columns of the holes' x and y; empty without.
    cells
        The readings of all cells.
    """
    read = [numbers_of(c) for c in cells]
    if any(r.size != file.rows for r in read):
        return None
    empty: set[str] = set()
    if {"x", "y"} <= set(holes):
        hole_m = np.stack([numbers_of(holes[a]) for a in "xy"], axis=1)
        codes = np.unique(hole_m, axis=0, return_inverse=True)[1].ravel()
        points = [c for c in file.of("placement", "sequence") if one_place_each(c, hole_m)]
        point = points[0] if points else None
        places = {f"hole_{a}_m": of(holes[a], holes[a].unit or "m") for a in "xy"}
        asked: tuple[Blank, ...] = ()
    else:
        found = (_free_between(c) if file.of("time") else None for c in file.of("placement"))
        labels = [label for label in found if label is not None]
        labels += [label for c in file.of("placement") if (label := as_label(c)) is not None]
        if not labels:
            return None
        point = next(c for c in file.columns if c.column == labels[0].column)
        if "" in labels[0].words:
            point = replace(point, names={"": NOTHING_ON})
        words = sorted(labels[0].words, key=lambda word: (len(word), word))
        codes, empty = loaded_places(labels[0])
        names = {word: "0" if word in empty else ASKED for word in words}
        entry = Entry(point, "mm", names=names, sure="guess", why=HOLES.why)
        places, asked = {f"hole_{a}_m": entry for a in "xy"}, (HOLES,)
    if not share_one_weight(read, codes):
        return None
    put = Entry(value=ASKED, unit="kg", sure="guess", why=WEIGHT.why)
    if empty and point is not None:
        names = {word: "0" if word in empty else ASKED for word in places["hole_x_m"].names}
        put = Entry(point, "kg", names=names, sure="guess", why=WEIGHT.why)
    plan = _with_load(file, point, places, put, cells)
    return replace(
        plan, why="holes, and readings that share one weight", blanks=(WEIGHT, *asked, *plan.blanks)
    )


def _free_between(column: ColumnGuess) -> ColumnGuess | None:
    """A running log's column of holes that is empty while nothing lies on them; None without."""
    if column.codes is None or len(column.words) < _LEAST or not np.any(column.codes < 0):
        return None
    codes = np.where(column.codes < 0, 0, column.codes + 1)
    return replace(column, words=("", *column.words), codes=codes)


def _plan(
    file: FileGuess, point: ColumnGuess | None, places: Mapping[str, Entry], load: ColumnGuess,
    cells: Sequence[ColumnGuess],
) -> LogPlan:  # fmt: skip
    put, asked = load_entry(load)
    plan = _with_load(file, point, places, put, cells)
    return replace(plan, blanks=(*asked, *plan.blanks))


def _with_load(
    file: FileGuess, point: ColumnGuess | None, places: Mapping[str, Entry], put: Entry,
    cells: Sequence[ColumnGuess],
) -> LogPlan:  # fmt: skip
    rounds = by_rounds(cells)
    cells = next(iter(rounds.values()), cells)
    sides = {c.name.side for c in cells}
    side = sides.pop() if len(sides) == 1 else ""
    names = [_within(_as_written(name, c), side) for name, c in channel_names(cells).items()]
    read = [
        {f"{name}_counts": reading_entry(c) for name, c in zip(names, own, strict=True)}
        for own in (rounds.values() or [cells])
    ]
    labels = [c for c in file.of("label") if c.words and (not point or c.column != point.column)]
    repeats = [
        c for c in file.of("repeat")
        if c.values is not None and c is not point and np.unique(c.values).size < file.rows
    ]  # fmt: skip
    entries = {
        "foot": of(labels[0]) if labels else Entry(value=side or "foot", why="one foot"),
        "placement": of(point) if point else Entry(value="point", why="no name of the points"),
        **places,
        "load_n": put,
        **({"repeat": of(repeats[0])} if repeats and not rounds else {}),
        **times(file, needed=False)[0],
        **{name: e for name, e in extras(file).items() if name == "temperature_degc"},
        **(read[0] if not rounds else {}),
    }
    feet = labels[0].words if labels else (side or "foot",)
    forces = all(c.unit in FORCES for c in cells)  # what they are off by, placements show
    return LogPlan(
        file, "a known weight over known holes of a foot", "holes, a load and readings", "likely",
        "offline-fit", "placements", entries, channels_of(feet, names),
        dict(zip(rounds, read, strict=False)), "repeat" if rounds else "channel",
        robot=(IN_NEWTON,) * forces,
        blanks=(where_cells(feet, names), *(WEIGHTS,) * (not forces)),
    )  # fmt: skip


def channels_of(feet: Sequence[str], cells: Sequence[str]) -> tuple[str, ...]:
    """Channels of feet that have cells of the same names."""
    return tuple(f"{foot}_{cell}" for foot in feet for cell in cells)


def where_cells(feet: Sequence[str], cells: Sequence[str]) -> Blank:
    """Where the cells of each foot sit, to be filled in."""
    lines = []
    for foot in feet:
        lines.append(f"# [robot.feet.{foot}.cells]    # x forward, y left, from the foot's origin")
        lines += [f"# {cell} = {{ x_m = , y_m =  }}" for cell in cells]
    return Blank(tuple(lines), WHERE)


def _as_written(name: str, cell: ColumnGuess) -> str:
    """A cell's name; that of its column where the name is but its number: ``s1`` of ``S1_mV``."""
    stem = slug(split_unit(cell.column)[0])
    if cell.name.side and cell.name.owner and not cell.name.place:
        return stem  # kakato_hidari is no more than left by its side
    number = name.removeprefix("cell_").isdigit() or name.replace("_", "") == stem
    return stem if number else name


def _within(name: str, side: str) -> str:
    """A cell's name within the one foot that all cells are of."""
    plain = without_side(name, side).removeprefix("foot_") if side else name
    return plain or name


def one_place_each(column: ColumnGuess, hole_m: FloatArray) -> bool:
    """Whether rows of one name or number are of one hole (n, 2), and the holes several."""
    named = column.values if column.codes is None else column.codes
    _, first, group = np.unique(
        numbers_of(column) if named is None else named, return_index=True, return_inverse=True
    )
    return first.size > 1 and np.array_equal(hole_m[first][group.ravel()], hole_m)


def _on_holes(
    file: FileGuess, load: ColumnGuess, cells: Sequence[ColumnGuess]
) -> ColumnGuess | None:
    """The column of the holes as words; None where no column says on which the load stood.

    With the load it explains all readings, which the load alone does not; where every hole was
    loaded once, it is the column that is called a hole.
    """
    put = numbers_of(load)
    if any(numbers_of(c).size != put.size for c in cells) or one_cell_moves(load, cells):
        return None
    if sum(straightness(put, numbers_of(c)) > _FOLLOWS for c in cells) > 1:
        return None
    best, most = None, _EXPLAINED
    for column in file.columns:
        label = as_label(column) if column.column != load.column else None
        others = [c for c in cells if c.column != column.column]  # numbers look like readings
        if label is None or len(label.words) < _LEAST or len(others) < _LEAST:
            continue
        if followers(load, label, others) or named_alike(label.words, others):
            continue
        shares = [_explained(put, numbers_of(c), codes_of(label)) for c in others]
        once = column.quantity == "placement" and not np.isfinite(shares).any()
        if once and best is None:
            best = label
        elif min(shares) > most:
            best, most = label, min(shares)
    return best


def _explained(load: FloatArray, read: FloatArray, codes: IntArray) -> float:
    """Share of a reading's variance that ``b + s_h F`` explains, for its degrees of freedom.

    NaN where there are as many unknowns as rows.
    """
    good: BoolArray = np.isfinite(load) & np.isfinite(read)
    slopes = [np.where(codes == at, load, 0.0)[good] for at in np.unique(codes)]
    table = np.column_stack([np.ones(int(good.sum())), *(s for s in slopes if s.any())])
    free = len(table) - table.shape[1]
    spread = float(np.var(read[good], ddof=1)) if len(table) > 1 else 0.0
    if free <= 0 or spread == 0.0:
        return float("nan")
    left = read[good] - table @ np.linalg.lstsq(table, read[good], rcond=None)[0]
    return float(1.0 - left @ left / free / spread)


def _always_empty(label: ColumnGuess, load: FloatArray) -> set[str]:
    """Words of rows in which nothing lay on the foot: ``-``, ``0``."""
    codes = codes_of(label)
    return {w for at, w in enumerate(label.words) if not np.nan_to_num(load[codes == at]).any()}
