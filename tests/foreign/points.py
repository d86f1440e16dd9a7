"""A quadruped on four points with one cell in each: crawling, and standing here and there."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from tests.foreign.biped import GRAVITY_MPS2
from tests.foreign.files import Recorded
from tests.foreign.kinds import kind_of
from tests.foreign.motion import rate
from tests.foreign.noise import Array, coloured, slow, stream

LEGS = ("fl", "fr", "hl", "hr")
ORDER = (0, 3, 1, 2)
FINE_HZ = 400.0
STEP_S, SWING_SHARE = 2.0, 0.4


def quadruped_truth(seed: int) -> dict[str, Any]:
    """Mass, half distances of the feet, height of the CoM; scales and zeros of the cells."""
    rng, kind = stream(seed, "points"), kind_of(seed)
    mass = float(np.round(rng.uniform(*kind.mass_kg), 2))
    scale = 4e-4 * mass / 12.0 * (1.0 + rng.normal(0.0, 0.02, 4))
    zero = np.round(rng.uniform(4e5, 6e5) + rng.normal(0.0, 0.02, 4) * mass * 9.81 / scale)
    half = np.array([rng.uniform(0.17, 0.24), rng.uniform(0.11, 0.15)]) * (mass / 12.0) ** (1 / 3)
    return {"mass_kg": mass, "scale": scale, "zero": zero, "half_m": half, "up_m": 1.3 * half[0]}


def points(seed: int, *, walking: bool, seconds: float = 60.0) -> Recorded:
    """A crawl with three feet down at any time, or a dozen quiet stances with feet set anew."""
    robot, rng = quadruped_truth(seed), stream(seed, "crawl" if walking else "poised")
    plan = _crawl(robot, rng, seconds) if walking else _stances(robot, rng)
    time_s, feet, on, com = plan
    acc = rate(rate(com)) if walking else np.zeros_like(com)
    load = _loads(robot, feet, on, com, acc, 0.4 * np.tanh(slow(rng, len(com), 1, FINE_HZ)[:, 0]))
    every = round(FINE_HZ / 100.0)
    at = np.arange(0, len(time_s), every)
    sd = 1e-3 * robot["mass_kg"] * GRAVITY_MPS2
    felt = load[at] + sd * coloured(rng, at.size, 4, 10.0)
    counts = np.round(robot["zero"] + felt / robot["scale"])
    cells = pd.DataFrame({"time_s": np.round(time_s[at], 4)})
    cells[[f"{leg}_foot_counts" for leg in LEGS]] = counts
    n = at.size
    com_off = rng.normal(0.0, 1e-3, 3) * [1, 1, 0]
    seen = com[at] + com_off + 3e-4 * slow(rng, n, 3, 50.0)
    body = pd.DataFrame({"time_s": np.round(time_s[at] + 0.021, 4)})
    body[[f"com_{a}_m" for a in "xyz"]] = seen
    noise = 0.02 * coloured(rng, n, 3, 5.0) if walking else np.zeros((n, 3))
    body[[f"com_acc_{a}_mps2" for a in "xyz"]] = acc[at] + noise
    if walking:
        body[[f"angmom_rate_{a}_nm" for a in "xy"]] = 0.005 * robot["mass_kg"] * slow(rng, n, 2, 20)
    for k, leg in enumerate(LEGS):
        body[[f"{leg}_foot_{a}_m" for a in "xyz"]] = feet[at, k] + 3e-4 * slow(rng, n, 3, 50.0)
    cell = {"foot": {"x_m": 0.0, "y_m": 0.0}}
    recipe = {
        "mass_kg": robot["mass_kg"],
        "feet": {leg: {"cells": cell} for leg in LEGS},
        "nameplate": {
            "scale_n_per_count": float(np.round(robot["scale"].mean(), 7)),
            "zero_counts": float(np.round(robot["zero"].mean(), -3)),
            "scale_relative_sd": 0.03,
            "bias_sd_n": float(4.0 * robot["scale"].mean() * robot["zero"].std()),
        },
    }
    late = {"delay_s": 0.02}
    commands = {"online_replay": late, "static_init": late}
    return Recorded({"cells": cells, "body": body}, recipe, {}, commands)


def _loads(
    robot: dict[str, Any], feet: Array, on: Array, com: Array, acc: Array, free: Array
) -> Array:
    """Vertical forces (n, 4) of the feet that are down: Newton and Euler, and what is left free."""
    mass = robot["mass_kg"]
    total = mass * (acc[:, 2] + GRAVITY_MPS2)
    cop = com[:, :2] - com[:, 2:] * mass * acc[:, :2] / total[:, None]
    out = np.zeros((len(com), 4))
    for i in range(len(com)):
        down = np.flatnonzero(on[i])
        grid = np.vstack([np.ones(down.size), feet[i, down, :2].T])
        wanted = total[i] * np.array([1.0, *cop[i]])
        share = np.linalg.lstsq(grid, wanted, rcond=None)[0]
        if down.size == 4:  # a chassis is stiff: diagonal feet share as the ground is uneven
            null = np.linalg.svd(grid)[2][-1]
            share = share + free[i] * np.abs(share).min() / np.abs(null).max() * null
        out[i, down] = share
    return out


def _stances(robot: dict[str, Any], rng: np.random.Generator) -> tuple[Array, Array, Array, Array]:
    """Twelve stances of four seconds: stamps, feet (n, 4, 3), down (n, 4), CoM (n, 3)."""
    each, parts = round(4.0 * FINE_HZ), []
    for i in range(12):
        feet = np.zeros((4, 3))
        feet[:, :2] = robot["half_m"] * np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]])
        feet[:, :2] += rng.uniform(-0.2, 0.2, (4, 2)) * robot["half_m"]
        com = np.array([*(rng.uniform(-0.35, 0.35, 2) * robot["half_m"]), robot["up_m"]])
        parts.append((
            i * 7.0 + np.arange(each) / FINE_HZ, np.tile(feet, (each, 1, 1)),
            np.ones((each, 4)), np.tile(com, (each, 1)),
        ))  # fmt: skip
    time_s, feet_m, on, com_m = (np.concatenate(one) for one in zip(*parts, strict=True))
    return time_s, feet_m, on, com_m


def _crawl(
    robot: dict[str, Any], rng: np.random.Generator, seconds: float
) -> tuple[Array, Array, Array, Array]:
    """One foot after the other; the CoM moves over the other three before a foot leaves."""
    n = round(seconds * FINE_HZ)
    time_s = np.arange(n) / FINE_HZ
    feet, on, aim = np.zeros((n, 4, 3)), np.ones((n, 4)), np.zeros((n, 2))
    here = robot["half_m"] * np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]])
    feet[:, :, :2] = here
    start, k = 2.0, 0
    stride = 0.25 * robot["half_m"][0]
    while start + STEP_S < seconds - 1.0:
        leg = ORDER[k % 4]
        lift = start + (1.0 - SWING_SHARE) * STEP_S
        others = [j for j in range(4) if j != leg]
        aim[time_s >= start] = here[others].mean(axis=0)
        target = here[leg] + [stride, 0.0] + rng.normal(0.0, 0.003, 2)
        phase = np.clip((time_s - lift) / (SWING_SHARE * STEP_S), 0.0, 1.0)
        rise = phase**3 * (10.0 - 15.0 * phase + 6.0 * phase**2)
        feet[:, leg, :2] += (target - here[leg]) * rise[:, None]
        feet[:, leg, 2] += 0.03 * (4.0 * phase * (1.0 - phase)) ** 3
        on[(phase > 0.0) & (phase < 1.0), leg] = 0.0
        here[leg] = target
        start, k = start + STEP_S, k + 1
    window = np.hanning(round(1.0 * FINE_HZ))
    pad = len(window) // 2
    smooth = [
        np.convolve(np.pad(c, (pad, len(window) - 1 - pad), mode="edge"), window / window.sum(),
                    "valid") for c in aim.T
    ]  # fmt: skip
    late = round(0.55 * FINE_HZ)  # it leaves when all feet are down, and is there in time
    moved = [np.append(np.full(late, c[0]), c[:-late]) for c in smooth]
    com = np.column_stack([*moved, np.full(n, robot["up_m"])])
    com[:, 2] += 2e-3 * np.sin(2 * np.pi * time_s / STEP_S) * np.clip((time_s - 2.0) / 2.0, 0, 1)
    return time_s, feet, on, com
