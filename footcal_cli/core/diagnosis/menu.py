"""Which experiment next? A menu of feasible ones, judged by how far they push rivals apart.

Each plan is simulated: what an effect would do to the planned log at its fitted size, what of it
neither the refitted calibration nor the refitted rival can absorb, over the noise of this data.

The plans by id, and the kind of log that `diagnose` then reads:

``weights`` (ladders on each cell alone, several sessions)
    ``up_down`` eight steps up and down, 5 s each; ``random_order`` the same weights shuffled, each
    twice, 10 s; ``up_down_60s`` eight steps up and down, 60 s each; ``fine_ladder`` 24 steps up
    and down, 5 s each; ``push_pull`` eight steps up and down, then the same weights pulling;
    ``hold_5min`` the largest weight for 5 minutes, 5 minutes unloaded; ``ramps`` a slow load up
    and down (1 min) and two fast ones (3 s); ``taps`` 20 quick taps sampled at 80 Hz; ``warm_up``
    the largest weight on and off every 20 s while warming by 5 K.
``placements``
    ``holes`` one weight on 18 holes of each foot, at five sizes.
``stand``
    ``stand_turned`` quiet stances at three heights, facing four ways.
``walk`` (body and cells as streams)
    ``bounce`` on both feet: bouncing and swaying, tempo rising from 0.5 to 4 Hz;
    ``turn_and_bounce`` the same at three heights of the hips, facing four ways in turn;
    ``walk_turning`` walking a circle each way; ``walk_slow_fast`` steps of 1.2 s, then of 0.5 s.
``hang``
    ``hang`` hanging in two opposite pairs of orientations, legs turning slowly.
``pose``
    ``pose_tilted`` poses with the body tilted up to 15° and turned; ``pose_tripods`` poses on
    three legs in turn.

What no log can show (a spirit level, a scale) has no id; the table's own advice stands then.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from footcal_cli.core.chain import Chain
from footcal_cli.core.diagnosis.case import Case, rows_of
from footcal_cli.core.diagnosis.problem import Signature
from footcal_cli.core.diagnosis.signatures import derivative
from footcal_cli.core.effects.contract import Effect, Scope
from footcal_cli.core.experiments import weights
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray, ParameterSet

_CELL = "cell"


@dataclass(frozen=True)
class Plan:
    """A feasible experiment on one cell.

    Parameters
    ----------
    words
        What to do, for the experimenter.
    time_s, share
        Stamps and loads as shares of the largest load, shape (n,).
    warming_k
        Temperature rise over the experiment.
    """

    words: str
    time_s: FloatArray
    share: FloatArray
    warming_k: float = 0.0


@dataclass(frozen=True)
class Prospect:
    """What an experiment would do for a pair of rivals.

    Parameters
    ----------
    words
        The experiment.
    cosine
        |cos| of the rivals' visible signatures there.
    separation
        What of the named effect, at its fitted size, no size of the rival absorbs, over the noise
        of one run.
    repeats
        Runs for a power of 0.8 at α = 0.01.
    """

    words: str
    cosine: float
    separation: float
    repeats: int


def plans() -> tuple[Plan, ...]:
    """The menu for load cells."""
    ladder = np.array([0.0, 0.1, 0.25, 0.4, 0.55, 0.7, 0.85, 1.0])
    up_down = np.concatenate([ladder, ladder[-2::-1]])
    rng = np.random.default_rng(0)

    def holds(loads: FloatArray, hold_s: float, step_s: float) -> tuple[FloatArray, FloatArray]:
        each = max(int(hold_s / step_s), 1)
        time_s = np.arange(float(loads.size * each)) * step_s
        return np.asarray(time_s, dtype=float), np.asarray(np.repeat(loads, each))

    mixed = rng.permutation(np.tile(ladder, 2))
    taps = np.tile(np.concatenate([np.zeros(20), np.ones(5)]), 20)
    slow = np.concatenate([np.linspace(0, 1, 300), np.linspace(1, 0, 300)])
    fast = np.concatenate([np.linspace(0, 1, 15), np.linspace(1, 0, 15)])
    ramps = np.concatenate([slow, fast, fast, fast, fast])
    warm = np.tile(np.repeat([0.0, 1.0], 10), 20)
    cool_down = np.concatenate([np.ones(150), np.zeros(150)])
    return (
        Plan("weights up and down in eight steps, 5 s each", *holds(up_down, 5.0, 0.5)),
        Plan("weights in random order, each twice, 10 s each", *holds(mixed, 10.0, 1.0)),
        Plan("weights up and down in eight steps, 60 s each", *holds(up_down, 60.0, 4.0)),
        Plan("the largest weight for 5 minutes, then 5 minutes unloaded",
             np.arange(0.0, 600.0, 2.0), cool_down),
        Plan("20 quick taps with the largest weight, sampled at 80 Hz",
             np.linspace(0.0, taps.size / 80.0, taps.size), taps),
        Plan("one slow ramp up and down (1 min) and two fast ones (3 s)",
             np.linspace(0.0, ramps.size / 10.0, ramps.size), ramps),
        Plan("warming up by 5 K with the largest weight on and off every 20 s",
             np.linspace(0.0, 2.0 * warm.size, warm.size), warm, 5.0),
    )  # fmt: skip


def prospects(
    first: Signature,
    second: Signature,
    table: Mapping[str, Effect],
    size: float,
    noise_n: float,
    full_load_n: float,
) -> tuple[Prospect, ...]:
    """The menu for two rival cell effects, best separation first; empty for other effects.

    Parameters
    ----------
    first, second
        The named effect and its rival.
    table
        Effects by name.
    size
        Size of the named effect.
    noise_n, full_load_n
        Noise sd of one reading and the largest load.
    """
    effects = [table[s.effect] for s in (first, second)]
    if any(e.scope is not Scope.CHANNEL for e in effects):
        return ()
    found = []
    for plan in plans():
        g, h, j = _signatures(plan, (first, second), effects, full_load_n)
        g, h = (x - j @ np.linalg.lstsq(j, x, rcond=1e-9)[0] for x in (g, h))
        norms = np.sqrt((g @ g) * (h @ h))
        cosine = float(abs(g @ h) / norms) if norms > 0 else 0.0
        alone = g - h * ((g @ h) / (h @ h) if h @ h > 0 else 0.0)
        separation = float(np.sqrt(alone @ alone) * abs(size) / noise_n)
        found.append(Prospect(plan.words, cosine, separation, repeats_for(separation)))
    return tuple(sorted(found, key=lambda p: -p.separation))


def repeats_for(separation: float, alpha: float = 0.01, power: float = 0.8) -> int:
    """Runs whose pooled separation reaches ``z_{1−α/2} + z_power``; at least 10 blocks' worth."""
    if separation <= 0:
        return 10**6
    needed = float(stats.norm.ppf(1 - alpha / 2) + stats.norm.ppf(power))
    return max(int(np.ceil((needed / separation) ** 2)), 1)


def _signatures(
    plan: Plan, pair: Sequence[Signature], effects: Sequence[Effect], full_load_n: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Signatures of both rivals on a plan, and the calibration columns of one cell."""
    load = full_load_n * plan.share
    n = load.size
    log = Log(
        "weights",
        (_CELL,),
        plan.time_s,
        load[:, None],
        {
            "load_n": load[:, None],
            "temperature_degc": 25.0 + plan.warming_k * np.linspace(0, 1, n),
        },
        np.zeros(n, dtype=np.int64),
    )
    case = Case(weights.EXPERIMENT, (log,), Chain(()), {}, ParameterSet(()), 1.0, 1.0)
    rows = rows_of(case)
    unit = rows.noise
    columns = []
    for signature, effect in zip(pair, effects, strict=True):
        size = next(p for p in effect.parameters if p.name == signature.parameter)
        columns.append(
            unit * derivative(case, rows, effect, size, {_CELL: (_CELL,)}, dict(signature.shape))
        )
    order = rows.row
    return columns[0], columns[1], np.column_stack([np.ones(n), load])[order]


def advice(effects: Sequence[Effect]) -> str:
    """The table's own words on what separates these effects."""
    words = dict.fromkeys(e.separates for e in effects if e.separates)
    return "; or ".join(words)


__all__ = ["Plan", "Prospect", "advice", "plans", "prospects", "repeats_for"]
