"""Evidence from blocks: sign-flip and permutation tests, family-wise, and intervals.

A block (session, gait cycle, placement, pose) is the unit of evidence, never the sample: within a
block errors are correlated in ways that no lag window repairs (a gain that is a little off all the
time), but under the null a block's score is as likely positive as negative.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import optimize

from footcal_cli.core import chances
from footcal_cli.core.parameters import FloatArray, IntArray

EXACT_UP_TO = 13
"""Number of blocks up to which all sign patterns are enumerated."""
RANDOM_PATTERNS = 8191
"""Sign patterns drawn beyond that, the observed one not counted."""
_TIE = 1e-9
_PATTERNS_AT_ONCE = 512
_UNSURE = 0.05


def sign_patterns(blocks: int, seed: int = 0) -> FloatArray:
    """Signs (k, blocks); the first row is all +1; the first block keeps its sign.

    A statistic that ignores the overall sign takes the same value on a pattern and its negative,
    so 2^(blocks − 1) patterns are all there are.
    """
    if blocks <= EXACT_UP_TO:
        codes = np.arange(2 ** max(blocks - 1, 0))
        bits = (codes[:, None] >> np.arange(max(blocks - 1, 0))) & 1
        return np.hstack([np.ones((codes.size, 1)), 1.0 - 2.0 * bits])[:, :blocks]
    rng = np.random.default_rng(seed)
    signs = rng.choice([-1.0, 1.0], size=(RANDOM_PATTERNS + 1, blocks))
    signs[0] = 1.0
    return signs


def effective_blocks(information: FloatArray) -> FloatArray:
    """Number of informative blocks ``(Σ w)² / Σ w²``, shape (k,).

    Parameters
    ----------
    information
        What each block tells about each candidate, shape (blocks, k).
    """
    squares = np.sum(information**2, axis=0)
    total = np.sum(information, axis=0)
    return np.asarray(np.divide(total**2, squares, out=np.zeros_like(total), where=squares > 0))


def smallest_p(blocks: FloatArray | float) -> FloatArray:
    """Smallest two-sided p that sign flips of so many blocks can reach: ``2^(1 − blocks)``."""
    return np.asarray(2.0 ** (1.0 - np.asarray(blocks, dtype=float)))


def self_normalised(scores: FloatArray) -> FloatArray:
    """``Σ_b s_b / √(Σ_b s_b²)``, shape (k,); at most √blocks.

    Parameters
    ----------
    scores
        Block scores, shape (blocks, k).
    """
    norm = np.sqrt(np.sum(scores**2, axis=0))
    total = np.sum(scores, axis=0)
    return np.asarray(np.divide(total, norm, out=np.zeros_like(total), where=norm > 0))


@dataclass(frozen=True)
class FamilyTest:
    """A max-T test over a family of candidates.

    Parameters
    ----------
    t
        Statistic of each candidate, shape (k,).
    p
        Family-wise adjusted p-values, shape (k,).
    null_max
        Largest statistic of the family under each resampling, shape (n,); the first is observed.
    """

    t: FloatArray
    p: FloatArray
    null_max: FloatArray


def sign_flip_max_t(scores: FloatArray, signs: FloatArray) -> FamilyTest:
    """Family-wise sign-flip test: ``p_k = P(max_j T*_j ≥ T_k)``, signs shared by all candidates.

    Parameters
    ----------
    scores
        Block scores of the candidates, shape (blocks, k).
    signs
        From `sign_patterns`, shape (n, blocks).
    """
    if scores.shape[1] == 0:
        return FamilyTest(np.empty(0), np.empty(0), np.empty(0))
    norm = np.sqrt(np.sum(scores**2, axis=0))
    usable = norm > 0
    scaled = scores[:, usable] / norm[usable]
    # in pieces that stay in the processor's cache
    null_max = np.concatenate(
        [np.abs(part @ scaled).max(axis=1, initial=0.0)
         for part in np.array_split(signs, max(len(signs) // _PATTERNS_AT_ONCE, 1))]
    )  # fmt: skip
    t = np.abs(self_normalised(scores))
    below = np.searchsorted(np.sort(null_max), t - _TIE, side="left")
    return FamilyTest(t, np.where(usable, (null_max.size - below) / null_max.size, 1.0), null_max)


def local_max_t(
    scores: FloatArray, information: FloatArray, many: float | None = None
) -> tuple[FloatArray, FloatArray]:
    """Is one of many alike places off? Each place's mean against the scatter of its repeats.

    ``t_k = Σ_b s_bk / √W_k / σ``, ``W_k = Σ_b w_bk``, with σ² the scatter of ``s_bk`` about each
    place's own mean, ``Σ_b (s_bk − β_k w_bk)² / (1 − w_bk/W_k) / W_k``, pooled over the places:
    one-way analysis of variance. Blocks count by what they know, as in the mean: the many that
    hardly know of a place tell of another noise. Too few know of a single place for sign flips;
    what repeats tell of the noise is the same everywhere.

    Parameters
    ----------
    scores, information
        ``g̃_b·r̃_b`` and ``|g̃_b|²`` of each candidate, shape (blocks, k).
    many
        Number of independent tests that the places count as; all of them where None.

    Returns
    -------
    t, p
        Shape (k,) each.
    """
    total = np.maximum(information.sum(axis=0), 1e-300)
    size = scores.sum(axis=0) / total
    repeats = np.maximum(effective_blocks(information) - 1.0, 0.0)
    freedom = float(repeats.sum())
    if freedom < 1.0:
        return np.zeros(size.size), np.ones(size.size)
    free = np.maximum(1.0 - information / total, 1e-9)
    scatter = np.sum((scores - size * information) ** 2 / free, axis=0) / total
    noise = np.sqrt(np.sum(repeats * scatter) / freedom)
    t = np.abs(size) * np.sqrt(total) / max(float(noise), 1e-300)
    return t, np.minimum((many or size.size) * 2.0 * chances.t_sf(t, freedom), 1.0)


def sign_flip_mean(values: FloatArray, signs: FloatArray) -> float:
    """One-sided sign-flip p of ``mean(values) > 0``; values one per block."""
    observed = values.sum()
    flipped = signs @ values
    # patterns cover one half of all; the other half are their negatives
    return float(np.mean(np.concatenate([flipped, -flipped]) >= observed - _TIE * abs(observed)))


def sign_flip_group(scores: FloatArray, signs: FloatArray) -> float:
    """Sign-flip p of many candidates together: mean squared standardised sum of block scores.

    Parameters
    ----------
    scores
        Block scores, shape (blocks, k).
    signs
        From `sign_patterns`.
    """
    norm = np.sqrt(np.sum(scores**2, axis=0))
    seen = norm > 0
    if not seen.any():
        return 1.0
    statistic = np.mean((signs @ (scores[:, seen] / norm[seen])) ** 2, axis=1)
    return float(np.mean(statistic >= statistic[0] * (1.0 - _TIE)))


@dataclass(frozen=True)
class Pooled:
    """Which candidates of a permutation test share one scatter per unit of information.

    What a candidate's own effect adds to the scatter that it is judged by hides it: of six sessions
    of one cell, no statistic exceeds √5. Permutations leave a scatter shared by several cells as
    it is, so that the test keeps its level.

    Parameters
    ----------
    group
        Number of each candidate's group, shape (k,).
    information
        Variance that its sum would have in white noise, shape (k,).
    """

    group: IntArray
    information: FloatArray

    def squares(self, own: FloatArray) -> FloatArray:
        """Squared norms by the median ratio of each group, from candidates' own ones, (k,)."""
        ratio = np.divide(own, self.information, out=np.zeros_like(own), where=self.information > 0)
        shared = np.zeros_like(own)
        for number in np.unique(self.group):
            mine = self.group == number
            known = ratio[mine & (ratio > 0)]
            shared[mine] = np.median(known) if known.size else 0.0
        return np.where(ratio > 0, shared * self.information, 0.0)


def permutation_max_t(
    responses: FloatArray,
    drivers: FloatArray,
    seed: int = 0,
    permutations: int = 1999,
    kind: IntArray | None = None,
    pooled: Pooled | None = None,
) -> FamilyTest:
    """Family-wise permutation test of block-level responses against block-level drivers.

    ``T_k = |Σ_b d_bk · y_π(b)| / √(Σ_bc (d_bk · y_c)² / B_c)``, blocks of y permuted as wholes
    among those of their kind; the sum is over pairs of a kind, B_c the number of its blocks.

    Parameters
    ----------
    responses
        Shape (blocks, q), centred over the blocks of each kind.
    drivers
        What each candidate would have done to them, shape (blocks, q, k), centred likewise.
    seed, permutations
        Of the permutations drawn.
    kind
        Which blocks may change places: those of one number, shape (blocks,); all where absent. A
        block of another cell has no response where this one's driver is: put there, it would make
        every chance product of the data look large.
    """
    blocks, _, k = drivers.shape
    if k == 0:
        return FamilyTest(np.empty(0), np.empty(0), np.empty(0))
    rng = np.random.default_rng(seed)
    kind = np.zeros(blocks, dtype=np.int64) if kind is None else kind
    orders = np.tile(np.arange(blocks), (permutations + 1, 1))
    for number in np.unique(kind):
        mine = np.flatnonzero(kind == number)
        orders[1:, mine] = rng.permuted(orders[1:, mine], axis=1)
    # y permuted against d depends on the pair of blocks alone
    pair = np.einsum("bqk,cq->bck", drivers, responses)
    same = kind[:, None] == kind[None, :]
    square = np.einsum("bck,bc->k", pair**2, same / same.sum(axis=1))
    norm = np.sqrt(square if pooled is None else pooled.squares(square))
    total = np.abs(pair[np.arange(blocks)[None, :], orders, :].sum(axis=1))
    t_all = np.divide(total, norm, out=np.zeros_like(total), where=norm > 0)
    null_max = t_all.max(axis=1)
    p = np.mean(null_max[:, None] >= t_all[0][None, :] - _TIE, axis=0)
    return FamilyTest(t_all[0], p, null_max)


@dataclass(frozen=True)
class Interval:
    """A value with its 95 % interval."""

    value: float
    low: float
    high: float

    @property
    def sureness(self) -> float:
        """|value| over half the interval: beyond one, zero is outside."""
        return 2.0 * abs(self.value) / max(self.high - self.low, 1e-300)


def jackknife_interval(
    value: float, without: FloatArray, informative: float | None = None
) -> Interval:
    """95 % interval of an estimate from its leave-one-block-out values (MacKinnon's CV3).

    ``se² = (B − 1)/B Σ_b (β_(b) − β)²``, Student's t on B − 1 degrees of freedom.

    Parameters
    ----------
    value, without
        The estimate, and without each block, shape (B,).
    informative
        Effective number of blocks that say anything about it, in place of B in the degrees of
        freedom: a quarter of the sessions informs about one cell of four.
    """
    blocks = without.size
    if blocks < 2:
        return Interval(value, -np.inf, np.inf)
    se = np.sqrt((blocks - 1) / blocks * np.sum((without - value) ** 2))
    freedom = max((blocks if informative is None else min(informative, blocks)) - 1.0, 1.0)
    half = float(chances.t_ppf(0.975, freedom) * se)
    return Interval(value, value - half, value + half)


def held_out_interval(
    value: float, without: FloatArray, informative: float | None = None
) -> Interval:
    """95 % interval of what a model buys on blocks it was not fitted to, for blocks yet to come.

    Models of different folds are fitted to nearly the same blocks, so that their errors are no
    independent draws: the variance is ``1/B + n_test/n_train`` instead of ``1/B`` (Nadeau and
    Bengio, Machine Learning 52 (2003)), here ``1/B + 1/(B − 1)``.

    Parameters
    ----------
    value, without
        The gain, and without each held-out block, shape (B,).
    informative
        As in `jackknife_interval`.
    """
    found = jackknife_interval(value, without, informative)
    blocks = without.size
    if blocks < 2:
        return found
    half = (found.high - value) * float(np.sqrt(1.0 + blocks / (blocks - 1.0)))
    return Interval(value, value - half, value + half)


def largest_excess(taken: float, freedom: int) -> float:
    """Upper 95 % bound of the noncentrality λ of χ²: ``P(χ²_k(λ) ≤ taken) = 0.05``.

    Parameters
    ----------
    taken
        Squared error in units of the noise that k directions take.
    freedom
        Their number, k.
    """
    if not freedom:
        return 0.0

    def below(excess: float) -> float:
        return float(chances.ncx2_cdf(taken, freedom, excess)) - _UNSURE

    if chances.chi2_cdf(taken, freedom) <= _UNSURE:
        return 0.0
    end = taken + freedom + 20.0
    while below(end) > 0.0:
        end *= 2.0
    return float(optimize.brentq(below, 0.0, end))
