"""Families of noise: white, autoregressive, heteroscedastic, gains that wander by block."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.signal import lfilter

from tests.blind.world import Array, Ints, Rng

BODY_DECAY = 0.7
"""From sample to sample of the body's stream."""
FAMILIES = ("white", "ar90", "ar98", "heteroscedastic", "block_gain_offset")


@dataclass(frozen=True)
class Spread:
    """How noise is drawn: its family and sd, and what does not repeat between blocks.

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

    family: str
    load: Array
    block: Ints
    sd: Array
    repeatability: float = 0.3

    def __post_init__(self) -> None:
        if self.family not in FAMILIES:
            raise ValueError(f"no family of noise named {self.family}")

    @cached_property
    def _typical(self) -> Array:
        return np.asarray(np.sqrt(np.mean(self.load**2, axis=0)) + 1e-9)

    @property
    def _unrepeated(self) -> float:
        """Sd of what does not repeat, as a share of `sd`."""
        gains = self.family == "block_gain_offset"
        return max(self.repeatability, 0.6) if gains else self.repeatability

    @property
    def _decay(self) -> float:
        return {"ar90": 0.9, "ar98": 0.98}.get(self.family, 0.0)

    @cached_property
    def _strength(self) -> Array:
        """Sd of the part that is new in every row, as a share of `sd`, shape (n, c)."""
        if self.family == "heteroscedastic":
            rise = 0.3 + np.abs(self.load) / self._typical
            return np.asarray(rise / np.sqrt(np.mean(rise**2, axis=0)))
        return np.full(self.load.shape, 0.8 if self.family == "block_gain_offset" else 1.0)

    def draw(self, rng: Rng) -> Array:
        """Noise, shape (n, c)."""
        white = rng.normal(size=self.load.shape)
        unit = autoregressive(white, self.block, self._decay) if self._decay else white
        unit = unit * self._strength
        if self.family == "heteroscedastic":
            unit /= np.sqrt(np.mean(unit**2, axis=0)) + 1e-12
        inside = np.unique(self.block, return_inverse=True)[1]
        shape = (2, int(inside.max()) + 1, self.load.shape[1])
        offset, gain = rng.normal(size=shape) * self._unrepeated
        wandering = offset[inside] + gain[inside] * self.load / self._typical
        return np.asarray(self.sd * (unit + wandering))

    def covariance(self, rows: slice, channel: int) -> Array:
        """Covariance of one channel over rows of one block, N² (N²m²), shape (r, r)."""
        load = self.load[rows, channel] / self._typical[channel]
        strength = self._strength[rows, channel]
        apart = np.abs(np.subtract.outer(np.arange(load.size), np.arange(load.size)))
        new = np.outer(strength, strength) * self._decay**apart
        again = self._unrepeated**2 * (1.0 + np.outer(load, load))
        return np.asarray(self.sd[channel] ** 2 * (new + again))


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
