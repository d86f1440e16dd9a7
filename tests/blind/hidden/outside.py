"""What happens to cells and is in no table of footcal: must be flagged, never named."""

from __future__ import annotations

import numpy as np

from tests.blind import foreign
from tests.blind.hidden.acting import added, cellwise, feet_of
from tests.blind.hidden.contract import Injection
from tests.blind.world import Array, Rng, World


def _hum(world: World, size: float, rng: Rng) -> Array:
    return foreign.mains_hum(rng, world.time_s, size, world.shown.shape[1])


def _tug(world: World, size: float, rng: Rng) -> Array:
    return foreign.cable_tug(rng, world.time_s, world.fresh, size)[:, None]


def _ring(world: World, size: float, rng: Rng) -> Array:
    step = float(np.median(np.diff(world.time_s)[np.diff(world.time_s) > 0]))
    return foreign.ringing(
        world.shown, world.time_s, world.fresh, size, rng.uniform(0.1, 0.3) / step, 8 * step
    )


def _edge(world: World, size: float, rng: Rng) -> World:
    return world.with_shown(
        foreign.edge_contact(world.shown, size, rng.uniform(0.52, 0.6), feet_of(world))
    )


INJECTIONS = (
    Injection("unseen/mains_hum", "", "weights walk", added(_hum), 0.1),
    Injection(
        "unseen/sticking_cell",
        "",
        "walk",
        cellwise(lambda w, s, r: foreign.sticking(r, w.shown, w.fresh, s)),
        0.3,
        signed=False,
    ),
    Injection("unseen/ringing", "", "walk", cellwise(_ring), 0.1, signed=False, most=1.5),
    Injection("unseen/cable_tug", "", "weights walk placements", added(_tug), 0.1),
    Injection(
        "unseen/edge_contact", "", "placements walk stand", _edge, 0.05, signed=False, most=1.0
    ),
)
"""Causes without right names."""
