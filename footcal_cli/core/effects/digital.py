"""Mix-ups and faults of raw channels: stuck, swapped, duplicated."""

from __future__ import annotations

import numpy as np

from footcal_cli.core.effects.contract import (
    Effect,
    EffectParameter,
    Scope,
    Stage,
    State,
    Theta,
    Trait,
    on_readings,
    unchanged,
)
from footcal_cli.core.effects.memory import elapsed, recording
from footcal_cli.core.log import EXPERIMENT_NAMES, Log
from footcal_cli.core.parameters import FloatArray

_CHANNEL_GRID = tuple(float(i) for i in range(8))
_WHOLE = 1e-12


def _stick(x: FloatArray, log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    clock, held = state or (None, x[0])
    fresh = recording(log.time_s, clock[1] if clock else None).fresh
    since, clock = elapsed(log, clock)
    stuck = (since[:, None] >= theta["stuck_time"]) & ~fresh[:, None]
    last_free = np.maximum.accumulate(np.where(stuck, -1, np.arange(len(x))[:, None]), axis=0)
    shown = np.where(last_free < 0, held, np.take_along_axis(x, np.maximum(last_free, 0), axis=0))
    return x + theta["channel_stuck"] * np.where(stuck, shown - x, 0.0), (clock, shown[-1])


def _pair(theta: Theta, first: str, second: str, channels: int) -> tuple[int, int] | None:
    """The two columns that are mixed up, or None where the log has no such columns."""
    a, b = int(theta[first][0]), int(theta[second][0])
    return (a, b) if a != b and min(a, b) >= 0 and max(a, b) < channels else None


def _swap(x: FloatArray, _log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    return _exchange(x, theta, theta["channel_swap"][0]), state


def _unswap(y: FloatArray, _log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    share = theta["channel_swap"][0]
    return _exchange(y, theta, share / (2.0 * share - 1.0)), state


def _exchange(x: FloatArray, theta: Theta, share: float) -> FloatArray:
    """Move a share of the difference between the two channels from one to the other."""
    pair = _pair(theta, "swap_first", "swap_second", x.shape[1])
    if pair is None:
        return x
    difference = share * (x[:, pair[1]] - x[:, pair[0]])
    mixed = x.copy()
    mixed[:, pair[0]] += difference
    mixed[:, pair[1]] -= difference
    return mixed


def _duplicate(x: FloatArray, _log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    pair = _pair(theta, "duplicate_of", "duplicate_on", x.shape[1])
    if pair is None:
        return x, state
    copied = x.copy()
    copied[:, pair[1]] += theta["channel_duplicate"][0] * (x[:, pair[0]] - x[:, pair[1]])
    return copied, state


def _unduplicate(y: FloatArray, _log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    pair = _pair(theta, "duplicate_of", "duplicate_on", y.shape[1])
    share = theta["channel_duplicate"][0]
    if pair is None or abs(1.0 - share) < _WHOLE:
        return y, state
    own = y.copy()
    own[:, pair[1]] = (y[:, pair[1]] - share * y[:, pair[0]]) / (1.0 - share)
    return own, state


CHANNEL_STUCK = Effect(
    name="channel_stuck",
    traits=(Trait.UNGRADED,),
    stage=Stage.DIGITAL,
    scope=Scope.CHANNEL,
    parameters=(
        EffectParameter("channel_stuck", "-", 0.0, 0.0, 1.0, 0.3),
        EffectParameter(
            "stuck_time", "s", 0.0, 0.0, 1e6, 20.0, True, (0.0, 5.0, 10.0, 20.0, 30.0, 60.0)
        ),
    ),
    apply=on_readings(_stick),
    remove=on_readings(unchanged),
    experiments=EXPERIMENT_NAMES,
    formula="y = x + s (x(t_stuck) − x) for t − t₀ ≥ t_stuck, s = 1 for a frozen channel",
    source="broken wire, hung converter, telemetry that repeats its last value",
    remedy="reconnect or replace the channel; leave its samples out",
    mimics=("dead_zone", "saturation"),
    separates="press the cell by hand: nothing moves",
    invertible=False,
)

CHANNEL_SWAP = Effect(
    name="channel_swap",
    traits=(Trait.SWITCH, Trait.SYMMETRIC, Trait.SMALL_CELL),
    stage=Stage.DIGITAL,
    scope=Scope.ROBOT,
    parameters=(
        EffectParameter("channel_swap", "-", 0.0, 0.0, 1.0, 0.3),
        EffectParameter("swap_first", "channel", 0.0, 0.0, 127.0, 1.0, True, _CHANNEL_GRID),
        EffectParameter("swap_second", "channel", 1.0, 0.0, 127.0, 1.0, True, _CHANNEL_GRID),
    ),
    apply=on_readings(_swap),
    remove=on_readings(_unswap),
    experiments=("placements", "stand", "walk", "pose"),
    formula="y_a = x_a + s (x_b − x_a), y_b = x_b + s (x_a − x_b), s = 1 for exchanged plugs",
    source="plugs or names of two channels exchanged",
    remedy="exchange the two plugs, or the two names in the recipe",
    mimics=("crosstalk", "cell_position"),
    separates="press one cell by hand: the other one's reading moves",
)

CHANNEL_DUPLICATE = Effect(
    name="channel_duplicate",
    traits=(Trait.UNGRADED,),
    stage=Stage.DIGITAL,
    scope=Scope.ROBOT,
    parameters=(
        EffectParameter("channel_duplicate", "-", 0.0, 0.0, 1.0, 0.3),
        EffectParameter("duplicate_of", "channel", 0.0, 0.0, 127.0, 1.0, True, _CHANNEL_GRID),
        EffectParameter("duplicate_on", "channel", 1.0, 0.0, 127.0, 1.0, True, _CHANNEL_GRID),
    ),
    apply=on_readings(_duplicate),
    remove=on_readings(_unduplicate),
    experiments=("placements", "stand", "walk", "pose"),
    formula="y_b = x_b + s (x_a − x_b), s = 1 where b shows what a shows",
    source="one converter read twice; a copied column (NAO CoP self-calibration, Table 2 looks "
    "like it)",
    remedy="check the addresses of the converters and the logging code",
    mimics=("channel_stuck", "crosstalk"),
    separates="press one cell by hand: both readings move alike",
    invertible=False,
)

EFFECTS = (CHANNEL_STUCK, CHANNEL_SWAP, CHANNEL_DUPLICATE)
