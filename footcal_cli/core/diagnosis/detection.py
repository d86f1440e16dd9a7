"""Is anything wrong? Three tests that know no cause, and the ceiling any cause could reach."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy import ndimage, stats

from footcal_cli.core.diagnosis.features import MEMORY, Features
from footcal_cli.core.diagnosis.problem import Problem
from footcal_cli.core.diagnosis.rules import LEVEL_SHARE
from footcal_cli.core.diagnosis.scores import held_out_loss, scores
from footcal_cli.core.diagnosis.spells import spell_p
from footcal_cli.core.diagnosis.whitening import Grams, RowWhitener
from footcal_cli.core.evidence import permutation_max_t, sign_flip_mean
from footcal_cli.core.parameters import FloatArray, IntArray

RIDGE = np.array([1e-3, 1e-2, 1e-1, 1.0, 10.0])
"""Ridge penalties tried, relative to the mean information of a feature."""
_LINE_WIDTH = 41
_MEDIAN_SCATTER = 6.0
_NARROWER = 3  # a spectrum is at least so many running medians wide
_SHORTEST_SPECTRUM = 64
_LINE_CAUTION = 5.0  # on nulls the whitened spectrum is not quite flat: p < .01 in 5 of 100


@dataclass(frozen=True)
class Detection:
    """Library-free evidence that something is left.

    Parameters
    ----------
    groups, group_p
        Recorded signals, and the family-wise p that the residual depends on each.
    bump_p, flexible_p, line_p, between_p, spell_p
        Per test: any dependence on a signal; a flexible learner predicts other blocks; a spectral
        line; calibration that moves with time or temperature between blocks; spells in which the
        reading is off to one side.
    flexible_gain, loss
        Held-out gain of the flexible learner per block (zero where it does not help), and the
        squared error without it, as the user counts them, shape (B,).
    line
        Output and frequency (Hz) of the strongest line.
    driver
        Block-level driver of `between_p`.
    """

    groups: tuple[str, ...]
    group_p: FloatArray
    bump_p: float
    flexible_p: float
    line_p: float
    between_p: float
    spell_p: float
    flexible_gain: FloatArray
    loss: FloatArray
    line: tuple[str, float]
    driver: str

    @property
    def ceiling(self) -> float:
        """Share of the held-out squared error that any function of the signals explains."""
        return max(float(self.flexible_gain.sum() / max(self.loss.sum(), 1e-300)), 0.0)

    @property
    def p(self) -> float:
        """Family-wise p over the tests; each has its share of the level."""
        found = {"bump": self.bump_p, "flexible": self.flexible_p, "line": self.line_p,
                 "between": self.between_p, "spell": self.spell_p}  # fmt: skip
        return min(1.0, *(p / LEVEL_SHARE[name] for name, p in found.items()))


def detect(
    problem: Problem,
    grams: Grams,
    features: Features,
    whitener: RowWhitener,
    base: IntArray,
    signs: FloatArray,
    accepted: FloatArray | None = None,
) -> Detection:
    """Run all tests on what a base leaves.

    Parameters
    ----------
    problem, grams, features, whitener
        The data, row by row and as Gram matrices.
    base
        Columns that are fitted: calibration and accepted candidates.
    signs
        From `footcal_cli.core.evidence.sign_patterns`.
    accepted
        Row columns of accepted candidates for the spectrum, shape (m, a).
    """
    group_p, bump_p = _group_test(grams, features, base, signs)
    slow = grams.features[[features.names[g] == MEMORY for g in features.group]]
    white, gain, loss = flexible_gain(grams, base, (slow,))
    line_p, output, frequency = _line_test(problem, whitener, accepted)
    between_p, driver = _between_test(problem, grams, base)
    return Detection(
        groups=features.names,
        group_p=group_p,
        bump_p=bump_p,
        flexible_p=sign_flip_mean(white, signs) if white.any() else 1.0,
        line_p=line_p,
        between_p=between_p,
        spell_p=spell_p(problem, signs, accepted),
        flexible_gain=gain,
        loss=loss,
        line=(output, frequency),
        driver=driver,
    )


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
    grams: Grams, base: IntArray, parts: Sequence[IntArray] = ()
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Held-out gains of a ridge over all features, or over a part of them.

    Features and penalty of each fold are those that do best on the other held-out blocks, "none"
    among the choices.

    Parameters
    ----------
    grams, base
        The data and what is fitted besides.
    parts
        Features that may explain it alone: what is slow drowns among many that are not.

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
    for features in (grams.features, *parts):
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
    inner, last = grams.inner, grams.inner.shape[1] - 1
    total = inner.sum(axis=0)
    used = np.ix_(*2 * [np.concatenate([base, features, [last]])])
    white, plain = (np.empty((RIDGE.size, grams.blocks)) for _ in range(2))
    for b, gram in enumerate(inner):
        fitted = _ridge_path(total - gram, base, features, last)
        weights = np.hstack([-fitted, np.ones((RIDGE.size, 1))])
        white[:, b] = np.einsum("li,li->l", weights @ gram[used], weights)
        plain[:, b] = np.einsum("li,li->l", weights @ grams.plain[b][used], weights)
    return white, plain


def _ridge_path(gram: FloatArray, base: IntArray, extra: IntArray, last: int) -> FloatArray:
    """Coefficients of [base, extra] for every penalty, the base unpenalised; (penalties, n)."""
    bb = gram[np.ix_(base, base)]
    scale = np.sqrt(np.clip(np.diag(bb), 1e-300, None))
    inverse = np.linalg.pinv(bb / np.outer(scale, scale), rcond=1e-9, hermitian=True)
    inverse = inverse / np.outer(scale, scale)
    gamma = inverse @ gram[np.ix_(base, extra)]
    theta = inverse @ gram[base, last]
    visible = gram[np.ix_(extra, extra)] - gram[np.ix_(extra, base)] @ gamma
    score = gram[extra, last] - gamma.T @ gram[base, last]
    values, vectors = np.linalg.eigh(0.5 * (visible + visible.T))
    values = np.clip(values, 0.0, None)
    unit = float(np.mean(np.diag(gram)[extra]))
    rotated = vectors.T @ score
    path = []
    for penalty in RIDGE * unit:
        # with nothing but the blocks that the filter learns on, no feature shows at all
        shown = values + penalty
        beta = vectors @ np.divide(rotated, shown, out=np.zeros_like(rotated), where=shown > 0)
        path.append(np.concatenate([theta - gamma @ beta, beta]))
    return np.array(path)


def _line_test(
    problem: Problem, whitener: RowWhitener, accepted: FloatArray | None
) -> tuple[float, str, float]:
    """Strongest line of the block-averaged periodogram over its running median.

    Each block is first regressed on its own calibration and offsets, and whitened: a drifting gain
    would look like a line at the frequency of the load.
    """
    if problem.rate_hz <= 0:
        return 1.0, "", 0.0
    extra = np.empty((problem.residual.size, 0)) if accepted is None else accepted
    kept = whitener.kept
    whole = whitener(
        np.hstack([problem.fitted, extra, _own_shapes(problem), problem.residual[:, None]])
    )
    block, sequence, output = problem.block[kept], problem.sequence[kept], problem.output[kept]
    starts = np.flatnonzero(np.diff(sequence, prepend=sequence[:1] - 1))
    stops = np.append(starts[1:], sequence.size)
    lengths = stops - starts
    size = int(np.quantile(lengths, 0.25)) if lengths.size else 0
    if size < _SHORTEST_SPECTRUM:
        return 1.0, "", 0.0
    left = whole[:, -1].copy()
    for b, o in product(range(problem.blocks), range(len(problem.outputs))):
        rows = (block == b) & (output == o)
        basis = whole[rows, :-1]
        norm = np.sqrt(np.sum(basis**2, axis=0))
        basis = basis[:, norm > 0] / norm[norm > 0]
        if basis.shape[0] > 2 * basis.shape[1]:
            left[rows] -= basis @ np.linalg.lstsq(basis, left[rows], rcond=1e-8)[0]
    window = np.hanning(size + 2)[1:-1]
    frequency = np.fft.rfftfreq(size, 1.0 / problem.rate_hz)
    width = min(_LINE_WIDTH, frequency.size // _NARROWER)
    tested = (np.arange(frequency.size) > width // 2) & (
        np.arange(frequency.size) < frequency.size - width // 2
    )
    best = (1.0, "", 0.0)
    tests = 0
    for o, name in enumerate(problem.outputs):
        power = [
            np.abs(np.fft.rfft(window * (left[a : a + size] - left[a : a + size].mean()))) ** 2
            for a, length in zip(starts, lengths, strict=True)
            if length >= size and output[a] == o
        ]
        if len(power) < 3:
            continue
        normed = np.array([p / ndimage.median_filter(p, width, mode="nearest") for p in power])
        mean = normed.mean(axis=0)
        mean /= ndimage.median_filter(mean, width, mode="nearest")
        # a mean of n exponentials; its median is close to its mean, which the division used.
        # Running medians of w bins scatter themselves: 2/w (relative variance) in each
        count = len(power) / (1.0 + _MEDIAN_SCATTER / width)
        p = stats.gamma.sf(mean, count, scale=1.0 / (count - 1.0 / 3.0))
        p = np.where(tested, p, 1.0)
        tests += int(tested.sum())
        at = int(np.argmin(p))
        if p[at] < best[0]:
            best = (float(p[at]), name, float(frequency[at]))
    return min(_LINE_CAUTION * best[0] * max(tests, 1), 1.0), best[1], best[2]


def _own_shapes(problem: Problem) -> FloatArray:
    """Regressors, their squares and their values one sample earlier, shape (m, q)."""
    fresh = np.diff(problem.sequence, prepend=problem.sequence[:1] - 1) != 0
    parts = [np.ones_like(problem.residual)]
    for values in problem.regressors.values():
        before = np.where(fresh, values, np.roll(values, 1))
        parts += [values, values**2, before]
    return np.stack(parts, axis=1)


def block_calibrations(
    grams: Grams, base: IntArray, columns: IntArray
) -> tuple[FloatArray, FloatArray]:
    """What each block says about its own calibration, and what candidates would do to it.

    Returns
    -------
    response
        ``Z_b' V_b⁻¹ r̃_b`` over its scatter, centred over the blocks, shape (B, q).
    drivers
        Coefficients of the projected candidates on Z_b in the matching units, centred,
        shape (B, q, k).
    """
    inner, rows, z = grams.inner, grams.rows, grams.wandering
    last = inner.shape[1] - 1
    wanted = np.append(columns, last)
    total = inner.sum(axis=0)
    gamma = (
        np.linalg.pinv(total[np.ix_(base, base)], rcond=1e-10, hermitian=True)
        @ total[np.ix_(base, wanted)]
    )
    score = inner[:, z, last] - np.einsum(
        "bij,j->bi", inner[:, z[:, None], base[None, :]], gamma[:, -1]
    )
    spread = np.sqrt(np.mean(score**2, axis=0))
    spread = np.where(spread > 0, spread, 1.0)
    moved = rows[:, z[:, None], columns[None, :]] - np.einsum(
        "bij,jk->bik", rows[:, z[:, None], base[None, :]], gamma[:, :-1]
    )
    own = rows[:, z[:, None], z[None, :]]
    ridge = _COEFFICIENT_RIDGE * np.eye(z.size)
    drivers = np.linalg.solve(own + ridge, moved) * spread[None, :, None]
    response = score / spread
    return response - response.mean(axis=0), drivers - drivers.mean(axis=0)


_COEFFICIENT_RIDGE = 1e-3


def _between_test(problem: Problem, grams: Grams, base: IntArray) -> tuple[float, str]:
    """Does calibration move between blocks with a block-level driver? Permutation of blocks."""
    names = [n for n, v in problem.covariates.items() if np.ptp(v) > 0]
    if not names or grams.blocks < 4 or not grams.wandering.size:
        return 1.0, ""
    response, _ = block_calibrations(grams, base, np.empty(0, dtype=np.int64))
    q = response.shape[1]
    design = np.zeros((grams.blocks, q, q * len(names)))
    for d, name in enumerate(names):
        values = problem.covariates[name]
        for i in range(q):
            design[:, i, d * q + i] = (values - values.mean()) / values.std()
    test = permutation_max_t(response, design)
    best = int(np.argmin(test.p)) // q
    return float(test.p.min()), names[best]
