"""Noise of the online estimator's rows and random walks, and what keeps it sane."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np

from footcal_cli.core.parameters import FloatArray

_DEFAULT_WEIGHT_N = 53.0
"""Body weight of the robot that the default noise is meant for (seed 1's NAO)."""


@dataclass(frozen=True)
class Noise:
    """Noise of the rows and of the random walks; every field a scalar or shape (settings,).

    Parameters
    ----------
    force_n, moment_nm
        White part of the totals' error, per block.
    force_slow_n, moment_slow_nm
        Stationary sd of its correlated part.
    force_slow_s, moment_slow_s
        Correlation times of the correlated part.
    swing_n
        White error of a swinging cell, per block.
    swing_slow_n, swing_slow_s
        Sd and correlation time of the cell's own slow noise.
    swing_fixed_n, swing_fixed_s
        Sd of an error that a swinging cell keeps from swing to swing: unloaded it rests on one
        step of its converter, so its rounding does not average out until its bias has drifted on.
    gain_walk, bias_walk_n
        Random walk of each gain (1/√s) and bias (N/√s).
    state_walk
        Random walk of every other state, in prior sd per √s.
    """

    force_n: FloatArray | float = 0.3
    moment_nm: FloatArray | float = 0.03
    force_slow_n: FloatArray | float = 0.2
    moment_slow_nm: FloatArray | float = 0.08
    force_slow_s: FloatArray | float = 0.2
    moment_slow_s: FloatArray | float = 0.2
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

    def for_weight(self, weight_n: float) -> Noise:
        """The same noise for a robot of another weight, forces and moments in proportion."""
        factor = weight_n / _DEFAULT_WEIGHT_N
        scaled = [f.name for f in fields(self) if f.name.endswith(("_n", "_nm"))]
        return replace(self, **{n: np.asarray(getattr(self, n)) * factor for n in scaled})

    @classmethod
    def of(cls, stacked: FloatArray) -> Noise:
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
