"""Cells that are wired wrongly or dead: there or not, without a size."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tests.blind.hidden.contract import Injection
from tests.blind.world import Rng, World


def _swap(world: World, size: float, rng: Rng) -> World:
    a, b = rng.choice(world.shown.shape[1], 2, replace=False)
    order = np.arange(world.shown.shape[1])
    order[[a, b]] = order[[b, a]]
    return world.with_shown(world.shown[:, order])


def _stuck(world: World, size: float, rng: Rng) -> World:
    shown, noise = world.shown.copy(), world.noise.copy()
    i, at = int(rng.integers(shown.shape[1])), len(shown) // 3
    shown[at:, i] = shown[at, i]
    noise[at:, i] = 0.0
    return replace(world, shown=shown, noise=noise)


def _duplicate(world: World, size: float, rng: Rng) -> World:
    a, b = rng.choice(world.shown.shape[1], 2, replace=False)
    changed = {}
    for name in ("shown", "noise"):
        array = getattr(world, name).copy()
        array[:, b] = array[:, a]
        changed[name] = array
    scale, zero = world.scale.copy(), world.zero.copy()
    scale[b], zero[b] = scale[a], zero[a]
    return replace(world, **changed, scale=scale, zero=zero)


INJECTIONS = (
    Injection(
        "channel_swap/wires", "channel_swap", "placements walk stand", _swap, 1.0, switch=True
    ),
    Injection("channel_stuck/frozen", "channel_stuck", "walk", _stuck, 1.0, switch=True),
    Injection(
        "channel_duplicate/wires",
        "channel_duplicate",
        "placements walk",
        _duplicate,
        1.0,
        switch=True,
    ),
)
"""Wiring faults; a right answer names them or calls the data bad."""
