"""Cells under the feet of a walk: which foot each is under, by names or by when it carries nothing.

Room: sniff; asked by several.

A cell under a foot reads one value while that foot is in the air, and carries something else while
another one is.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.core.parameters import BoolArray, FloatArray
from footcal_cli.sniff.bodies import GRID_S, BodyLog, body_of
from footcal_cli.sniff.body_columns import differing_parts
from footcal_cli.sniff.feet_weighed import in_kilograms
from footcal_cli.sniff.file_loads import by_letters
from footcal_cli.sniff.frame_clocks import at_said_rate, with_frame_clocks
from footcal_cli.sniff.groups import bracketed_end, channel_names, readings, wrenches
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, seconds_of
from footcal_cli.sniff.names import NameGuess, common_start, name_guess
from footcal_cli.sniff.numbered import numbered
from footcal_cli.sniff.split_bodies import joined_body
from footcal_cli.sniff.stands import standing
from footcal_cli.sniff.units import split_unit

_EDGE_S = 0.08
"""Lag of a stream, and of what a landing stirs up, that is left out of each swing."""
_RESTS, _CLEARLY = 0.35, 0.5
"""Share of its range within which a cell stays while its foot is in the air, and of what it does
while another foot is."""
_LEAST = 20
_SERIAL = 3
"""Digits of a number that is no count of the cells of a foot."""


def walked(files: Sequence[FileGuess]) -> list[FileGuess]:
    """Logs with a body's stream recognised, and cells under the names of their feet."""
    files, bodies = _with_bodies(files)
    if not any(bodies):
        counted, seen = _with_bodies([at_said_rate(file) for file in files])
        files, bodies = (counted, seen) if any(seen) else (files, bodies)
    files = [
        standing(file) if body is None else body.file
        for file, body in zip(files, bodies, strict=True)
    ]
    files = [in_kilograms(file) for file in with_frame_clocks(files)]
    found = [body for body in bodies if body is not None]
    body = found[0] if len(found) == 1 else None
    cells = [
        (i, c) for i, file in enumerate(files)
        if file.of("time") and file.rows >= _LEAST and not file.of("load")
        and not wrenches(numbered(file))
        for c in readings(file)
    ]  # fmt: skip
    feet = _by_names([c for _, c in cells])
    known = body.swings.keys() if body is not None else {*feet}
    if not feet or not {*feet} <= known:
        by_stems, named = _of_the_stems(body.stems if body else _stems(files), cells)
        cells, feet = (by_stems, named) if named else (cells, feet)
    if body is not None and not (feet and {*feet} <= known):
        shares = _in_swings(body, files, cells)
        # what moves most while feet are in the air is of the body's motion, and no cell
        felt = [min(own.values(), default=0.0) < 1.0 for own in shares]
        cells = [own for own, is_cell in zip(cells, felt, strict=True) if is_cell]
        shares = [own for own, is_cell in zip(shares, felt, strict=True) if is_cell]
        feet = _as_the_feet(body, [c for _, c in cells]) or _by_steps(body, shares)
        called = channel_names([c for _, c in cells])
        if feet and all(n.startswith(f"{foot}_") for n, foot in zip(called, feet, strict=True)):
            return files  # their names say it already
    if not feet or (body is None and [c.name.side for _, c in cells] == feet):
        return files
    # a log of the feet in the air has the same cells
    once = {(c.column, foot): c for (_, c), foot in zip(cells, feet, strict=True)}
    if len(once) * len({i for i, _ in cells}) == len(cells):
        fresh = dict(zip(once, _named([*once.values()], [f for _, f in once]), strict=True))
        own = [fresh[c.column, foot] for (_, c), foot in zip(cells, feet, strict=True)]
    else:
        own = _named([c for _, c in cells], feet)
    made = {(i, c.column): replace(c, name=new.name)
            for (i, c), new in zip(cells, own, strict=True)}  # fmt: skip
    return [
        replace(file, columns=tuple(made.get((i, c.column), c) for c in file.columns))
        for i, file in enumerate(files)
    ]


def _with_bodies(files: Sequence[FileGuess]) -> tuple[Sequence[FileGuess], list[BodyLog | None]]:
    """Logs and the body's stream in each; several that are one stream together are one of them."""
    bodies = [body_of(file) for file in files]
    if not any(bodies):
        files = joined_body(files)
        bodies = [body_of(file) if file.joined else None for file in files]
    return files, bodies


def _by_names(cells: Sequence[ColumnGuess]) -> list[str]:
    """The foot of each cell by its name; empty where names do not say it of all cells.

    A side, a leg that several cells are called after (two legs FL and FR are a left and a right
    foot), or the first letters of left and right.
    """
    if sides := _sides(cells):
        return sides
    places = [c.name.place for c in cells]
    several = {p: places.count(p) for p in places}
    if all(places) and len(several) > 1 and min(several.values()) > 1:
        two = {"fl": "left", "fr": "right"} if several.keys() == {"fl", "fr"} else {}
        return [two.get(p, p) for p in places]
    heads, ends = _heads(cells)
    if len(ends) != 2:
        return []
    called = dict(zip(ends, by_letters([end[::-1] for end in ends]), strict=False))
    return [called[head] for head in heads] if called else []


def _heads(cells: Sequence[ColumnGuess]) -> tuple[list[str], list[str]]:
    """What stands before the number of each cell, and those that there are; none if not alike."""
    names = [split_unit(c.column)[0] for c in cells]
    names = [name.removesuffix(bracketed_end(names)) for name in names]
    heads = [re.sub(r"\W*\d*$", "", name) for name in names]
    ends = list(dict.fromkeys(heads))
    numbers = [name.removeprefix(h) for name, h in zip(names, heads, strict=True)]
    each = [sorted(n for n, h in zip(numbers, heads, strict=True) if h == end) for end in ends]
    alike = len(ends) > 1 and all(own == each[0] for own in each) and len(each[0]) > 1
    return (heads, ends) if alike else ([], [])


def _sides(cells: Sequence[ColumnGuess]) -> list[str]:
    sides = [c.name.side for c in cells]
    return sides if min(sides.count("left"), sides.count("right")) > 1 and all(sides) else []


def _as_the_feet(body: BodyLog, cells: Sequence[ColumnGuess]) -> list[str]:
    """The foot of each cell that is called by a word as one of the stream's feet: DE, TD."""
    found = []
    for cell in cells:
        words = re.split(r"[\W_]+", split_unit(cell.column)[0].lower())
        found.append([foot for foot in body.swings if foot in words])
    if not all(len(own) == 1 for own in found):
        return []
    feet = [own[0] for own in found]
    return feet if {*feet} == {*body.swings} else []


def _stems(files: Sequence[FileGuess]) -> dict[str, str]:
    """Foot -> what stands before the axis in the name of its place, of a body that stands."""
    ends = {"left_foot_x_m": "left", "right_foot_x_m": "right"}
    found = {
        ends[c.name.owner]: c.column for file in files for c in file.of("motion")
        if c.name.owner in ends
    }  # fmt: skip
    return found if len(found) == len(ends) else {}


def _of_the_stems(
    stems: Mapping[str, str], cells: Sequence[tuple[int, ColumnGuess]]
) -> tuple[list[tuple[int, ColumnGuess]], list[str]]:
    """Cells whose names differ as those of the feet do, and their feet."""
    heads = [re.sub(r"\W*\d*$", "", split_unit(c.column)[0]) for _, c in cells]
    several = [own for own, head in zip(cells, heads, strict=True) if heads.count(head) > 1]
    for kept in ([*cells], several) if stems else ():
        if feet := _by_stems(stems, [c for _, c in kept]):
            return kept, feet
    return [*cells], []


def _by_stems(stems: Mapping[str, str], cells: Sequence[ColumnGuess]) -> list[str]:
    """The foot of each cell whose name differs from those of the others as the feet's do.

    ``ar_kyt1`` and ``de_kyt1`` next to the places ``ar_podi_x`` and ``de_podi_x``.
    """
    heads, ends = _heads(cells)
    if len(ends) != len(stems):
        return []
    by_part = dict(zip(differing_parts(list(stems.values())), stems, strict=True))
    own = dict(zip(ends, differing_parts(ends), strict=True))
    called = {head: by_part[part] for head, part in own.items() if part in by_part}
    return [called[head] for head in heads] if len(called) == len(ends) else []


def _by_steps(body: BodyLog, shares: Sequence[Mapping[str, float]]) -> list[str]:
    """The foot of each cell by when it carries nothing; empty where that is not clear of all."""
    found = []
    for own in shares:
        if len(own) < len(body.swings):
            return []
        first, second = sorted(own, key=lambda foot: own[foot])[:2]
        if own[first] >= min(_RESTS, _CLEARLY * own[second]):
            return []
        found.append(first)
    return found if {*found} == {*body.swings} else []


def _in_swings(
    body: BodyLog, files: Sequence[FileGuess], cells: Sequence[tuple[int, ColumnGuess]]
) -> list[dict[str, float]]:
    """Of each cell foot -> how far it moves in that foot's swings, as a share of its range."""
    edge = round(_EDGE_S / GRID_S)
    swings = {foot: _eroded(moves, edge) for foot, moves in body.swings.items()}
    found = []
    for i, cell in cells:
        seconds = seconds_of(files[i].of("time")[0])
        found.append({} if seconds is None else _shares(seconds, cell, body.at_s, swings))
    return found


def _eroded(moves: BoolArray, edge: int) -> BoolArray:
    """Rows of a swing that lie so many rows inside of it, shape (n,)."""
    width = 2 * edge + 1
    return np.asarray(np.convolve(moves, np.ones(width), mode="same") > width - 0.5)


def _shares(
    seconds: FloatArray, cell: ColumnGuess, at_s: FloatArray, swings: Mapping[str, BoolArray]
) -> dict[str, float]:
    """Foot -> how far a reading moves in its swings, by its whole range; empty if not known."""
    values = np.full(0, np.nan) if cell.values is None else cell.values
    good = np.isfinite(values) & np.isfinite(seconds)
    if good.sum() < _LEAST:
        return {}
    then, read = seconds[good], values[good]
    there = (at_s >= then.min()) & (at_s <= then.max())
    grid = np.interp(at_s, then, read)
    whole = _range(grid[there])
    return {
        foot: _range(grid[there & moves]) / whole
        for foot, moves in swings.items() if whole > 0 and (there & moves).sum() >= _LEAST
    }  # fmt: skip


def _range(values: FloatArray) -> float:
    low, high = np.quantile(values, [0.1, 0.9]) if values.size else (0.0, 0.0)
    return float(high - low)


def _named(cells: Sequence[ColumnGuess], feet: Sequence[str]) -> list[ColumnGuess]:
    """Cells called by their foot and by what tells them apart there: ``lc_i1`` is left, 1."""
    if len({*feet}) == len(feet) > 2:  # a cell in the point of each
        return [replace(c, name=NameGuess("reading", side=foot, factor=c.name.factor))
                for c, foot in zip(cells, feet, strict=True)]  # fmt: skip
    names = [split_unit(c.column)[0] for c in cells]
    stems = [name.removesuffix(bracketed_end(names)) for name in names]
    groups = {foot: [s for s, own in zip(stems, feet, strict=True) if own == foot] for foot in feet}
    heads = {foot: _head(own) for foot, own in groups.items()}
    last = {foot: re.search(r"[^\W\d_]*$", head) for foot, head in heads.items()}
    words = {foot: found[0] if found else "" for foot, found in last.items()}
    apart = len({*words.values()}) == len(words) > 1
    rests = []
    for stem, foot in zip(stems, feet, strict=True):
        head = heads[foot] if apart else heads[foot].removesuffix(words[foot])
        tail = re.search(r"[\W_]\w*$", common_start([s[::-1] for s in groups[foot]])[::-1])
        rests.append(stem.removeprefix(head).removesuffix(tail[0] if tail else "").strip("_. -"))
    places = [name_guess(rest).place for rest in rests]
    own = [re.sub(r"[^a-z0-9]+", "_", rest.lower()).strip("_") for rest in rests]
    for called in (places, own, [str(i + 1) for i in range(len(cells))]):
        if all(called) and len({*zip(feet, called, strict=True)}) == len(cells):
            return [
                replace(c, name=NameGuess("reading", side=foot, place=name, factor=c.name.factor))
                for c, foot, name in zip(cells, feet, called, strict=True)
            ]  # fmt: skip
    return list(cells)


def _head(stems: Sequence[str]) -> str:
    """The letters that names begin with; of a serial number, as ``0412``, all digits are kept."""
    start = common_start(stems)
    number = re.match(r"\d+", stems[0][len(start.rstrip("0123456789")) :])
    serial = number is not None and len(number[0]) >= _SERIAL
    return start.rstrip("0123456789") if serial else start
