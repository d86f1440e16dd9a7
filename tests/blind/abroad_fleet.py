"""Causes hidden in logs of robots of all makes on load cells: 0.5 to 150 kg, three to six cells.

The hidden sizes are those of `tests.blind.abroad`, as shares of the robot's weight and height.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from tests.blind import foreign
from tests.blind.abroad import (
    ACC,
    COM,
    SECONDS,
    WIRING,
    Abroad,
    _clock,
    _exchanged,
    _mislabelled_weight,
    _pushed,
    _rested,
)
from tests.blind.abroad_legs import Hide, heavier, with_log
from tests.blind.abroad_streams import averaged, lateness
from tests.blind.classes import CREEP, CURVES, LATE, LEVEL, SUM
from tests.blind.world import Array, Rng
from tests.foreign import Distort, Recorded, joined, placements, stand, walk, weights
from tests.foreign.biped import draw_biped
from tests.foreign.kinds import DRAW, FLEET

MAKES = tuple(make for make in FLEET if 7001 <= make <= 7012 or 7201 <= make <= 7204)
"""Bipeds on cells whose owners use footcal's own axes."""
ALSO: Mapping[int, tuple[str, ...]] = {
    7003: ("hysteresis", "wrong_weight", "dead_zone", "hinge", "saturation"),
    7006: ("smoothing", "lag"),
    7008: ("wrong_weight",),
    7009: ("bias_drift",),
    7010: ("mass",),
    7012: ("angular_momentum",),
    7204: ("plate_inertia", "hanging_plate", "angular_momentum"),
}
"""What robots of a make truly have, whatever else is hidden."""

Record = Callable[..., Recorded]


def _seed(make: int, seed: int) -> int:
    return seed * DRAW + make


def _feet(loads: Array) -> list[list[int]]:
    """Columns of both feet."""
    half = loads.shape[1] // 2
    return [list(range(half)), list(range(half, 2 * half))]


def _chosen(rng: Rng, loads: Array) -> Array:
    """All cells, or one foot's, or one."""
    feet, count = _feet(loads), loads.shape[1]
    one = rng.integers(count, size=1)
    return np.asarray([np.arange(count), feet[0], one][int(rng.integers(3))])


Law = Callable[[Array, Array, float, Rng], Array]
"""``(time_s, loads of what is drawn, reach N, rng) -> loads``."""


def _law(law: Law, *, one: bool = False) -> Callable[[Rng], Distort]:
    """A law on cells that are drawn once for all of a log's pieces."""

    def drawn(rng: Rng) -> Distort:
        state = int(rng.integers(2**32))

        def distort(time_s: Array, loads: Array) -> Array:
            again = np.random.default_rng(state)
            own = again.integers(loads.shape[1], size=1) if one else _chosen(again, loads)
            out = loads.copy()
            out[:, own] = law(time_s, loads[:, own], float(np.percentile(loads, 99.5)), again)
            return out

        return distort

    return drawn


def _loop(share: float) -> Law:
    return lambda time_s, x, span, rng: foreign.bouc_wen(
        x, _rested(len(x)), share * span, 0.2 * span
    )


def _crept(time_s: Array, x: Array, span: float, rng: Rng) -> Array:
    fast, slow = rng.uniform(10, 25), rng.uniform(80, 200)
    return foreign.two_stage_creep(x, time_s, _rested(len(x)), 0.012, fast, slow)


def _bent(share: float) -> Law:
    return lambda time_s, x, span, rng: foreign.exponential_bend(
        x, rng.choice([-1.0, 1.0]) * share * span, rng.uniform(0.3, 0.6) * span
    )


def _kinked(share: float) -> Law:
    return lambda time_s, x, span, rng: foreign.soft_hinge(
        x, rng.choice([-1.0, 1.0]) * share, 0.55 * span
    )


def _jumped(time_s: Array, x: Array, span: float, rng: Rng) -> Array:
    """A fifth of the jump comes slowly after it."""
    when = time_s[0] + rng.uniform(0.2, 0.8) * np.ptp(time_s)
    since = np.maximum(time_s - when, 0.0)
    settled = np.where(time_s >= when, 1.0 - 0.2 * np.exp(-since / 3.0), 0.0)
    return np.asarray(x + rng.choice([-1.0, 1.0]) * 0.05 * span * settled[:, None])


def _drifting(share: float) -> Law:
    """The zero moves with the root of time, to a share of the largest load."""

    def law(time_s: Array, x: Array, span: float, rng: Rng) -> Array:
        late = np.sqrt((time_s - time_s.min()) / max(float(np.ptp(time_s)), 1e-9))[:, None]
        return np.asarray(x + rng.choice([-1.0, 1.0]) * share * span * late)

    return law


def _late_cell(time_s: Array, x: Array, span: float, rng: Rng) -> Array:
    return foreign.slow_part(x, time_s, _rested(len(x)), 0.05)


def _heard(share: float) -> Callable[[Rng], Distort]:
    return lambda rng: lambda t, loads: foreign.neighbour_crosstalk(loads, share, _feet(loads))


def _bypassed(share: float) -> Callable[[Rng], Distort]:
    def distort(time_s: Array, loads: Array) -> Array:
        feet = _feet(loads)
        total = max(float(loads[:, cells].sum(axis=1).max()) for cells in feet)
        return foreign.soft_bypass(loads, share, 0.5 * total, feet)

    return lambda rng: distort


def _walking(make: int, seed: int, distort: Distort | None = None, **options: Any) -> Recorded:
    own = _seed(make, seed)
    return joined(walk(own, seconds=SECONDS, distort=distort, **options), weights(own))


def _standing(make: int, seed: int, distort: Distort | None = None) -> Recorded:
    return joined(stand(_seed(make, seed), distort=distort), weights(_seed(make, seed)))


def _weighed(make: int, seed: int, distort: Distort | None = None) -> Recorded:
    return weights(_seed(make, seed), distort=distort)


def _placed(make: int, seed: int, distort: Distort | None = None, **options: Any) -> Recorded:
    own = _seed(make, seed)
    return joined(placements(own, rounds=2, distort=distort, **options), weights(own))


Of = Callable[[int], Hide]
"""Make -> how a cause is hidden in a robot of it."""


def _felt(record: Record, distort: Callable[[Rng], Distort]) -> Of:
    return lambda make: lambda seed, rng: record(make, seed, distort=distort(rng))


def _clean(record: Record) -> Of:
    return lambda make: lambda seed, rng: record(make, seed)


Heard = Callable[[Rng, float], Callable[[pd.DataFrame], pd.DataFrame]]
"""``(rng, height of the CoM, m) -> change of the body's stream``."""


def _body(record: Record, change: Heard) -> Of:
    def of(make: int) -> Hide:
        def hidden(seed: int, rng: Rng) -> Recorded:
            recorded = record(make, seed)
            body = recorded.logs["body"]
            changed = change(rng, float(body["com_z_m"].median()))(body.copy())
            return with_log(recorded, "body", changed)

        return hidden

    return of


def _late(make: int) -> Hide:
    return lambda seed, rng: _walking(make, seed, **lateness(rng))


def _elsewhere(make: int) -> Hide:
    """The recipe has one cell 8 mm, in units of a usual foot, from where it is."""

    def hidden(seed: int, rng: Rng) -> Recorded:
        recorded = _walking(make, seed)
        by_m, angle = 0.008 * FLEET[make].size, rng.uniform(0, 2 * np.pi)
        robot: dict[str, Any] = {**recorded.robot}
        spec = robot["feet"]["left"]
        cells = {name: dict(at) for name, at in spec["cells"].items()}
        name = list(cells)[int(rng.integers(len(cells)))]
        cells[name]["x_m"] += by_m * np.cos(angle)
        cells[name]["y_m"] += by_m * np.sin(angle)
        feet = {**robot["feet"], "left": {**spec, "cells": cells}}
        return replace(recorded, robot={**robot, "feet": feet})

    return hidden


def _moved(make: int) -> Hide:
    def hidden(seed: int, rng: Rng) -> Recorded:
        moved = np.zeros((len(draw_biped(_seed(make, seed)).channels), 2))
        moved[int(rng.integers(len(moved)))] = 0.003 * FLEET[make].size * rng.choice([-1.0, 1.0], 2)
        return _placed(make, seed, moved_m=moved)

    return hidden


def _dead(make: int) -> Hide:
    def hidden(seed: int, rng: Rng) -> Recorded:
        recorded = _walking(make, seed)
        table = recorded.logs["cells"].copy()
        name = str(rng.choice([c for c in table.columns if c.endswith("_counts")]))
        table[name] = table[name].iloc[0]
        return with_log(recorded, "cells", table)

    return hidden


def _plugs(record: Record, role: str, side: str) -> Of:
    """Two plugs of a foot in each other's socket; the far ones on a robot's left foot."""

    def of(make: int) -> Hide:
        def hidden(seed: int, rng: Rng) -> Recorded:
            first, last = (draw_biped(_seed(make, seed)).cells[i] for i in (0, -2))
            return _exchanged(record(make, seed), role, f"{side}{first}", f"{side}{last}")

        return hidden

    return of


def _labelled(record: Record, role: str, share: float) -> Of:
    return lambda make: lambda seed, rng: _mislabelled_weight(record(make, seed), role, share)


_KINDS: tuple[tuple[str, str, tuple[str, ...], Of], ...] = (
    ("weights", "", (), _clean(_weighed)),
    ("weights", "hysteresis", ("hysteresis",), _felt(_weighed, _law(_loop(0.012)))),
    ("weights", "creep", CREEP, _felt(_weighed, _law(_crept))),
    ("weights", "curve", CURVES, _felt(_weighed, _law(_bent(0.03)))),
    ("weights", "kink", CURVES, _felt(_weighed, _law(_kinked(0.05)))),
    ("weights", "drift", ("bias_drift",), _felt(_weighed, _law(_drifting(0.02), one=True))),
    ("weights", "label", ("wrong_weight",), _labelled(_weighed, "weights", 0.015)),
    ("placements", "", (), _clean(_placed)),
    ("placements", "cell", ("cell_position",), _moved),
    ("placements", "label", SUM, _labelled(_placed, "placements", 0.02)),
    ("placements", "crosstalk", ("crosstalk",), _felt(_placed, _heard(0.02))),
    ("placements", "bypass", SUM, _felt(_placed, _bypassed(0.06))),
    ("placements", "drift", ("bias_drift",), _felt(_placed, _law(_drifting(0.03), one=True))),
    ("placements", "curve", CURVES, _felt(_placed, _law(_bent(0.04)))),
    ("placements", "plugs", ("channel_swap",), _plugs(_placed, "placements", "")),
    ("walk", "", (), _clean(_walking)),
    ("walk", "accelerometer", LEVEL, _body(_walking, lambda r, h: _pushed(ACC, 0.15, r))),
    ("walk", "CoM", LEVEL, _body(_walking, lambda r, h: _pushed(COM, 0.035 * h, r))),
    ("walk", "late", LATE, _late),
    ("walk", "averaged", ("acceleration_delay",), _body(_walking, lambda r, h: averaged(r))),
    ("walk", "clock", ("clock_drift",), _body(_walking, lambda r, h: _clock(r))),
    ("walk", "hysteresis", ("hysteresis",), _felt(_walking, _law(_loop(0.07)))),
    ("walk", "crosstalk", ("crosstalk",), _felt(_walking, _heard(0.05))),
    ("walk", "curve", CURVES, _felt(_walking, _law(_bent(0.1)))),
    ("walk", "jump", ("bias_jump",), _felt(_walking, _law(_jumped, one=True))),
    ("walk", "bypass", ("load_bypass",), _felt(_walking, _bypassed(0.25))),
    ("walk", "cell", ("cell_position",), _elsewhere),
    ("walk", "slow cell", ("sensor_lag",), _felt(_walking, _law(_late_cell, one=True))),
    ("walk", "dead cell", ("channel_stuck",), _dead),
    ("walk", "plugs", ("channel_swap",), _plugs(_walking, "cells", "left_")),
    ("stand", "", (), _clean(_standing)),
    ("stand", "CoM", LEVEL, _body(_standing, lambda r, h: _pushed(COM, 0.045 * h, r))),
    ("stand", "mass", ("mass",), lambda make: lambda s, r: heavier(_standing(make, s), 0.06)),
    ("stand", "curve", CURVES, _felt(_standing, _law(_bent(0.1)))),
    ("stand", "crosstalk", ("crosstalk",), _felt(_standing, _heard(0.06))),
    ("stand", "plugs", ("channel_swap",), _plugs(_standing, "cells", "left_")),
)  # fmt: skip


def fleet_trials() -> Mapping[str, Abroad]:
    """``fleet walk 7003 late`` and its like: every cause on every make."""
    return {
        f"fleet {experiment} {make} {cause or 'clean'}": Abroad(
            experiment, cause, right, of(make), wiring=cause in WIRING, also=ALSO.get(make, ())
        )
        for experiment, cause, right, of in _KINDS
        for make in MAKES
    }


def mixed(name: str, number: int) -> bool:
    """Whether a fleet trial is in the mix of a number: each cause once, on one make."""
    experiment, make, *rest = name.removeprefix("fleet ").split(" ", 2)
    if not make.isdigit():
        return False  # of legs, whose makes are drawn
    cause = " ".join(rest)
    at = next(i for i, k in enumerate(_KINDS) if k[:2] == (experiment, cause.replace("clean", "")))
    return MAKES[(5 * number + 7 * at) % len(MAKES)] == int(make)
