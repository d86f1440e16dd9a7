"""Which effect? Forward by held-out gain under family-wise control, rivals, then backward."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.diagnosis.few_sessions import are_few_sessions
from footcal_cli.core.diagnosis.library import Library
from footcal_cli.core.diagnosis.refusal import Refusal, Why
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.weighing import (
    Evidence,
    between_blocks,
    has_few_blocks,
    of_cells_p,
    single_rows_p,
    weigh,
)
from footcal_cli.core.effects import TABLE
from footcal_cli.core.effects.contract import Stage
from footcal_cli.core.inference.evidence import sign_flip_max_t, sign_flip_mean, smallest_p
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.inference.scores import (
    cosines,
    held_out_gains,
    held_out_loss,
    joint_sizes,
    scores,
)
from footcal_cli.core.inference.whitening import has_single_rows
from footcal_cli.core.parameters import FloatArray, IntArray

WRITTEN = frozenset(name for name, effect in TABLE.items() if effect.stage is Stage.BENCH)
"""Names of what was written down wrong: a number, which has no form that could be another."""


@dataclass(frozen=True)
class Step:
    """One accepted effect.

    Parameters
    ----------
    column
        Gram column of the accepted candidate.
    p, t
        Family-wise p and statistic when it was accepted.
    gain, loss
        Held-out gain and loss per block when it was accepted, as the user counts them, shape (B,).
    rivals
        Gram columns of other effects that do as well.
    places
        Gram columns of the same effect elsewhere that do as well.
    """

    column: int
    p: float
    t: float
    gain: FloatArray
    loss: FloatArray
    rivals: tuple[int, ...]
    places: tuple[int, ...]


@dataclass(frozen=True)
class Search:
    """What was accepted, in order, and the evidence first and last."""

    steps: tuple[Step, ...]
    first: Evidence
    last: Evidence
    base: IntArray
    refused: tuple[Refusal, ...]


def search(
    lib: Library,
    signs: FloatArray,
    rules: Rules,
    seed: int = 0,
    start_loss: float | None = None,
    failed: frozenset[str] = frozenset(),
    *,
    rest: bool = True,
) -> Search:
    """Forward selection with rivals, then backward.

    Parameters
    ----------
    lib
        Candidates.
    signs
        Sign patterns of the blocks.
    rules
        Thresholds.
    seed
        Of permutations.
    start_loss
        Held-out squared error before anything was named; of this problem's calibration if absent.
    failed
        Effects that are not tried again. They stay in the family that the others' p are of, and
        may be rivals.
    rest
        Whether more is asked for than columns: else the last step that rules allow has no rivals,
        and `Search.last` is what was weighed before it.
    """
    grams = lib.grams
    base = grams.calibration
    if start_loss is None:
        start_loss = float(held_out_loss(grams.inner, base, grams.plain).sum())
    steps: list[Step] = []
    first = weigh(lib, base, signs, rules, seed)
    evidence = first
    refused: list[Refusal] = []
    while len(steps) < rules.most_effects:
        more = rest or len(steps) + 1 < rules.most_effects
        step, why = _next_step(
            lib, evidence, base, signs, rules, steps, start_loss, seed, failed, more
        )
        refused += why
        if step is None:
            break
        steps.append(step)
        base = np.unique(np.concatenate([base, _occupied(lib, step)]))
        evidence = weigh(lib, base, signs, rules, seed) if more else evidence
    kept = _backward(lib, steps, signs)
    if len(kept) < len(steps):
        dropped = [s for s in steps if s not in kept]
        refused += [
            Refusal(lib.problem.signatures[lib.index(s.column)], Why.SUPERSEDED) for s in dropped
        ]
        base = np.unique(np.concatenate([grams.calibration, *(_occupied(lib, s) for s in kept)]))
        evidence = weigh(lib, base, signs, rules, seed) if rest else evidence
    return Search(tuple(kept), first, evidence, base, tuple(refused))


def beside(rules: Rules, effects: Collection[str]) -> Rules:
    """Rules for a cause beside others, their rivals among them: what has no form leaves none."""
    exact = len(effects) > 0 and WRITTEN.issuperset(effects)
    return replace(rules, second_share=rules.later_share) if exact else rules


def _occupied(lib: Library, step: Step) -> IntArray:
    """Columns that a step takes out of the comparison: itself, its next shapes, its rivals."""
    columns = [step.column, *step.rivals]
    signatures = lib.problem.signatures
    cause = signatures[lib.index(step.column)].cause
    same = lib.columns[lib.causes.index(cause)]
    at = int(np.flatnonzero(same == step.column)[0])
    columns += [int(c) for c in same[max(at - 1, 0) : at + 2]]
    return np.unique(np.array(columns, dtype=np.int64))


def _next_step(
    lib: Library,
    evidence: Evidence,
    base: IntArray,
    signs: FloatArray,
    rules: Rules,
    steps: Sequence[Step],
    start_loss: float,
    seed: int,
    failed: frozenset[str],
    with_rivals: bool,
) -> tuple[Step | None, list[Refusal]]:
    """The best cause that meets every condition, or none."""
    grams, why = lib.grams, list[Refusal]()
    loss = held_out_loss(grams.inner, base, grams.plain)
    total = evidence.gain.sum(axis=0)
    order = np.argsort(-total)
    taken = {lib.problem.signatures[lib.index(s.column)].cause for s in steps}
    before_it = [c for s in steps for c in (s.column, *s.rivals)]
    rules = beside(rules, {lib.problem.signatures[lib.index(c)].effect for c in before_it})
    # what is refused for what it buys the user leaves the word to causes that buy more; not beside
    # a cause, whose form a weaker one may be
    refused, later = -np.inf, bool(steps) or lib.problem.accepted is not None
    for c in order:
        if not (evidence.p[c] < rules.alpha_name) or lib.causes[c] in taken:
            continue
        signature = lib.problem.signatures[lib.index(int(evidence.best[c]))]
        if signature.effect in failed:
            continue
        size = evidence.size[c]
        if not evidence.possible(int(c), signature, rules):
            why.append(Refusal(signature, Why.IMPOSSIBLE, float(size)))
            continue
        before = max(start_loss - float(loss.sum()), 0.0)
        column = lib.index(int(evidence.best[c]))
        touched = _touched(lib.problem, column)
        # what acts on other sensors is no form at all, what acts at one place none of all of them
        if _elsewhere(lib, column, before_it):
            share = rules.pair_share
        else:
            share = rules.later_share if lib.local[column] else rules.second_share
        needed = max(rules.smallest_gain * touched * float(loss.sum()), share * before)
        plain = evidence.plain_gain[:, c]
        if plain.sum() < refused:
            continue
        earned = min(sign_flip_mean(evidence.gain[:, c], signs), sign_flip_mean(plain, signs))
        few = has_few_blocks(lib.problem, float(evidence.informative[c]))
        if few or lib.local[column]:
            # one of many places: two visits have no signs to flip, the others' scatter judged them
            earned = float(evidence.p[c])
        total_loss = max(float(loss.sum()), 1e-300)
        tried = Refusal(signature, Why.UNSURE, float(size), float(plain.sum()) / total_loss)
        if plain.sum() <= needed:
            form = share * before >= needed
            limit = share if form else rules.smallest_gain * touched
            why.append(replace(tried, why=Why.FORM if form else Why.LITTLE, limit=limit))
            if later:
                return None, why
            refused = max(refused, float(plain.sum()))
            continue
        if earned > rules.alpha_rival:
            why.append(replace(tried, limit=rules.alpha_rival, p=earned))
            if later:
                return None, why
            refused = max(refused, float(plain.sum()))
            continue
        small = abs(size) < lib.smallest[column]
        signs_reach = bool(smallest_p(float(evidence.informative[c])) < rules.alpha_small)
        signs_reach = signs_reach or are_few_sessions(lib.problem)
        certain = evidence.p[c] < rules.alpha_small and signs_reach
        worth = certain or float(plain.sum()) >= rules.later_share * total_loss
        if small and (lib.problem.drifts or not worth):
            # a small cause that is certain is named and called small, but not what the form of a
            # larger one gets wrong, nor what is usual in a walk, nor what so few blocks know of
            # that a law of the noise alone makes it certain
            why.append(replace(tried, why=Why.SMALL))
            return None, why
        of = lib, evidence, base, int(c), signs, rules, seed
        return Step(
            int(evidence.best[c]), float(evidence.p[c]), float(evidence.t[c]),
            plain, loss, *(_rivals(*of) if with_rivals else ((), ())),
        ), why  # fmt: skip
    return None, why


def _elsewhere(lib: Library, column: int, taken: Sequence[int]) -> bool:
    """Whether a candidate acts on other sensors than all that is in the model, as hung legs are."""
    problem = lib.problem
    if problem.settings is None or problem.settings.sensor is None:
        return False
    mine = problem.columns[:, column] != 0.0
    named = problem.columns[np.ix_(mine, [lib.index(c) for c in taken])]
    before = named if problem.accepted is None else np.hstack([named, problem.accepted[mine]])
    return not before.any()


def _touched(problem: Problem, column: int) -> float:
    """Share of the rows that a candidate acts on, where sensors have nothing in common.

    An axis of one hanging leg cannot mend the errors of the others; the more legs hang, the less
    of the whole error is its own.
    """
    if problem.settings is None or problem.settings.sensor is None:
        return 1.0
    return float(np.mean(problem.columns[:, column] != 0.0))


def _rivals(
    lib: Library,
    evidence: Evidence,
    base: IntArray,
    best: int,
    signs: FloatArray,
    rules: Rules,
    seed: int,
) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Causes that explain the same just as well, here or by design."""
    grams = lib.grams
    total = evidence.gain.sum(axis=0)
    cos = np.abs(cosines(grams.inner, base, evidence.best))[best]
    signatures = lib.problem.signatures
    mine = signatures[lib.index(int(evidence.best[best]))]
    rivals: list[int] = []
    places: list[int] = []
    for c in range(len(lib.causes)):
        other = signatures[lib.index(int(evidence.best[c]))]
        if c == best or (other.effect, other.where) == (mine.effect, mine.where):
            continue
        alias = cos[c] > rules.alias
        if total[c] < rules.rival_share * total[best] and not alias:
            continue
        if not evidence.possible(c, other, rules):
            continue
        if _out_of_it(lib, evidence, base, best, c, signs, rules, seed):
            continue
        (places if other.effect == mine.effect else rivals).append(int(evidence.best[c]))
    return tuple(rivals), tuple(places)


def _out_of_it(
    lib: Library,
    evidence: Evidence,
    base: IntArray,
    best: int,
    other: int,
    signs: FloatArray,
    rules: Rules,
    seed: int,
) -> bool:
    """Whether data can tell the best cause from another: it still adds something beside that one.

    If the other one were the truth, the best one's score beside it would be noise. A loss
    difference holds the same evidence with twice the noise.
    """
    difference = evidence.gain[:, best] - evidence.gain[:, other]
    if not float(difference.sum()) > 0.0:
        return False
    columns = evidence.best[[best, other]]
    same = lib.columns[other]
    at = int(np.flatnonzero(same == columns[1])[0])
    beside = np.concatenate([base, same[max(at - 1, 0) : at + 2]])
    found = scores(lib.grams.inner, beside, columns[:1])
    if found.inside[0]:
        return False
    if lib.between[lib.index(int(columns[0]))]:
        p = float(between_blocks(lib, beside, columns[:1], seed)[1][0])
    else:
        p = float(sign_flip_max_t(found.score, signs).p[0])
        single_rows = has_single_rows(lib.problem)
        few = has_few_blocks(lib.problem, float(evidence.informative[best]))
        if 2.0 * p > rules.alpha_beside and (single_rows or few):
            # signs of few blocks tell little: the rows, or the scatter of all cells, can do more
            every, which = scores(lib.grams.inner, beside, lib.grams.candidates), int(columns[0])
            p = 2.0 * min(
                p,
                float(single_rows_p(lib.problem, every, beside.size)[lib.index(which)])
                if single_rows
                else of_cells_p(lib.problem.signatures, every, lib.index(which)),
            )
    return p <= rules.alpha_beside


def _backward(lib: Library, steps: Sequence[Step], signs: FloatArray) -> list[Step]:
    """Steps that still earn their place given all the others."""
    grams = lib.grams
    kept = list(steps)
    while len(kept) > 1:
        worth = []
        for step in kept:
            others = [s.column for s in kept if s is not step]
            base = np.concatenate([grams.calibration, np.array(others, dtype=np.int64)])
            group = lib.columns[
                lib.causes.index(lib.problem.signatures[lib.index(step.column)].cause)
            ]
            gain = held_out_gains(grams.inner, grams.plain, base, [group]).plain[:, 0]
            worth.append((gain.sum(), sign_flip_mean(gain, signs)))
        weakest = int(np.argmin([w[0] for w in worth]))
        if worth[weakest][0] > 0 and worth[weakest][1] < 0.05:
            break
        kept.pop(weakest)
    return kept


def sizes_of(lib: Library, steps: Sequence[Step]) -> tuple[FloatArray, FloatArray]:
    """Joint sizes of the accepted columns, and without each block."""
    chosen = np.array([s.column for s in steps], dtype=np.int64)
    return joint_sizes(lib.grams, lib.grams.calibration, chosen)
