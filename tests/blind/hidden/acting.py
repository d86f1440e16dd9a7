"""Where an effect acts among load cells, and how what it does is laid on them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tests.blind.hidden.contract import Act, Mask
from tests.blind.library import apply_from_table, of_a_foot
from tests.blind.world import Array, Rng, World


def somewhere(world: World, rng: Rng) -> Mask:
    """One cell, or all of them, shape (n, c)."""
    one = rng.random() < 0.5
    if "cell" in world.row:  # weights: a row belongs to a cell
        cells = int(world.row["cell"].max()) + 1
        chosen = world.row["cell"] == rng.integers(cells)
        return np.asarray(chosen[:, None] if one else np.ones((chosen.size, 1), dtype=bool))
    channel = int(rng.integers(world.shown.shape[1]))
    if not one:
        return np.ones(world.shown.shape, dtype=bool)
    return np.broadcast_to(np.arange(world.shown.shape[1]) == channel, world.shown.shape)


def feet_of(world: World) -> list[list[int]]:
    names = [channel.split("_")[0] for channel in world.channels]
    return [[i for i, n in enumerate(names) if n == foot] for foot in dict.fromkeys(names)]


def some_foot(world: World, rng: Rng) -> Mask:
    """All cells of one foot, or of all, shape (n, c)."""
    feet, channels = feet_of(world), np.arange(world.shown.shape[1])
    chosen = feet[int(rng.integers(len(feet)))] if rng.random() < 0.5 else channels
    return np.broadcast_to(np.isin(channels, chosen), world.shown.shape)


def from_table(effect: str, parameter: str, **shapes: float) -> Act:
    """An effect of footcal's table; a shape above zero is a share of the span, else as it is."""

    def act(world: World, size: float, rng: Rng) -> World:
        mask = some_foot(world, rng) if of_a_foot(effect) else somewhere(world, rng)
        values = {
            name: (
                value * world.span_n
                if name.endswith(("reach", "load", "limit", "width"))
                else value
            )
            for name, value in shapes.items()
        }
        return apply_from_table(world, effect, {parameter: size, **values}, mask)

    return act


def cellwise(distort: Callable[[World, float, Rng], Array]) -> Act:
    def act(world: World, size: float, rng: Rng) -> World:
        mask = somewhere(world, rng)
        return world.with_shown(np.where(mask, distort(world, size, rng), world.shown))

    return act


def added(signal: Callable[[World, float, Rng], Array]) -> Act:
    return cellwise(lambda world, size, rng: world.shown + signal(world, size, rng))
