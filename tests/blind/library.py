"""Effects as footcal's own table applies them: the half of the trials that is not foreign."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from footcal_cli.core.chain import chain_of, link
from footcal_cli.core.effects import find_effect
from footcal_cli.core.effects.contract import Scope
from footcal_cli.core.log import Log
from tests.blind.world import World


def of_a_foot(effect: str) -> bool:
    """Whether a row of footcal's table acts on whole feet: one cell alone cannot have it."""
    return find_effect(effect).scope is Scope.FOOT


def apply_from_table(
    world: World, effect: str, values: dict[str, float], mask: NDArray[np.bool_]
) -> World:
    """Distort the channels with a row of footcal's table, where `mask` (n, c) says so.

    Parameters
    ----------
    values
        Parameter -> value, the same for every owner.
    """
    row = find_effect(effect)
    known = (
        {"temperature_degc": world.row["temperature_degc"]}
        if "temperature_degc" in world.row
        else {}
    )
    shown = world.shown.copy()
    for block in np.unique(world.block):
        part = world.block == block
        log = Log(
            world.experiment,
            world.channels if world.shown.shape[1] > 1 else ("left_fl",),
            world.time_s[part],
            world.shown[part],
            {k: v[part] for k, v in known.items()},
            world.block[part],
        )
        item = link(row, log.channels)
        flat = {f"{owner}.{name}": value for owner in item.owners for name, value in values.items()}
        distorted, _ = chain_of([item]).apply(log, flat)
        shown[part] = distorted.readings
    return world.with_shown(np.where(mask, shown, world.shown))
