"""Known weights on single cells, and known weights on known holes of a foot's top plate."""

from __future__ import annotations

import numpy as np
import pandas as pd

from tests.foreign.biped import FEET, draw_biped
from tests.foreign.files import Recorded
from tests.foreign.loggers import Drift, converted, looped
from tests.foreign.noise import Array, slow, stream
from tests.foreign.streams import Distort

PIN_PLAY_M = 1.5e-4


def weights(seed: int, *, repeats: int | None = None, distort: Distort | None = None) -> Recorded:
    """Each cell alone under five loads, up and down, several times; a reading every 20 s.

    Parameters
    ----------
    distort : a hidden cause; it sees the loads (n, 8) of all cells in the order of the table
    """
    robot, rng = draw_biped(seed), stream(seed, "weights")
    kind, cells = robot.kind, len(robot.channels)
    repeats = kind.repeats if repeats is None else repeats
    ladder = np.round(0.6 * robot.weight_n * np.array(kind.ladder), 2)
    steps = np.concatenate([ladder, ladder[-2::-1]])
    direction = np.concatenate([np.ones(len(ladder)), -np.ones(len(ladder) - 1)])
    loads = np.tile(steps, cells * repeats)
    channel = np.repeat(np.arange(cells), len(steps) * repeats)
    repeat = np.tile(np.repeat(np.arange(repeats), len(steps)), cells)
    time_s = 20.0 * np.arange(len(loads)) + rng.uniform(0.0, 2.0, len(loads))
    real = loads * (1.0 + kind.weights_off * rng.normal(size=len(ladder))[_rank(loads, ladder)])
    on_all = np.zeros((len(loads), cells))
    on_all[np.arange(len(loads)), channel] = real
    if distort is not None:
        on_all = distort(time_s, on_all)
    drift = Drift(robot, rng).at(time_s)
    shown = looped(on_all, kind.hysteresis, robot.weight_n) + drift
    felt = shown[np.arange(len(loads)), channel]
    # the reading is a mean over seconds; what is left wanders from one weight to the next
    felt = felt + robot.sd_n * (
        0.3 * rng.normal(size=len(loads)) + 0.4 * slow(rng, len(loads), 1, 6.0)[:, 0]
    )
    counts = converted(robot, robot.zero[channel] + felt / robot.scale[channel])
    frame = pd.DataFrame(
        {
            "channel": np.array(robot.channels)[channel],
            "load_n": loads,
            "counts": counts,
            "time_s": np.round(time_s, 2),
            "direction": np.tile(direction, cells * repeats).astype(int),
            "repeat": repeat + 1,
        }
    )
    moved = [drift[channel == c, c % drift.shape[1]].mean() for c in range(cells)]
    truth = {"parameters": robot.truth(), "cell_sd_n": robot.sd_n, "drift_n": moved}
    return Recorded({"weights": frame}, robot.recipe(), truth)


def placements(
    seed: int, *, rounds: int = 4, distort: Distort | None = None, moved_m: Array | None = None
) -> Recorded:
    """Two weights on fifteen holes of both feet, every round in an order of its own.

    Parameters
    ----------
    distort : a hidden cause; it sees the loads (n, cells of both feet)
    moved_m : (cells of both feet, 2) where the cells really are, less where the recipe has them
    """
    robot, rng = draw_biped(seed), stream(seed, "placements")
    under = len(robot.cells)
    moved = np.zeros((2 * under, 2)) if moved_m is None else moved_m
    frames = []
    for side, foot in enumerate(FEET):
        middle = robot.cells_m.mean(axis=0)
        half = np.max(robot.cells_m - middle, axis=0)
        if under == 3:  # a hole outside the triangle would tip the plate
            half = 0.5 * half
        grid = np.stack(np.meshgrid(np.linspace(-0.6, 0.6, 5), [-0.5, 0.0, 0.5], indexing="ij"), -1)
        holes = np.round(grid.reshape(-1, 2) * half + middle, 4)
        known = np.round(robot.weight_n * np.array([0.3, 0.7]), 2)
        visits = np.array([(h, w) for h in range(len(holes)) for w in range(len(known))])
        order = np.concatenate([rng.permutation(visits) for _ in range(rounds)])
        n = len(order)
        time_s = np.arange(n, dtype=np.float64) * 15.0 + 3600.0 * side
        load = known[order[:, 1]]
        pin = holes[order[:, 0]] + PIN_PLAY_M * rng.normal(size=(n, 2))
        part = slice(under * side, under * side + under)
        real = robot.cells_m + moved[part]
        on_all = np.zeros((n, 2 * under))
        twist = 0.04 * rng.normal(size=(n, under - 3))
        on_all[:, part] = _shares(real, pin, twist) * load[:, None]
        if distort is not None:
            on_all = distort(time_s, on_all)
        # pressed once before all, unloaded before each placement
        apart = np.stack([np.zeros_like(on_all), on_all], axis=1).reshape(2 * n, -1)
        pressed = np.vstack([np.full((1, 2 * under), robot.weight_n), apart])
        felt = looped(pressed, robot.kind.hysteresis, robot.weight_n)[2::2, part]
        white = 0.3 * rng.normal(size=(n, under))
        felt = felt + robot.sd_n * (white + 0.4 * slow(rng, n, under, 6.0))
        counts = np.round(robot.zero[part] + felt / robot.scale[part])
        frames.append(
            pd.DataFrame(
                {
                    "foot": foot,
                    "placement": [f"{foot} hole {h + 1} weight {w + 1}" for h, w in order],
                    "hole_x_m": holes[order[:, 0], 0],
                    "hole_y_m": holes[order[:, 0], 1],
                    "load_n": load,
                    **{f"{c}_counts": counts[:, i] for i, c in enumerate(robot.cells)},
                    "repeat": np.repeat(np.arange(rounds), len(visits)) + 1,
                    "time_s": time_s,
                }
            )
        )
    truth = {"parameters": robot.truth(), "moved_m": moved, "cell_sd_n": robot.sd_n}
    return Recorded({"placements": pd.concat(frames, ignore_index=True)}, robot.recipe(), truth)


def _rank(loads: Array, ladder: Array) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    return np.asarray(np.argmin(np.abs(loads[:, None] - ladder), axis=1), dtype=np.int64)


def _shares(cells: Array, point: Array, twist: Array) -> Array:
    """Parts of a weight (n, c): exact in sum and moments; the plate rocks by `twist` (n, c − 3)."""
    grid = np.column_stack([np.ones(len(cells)), cells])
    least = np.linalg.pinv(grid.T) @ np.column_stack([np.ones(len(point)), point]).T
    free = np.linalg.svd(grid.T)[2][3:]
    return np.asarray(least.T + twist @ free)
