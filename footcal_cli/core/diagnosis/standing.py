"""Whether an answer holds without single blocks: chosen again, and better than what else would be.

Of the room of the diagnosis; `footcal_cli.core.diagnosis.investigation` asks.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.diagnosis.answer import Cause, Verdict
from footcal_cli.core.diagnosis.contenders import fit
from footcal_cli.core.diagnosis.departure import (
    Departure,
    as_known,
    departure_of,
    of_calibration,
)
from footcal_cli.core.diagnosis.few_sessions import are_few_sessions
from footcal_cli.core.diagnosis.field import white_loss
from footcal_cli.core.diagnosis.gain import (
    Gain,
    bought,
    gains_from,
    gains_of,
    output_losses,
    removed_in_what_is_open,
    without_rivals,
)
from footcal_cli.core.diagnosis.nested import chosen_without, likeness_of, nested_losses
from footcal_cli.core.diagnosis.path import Path
from footcal_cli.core.diagnosis.rivals import excess_of
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.subject import Subject
from footcal_cli.core.inference.evidence import sign_flip_mean, sign_patterns
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.inference.refit import Refit
from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray

LEAST_STABLE = 0.5
"""Share of blocks without which a name is chosen again, below which it is none."""


@dataclass(frozen=True)
class Standing:
    """An answer and what a new recording may expect of it.

    Parameters
    ----------
    path, verdict, share
        The answer.
    gains
        Held-out errors per output, the selection repeated without each fold.
    stable
        Share of blocks without which the same effects are chosen.
    p
        That it predicts blocks of stances no better, by signs of the blocks; 0 elsewhere.
    better
        Whether it predicts blocks better at all.
    departure
        How far the calibration must be from what was known of it, without and with the names.
    """

    path: Path
    verdict: Verdict
    share: float
    gains: tuple[Gain, ...]
    stable: float
    p: float
    better: bool = True
    departure: Departure | None = None

    @property
    def holds(self) -> bool:
        """Whether it predicts blocks that had no say, and is chosen without most of them.

        Where a known calibration could take up what is wrong, blocks are predicted as well without
        a name: there it is how far that calibration had to move which tells.
        """
        rules = self.path.rounds[0].rules
        if self.stable < LEAST_STABLE:
            return False
        if self.departure is not None and self.departure.p < rules.alpha_name:
            # a single name after which the calibration is still far off leaves something
            return not self.departure.far or self.verdict is Verdict.AMBIGUOUS
        return self.p <= rules.alpha_rival and self.better


def standing(
    subject: Subject, path: Path, verdict: Verdict, share: float, rules: Rules, seed: int
) -> Standing:
    """Repeat the selection of named causes without each fold.

    The linear search without a fold may begin with another effect than the one that a full refit
    surely prefers: beside a single named cause such an effect is refitted in its place, and begins
    the same comparison where it is surely worse.

    Parameters
    ----------
    subject, path
        What is diagnosed, and a path with at least one cause.
    verdict, share
        The verdict on it, and the share of what can be explained that it explains.
    rules, seed
        Thresholds; of sign patterns.
    """
    problem, final = subject.problem, path.current
    library, count = path.rounds[0].library, len(path.causes)
    most = count + len(path.dropped)
    nested = nested_losses(problem, library, rules, most, seed, final.law, pair=path.pair)
    begun = [cause.begun_by for cause in path.causes]
    alike = nested.alike(begun, path.dropped)
    if count == 1 and path.model is not None and not alike.all():
        others = frozenset().union(*nested.chosen) - begun[0]
        alike = nested.alike([begun[0] | _behind(subject, path, path.model, others)])
    if count > 1 and not alike.all():
        # what one cause leaves shows the next one only once the first is fitted
        gone = _ruled_out_later(path)
        rounds = [
            chosen_without(
                answer.library, nested.fold, answer.rules, seed,
                frozenset().union(*begun[i:]) - gone,
            )
            for i, answer in enumerate(path.answers)
        ]  # fmt: skip
        alike = alike | np.all(rounds, axis=0)
    if path.instead and not alike.all():
        # first sight may prefer another pair without a fold too: of those likely there the one
        # that loses least once refitted is chosen
        ahead = _ahead(subject, path, nested.fold)[nested.fold]
        alike = alike | (nested.proposed(begun) & ahead)
    if path.model is not None and are_few_sessions(problem):
        # of two sessions of a cell the one left over chooses nothing; its size predicts the other
        alike = alike | _known_to_one_other(problem, path.model)
    extended = without_rivals(final, path.model)
    named = [cause.signature for cause in path.causes]
    p, departure, hidden = 0.0, None, of_calibration(problem, named)
    better = False
    if hidden:
        gains = gains_of(as_known(problem), as_known(extended), final.law)
    else:
        # blocks without which other effects are chosen are predicted by those, their fold left out
        same = alike[:, None]
        old = np.where(same, output_losses(problem, final.law), nested.bare)
        new = np.where(same, output_losses(extended, final.law), nested.loss)
        gains = gains_from(problem, old, new)
    if problem.pieces or problem.known is not None:
        # a test of rows takes the pieces of a stance for more than they are, and a name may only
        # spare a known calibration a way that no block asks for: blocks judge too
        removed = removed_in_what_is_open(problem, extended, final.law)
        removed = np.where(alike, removed, nested.removed)
        better = float(removed.sum()) > 0.0
        p = sign_flip_mean(removed, sign_patterns(problem.blocks, seed))
    if problem.pieces or hidden:
        among = likeness_of(library, rules)
        departure = departure_of(problem, extended, final.law, count, among)
    # without whitening a model that undoes a low-pass, a dead zone, or a play that hides small
    # changes of load, is blamed for the noise that it makes larger: where a calibration is tracked,
    # the innovations are what a model answers for
    innovated = problem.tracking is not None and path.removed > 0.0
    better = better or innovated or bought(gains, problem) > 0.0
    return Standing(path, verdict, share, gains, float(np.mean(alike)), p, better, departure)


def _known_to_one_other(problem: Problem, model: Refit) -> BoolArray:
    """Blocks that show the names, where fewer than two others do, shape (B,)."""
    rows = np.any(model.columns != 0.0, axis=1)
    shows = np.bincount(problem.block, rows, minlength=problem.blocks) > 0
    return np.asarray(shows & (shows.sum() - 1 < _CHOOSE))


_CHOOSE = 2
"""Blocks that must know of a cause to choose it and to be predicted by it."""


def _ahead(subject: Subject, path: Path, fold: IntArray) -> BoolArray:
    """Whether a pair loses less than each that was refitted before it, without each fold, (folds,).

    Held-out squared errors of all blocks but those of the fold, in the noise of the pair.
    """

    def loss(of: Path) -> FloatArray:
        fair = of.current if of.model is None else subject.without_credit(of.current, of.model)
        return white_loss(fair, path.current.law)

    mine = loss(path)
    more = np.array([loss(other) - mine for other in path.instead])
    without = more.sum(axis=1)[:, None] - np.array([np.bincount(fold, one) for one in more])
    return np.asarray(np.all(without > 0.0, axis=0))


def _ruled_out_later(path: Path) -> frozenset[str]:
    """Rivals of the causes before the last, which only a later cause spoke against.

    Without a fold that chooses one of them the later cause would not have been looked for; not so
    where the search with all folds began with it, or each was found beside the other.
    """
    if path.both_ways:
        return frozenset()
    before, now = path.shorter, (s for c in path.causes for s in (c.signature, *c.rivals))
    was = () if before is None else (s for c in before.causes for s in c.rivals)
    began = frozenset(answer.causes[0].signature.effect for answer in path.answers)
    return frozenset(s.effect for s in was) - frozenset(s.effect for s in now) - began


def happened(subject: Subject, path: Path, verdict: Verdict) -> Standing:
    """An answer whose cause happened once: no block repeats it, so that none can confirm it."""
    final = path.current
    gains = gains_of(subject.problem, without_rivals(final, path.model), final.law)
    return Standing(path, verdict, 1.0, gains, stable=1.0, p=path.causes[0].p)


def _behind(subject: Subject, path: Path, model: Refit, effects: Iterable[str]) -> frozenset[str]:
    """Effects that surely predict left-out blocks worse in the place of the only cause."""

    def loss(bare: Problem, fitted: Refit) -> FloatArray:
        return white_loss(subject.without_credit(bare, fitted), path.current.law)

    mine = loss(subject.bare(model, [replace(path.causes[0], rivals=(), places=())]), model)
    found = set()
    for effect in sorted(effects):
        _, fitted, bare = fit(subject, (), None, _best_of(path, effect))
        if excess_of(loss(bare, fitted), mine).low > 0.0:
            found.add(effect)
    return frozenset(found)


def _best_of(path: Path, effect: str) -> Cause:
    """An effect where, and in the shape in which, it explains most beside the baseline."""
    baseline = path.rounds[0]
    evidence, lib = baseline.search.first, baseline.library
    mine = [c for c, (name, *_) in enumerate(lib.causes) if name == effect]
    best = max(mine, key=lambda c: float(evidence.gain[:, c].sum()))
    signature = lib.problem.signatures[lib.index(int(evidence.best[best]))]
    return replace(
        path.causes[0], signature=signature, size=evidence.interval(best), rivals=(), places=()
    )
