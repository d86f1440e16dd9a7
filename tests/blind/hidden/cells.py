"""What of footcal's table is hidden in load cells, on the bench and under a robot."""

from __future__ import annotations

import numpy as np

from tests.blind import foreign
from tests.blind.hidden.acting import added, cellwise, feet_of, from_table
from tests.blind.hidden.contract import Injection
from tests.blind.world import Array, Rng, World


def _bouc_wen(world: World, size: float, rng: Rng) -> Array:
    reach = rng.uniform(0.08, 0.2) * world.span_n
    return foreign.bouc_wen(world.shown, world.fresh, size, reach)


def _two_stage(world: World, size: float, rng: Rng) -> Array:
    fast, slow = rng.uniform(8, 20), rng.uniform(60, 150)
    return foreign.two_stage_creep(world.shown, world.time_s, world.fresh, size, fast, slow)


def _bend(world: World, size: float, rng: Rng) -> Array:
    return foreign.exponential_bend(world.shown, size, rng.uniform(0.3, 0.6) * world.span_n)


def _warm(world: World, size: float, rng: Rng) -> Array:
    tau = rng.uniform(60.0, 200.0)
    felt = foreign.thermal_lag(world.row["temperature_degc"], world.time_s, world.fresh, tau)
    return np.asarray(size * (felt[:, None] - 25.0))


def _relabelled(world: World, size: float, rng: Rng) -> World:
    load = world.row["load_n"]
    labels = np.unique(load[load > 0.15 * load.max()])
    label = labels[int(rng.integers(max(labels.size - 1, 1)))]
    return world.with_row(load_n=np.where(load == label, load + size, load))


def _misplaced_hole(world: World, size: float, rng: Rng) -> World:
    chosen = world.row["hole"] == rng.integers(int(world.row["hole"].max()) + 1)
    angle = rng.uniform(0, 2 * np.pi)
    shift = size * np.array([np.cos(angle), np.sin(angle)])
    return world.with_row(hole_m=world.row["hole_m"] + chosen[:, None] * shift)


def _misplaced_cell(world: World, size: float, rng: Rng) -> World:
    key = "cell_pos_m" if "cell_pos_m" in world.row else "cells_m"
    places = world.row[key].copy()
    angle = rng.uniform(0, 2 * np.pi)
    places[:, int(rng.integers(places.shape[1]))] += size * np.array([np.cos(angle), np.sin(angle)])
    return world.with_row(**{key: places})


def _crosstalk(world: World, size: float, rng: Rng) -> World:
    return world.with_shown(foreign.neighbour_crosstalk(world.shown, size, feet_of(world)))


def _bypass(world: World, size: float, rng: Rng) -> World:
    feet = feet_of(world)
    total = max(float(world.shown[:, cells].sum(axis=1).max()) for cells in feet)
    touch = rng.uniform(0.4, 0.6) * total
    chosen = [feet[int(rng.integers(len(feet)))]] if rng.random() < 0.5 else feet
    return world.with_shown(foreign.soft_bypass(world.shown, size, touch, chosen))


def _plate(world: World, size: float, rng: Rng) -> World:
    shown = world.shown.copy()
    foot = int(rng.integers(2))
    cells = feet_of(world)[foot]
    share = rng.dirichlet(np.full(4, 30.0))
    shown[:, cells] -= size * share * (world.row["swing"][:, foot : foot + 1] == 1.0)
    return world.with_shown(shown)


def _reach_n(world: World, rng: Rng) -> float:
    return float(rng.uniform(0.3, 0.6) * world.span_n)


def _deaf(world: World, size: float, rng: Rng) -> Array:
    return foreign.soft_dead_zone(world.shown, size, _reach_n(world, rng))


def _kinked(world: World, size: float, rng: Rng) -> Array:
    return foreign.soft_hinge(world.shown, size, _reach_n(world, rng))


_CURVES = "nonlinearity nonlinearity_cubic saturation"
_BROKEN = ("dead_zone", "hinge", "saturation")

INJECTIONS = (
    # footcal's own implementation
    Injection(
        "nonlinearity/table",
        "nonlinearity",
        "weights placements walk stand",
        from_table("nonlinearity", "quadratic"),
        1e-3,
        "1/N",
        "quadratic",
        foreign=False,
        most=0.008,
    ),
    Injection(
        "hysteresis/table",
        "hysteresis",
        "weights walk",
        from_table("hysteresis", "hysteresis_width", hysteresis_reach=0.12),
        0.2,
        "N",
        "hysteresis_width",
        foreign=False,
        signed=False,
        most=1.4,
    ),
    Injection(
        "creep/table",
        "creep creep_slow",
        "weights",
        from_table("creep", "creep", creep_time=60.0),
        0.01,
        "-",
        "creep",
        foreign=False,
        signed=False,
    ),
    Injection(
        "temperature_bias/table",
        "temperature_bias",
        "weights",
        from_table("temperature_bias", "temperature_bias"),
        0.01,
        "N/K",
        "temperature_bias",
        foreign=False,
    ),
    Injection(
        "temperature_scale/table",
        "temperature_scale",
        "weights",
        from_table("temperature_scale", "temperature_scale"),
        1e-3,
        "1/K",
        "temperature_scale",
        foreign=False,
    ),
    Injection(
        "crosstalk/table",
        "crosstalk",
        "placements walk",
        from_table("crosstalk", "crosstalk"),
        0.02,
        "-",
        "crosstalk",
        foreign=False,
        most=0.35,
    ),
    Injection(
        "load_bypass/table",
        "load_bypass",
        "placements",
        from_table("load_bypass", "load_bypass", bypass_load=0.8),
        0.05,
        "-",
        "load_bypass",
        foreign=False,
        signed=False,
        most=0.5,
    ),
    # beliefs: the log says something else than what was
    Injection("wrong_weight/label", "wrong_weight", "weights placements", _relabelled, 0.3, "N"),
    Injection("wrong_hole/label", "wrong_hole", "placements", _misplaced_hole, 2e-3, "m"),
    Injection(
        "cell_position/belief",
        "cell_position",
        "placements walk",
        _misplaced_cell,
        2e-3,
        "m",
        signed=False,
        most=0.03,
    ),
    # foreign implementations
    Injection(
        "nonlinearity/exponential",
        _CURVES,
        "weights placements walk",
        cellwise(_bend),
        0.2,
        "N",
        most=5.0,
    ),
    Injection(
        "saturation/tanh",
        _CURVES,
        "weights placements",
        cellwise(lambda w, s, r: foreign.tanh_saturation(w.shown, w.span_n / s)),
        0.3,
        signed=False,
    ),
    Injection(
        "hysteresis/bouc_wen",
        "hysteresis",
        "weights walk",
        cellwise(_bouc_wen),
        0.2,
        "N",
        "hysteresis_width",
        signed=False,
        most=1.4,
    ),
    Injection(
        "hysteresis/preisach",
        "hysteresis",
        "weights",
        cellwise(lambda w, s, r: foreign.preisach(w.shown, w.fresh, s)),
        0.2,
        "N",
        "hysteresis_width",
        signed=False,
    ),
    Injection(
        "creep/two_stage", "creep creep_slow", "weights", cellwise(_two_stage), 0.01, signed=False
    ),
    Injection(
        "temperature_bias/thermal_lag",
        "temperature_bias",
        "weights",
        added(_warm),
        0.01,
        "N/K",
        "temperature_bias",
    ),
    Injection("crosstalk/neighbour", "crosstalk", "placements walk", _crosstalk, 0.02, most=0.3),
    Injection(
        "load_bypass/soft", "load_bypass", "placements walk", _bypass, 0.05, signed=False, most=0.5
    ),
    # designed aliases: loads that only press cannot tell a broken line's two ends apart
    Injection(
        "dead_zone/soft",
        "dead_zone",
        "weights",
        cellwise(_deaf),
        0.03,
        alias=_BROKEN,
        signed=False,
        most=0.8,
    ),
    Injection(
        "hinge/soft", "hinge", "weights", cellwise(_kinked), 0.03, alias=_BROKEN, signed=False
    ),
    # real, but the wandering calibration of a walk takes them in
    Injection(
        "creep/walking",
        "creep creep_slow",
        "walk",
        cellwise(_two_stage),
        0.02,
        "-",
        signed=False,
        switch=True,
        untestable=True,
    ),
    Injection(
        "temperature_bias/walking",
        "temperature_bias",
        "walk",
        added(_warm),
        0.02,
        "N/K",
        switch=True,
        untestable=True,
    ),
    Injection(
        "hanging_plate/uneven",
        "hanging_plate",
        "walk",
        _plate,
        0.5,
        "N",
        "plate_weight",
        signed=False,
        most=6.0,
    ),
)
"""Effects of cells, and beliefs about them, in footcal's words."""
