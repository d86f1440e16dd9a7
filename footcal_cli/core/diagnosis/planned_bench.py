"""Planned recordings of a bench: weights on one cell, weights on the holes of a foot."""

from __future__ import annotations

import numpy as np

from footcal_cli.core.chain import Chain
from footcal_cli.core.diagnosis.rig import Rig
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.simulation.bench_logs import PlacementsPlan, placements_log

CELL = "cell"
"""Stands for whichever cell is weighed."""
Logs = tuple[Log, ...]
LADDER = np.array([0.0, 0.1, 0.25, 0.4, 0.55, 0.7, 0.85, 1.0])
"""Shares of the largest weight."""
TAPS, TAP_RATE_HZ = 20, 80.0


def up_down(rig: Rig) -> Logs:
    """Eight steps up and down, 5 s each."""
    return _held(rig, _there_and_back(LADDER), 5.0, 0.5)


def up_down_60s(rig: Rig) -> Logs:
    """Eight steps up and down, a minute each."""
    return _held(rig, _there_and_back(LADDER), 60.0, 4.0)


def random_order(rig: Rig) -> Logs:
    """The same weights shuffled, each twice, 10 s each."""
    mixed = np.random.default_rng(0).permutation(np.tile(LADDER, 2))
    return _held(rig, mixed, 10.0, 1.0)


def fine_ladder(rig: Rig) -> Logs:
    """24 steps up and down, 5 s each."""
    return _held(rig, _there_and_back(np.linspace(0.0, 1.0, 25)), 5.0, 0.5)


def push_pull(rig: Rig) -> Logs:
    """Eight steps up and down, then the same weights hanging from the cell."""
    pushed = _there_and_back(LADDER)
    return _held(rig, np.concatenate([pushed, -pushed]), 5.0, 0.5)


def hold_5min(rig: Rig) -> Logs:
    """The largest weight for five minutes, then nothing for five."""
    return _held(rig, np.array([1.0, 0.0]), 300.0, 2.0)


def ramps(rig: Rig) -> Logs:
    """A load that rises and falls within a minute, then two within three seconds."""
    slow, fast = (np.concatenate([np.linspace(0, 1, n), np.linspace(1, 0, n)]) for n in (300, 15))
    return _weighed(rig, np.concatenate([slow, fast, fast]), 0.1)


def taps(rig: Rig) -> Logs:
    """Quick taps with the largest weight."""
    once = np.concatenate([np.zeros(20), np.ones(5)])
    return _weighed(rig, np.tile(once, TAPS), 1.0 / TAP_RATE_HZ)


def warm_up(rig: Rig) -> Logs:
    """The largest weight on and off every 20 s while the cell warms by 5 K."""
    return _weighed(rig, np.tile(np.repeat([0.0, 1.0], 10), 20), 2.0, warming_k=5.0)


def holes(rig: Rig) -> Logs:
    """Five weights on the 18 holes of each foot."""
    robot = rig.biped
    plan = PlacementsPlan(repeats=1)
    return tuple(
        placements_log(robot, foot, plan, Chain(()), {}, seed=0, to_counts=False).truth
        for foot in robot.feet
    )


def _there_and_back(steps: FloatArray) -> FloatArray:
    return np.concatenate([steps, steps[-2::-1]])


def _held(rig: Rig, shares: FloatArray, hold_s: float, step_s: float) -> Logs:
    """Each share of the largest weight held, read every `step_s`."""
    return _weighed(rig, np.repeat(shares, int(hold_s / step_s)), step_s)


def _weighed(rig: Rig, shares: FloatArray, step_s: float, warming_k: float = 0.0) -> Logs:
    n = shares.size
    load = (rig.full_load_n * shares)[:, None]
    known = {"load_n": load, "temperature_degc": 25.0 + warming_k * np.linspace(0.0, 1.0, n)}
    stamps = step_s * np.arange(float(n))
    return (Log("weights", (CELL,), stamps, load, known, np.zeros(n, dtype=np.int64)),)
