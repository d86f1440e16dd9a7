"""Noise of sensors here: a white part and a slow one, and where they come from."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

Array = NDArray[np.float64]
Rng = np.random.Generator


def stream(seed: int, what: str) -> Rng:
    """Random numbers of one thing in the world of a seed, independent of all others."""
    return np.random.default_rng([seed, *what.encode()])


def slow(rng: Rng, rows: int, columns: int, memory: float) -> Array:
    """Stationary AR(1) of unit sd with a memory of that many samples, shape (rows, columns)."""
    decay = float(np.exp(-1.0 / memory))
    drive = rng.normal(size=(rows, columns)) * np.sqrt(1.0 - decay**2)
    first = rng.normal(size=(1, columns)) * decay
    return np.asarray(lfilter([1.0], [1.0, -decay], drive, axis=0, zi=first)[0])


def coloured(rng: Rng, rows: int, columns: int, memory: float, slow_share: float = 0.5) -> Array:
    """Unit sd: white noise and `slow`, which has `slow_share` of the variance."""
    white = rng.normal(size=(rows, columns))
    both = np.sqrt(1.0 - slow_share) * white
    return np.asarray(both + np.sqrt(slow_share) * slow(rng, rows, columns, memory))
