"""The paper's own procedure for hanging logs, step by step, and the naive one without tilt.

[Wu], sections III-A.2 to III-A.4: half-differences of a pair of opposite logs give the leg's
weight and, through a Kalman smoother, its CoM; half-sums give the offsets. Kept for comparison:
it treats the tilt as infinitesimal, and each step passes its error on to the next.

Not as printed: the costs of s⁺ and s⁻ are sums of root mean squares and standard deviations in the
paper, of their squares here (a least-squares solver squares what it is given); s⁻ is found for the
torque's three axes together, where the paper's one std of a vector leaves the sum unsaid.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footcal_cli.core.hang.model import leg_com_t_m
from footcal_cli.core.hang.runs import HangRun, hang_runs
from footcal_cli.core.inference.fit import least_squares_alone
from footcal_cli.core.inference.kalman import correct, innovate, predict, smooth_back
from footcal_cli.core.inference.linear import scaled_inverse
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.spatial import skew
from footcal_cli.errors import FitError

COST_TOLERANCE = 1e-3
SMOOTHER_VARIANCE = 0.01
_OPPOSITE = -0.9
_PARALLEL = 0.5
_SEEN = 1e-14


@dataclass(frozen=True)
class StepwiseFit:
    """What the stepwise procedure says of one leg; it gives no intervals.

    Parameters
    ----------
    leg
        Owner.
    weight_n
        m g, mean of the pairs.
    offset
        Shape (6,), N and Nm, mean of the pairs.
    com_m
        ``mean, sin, cos`` per axis, shape (3, 3), m; y is constant.
    turn_rad
        s of every orientation, in the order of `hang_runs`, shape (L, 3); zero outside the pairs.
    """

    leg: str
    weight_n: float
    offset: FloatArray
    com_m: FloatArray
    turn_rad: FloatArray

    def gravity_dir_t(self, runs: Sequence[HangRun]) -> FloatArray:
        """``(I + [s]) e`` per run, the paper's direction of gravity, shape (L, 3)."""
        down = np.stack([run.nominal_dir_t for run in runs])
        return down + np.cross(self.turn_rad, down)

    def com_t_m(self, phase_rad: FloatArray) -> FloatArray:
        """Leg CoM at shaft angles (...,), shape (..., 3)."""
        return leg_com_t_m(self.com_m, phase_rad)

    def residuals(self, runs: Sequence[HangRun]) -> list[FloatArray]:
        """What is left of each run's readings, ``(I + [s]) m g e`` taken for the force, (n, 6)."""
        left = []
        for run, down in zip(runs, self.gravity_dir_t(runs), strict=True):
            force = self.weight_n * down
            arm = leg_com_t_m(self.com_m, run.phase_rad)
            torque = np.cross(arm, force)
            applied = np.column_stack([np.broadcast_to(force, torque.shape), torque])
            left.append(run.wrench - self.offset - applied)
        return left

    def parameters(self) -> dict[str, float]:
        """The same by name: ``hl.weight``, ``hl.offset_fx``, ``hl.com_x_mean`` and so on."""
        names = ["weight"]
        names += [f"offset_{axis}" for axis in ("fx", "fy", "fz", "tx", "ty", "tz")]
        names += [f"com_{axis}_{term}" for axis in "xyz" for term in ("mean", "sin", "cos")]
        values = np.concatenate([[self.weight_n], self.offset, self.com_m.ravel()])
        return {f"{self.leg}.{n}": float(v) for n, v in zip(names, values, strict=True)}


@dataclass(frozen=True)
class _Pair:
    """Two opposite logs at the same shaft angles.

    Parameters
    ----------
    first, second
        Numbers of the runs.
    axis_t
        Nominal direction of gravity in the first log, shape (3,).
    phase_rad
        Shape (n,).
    minus, plus
        Half-difference and half-sum of the wrenches, shape (n, 6).
    """

    first: int
    second: int
    axis_t: FloatArray
    phase_rad: FloatArray
    minus: FloatArray
    plus: FloatArray


def fit_stepwise(logs: Sequence[Log], *, naive: bool = False) -> StepwiseFit:
    """Fit one leg as the paper does, or naively.

    Parameters
    ----------
    logs
        Hanging logs of one leg in two pairs of opposite orientations.
    naive
        True: no tilt at all, s⁺ = s⁻ = 0 (the baseline of [Wu], Fig. 5).

    Raises
    ------
    ValueError
        Without two pairs of opposite orientations.
    """
    return _steps(*_smoothed(logs), naive=naive)


def _smoothed(
    logs: Sequence[Log],
) -> tuple[str, tuple[HangRun, ...], list[_Pair], list[FloatArray]]:
    """Leg, runs, pairs, and the CoM each pair gives sample by sample."""
    runs, leg = hang_runs(logs)
    pairs = _pairs(runs)
    minus = np.stack([pair.minus for pair in pairs], axis=1)
    arms, _ = smooth_com(minus[..., :3], minus[..., 3:])
    return leg, runs, pairs, list(np.moveaxis(arms, 1, 0))


def _steps(
    leg: str,
    runs: Sequence[HangRun],
    pairs: Sequence[_Pair],
    arms: Sequence[FloatArray],
    *,
    naive: bool,
) -> StepwiseFit:
    turns = [np.zeros(3) if naive else _mean_turn(pair) for pair in pairs]
    weights = [_weight_n(pair, turn) for pair, turn in zip(pairs, turns, strict=True)]
    com_samples = _merged_com_m(pairs, arms)
    phase = pairs[0].phase_rad
    com = _sine_fit(phase, com_samples)

    offsets = []
    turn_of_run = np.zeros((len(runs), 3))
    for pair, weight, turn in zip(pairs, weights, turns, strict=True):
        arm = leg_com_t_m(com, pair.phase_rad)
        down = weight * pair.axis_t
        half = np.zeros(3) if naive else _half_turn(pair, arm, down)
        turn_of_run[pair.first], turn_of_run[pair.second] = turn + half, turn - half
        leak = np.cross(half, down)
        force = (pair.plus[:, :3] - leak).mean(axis=0)
        torque = (pair.plus[:, 3:] - np.cross(arm, leak)).mean(axis=0)
        offsets.append(np.concatenate([force, torque]))
    return StepwiseFit(leg, float(np.mean(weights)), np.mean(offsets, axis=0), com, turn_of_run)


def _pairs(runs: Sequence[HangRun]) -> list[_Pair]:
    """Opposite runs, the second interpolated onto the shaft angles of the first."""
    pairs: list[_Pair] = []
    for i, first in enumerate(runs):
        for j, second in enumerate(runs[i + 1 :], start=i + 1):
            opposite = first.nominal_dir_t @ second.nominal_dir_t < _OPPOSITE
            if opposite and all(
                abs(pair.axis_t @ first.nominal_dir_t) < _PARALLEL for pair in pairs
            ):
                phase = pairs[0].phase_rad if pairs else first.phase_rad
                w_first, w_second = _at_phase(first, phase), _at_phase(second, phase)
                minus, plus = 0.5 * (w_first - w_second), 0.5 * (w_first + w_second)
                pairs.append(_Pair(i, j, first.nominal_dir_t, phase, minus, plus))
    if len(pairs) < 2:
        raise FitError(
            "the stepwise method needs two pairs of opposite orientations (±x and ±z)",
            remedy="use --method joint",
        )
    return pairs[:2]


def _at_phase(run: HangRun, phase_rad: FloatArray) -> FloatArray:
    """Wrenches of a run at the shaft angles of another, matched along the slow turning."""
    own = np.unwrap(run.phase_rad)
    if own.size == phase_rad.size and np.abs(own - np.unwrap(phase_rad)).max() < 1e-3:
        return run.wrench
    order = np.argsort(own, kind="stable")
    low, turns = own[order[0]], np.floor(np.ptp(own) / (2 * np.pi))
    if turns < 1:
        raise FitError("the leg must turn at least once in every log", remedy="use --method joint")
    wanted = low + np.mod(np.unwrap(phase_rad) - low, 2 * np.pi * turns)
    return np.stack([np.interp(wanted, own[order], w[order]) for w in run.wrench.T], axis=1)


def _mean_turn(pair: _Pair) -> FloatArray:
    """s⁺ that turns the half-difference of force onto the axis (section III-A.2)."""
    along = int(np.argmax(np.abs(pair.axis_t)))
    across = [i for i in range(3) if i != along]

    def cost(turn: FloatArray) -> FloatArray:
        turned = np.linalg.solve(skew(turn) + np.eye(3), pair.minus[:, :3].T)
        norms = np.sqrt(np.mean(turned[across] ** 2, axis=1))
        return np.append(norms, turned[along].std())

    return least_squares_alone(cost, np.zeros(3), COST_TOLERANCE)


def _weight_n(pair: _Pair, turn: FloatArray) -> float:
    turned = np.linalg.solve(skew(turn) + np.eye(3), pair.minus[:, :3].T)
    return float(np.mean(pair.axis_t @ turned))


def smooth_com(force_n: FloatArray, torque_nm: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Leg CoM per sample (n, …, 3) and its covariance by a Rauch-Tung-Striebel smoother.

    State r, a random walk; observation ``τ⁻ = r × f⁻ = −[f⁻] r`` (section III-A.3). The component
    along f⁻ is not observed and stays where it started.
    """
    stays, drive = np.ones(3), np.full(3, SMOOTHER_VARIANCE)
    lever = -skew(force_n)
    found, ahead = [(np.zeros(force_n.shape[1:]), np.zeros(lever.shape[1:]) + np.eye(3))], []
    for h, torque in zip(lever, torque_nm, strict=True):
        mean, cov = predict(*found[-1], stays, drive)
        innovation = innovate(cov, h, torque - (h @ mean[..., None])[..., 0], np.diag(drive))
        found.append(correct(mean, cov, innovation))
        ahead.append((mean, cov))
    for i in range(len(ahead) - 1, 0, -1):
        found[i] = smooth_back(*found[i], stays, ahead[i], found[i + 1])
    means, variances = zip(*found[1:], strict=True)
    return np.array(means), np.array(variances)


def _merged_com_m(pairs: Sequence[_Pair], arms: Sequence[FloatArray]) -> FloatArray:
    """Fill each pair's unseen direction from the other pair, and average (section III-A.3)."""
    unit = [
        pair.minus[:, :3] / np.linalg.norm(pair.minus[:, :3], axis=1, keepdims=True)
        for pair in pairs
    ]
    matrix = np.stack([unit[0], -unit[1]], axis=2)
    across = np.swapaxes(matrix, -1, -2)
    shift = scaled_inverse(across @ matrix, _SEEN) @ across @ (arms[1] - arms[0])[..., None]
    first = arms[0] + shift[:, :1, 0] * unit[0]
    second = arms[1] + shift[:, 1:, 0] * unit[1]
    return np.asarray(0.5 * (first + second))


def _sine_fit(phase_rad: FloatArray, com_samples_m: FloatArray) -> FloatArray:
    """``A sin(φ + C) + D`` for x and z, a constant for y, as ``mean, sin, cos`` (3, 3)."""
    z = np.stack([np.ones_like(phase_rad), np.sin(phase_rad), np.cos(phase_rad)], axis=1)
    com = np.linalg.lstsq(z, com_samples_m, rcond=None)[0].T
    com[1] = [com_samples_m[:, 1].mean(), 0.0, 0.0]
    return np.asarray(com)


def _half_turn(pair: _Pair, arm_m: FloatArray, down_n: FloatArray) -> FloatArray:
    """s⁻ that makes the torque offset most nearly constant (section III-A.4)."""

    def cost(turn: FloatArray) -> FloatArray:
        torque = pair.plus[:, 3:] - np.cross(arm_m, np.cross(turn, down_n))
        return np.asarray(torque.std(axis=0))

    return least_squares_alone(cost, np.zeros(3), COST_TOLERANCE)
