"""Quiet standing in many stances, one log."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tests.blind.world import Maker, Rng, World, affine_calibrations
from tests.blind.worlds import walk
from tests.blind.worlds.gait import draw_build, stances


def draw(rng: Rng, options: Mapping[str, Any]) -> World:
    """A robot in 20–25 stances of a few seconds."""
    build = draw_build(rng)
    count = int(options.get("blocks") or rng.integers(20, 26))
    motion = stances(rng, build, count, float(rng.uniform(3.0, 4.0)))
    return walk.logged(rng, "stand", build, motion, drift=bool(options.get("drift")))


MAKER = Maker(draw, walk.error, affine_calibrations, walk.write)
