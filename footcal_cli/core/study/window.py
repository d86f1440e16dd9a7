"""[NAO]'s sliding window, eq. (14), and Han's static assumption in the same window.

``min Σₖ ωF ((Fz(θ) − F_ref)/BW)² + ωP ‖(p(θ) − p_ref)/L_f‖² + ωS ‖θ − θ_prev‖²`` over 0.5 s,
every 4 samples, up to five Gauss-Newton iterations with bounded steps, θ the gains and biases in
centred units over their prior sd (see `footcal_cli.core.online.rows`).
"""

from __future__ import annotations

from dataclasses import dataclass
from types import ModuleType
from typing import NamedTuple

import numpy as np

from footcal_cli.core.centroidal import MIN_FORCE_N, pressure
from footcal_cli.core.experiments import walk
from footcal_cli.core.log import Log
from footcal_cli.core.online.belief import Belief
from footcal_cli.core.parameters import FloatArray, IntArray
from footcal_cli.errors import DataError


def window_loops() -> ModuleType | None:
    """`footcal_cli.core.study.window_loops`, or None without numba."""
    try:
        from footcal_cli.core.study import window_loops
    except ImportError:
        return None
    return window_loops


@dataclass(frozen=True)
class Weights:
    """Weights of eq. (14); each a scalar or shape (settings,).

    Parameters
    ----------
    force, cop
        ``ωF = 1/δF²``, ``ωP = 1/δP²``.
    smooth
        ωS, θ in prior sd.
    """

    force: FloatArray | float
    cop: FloatArray | float
    smooth: FloatArray | float

    def stacked(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Shape (settings,) each."""
        force, cop, smooth = np.broadcast_arrays(
            *[
                np.atleast_1d(np.asarray(w, dtype=float))
                for w in (self.force, self.cop, self.smooth)
            ]
        )
        return force, cop, smooth


@dataclass(frozen=True)
class WindowRule:
    """Shape of the window.

    Parameters
    ----------
    samples
        Length of the window (0.5 s at 80 Hz).
    every
        Samples between updates (20 Hz).
    iterations
        Gauss-Newton iterations per update, at most.
    largest_step
        Bound on each unknown's step per iteration, in prior sd.
    smallest_step
        After an iteration with shorter steps no other follows, in prior sd: each is about a
        thousandth of the one before it.
    foot_length_m
        L_f.
    min_force_n
        ε: below it the CoP is not defined, and its residual does not count.
    """

    samples: int = 40
    every: int = 4
    iterations: int = 5
    largest_step: float = 0.5
    smallest_step: float = 1e-6
    foot_length_m: float = 0.16
    min_force_n: float = MIN_FORCE_N


class WindowSquares(NamedTuple):
    """Weights of squared errors, shape (settings,) each: force, CoP, change of θ."""

    force: FloatArray
    cop: FloatArray
    smooth: FloatArray


class CellSamples(NamedTuple):
    """Forces (n, c) and positions (n, c, 2) of cells, Fz (n,), CoP (n, 2); unit of θ, (2c,)."""

    believed: FloatArray
    positions: FloatArray
    fz: FloatArray
    cop: FloatArray
    unit: FloatArray


@dataclass(frozen=True)
class WindowTrack:
    """Solutions of the window.

    Parameters
    ----------
    time_s, last_sample
        Of each update, shape (u,).
    gain, bias_n
        γ and β, shape (u, settings, c).
    """

    time_s: FloatArray
    last_sample: IntArray
    gain: FloatArray
    bias_n: FloatArray


def standing_weights(log: Log, belief: Belief, rule: WindowRule) -> Weights:
    """``ωF = 1/δF²`` and ``ωP = 1/δP²`` from the scatter of quiet standing; ωS is left at 1.

    Parameters
    ----------
    log
        The quiet part of a log, raw counts.
    belief
        Calibration to read it with.
    rule
        For the foot length.
    """
    problem = _Problem.of(log, belief, static=False)
    stood = pressure(belief.forces(log.readings)[problem.rows], problem.positions, rule.min_force_n)
    force_sd = float(np.std((stood.fz_n - problem.fz) / problem.weight_n))
    off = (stood.cop_m - problem.cop)[stood.valid] / rule.foot_length_m
    cop_sd = float(np.sqrt(np.mean(np.var(off, axis=0))))
    return Weights(1.0 / max(force_sd, 1e-6) ** 2, 1.0 / max(cop_sd, 1e-6) ** 2, 1.0)


@dataclass(frozen=True)
class _Problem:
    """The samples that count, by name."""

    rows: IntArray
    believed: FloatArray
    positions: FloatArray
    fz: FloatArray
    cop: FloatArray
    weight_n: float

    def weighed(self, weights: Weights, rule: WindowRule) -> WindowSquares:
        """Weights of squared errors in N and m."""
        force, cop, smooth = weights.stacked()
        return WindowSquares(
            force / self.weight_n**2, cop / rule.foot_length_m**2, np.array(smooth)
        )

    def plain(self, unit: FloatArray) -> CellSamples:
        """As the loops take them."""
        parts = (self.believed, self.positions, self.fz, self.cop, unit)
        return CellSamples(*(np.ascontiguousarray(part) for part in parts))

    @classmethod
    def of(cls, log: Log, belief: Belief, *, static: bool) -> _Problem:
        reference = walk.reference_of(log, static=static)
        believed = belief.forces(log.readings)
        balance = walk.cell_balance(log.with_readings(believed), reference)
        rows = np.flatnonzero(balance.valid[:, : len(walk.CELL_TOTALS)].all(axis=1))
        if rows.size == 0:
            raise DataError(
                "no sample can be used: no foot is known to stand",
                remedy="check contact, mass and units (footcal check)",
            )
        weight = float(np.mean(log.known["mass_kg"] * log.known["gravity_mps2"]))
        return cls(
            rows,
            believed[rows],
            log.known["cell_pos_m"][rows],
            reference.fz_n[rows],
            reference.cop_m[rows],
            weight,
        )


def run_window(
    log: Log,
    belief: Belief,
    weights: Weights,
    rule: WindowRule | None = None,
    *,
    static: bool = False,
    fast: bool = True,
) -> WindowTrack:
    """The paper's estimator as printed, for one or many settings of its weights.

    Parameters
    ----------
    log
        Walk with raw counts, filtered as wanted.
    belief
        Start θ = 0, and the unit of θ.
    weights
        ωF, ωP, ωS.
    static
        Han's static assumption: CoP below the CoM, Fz = m g.
    fast
        Use compiled loops where they are at hand; the array code gives the same to rounding.
    """
    rule = rule or WindowRule()
    problem = _Problem.of(log, belief, static=static)
    squares = problem.weighed(weights, rule)
    unit = np.concatenate([belief.gain_sd, belief.bias_sd_n])
    ends = np.arange(rule.every, len(log) + 1, rule.every)
    first = np.searchsorted(problem.rows, ends - rule.samples)
    stop = np.searchsorted(problem.rows, ends)
    solutions = np.empty((ends.size, squares.force.size, unit.size))
    loops = window_loops() if fast else None
    solve = _window_exact if loops is None else loops.window_exact
    solve(
        problem.plain(unit), squares, first, stop, rule.iterations, rule.largest_step,
        rule.smallest_step, rule.min_force_n, solutions,
    )  # fmt: skip
    return _track(log, ends, solutions * unit)


def _window_exact(
    samples: CellSamples,
    squares: WindowSquares,
    first: IntArray,
    stop: IntArray,
    iterations: int,
    largest_step: float,
    smallest_step: float,
    min_force_n: float,
    solutions: FloatArray,
) -> None:
    """`window_loops.window_exact` in array code."""
    (force_w, cop_w, smooth_w), unit = squares, samples.unit
    theta, identity = np.zeros((force_w.size, unit.size)), np.eye(unit.size)
    for j, part in enumerate(map(slice, first, stop)):
        if part.stop > part.start:
            previous = theta
            believed, positions = samples.believed[part], samples.positions[part]
            features = np.concatenate([believed, np.ones_like(believed)], axis=1) * unit
            axes = np.concatenate([positions, positions], axis=1)
            # the force row does not depend on θ: its normal matrix serves all iterations
            force_normal = features.T @ features
            moving = np.ones((force_w.size, 1), dtype=bool)
            for _ in range(iterations):
                total = believed.sum(axis=1) + theta @ features.T
                moment = np.einsum("nc,nck->nk", believed, positions) + np.einsum(
                    "bp,np,npk->bnk", theta, features, axes
                )
                carried = total > min_force_n
                safe = np.where(carried, total, 1.0)
                cop = moment / safe[:, :, None]
                slope = (axes[None] - cop[:, :, None, :]) * (features / safe[:, :, None])[..., None]
                slope *= carried[:, :, None, None]
                miss = (cop - samples.cop[part]) * carried[:, :, None]
                force_miss = total - samples.fz[part]
                normal = force_w[:, None, None] * force_normal
                normal = normal + cop_w[:, None, None] * _gram(slope)
                normal = normal + smooth_w[:, None, None] * identity
                pull = force_w[:, None] * (force_miss @ features)
                pull = pull + cop_w[:, None] * np.einsum("bnpk,bnk->bp", slope, miss)
                pull = pull + smooth_w[:, None] * (theta - previous)
                step = -np.linalg.solve(normal, pull[:, :, None])[:, :, 0]
                theta = theta + moving * np.clip(step, -largest_step, largest_step)
                moving &= np.abs(step).max(axis=1, keepdims=True) >= smallest_step
                if not moving.any():
                    break
        solutions[j] = theta


def _track(log: Log, ends: IntArray, solutions: FloatArray) -> WindowTrack:
    """Solutions (u, settings, 2c), each known after ``ends`` samples, shape (u,)."""
    c = len(log.channels)
    return WindowTrack(log.time_s[ends - 1], ends - 1, solutions[:, :, :c], solutions[:, :, c:])


def _gram(slope: FloatArray) -> FloatArray:
    """``Σ slope slopeᵀ`` over samples and axes, (b, n, p, k) -> (b, p, p)."""
    b, n, p, k = slope.shape
    flat = slope.transpose(0, 2, 1, 3).reshape(b, p, n * k)
    return np.asarray(flat @ flat.transpose(0, 2, 1))


def run_window_fast(
    log: Log,
    belief: Belief,
    weights: Weights,
    rule: WindowRule | None = None,
    *,
    static: bool = False,
    fast: bool = True,
) -> WindowTrack:
    """The same window with moments in place of the ratio: quadratic, so its sums slide.

    The CoP residual is weighed by the demanded Fz, ``(Σ pᵢ Fᵢ − p_ref Σ Fᵢ) / F_ref``, which makes
    it linear in θ; one linear solve replaces the iterations.

    Parameters
    ----------
    log, belief, weights, rule, static, fast
        As `run_window`.
    """
    rule = rule or WindowRule()
    problem = _Problem.of(log, belief, static=static)
    squares = problem.weighed(weights, rule)
    unit = np.concatenate([belief.gain_sd, belief.bias_sd_n])
    # sums per block of samples between updates, then over the blocks of the window
    blocks = len(log) // rule.every
    ends = np.arange(1, blocks + 1) * rule.every
    edges = np.searchsorted(problem.rows // rule.every, np.arange(blocks + 1))
    length = max(rule.samples // rule.every, 1)
    bound = rule.largest_step * rule.iterations
    solutions = np.empty((blocks, squares.force.size, unit.size))
    loops = window_loops() if fast else None
    solve = _window_sums if loops is None else loops.window_sums
    solve(problem.plain(unit), squares, edges, length, bound, solutions)
    return _track(log, ends, solutions * unit)


def _window_sums(
    samples: CellSamples,
    squares: WindowSquares,
    edges: IntArray,
    length: int,
    bound: float,
    solutions: FloatArray,
) -> None:
    """`window_loops.window_sums` in array code."""
    (force_w, cop_w, smooth_w), blocks = squares, edges.size - 1
    believed, unit = samples.believed, samples.unit
    features = np.concatenate([believed, np.ones_like(believed)], axis=1) * unit
    arms = (samples.positions - samples.cop[:, None]) / samples.fz[:, None, None]
    axes = np.concatenate([arms, arms], axis=1)
    moments = features[:, :, None] * axes
    force_miss = believed.sum(axis=1) - samples.fz
    moment_miss = np.einsum("nc,nck->nk", believed, arms)

    def slide(values: FloatArray) -> FloatArray:
        per_block = np.zeros((blocks, *values.shape[1:]))
        filled = np.diff(edges) > 0
        if filled.any():
            starts = edges[:-1][filled]
            per_block[filled] = np.add.reduceat(values[: edges[-1]], starts, axis=0)
        sums = np.cumsum(per_block, axis=0)
        sums[length:] -= sums[:-length].copy()
        return sums

    force_normal = slide(features[:, :, None] * features[:, None, :])
    cop_normal = slide(np.einsum("npk,nqk->npq", moments, moments))
    force_pull = slide(features * force_miss[:, None])
    cop_pull = slide(np.einsum("npk,nk->np", moments, moment_miss))
    theta = np.zeros((force_w.size, unit.size))
    ridge = smooth_w[:, None, None] * np.eye(unit.size)
    for j in range(blocks):
        normal = force_w[:, None, None] * force_normal[j] + cop_w[:, None, None] * cop_normal[j]
        pull = force_w[:, None] * (force_pull[j] + theta @ force_normal[j])
        pull = pull + cop_w[:, None] * (cop_pull[j] + theta @ cop_normal[j])
        step = -np.linalg.solve(normal + ridge, pull[:, :, None])[:, :, 0]
        theta = theta + np.clip(step, -bound, bound)
        solutions[j] = theta
