"""What became of the rivals of a log before, once the experiment that tells them apart is made.

A rival explains the log before at a size of its own. Were it the cause, the new log would hold it
at just that size: a share of one; of the others it would hold nothing.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from footcal_cli.core.diagnosis.answer import Diagnosis, Verdict
from footcal_cli.core.diagnosis.investigation import Investigation
from footcal_cli.core.diagnosis.menu import LIKE
from footcal_cli.core.diagnosis.next_experiment import ambiguity
from footcal_cli.core.diagnosis.rehearsal import Contender
from footcal_cli.core.effects.contract import Effect, can_carry, units_of
from footcal_cli.core.inference.case import Case, channels_of
from footcal_cli.core.inference.evidence import Interval, jackknife_interval
from footcal_cli.core.inference.grams import Grams, whitened_grams
from footcal_cli.core.inference.ideal import balanced
from footcal_cli.core.inference.scores import joint_sizes, scores
from footcal_cli.core.inference.signatures import derivative
from footcal_cli.core.parameters import FloatArray, IntArray

HALF = 0.5
"""Share that divides what is there from what is gone."""
_UNSURE = 10.0  # half width beyond which a share says nothing
_TWO_SIDED = 1.96  # sd of a 95 % interval
_BESIDE_UNKNOWN = (Verdict.UNKNOWN, Verdict.NAMED_UNKNOWN)
_SPEAKS = (Verdict.NONE, Verdict.NAMED, Verdict.AMBIGUOUS)


@dataclass(frozen=True)
class Suspect:
    """A rival with the sizes at which it explains the log before.

    Parameters
    ----------
    effect
        Name in the table.
    owners
        Who carries it, as in a link.
    values
        Its parameters by short name.
    sd
        Of its size there, as a share of it.
    """

    effect: str
    owners: Mapping[str, tuple[str, ...]]
    values: Mapping[str, float]
    sd: float = 0.0


class Says(StrEnum):
    """What a new log says of a suspect."""

    THERE = "there"
    GONE = "gone"
    OPEN = "open"
    UNSEEN = "unseen"


_OUT_ALONE = Says.OPEN, Says.GONE
"""What is said of a suspect beside the others and on its own, where that rules it out."""


@dataclass(frozen=True)
class Followed:
    """A suspect in a new log.

    Parameters
    ----------
    effect
        Its name.
    share
        Of it that the new log holds, all suspects together, with the 95 % interval over blocks; on
        its own where the others would copy it, or where together they say nothing and that rules
        it out; None where the experiment does not show it.
    sd
        Of the size that the log before asked for, as a share of it.
    """

    effect: str
    share: Interval | None
    sd: float = 0.0

    @property
    def says(self) -> Says:
        """There if it is not nothing, gone if it is not what the other log asked for, or neither.

        Both logs count in the second; what is there in part is neither.
        """
        if self.share is None:
            return Says.UNSEEN
        value, low, high = self.share.value, self.share.low, self.share.high
        short = value + np.hypot(high - value, _TWO_SIDED * self.sd) < 1.0
        if value < HALF and short and (low <= 0 or high < HALF):
            return Says.GONE
        return Says.THERE if value > HALF and low > 0 else Says.OPEN


def suspects_of(found: Investigation, table: Mapping[str, Effect]) -> tuple[Suspect, ...]:
    """The first group of rivals, each as large as it must be."""
    if found.verdict is not Verdict.AMBIGUOUS:
        return ()
    item = next((item for item in found.found if item.cause.rivals), None)
    if item is None:
        return ()
    rivals = ambiguity(found, table)
    named, *others = rivals
    # what was named has sizes from its own refit, and what copies it follows from these: all its
    # axes fitted would fit the noise too, and find it again where the same log is diagnosed again
    first = replace(_as_large(named, item.answer, table), values=dict(named.values))
    return first, *(
        Suspect(r.signature.effect, dict(r.signature.owners), dict(r.values), first.sd)
        if r.copies
        else _as_large(r, item.answer, table)
        for r in others
    )


def _as_large(rival: Contender, answer: Diagnosis, table: Mapping[str, Effect]) -> Suspect:
    """A rival with all its sizes fitted in the place of the cause."""
    signature, effect = rival.signature, table[rival.signature.effect]
    place = signature.effect, signature.where, signature.shape
    signatures = answer.library.problem.signatures
    axes = [i for i, s in enumerate(signatures) if (s.effect, s.where, s.shape) == place]
    values, sd = dict(rival.values), 0.0
    if axes:
        columns = answer.grams.candidates[axes]
        sizes, without = joint_sizes(answer.grams, answer.grams.calibration, columns)
        parameters = {p.name: p for p in effect.sizes}
        own = [parameters[signatures[i].parameter] for i in axes]
        # as far as those data show each axis: one that they hardly know adds no doubt
        along = answer.library.products[np.ix_(axes, axes)] @ sizes
        share = jackknife_interval(1.0, without @ along / max(float(sizes @ along), 1e-300))
        sd = min(share.high - 1.0, _UNSURE) / _TWO_SIDED
        for p, size in zip(own, sizes, strict=True):
            values[p.name] = float(np.clip(p.neutral + size, p.lower, p.upper))
    return Suspect(signature.effect, dict(signature.owners), values, sd)


def followed(
    found: Investigation, suspects: Sequence[Suspect], table: Mapping[str, Effect]
) -> tuple[Followed, ...]:
    """How much of each suspect a new log holds.

    Parameters
    ----------
    found
        The new log, diagnosed.
    suspects
        From the log before.
    table
        Effects that are still in question.
    """
    ideal = balanced(found.case, found.case.values)
    columns = [_column(found, ideal, suspect, table) for suspect in suspects]
    seen = [i for i, column in enumerate(columns) if column is not None]
    became = [Followed(s.effect, None, s.sd) for s in suspects]
    if not seen:
        return tuple(became)
    some = found.problem.signatures[:1] * len(seen)
    made = np.stack([c for c in columns if c is not None], axis=1)
    problem = replace(found.problem, columns=made, signatures=some)
    grams, _ = whitened_grams(problem, np.empty((len(made), 0)))
    together = _shares(grams, grams.candidates)
    for i, share, column in zip(seen, together, grams.candidates, strict=True):
        beside = replace(became[i], share=share)
        # the cause is here in full whether or not its rivals are fitted too; what these data do not
        # tell apart has no share beside each other, and still one on its own
        alone = replace(beside, share=_shares(grams, column[None])[0])
        same = not _distinguished(grams, column)
        became[i] = alone if same or (beside.says, alone.says) == _OUT_ALONE else beside
    return tuple(became)


def _distinguished(grams: Grams, column: int) -> bool:
    """Whether the other suspects leave enough of one that it has a share of its own."""
    one, base = np.array([column]), grams.calibration
    others = grams.candidates[grams.candidates != column]
    whole = scores(grams.inner, base, one).information.sum()
    left = scores(grams.inner, np.concatenate([base, others]), one).information.sum()
    return bool(left > (1.0 - LIKE**2) * whole)


def _shares(grams: Grams, columns: IntArray) -> list[Interval]:
    """How much of each column a log holds, these columns together."""
    value, without = joint_sizes(grams, grams.calibration, columns)
    return [jackknife_interval(float(v), w) for v, w in zip(value, without.T, strict=True)]


def survivors(verdict: Verdict, named: Sequence[str], after: Sequence[Followed]) -> tuple[str, ...]:
    """Suspects that are left: those named anew, else those there, else those not gone.

    Beside something without a name nobody is left by elimination: only the one that is there at
    just the size that the log before asked for.

    Parameters
    ----------
    verdict, named
        Of the new log; effects that it names, rivals too.
    after
        The suspects in it.
    """
    there = [f.effect for f in after if f.says is Says.THERE]
    if verdict in _BESIDE_UNKNOWN:
        just = [f.effect for f in after if f.effect in there and f.share and f.share.low <= 1.0
                and f.share.high >= 1.0]  # fmt: skip
        return tuple(just) if len(there) == 1 else ()
    if verdict not in _SPEAKS:
        return ()
    again = [f.effect for f in after if f.effect in named]
    return tuple(again or there or [f.effect for f in after if f.says is not Says.GONE])


def _column(
    found: Investigation, ideal: Case, suspect: Suspect, table: Mapping[str, Effect]
) -> FloatArray | None:
    """What a suspect would add to the new log's residual; None where nothing."""
    effect, case = table.get(suspect.effect), found.case
    if effect is None or case.experiment.name not in effect.experiments:
        return None
    channels = channels_of(case.logs)
    known = set.intersection(*(set(log.known) for log in case.logs))
    if not can_carry(channels, effect) or not set(effect.needs) <= known:
        return None
    units = set(units_of(effect.scope, channels))
    owners = {o: tuple(m for m in members if m in units) for o, members in suspect.owners.items()}
    owners = {owner: members for owner, members in owners.items() if members}
    if not owners:
        return None
    shape = {p.name: suspect.values[p.name] for p in effect.shapes if p.name in suspect.values}
    column = np.zeros(found.problem.residual.size)
    for size in effect.sizes:
        by = suspect.values.get(size.name, size.neutral) - size.neutral
        if by:
            column += by * derivative(ideal, found.problem, effect, size, owners, shape)
    return column if column.any() else None
