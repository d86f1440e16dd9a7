"""A foot's roll, pitch and yaw beside its place, and their unit: by name, size or the feet's way.

Room: sniff; asked by bodies.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from footcal_cli.core.parameters import BoolArray, FloatArray
from footcal_cli.sniff.guesses import ColumnGuess, numbers_of
from footcal_cli.sniff.names import words_of
from footcal_cli.sniff.triples import ROLL_PITCH_YAW, Axes
from footcal_cli.sniff.units import known_unit
from footcal_cli.sniff.vocabulary import ANGLES

_PARTS = 10
"""Parts of a walk whose directions are compared with the headings in them."""
_CLEARLY = 0.5
"""The right unit leaves so small a share of what the other leaves."""
_DEGREES = re.compile(r"(?i)[\[(]\s*(?:der|derece|gr|grd|st|stop|aste)\.?\s*[\])]")
"""Degrees as they are cut short behind an angle; ``der`` alone is a side, too."""
_SAID = re.compile(r"(?<![^\W\d])(?<!/)(?:[^\W\d_]+|°)(?!\w|/| ?[CF]\b)")
"""What may be a unit in a sentence; ``°C`` and ``rad/s`` are none of angles."""
_STEEPEST_RAD, _ALL_BUT = 1.3, 0.995
"""No sole rolls or pitches as far from how it stands, but in a few rows."""
_WHOLE_TURN_DEG, _LAGS, _FASTER = 360.0, 1000, 2.0
"""Largest angle; parts of a log over which a change is taken; how much faster swings are."""


def angles_beside(
    places: Sequence[Axes], swings: Sequence[BoolArray], columns: Sequence[ColumnGuess]
) -> list[Axes]:
    """Three more columns under the name of each foot's place: its roll, pitch and yaw, in order.

    They are no more than a turn, and move while the foot does: ``VF_x VF_y VF_z VF_rul VF_stamp
    VF_gir``. Empty unless all feet have the same three.

    Parameters
    ----------
    places
        Of each foot.
    swings
        Rows in which it moves, shape (n,) each.
    columns
        What may be angles.
    """
    found = []
    for place, moves in zip(places, swings, strict=True):
        own = {c.column for c in place.columns.values()}
        rest = [c for c in columns
                if c.column.startswith(place.before) and c.column not in own]  # fmt: skip
        if not place.before or len(rest) != len(ROLL_PITCH_YAW) or not _turn_with(rest, moves):
            return []
        three = dict(zip(ROLL_PITCH_YAW, rest, strict=True))
        found.append(Axes(place.before, "", three, f"{', '.join(ROLL_PITCH_YAW)} by their order"))
    tails = {tuple(c.column[len(axes.before) :] for c in axes.columns.values()) for axes in found}
    return found if len(tails) == 1 else []


def headings_beside(
    places: Sequence[Axes], columns: Sequence[ColumnGuess], swings: Sequence[BoolArray] = ()
) -> dict[int, Axes]:
    """Foot -> the one column of angles under the name of its place, whatever it is called: its yaw.

    Empty unless all feet have one.

    Parameters
    ----------
    swings
        Rows in which each foot moves, shape (n,): its angle changes faster then; none of a stand.
    """
    moves: Sequence[BoolArray | None] = swings or [None] * len(places)
    found = [_heading_beside(p, m, columns) for p, m in zip(places, moves, strict=True)]
    return {i: axes for i, axes in enumerate(found) if axes is not None and all(found)}


def _heading_beside(
    place: Axes, moves: BoolArray | None, columns: Sequence[ColumnGuess]
) -> Axes | None:
    known = {c.column for c in place.columns.values()}
    beside = [
        c for c in columns
        if place.before and c.column.startswith(place.before) and c.column not in known
        and not {"roll", "pitch"} & {ANGLES.get(word) for word in words_of(c.column)}
        and c.unit in (None, "rad", "deg") and not {*numbers_of(c).tolist()} <= {0.0, 1.0}
    ]  # fmt: skip
    if len(beside) != 1 or float(np.nanmax(np.abs(numbers_of(beside[0])))) > _WHOLE_TURN_DEG:
        return None
    if moves is not None and not _turn_with(beside, moves):
        return None
    return Axes(place.before, "", {"yaw": beside[0]}, "the one angle next to its place")


def with_tilts(frame: Axes, moves: BoolArray, columns: Sequence[ColumnGuess]) -> Axes:
    """A frame of which only the yaw is called so, or yaw and another, with those beside it.

    Their names differ from the yaw's by one word, and they are angles by their unit, or change
    faster while the foot moves. Pitch stands between yaw and roll: ``L_gier L_stamp L_rol``.
    """
    missing = [axis for axis in ROLL_PITCH_YAW if axis not in frame.columns]
    known = {c.column: axis for axis, c in frame.columns.items()}
    whole = rf"{re.escape(frame.before)}[^\W\d_]{{2,}}{re.escape(frame.after)}"
    three = [c for c in columns if re.fullmatch(whole, c.column)]
    rest = [c for c in three if c.column not in known]
    if "yaw" not in frame.columns or not frame.before or len(rest) != len(missing) or not rest:
        return frame
    unit = frame.columns["yaw"].unit
    if {c.unit for c in rest} != {unit} or not (unit or _turn_with(rest, moves)):
        return frame
    order = ROLL_PITCH_YAW if known.get(three[-1].column) == "yaw" else ROLL_PITCH_YAW[::-1]
    named = dict(zip(order, three, strict=True))
    if len(rest) == 1:
        named = {**frame.columns, missing[0]: rest[0]}
    if any(named[axis].column != c.column for axis, c in frame.columns.items()):
        return frame
    return replace(frame, columns=named, why=f"{' and '.join(missing)} by what stands next to it")


def _turn_with(three: Sequence[ColumnGuess], moves: BoolArray) -> bool:
    """Whether numbers are angles by size and unit, and change faster while a foot moves."""
    table = np.column_stack([numbers_of(c) for c in three])
    most = float(np.nanmax(np.abs(table), initial=0.0))
    if most > _WHOLE_TURN_DEG or any(c.unit not in (None, "rad", "deg") for c in three):
        return False
    reach = max(len(table) // _LAGS, 1)
    way = np.abs(table[reach:] - table[:-reach]).sum(axis=1)
    swing = moves[reach:] & moves[:-reach]
    good = np.isfinite(way)
    if not (good & swing).any() or not (good & ~swing).any():
        return False
    return bool(np.mean(way[good & swing]) > _FASTER * np.mean(way[good & ~swing]))


def angle_unit(
    axes: Axes, way: NDArray[np.complex128], above: Sequence[str] = ()
) -> tuple[str, str]:
    """Unit of a frame's angles, and by what; by nothing where it is a guess.

    Feet turn as the way turns that they go: of walks in the foot's own heading, the directions lie
    closer together if the heading was read in its unit.

    Parameters
    ----------
    axes
        Roll, pitch and yaw.
    way
        Where the feet are on the floor at the same rows, x + iy, shape (n,).
    above
        Lines above the table, and notes.
    """
    if (said := axes.columns["yaw"].unit) in ("rad", "deg"):
        return said, "its name"
    if said is None and _DEGREES.search(axes.after):
        return "deg", "its name"
    yaw = axes.values(["yaw"])[:, 0]
    tilts = [axes.values([a])[:, 0] for a in axes.columns if a != "yaw"]
    steep = [float(np.nanquantile(np.abs(t - np.nanmedian(t)), _ALL_BUT)) for t in tilts]
    if float(np.nanmax(np.abs(yaw))) > 2.0 * np.pi or max(steep, default=0.0) > _STEEPEST_RAD:
        return "deg", "its size"
    stem = axes.before.strip("_. [(").lower()
    own = [x for x in above if len(stem) > 1 and stem in x.lower()]
    called = [x for x in above if {*words_of(x)} & ANGLES.keys()]
    for lines in (own, called):
        units = {known_unit(word) for x in lines for word in _SAID.findall(x)} & {"deg", "rad"}
        if len(units) == 1:
            return str(units.pop()), "what is said of it above the table"
    rad, deg = (_apart(heading, way) for heading in (yaw, np.radians(yaw)))
    if min(rad, deg) < _CLEARLY * max(rad, deg):
        return ("rad" if rad < deg else "deg"), "how it turns with the way of the feet"
    return "rad", ""


def _apart(heading_rad: FloatArray, way: NDArray[np.complex128]) -> float:
    """How far ways lie apart as seen by who turns so: 1 less the length of their mean, 0 to 1."""
    good = np.flatnonzero(np.isfinite(heading_rad) & np.isfinite(way))
    if good.size < 2 * _PARTS:
        return 1.0
    parts = np.array_split(good, _PARTS)
    gone = np.array([way[own[-1]] - way[own[0]] for own in parts])
    seen = gone * np.exp(-1j * np.array([heading_rad[own].mean() for own in parts]))
    whole = float(np.abs(gone).sum())
    return 1.0 - float(abs(seen.sum())) / whole if whole > 0 else 1.0
