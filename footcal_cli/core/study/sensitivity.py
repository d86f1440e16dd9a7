"""How much each weight and noise matters: every one scaled, all settings in one batched pass."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from footcal_cli.core.centroidal import MIN_FORCE_N, Reference
from footcal_cli.core.log import Log
from footcal_cli.core.online.belief import Belief
from footcal_cli.core.online.evidence import SETTLING_S, rms
from footcal_cli.core.online.filter import WalkNoise, run_settings
from footcal_cli.core.online.memory import Memory, replay_track
from footcal_cli.core.online.replay import Replayed, errors_against
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.study.window import Weights, WindowRule, run_window_fast
from footcal_cli.core.study.windows import replay_window


@dataclass(frozen=True)
class Sensitivity:
    """RMSE as one setting is scaled, all others kept.

    Parameters
    ----------
    setting
        Name of the weight or noise.
    factors
        Shape (f,).
    cop_m, vgrf_n
        RMSE once settled (`footcal_cli.core.online.evidence.SETTLING_S`), shape (f,).
    """

    setting: str
    factors: FloatArray
    cop_m: FloatArray
    vgrf_n: FloatArray


FACTORS = np.array([0.2, 0.5, 1.0, 2.0, 5.0])
"""As in [NAO], section 3.3.2."""


def memory_sensitivity(
    memory: Memory,
    belief: Belief,
    truth: Replayed | Reference,
    settings: Sequence[str] | None = None,
    min_force_n: float = MIN_FORCE_N,
) -> list[Sensitivity]:
    """RMSE of the filter with each noise scaled, all in one batched pass."""
    names = list(settings or (f.name for f in fields(WalkNoise)))
    base = {f.name: float(np.asarray(getattr(memory.noise, f.name))) for f in fields(WalkNoise)}
    table = _one_by_one(base, names)
    late = memory.log.time_s - memory.log.time_s[0] > SETTLING_S
    _, values, momentary = run_settings(memory.rows, WalkNoise(**table))
    scores = []
    for b in range(len(names) * FACTORS.size):
        own = None if momentary is None else momentary[:, b]
        track = replace(memory.track, values=values[:, b], momentary=own)
        error = errors_against(replay_track("memory", memory, track, belief, min_force_n), truth)
        scores.append((rms(error.cop_m[late]), rms(error.vgrf_n[late])))
    return _curves(names, np.array(scores))


def window_sensitivity(
    log: Log,
    belief: Belief,
    weights: Weights,
    truth: Replayed | Reference,
    rule: WindowRule | None = None,
) -> list[Sensitivity]:
    """RMSE of the paper's window with ωF, ωP, ωS scaled, all in one batched pass."""
    rule = rule or WindowRule()
    names = ("force", "cop", "smooth")
    table = _one_by_one({n: float(np.asarray(getattr(weights, n))) for n in names}, names)
    track = run_window_fast(log, belief, Weights(**table), rule)
    late = log.time_s - log.time_s[0] > SETTLING_S
    scores = []
    for b in range(3 * FACTORS.size):
        error = errors_against(
            replay_window("window", log, belief, track, b, rule.min_force_n), truth
        )
        scores.append((rms(error.cop_m[late]), rms(error.vgrf_n[late])))
    return _curves(["omega_f", "omega_p", "omega_s"], np.array(scores))


def _one_by_one(base: Mapping[str, float], names: Sequence[str]) -> dict[str, FloatArray]:
    """Settings in which one after the other is scaled by every factor, shape (names · factors,)."""
    table = {name: np.full(len(names) * FACTORS.size, value) for name, value in base.items()}
    for i, name in enumerate(names):
        table[name][i * FACTORS.size : (i + 1) * FACTORS.size] *= FACTORS
    return table


def _curves(names: Sequence[str], scores: FloatArray) -> list[Sensitivity]:
    f = FACTORS.size
    return [
        Sensitivity(name, FACTORS, scores[i * f : (i + 1) * f, 0], scores[i * f : (i + 1) * f, 1])
        for i, name in enumerate(names)
    ]
