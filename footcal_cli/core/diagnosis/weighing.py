"""How strong the evidence for each cause is: family-wise p, held-out gain, size."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footcal_cli.core import chances
from footcal_cli.core.diagnosis.detection import block_calibrations
from footcal_cli.core.diagnosis.few_sessions import NOTHING, are_few_sessions, of_few_sessions_p
from footcal_cli.core.diagnosis.library import Library
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.inference.evidence import (
    Interval,
    Pooled,
    effective_blocks,
    jackknife_interval,
    local_max_t,
    permutation_max_t,
    sign_flip_max_t,
)
from footcal_cli.core.inference.grams import Grams
from footcal_cli.core.inference.problem import Problem, Signature
from footcal_cli.core.inference.scores import Scores, held_out_gains, scores, visible_products
from footcal_cli.core.inference.whitening import has_single_rows
from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray


@dataclass(frozen=True)
class Evidence:
    """What the residual says about every cause on top of a base.

    Parameters
    ----------
    t, p
        Best statistic and smallest family-wise p over each cause's shapes, shape (causes,).
    gain, plain_gain
        Held-out gain per block in the metric of the noise, and as the user counts it,
        shape (B, causes).
    best
        Gram column of each cause's best shape on all blocks, shape (causes,).
    size, size_without
        Its size, and without each block, shapes (causes,), (B, causes).
    informative
        Effective number of informative blocks, shape (causes,).
    null_max
        Largest statistic of the within-block family under each sign pattern; the observed first.
    """

    t: FloatArray
    p: FloatArray
    gain: FloatArray
    plain_gain: FloatArray
    best: IntArray
    size: FloatArray
    size_without: FloatArray
    informative: FloatArray
    null_max: FloatArray

    def interval(self, cause: int) -> Interval:
        """The size of a cause with its 95 % interval over blocks."""
        return jackknife_interval(float(self.size[cause]), self.size_without[:, cause])

    def possible(
        self, cause: int, signature: Signature, rules: Rules, *, as_it_is: bool = False
    ) -> bool:
        """`is_possible` of a cause's size, which may be off by two of its standard errors.

        Where the cause is certain, a share may be lost at the end of its range.

        Parameters
        ----------
        as_it_is
            Whether the size is taken as it is.
        """
        without = self.size_without[:, cause]
        spread = 0.0 if as_it_is else 2.0 * np.std(without) * np.sqrt(max(without.size - 1, 1))
        share = rules.second_share if self.p[cause] < rules.alpha_small else 0.0
        return is_possible(signature, float(self.size[cause]), float(spread), share)


def weigh(lib: Library, base: IntArray, signs: FloatArray, rules: Rules, seed: int) -> Evidence:
    """Family-wise tests and held-out gains of all causes on top of a base."""
    grams = lib.grams
    found = scores(grams.inner, base, grams.candidates)
    active = lib.testable & (found.inside == 0)
    informative = effective_blocks(found.information)
    within = np.flatnonzero(active & ~lib.between & ~lib.local)
    local = np.flatnonzero(active & lib.local)
    between = np.flatnonzero(active & lib.between)
    t = np.zeros(len(lib.problem.signatures))
    p = np.ones(len(lib.problem.signatures))
    partial = within[_in_some_blocks(lib, informative[within], rules)]
    split = max(float(sum(family.size > 0 for family in (within, local, between, partial))), 1.0)
    test = sign_flip_max_t(found.score[:, within], signs)
    t[within], p[within] = test.t, np.minimum(split * test.p, 1.0)
    if partial.size:
        level = rules.alpha_name / split
        single = _partial_p(lib, found, partial, base, level)
        p[partial] = np.minimum(p[partial], split * single)
    if between.size and grams.blocks >= 4:
        apart = between_blocks(lib, base, grams.candidates[between], seed)
        t[between], p[between] = apart[0], np.minimum(split * apart[1], 1.0)
    if local.size:
        t[local], single = local_max_t(found.score[:, local], found.information[:, local])
        p[local] = np.minimum(split * single, 1.0)
    gains = held_out_gains(grams.inner, grams.plain, base, lib.columns)
    count = len(lib.causes)
    best = np.zeros(count, dtype=np.int64)
    out_t, out_p, size, blocks = np.zeros(count), np.ones(count), np.zeros(count), np.zeros(count)
    sizes = found.size
    drop = sizes * found.score.sum(axis=0)
    for c, columns in enumerate(lib.columns):
        at = np.array([lib.index(int(x)) for x in columns])
        top = int(at[np.argmax(drop[at])])
        best[c] = int(grams.candidates[top])
        out_t[c], out_p[c] = t[at].max(), p[at].min()
        size[c], blocks[c] = sizes[top], informative[top]
    return Evidence(
        out_t, out_p, gains.white, gains.plain, best, size, gains.size, blocks, test.null_max
    )


_UNSEEN = 1e-6  # share of the largest eigenvalue of correlations, below which there is none
_ROUNDING = 1e-10  # share of a column's square that a base leaves, below which it leaves none
_DRAWS, _PARTS = 20_000, 20
_MANY = 16  # blocks from which permutations reach the level of any family
_SOME = 0.7
_FEWEST = 8.0


def _in_some_blocks(lib: Library, informative: FloatArray, rules: Rules) -> BoolArray:
    """Candidates that a part of the blocks knows of: one cell of several, each with its sessions.

    So few signs cannot reach the level of a family; block scores are sums over many rows, and
    Student's t on them can, with a scatter that all cells know.
    """
    if lib.problem.turned:
        return np.asarray(informative >= rules.fewest_sessions)
    if are_few_sessions(lib.problem):
        return np.asarray(np.round(informative) >= rules.fewest_sessions - 1.0)
    # sessions of one cell never tell exactly alike: three of them count as 2.99
    whole = np.round(informative)
    if has_single_rows(lib.problem) and not lib.problem.drifts:
        return np.asarray(whole >= rules.fewest_sessions)
    if lib.problem.drifts:
        return np.zeros(informative.size, dtype=bool)
    # beside a cause that is in the model few blocks may only show what its form gets wrong
    fewest = rules.fewest_sessions if lib.problem.accepted is None else _FEWEST
    return np.asarray((informative < _SOME * lib.grams.blocks) & (whole >= fewest))


def has_few_blocks(problem: Problem, informative: float) -> bool:
    """Whether so few blocks know of a cause that signs could not judge it: sessions of one cell.

    ``2^(1 − n) > 0.01``. The scatter of all cells judges it, or the rows. Stances, and placements
    from a calibration made before, have all cells in every block: there signs stay the judge.
    """
    if problem.settings is not None or problem.drifts or problem.pieces:
        return False
    if problem.known is not None:
        return False
    if are_few_sessions(problem):
        return True
    return informative < min(_FEWEST, _SOME * problem.blocks)


def is_possible(signature: Signature, size: float, spread: float, share: float) -> bool:
    """Whether a linear size is one that an effect may have, or overshoots its range only a little.

    A large effect bends the calibration that its linear size is beside: of a cell that stops, the
    scale too is too small, and 1 is found as 1.4. At the end e of its range it would still explain
    all but ``(1 − e/β)²`` of what it does at β; the refit finds the size.

    Parameters
    ----------
    signature, size, spread
        The candidate, its linear size β, and how far that may be off.
    share
        Share of what it explains that may be lost at the end of its range.
    """
    if signature.lower - spread <= size <= signature.upper + spread:
        return True
    end = float(np.clip(size, signature.lower, signature.upper))
    return abs(end) < abs(size) and (1.0 - end / size) ** 2 <= share


def of_cells_p(signatures: Sequence[Signature], found: Scores, which: int) -> float:
    """The p of one candidate alone, with the scatter of all that are of its form.

    Parameters
    ----------
    signatures, found
        Of many candidates.
    which
        Number of that one.
    """
    forms = forms_of(signatures)
    alike = np.flatnonzero((forms == forms[which]) & (found.inside == 0))
    p = of_one_form_p(found.score[:, alike], found.information[:, alike], forms[alike])
    return float(p[alike == which].sum()) if which in alike else 1.0


def _partial_p(
    lib: Library,
    found: Scores,
    partial: IntArray,
    base: IntArray,
    level: float,
) -> FloatArray:
    """Family-wise p of candidates that a part of the blocks knows of.

    Where what scatters is normal, they count as so many independent ones as they are alike to.

    Blocks that are parts of settings are white once that is accounted for: how far their scores
    scatter is then known from all of them together, not from the few that know of one candidate.
    """
    single_rows = has_single_rows(lib.problem)
    many = lib.likeness or alike_as(lib.grams, base, lib.grams.candidates[partial], level)
    if single_rows:
        single = single_rows_p(lib.problem, found, base.size)[partial]
        return np.asarray(np.minimum(many * single, 1.0))
    score, information = found.score[:, partial], found.information[:, partial]
    if lib.problem.settings is not None:
        return local_max_t(score, information, many)[1]
    forms = forms_of([lib.problem.signatures[i] for i in partial])
    if are_few_sessions(lib.problem):
        owners = [lib.problem.signatures[i].owners for i in partial]
        alone = np.array([len(own) == 1 for own in owners])
        sensors = len({own for own, one in zip(owners, alone, strict=True) if one})
        single = of_few_sessions_p(score, information, forms, alone, many / max(sensors, 1))
    else:
        single = of_one_form_p(score, information, forms)
    return np.asarray(np.minimum(many * single, 1.0))


def alike_as(grams: Grams, base: IntArray, columns: IntArray, level: float) -> float:
    """Number of independent tests whose largest |z| is exceeded as often as that of columns.

    Shapes of one effect, and one effect in neighbouring places, are much alike: with Σ the
    correlation of the columns after a base is fitted and q the ``1 − level`` quantile of
    ``max |z|``, ``z ~ N(0, Σ)``, it is ``level / (2 Φ(−q))``; q is simulated. Columns that the
    base holds are no tests.
    """
    whole, left = visible_products(grams.inner, base, columns)
    apart = np.flatnonzero(np.diag(left) > _ROUNDING * whole)
    if not apart.size:
        return 1.0
    scale = np.sqrt(np.diag(left)[apart])
    values, vectors = np.linalg.eigh(left[np.ix_(apart, apart)] / np.outer(scale, scale))
    shown = values > _UNSEEN * values.max(initial=0.0)
    root = (vectors[:, shown] * np.sqrt(values[shown])).astype(np.float32)
    draws = np.random.default_rng(0).standard_normal((_DRAWS, int(shown.sum())), dtype=np.float32)
    largest = np.concatenate(
        [np.abs(part @ root.T).max(axis=1) for part in np.array_split(draws, _PARTS)]
    )
    beyond = float(2.0 * chances.norm_sf(np.quantile(largest, 1.0 - level)))
    return float(np.clip(level / max(beyond, 1e-300), 1.0, columns.size))


def single_rows_p(problem: Problem, found: Scores, fitted: int) -> FloatArray:
    """The p of each candidate alone where rows are single observations, shape (k,).

    Means over seconds are as good as normal, and all rows tell of their noise: Student's t on the
    n − r degrees of freedom that a calibration of rank r leaves. The noise is that of the rows,
    ``z = Σ s / √(Σ |g̃|²)``, or what blocks scatter by (`local_max_t`, made smaller by ``1 − r/n``)
    where that is larger. A candidate that acts in four of twenty stances cannot reach any level by
    their signs.

    Parameters
    ----------
    problem
        The rows.
    found
        Scores of many candidates: what scatters between blocks is pooled over them.
    fitted
        Number of columns that are fitted.
    """
    rows = problem.residual.size
    freedom = float(max(rows - fitted, 1))
    by_blocks = local_max_t(found.score, found.information)[0] * np.sqrt(freedom / rows)
    total = np.maximum(found.information.sum(axis=0), 1e-300)
    by_rows = np.abs(found.score.sum(axis=0)) / np.sqrt(total)
    return np.asarray(2.0 * chances.t_sf(np.minimum(by_blocks, by_rows), freedom))


def between_blocks(
    lib: Library, base: IntArray, columns: IntArray, seed: int
) -> tuple[FloatArray, FloatArray]:
    """Two-stage test of candidates that act between blocks: t and family-wise p, shapes (k,).

    Blocks are permuted. A few sessions of one cell have too few orders to reach the level of a
    family: there Student's t counts, with a scatter that all cells know.
    """
    response, drivers, kind, information = block_calibrations(lib.grams, base, columns)
    signatures = [lib.problem.signatures[lib.index(int(c))] for c in columns]
    group = forms_of(signatures)
    pooled = Pooled(group, information.sum(axis=0))
    test = permutation_max_t(response, drivers, seed, kind=kind, pooled=pooled)
    score = np.einsum("bqk,bq->bk", drivers, response)
    tells = information > NOTHING * information.max(axis=0, initial=0.0)
    few = tells.sum(axis=0) < _MANY
    p = columns.size * of_one_form_p(score, information, group, kind)
    return test.t, np.where(few, np.minimum(p, 1.0), test.p)


def of_one_form_p(
    score: FloatArray, information: FloatArray, form: IntArray, kind: IntArray | None = None
) -> FloatArray:
    """Single p of each candidate, scatter pooled over the cells that share its form, shape (k,).

    ``u_b ~ N(β i_b, φ i_b)`` with score u and information i of block b; φ is the mean square of
    what is left beside each cell's own β, over all cells and never less than the candidate's own:
    a few sessions of one cell alone do not tell how far scores scatter.

    Parameters
    ----------
    score, information
        Of each block about each candidate, shape (blocks, k).
    form
        Number of the form of each candidate, shape (k,).
    kind
        Blocks within which scores are centred, shape (blocks,); not centred where None.
    """
    known = information > NOTHING * information.max(axis=0, initial=0.0)
    total = np.maximum(np.sum(np.where(known, information, 0.0), axis=0), 1e-300)
    size = np.sum(np.where(known, score, 0.0), axis=0) / total
    shares = np.where(known, information, np.inf)
    left = np.sum((score - size * information) ** 2 / shares, axis=0)
    centred = np.zeros(size.size, dtype=np.int64)
    if kind is not None:
        centred = np.array([np.unique(kind[one]).size for one in known.T], dtype=np.int64)
    freedom = known.sum(axis=0) - centred - 1
    least = 1 if kind is None else 2  # fewer, and centred, say nothing of their own
    p = np.ones(size.size)
    for k in range(size.size):
        alike = (form == form[k]) & (centred <= 1) & (freedom > 0)
        if freedom[k] < least or not alike.any():
            continue
        df = int(freedom[alike].sum())
        scatter = max(float(left[alike].sum()) / df, left[k] / freedom[k])
        t = size[k] * np.sqrt(total[k] / max(scatter, 1e-300))
        p[k] = 2.0 * float(chances.t_sf(abs(t), df))
    return p


def forms_of(signatures: Sequence[Signature]) -> IntArray:
    """Number of the form of each signature: effect, size and shape, in so many sensors."""
    seen: dict[tuple[object, ...], int] = {}
    return np.array(
        [
            seen.setdefault(
                (s.effect, s.parameter, s.shape, tuple(len(units) for _, units in s.owners)),
                len(seen),
            )
            for s in signatures
        ],
        dtype=np.int64,
    )
