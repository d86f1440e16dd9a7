"""A known weight on known holes of a foot's top plate, placed again and again."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from tests.blind.noise import Spread
from tests.blind.world import Array, Maker, Rng, World, affine_calibrations, draw_cells
from tests.blind.worlds.files import write_bench_calibration, write_log, write_recipe

NAMES = ("fl", "fr", "rl", "rr")


def draw(rng: Rng, options: Mapping[str, Any]) -> World:
    """One foot, four cells not quite on a rectangle, 12–18 holes, 2–3 weights, 3–5 rounds."""
    half_x, half_y = rng.uniform(0.035, 0.08), rng.uniform(0.02, 0.045)
    cells = np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]]) * [half_x, half_y]
    cells = cells + rng.normal(0, 0.002, (4, 2)) + [rng.uniform(-0.01, 0.02), 0.0]
    across = int(options.get("blocks") or rng.integers(4, 7))
    grid = np.stack(
        np.meshgrid(np.linspace(-0.55, 0.55, across), np.linspace(-0.42, 0.42, 3), indexing="ij"),
        -1,
    ).reshape(-1, 2)
    holes = np.round(grid * [half_x, half_y] + cells.mean(axis=0), 4)
    full_n = float(rng.uniform(15.0, 60.0))
    weights = np.round(
        full_n
        * np.array([[0.3, 1.0], [0.35, 0.65, 1.0]][int(rng.integers(2))], dtype=object).astype(
            float
        ),
        2,
    )
    rounds = int(rng.integers(4, 6))
    if options.get("blocks"):  # too little: a few holes, once
        rounds, weights = 1, weights[-1:]
    return placed(rng, cells, holes, weights, rounds)


def placed(
    rng: Rng, cells: Array, holes: Array, weights: Array, rounds: int, like: World | None = None
) -> World:
    """Every weight on every hole in some rounds; the cells of another world's left foot if given.

    Parameters
    ----------
    cells, holes
        In the foot's frame, shape (4, 2) and (h, 2), m.
    weights
        N.
    """
    full_n = float(weights[-1])
    visits = np.array([(h, w) for h in range(len(holes)) for w in range(len(weights))])
    # every round in an order of its own, or drift and place could not be told apart
    order = np.concatenate(
        [np.column_stack([np.full(len(visits), r), rng.permutation(visits)]) for r in range(rounds)]
    )
    hole, load = holes[order[:, 1]], weights[order[:, 2]]
    time_s = np.cumsum(rng.uniform(12.0, 25.0, len(order)))
    scale, zero = draw_cells(rng, 4)
    sd_n = full_n * float(rng.uniform(6e-4, 2e-3))
    family = str(rng.choice(["white", "heteroscedastic", "block_gain_offset"]))
    if like is not None:
        scale, zero, sd_n = like.scale[:4], like.zero[:4], float(like.facts["sd_n"])
    play_m = float(rng.uniform(1e-4, 4e-4))  # of the pin
    true_hole = hole + rng.normal(0, play_m, hole.shape)
    carried = plate_shares(cells, true_hole, rng.normal(0, 0.03, len(order))) * load[:, None]
    intended = plate_shares(cells, hole, np.zeros(len(order))) * load[:, None]
    rows = np.arange(len(order))
    spread = Spread(family, intended, order[:, 0].astype(np.int64), np.full(4, sd_n))
    return World(
        experiment="placements",
        channels=tuple(f"left_{name}" for name in NAMES),
        time_s=time_s,
        block=rows.astype(np.int64) * 0,
        shown=intended,
        noise=spread.draw(rng) + carried - intended,
        row={
            "hole_m": hole,
            "load_n": load,
            "round": order[:, 0].astype(float),
            "hole": order[:, 1].astype(float),
            "weight": order[:, 2].astype(float),
            "cell_pos_m": np.broadcast_to(cells, (len(order), 4, 2)).copy(),
        },
        robot={
            "name": "plate",
            "feet": {"left": {"cells": {n: {"x_m": 0.0, "y_m": 0.0} for n in NAMES}}},
        },
        scale=scale,
        zero=zero,
        quantum_n=float(rng.choice([0.0, 0.3 * sd_n, sd_n])),
        facts={
            "noise": family,
            "sd_n": sd_n,
            "full_n": full_n,
            "holes": len(holes),
            "rounds": rounds,
        },
        spread=spread,
        play_m=play_m,
    )


def plate_shares(cells: Array, hole: Array, twist: Array) -> Array:
    """Shares (n, 4) of a weight: a stiff plate on equal springs, with some rocking of the plate."""
    centre = cells.mean(axis=0)
    arms = np.column_stack([np.ones(4), cells - centre])
    load = np.column_stack([np.ones(len(hole)), hole - centre])
    shares = load @ np.linalg.solve(arms.T @ arms, arms.T)
    # rocking: the one direction that changes neither the sum nor the moments
    rock = np.linalg.svd(arms.T)[2][-1]
    return np.asarray(shares + twist[:, None] * rock)


def error(world: World) -> Array:
    """Σ F − weight (N) and moments about the hole (Nm), shape (n, 3)."""
    arms = world.row["cell_pos_m"] - world.row["hole_m"][:, None]
    total = world.shown.sum(axis=1) - world.row["load_n"]
    return np.column_stack([total, np.einsum("nc,nck->nk", world.shown, arms)])


def write(world: World, folder: Path, rng: Rng) -> None:
    """The table of placements and an older bench calibration of the same cells."""
    counts = world.counts()
    row = world.row
    frame = pd.DataFrame(
        {
            "foot": "left",
            "placement": [
                f"hole {int(h) + 1}, weight {int(w) + 1}"
                for h, w in zip(row["hole"], row["weight"], strict=True)
            ],
            "hole_x_m": np.round(row["hole_m"][:, 0], 5),
            "hole_y_m": np.round(row["hole_m"][:, 1], 5),
            "load_n": np.round(row["load_n"], 4),
            **{f"{n}_counts": counts[:, i] for i, n in enumerate(NAMES)},
            "repeat": row["round"].astype(int) + 1,
            "time_s": np.round(world.time_s, 3),
        }
    )
    believed = world.row["cell_pos_m"][0]
    cells = {
        n: {"x_m": float(x), "y_m": float(y)} for n, (x, y) in zip(NAMES, believed, strict=True)
    }
    robot = {**world.robot, "feet": {"left": {"cells": cells}}}
    bench = write_bench_calibration(world, folder, rng, float(world.row["load_n"].max()))
    logs = {"placements": write_log(frame, folder, "placements", rng), "weights": bench}
    write_recipe(folder, robot, logs)


MAKER = Maker(draw, error, affine_calibrations, write)
