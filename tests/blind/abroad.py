"""Causes hidden in the foreign world: what `tests.foreign` records, and one thing wrong with it.

Nothing here knows footcal: a cause changes what cells show, what a stream or a label says, or what
the recipe believes, in laws that are not the table's.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from tests.blind import foreign
from tests.blind.abroad_ankles import ON_ANKLES
from tests.blind.abroad_fleet_legs import ON_FLEET
from tests.blind.abroad_legs import ON_LEGS, Hide, heavier, with_log
from tests.blind.abroad_streams import averaged, lateness
from tests.blind.classes import CREEP, CURVES, LATE, LEVEL, SLOW, SUM
from tests.blind.world import Array, Rng
from tests.foreign import (
    CELLS,
    Distort,
    Recorded,
    joined,
    placements,
    stand,
    walk,
    weights,
    write,
)

FEET = ("left", "right")
CHANNELS = tuple(f"{foot}_{cell}" for foot in FEET for cell in CELLS)
FEET_OF = [[0, 1, 2, 3], [4, 5, 6, 7]]
ACC, COM = "com_acc_{}_mps2", "com_{}_m"
WIRING = ("plugs", "dead cell", "dead axis", "half turn", "mirrored", "loose contact")
SECONDS = 45.0
"""Of a walk."""


@dataclass(frozen=True)
class Abroad:
    """One kind of trial.

    Parameters
    ----------
    experiment, cause
        Where, and what is wrong or unusual.
    right
        Names that are right, none of a clean log; several where one remedy
        serves or no data of that experiment differ.
    hide
        ``(seed, rng) -> Recorded``.
    wiring
        Whether ``bad-data`` is a right answer too.
    also
        Names of what the robot truly has, whatever is hidden.
    """

    experiment: str
    cause: str
    right: tuple[str, ...]
    hide: Hide
    wiring: bool = False
    also: tuple[str, ...] = ()

    @property
    def beside(self) -> frozenset[str]:
        """Names that may stand in a set beside the right ones."""
        return frozenset(SLOW if set(self.right) & set(SLOW) else ())


def make(trial: Abroad, seed: int, folder: Path) -> None:
    """Write the logs and the recipe of a trial."""
    write(trial.hide(seed, np.random.default_rng([seed, 77])), folder)


def _on(loads: Array, cells: Array, change: Callable[[Array], Array]) -> Array:
    out = loads.copy()
    out[:, cells] = change(loads[:, cells])
    return out


def _cells(rng: Rng) -> Array:
    """All cells, or one foot's, or one."""
    return np.asarray([np.arange(8), np.arange(4), rng.integers(8, size=1)][int(rng.integers(3))])


def _rested(n: int) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    fresh = np.zeros(n, dtype=bool)
    fresh[0] = True
    return fresh


def _loop(rng: Rng, share: float) -> Distort:
    """A loop after Bouc and Wen, in cells that are drawn."""
    cells = _cells(rng)

    def distort(time_s: Array, loads: Array) -> Array:
        span = np.percentile(loads, 99.5)
        return _on(
            loads, cells,
            lambda x: foreign.bouc_wen(x, _rested(len(x)), share * span, 0.2 * span),
        )  # fmt: skip

    return distort


def _creeping(rng: Rng) -> Distort:
    cells, fast, slow = _cells(rng), rng.uniform(10, 25), rng.uniform(80, 200)

    def distort(time_s: Array, loads: Array) -> Array:
        return _on(
            loads, cells,
            lambda x: foreign.two_stage_creep(x, time_s, _rested(len(x)), 0.012, fast, slow),
        )  # fmt: skip

    return distort


def _bent(rng: Rng, share: float) -> Distort:
    """A curve that no polynomial holds."""
    cells, reach, sign = _cells(rng), rng.uniform(0.3, 0.6), rng.choice([-1.0, 1.0])

    def distort(time_s: Array, loads: Array) -> Array:
        span = np.percentile(loads, 99.5)
        return _on(
            loads, cells,
            lambda x: foreign.exponential_bend(x, sign * share * span, reach * span),
        )  # fmt: skip

    return distort


def _kinked(rng: Rng, share: float) -> Distort:
    cells, sign = _cells(rng), rng.choice([-1.0, 1.0])

    def distort(time_s: Array, loads: Array) -> Array:
        span = np.percentile(loads, 99.5)
        return _on(loads, cells, lambda x: foreign.soft_hinge(x, sign * share, 0.55 * span))

    return distort


def _hearing(share: float) -> Distort:
    return lambda time_s, loads: foreign.neighbour_crosstalk(loads, share, FEET_OF)


def _jumped(rng: Rng, share: float, seconds: float) -> Distort:
    """A tugged cable: a fifth of the jump of one cell comes slowly after it."""
    cell, sign = int(rng.integers(8)), rng.choice([-1.0, 1.0])
    when_s = rng.uniform(0.2, 0.8) * seconds

    def distort(time_s: Array, loads: Array) -> Array:
        since = np.maximum(time_s - when_s, 0.0)
        settled = np.where(time_s >= when_s, 1.0 - 0.2 * np.exp(-since / 3.0), 0.0)
        jump = sign * share * np.percentile(loads, 99.5)
        return _on(loads, np.array([cell]), lambda x: x + jump * settled[:, None])

    return distort


def _bypassed(share: float) -> Distort:
    def distort(time_s: Array, loads: Array) -> Array:
        total = max(float(loads[:, cells].sum(axis=1).max()) for cells in FEET_OF)
        return foreign.soft_bypass(loads, share, 0.5 * total, FEET_OF)

    return distort


def _lagging(rng: Rng, *, every: bool = False) -> Distort:
    cells: Array = np.asarray(np.arange(8) if every else rng.integers(8, size=1))

    def distort(time_s: Array, loads: Array) -> Array:
        late = foreign.slow_part(loads, time_s, _rested(len(loads)), 0.05)
        return _on(loads, cells, lambda x: late[:, cells])

    return distort


def _exchanged(recorded: Recorded, role: str, first: str, second: str) -> Recorded:
    """Two plugs in each other's socket."""
    table = recorded.logs[role].copy()
    a, b = f"{first}_counts", f"{second}_counts"
    table[[a, b]] = recorded.logs[role][[b, a]].to_numpy()
    return with_log(recorded, role, table)


def _dead(seed: int, rng: Rng) -> Recorded:
    recorded = _walking(seed)
    table, name = recorded.logs["cells"].copy(), f"{CHANNELS[int(rng.integers(8))]}_counts"
    table[name] = table[name].iloc[0]
    return with_log(recorded, "cells", table)


def _misplaced(recorded: Recorded, rng: Rng, by_m: float) -> Recorded:
    """The recipe has one cell of each foot elsewhere than it is."""
    robot: dict[str, Any] = {**recorded.robot}
    name, angle = CELLS[int(rng.integers(4))], rng.uniform(0, 2 * np.pi)
    feet = {}
    for foot, spec in robot["feet"].items():
        cells = {k: dict(v) for k, v in spec["cells"].items()}
        if foot == "left":
            cells[name]["x_m"] += by_m * np.cos(angle)
            cells[name]["y_m"] += by_m * np.sin(angle)
        feet[foot] = {**spec, "cells": cells}
    return replace(recorded, robot={**robot, "feet": feet})


def _body(recorded: Recorded, changed: Callable[[pd.DataFrame], pd.DataFrame]) -> Recorded:
    return with_log(recorded, "body", changed(recorded.logs["body"].copy()))


def _pushed(columns: str, size: float, rng: Rng) -> Callable[[pd.DataFrame], pd.DataFrame]:
    """A constant in the body's own axes on two columns."""
    angle = rng.uniform(0, 2 * np.pi)

    def changed(body: pd.DataFrame) -> pd.DataFrame:
        yaw = 0.5 * (body["left_foot_yaw_rad"] + body["right_foot_yaw_rad"]).to_numpy() + angle
        body[columns.format("x")] += size * np.cos(yaw)
        body[columns.format("y")] += size * np.sin(yaw)
        return body

    return changed


def _fast_clock(ppm: float) -> Callable[[pd.DataFrame], pd.DataFrame]:
    def changed(body: pd.DataFrame) -> pd.DataFrame:
        start = body["time_s"].iloc[0]
        body["time_s"] = start + (body["time_s"] - start) * (1.0 + 1e-6 * ppm)
        return body

    return changed


def _walking(seed: int, distort: Distort | None = None, **options: Any) -> Recorded:
    return joined(walk(seed, seconds=SECONDS, distort=distort, **options), weights(seed))


def _late(seed: int, rng: Rng) -> Recorded:
    return _walking(seed, **lateness(rng))


def _standing(seed: int, distort: Distort | None = None) -> Recorded:
    return joined(stand(seed, distort=distort), weights(seed))


def _placed(seed: int, distort: Distort | None = None, **options: Any) -> Recorded:
    return joined(placements(seed, rounds=2, distort=distort, **options), weights(seed))


def _moved(seed: int, rng: Rng) -> Recorded:
    moved = np.zeros((8, 2))
    moved[int(rng.integers(8))] = 0.003 * rng.choice([-1.0, 1.0], 2)
    return _placed(seed, moved_m=moved)


def _mislabelled(seed: int, rng: Rng, *, once: bool) -> Recorded:
    """One hole written as its neighbour: in all visits, or in one."""
    recorded = _placed(seed)
    table = recorded.logs["placements"].copy()
    on_left = table[table["foot"] == "left"][["hole_x_m", "hole_y_m"]]
    where = on_left.drop_duplicates().to_numpy()
    wrong = where[int(rng.integers(len(where)))]
    apart = np.linalg.norm(where - wrong, axis=1)
    there = where[np.argsort(apart)[1 if not once else 3]]
    xy = table[["hole_x_m", "hole_y_m"]].to_numpy(copy=True)
    rows = np.flatnonzero((table["foot"] == "left") & np.all(xy == wrong, axis=1))
    rows = rows[:1] if once else rows
    xy[rows] = there
    table[["hole_x_m", "hole_y_m"]] = xy
    return with_log(recorded, "placements", table)


def _mislabelled_weight(recorded: Recorded, role: str, share: float) -> Recorded:
    table = recorded.logs[role].copy()
    loads = np.unique(table["load_n"][table["load_n"] > 0])
    chosen = table["load_n"] == loads[len(loads) // 2]
    table.loc[chosen, "load_n"] = np.round(table.loc[chosen, "load_n"] * (1.0 + share), 3)
    return with_log(recorded, role, table)


def _wandering(rng: Rng, size_n: float) -> Distort:
    """The zero of one cell moves with the root of time."""
    cell = np.array([int(rng.integers(8))])
    sign = rng.choice([-1.0, 1.0])

    def distort(time_s: Array, loads: Array) -> Array:
        late = np.sqrt((time_s - time_s.min()) / max(float(np.ptp(time_s)), 1e-9))[:, None]
        return _on(loads, cell, lambda x: x + sign * size_n * late)

    return distort


def _felt(record: Callable[..., Recorded], distort: Callable[[Rng], Distort]) -> Hide:
    """A cause that changes what cells show."""
    return lambda seed, rng: record(seed, distort=distort(rng))


def _told(
    record: Callable[[int], Recorded],
    change: Callable[[Rng], Callable[[pd.DataFrame], pd.DataFrame]],
) -> Hide:
    """A cause that changes what the body's stream says."""
    return lambda seed, rng: _body(record(seed), change(rng))


def _label(record: Callable[[int], Recorded], role: str, share: float) -> Hide:
    return lambda seed, rng: _mislabelled_weight(record(seed), role, share)


def _plugs(record: Callable[[int], Recorded], role: str, first: str, second: str) -> Hide:
    return lambda seed, rng: _exchanged(record(seed), role, first, second)


def _clock(rng: Rng) -> Callable[[pd.DataFrame], pd.DataFrame]:
    return _fast_clock(float(rng.choice([-1.0, 1.0]) * rng.uniform(1500, 3000)))


def _hole(*, once: bool) -> Hide:
    return lambda seed, rng: _mislabelled(seed, rng, once=once)


_BENCH: tuple[tuple[str, str, tuple[str, ...], Hide], ...] = (
    ("weights", "", (), lambda s, r: weights(s)),
    ("weights", "hysteresis", ("hysteresis",), _felt(weights, lambda r: _loop(r, 0.008))),
    ("weights", "creep", CREEP, _felt(weights, _creeping)),
    ("weights", "curve", CURVES, _felt(weights, lambda r: _bent(r, 0.02))),
    ("weights", "kink", CURVES, _felt(weights, lambda r: _kinked(r, 0.03))),
    ("weights", "drift", ("bias_drift",), _felt(weights, lambda r: _wandering(r, 0.5))),
    ("weights", "label", ("wrong_weight",), _label(weights, "weights", 0.015)),
    ("placements", "", (), lambda s, r: _placed(s)),
    ("placements", "cell", ("cell_position",), _moved),
    ("placements", "hole", ("wrong_hole",), _hole(once=False)),
    ("placements", "hole once", ("wrong_hole",), _hole(once=True)),
    ("placements", "label", SUM, _label(_placed, "placements", 0.02)),
    ("placements", "crosstalk", ("crosstalk",), _felt(_placed, lambda r: _hearing(0.02))),
    ("placements", "bypass", SUM, _felt(_placed, lambda r: _bypassed(0.06))),
    ("placements", "drift", ("bias_drift",), _felt(_placed, lambda r: _wandering(r, 1.0))),
    ("placements", "curve", CURVES, _felt(_placed, lambda r: _bent(r, 0.04))),
    ("placements", "plugs", ("channel_swap",), _plugs(_placed, "placements", "fl", "fr")),
)
_ON_FEET: tuple[tuple[str, str, tuple[str, ...], Hide], ...] = (
    ("walk", "", (), lambda s, r: _walking(s)),
    ("walk", "clean, drifting", (), _felt(_walking, lambda r: _wandering(r, 0.3))),
    ("walk", "accelerometer", LEVEL, _told(_walking, lambda r: _pushed(ACC, 0.15, r))),
    ("walk", "CoM", LEVEL, _told(_walking, lambda r: _pushed(COM, 0.009, r))),
    ("walk", "late", LATE, _late),
    ("walk", "averaged", ("acceleration_delay",), _told(_walking, averaged)),
    ("walk", "clock", ("clock_drift",), _told(_walking, _clock)),
    ("walk", "hysteresis", ("hysteresis",), _felt(_walking, lambda r: _loop(r, 0.07))),
    ("walk", "crosstalk", ("crosstalk",), _felt(_walking, lambda r: _hearing(0.05))),
    ("walk", "curve", CURVES, _felt(_walking, lambda r: _bent(r, 0.1))),
    ("walk", "jump", ("bias_jump",), _felt(_walking, lambda r: _jumped(r, 0.05, SECONDS))),
    ("walk", "bypass", ("load_bypass",), _felt(_walking, lambda r: _bypassed(0.25))),
    ("walk", "cell", ("cell_position",), lambda s, r: _misplaced(_walking(s), r, 0.008)),
    ("walk", "slow cell", ("sensor_lag",), _felt(_walking, _lagging)),
    ("walk", "slow cells", ("sensor_lag",), _felt(_walking, lambda r: _lagging(r, every=True))),
    ("walk", "dead cell", ("channel_stuck",), _dead),
    ("walk", "plugs", ("channel_swap",), _plugs(_walking, "cells", "left_fl", "left_rl")),
    ("stand", "", (), lambda s, r: _standing(s)),
    ("stand", "CoM", LEVEL, _told(_standing, lambda r: _pushed(COM, 0.012, r))),
    ("stand", "mass", ("mass",), lambda s, r: heavier(_standing(s), 0.05)),
    ("stand", "curve", CURVES, _felt(_standing, lambda r: _bent(r, 0.1))),
    ("stand", "crosstalk", ("crosstalk",), _felt(_standing, lambda r: _hearing(0.06))),
    ("stand", "plugs", ("channel_swap",), _plugs(_standing, "cells", "left_fl", "left_rl")),
)
TRIALS: Mapping[str, Abroad] = {
    f"{experiment} {cause or 'clean'}": Abroad(
        experiment,
        cause,
        right,
        hide,
        wiring=cause in WIRING,
    )
    for experiment, cause, right, hide in (*_BENCH, *_ON_FEET, *ON_LEGS, *ON_ANKLES, *ON_FLEET)
}
