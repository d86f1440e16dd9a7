"""The selection repeated without each fold: what a new recording may expect of it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.diagnosis.detection import block_calibrations, kinds_of
from footcal_cli.core.diagnosis.few_sessions import are_few_sessions
from footcal_cli.core.diagnosis.library import Library
from footcal_cli.core.diagnosis.pairs import likely_pairs
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.search import search
from footcal_cli.core.diagnosis.weighing import alike_as
from footcal_cli.core.inference.evidence import sign_patterns, smallest_p
from footcal_cli.core.inference.grams import Grams, whitened_grams
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.inference.scores import coefficients, losses_in_what_is_open
from footcal_cli.core.inference.whitening import Noise, has_single_rows
from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray


@dataclass(frozen=True)
class Nested:
    """Errors of blocks whose fold had no say in the choice of effects, their shape or their size.

    Parameters
    ----------
    fold
        Fold of each block, shape (B,).
    chosen
        Effects that were chosen without each fold.
    loss, bare
        Squared error of each block and output in units of the noise with what was chosen and
        without any effect, shape (B, outputs).
    removed
        What is chosen without its fold removes of each block's error, in what is open, shape (B,).
    pairs
        Effects of every pair that is likely without each fold, where a pair is chosen.
    """

    fold: IntArray
    chosen: tuple[frozenset[str], ...]
    loss: FloatArray
    bare: FloatArray
    removed: FloatArray
    pairs: tuple[tuple[frozenset[str], ...], ...] = ()

    def alike(
        self, sets: Sequence[frozenset[str]], dropped: Sequence[frozenset[str]] = ()
    ) -> BoolArray:
        """Blocks without which one effect of each set, and nothing else, was chosen, shape (B,).

        One of each set that was `dropped` may be chosen too.
        """
        allowed = frozenset().union(*sets, *dropped)
        same = [
            names <= allowed
            and 0 <= len(names) - len(sets) <= len(dropped)
            and all(names & one for one in sets)
            for names in self.chosen
        ]
        return np.asarray(np.array(same, dtype=bool)[self.fold])

    def proposed(self, sets: Sequence[frozenset[str]]) -> BoolArray:
        """Blocks without which a pair with one effect of each set is a likely one, shape (B,)."""
        same = [
            any(names <= frozenset().union(*sets) and all(names & one for one in sets)
                for names in of_fold)
            for of_fold in self.pairs
        ]  # fmt: skip
        return np.asarray(np.array(same, dtype=bool)[self.fold])


def nested_losses(
    problem: Problem,
    lib: Library,
    rules: Rules,
    most_effects: int,
    seed: int = 0,
    noise: Noise | None = None,
    *,
    pair: bool = False,
) -> Nested:
    """Run the whole search without each fold and predict the fold with what it chose.

    Parameters
    ----------
    problem, lib
        The baseline and its candidates.
    rules
        Thresholds; the level of a name is what the same evidence reaches in fewer blocks, and at
        least what they can reach at all.
    most_effects
        Effects chosen at most.
    seed
        Of sign patterns.
    noise
        In which all models are judged; that of what was chosen where absent.
    pair
        Whether two causes were looked for together: the likeliest pair is chosen.
    """
    blocks = lib.grams.blocks
    # of two sessions of a channel each is left out by itself
    few = are_few_sessions(problem)
    fold = np.arange(blocks) if few else folds_of(_alike_blocks(lib.grams), rules.most_folds)
    searched = replace(lib, likeness=_likeness(lib, rules))
    folds = range(int(fold.max()) + 1)
    pairs = [_pairs_without(searched, fold != f, rules) for f in folds] if pair else []
    picks = [
        np.array(pairs[f][0] if pairs[f] else (), dtype=np.int64)
        if pair
        else _chosen_without(searched, fold != f, replace(rules, most_effects=most_effects), seed)
        for f in folds
    ]
    used = np.unique(np.concatenate([*picks, np.empty(0, dtype=np.int64)])).astype(np.int64)
    extended = problem.without_candidates.holding(problem.columns[:, used])
    grams, _ = whitened_grams(extended, np.empty((problem.residual.size, 0)), noise)
    products = grams.inner.among(np.append(grams.calibration, grams.inner.last))
    own_size = grams.calibration.size - used.size
    base, extra, last = np.split(np.arange(products.shape[1]), [own_size, -1])
    total = products.sum(axis=0)
    at_last = [of_one.last for of_one in grams.by_output]
    loss, bare = (np.zeros((blocks, len(problem.outputs))) for _ in range(2))
    removed = np.zeros(blocks)
    for f, pick in enumerate(picks):
        mine = np.flatnonzero(fold == f)
        chosen = np.append(base, extra[np.isin(used, pick)])
        if lib.problem.pieces or lib.problem.known is not None:
            at = np.append(chosen, last)
            in_open = products[:, at[:, None], at]
            before, after = (
                losses_in_what_is_open(in_open, np.arange(count), fold == f)
                for count in (base.size, chosen.size)
            )
            removed[mine] = before - after
        left = total - products[mine].sum(axis=0)
        own = [of_one.of_blocks(fold == f) for of_one in grams.by_output]
        for out, columns in ((loss, chosen), (bare, base)):
            weights = np.append(-coefficients(left, columns, last)[:, 0], 1.0)
            for o, one in enumerate(own):
                products_of = one.among(np.append(grams.calibration[columns], at_last[o]))
                out[mine, o] = np.einsum("i,bij,j->b", weights, products_of, weights)

    def effects_of(pick: Iterable[int]) -> frozenset[str]:
        return frozenset(lib.problem.signatures[i].effect for i in pick)

    likely = tuple(tuple(map(effects_of, of_fold)) for of_fold in pairs)
    return Nested(fold, tuple(map(effects_of, picks)), loss, bare, removed, likely)


def _likeness(lib: Library, rules: Rules) -> float:
    """Of all blocks: a fold less changes nothing of it, and it is the most work of a search."""
    if lib.problem.settings is None and not has_single_rows(lib.problem):
        return 0.0
    return likeness_of(lib, rules)


def likeness_of(lib: Library, rules: Rules) -> float:
    """Number of independent tests that a search of candidates within blocks is."""
    tested = lib.grams.candidates[lib.testable & ~lib.between & ~lib.local]
    return alike_as(lib.grams, lib.grams.calibration, tested, rules.alpha_name)


def folds_of(kind: IntArray, most: int) -> IntArray:
    """Fold of each block: neighbours of a kind together, of every kind the same share in each.

    Neighbours of all kinds together would leave out a third of one cell's sessions at once, and
    what was found with all of them is not found without so many. Where each block is of a kind of
    its own (attitudes, each with a tilt of its own) a fold is a run of neighbours.

    Parameters
    ----------
    kind
        Blocks of one number are of the same sensors, shape (B,).
    most
        Folds at most.
    """
    fold = np.zeros(kind.size, dtype=np.int64)
    folds = min(kind.size, most)
    if np.unique(kind).size == kind.size:
        return np.asarray((np.arange(kind.size) * folds) // max(kind.size, 1), dtype=np.int64)
    for number in np.unique(kind):
        mine = np.flatnonzero(kind == number)
        fold[mine] = (np.arange(mine.size) * folds) // mine.size
    return np.unique(fold, return_inverse=True)[1].astype(np.int64)


def _alike_blocks(grams: Grams) -> IntArray:
    """Kind of each block: which sensors' calibration it knows of."""
    if grams.wandering.size:
        return block_calibrations(grams, grams.calibration, np.empty(0, dtype=np.int64))[2]
    columns = grams.calibration
    if not columns.size:
        return np.zeros(grams.blocks, dtype=np.int64)
    return kinds_of(grams.rows.part(columns, columns))


def _pairs_without(lib: Library, kept: BoolArray, rules: Rules) -> list[tuple[int, int]]:
    """The pairs of candidates that explain most on some of the blocks alone."""
    return likely_pairs(replace(lib, grams=lib.grams.of_blocks(kept)), rules)


def _chosen_without(lib: Library, kept: BoolArray, rules: Rules, seed: int) -> IntArray:
    """Candidates that the search accepts on some of the blocks alone."""
    # the first block of a recording, on which a filter learns, has no sign to flip
    last = np.array([lib.grams.inner.last])
    tells = lib.grams.inner.squares(last)[:, 0] != 0.0
    level = level_of_fewer(rules.alpha_name, int((kept & tells).sum()), int(tells.sum()))
    found = search(
        replace(lib, grams=lib.grams.of_blocks(kept)),
        sign_patterns(int(kept.sum()), seed),
        replace(
            rules,
            alpha_name=level,
            alpha_small=max(rules.alpha_small, level * rules.alpha_small / rules.alpha_name),
            fewest_sessions=rules.fewest_sessions - 1.0,
        ),
        seed,
        rest=False,
    )
    return np.array([lib.index(step.column) for step in found.steps], dtype=np.int64)


def chosen_without(
    lib: Library, fold: IntArray, rules: Rules, seed: int, effects: frozenset[str]
) -> BoolArray:
    """Blocks without whose fold one of some effects is the best of a single round, shape (B,).

    Parameters
    ----------
    lib
        Candidates of the round, beside the model of the rounds before it.
    fold
        Fold of each block, shape (B,).
    rules, seed
        Thresholds of that round; of sign patterns.
    effects
        Effects that begin its comparison.
    """
    searched, one = replace(lib, likeness=_likeness(lib, rules)), replace(rules, most_effects=1)
    alike = np.zeros(fold.size, dtype=bool)
    for f in range(int(fold.max(initial=-1)) + 1):
        pick = _chosen_without(searched, fold != f, one, seed)
        names = {lib.problem.signatures[i].effect for i in pick}
        alike[fold == f] = bool(names) and names <= effects
    return alike


def level_of_fewer(level: float, fewer: int, blocks: int) -> float:
    """What the same evidence per block reaches in fewer blocks, at least four times their smallest.

    Log p is proportional to the number of blocks that tell alike: ``α^(n'/n)``.
    """
    same = float(level ** (fewer / max(blocks, 1)))
    return min(max(same, 4.0 * float(smallest_p(fewer))), 1.0)
