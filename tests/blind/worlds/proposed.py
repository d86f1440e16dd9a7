"""The experiments that a diagnosis may propose, made with the robot it was about.

Written from their descriptions in footcal's menu; ids are the menu's.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from tests.blind.world import GRAVITY_MPS2, Array, Rng, World
from tests.blind.worlds import hang, placements
from tests.blind.worlds import walk as walks
from tests.blind.worlds.gait import Build, Motion, bounces, joined, stances, walk
from tests.blind.worlds.legs import legs_of
from tests.blind.worlds.weights import Cells, Schedule, held, weighed

LADDER = np.linspace(0.0, 1.0, 9)
_TOES_OUT = (np.deg2rad(45.0), np.deg2rad(-15.0))
FEWEST, MOST = 12, 24
"""Sessions of a bench experiment, however many runs the proposal asks for."""
HANG_TURNS = 10
SCALE_N = 0.02
"""Error sd of a kitchen scale."""
SETTLED: Mapping[str, tuple[str, ...]] = {
    "walk_unsmoothed": ("lag",),
    "weigh_robot": ("robot_weight",),
    "weigh_standing": ("mass",),
    "weigh_walking": ("mass",),
    "hang_again": ("leg_weight",),
}
"""What goes because the experimenter switched it off, or looked."""
MOST_MOVES = 6
"""Runs of an experiment of the whole robot, likewise."""


def _there_and_back(steps: Array) -> Array:
    return np.concatenate([steps, steps[-2::-1]])


def _steps(share: Array, hold_s: float, step_s: float) -> Schedule:
    return held(share, np.full(share.size, hold_s), step_s)


def _shuffled(rng: Rng) -> Schedule:
    return _steps(rng.permutation(np.tile(LADDER, 2)), 10.0, 1.0)


def _ramps() -> Schedule:
    slow = np.concatenate([np.linspace(0, 1, 300), np.linspace(1, 0, 300)])
    fast = np.concatenate([np.linspace(0, 1, 15), np.linspace(1, 0, 15)])
    share = np.concatenate([slow, fast, fast])
    return Schedule(0.1 * np.arange(float(share.size)), share.astype(float))


def _taps() -> Schedule:
    share = np.tile(np.concatenate([np.zeros(20), np.ones(5)]), 20)
    return Schedule(np.arange(float(share.size)) / 80.0, share.astype(float))


def _warm_up() -> Schedule:
    share = np.tile(np.repeat([0.0, 1.0], 10), 20)
    return Schedule(2.0 * np.arange(float(share.size)), share.astype(float), warming_k=8.0)


_BENCH: Mapping[str, Callable[[Rng], Schedule]] = {
    "up_down": lambda _: _steps(_there_and_back(LADDER), 5.0, 0.5),
    "random_order": _shuffled,
    "up_down_60s": lambda _: _steps(_there_and_back(LADDER), 60.0, 4.0),
    "fine_ladder": lambda _: _steps(_there_and_back(np.linspace(0.0, 1.0, 25)), 5.0, 0.5),
    "push_pull": lambda _: _steps(
        np.concatenate([_there_and_back(LADDER), -_there_and_back(LADDER)]), 5.0, 0.5
    ),
    "hold_5min": lambda _: _steps(np.array([1.0, 0.0]), 300.0, 2.0),
    "ramps": lambda _: _ramps(),
    "taps": lambda _: _taps(),
    "warm_up": lambda _: _warm_up(),
}


def _circles(rng: Rng, build: Build) -> Motion:
    turn = 2 * np.pi / 30.0
    return joined([walk(rng, build, 34.0, turn_radps=sign * turn) for sign in (1.0, -1.0)])


def _squatting(rng: Rng, build: Build) -> Motion:
    turn = 2 * np.pi / 30.0
    return joined(
        [
            walk(rng, build, 34.0, turn_radps=sign * turn, step_s=0.6, squatting=True)
            for sign in (1.0, -1.0)
        ]
    )


def _slow_fast(rng: Rng, build: Build) -> Motion:
    return joined([walk(rng, build, 34.0, turn_radps=0.0, step_s=s) for s in (1.2, 0.5)])


_MOVED: Mapping[str, Callable[[Rng, Build], Motion]] = {
    "bounce": lambda rng, build: bounces(
        rng, build, stretches=3, seconds_each=12.0, facing_ways=1, heights=1
    ),
    "turn_and_bounce": lambda rng, build: bounces(
        rng, build, stretches=12, seconds_each=12.0, facing_ways=4, heights=3, toes_out=_TOES_OUT
    ),
    "walk_turning": _circles,
    "walk_squatting": _squatting,
    "walk_slow_fast": _slow_fast,
    "walk_unsmoothed": lambda rng, build: walk(rng, build, 66.0, turn_radps=0.0),
    "stand_turned": lambda rng, build: stances(rng, build, 24, 4.0, toes_out=_TOES_OUT),
}


def _holes(rng: Rng, like: World, repeats: int) -> World:
    """Five weights on 18 holes of the left foot, up to half the robot's weight."""
    cells = like.row["cells_m"][0][:4]
    middle = cells.mean(axis=0)
    grid = np.stack(
        np.meshgrid(np.linspace(-0.55, 0.55, 6), np.linspace(-0.42, 0.42, 3), indexing="ij"), -1
    ).reshape(-1, 2)
    holes = np.round(grid * np.abs(cells - middle).mean(axis=0) + middle, 4)
    full_n = 0.5 * float(like.robot["mass_kg"]) * GRAVITY_MPS2
    weights = np.round(full_n * np.linspace(0.2, 1.0, 5), 2)
    return placements.placed(rng, cells, holes, weights, repeats, like)


def can_make(plan: str) -> bool:
    """Whether a proposal can be carried out here."""
    return plan in _BENCH or plan in _MOVED or plan in ("hang", "holes", *SETTLED)


def proposed(rng: Rng, plan: str, like: World, repeats: int) -> World:
    """The clean world of a proposed experiment on the robot of another world."""
    if plan in ("weigh_robot", "weigh_standing", "weigh_walking"):
        mass = like.robot["mass_kg"] + rng.normal(0.0, SCALE_N) / GRAVITY_MPS2
        return replace(like, robot={**like.robot, "mass_kg": mass})
    if plan == "hang_again":
        return like  # hanging as it stands, shoes on
    if plan == "hang":
        # hung anew, all its legs turning, as long as the robot's first hanging
        return hang.hanging(rng, legs_of(like.facts["legs"]), HANG_TURNS, sd_n=like.facts["sd_n"])
    if plan in _BENCH:
        share = like.facts.get("sd_n", 0.05)
        full_n = float(like.facts.get("full_n", np.abs(like.shown).max()))
        cells = Cells(like.channels, like.scale, like.zero, full_n, share, like.facts["noise"])
        return weighed(rng, cells, _BENCH[plan](rng), int(np.clip(repeats, FEWEST, MOST)))
    runs = int(np.clip(repeats, 1, MOST_MOVES))
    if plan == "holes":
        return _holes(rng, like, runs)
    build = like.facts["build"]
    kind = "stand" if plan == "stand_turned" else "walk"
    drifting = like.drift is not None
    motion = joined([_MOVED[plan](rng, build) for _ in range(runs)])
    return walks.logged(rng, kind, build, motion, drifting, like=like)
