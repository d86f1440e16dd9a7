"""How a shaft turns: its speed and acceleration from sampled angles."""

from __future__ import annotations

import numpy as np
from scipy.signal import savgol_filter

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
