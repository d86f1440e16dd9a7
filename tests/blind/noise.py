"""Families of noise: white, autoregressive, heteroscedastic, gains that wander by block."""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

from tests.blind.world import Array, Ints, Rng

FAMILIES = ("white", "ar90", "ar98", "heteroscedastic", "block_gain_offset")


def draw_noise(
    rng: Rng, family: str, load: Array, block: Ints, sd: Array, repeatability: float = 0.3
) -> Array:
    """Noise (n, c) of a family with a given sd, plus what does not repeat between blocks.

    Parameters
    ----------
    load
        True load, shape (n, c): scale of gain noise and of heteroscedasticity.
    block
        Shape (n,); autoregressions start anew in each.
    sd
        Per channel, shape (c,).
    repeatability
        Offset and gain drawn per block, as a share of `sd`.
    """
    n, c = load.shape
    typical = np.sqrt(np.mean(load**2, axis=0)) + 1e-9
    white = rng.normal(size=(n, c))
    if family in ("ar90", "ar98"):
        unit = autoregressive(white, block, 0.9 if family == "ar90" else 0.98)
    elif family == "heteroscedastic":
        unit = white * (0.3 + np.abs(load) / typical)
        unit /= np.sqrt(np.mean(unit**2, axis=0)) + 1e-12
    elif family == "block_gain_offset":
        unit, repeatability = 0.8 * white, max(repeatability, 0.6)
    elif family == "white":
        unit = white
    else:
        raise ValueError(f"no family of noise named {family}")
    inside = np.unique(block, return_inverse=True)[1]
    offset, gain = rng.normal(size=(2, int(inside.max()) + 1, c)) * repeatability
    wandering = offset[inside] + gain[inside] * load / typical
    return np.asarray(sd * (unit + wandering))


def autoregressive(white: Array, block: Ints, decay: float) -> Array:
    """Stationary first-order autoregression of unit sd, restarted with every block."""
    out = np.empty_like(white)
    edges = np.flatnonzero(np.diff(block, prepend=block[:1] - 1))
    for start, stop in zip(edges, [*edges[1:], len(block)], strict=True):
        drive = white[start:stop] * np.sqrt(1.0 - decay**2)
        drive[0] = white[start]
        out[start:stop] = lfilter([1.0], [1.0, -decay], drive, axis=0)
    return out


def wandering(rng: Rng, time_s: Array, sd_per_root_s: float, channels: int) -> Array:
    """Random walk from zero, shape (n, channels)."""
    step = np.sqrt(np.diff(time_s, prepend=time_s[:1]))[:, None]
    return np.asarray(np.cumsum(rng.normal(size=(time_s.size, channels)) * step, 0) * sd_per_root_s)
