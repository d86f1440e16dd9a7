"""Noise of the online estimator's rows and random walks, and what keeps it sane."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np

from footcal_cli.core.parameters import BoolArray, FloatArray

_DEFAULT_WEIGHT_N = 53.0
"""Body weight of the robot that the default noise is meant for ([NAO]'s NAO)."""
_HARMONICS = np.arange(1, 200)
_SIGMA = np.linspace(0.0, 1.0, 101)
_KEPT = (
    np.sqrt(
        0.5
        * np.sum(np.exp(-4.0 * (np.pi * _HARMONICS * _SIGMA[:, None]) ** 2) / _HARMONICS**2, axis=1)
    )
    / np.pi
)
_SCATTER = _SIGMA**2 + 1.0 / 12.0 - _KEPT**2
"""For noise `_SIGMA` in steps: rounding that lasts, and variance of what is shown."""


@dataclass(frozen=True)
class WalkNoise:
    """Noise of the rows and of the random walks; every field a scalar or shape (settings,).

    Parameters
    ----------
    force_n, moment_nm
        White part of the totals' error, per block, beside the cells' own noise.
    force_slow_n, moment_slow_nm
        Stationary sd of its correlated part.
    force_slow_s, moment_slow_s
        Correlation times of the correlated part.
    sole_m
        Sd of how far a sole stands from where the joints have it, drawn anew in each stance.
    jitter_s
        Sd of what the stamps of the body stream are wrong by, per block.
    swing_n
        White noise of each cell, per block; seen in swing, and in the totals all the time.
    swing_slow_n, swing_slow_s
        Sd and correlation time of the cell's own slow noise, likewise.
    swing_fixed_n, swing_fixed_s
        Sd of an error that a swinging cell keeps from swing to swing (`kept_rounding_n`).
    gain_walk, bias_walk_n
        Random walk of each gain (1/√s) and bias (N/√s).
    state_walk
        Random walk of every other state, in prior sd per √s.
    """

    force_n: FloatArray | float = 0.1
    moment_nm: FloatArray | float = 0.02
    force_slow_n: FloatArray | float = 0.1
    moment_slow_nm: FloatArray | float = 0.03
    force_slow_s: FloatArray | float = 0.2
    moment_slow_s: FloatArray | float = 0.2
    sole_m: FloatArray | float = 1e-3
    jitter_s: FloatArray | float = 1e-3
    swing_n: FloatArray | float = 0.1
    swing_slow_n: FloatArray | float = 0.05
    swing_slow_s: FloatArray | float = 0.5
    swing_fixed_n: FloatArray | float = 0.0
    swing_fixed_s: FloatArray | float = 15.0
    gain_walk: FloatArray | float = 2e-4
    bias_walk_n: FloatArray | float = 0.01
    state_walk: FloatArray | float = 0.01

    def stacked(self) -> FloatArray:
        """All fields, shape (settings, fields)."""
        values = np.broadcast_arrays(*[np.atleast_1d(getattr(self, f.name)) for f in fields(self)])
        return np.stack(values, axis=-1)

    def for_weight(self, weight_n: float) -> WalkNoise:
        """The same noise for a robot of another weight, forces and moments in proportion."""
        factor = weight_n / _DEFAULT_WEIGHT_N
        scaled = [f.name for f in fields(self) if f.name.endswith(("_n", "_nm"))]
        return replace(self, **{n: np.asarray(getattr(self, n)) * factor for n in scaled})

    @classmethod
    def of(cls, stacked: FloatArray) -> WalkNoise:
        """The inverse of `stacked`; a single setting (fields,) gives scalars."""
        names = [f.name for f in fields(cls)]
        if stacked.ndim == 1:
            return cls(**{n: float(v) for n, v in zip(names, stacked, strict=True)})
        return cls(**dict(zip(names, stacked.T, strict=True)))


@dataclass(frozen=True)
class Guards:
    """What keeps the filter sane.

    Parameters
    ----------
    huber
        Innovations beyond this many sd are weighed down to it; ``inf`` for none.
    least_gain_nats
        An update whose information about z is below this changes nothing.
    jump_threshold
        Twice the log likelihood ratio at which a bias jump is believed; ``inf`` for none.
    least_jump_n
        Smaller jumps are left to the random walk.
    jump_memory_s
        How far back the onset of a jump is looked for.
    """

    huber: float = 3.0
    least_gain_nats: float = 1e-3
    jump_threshold: float = 30.0
    least_jump_n: float = 0.5
    jump_memory_s: float = 2.0

    def without_jumps(self) -> Guards:
        """The same, looking for none."""
        return replace(self, jump_threshold=np.inf)


def starting_noise(raw_n: FloatArray, idle: BoolArray, weight_n: float) -> WalkNoise:
    """Where learning begins: the default for the robot's weight, and the converter's rounding.

    Parameters
    ----------
    raw_n
        Readings in newtons, not filtered, shape (n, c).
    idle
        Where the foot of each cell is in the air, shape (n, c).
    """
    return replace(WalkNoise().for_weight(weight_n), swing_fixed_n=kept_rounding_n(raw_n, idle))


def kept_rounding_n(raw_n: FloatArray, idle: BoolArray) -> float:
    """Sd of the rounding error that an unloaded cell keeps until its bias has drifted on.

    A cell at rest shows one step of its converter and errs by up to half of it; noise of a
    fraction of a step averages most of that out: the mean error at a place φ within the step q is
    ``q/π Σ (−1)ᵏ/k exp(−2 π² k² σ²/q²) sin 2πkφ`` (Widrow and Kollár, Quantization Noise, 2008),
    rms over φ ``L = q/π √(½ Σ exp(−4 π² k² σ²/q²)/k²)``, q/√12 without noise. The scatter of
    neighbouring readings of idle cells, ``σ² + q²/12 − L²``, tells σ.

    Parameters
    ----------
    raw_n, idle
        As `starting_noise`.

    Returns
    -------
    For the cells together, N
    """
    step = quantum(raw_n)
    scatter = []
    for i in np.flatnonzero(step > 0):
        change = np.diff(raw_n[:, i])[idle[1:, i] & idle[:-1, i]] / step[i]
        change = change[np.isfinite(change)]
        scatter.append(float(np.mean(change**2)) / 2.0 if change.size else 0.0)
    # a cell at the middle of a step scatters less than one at its edge: all of them together tell
    share = np.interp(np.mean(scatter), _SCATTER, _KEPT) if scatter else 0.0
    return float(np.median(step) * share)


def quantum(readings: FloatArray) -> FloatArray:
    """The step of each channel's converter, shape (c,): the smallest change that occurs often.

    The tenth percentile of the differences between neighbouring distinct readings, so that a
    channel of real numbers has a step of nearly nothing.
    """
    steps = np.zeros(readings.shape[1])
    for i, column in enumerate(readings.T):
        distinct = np.unique(column[np.isfinite(column)])
        if distinct.size > 2:
            steps[i] = float(np.quantile(np.diff(distinct), 0.1))
    return steps
