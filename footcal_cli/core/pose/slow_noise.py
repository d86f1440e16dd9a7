"""Noise that lasts from pose to pose: its law, and the Gram matrix that it leaves.

A transducer's reading drifts while the robot steps from pose to pose; neighbouring poses then say
the same thing twice. All channels share one correlation over poses,

    C = (1 − s) I + s exp(−|p − q| / τ),

a white part and a first-order autoregression of share s and memory τ. Maximum likelihood over
mounting and true wrenches depends on the poses through ``S = Xᵀ C⁻¹ X`` alone, so that a fit
weighs slow noise right with another Gram matrix and nothing else. Share and memory are those of
the highest restricted likelihood (Patterson & Thompson 1971), which knows that the fit itself took
slow noise away.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.inference.descent import newton_step
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.pose.data import PoseData, PoseSummary, summarise
from footcal_cli.core.pose.hanging import LegKnowledge
from footcal_cli.core.pose.joint import PoseFit, fit_pose
from footcal_cli.core.pose.problem import PoseCost, PoseOptions

_SHARES = (0.05, 0.1, 0.2, 0.3, 0.45, 0.6, 0.8, 0.95)
_MEMORIES = 9
_SHORTEST = 1.0
_MIN_FREEDOM = 120
"""Balance errors beyond the fitted mounting below which their memory cannot be determined."""
_ROUNDS = 2
_NO_SCALE, _SURELY = 10.0, 2.0
_SETTLED = 1e-10


@dataclass(frozen=True)
class SlowNoise:
    """Correlation of the noise over poses.

    Parameters
    ----------
    share
        Part s of the variance that lasts; 0: every pose's noise is fresh.
    memory_poses
        τ, in poses.
    """

    share: float = 0.0
    memory_poses: float = 1.0

    def whitened(self, columns: FloatArray) -> tuple[FloatArray, float]:
        """``L⁻¹ X`` with ``C = L Lᵀ``, shape (P, c), and ``log det C``.

        Innovations of a Kalman filter of the slow part; once its gain is constant, a recursion.
        """
        if self.share == 0.0:
            return columns, 0.0
        decay, white = float(np.exp(-1.0 / self.memory_poses)), 1.0 - self.share
        out, state = np.empty_like(columns), np.zeros(columns.shape[1])
        variance, logarithms = self.share, 0.0
        for p, row in enumerate(columns):
            total = variance + white
            gain = variance / total
            out[p] = (row - state) / np.sqrt(total)
            logarithms += np.log(total)
            state = decay * (state + gain * (row - state))
            new = decay**2 * variance * (1.0 - gain) + self.share * (1.0 - decay**2)
            settled, variance = abs(new - variance) < _SETTLED, new
            if settled and p + 1 < columns.shape[0]:
                break
        else:
            return out, logarithms
        from scipy.signal import lfilter

        # state' = d (1 − k) state + d k x from here on
        left = columns[p + 1 :]
        total = variance + white
        gain = variance / total
        feedback = decay * (1.0 - gain)
        later = lfilter([decay * gain], [1.0, -feedback], left, axis=0, zi=feedback * state[None])
        before = np.concatenate([state[None], np.asarray(later[0])[:-1]])
        out[p + 1 :] = (left - before) / np.sqrt(total)
        return out, logarithms + left.shape[0] * float(np.log(total))

    def summarise(self, data: PoseData) -> PoseSummary:
        """`summarise` with ``Xᵀ C⁻¹ X`` in the place of ``Xᵀ X``."""
        white, _ = self.whitened(data.features())
        return replace(summarise(data), gram=white.T @ white)


def fit_pose_slowly(
    data: PoseData,
    legs: tuple[LegKnowledge, ...],
    noise_sd: FloatArray,
    options: PoseOptions | None = None,
) -> tuple[PoseFit, SlowNoise]:
    """`fit_pose` with noise that may last from pose to pose, and the law found for it.

    Parameters
    ----------
    data
        Poses in the order in which they were recorded.
    legs, noise_sd, options
        As for `fit_pose`; `noise_sd` is the whole noise of a pose, slow part and fresh part.
    """
    law = SlowNoise()
    fit = fit_pose(summarise(data), legs, noise_sd, options)
    freedom = 6 * len(data) - fit.free
    if freedom < _MIN_FREEDOM or not fit.converged:
        return fit, law
    # a scale that is wrong must not pass for a drift of all sensors: the weight is left free
    blind = replace(fit.options, robot_weight_sd_n=_NO_SCALE * data.robot_weight_n)
    free = fit_pose(summarise(data), legs, noise_sd, blind)
    for _ in range(_ROUNDS):
        found = _likeliest(data, legs, noise_sd, free)
        if found == law:
            break
        law = found
        free = fit_pose(law.summarise(data), legs, noise_sd, blind)
    # poses noisier than the sensors are said to be widen the intervals as much
    level = free.noise_factor if fit.options.noise_known else 1.0
    if level < 1.0 + _SURELY / np.sqrt(2.0 * freedom):
        level = 1.0
    if law.share > 0.0 or level > 1.0:
        fit = fit_pose(law.summarise(data), legs, level * noise_sd, fit.options)
        chi2, factor = level**2 * fit.chi2_poses, level * fit.noise_factor
        fit = replace(fit, chi2_poses=chi2, noise_factor=factor)
    return fit, law


def _likeliest(
    data: PoseData, legs: tuple[LegKnowledge, ...], noise_sd: FloatArray, fit: PoseFit
) -> SlowNoise:
    """The law of the highest restricted likelihood near a fit; fresh noise if none is better."""
    memories = np.geomspace(_SHORTEST, len(data) / 2.0, _MEMORIES)
    laws = [SlowNoise(share, float(memory)) for share in _SHARES for memory in memories]
    features = data.features()
    problem = PoseCost.of(summarise(data), legs, noise_sd, fit.options)
    costs = [_cost(law, features, problem, fit) for law in (SlowNoise(), *laws)]
    best = int(np.argmin(costs))
    # two more parameters: their price by the Bayesian information criterion
    if best == 0 or costs[0] - costs[best] < np.log(6.0 * len(data)):
        return SlowNoise()
    return laws[best - 1]


def _cost(law: SlowNoise, features: FloatArray, problem: PoseCost, fit: PoseFit) -> float:
    """−log restricted likelihood, the level of the noise profiled out."""
    white, logarithm = law.whitened(features)
    summary = replace(problem.summary, gram=white.T @ white)
    state = replace(problem, summary=summary).at(fit.mounting, fit.noise_factor)
    step, scaled, scale = newton_step(state)
    gained = -0.5 * float(state.gradient @ step)
    count = 6 * summary.poses - fit.free
    level = max(state.chi2_poses - 2.0 * gained, np.finfo(float).tiny)
    determinant = np.linalg.slogdet(scaled)[1] - 2.0 * np.log(scale).sum()
    return float(0.5 * count * np.log(level) + 3.0 * logarithm + 0.5 * determinant)
