"""Walking on foot load cells, with the body's own stream on its own clock."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from tests.blind.noise import BODY_DECAY, FAMILIES, Spread, autoregressive, wandering
from tests.blind.world import (
    GRAVITY_MPS2,
    Array,
    Maker,
    Rng,
    World,
    affine_calibrations,
    draw_cells,
)
from tests.blind.worlds.engine import RATE_HZ, engine_walk
from tests.blind.worlds.files import write_bench_calibration, write_log, write_recipe
from tests.blind.worlds.gait import PAUSE_S, Build, Motion, draw_build, walk

FEET = ("left", "right")
CELLS = ("fl", "fr", "rl", "rr")
LONGEST_DELAY_S = 0.04
"""The body stream comes late by up to twice what [NAO] names; the recipe says by how much."""
BODY_SD = {"com_m": 3e-4, "com_acc_mps2": 0.02, "angmom_rate_nm": 0.02}
"""Noise of the body's stream while it moves; a tenth of it where it stands."""
ENGINE_SHARE = 0.35
"""Of the walks, how many come from the physics engine."""


def draw(rng: Rng, options: Mapping[str, Any]) -> World:
    """A robot and a minute of its gait, logged; `straight` forbids turning."""
    seconds = float(options.get("seconds") or rng.uniform(60.0, 80.0))
    drift, straight = bool(options.get("drift")), bool(options.get("straight"))
    if rng.random() < ENGINE_SHARE:
        build, motion = engine_walk(rng, seconds, straight=straight)
        return logged(rng, "walk", build, motion, drift, rate_hz=RATE_HZ)
    build = draw_build(rng)
    motion = walk(rng, build, seconds, turn_radps=0.0 if straight else None)
    return logged(rng, "walk", build, motion, drift)


def logged(
    rng: Rng,
    experiment: str,
    build: Build,
    motion: Motion,
    drift: bool,
    rate_hz: float | None = None,
    like: World | None = None,
) -> World:
    """A motion as two loggers record it; on the motion's own stamps where a rate is given.

    `like` is another log of the same robot: its converters and its noise are this one's too.
    """
    rate, body_rate = (
        float(rng.choice([60.0, 80.0, 100.0])),
        float(rng.choice([80.0, 100.0, 120.0])),
    )
    last = motion.time_s[-1]
    time_s = np.arange(0.3, last - 0.3, 1.0 / rate)
    body_time_s = np.arange(rng.uniform(0.0, 0.01), last, 1.0 / body_rate)
    if rate_hz is not None:
        # touch-downs of an engine are too quick to be interpolated without error
        rate = body_rate = rate_hz
        time_s = body_time_s = motion.time_s
    # a stance robot pauses its loggers while it moves: no rows inside a gap of the motion
    time_s, body_time_s = (t[_recorded(motion.time_s, t)] for t in (time_s, body_time_s))
    shown = resampled(motion.time_s, motion.forces_n, time_s)
    swing = resampled(motion.time_s, motion.swing, time_s)
    cycle = resampled(motion.time_s, motion.cycle[:, None], time_s)[:, 0].astype(np.int64)
    family = str(rng.choice(FAMILIES))
    weight_n = build.mass_kg * GRAVITY_MPS2
    sd_n = weight_n * float(rng.uniform(1e-3, 4e-3))
    delay_s = round(float(rng.uniform(0.0, LONGEST_DELAY_S)), 3)
    scale, zero = draw_cells(rng, 8)
    if like is not None:
        family, sd_n, delay_s = (like.facts[k] for k in ("noise", "sd_n", "delay_s"))
        scale, zero = like.scale, like.zero
    spread = Spread(family, shown, cycle, np.full(8, sd_n), repeatability=0.15)
    noise = spread.draw(rng)
    whole = np.zeros(body_time_s.size, dtype=np.int64)

    def jitter(columns: int, sd: float) -> Array:
        white = rng.normal(size=(body_time_s.size, columns))
        return sd * autoregressive(white, whole, BODY_DECAY)

    still = 0.1 if experiment == "stand" else 1.0
    body_sd = {name: still * sd for name, sd in BODY_SD.items()}
    wander, rates = None, (0.0, 0.0)
    if drift:
        rates = (1e-3, 2e-3 * weight_n / 4)
        scales, biases = (wandering(rng, time_s, rate, 8) for rate in rates)
        wander = scales * shown + biases
    warm = rng.uniform(18, 30) + rng.uniform(-3, 6) * (time_s / last) + 0.3 * np.sin(time_s / 7.0)
    return World(
        experiment=experiment,
        channels=tuple(f"{foot}_{cell}" for foot in FEET for cell in CELLS),
        time_s=time_s,
        block=np.zeros(time_s.size, dtype=np.int64),
        shown=shown,
        noise=noise,
        row={
            "swing": swing,
            "temperature_degc": warm,
            "cells_m": np.broadcast_to(np.tile(build.cells_m, (2, 1)), (time_s.size, 8, 2)).copy(),
        },
        robot={"name": "biped", "mass_kg": build.mass_kg},
        scale=scale,
        zero=zero,
        quantum_n=float(rng.choice([0.0, sd_n, 3 * sd_n])),
        drift=wander,
        drift_per_root_s=rates,
        body_time_s=body_time_s,
        body={
            name: resampled(motion.time_s, getattr(motion, name), body_time_s)
            for name in ("com_m", "com_acc_mps2", "angmom_rate_nm", "feet_m", "yaw_rad")
        },
        body_noise={
            name: jitter(2 if name == "angmom_rate_nm" else 3, sd) for name, sd in body_sd.items()
        },
        facts={
            "noise": family,
            "sd_n": sd_n,
            "rate_hz": rate,
            "body_rate_hz": body_rate,
            "mass_kg": build.mass_kg,
            "engine": rate_hz is not None,
            "drift": drift,
            "seconds": float(last),
            "delay_s": delay_s,
            "build": build,
        },
        spread=spread,
        body_sd=body_sd,
    )


def _recorded(then: Array, now: Array) -> NDArray[np.bool_]:
    """Rows between two samples of one stretch of the motion, shape (n,)."""
    after = np.clip(np.searchsorted(then, now), 1, then.size - 1)
    return np.asarray(then[after] - then[after - 1] < 0.5 * PAUSE_S)


def resampled(then: Array, values: Array, now: Array) -> Array:
    """Linear interpolation of any array along its first axis."""
    flat = values.reshape(len(values), -1)
    columns = [np.interp(now, then, column) for column in flat.T]
    return np.stack(columns, axis=1).reshape(now.size, *values.shape[1:])


def error(world: World) -> Array:
    """Σ F − m (z̈ + g), moments about the demanded CoP, and swinging cells, shape (n, 11)."""
    body = {k: resampled(world.body_time_s, v, world.time_s) for k, v in world.body.items()}
    mass = float(world.robot["mass_kg"])
    com, acc, rate = body["com_m"], body["com_acc_mps2"], body["angmom_rate_nm"]
    demanded = mass * (acc[:, 2] + GRAVITY_MPS2)
    turning = np.column_stack([rate[:, 1], -rate[:, 0]])
    cop = com[:, :2] - (com[:, 2:] * mass * acc[:, :2] + turning) / demanded[:, None]
    cos, sin = (np.repeat(f(body["yaw_rad"]), 4, axis=1) for f in (np.cos, np.sin))
    x, y = world.row["cells_m"][..., 0], world.row["cells_m"][..., 1]
    turned = np.stack([cos * x - sin * y, sin * x + cos * y], axis=-1)
    arms = np.repeat(body["feet_m"][:, :, :2], 4, axis=1) + turned - cop[:, None]
    totals = np.column_stack(
        [world.shown.sum(axis=1) - demanded, np.einsum("nc,nck->nk", world.shown, arms)]
    )
    airborne = np.repeat(world.row["swing"] == 1.0, 4, axis=1)
    return np.column_stack([totals, np.where(airborne, world.shown, np.nan)])


def write(world: World, folder: Path, rng: Rng) -> None:
    """Cells, body, an older bench calibration, and the recipe."""
    counts = world.counts()
    cells = pd.DataFrame(
        {
            "time_s": np.round(world.time_s, 5),
            **{f"{name}_counts": counts[:, i] for i, name in enumerate(world.channels)},
            "temperature_degc": np.round(world.row["temperature_degc"], 2),
        }
    )
    seen = world.noisy().body
    body: dict[str, Array] = {"time_s": np.round(world.body_time_s + world.facts["delay_s"], 5)}
    for i, axis in enumerate("xyz"):
        body[f"com_{axis}_m"] = seen["com_m"][:, i]
        body[f"com_acc_{axis}_mps2"] = seen["com_acc_mps2"][:, i]
        if axis != "z":
            body[f"angmom_rate_{axis}_nm"] = seen["angmom_rate_nm"][:, i]
        for foot, name in enumerate(FEET):
            body[f"{name}_foot_{axis}_m"] = seen["feet_m"][:, foot, i]
    for foot, name in enumerate(FEET):
        body[f"{name}_foot_yaw_rad"] = seen["yaw_rad"][:, foot]
    full_n = float(world.robot["mass_kg"]) * GRAVITY_MPS2
    logs = {
        "cells": write_log(cells, folder, "cells", rng),
        "body": write_log(pd.DataFrame(body), folder, "body", rng),
        "weights": write_bench_calibration(world, folder, rng, 0.6 * full_n),
    }
    places = world.row["cells_m"][0].reshape(2, 4, 2)
    feet = {
        foot: {
            "cells": {
                n: {"x_m": float(x), "y_m": float(y)} for n, (x, y) in zip(CELLS, p, strict=True)
            }
        }
        for foot, p in zip(FEET, places, strict=True)
    }
    write_recipe(folder, {**world.robot, "feet": feet}, logs)


MAKER = Maker(draw, error, affine_calibrations, write)
