"""A simulated bench after [NAO]: weights of 1 g to 6 kg on cells and over 18 holes of a foot.

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


@dataclass(frozen=True)
class Staircase:
    """A cell loaded step by step up and down, with everything that is true of it.

    Defaults are a perfect affine cell; sizes are in N, 1/N, s, N/K and 1/K.
    """

    full_scale_n: float = 60.0
    steps: int = 11
    hold_s: float = 20.0
    rows_per_hold: int = 1
    sessions: int = 1
    scale: float = -2.3e-4
    bias: float = 1909.0
    noise_n: float = 0.03
    session_sd_n: float = 0.0
    hysteresis_width: float = 0.0
    hysteresis_reach: float = 3.0
    creep: float = 0.0
    creep_time: float = 60.0
    quadratic: float = 0.0
    temperature_bias: float = 0.0
    temperature_scale: float = 0.0
    temperature_span_k: float = 0.0

    def record(self, rng: np.random.Generator) -> dict[str, Array]:
        """load_n, counts, time_s, session, temperature_degc, each shape (n,)."""
        up = np.linspace(0.0, self.full_scale_n, self.steps)
        stairs = np.repeat(np.concatenate([up, up[-2::-1]]), self.rows_per_hold)
        dt = self.hold_s / self.rows_per_hold
        rows: list[tuple[float, ...]] = []
        for session in range(self.sessions):
            offset = self.session_sd_n * rng.normal()
            base = self.temperature_span_k * rng.uniform(-0.5, 0.5)
            play = crept = 0.0
            for i, load in enumerate(stairs):
                warm = base + self.temperature_span_k * i / stairs.size
                play = min(max(play, load - self.hysteresis_reach), load + self.hysteresis_reach)
                fading = np.exp(-dt / self.creep_time) if i else 1.0
                crept = fading * crept + (1.0 - fading) * load
                shown = load * (1.0 + self.temperature_scale * warm)
                shown += self.temperature_bias * warm + self.quadratic * load**2
                shown += 0.5 * self.hysteresis_width / self.hysteresis_reach * (play - load)
                shown += self.creep * crept + offset + self.noise_n * rng.normal()
                counts = np.rint((shown - self.bias) / self.scale)
                rows.append((load, float(counts), i * dt, float(session), 25.0 + warm))
        names = ("load_n", "counts", "time_s", "session", "temperature_degc")
        return dict(zip(names, np.array(rows).T, strict=True))
