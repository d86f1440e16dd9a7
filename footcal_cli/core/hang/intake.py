"""Columns of a hanging log, in long form, to one log per leg."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from footcal_cli.core.effects.calibration import AXES
from footcal_cli.core.hang.runs import LEVEL
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import BoolArray, FloatArray

_TURN_SHARE = 1.0 / 8.0
_POLYNOMIAL = 4
_FEWEST = 9
_GAP = 3.0
_TURNS = 0.5
"""A shaft that moves less than this in a recording is not a turning one."""


def shaft_motion(
    time_s: FloatArray, phase_rad: FloatArray, starts: BoolArray | None = None
) -> tuple[FloatArray, FloatArray]:
    """Speed (rad/s) and acceleration (rad/s²) of a shaft, each (n,).

    Local polynomials of fourth order over an eighth of a turn (Savitzky and Golay, Anal. Chem. 36,
    1964): short against the turn, long against the steps of an encoder. Zero where a stretch is
    too short, does not turn, or its stamps do not increase.

    Parameters
    ----------
    time_s, phase_rad
        Stamps and shaft angles, shape (n,); angles may wrap.
    starts
        Rows with which a new recording begins, shape (n,); gaps in the stamps begin one too.
    """
    speed, acceleration = np.zeros(time_s.size), np.zeros(time_s.size)
    if time_s.size < _FEWEST:
        return speed, acceleration
    step = np.diff(time_s)
    usual = float(np.median(step[step > 0.0], axis=0)) if np.any(step > 0.0) else 0.0
    broken = (step <= 0.0) | (step > _GAP * usual)
    if starts is not None:
        broken |= starts[1:]
    for rows in np.split(np.arange(time_s.size), np.flatnonzero(broken) + 1):
        if rows.size >= _FEWEST:
            speed[rows], acceleration[rows] = _stretch(time_s[rows], phase_rad[rows])
    return speed, acceleration


def _stretch(time_s: FloatArray, phase_rad: FloatArray) -> tuple[FloatArray, FloatArray]:
    phase = np.unwrap(phase_rad)
    turns = abs(phase[-1] - phase[0]) / (2.0 * np.pi)
    if turns < _TURNS:
        return np.zeros(time_s.size), np.zeros(time_s.size)
    from scipy.signal import savgol_filter

    even = np.linspace(time_s[0], time_s[-1], time_s.size)
    period = even[1] - even[0]
    span = int(_TURN_SHARE * time_s.size / turns) // 2 * 2 + 1
    span = min(max(span, _FEWEST), (time_s.size - 1) // 2 * 2 + 1)
    resampled = np.interp(even, time_s, phase)
    speed, acceleration = (
        np.interp(
            time_s, even, savgol_filter(resampled, span, _POLYNOMIAL, deriv=order, delta=period)
        )
        for order in (1, 2)
    )
    return speed, acceleration


Texts = NDArray[np.object_] | NDArray[Any]

ORIENTATIONS: dict[str, FloatArray] = {
    f"{sign}{axis}": (1.0 if sign == "+" else -1.0) * np.eye(3)[i]
    for i, axis in enumerate("xyz")
    for sign in "+-"
}
"""``+x -x +y -y +z -z``: which axis points along gravity."""
_NAMED = re.compile(r"(?P<sign>[+-]?)(?P<axis>[xyz])(?:[ _]+(?P<sense>down|up))?")


STILL_RAD = 0.01
"""Angle within which an attitude counts as held: noise of an IMU, not a movement."""


SHORT = 0.2
"""Share of the length of a hold below which equal directions are a movement."""
_FEWEST_HELD, _FEWEST_HOLDS, _LEFT_OF_SPREAD = 20, 4, 0.5


def gravity_of_orientation(
    orientation: Texts, rot_bt: FloatArray | None = None
) -> tuple[FloatArray, tuple[str, ...]]:
    """Nominal direction of gravity in the transducer frame (n, 3), and words nobody knows.

    Parameters
    ----------
    orientation
        Names of `ORIENTATIONS`, shape (n,): the axis along gravity. ``+x down`` is the same as
        ``+x``, ``+x up`` the opposite; ``x_up`` is ``+x up``.
    rot_bt
        Where the names mean *body* axes: the leg's nominal rotation transducer to body, (3, 3).
        A transducer turned by π about z then reads −x where its neighbours read +x.
    """
    names, place = np.unique(orientation.astype(str), return_inverse=True)
    found = [_along(name) for name in names]
    unknown = tuple(name for name, axis in zip(names, found, strict=True) if axis is None)
    axes = np.stack([np.full(3, np.nan) if axis is None else axis for axis in found])
    if rot_bt is not None:
        axes = axes @ rot_bt
    return np.asarray(axes[place.ravel()]), unknown


def _along(name: str) -> FloatArray | None:
    """Direction of gravity that a name states: ``+x``, ``-z down``, ``+y up``, ``z_up``."""
    found = _NAMED.fullmatch(name.strip().lower())
    if found is None or not (found["sign"] or found["sense"]):
        return None
    axis = ORIENTATIONS[f"{found['sign'] or '+'}{found['axis']}"]
    return -axis if found["sense"] == "up" else axis


def held_still(direction: FloatArray) -> FloatArray:
    """Measured directions of gravity with the noise within a hold averaged, unit vectors (n, 3).

    A hold lasts as long as rows stay within `STILL_RAD` of the mean of the hold so far; a
    direction that turns is cut into steps of that size. Rows that are not numbers stay so.

    Parameters
    ----------
    direction
        Shape (n, 3), of any length.
    """
    size = np.linalg.norm(direction, axis=1, keepdims=True)
    unit = direction / np.where(size > 0, size, np.nan)
    found = unit.copy()
    good = np.flatnonzero(np.isfinite(unit).all(axis=1))
    start, total, far = 0, np.zeros(3), (2.0 * np.sin(STILL_RAD / 2)) ** 2
    for at, row in enumerate(good):
        gap = unit[row] - total / np.linalg.norm(total) if at > start else np.zeros(3)
        if gap @ gap > far:
            found[good[start:at]] = total / np.linalg.norm(total)
            start, total = at, np.zeros(3)
        total = total + unit[row]
    if good.size:
        found[good[start:]] = total / np.linalg.norm(total)
    return found


def between_holds(direction: FloatArray) -> NDArray[np.bool_]:
    """Which rows lie between two holds of a measured attitude, shape (n,).

    A quarter of all rows lies in runs of equal direction at least as long as L; runs shorter than
    `SHORT` L are movements, during which inertia adds to the weight. None is, where the directions
    that would remain determine less: an attitude that turns all the time has no holds.

    Parameters
    ----------
    direction
        As `held_still` returns it, shape (n, 3).
    """
    good = np.flatnonzero(np.isfinite(direction).all(axis=1))
    moves = np.zeros(len(direction), dtype=bool)
    if good.size < _FEWEST_HELD:
        return moves
    changed = np.any(direction[good[1:]] != direction[good[:-1]], axis=1)
    run = np.concatenate([[0], np.cumsum(changed)])
    length = np.bincount(run)[run]
    short = length < SHORT * np.quantile(length, 0.75)
    kept = direction[good[~short]]
    if not short.any() or len(np.unique(kept, axis=0)) < _FEWEST_HOLDS:
        return moves
    if _spread(kept) < _LEFT_OF_SPREAD * _spread(direction[good]):
        return moves
    moves[good[short]] = True
    return moves


def _spread(direction: FloatArray) -> float:
    """How well directions (n, 3) tell weight from offset: their smallest standard deviation."""
    return float(np.sqrt(np.linalg.svd(np.cov(direction.T), compute_uv=False)[-1]))


def hang_log(
    leg: str,
    time_s: FloatArray,
    phase_rad: FloatArray,
    wrench: FloatArray,
    gravity_dir: FloatArray,
    *,
    leg_weight_n: float,
    temperature_degc: FloatArray | None = None,
    level_t: FloatArray | None = None,
) -> Log:
    """One leg's hanging log, rows in the order given; a block per nominal orientation.

    Parameters
    ----------
    time_s, phase_rad
        Shape (n,).
    wrench
        Readings, shape (n, 6), N and Nm.
    gravity_dir
        Nominal direction of gravity in the transducer frame, shape (n, 3).
    temperature_degc
        Shape (n,), where measured.
    level_t
        Horizontal axes of the attitude's world in the transducer frame, shape (n, 3, 2), if known.
    """
    rows = time_s.shape[0]
    changed = np.any(gravity_dir[1:] != gravity_dir[:-1], axis=1)
    speed, acceleration = shaft_motion(time_s, phase_rad, np.concatenate([[True], changed]))
    known = {
        "phase_rad": phase_rad,
        "gravity_dir": gravity_dir,
        "leg_weight_n": np.full(rows, leg_weight_n),
        "leg_com_m": np.zeros((rows, 3)),
        "shaft_radps": speed,
        "shaft_radps2": acceleration,
    }
    if temperature_degc is not None:
        known["temperature_degc"] = temperature_degc
    if level_t is not None:
        known[LEVEL] = level_t
    return Log(
        "hang",
        tuple(f"{leg}.{axis}" for axis in AXES),
        time_s,
        wrench,
        known,
        np.concatenate([[0], np.cumsum(changed)]).astype(np.int64),
    )


def finite_rows(*columns: FloatArray) -> NDArray[np.bool_]:
    """Rows in which every number is one, shape (n,)."""
    return np.asarray(
        np.logical_and.reduce([np.isfinite(c).reshape(c.shape[0], -1).all(axis=1) for c in columns])
    )


def legs_in_order(leg: Texts, wanted: Sequence[str] = ()) -> tuple[str, ...]:
    """Legs of a log: those wanted that are there, else in order of appearance."""
    present = tuple(dict.fromkeys(leg.astype(str).tolist()))
    return tuple(name for name in wanted if name in present) or present
