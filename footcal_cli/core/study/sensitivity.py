"""How much each weight and noise matters: every one scaled, all settings in one batched pass."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from footcal_cli.core.centroidal import MIN_FORCE_N, Reference
from footcal_cli.core.log import Log
from footcal_cli.core.online.belief import Belief
from footcal_cli.core.online.evidence import SETTLING_S, rms
from footcal_cli.core.online.filter import Noise, run_settings
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
    factors: FloatArray = FACTORS,
    min_force_n: float = MIN_FORCE_N,
) -> list[Sensitivity]:
    """RMSE of the filter with each noise scaled, all in one batched pass."""
    names = list(settings or (f.name for f in fields(Noise)))
    base = {f.name: float(np.asarray(getattr(memory.noise, f.name))) for f in fields(Noise)}
    size = len(names) * factors.size
    table = {name: np.full(size, value) for name, value in base.items()}
    for i, name in enumerate(names):
        table[name][i * factors.size : (i + 1) * factors.size] *= factors
    late = memory.log.time_s - memory.log.time_s[0] > SETTLING_S
    _, values, momentary = run_settings(memory.rows, Noise(**table))
    scores = []
    for b in range(size):
        own = None if momentary is None else momentary[:, b]
        track = replace(memory.track, values=values[:, b], momentary=own)
        error = errors_against(replay_track("memory", memory, track, belief, min_force_n), truth)
        scores.append((rms(error.cop_m[late]), rms(error.vgrf_n[late])))
    return _curves(names, factors, np.array(scores))


def window_sensitivity(
    log: Log,
    belief: Belief,
    weights: Weights,
    truth: Replayed | Reference,
    rule: WindowRule | None = None,
    factors: FloatArray = FACTORS,
) -> list[Sensitivity]:
    """RMSE of the paper's window with ωF, ωP, ωS scaled, all in one batched pass."""
    rule = rule or WindowRule()
    names = ("force", "cop", "smooth")
    table = {n: np.full(3 * factors.size, float(np.asarray(getattr(weights, n)))) for n in names}
    for i, name in enumerate(names):
        table[name][i * factors.size : (i + 1) * factors.size] *= factors
    track = run_window_fast(log, belief, Weights(**table), rule)
    late = log.time_s - log.time_s[0] > SETTLING_S
    scores = []
    for b in range(3 * factors.size):
        error = errors_against(
            replay_window("window", log, belief, track, b, rule.min_force_n), truth
        )
        scores.append((rms(error.cop_m[late]), rms(error.vgrf_n[late])))
    return _curves(["omega_f", "omega_p", "omega_s"], factors, np.array(scores))


def _curves(names: Sequence[str], factors: FloatArray, scores: FloatArray) -> list[Sensitivity]:
    f = factors.size
    return [
        Sensitivity(name, factors, scores[i * f : (i + 1) * f, 0], scores[i * f : (i + 1) * f, 1])
        for i, name in enumerate(names)
    ]
