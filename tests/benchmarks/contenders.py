"""Each online kernel beside what a user would write, the array code and the C limit."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from scipy.optimize import least_squares

from footcal_cli.core.centroidal import MIN_FORCE_N
from footcal_cli.core.log import Log
from footcal_cli.core.online.belief import Belief
from footcal_cli.core.online.filter import Guards, WalkNoise, run_filter, run_settings
from footcal_cli.core.online.passes import Pass
from footcal_cli.core.online.rows import cell_rows
from footcal_cli.core.online.smoother import run_smoother
from footcal_cli.core.parameters import FloatArray, IntArray
from footcal_cli.core.study.window import Weights, WindowRule, _Problem, run_window, run_window_fast
from tests.benchmarks import limits
from tests.benchmarks.limits import pointer, real, whole
from tests.core.walk_data import Errors, make_walk, record
from tests.core.walking import belief_of, walk_log

NOISE = WalkNoise(swing_fixed_n=0.07)
QUIET = Guards(jump_threshold=np.inf)
ONE = Weights(4e4, 3e4, 3e3)
MANY = Weights(4e4, 3e4, np.geomspace(1.0, 1e6, 64))
SETTINGS = 26
FEW = 12
"""Updates that the slow contenders run."""


@dataclass(frozen=True)
class Contender:
    """One way to do one thing.

    Parameters
    ----------
    group, name
        What is done, and how.
    run
        Does it once.
    units
        How many updates (times settings) that are.
    """

    group: str
    name: str
    run: Callable[[], object]
    units: int


def contenders() -> Iterator[Contender]:
    """All of them on the same 20 s of walking, 8 cells at 80 Hz, 20 updates per second."""
    recording = record(make_walk(0.04, 20.0, seed=1), Errors(), seed=1)
    log, belief = walk_log(recording), belief_of(recording)
    c = limits.load() if limits.compiler() else None
    yield from _windows(log, belief, c)
    yield from _filters(log, belief, c)


def _windows(log: Log, belief: Belief, c: ctypes.CDLL | None) -> Iterator[Contender]:
    rule = WindowRule()
    ends = np.arange(rule.every, len(log) + 1, rule.every)
    u = ends.size
    group = "window, up to 5 Gauss-Newton iterations on the ratio"
    user = _UserWindow(log, belief, rule)
    few = user.ends(FEW)
    yield Contender(group, "SciPy least_squares, numeric", lambda: user.scipy(few, "2-point"), FEW)
    yield Contender(group, "SciPy least_squares, analytic", lambda: user.scipy(few, None), FEW)
    yield Contender(group, "array code", lambda: run_window(log, belief, ONE, fast=False), u)
    yield Contender(group, "compiled", lambda: run_window(log, belief, ONE), u)
    if c is not None:
        yield Contender(group, "C limit", lambda: user.exact(c), u)
    group = "window, sliding sums"
    yield Contender(group, "pandas rolling sums and solve", user.pandas, u)
    yield Contender(group, "array code", lambda: run_window_fast(log, belief, ONE, fast=False), u)
    yield Contender(group, "compiled", lambda: run_window_fast(log, belief, ONE), u)
    if c is not None:
        yield Contender(group, "C limit", lambda: user.sums(c, ONE), u)
    group = "window, sliding sums, 64 settings at once, per setting"
    many = 64 * u
    yield Contender(
        group, "array code", lambda: run_window_fast(log, belief, MANY, fast=False), many
    )
    yield Contender(group, "compiled", lambda: run_window_fast(log, belief, MANY), many)
    if c is not None:
        yield Contender(group, "C limit", lambda: user.sums(c, MANY), many)


def _filters(log: Log, belief: Belief, c: ctypes.CDLL | None) -> Iterator[Contender]:
    rows = cell_rows(log, belief)
    u = len(rows)
    group = "memory: Kalman filter, without the search for jumps"
    bare = _BareFilter(log, belief)
    yield Contender(group, "textbook NumPy loop with an inverse", bare.textbook, u)
    yield Contender(group, "array code", lambda: run_filter(rows, NOISE, QUIET, fast=False), u)
    yield Contender(group, "compiled", lambda: run_filter(rows, NOISE, QUIET), u)
    if c is not None:
        yield Contender(group, "C limit", lambda: bare.limit(c), u)
    group = "memory: Kalman filter with the search for jumps (320 hypotheses)"
    yield Contender(group, "array code", lambda: run_filter(rows, NOISE, fast=False), u)
    yield Contender(group, "compiled", lambda: run_filter(rows, NOISE), u)
    many = WalkNoise.of(NOISE.stacked() * np.geomspace(0.5, 2.0, SETTINGS)[:, None])
    group = f"likelihood of {SETTINGS} settings of the noise, per setting"
    yield Contender(
        group, "array code", lambda: run_settings(rows, many, states=False, fast=False),
        u * SETTINGS,
    )  # fmt: skip
    yield Contender(group, "compiled", lambda: run_settings(rows, many, states=False), u * SETTINGS)
    group = "smoother, the filter that it needs included"
    yield Contender(group, "array code", lambda: run_smoother(rows, NOISE, QUIET, fast=False), u)
    yield Contender(group, "compiled", lambda: run_smoother(rows, NOISE, QUIET), u)


class _UserWindow:
    """The window as a user would write it, and as C does it."""

    def __init__(self, log: Log, belief: Belief, rule: WindowRule) -> None:
        self.problem = _Problem.of(log, belief, static=False)
        self.rule, self.samples = rule, len(log)
        self.unit = np.concatenate([belief.gain_sd, belief.bias_sd_n])
        self.to_force = float(np.asarray(ONE.force)) / self.problem.weight_n**2
        self.to_cop = float(np.asarray(ONE.cop)) / rule.foot_length_m**2

    def ends(self, count: int) -> IntArray:
        """Updates in the middle of the walk."""
        middle = self.samples // 2
        return np.asarray(middle + self.rule.every * np.arange(count))

    def scipy(self, ends: IntArray, jacobian: str | None) -> FloatArray:
        """Every window by a general solver, from the solution before."""
        theta = np.zeros(self.unit.size)
        smooth = np.sqrt(float(np.asarray(ONE.smooth)))
        for end in ends:
            first, stop = np.searchsorted(self.problem.rows, [end - self.rule.samples, end])
            cut = slice(int(first), int(stop))
            b, q = self.problem.believed[cut], self.problem.positions[cut]
            fz, cop = self.problem.fz[cut], self.problem.cop[cut]
            f = np.hstack([b, np.ones_like(b)]) * self.unit
            axes = np.concatenate([q, q], axis=1)
            before = theta

            def residual(
                t: FloatArray, b: FloatArray = b, q: FloatArray = q, f: FloatArray = f,
                axes: FloatArray = axes, fz: FloatArray = fz, cop: FloatArray = cop,
                before: FloatArray = before,
            ) -> FloatArray:  # fmt: skip
                total = b.sum(axis=1) + f @ t
                moment = np.einsum("nc,nck->nk", b, q) + np.einsum("np,npk,p->nk", f, axes, t)
                miss = moment / np.maximum(total, MIN_FORCE_N)[:, None] - cop
                return np.concatenate([
                    np.sqrt(self.to_force) * (total - fz), np.sqrt(self.to_cop) * miss.ravel(),
                    smooth * (t - before),
                ])  # fmt: skip

            def slope(
                t: FloatArray, b: FloatArray = b, q: FloatArray = q, f: FloatArray = f,
                axes: FloatArray = axes,
            ) -> FloatArray:  # fmt: skip
                total = b.sum(axis=1) + f @ t
                moment = np.einsum("nc,nck->nk", b, q) + np.einsum("np,npk,p->nk", f, axes, t)
                point = moment / total[:, None]
                by_cop = (axes - point[:, None]) * (f / total[:, None])[..., None]
                return np.vstack([
                    np.sqrt(self.to_force) * f,
                    np.sqrt(self.to_cop) * by_cop.transpose(0, 2, 1).reshape(-1, t.size),
                    smooth * np.eye(t.size),
                ])  # fmt: skip

            jac: Any = jacobian if jacobian is not None else slope
            theta = np.asarray(least_squares(residual, theta, jac=jac, max_nfev=6).x)
        return theta

    def pandas(self) -> FloatArray:
        """Products of every sample in a frame, rolled, and solved update by update."""
        p = self.problem
        f = np.hstack([p.believed, np.ones_like(p.believed)]) * self.unit
        arms = (p.positions - p.cop[:, None]) / p.fz[:, None, None]
        m = f[:, :, None] * np.concatenate([arms, arms], axis=1)
        products = self.to_force * f[:, :, None] * f[:, None, :]
        products = products + self.to_cop * np.einsum("npk,nqk->npq", m, m)
        miss = self.to_force * f * (p.believed.sum(axis=1) - p.fz)[:, None]
        miss = miss + self.to_cop * np.einsum(
            "npk,nk->np", m, np.einsum("nc,nck->nk", p.believed, arms)
        )
        frame = pd.DataFrame(np.hstack([products.reshape(len(f), -1), miss]), index=p.rows)
        whole_log = frame.reindex(np.arange(self.samples), fill_value=0.0)
        sums = whole_log.rolling(self.rule.samples, min_periods=1).sum().to_numpy()
        theta, size = np.zeros(self.unit.size), self.unit.size
        ridge = float(np.asarray(ONE.smooth)) * np.eye(size)
        for end in np.arange(self.rule.every - 1, self.samples, self.rule.every):
            normal = sums[end, : size * size].reshape(size, size)
            pull = sums[end, size * size :] + normal @ theta
            theta = theta - np.linalg.solve(normal + ridge, pull)
        return theta

    def exact(self, c: ctypes.CDLL) -> FloatArray:
        """Gauss-Newton in C."""
        p, rule = self.problem, self.rule
        ends = np.arange(rule.every, self.samples + 1, rule.every)
        first = np.searchsorted(p.rows, ends - rule.samples).astype(np.int64)
        stop = np.searchsorted(p.rows, ends).astype(np.int64)
        out = np.empty((ends.size, self.unit.size))
        c.window_exact(
            *map(pointer, (*p.plain(self.unit), first, stop)), whole(ends.size),
            real(self.to_force), real(self.to_cop), real(float(np.asarray(ONE.smooth))),
            rule.iterations, real(rule.largest_step), real(rule.smallest_step), real(MIN_FORCE_N),
            pointer(out),
        )  # fmt: skip
        return np.asarray(out * self.unit)

    def sums(self, c: ctypes.CDLL, weights: Weights) -> FloatArray:
        """Sliding sums in C."""
        p, rule = self.problem, self.rule
        force, cop, smooth = (np.ascontiguousarray(w) for w in p.weighed(weights, rule))
        blocks = self.samples // rule.every
        edges = np.searchsorted(p.rows // rule.every, np.arange(blocks + 1)).astype(np.int64)
        theta, out = np.zeros((force.size, 16)), np.empty((blocks, force.size, 16))
        c.window_sums(
            *map(pointer, (*p.plain(self.unit), edges)), whole(blocks),
            rule.samples // rule.every, pointer(force), pointer(cop), pointer(smooth),
            int(force.size), real(rule.largest_step * rule.iterations), pointer(theta),
            pointer(out),
        )  # fmt: skip
        return np.asarray(out * self.unit)


class _BareFilter:
    """The filter's algebra alone, rows and noise ready made."""

    def __init__(self, log: Log, belief: Belief) -> None:
        rows = cell_rows(log, belief)
        self.rows, self.start = rows, Pass.begin(rows, NOISE, ())
        tuned, (u, k), s = self.start.tuned, rows.error.shape, self.start.mean.size
        every = np.arange(k)
        self.h, self.noise = np.zeros((u, k, s)), np.zeros((u, k, k))
        for j in range(u):
            self.h[j] = tuned.design(j, rows.h[j], every)
            self.noise[j] = tuned.noise(j, rows.h[j], every)[0]
        self.valid = rows.valid.astype(np.uint8)

    def textbook(self) -> FloatArray:
        """``K = P Hᵀ S⁻¹``, ``P ← P − K H P``."""
        x, cov = self.start.mean.copy(), self.start.cov.copy()
        values = np.empty((len(self.rows), len(self.rows.names)))
        for j in range(len(self.rows)):
            transition = np.diag(self.start.decay[j])
            x = transition @ x
            cov = transition @ cov @ transition.T + np.diag(self.start.drive[j])
            at = np.flatnonzero(self.rows.valid[j])
            h = self.h[j, at]
            nu = -(self.rows.error[j, at] + h @ x)
            total = h @ cov @ h.T + self.noise[j][np.ix_(at, at)]
            diagonal = np.diag(total)
            total = total + np.diag(np.maximum(nu**2 / 9.0 - diagonal, 0.0))
            gain = cov @ h.T @ np.linalg.inv(total)
            x = x + gain @ nu
            cov = cov - gain @ h @ cov
            values[j] = x[: values.shape[1]]
        return values

    def limit(self, c: ctypes.CDLL) -> FloatArray:
        """The same in C."""
        x, cov = self.start.mean.copy(), self.start.cov.copy()
        u, p = len(self.rows), len(self.rows.names)
        values = np.empty((u, p))
        c.filter_walk(
            pointer(x), pointer(cov), pointer(self.h), pointer(self.noise),
            pointer(self.rows.error), pointer(self.valid), pointer(self.start.decay),
            pointer(self.start.drive), whole(u), x.size, p, real(3.0), pointer(values),
        )  # fmt: skip
        return values
