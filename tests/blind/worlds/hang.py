"""A robot hanging in two opposite pairs of orientations, its legs turning slowly."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from tests.blind.noise import FAMILIES, Spread
from tests.blind.world import GRAVITY_MPS2, Array, Maker, Rng, World
from tests.blind.worlds.files import write_recipe
from tests.blind.worlds.legs import (
    ALL_LEGS,
    DOWN,
    Legs,
    com_at,
    draw_legs,
    small_turn,
    write_hang,
)


def draw(rng: Rng, options: Mapping[str, Any]) -> World:
    """Two legs, ten to twelve turns in each of four orientations."""
    names = [ALL_LEGS[i] for i in sorted(rng.choice(6, 2, replace=False))]
    return hanging(rng, draw_legs(rng, names), int(options.get("blocks") or rng.integers(10, 13)))


def hanging(rng: Rng, legs: Legs, turns: int, sd_n: float | None = None) -> World:
    """These legs hanging, each orientation askew in its own way."""
    rate, turn_s = float(rng.uniform(3.0, 5.0)), float(rng.uniform(8.0, 12.0))
    per_log = int(turns * turn_s * rate)
    k = len(legs.names)
    log, leg = (g.ravel() for g in np.meshgrid(np.arange(4), np.arange(k), indexing="ij"))
    log, leg = np.repeat(log, per_log), np.repeat(leg, per_log)
    clock = np.tile(np.arange(per_log) / rate, 4 * k)
    phase = 2 * np.pi * clock / turn_s + rng.uniform(0, 6, k)[leg]
    down = np.array(list(DOWN.values()))[log]
    tilt = rng.normal(0, 0.025, (4, 3))
    down = np.einsum("nij,nj->ni", small_turn(tilt)[log], down)
    family = str(rng.choice(FAMILIES))
    sd = (sd_n or float(rng.uniform(0.02, 0.1))) * np.array([1, 1, 1, 0.06, 0.06, 0.06])
    block = ((log * k + leg) * turns + np.minimum(clock / turn_s, turns - 1).astype(int)).astype(
        np.int64
    )
    row = {
        "log": log.astype(float),
        "leg": leg.astype(float),
        "clock_s": clock,
        "phase_rad": phase,
        "down": down,
        "weight_n": legs.weight_n[leg],
        "com": legs.com_m[leg],
        # an evenly turning leg: r̈ = −ω² (r − its mean)
        "spin2_over_g": np.full(log.size, (2 * np.pi / turn_s) ** 2 / GRAVITY_MPS2),
        "temperature_degc": (rng.uniform(18, 28) + rng.uniform(-4, 4, 4))[log]
        + rng.uniform(-2, 3) * (1 - np.exp(-clock / 60.0)),
    }
    world = World(
        experiment="hang",
        channels=tuple(f"leg.{axis}" for axis in ("fx", "fy", "fz", "tx", "ty", "tz")),
        time_s=clock + log * (per_log / rate + 60.0),
        block=(log * k + leg).astype(np.int64),
        shown=np.zeros((log.size, 6)),
        noise=np.zeros((log.size, 6)),
        row=row,
        robot={
            "name": "hexapod",
            "mass_kg": 8.0,
            "legs": {
                n: {"position_m": p.tolist()} for n, p in zip(legs.names, legs.hip_m, strict=True)
            },
        },
        scale=np.ones(6),
        zero=np.zeros(6),
        quantum_n=float(rng.choice([0.0, 0.3 * sd[0]])),
        facts={
            "noise": family,
            "sd_n": float(sd[0]),
            "rate_hz": rate,
            "turns": turns,
            "legs": list(legs.names),
        },
    )
    shown = -error(world) + legs.offset[leg]
    spread = Spread(family, shown, block, sd, 0.15)
    return replace(world, shown=shown, noise=spread.draw(rng), spread=spread)


def error(world: World) -> Array:
    """Shown − what a hanging leg of the believed weight and CoM weighs, shape (n, 6 · legs)."""
    arm = com_at(world.row["com"], world.row["phase_rad"])
    off = arm - world.row["com"][:, :, 0]
    down = world.row["down"] + world.row["spin2_over_g"][:, None] * off
    force = world.row["weight_n"][:, None] * down
    left = world.shown - np.column_stack([force, np.cross(arm, force)])
    if not left.size or not world.shown.any():
        return left
    leg = world.row["leg"].astype(int)
    out = np.full((leg.size, int(leg.max()) + 1, 6), np.nan)
    out[np.arange(leg.size), leg] = left
    return out.reshape(leg.size, -1)


def calibrations(world: World) -> Iterator[World]:
    """Per leg: six offsets, weight, CoM (mean, sine, cosine), and the tilt of each log."""
    row = world.row
    for leg in np.unique(row["leg"]):
        mine = row["leg"] == leg
        for axis in range(6):
            shown = world.shown.copy()
            shown[mine, axis] += 0.01
            yield world.with_shown(shown)
        yield world.with_row(weight_n=row["weight_n"] + 0.01 * mine)
        for axis in range(3):
            for term in range(3):
                com = row["com"].copy()
                com[mine, axis, term] += 1e-4
                yield world.with_row(com=com)
        for log in np.unique(row["log"]):
            part = mine & (row["log"] == log)
            for turn in 1e-3 * np.eye(3):
                turned = row["down"] + np.where(part[:, None], np.cross(turn, row["down"]), 0.0)
                yield world.with_row(down=turned)


def write(world: World, folder: Path, rng: Rng) -> None:
    """One long table."""
    wrench = world.shown + world.noise
    if world.quantum_n > 0:
        step = world.quantum_n * np.array([1, 1, 1, 0.06, 0.06, 0.06])
        wrench = np.round(wrench / step) * step
    rows = {**world.row, "time_s": world.time_s, "wrench": wrench}
    name = write_hang(folder, rng, rows, tuple(world.robot["legs"]))
    write_recipe(folder, world.robot, {"hang": name})


MAKER = Maker(draw, error, calibrations, write)
