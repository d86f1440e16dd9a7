"""What is hidden in load cells, on the bench and under a robot."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from tests.blind import foreign
from tests.blind.hidden.contract import Act, Injection, Mask
from tests.blind.library import apply_from_table
from tests.blind.world import Array, Rng, World


def _somewhere(world: World, rng: Rng) -> Mask:
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


def _feet(world: World) -> list[list[int]]:
    names = [channel.split("_")[0] for channel in world.channels]
    return [[i for i, n in enumerate(names) if n == foot] for foot in dict.fromkeys(names)]


def _table(effect: str, parameter: str, **shapes: float) -> Act:
    """An effect of footcal's table; a shape above zero is a share of the span, else as it is."""

    def act(world: World, size: float, rng: Rng) -> World:
        mask = _somewhere(world, rng)
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


def _cellwise(distort: Callable[[World, float, Rng], Array]) -> Act:
    def act(world: World, size: float, rng: Rng) -> World:
        mask = _somewhere(world, rng)
        return world.with_shown(np.where(mask, distort(world, size, rng), world.shown))

    return act


def _added(signal: Callable[[World, float, Rng], Array]) -> Act:
    return _cellwise(lambda world, size, rng: world.shown + signal(world, size, rng))


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
    return world.with_shown(foreign.neighbour_crosstalk(world.shown, size, _feet(world)))


def _bypass(world: World, size: float, rng: Rng) -> World:
    feet = _feet(world)
    total = max(float(world.shown[:, cells].sum(axis=1).max()) for cells in feet)
    touch = rng.uniform(0.4, 0.6) * total
    chosen = [feet[int(rng.integers(len(feet)))]] if rng.random() < 0.5 else feet
    return world.with_shown(foreign.soft_bypass(world.shown, size, touch, chosen))


def _plate(world: World, size: float, rng: Rng) -> World:
    shown = world.shown.copy()
    foot = int(rng.integers(2))
    cells = _feet(world)[foot]
    share = rng.dirichlet(np.full(4, 30.0))
    shown[:, cells] -= size * share * (world.row["swing"][:, foot : foot + 1] == 1.0)
    return world.with_shown(shown)


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
        foreign.edge_contact(world.shown, size, rng.uniform(0.52, 0.6), _feet(world))
    )


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
        _table("nonlinearity", "quadratic"),
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
        _table("hysteresis", "hysteresis_width", hysteresis_reach=0.12),
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
        _table("creep", "creep", creep_time=60.0),
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
        _table("temperature_bias", "temperature_bias"),
        0.01,
        "N/K",
        "temperature_bias",
        foreign=False,
    ),
    Injection(
        "temperature_scale/table",
        "temperature_scale",
        "weights",
        _table("temperature_scale", "temperature_scale"),
        1e-3,
        "1/K",
        "temperature_scale",
        foreign=False,
    ),
    Injection(
        "crosstalk/table",
        "crosstalk",
        "placements walk",
        _table("crosstalk", "crosstalk"),
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
        _table("load_bypass", "load_bypass", bypass_load=0.8),
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
        _cellwise(_bend),
        0.2,
        "N",
        most=5.0,
    ),
    Injection(
        "saturation/tanh",
        _CURVES,
        "weights placements",
        _cellwise(lambda w, s, r: foreign.tanh_saturation(w.shown, w.span_n / s)),
        0.3,
        signed=False,
    ),
    Injection(
        "hysteresis/bouc_wen",
        "hysteresis",
        "weights walk",
        _cellwise(_bouc_wen),
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
        _cellwise(lambda w, s, r: foreign.preisach(w.shown, w.fresh, s)),
        0.2,
        "N",
        "hysteresis_width",
        signed=False,
    ),
    Injection(
        "creep/two_stage", "creep creep_slow", "weights", _cellwise(_two_stage), 0.01, signed=False
    ),
    Injection(
        "temperature_bias/thermal_lag",
        "temperature_bias",
        "weights",
        _added(_warm),
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
        _cellwise(_deaf),
        0.03,
        alias=_BROKEN,
        signed=False,
        most=0.8,
    ),
    Injection(
        "hinge/soft", "hinge", "weights", _cellwise(_kinked), 0.03, alias=_BROKEN, signed=False
    ),
    # real, but the wandering calibration of a walk takes them in
    Injection(
        "creep/walking",
        "creep creep_slow",
        "walk",
        _cellwise(_two_stage),
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
        _added(_warm),
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
    # wiring: there or not
    Injection("channel_swap/wires", "channel_swap", "placements walk", _swap, 1.0, switch=True),
    Injection("channel_stuck/frozen", "channel_stuck", "walk", _stuck, 1.0, switch=True),
    Injection(
        "channel_duplicate/wires",
        "channel_duplicate",
        "placements walk",
        _duplicate,
        1.0,
        switch=True,
    ),
    # not in the library
    Injection("unseen/mains_hum", "", "weights walk", _added(_hum), 0.1),
    Injection(
        "unseen/sticking_cell",
        "",
        "walk",
        _cellwise(lambda w, s, r: foreign.sticking(r, w.shown, w.fresh, s)),
        0.3,
        signed=False,
    ),
    Injection("unseen/ringing", "", "walk", _cellwise(_ring), 0.1, signed=False, most=1.5),
    Injection("unseen/cable_tug", "", "weights walk placements", _added(_tug), 0.1),
    Injection(
        "unseen/edge_contact", "", "placements walk stand", _edge, 0.05, signed=False, most=1.0
    ),
)
