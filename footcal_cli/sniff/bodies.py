r"""The body's stream of a walk by what its numbers do, whatever its columns are called.

Room: sniff; asked by walking.

A foot stands for long stretches, moves between them and is higher then. The CoM lies above all
feet. With bumps :math:`\varphi` of half a second that end at zero,

.. math:: \varphi * \dot p = \dot\varphi * p, \qquad \varphi * \ddot p = \ddot\varphi * p

tell which columns are the velocity and the acceleration of a place :math:`p`, and in which unit.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.parameters import BoolArray, FloatArray
from footcal_cli.core.spatial import headings
from footcal_cli.sniff.body_columns import foot_names, length_unit, of_the_com, of_the_feet
from footcal_cli.sniff.foot_angles import angle_unit, angles_beside, headings_beside, with_tilts
from footcal_cli.sniff.groups import wrenches
from footcal_cli.sniff.guesses import FileGuess, looked_at_joined, seconds_of
from footcal_cli.sniff.names import COMMANDED, words_of
from footcal_cli.sniff.triples import (
    Axes,
    angles,
    axes_of,
    frames_of,
    matrices,
    quaternions,
    rotations,
)
from footcal_cli.sniff.units import LENGTHS, metres_per
from footcal_cli.sniff.unnamed import unnamed
from footcal_cli.tables.world import TO_Z_UP, WorldUp

_UP: tuple[WorldUp, ...] = ("+z", "+y", "-z")
"""Worlds that are tried in turn."""
GRID_S = 0.01
"""Step of the grid on which streams of one walk are compared."""
_BUMP_S = 0.25
_REACH_S, _STANDS = 0.1, 0.1
"""A foot stands where it moves in so long by less than this share of its fastest step."""
_MOSTLY_STANDS, _LIFTED, _TRAVELS_M = 0.4, 0.3, 0.1
_ABOVE_M, _BESIDE = 0.05, 1.0
"""How far the CoM lies above each foot, and off their middle at most: shares of its height."""
_FOLLOWS, _FREE_MPS2, _SAME_STEPS = 0.9, 2.0, 0.9
_CENTRED, _HALF = 0.5, 0.5
_CLEARLY, _PIECES = 0.7, 20
"""What of a heading in degrees is across the feet, of what is in radians: straight on, both are."""
_ACCELERATIONS = {"m/s^2": 1.0, "mm/s^2": 1e3, "cm/s^2": 1e2, "in/s^2": 1 / 0.0254,
                  "ft/s^2": 1 / 0.3048, "g0": 1 / 9.80665}  # fmt: skip
_SPEEDS = {"m/s": 1.0, "mm/s": 1e3, "cm/s": 1e2, "in/s": 1 / 0.0254, "ft/s": 1 / 0.3048}
_NMS = re.compile(
    r"(?i)\bN[ .*·]?m[ .*·]?s\b|\bkg[ .*·]?m(?:\^?2|²)[ .*·]?(?:/ ?s|s(?:\^?-1|⁻¹))(?![\^²2])"
)
"""The unit of an angular momentum, of which the rate in Nm is what moves the CoP."""
_MOMENTUM = "an angular momentum; its rate, in Nm, would count"
_BY_COLUMNS = re.compile(
    r"(?i)column[- ]?(?:major|wise|by)|by columns|spaltenweise|par colonnes|por colu(?:n|mn)as|"
    r"(?:per|di) colonne|kolonnevis|kolumnvis|kolumnami|po sloupc|oszlopon|oszlopfolytonos|sütun|"
    r"по столбцам|列優先|列ごと|按列"
)
"""A matrix written column by column."""
_MOMENTS = ("Nm", "N*m", "N*mm")
_SPOKEN = ("ldot", "hdot", "angmom", "momentum", "drall", "drehimpuls", "undouryou", "amrate",
           "angular", "dh", "dl")  # fmt: skip
"""Parts of names of an angular momentum or its rate."""


@dataclass(frozen=True)
class BodyLog:
    """A body's stream.

    Parameters
    ----------
    file
        The log, its columns of the motion taken for that.
    at_s
        An even grid of times, shape (n,).
    swings
        Foot -> where it moves, shape (n,).
    stems
        Foot -> what stands before the axis in the names of its place.
    """

    file: FileGuess
    at_s: FloatArray
    swings: Mapping[str, BoolArray]
    stems: Mapping[str, str]


@dataclass(frozen=True)
class _Moving:
    """A vector on the grid, shape (n, 3), and its integrals with the bump and its derivatives."""

    axes: Axes
    values: FloatArray
    smooth: tuple[FloatArray, FloatArray, FloatArray]


def body_of(file: FileGuess) -> BodyLog | None:
    """The body's stream in a log; None where there is no CoM above two feet or more that step.

    Of several files each column is called after its own.
    """
    bodies: list[BodyLog] = []

    def look(called: FileGuess) -> FileGuess | None:
        body = _body_of(called)
        bodies.extend([body] if body else [])
        return body.file if body else None

    found = looked_at_joined(file, look)
    return replace(bodies[0], file=found) if found else None


def _body_of(file: FileGuess) -> BodyLog | None:
    clock = file.of("time")
    seconds = seconds_of(clock[0]) if clock else None
    if seconds is None or not np.isfinite(seconds).any() or np.ptp(seconds) < 4 * _BUMP_S:
        return None
    named = [c for c in file.columns if c.values is not None and c is not clock[0]]
    felt = {c.column for axes in wrenches(file).values() for c in axes.values()}
    felt |= {c.column for c in file.of("cop")}
    named = [
        c for c in named if c.column not in felt and not COMMANDED & set(words_of(c.column))
    ]  # fmt: skip
    vectors = axes_of(named)
    four = quaternions(named, vectors)
    in_order, frames_in_order = unnamed(named)
    vectors = [*vectors, *in_order]
    by_columns = any(_BY_COLUMNS.search(line) for line in file.text.above)
    nine = matrices(named, by_columns=by_columns)
    turned = [*four, *nine, *angles(named, file.text.above), *frames_in_order]
    at = np.arange(seconds.min(), seconds.max(), GRID_S)
    logged = [
        moved for axes in vectors
        if axes not in four and (moved := _on(at, seconds, axes)) is not None
    ]  # fmt: skip
    for turn in (TO_Z_UP[up] for up in _UP):
        moving = [_turned(moved, turn) for moved in logged]
        feet = _feet(moving)
        if len(feet) > 1 and (com := _com(moving, feet)) is not None:
            break
    else:
        return None
    others = [m for m in moving if m is not com and m not in feet]
    length = length_unit(com.values[:, 2])
    in_metres = _times(com, metres_per(length))
    roles = {"com": com, **_derivatives(in_metres, others)}
    placed = {c.column for m in (com, *feet) for c in m.axes.columns.values()}
    turned = [t for t in turned if not placed & {c.column for c in t.columns.values()}]
    frames = frames_of([f.axes for f in feet], turned)
    vectored = {c.column for axes in vectors for c in axes.columns.values()}
    spare_columns = [c for c in named if c.column not in vectored]
    swings = [np.interp(seconds, at, _steps(f)) > _HALF for f in feet]
    if not frames:
        frames = dict(enumerate(angles_beside([f.axes for f in feet], swings, spare_columns)))
    if not frames:
        frames = headings_beside([f.axes for f in feet], spare_columns, swings)
    frames = {i: with_tilts(axes, swings[i], spare_columns) for i, axes in frames.items()}
    used = {c.column for m in roles.values() for c in m.axes.columns.values()}
    used |= {c.column for axes in frames.values() for c in axes.columns.values()}
    spare = [m for m in others if m.axes.columns["x"].column not in used]
    momenta = [m for m in spare if _is_momentum(m, file.text.above)]
    if (rate := _momentum_rate(com, spare, file.text.above)) is not None:
        roles["rate"] = rate
    elif len(momenta) == 1:
        roles["momentum"] = momenta[0]
    middle = np.mean([f.values[:, :2] for f in feet], axis=0)
    way = np.interp(seconds, at, middle[:, 0]) + 1j * np.interp(seconds, at, middle[:, 1])
    read = {
        i: angle_unit(axes, way, file.text.above)
        for i, axes in frames.items()
        if "yaw" in axes.columns
    }
    units = {i: read[i][0] if i in read else "" for i in frames}
    heading = None
    if 0 in frames:
        heading = np.unwrap(np.nan_to_num(headings(turn @ rotations(frames[0], units[0]))))
        heading = np.interp(at, seconds, heading)
    names = foot_names([f.axes.before for f in feet], [f.values for f in feet], heading)
    columns = of_the_com({role: m.axes for role, m in roles.items()}, length=length)
    columns |= of_the_feet([f.axes for f in feet], names, frames, read, length=length)
    left = {c.column for m in others for c in m.axes.columns.values()}
    left |= {c.column for axes in turned for c in axes.columns.values()}
    left -= {c.column for c in file.of("force")}
    other = {c.column for m in momenta for c in m.axes.columns.values()}
    marked = replace(file, columns=tuple(
        columns[c.column] if c.column in columns
        else c.as_quantity("other", "likely", _MOMENTUM) if c.column in left & other
        else c.as_quantity("other", "likely", "of the body's motion") if c.column in left else c
        for c in file.columns
    ))  # fmt: skip
    steps = {n: _steps(f) for n, f in zip(names, feet, strict=True)}
    stems = {n: f.axes.before for n, f in zip(names, feet, strict=True)}
    return BodyLog(marked, at, steps, stems)


def _on(at: FloatArray, seconds: FloatArray, axes: Axes) -> _Moving | None:
    """A vector on the grid, places in m; None where it has no numbers or never moves."""
    values = axes.values("xyz")
    values = values * metres_per(axes.columns["x"].unit)
    good = np.isfinite(values).all(axis=1) & np.isfinite(seconds)
    if good.sum() < len(values) / 2:
        return None
    order = np.argsort(seconds[good], kind="stable")
    then = seconds[good][order]
    grid = np.stack([np.interp(at, then, v[good][order]) for v in values.T], axis=1)
    if not np.any(np.ptp(grid, axis=0) > 0):
        return None
    half = round(_BUMP_S / GRID_S)
    s = np.arange(-half, half + 1) / half
    bumps = (
        (1 - s**2) ** 4,
        -8 * s * (1 - s**2) ** 3 / _BUMP_S,
        (-8 * (1 - s**2) ** 3 + 48 * s**2 * (1 - s**2) ** 2) / _BUMP_S**2,
    )
    centred = grid - grid.mean(axis=0)
    smooth = tuple(
        np.stack([np.convolve(v, bump, mode="valid") for v in centred.T], axis=1) for bump in bumps
    )
    return _Moving(axes, grid, (smooth[0], smooth[1], smooth[2]))


def _is_place(moved: _Moving) -> bool:
    unit = moved.axes.columns["x"].unit
    return unit is None or unit in LENGTHS


def _steps(moved: _Moving) -> BoolArray:
    """Where a place moves as in a step, shape (n,)."""
    reach = round(_REACH_S / GRID_S)
    far = np.zeros(len(moved.values))
    apart = np.linalg.norm(moved.values[reach:] - moved.values[:-reach], axis=1)
    far[reach // 2 : reach // 2 + apart.size] = apart
    return np.asarray(far > _STANDS * np.quantile(far, 0.98))


def _feet(moving: Sequence[_Moving]) -> list[_Moving]:
    """Places that mostly stand, and are higher while they move; of two alike the lower."""
    found: list[tuple[_Moving, BoolArray]] = []
    for moved in moving:
        steps, place = _steps(moved), moved.values
        travelled = float(np.max(np.ptp(place[:, :2], axis=0)))
        if not _is_place(moved) or not _MOSTLY_STANDS < 1.0 - steps.mean() < 1.0:
            continue
        if not travelled > _TRAVELS_M or np.ptp(place[:, 2]) == 0.0:
            continue
        if np.corrcoef(steps, place[:, 2])[0, 1] > _LIFTED:
            found.append((moved, steps))
    found.sort(key=lambda one: float(np.median(one[0].values[:, 2])))
    feet: list[tuple[_Moving, BoolArray]] = []
    for moved, steps in found:
        if all(np.corrcoef(steps, own)[0, 1] < _SAME_STEPS for _, own in feet):
            feet.append((moved, steps))
    own = [moved for moved, _ in feet]
    return [moved for moved in moving if moved in own]


def _com(moving: Sequence[_Moving], feet: Sequence[_Moving]) -> _Moving | None:
    """The place above all feet; of several the one that is called so, or whose acceleration is."""
    ground = np.stack([f.values for f in feet], axis=1)
    found = []
    for moved in moving:
        if moved in feet or not _is_place(moved):
            continue
        height = np.quantile(moved.values[:, 2, None] - ground[..., 2], 0.02)
        aside = np.linalg.norm(moved.values[:, :2] - ground[..., :2].mean(axis=1), axis=1)
        if height > _ABOVE_M and np.median(aside) < _BESIDE * height:
            found.append(moved)

    def rank(moved: _Moving) -> tuple[bool, bool]:
        called = {c.quantity for c in moved.axes.columns.values()} == {"com"}
        return called, "acc" in _derivatives(moved, [m for m in moving if m not in found])

    return max(found, key=rank) if found else None


def _ratio(given: FloatArray, derived: FloatArray) -> tuple[float, float]:
    """Slope and correlation of one vector on another."""
    given, derived = ((v - v.mean(axis=0))[:, :2].ravel() for v in (given, derived))
    size = float(np.sqrt((given @ given) * (derived @ derived)))
    if not size > 0:
        return 0.0, 0.0
    return float(given @ derived) / float(derived @ derived), float(given @ derived) / size


def _derivatives(com: _Moving, others: Sequence[_Moving]) -> dict[str, _Moving]:
    """Velocity and acceleration of a place, gravity not included, among other vectors."""
    found = {}
    for role, order, units in (("vel", 1, _SPEEDS), ("acc", 2, _ACCELERATIONS)):
        best = _FOLLOWS
        for moved in others:
            slope, alike = _ratio(_bare(moved).smooth[0], com.smooth[order])
            unit = min(units, key=lambda u: abs(np.log(max(abs(slope), 1e-9) / units[u])))
            mean = np.abs(_bare(moved).values.mean(axis=0)).max() / units[unit]
            if alike > best and (role == "vel" or mean < _FREE_MPS2):
                best = alike
                said = None if units[unit] == 1.0 else unit
                own = {a: replace(c, unit=said) for a, c in moved.axes.columns.items()}
                found[role] = replace(moved, axes=replace(moved.axes, columns=own))
    return found


def _bare(moved: _Moving) -> _Moving:
    """A vector as its numbers are written: ``_m`` behind a speed is no unit of its own."""
    return _times(moved, 1.0 / metres_per(moved.axes.columns["x"].unit))


def _turned(moved: _Moving, turn: FloatArray) -> _Moving:
    """A vector in a world that is turned so, (3, 3)."""
    smooth = moved.smooth
    return replace(moved, values=moved.values @ turn.T, smooth=(
        smooth[0] @ turn.T, smooth[1] @ turn.T, smooth[2] @ turn.T,
    ))  # fmt: skip


def _times(moved: _Moving, scale: float) -> _Moving:
    """A vector whose numbers are so many times as large."""
    smooth = moved.smooth
    return replace(moved, values=moved.values * scale, smooth=(
        smooth[0] * scale, smooth[1] * scale, smooth[2] * scale,
    ))  # fmt: skip


def _is_momentum(moved: _Moving, above: Sequence[str]) -> bool:
    """Whether a vector is an angular momentum itself, in Nm s, by its name or a line above."""
    column, stem = moved.axes.columns["x"], moved.axes.before.strip("_. [(")
    called = [word for word in (stem if len(stem) > 1 else "", column.column) if word]
    lines = [x for x in above if any(_names(word, x) for word in called)]
    return any(_NMS.search(line) for line in (column.column, *lines))


def _names(word: str, line: str) -> bool:
    """Whether a line speaks of a column or its stem, which is no part of another word."""
    return re.search(rf"(?<![^\W_]){re.escape(word)}(?![^\W_])", line) is not None


def _momentum_rate(com: _Moving, others: Sequence[_Moving], above: Sequence[str]) -> _Moving | None:
    """The rate of an angular momentum: in Nm or called so, else the one vector that is left over.

    It is zero on average, and follows neither the velocity nor the acceleration of the CoM.
    """
    left = []
    for moved in others:
        if _is_momentum(moved, above):
            continue
        column, values = moved.axes.columns["x"], moved.values
        said = column.unit in _MOMENTS or any(word in column.column.lower() for word in _SPOKEN)
        centred = bool(np.all(np.abs(values.mean(axis=0)) < _CENTRED * values.std(axis=0)))
        alike = max(abs(_ratio(moved.smooth[0], com.smooth[i])[1]) for i in (1, 2))
        other = column.unit not in (None, *_MOMENTS) or column.quantity in ("force", "acceleration")
        if centred and (said or not (other or alike > _FOLLOWS)):
            left.append((said, moved))
    called = [moved for said, moved in left if said]
    for moved in called:  # of an angular momentum and its rate the rate is taken
        if any(
            _ratio(moved.smooth[0], m.smooth[1])[1] > _FOLLOWS for m in called if m is not moved
        ):
            return moved
    if called:
        return called[0]
    return left[0][1] if len(left) == 1 else None
