"""Combinations of one candidate per finding of several experiments, weighed.

Each experiment has been diagnosed by itself; its answer is a set of names for each cause, which its
own data cannot narrow. Here one name per finding is tried in every combination. A cause has one
size in all experiments; noise and calibration stay each experiment's own:

``p(S | all) ∝ Π_{c∈S} p(c) ∫ p(b) Π_e L_e(b, c) db``

with ``L_e`` Student's law of the size that experiment e prefers, relative to the best that e has
(where e names c) or to no such cause (where it does not). An experiment thus judges between the
names of another one only by sizes: one that e names must have the same size there, one that e would
have shown must be absent nowhere. Form errors of 0–20 % of a size are allowed for.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.special import logsumexp

from footcal_cli.core import chances
from footcal_cli.core.diagnosis.answer import Verdict
from footcal_cli.core.diagnosis.investigation import Found
from footcal_cli.core.diagnosis.joint_likelihood import (
    agreement,
    common_size,
    log_likelihood,
    size_grid,
    trapezoids,
)
from footcal_cli.core.diagnosis.joint_refit import RefittedCause, refitted_together
from footcal_cli.core.diagnosis.joint_sizes import JointCause, SingleDiagnosis, SizeSeen, members
from footcal_cli.core.effects.contract import Effect
from footcal_cli.core.inference.evidence import Interval
from footcal_cli.core.inference.problem import Signature

CREDIBLE = 0.95
EXCLUDED = 0.003
"""p of the agreement of sizes below which one experiment excludes what another one names."""
SAYS_NOTHING = (Verdict.UNKNOWN, Verdict.NAMED_UNKNOWN, Verdict.BAD_DATA)
_ONE_OF = 30.0  # effects that a cause is one of, a priori
_FURTHER = 0.1  # probability of one more cause
_NEEDED = 3.0  # sd from nothing, beside the others, below which a cause is not needed
_MOST = 4000

Combination = tuple[JointCause, ...]
"""One candidate per finding."""


@dataclass(frozen=True)
class JointSize:
    """A cause with its size in every experiment.

    Parameters
    ----------
    cause
        What and where.
    seen
        Experiment -> size of each group, None where it says nothing of it.
    unseen
        Experiment -> why it says nothing.
    size
        All experiments together, per group, with the 95 % interval; of an effect with a shape, of
        the surest experiment.
    shape
        Values of the shape parameters there.
    agreement
        p of the sizes being the same, form errors allowed for; None where one experiment alone
        knows of it.
    rivals
        Effect -> probability, the cause itself first, of those that make up the credible set.
    named_by
        Experiments whose own diagnosis names it or has it among its rivals.
    """

    cause: JointCause
    seen: Mapping[str, tuple[SizeSeen | None, ...]]
    unseen: Mapping[str, str]
    size: tuple[Interval, ...]
    shape: Mapping[str, float]
    agreement: float | None
    rivals: Mapping[str, float]
    named_by: tuple[str, ...]

    @property
    def excluded(self) -> bool:
        """Whether one experiment excludes the size of another."""
        return self.agreement is not None and self.agreement < EXCLUDED


@dataclass(frozen=True)
class SingleFinding:
    """What one experiment names, and the candidates for it."""

    single: int
    candidates: tuple[JointCause, ...]


def candidates_of(
    item: Found, singles: Sequence[SingleDiagnosis], table: Mapping[str, Effect]
) -> tuple[JointCause, ...]:
    """A named cause and its rivals, in every place and shape that one of the experiments has.

    A rival by its law alone has no columns anywhere: no experiment can weigh it.
    """
    named = item.cause.signature
    weighed = (rival for rival in item.cause.rivals if rival.owners)
    signatures = [named, *item.cause.places, *weighed]
    found: dict[JointCause, None] = {}
    for signature in signatures:
        groups, where = _everywhere(signature, singles)
        for shape in _shapes(signature, singles, table):
            cause = JointCause(
                signature.effect, signature.parameter, signature.unit, groups, where, shape
            )
            found[cause] = None
    return tuple(found)


def _everywhere(
    signature: Signature, singles: Sequence[SingleDiagnosis]
) -> tuple[tuple[frozenset[str], ...], str]:
    """The groups of a signature among all units: all cells of one experiment are all of all."""
    effect, where = signature.effect, signature.where
    if len(signature.owners) > 1:
        return tuple(frozenset(units) for _, units in signature.owners), where
    group = members(signature)
    every = frozenset[str]().union(*(s.units.get(effect, frozenset()) for s in singles))
    whole = any(
        len(group) > 1 and group == s.units.get(effect, frozenset()) for s in singles
    )  # fmt: skip
    return (every if whole else group,), where


def _shapes(
    signature: Signature, singles: Sequence[SingleDiagnosis], table: Mapping[str, Effect]
) -> list[tuple[tuple[str, float], ...]]:
    """Shapes that any of the experiments tries."""
    if not table[signature.effect].shapes:
        return [()]
    found = dict.fromkeys(
        s.shape for one in singles for s in one.found.problem.signatures
        if (s.effect, s.parameter) == (signature.effect, signature.parameter)
    )  # fmt: skip
    return list(found) or [signature.shape]


class Hypotheses:
    """All combinations of one candidate per finding, weighed."""

    def __init__(
        self,
        singles: Sequence[SingleDiagnosis],
        findings: Sequence[SingleFinding],
        table: Mapping[str, Effect],
    ) -> None:
        self.singles = singles
        self.findings = findings
        self.table = table
        self._known: dict[tuple[object, ...], float] = {}
        self._seen: dict[tuple[object, ...], tuple[SizeSeen | None, ...]] = {}
        self._gains: dict[tuple[object, ...], dict[JointCause, float]] = {}

    def answer(self) -> tuple[JointSize, ...]:
        """The causes of the most probable combination, each with its credible set."""
        chosen = self._likely()
        weights = np.array([self._log_evidence(c) for c in chosen])
        shares = np.exp(weights - logsumexp(weights))
        best = chosen[int(np.argmax(weights))]
        sized = self._sized(best)
        causes = []
        for cause in dict.fromkeys(best):
            covered = [i for i, c in enumerate(best) if c == cause]
            rivals: dict[str, float] = {}
            for combination, share in zip(chosen, shares, strict=True):
                name = combination[covered[0]].effect
                rivals[name] = rivals.get(name, 0.0) + float(share)
            names = tuple(self.singles[self.findings[i].single].name for i in covered)
            causes.append(self._stated(cause, sized[cause], _credible(rivals, cause.effect), names))
        return tuple(causes)

    def _likely(self) -> list[Combination]:
        """Combinations to weigh: all of them, of each finding its best alone where too many."""
        options = [list(f.candidates) for f in self.findings]
        while np.prod([float(len(o)) for o in options]) > _MOST:
            longest = max(range(len(options)), key=lambda i: len(options[i]))
            alone = [self._log_predicted(c, (longest,), ()) for c in options[longest]]
            options[longest].pop(int(np.argmin(alone)))
        return list(product(*options))

    def _log_evidence(self, combination: Combination) -> float:
        """Log of prior times evidence of a combination."""
        total, causes = 0.0, tuple(dict.fromkeys(combination))
        for number, cause in enumerate(causes):
            covered = tuple(i for i, c in enumerate(combination) if c == cause)
            beside = tuple(c for c in causes if c != cause)
            if not self._needed(cause, covered, beside):
                return -np.inf
            prior = (_FURTHER if number else 1.0) / _ONE_OF / self._shapes(cause, covered)
            total += float(np.log(prior))
            total += self._log_predicted(cause, covered, beside)
        return total

    def _needed(self, cause: JointCause, covered: tuple[int, ...], beside: Combination) -> bool:
        """Whether a cause is something beside the others, where it is named."""
        seen = [
            s
            for i in covered
            for s in self._sizes(self.findings[i].single, cause, beside)
            if s is not None
        ]
        return not beside or any(abs(s.size) > _NEEDED * s.sd for s in seen)

    def _shapes(self, cause: JointCause, covered: tuple[int, ...]) -> int:
        """Number of shapes and places that an effect is tried in."""
        tried = self.findings[covered[0]].candidates
        return sum(c.effect == cause.effect for c in tried)

    def _log_predicted(
        self, cause: JointCause, covered: tuple[int, ...], beside: Combination
    ) -> float:
        """How well the surest size of a cause predicts what the other experiments say of it.

        What an experiment that names a cause says of its rivals is left as it is: there they are
        as good as each other, and only another shape or place of the same effect is worse.
        """
        key = (cause, covered, beside)
        if key not in self._known:
            naming = {self.findings[i].single for i in covered}
            total = sum(0.5 * self._less(i, cause, beside) for i in covered)
            seen = {
                e: self._sizes(e, cause, beside)
                for e in range(len(self.singles))
                if e in naming or not self._says_nothing(e, cause)
            }
            for g in range(len(cause.groups)):
                there = {e: found[g] for e, found in seen.items()}
                total += self._of_group(cause, {e: s for e, s in there.items() if s}, naming)
            self._known[key] = total
        return self._known[key]

    def _sizes(self, e: int, cause: JointCause, beside: Combination) -> tuple[SizeSeen | None, ...]:
        key = (e, cause, beside)
        if key not in self._seen:
            self._seen[key] = self.singles[e].sizes(cause, beside)
        return self._seen[key]

    def _less(self, finding: int, cause: JointCause, beside: Combination) -> float:
        """Gain of a candidate in the experiment that names it, less the best of its effect."""
        there = self.findings[finding]
        key = (finding, cause.effect, beside)
        if key not in self._gains:
            alike = [c for c in there.candidates if c.effect == cause.effect]
            single = self.singles[there.single]
            self._gains[key] = {c: single.gain(c, beside) for c in alike}
        gains = self._gains[key]
        return gains[cause] - max(gains.values())

    def _says_nothing(self, e: int, cause: JointCause) -> bool:
        """Whether an experiment that does not name a cause says nothing of it either.

        What belongs to a recording is in that one alone; where something without a name is left,
        every size is off.
        """
        effect = self.table[cause.effect]
        return effect.of_recording or self.singles[e].found.verdict in SAYS_NOTHING

    def _of_group(self, cause: JointCause, seen: Mapping[int, SizeSeen], naming: set[int]) -> float:
        """Of one size: ``log ∫ p Π L db − log ∫ p L₀ db`` with L₀ of the surest that names it."""
        sure = [e for e in seen if e in naming]
        if not sure:
            return 0.0
        first = min(sure, key=lambda e: seen[e].sd)
        effect = self.table[cause.effect]
        size = next(p for p in effect.sizes if p.name == cause.parameter)
        b = size_grid(
            list(seen.values()), size.prior_sd, size.lower - size.neutral, size.upper - size.neutral
        )
        start = chances.cauchy_logpdf(b, scale=size.prior_sd) + log_likelihood(b, seen[first])
        others = np.zeros_like(b)
        for e, one in seen.items():
            if e != first:
                others = others + log_likelihood(b, one, against_none=e not in naming)
        widths = trapezoids(b)
        predicted = logsumexp(start + others, b=widths) - logsumexp(start, b=widths)
        # an experiment that holds a cause which its own diagnosis does not name is no evidence for
        # it: what it holds may be that of a rival
        return min(float(predicted), 0.0)

    def _sized(self, best: Combination) -> dict[JointCause, dict[int, RefittedCause]]:
        """Cause -> experiment -> its sizes there, after a refit of what each experiment sees."""
        causes = tuple(dict.fromkeys(best))
        found: dict[JointCause, dict[int, RefittedCause]] = {cause: {} for cause in causes}
        for e, single in enumerate(self.singles):
            linear = {}
            for cause in causes:
                seen = self._sizes(e, cause, tuple(c for c in causes if c != cause))
                if any(seen):
                    linear[cause] = seen
            if linear:
                for cause, refit in refitted_together(
                    single, tuple(linear), linear, self.table
                ).items():
                    found[cause][e] = refit
        return found

    def _stated(
        self,
        cause: JointCause,
        sized: Mapping[int, RefittedCause],
        rivals: Mapping[str, float],
        named_by: tuple[str, ...],
    ) -> JointSize:
        names = [single.name for single in self.singles]
        seen = {names[e]: one.sizes for e, one in sized.items() if any(one.sizes)}
        unseen = {
            single.name: single.why_unseen(cause.effect) or "the calibration absorbs it"
            for single in self.singles
            if single.name not in seen
        }
        counted = {
            e: one
            for e, one in sized.items()
            if names[e] in seen and (names[e] in named_by or not self._says_nothing(e, cause))
        }
        # sizes at shapes of their own are not the same number: the surest experiment's are stated
        surest = max(counted, key=lambda e: _sureness(counted[e].sizes))
        shape = counted[surest].shape
        used = {surest: counted[surest]} if shape else counted
        groups = [
            [s for s in (one.sizes[g] for one in used.values()) if s is not None]
            for g in range(len(cause.groups))
        ]
        linear = [self._sizes(e, cause, ()) for e in counted] if shape else [
            one.sizes for one in counted.values()
        ]  # fmt: skip
        compared = [
            [s for s in (sizes[g] for sizes in linear) if s is not None]
            for g in range(len(cause.groups))
        ]
        return JointSize(
            cause, seen, unseen, tuple(common_size(group)[0] for group in groups), shape,
            agreement(compared), rivals, named_by,
        )  # fmt: skip


def _sureness(sizes: Sequence[SizeSeen | None]) -> float:
    return max((s.sureness for s in sizes if s is not None), default=0.0)


def _credible(shares: Mapping[str, float], first: str) -> dict[str, float]:
    """The smallest set with a probability of `CREDIBLE`, the named one first."""
    kept, total = {first: shares[first]}, shares[first]
    for name in sorted(shares, key=lambda n: -shares[n]):
        if total >= CREDIBLE:
            break
        if name != first:
            kept[name] = shares[name]
            total += shares[name]
    return kept
