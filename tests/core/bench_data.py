"""A simulated bench after seed 1: weights of 1 g to 6 kg on cells and over 18 holes of a foot.

Written from the physics alone; it shares no code with what it tests.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
G = 9.80665
WEIGHTS_KG = np.array([0.0, 0.001, 0.01, 0.05, 0.2, 0.5, 1.0, 2.0, 4.0, 6.0])
NAMEPLATE_SCALE, NAMEPLATE_BIAS = -3.4e-5, 283.0
"""What is believed of every cell before it is calibrated: N per count, N."""
CELLS = ("left_fl", "left_fr", "left_rl", "left_rr")
CELL_POS = np.array([[0.07, 0.04], [0.07, -0.04], [-0.05, 0.04], [-0.05, -0.04]])
HOLES = np.array([[x, y] for x in np.arange(-0.04, 0.061, 0.02) for y in (-0.02, 0.0, 0.02)])


@dataclass(frozen=True)
class Foot:
    """What is true of one foot and nobody told the calibration."""

    scale: Array
    bias: Array
    pos: Array
    crosstalk: Array
    noise_n: float
    seat: float

    def counts(self, forces: Array, rng: np.random.Generator) -> Array:
        """True cell forces to integer counts."""
        others = (forces.sum(axis=1, keepdims=True) - forces) / (forces.shape[1] - 1)
        shown = forces + self.crosstalk * others + self.noise_n * rng.normal(size=forces.shape)
        return np.asarray(np.rint((shown - self.bias) / self.scale))

    def share_out(self, load: Array, place: Array, rng: np.random.Generator) -> Array:
        """Forces of four cells with the right sum and moments; the fourth direction is the seat."""
        arms = np.vstack([np.ones(4), self.pos.T])
        wanted = np.vstack([load, load * place[:, 0], load * place[:, 1]])
        forces = (np.linalg.pinv(arms) @ wanted).T
        warp = np.linalg.svd(arms)[2][-1]
        return np.asarray(forces + (self.seat * load * rng.normal(size=load.size))[:, None] * warp)


def make_foot(
    rng: np.random.Generator,
    *,
    crosstalk: float = 0.0,
    position_m: float = 0.0,
    noise_n: float = 0.035,
    seat: float = 0.1,
) -> Foot:
    """A foot whose cells have individual scales, and hidden errors of the given size."""
    scale = NAMEPLATE_SCALE * (1.0 + 0.02 * rng.normal(size=4))
    unloaded = -NAMEPLATE_BIAS / NAMEPLATE_SCALE + 2.65 / NAMEPLATE_SCALE * rng.normal(size=4)
    return Foot(
        scale=scale,
        bias=-scale * unloaded,
        pos=CELL_POS + position_m * rng.normal(size=(4, 2)),
        crosstalk=crosstalk * (1.0 + 0.3 * rng.normal(size=4)),
        noise_n=noise_n,
        seat=seat,
    )


def weights_on_cells(
    foot: Foot, rng: np.random.Generator, repeats: int = 3
) -> tuple[Array, Array, Array]:
    """Every weight on every cell alone: cell index, load, counts of that cell."""
    load = np.tile(WEIGHTS_KG * G, repeats)
    cell = np.repeat(np.arange(4), load.size)
    load = np.tile(load, 4)
    forces = np.zeros((load.size, 4))
    forces[np.arange(load.size), cell] = load
    counts = foot.counts(forces, rng)
    return cell.astype(float), load, counts[np.arange(load.size), cell]


def placements(
    foot: Foot, rng: np.random.Generator, repeats: int = 20, hole_sd_m: float = 1e-4
) -> tuple[Array, Array, Array]:
    """Every weight over every hole: load, nominal hole, counts of the four cells.

    The hole is `hole_sd_m` off where it is believed; that error is the same in every repeat.
    """
    weights = WEIGHTS_KG[1:] * G
    hole = np.repeat(np.arange(len(HOLES)), weights.size * repeats)
    load = np.tile(np.repeat(weights, repeats), len(HOLES))
    true = HOLES + hole_sd_m * rng.normal(size=HOLES.shape)
    forces = foot.share_out(load, true[hole], rng)
    return load, HOLES[hole], foot.counts(forces, rng)
