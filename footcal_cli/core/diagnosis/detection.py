"""Is anything wrong? Tests that know no cause, and the ceiling any cause could reach."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.linalg import lapack
from scipy.sparse.csgraph import connected_components

from footcal_cli.core.diagnosis.curves import Curve, strongest_curve
from footcal_cli.core.diagnosis.features import MEMORY, Features, features_of
from footcal_cli.core.diagnosis.line_test import line_of, rid_of_signals
from footcal_cli.core.diagnosis.rules import LEVEL_SHARE
from footcal_cli.core.diagnosis.spells import spell_p
from footcal_cli.core.diagnosis.telegraph import levels_p
from footcal_cli.core.inference.evidence import permutation_max_t, sign_flip_mean
from footcal_cli.core.inference.grams import Grams, whitened_grams
from footcal_cli.core.inference.linear import scaled_inverse
from footcal_cli.core.inference.lines import Line
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.inference.scores import held_out_loss, scores
from footcal_cli.core.parameters import FloatArray, IntArray

_RCOND = 1e-9
"""Of the RMS of a column."""
RIDGE = np.array([1e-3, 1e-2, 1e-1, 1.0, 10.0])
"""Ridge penalties tried, relative to the mean information of a feature."""


@dataclass(frozen=True)
class Detection:
    """Library-free evidence that something is left.

    Parameters
    ----------
    groups, group_p
        Recorded signals, and the family-wise p that the residual depends on each.
    bump_p, flexible_p, between_p, spell_p
        Per test: any dependence on a signal; a flexible learner predicts other blocks; calibration
        that moves with time or temperature between blocks; spells in which the reading is off.
    flexible_gain, loss
        Held-out gain of the flexible learner per block (zero where it does not help), and the
        squared error without it, as the user counts them, shape (B,).
    line
        The strongest line: where, and at what frequency.
    curve
        The signal with which the residual bends most surely, where rows are no series.
    driver
        Block-level driver of `between_p`.
    tolerated
        Share of the squared error that may be anything: no output is off by its tolerance.
    """

    groups: tuple[str, ...]
    group_p: FloatArray
    bump_p: float
    flexible_p: float
    between_p: float
    spell_p: float
    flexible_gain: FloatArray
    loss: FloatArray
    line: Line
    curve: Curve
    driver: str
    tolerated: float = 0.0

    @property
    def line_p(self) -> float:
        """Of a spectral line."""
        return self.line.p

    def bends_with(self, alpha: float) -> str:
        """The signal that the residual bends with at this level of 'unknown'; none where empty."""
        return self.curve.name if self.curve.p < alpha * LEVEL_SHARE["curve"] else ""

    @property
    def ceiling(self) -> float:
        """Share of the held-out squared error that any function of the signals explains."""
        return max(float(self.flexible_gain.sum() / max(self.loss.sum(), 1e-300)), 0.0)

    @property
    def p(self) -> float:
        """Family-wise p over the tests; each has its share of the level."""
        found = {"bump": self.bump_p, "flexible": self.flexible_p, "line": self.line_p,
                 "between": self.between_p, "spell": self.spell_p,
                 "curve": self.curve.p}  # fmt: skip
        return min(1.0, *(p / LEVEL_SHARE[name] for name, p in found.items()))


def detect(
    problem: Problem,
    grams: Grams,
    features: Features,
    base: IntArray,
    signs: FloatArray,
    accepted: FloatArray | None = None,
) -> Detection:
    """Run all tests on what a base leaves.

    Parameters
    ----------
    problem, grams, features
        The data, row by row and as Gram matrices.
    base
        Columns that are fitted: calibration and accepted candidates.
    signs
        From `footcal_cli.core.inference.evidence.sign_patterns`.
    accepted
        Row columns of accepted candidates, shape (m, a).
    """
    group_p, bump_p = _group_test(grams, features, base, signs)
    memory = np.array([name == MEMORY for name in features.names], dtype=bool)[features.group]
    parts = [grams.features[part] for part in (~features.curved, memory, features.curved)]
    white, gain, loss = flexible_gain(grams, base, parts)
    fitted = problem.fitted if accepted is None else np.hstack([problem.fitted, accepted])
    unexplained = cache(lambda: rid_of_signals(problem, features, fitted))
    line = line_of(problem, fitted, unexplained)
    between_p, driver = _between_test(problem, grams, base)
    return Detection(
        groups=features.names,
        group_p=group_p,
        bump_p=bump_p,
        flexible_p=sign_flip_mean(white, signs) if white.any() else 1.0,
        between_p=between_p,
        spell_p=_spell_test(problem, signs, accepted, unexplained),
        flexible_gain=gain,
        loss=loss,
        line=line,
        curve=_curve_test(problem, grams, features, base),
        driver=driver,
        tolerated=_tolerated(problem, loss),
    )


def _tolerated(problem: Problem, loss: FloatArray) -> float:
    """Share of a squared error that changes no output by its tolerance, were it all in that one."""
    rms = problem.noise * np.sqrt(float(loss.sum()) / max(problem.residual.size, 1))
    tolerance = problem.tolerance[problem.output]
    return float(np.min((tolerance / np.maximum(rms, 1e-100)) ** 2, initial=np.inf))


def _curve_test(problem: Problem, grams: Grams, features: Features, base: IntArray) -> Curve:
    """Curves of single observations: of stances as a whole, where several rows are of one."""
    if problem.pieces:
        taken = np.isin(grams.candidates, base)
        problem = problem.holding(problem.columns[:, taken]).without_candidates.averaged
        features = features_of(problem)
        grams, _ = whitened_grams(problem, features.columns)
        base = grams.calibration
    return strongest_curve(grams, features, base, problem.residual.size)


def _group_test(
    grams: Grams, features: Features, base: IntArray, signs: FloatArray
) -> tuple[FloatArray, float]:
    """Mean squared standardised block score per group; min-p over the groups by sign flips."""
    count = len(features.names)
    if not grams.features.size:
        return np.ones(count), 1.0
    found = scores(grams.inner, base, grams.features)
    norm = np.sqrt(np.sum(found.score**2, axis=0))
    seen = norm > 0
    standard = np.divide(found.score, norm, out=np.zeros_like(found.score), where=seen)
    squared = (signs @ standard) ** 2
    seen &= ~features.curved
    present = [g for g in range(count) if np.any(seen & (features.group == g))]
    if not present:
        return np.ones(count), 1.0
    statistic = np.stack(
        [squared[:, seen & (features.group == g)].mean(axis=1) for g in present], axis=1
    )
    # p of every pattern within its own null, then the smallest over the groups
    order = np.argsort(np.argsort(-statistic, axis=0, kind="stable"), axis=0, kind="stable")
    p_all = (order + 1.0) / len(signs)
    smallest = p_all.min(axis=1)
    adjusted = np.ones(count)
    for i, g in enumerate(present):
        adjusted[g] = np.mean(smallest <= p_all[0, i])
    return adjusted, float(np.mean(smallest <= smallest[0]))


def flexible_gain(
    grams: Grams, base: IntArray, parts: Sequence[IntArray]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Held-out gains of a ridge over one of several sets of features.

    Set and penalty of each fold are those that do best on the other held-out blocks, "none"
    among the choices.

    Parameters
    ----------
    grams, base
        The data and what is fitted besides.
    parts
        The sets: what is slow drowns among many that are not.

    Returns
    -------
    white, plain
        Gain per block in the metric of the noise, and as the user counts it, shape (B,).
    loss
        Squared error without the features, as the user counts it, shape (B,).
    """
    plain0 = held_out_loss(grams.inner, base, grams.plain)
    white0 = held_out_loss(grams.inner, base)
    gain_white, gain_plain = (np.zeros((1, grams.blocks)) for _ in range(2))
    for features in parts:
        if features.size:
            white, plain = _ridge_losses(grams, base, features)
            gain_white = np.vstack([gain_white, white0 - white])
            gain_plain = np.vstack([gain_plain, plain0 - plain])
    others = gain_white.sum(axis=1, keepdims=True) - gain_white
    best = np.argmax(others, axis=0), np.arange(grams.blocks)
    return gain_white[best], gain_plain[best], plain0


def _ridge_losses(
    grams: Grams, base: IntArray, features: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Held-out squared errors under every penalty, in both metrics, shape (penalties, B)."""
    used = np.concatenate([base, features, [grams.inner.last]])
    inner = grams.inner.among(used)
    total = inner.sum(axis=0)
    white = np.empty((RIDGE.size, grams.blocks))
    weights = np.ones((grams.blocks, RIDGE.size, used.size))
    for b, gram in enumerate(inner):
        weights[b, :, :-1] = -_ridge_path(total - gram, base.size)
        white[:, b] = np.einsum("li,li->l", weights[b] @ gram, weights[b])
    return white, grams.plain.squared(used, weights).T


def _ridge_path(gram: FloatArray, base: int) -> FloatArray:
    """Coefficients for every penalty, those of the first columns unpenalised; (penalties, n)."""
    inverse = scaled_inverse(gram[:base, :base], _RCOND)
    gamma = inverse @ gram[:base, base:-1]
    theta = inverse @ gram[:base, -1]
    visible = gram[base:-1, base:-1] - gram[base:-1, :base] @ gamma
    score = gram[base:-1, -1] - gamma.T @ gram[:base, -1]
    unit = float(np.mean(np.diag(gram)[base:-1]))
    path = []
    for penalty in RIDGE * unit:
        beta = _ridge(visible, score, penalty)
        path.append(np.concatenate([theta - gamma @ beta, beta]))
    return np.array(path)


def _ridge(visible: FloatArray, score: FloatArray, penalty: float) -> FloatArray:
    """``(visible + penalty I) β = score``, by Cholesky: less work than eigenvalues for all."""
    if penalty <= 0.0:
        # with nothing but the blocks that the filter learns on, no feature shows at all
        return np.zeros_like(score)
    shown = visible.T.copy(order="K")  # columns one by one, as LAPACK has them
    np.einsum("ii->i", shown)[:] += penalty
    factor, failed = lapack.dpotrf(shown, clean=False, overwrite_a=True)
    if failed:  # what is fitted leaves nothing but rounding of some features
        values, vectors = np.linalg.eigh(visible)
        return np.asarray(vectors @ ((vectors.T @ score) / (np.maximum(values, 0.0) + penalty)))
    return np.asarray(lapack.dpotrs(factor, score)[0])


def _spell_test(
    problem: Problem,
    signs: FloatArray,
    accepted: FloatArray | None,
    unexplained: Callable[[], FloatArray],
) -> float:
    """Spells lean to one side, or push to a second level; what pushes is far beyond its share."""
    leaning = spell_p(problem, signs, accepted)
    if problem.rate_hz <= 0 or problem.drifts or problem.settings is not None:
        return leaning
    pushed = levels_p(problem, unexplained())
    return min(1.0, leaning / (1.0 - _PUSHED), pushed / _PUSHED)


_PUSHED = 0.1  # share of the level of spells


def block_calibrations(
    grams: Grams, base: IntArray, columns: IntArray
) -> tuple[FloatArray, FloatArray, IntArray, FloatArray]:
    """What each block says about its own calibration, and what candidates would do to it.

    Returns
    -------
    response
        ``Z_b' V_b⁻¹ r̃_b`` over its scatter, centred over the blocks of a kind, shape (B, q).
    drivers
        Coefficients of the projected candidates on Z_b in the matching units, centred likewise,
        shape (B, q, k).
    kind
        Blocks of one number are of the same sensors and may change places, shape (B,).
    information
        Of each block on each candidate's size beside its calibration, in one unit, shape (B, k).
    """
    inner, z = grams.inner, grams.wandering
    square = inner.part(base, base).sum(axis=0)
    cross = inner.part(base, np.append(columns, inner.last)).sum(axis=0)
    gamma = scaled_inverse(square, 1e-10) @ cross
    on_base = inner.part(base, z).swapaxes(1, 2)
    score = inner.with_residual(z) - on_base @ gamma[:, -1]
    spread = np.sqrt(np.mean(score**2, axis=0))
    spread = np.where(spread > 0, spread, 1.0)
    moved = inner.part(z, columns) - inner.part(z, base) @ gamma[:, :-1]
    own = inner.part(z, z)
    ridge = _COEFFICIENT_RIDGE * np.eye(z.size)
    kind = kinds_of(grams.rows.part(z, z))
    moves = _centred(np.linalg.solve(own + ridge, moved), kind)
    information = np.einsum("bqk,bqr,brk->bk", moves, own, moves)
    return _centred(score / spread, kind), moves * spread[None, :, None], kind, information


_COEFFICIENT_RIDGE = 1e-3
_OF_A_KIND = 0.1
"""cos of what two blocks know of their calibrations from which they know of the same sensors."""


def kinds_of(own: FloatArray) -> IntArray:
    """Number of the group of blocks that know of the same calibration, shape (B,).

    Parameters
    ----------
    own
        What each block knows of each pair of coefficients, shape (B, q, q).
    """
    flat = own.reshape(len(own), -1)
    norm = np.sqrt(np.sum(flat**2, axis=1))
    cos = (flat @ flat.T) / np.maximum(np.outer(norm, norm), 1e-300)
    return np.asarray(connected_components(cos > _OF_A_KIND)[1].astype(np.int64))


def _centred(values: FloatArray, kind: IntArray) -> FloatArray:
    """Values of blocks less the mean over those of their kind."""
    return np.stack(
        [v - values[kind == number].mean(axis=0) for v, number in zip(values, kind, strict=True)]
    )


def _between_test(problem: Problem, grams: Grams, base: IntArray) -> tuple[float, str]:
    """Does calibration move between blocks with a block-level driver? Permutation of blocks."""
    names = [n for n, v in problem.covariates.items() if np.ptp(v) > 0]
    if not names or grams.blocks < 4 or not grams.wandering.size:
        return 1.0, ""
    response, _, kind, _ = block_calibrations(grams, base, np.empty(0, dtype=np.int64))
    q = response.shape[1]
    design = np.zeros((grams.blocks, q, q * len(names)))
    for d, name in enumerate(names):
        values = problem.covariates[name]
        for i in range(q):
            design[:, i, d * q + i] = (values - values.mean()) / values.std()
    test = permutation_max_t(response, _centred(design, kind), kind=kind)
    best = int(np.argmin(test.p)) // q
    return float(test.p.min()), names[best]
