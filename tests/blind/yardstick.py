"""How large a hidden effect is: what calibration cannot absorb, over the noise."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tests.blind.wandering import Wandering, wandering
from tests.blind.world import BIAS_STEP_N, SCALE_STEP, Array, Maker, World

TOUCHED = 1e-3
"""Outputs that an effect changes by less than this share of the most changed one do not count."""
TOLERANCE = 0.02
MOST_STEPS = 25


class UnreachableError(ValueError):
    """No size of the effect reaches the wanted ρ in this world."""


@dataclass(frozen=True)
class Yardstick:
    """Noise and calibration of one clean world.

    Parameters
    ----------
    clean_error
        Shape (n, k); NaN where nothing is demanded.
    noise
        RMS of the noise per output, shape (k,).
    absorbed
        Orthonormal basis of what calibration explains, over the valid errors, shape (m, p).
    moves
        Change of the error with each calibration parameter, units of noise, each (n, k).
    follows
        Where the calibration wanders: what following it explains, constants included.
    """

    maker: Maker
    clean_error: Array
    noise: Array
    absorbed: Array
    moves: tuple[Array, ...] = ()
    follows: Wandering | None = None

    @property
    def valid(self) -> NDArray[np.bool_]:
        """Errors that count, shape (n, k)."""
        return np.isfinite(self.clean_error)

    def influence(self, world: World) -> Array:
        """Change of the error in units of noise, before anything is refitted, shape (n, k)."""
        change = (self.maker.error(world) - self.clean_error) / self.noise
        return np.asarray(np.where(self.valid & np.isfinite(change), change, 0.0))

    def left(self, world: World) -> Array:
        """What is left of it after the calibration was refitted, or followed, shape (n, k)."""
        change = self.influence(world)
        flat = change[self.valid]
        out = np.zeros_like(change)
        if self.follows is None:
            out[self.valid] = flat - self.absorbed @ (self.absorbed.T @ flat)
        else:
            out[self.valid] = self.follows.left(flat)
        return out

    def rho(self, world: World) -> float:
        """RMS of what is left over RMS of the noise, over the outputs that the effect touches."""
        whole = np.sqrt(np.mean(self.influence(world) ** 2, axis=0))
        touched = whole > TOUCHED * max(float(whole.max()), 1e-300)
        if not touched.any():
            return 0.0
        left = self.left(world)[:, touched][self.valid[:, touched]]
        return float(np.sqrt(np.mean(left**2)))

    def matters(self, world: World, smallest: Array) -> float:
        """What is left over the smallest error that matters, the output where it is largest.

        Parameters
        ----------
        smallest
            Per output, N or Nm, shape (k,).
        """
        rows = np.maximum(self.valid.sum(axis=0), 1)
        rms = self.noise * np.sqrt(np.sum(self.left(world) ** 2, axis=0) / rows)
        return float(np.max(rms / smallest))


def yardstick(maker: Maker, world: World) -> Yardstick:
    """Measure a clean world."""
    clean = maker.error(world)
    valid = np.isfinite(clean)
    shake = np.where(valid, maker.error(world.noisy()) - clean, 0.0)
    rows = valid.sum(axis=0)
    # an output that never counts (no foot was lifted) has no noise of its own
    noise = np.where(rows > 0, np.sqrt(np.sum(shake**2, axis=0) / np.maximum(rows, 1)), 1.0)
    changes = tuple((maker.error(moved) - clean) / noise for moved in maker.calibrations(world))
    if any(world.drift_per_root_s):
        follows = wandering(world.time_s, changes, wandering_rates(world), valid)
        return Yardstick(maker, clean, noise, np.zeros((int(valid.sum()), 0)), changes, follows)
    columns = [change[valid] for change in changes]
    sizes = [float(np.sqrt(np.sum(column**2))) for column in columns]
    kept = [column / size for column, size in zip(columns, sizes, strict=True) if size > 0]
    u, s, _ = np.linalg.svd(np.stack(kept, axis=1), full_matrices=False)
    return Yardstick(maker, clean, noise, u[:, s > 1e-7 * s[0]], changes)


def wandering_rates(world: World) -> list[float]:
    """Random walk of each calibration parameter in steps of `affine_calibrations` per √s."""
    steps = np.array(world.drift_per_root_s) / [SCALE_STEP, BIAS_STEP_N]
    return [float(rate) for rate in np.tile(steps, len(world.channels))]


def size_for(
    rho: float,
    act: Callable[[float], World],
    stick: Yardstick,
    guess: float,
    most: float = np.inf,
) -> tuple[float, World]:
    """Size at which an effect leaves `rho`, and the world that has it.

    Raises
    ------
    UnreachableError
        The effect stays hidden in the calibration, saturates below `rho`, or would be larger than
        `most`.
    """
    size, below, above = guess, (0.0, 0.0), (np.inf, np.inf)
    for step in range(MOST_STEPS):
        world = act(size)
        found = max(stick.rho(world), 1e-12)
        if abs(np.log(found / rho)) < TOLERANCE and size <= most:
            return size, world
        below, above = ((size, found), above) if found < rho else (below, (size, found))
        if below[0] > 0 and np.isfinite(above[0]):
            # a straight line in logarithms, every third time the middle
            ends, values = np.log([below[0], above[0]]), np.log([below[1], above[1]])
            # a size that is rounded off may leave as much as the next one
            flat = step % 3 == 2 or values[0] == values[1]
            share = 0.5 if flat else (np.log(rho) - values[0]) / np.ptp(values)
            size = float(np.exp(ends[0] + np.clip(share, 0.05, 0.95) * np.ptp(ends)))
        else:
            size *= float(np.clip(rho / found, 0.1, 10.0))
    raise UnreachableError(f"rho {rho} not reached: {found:.3g} at size {size:.3g}")
