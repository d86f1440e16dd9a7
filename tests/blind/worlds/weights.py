"""Known weights on each cell alone: ladders up and down with holds, on several days."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from tests.blind.noise import FAMILIES, Spread
from tests.blind.world import Array, Maker, Rng, World, draw_cells
from tests.blind.worlds.files import write_log, write_recipe

NAMES = ("fl", "fr", "rl", "rr")


@dataclass(frozen=True)
class Schedule:
    """Loads of one session on one cell: readings and their stamps.

    Parameters
    ----------
    time_s, share
        Stamps and loads as shares of the largest one, shape (n,).
    warming_k
        Largest rise of the temperature within a session; drawn where None.
    """

    time_s: Array
    share: Array
    warming_k: float | None = None


@dataclass(frozen=True)
class Cells:
    """What is weighed: cells and their converters, and the noise of their readings."""

    channels: tuple[str, ...]
    scale: Array
    zero: Array
    full_n: float
    sd_n: float
    family: str


def draw(rng: Rng, options: Mapping[str, Any]) -> World:
    """Ladders of 5–8 weights, up and down, holds at the top and at zero, on 12–15 days."""
    count = int(rng.choice([2, 3, 4]))
    sessions = int(options.get("blocks") or rng.integers(12, 16))
    full_n = float(rng.uniform(8.0, 60.0))
    rungs = int(rng.integers(5, 9))
    ladder = np.sort(np.concatenate([[0.0, 1.0], rng.uniform(0.06, 0.94, rungs - 1)]))
    ladder = np.round(full_n * ladder, 2) / full_n
    up_down = np.concatenate([ladder, ladder[-2::-1]])
    hold_s = np.full(up_down.size, float(rng.uniform(15.0, 25.0)))
    hold_s[[rungs, -1]] = rng.uniform(100.0, 180.0, 2)
    schedule = held(up_down, hold_s, float(rng.uniform(3.0, 6.0)))
    scale, zero = draw_cells(rng, count)
    cells = Cells(
        tuple(f"left_{name}" for name in NAMES[:count]),
        scale,
        zero,
        full_n,
        full_n * float(rng.uniform(5e-4, 2e-3)),
        str(rng.choice(FAMILIES)),
    )
    return weighed(rng, cells, schedule, sessions)


def held(share: Array, hold_s: Array, step_s: float) -> Schedule:
    """Each share held for its time, read every `step_s` once the weight has come to rest."""
    edges = np.concatenate([[0.0], np.cumsum(hold_s)])
    time_s = np.arange(min(2.0, 0.5 * step_s + 0.5), edges[-1], step_s)
    return Schedule(time_s, share[np.searchsorted(edges, time_s, side="right") - 1])


def weighed(rng: Rng, cells: Cells, schedule: Schedule, sessions: int) -> World:
    """Every cell under the schedule, in an order of its own in every session."""
    count = len(cells.channels)
    parts: dict[str, list[Array]] = {k: [] for k in ("time", "load", "session", "cell", "degc")}
    for session in range(sessions):
        clock, morning, warming = 0.0, rng.uniform(17.0, 31.0), rng.uniform(-3.0, 5.0)
        warming = warming if schedule.warming_k is None else schedule.warming_k
        for cell in rng.permutation(count):
            time_s = clock + schedule.time_s
            parts["time"].append(time_s)
            parts["load"].append(np.round(cells.full_n * schedule.share, 4))
            parts["session"].append(np.full(time_s.size, float(session)))
            parts["cell"].append(np.full(time_s.size, float(cell)))
            parts["degc"].append(morning + warming * (1 - np.exp(-time_s / 900.0)))
            clock = time_s[-1] + rng.uniform(20.0, 60.0)
    row = {key: np.concatenate(values) for key, values in parts.items()}
    session_cell = (row["session"] * count + row["cell"]).astype(np.int64)
    load = row["load"][:, None]
    spread = Spread(cells.family, load, session_cell, np.array([cells.sd_n]))
    return World(
        experiment="weights",
        channels=cells.channels,
        time_s=row["time"],
        block=session_cell,
        shown=load.copy(),
        noise=spread.draw(rng),
        row={
            "load_n": row["load"],
            "cell": row["cell"],
            "session": row["session"],
            "temperature_degc": row["degc"] + 0.02 * rng.normal(size=row["degc"].size),
        },
        robot={"name": "bench", "channels": list(cells.channels)},
        scale=cells.scale,
        zero=cells.zero,
        quantum_n=float(rng.choice([0.0, 0.2 * cells.sd_n, cells.sd_n])),
        facts={
            "noise": cells.family,
            "sd_n": cells.sd_n,
            "sessions": sessions,
            "full_n": cells.full_n,
        },
        spread=spread,
    )


def error(world: World) -> Array:
    """Shown − label, one column per cell, shape (n, cells)."""
    out = np.full((world.time_s.size, len(world.channels)), np.nan)
    cell = world.row["cell"].astype(int)
    out[np.arange(cell.size), cell] = world.shown[:, 0] - world.row["load_n"]
    return out


def calibrations(world: World) -> list[World]:
    """Scale and bias of each cell."""
    moved = []
    for i in range(len(world.channels)):
        mine = (world.row["cell"] == i)[:, None]
        moved.append(world.with_shown(np.where(mine, 1.01 * world.shown, world.shown)))
        moved.append(world.with_shown(np.where(mine, 0.1 + world.shown, world.shown)))
    return moved


def write(world: World, folder: Path, rng: Rng) -> None:
    """The long table of all cells and days."""
    cell = world.row["cell"].astype(int)
    force = world.shown[:, 0] + world.noise[:, 0]
    if world.quantum_n > 0:
        force = np.round(force / world.quantum_n) * world.quantum_n
    load = world.row["load_n"]
    same = np.diff(world.block, prepend=-1) == 0
    change = np.where(same, np.diff(load, prepend=0.0), 0.0)
    frame = pd.DataFrame(
        {
            "channel": np.array(world.channels)[cell],
            "load_n": np.round(load, 4),
            "counts": np.round(world.zero[cell] + force / world.scale[cell]),
            "time_s": np.round(world.time_s, 3),
            "temperature_degc": np.round(world.row["temperature_degc"], 2),
            "direction": _held_sign(change, ~same),
            "session": [f"day {int(s) + 1}" for s in world.row["session"]],
        }
    )
    write_recipe(folder, world.robot, {"weights": write_log(frame, folder, "weights", rng)})


def _held_sign(change: Array, fresh: Array) -> Array:
    """Sign of the last change of load, +1 at the start of a ladder."""
    sign = np.where(fresh, 1.0, np.sign(change))
    at = np.where(sign != 0, np.arange(sign.size), 0)
    return np.asarray(sign[np.maximum.accumulate(at)])


MAKER = Maker(draw, error, lambda world: iter(calibrations(world)), write)
