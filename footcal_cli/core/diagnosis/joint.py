"""Several experiments diagnosed together: which causes explain all of them, with shared sizes.

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
from scipy import stats
from scipy.special import logsumexp

from footcal_cli.core.diagnosis.answer import Verdict
from footcal_cli.core.diagnosis.investigation import Found
from footcal_cli.core.diagnosis.joint_sizes import (
    JointCause,
    SingleDiagnosis,
    SizeSeen,
    members,
)
from footcal_cli.core.diagnosis.problem import Signature
from footcal_cli.core.effects.contract import Effect
from footcal_cli.core.evidence import Interval
from footcal_cli.core.parameters import FloatArray

CREDIBLE = 0.95
FORM_ERRORS = ((0.0, 0.4), (0.03, 0.2), (0.1, 0.2), (0.2, 0.2))
"""Error of an effect's form as a share of its size, and how likely it is."""
EXCLUDED = 0.003
"""p of the agreement of sizes below which one experiment excludes what another one names."""
_ONE_OF = 30.0  # effects that a cause is one of, a priori
_FURTHER = 0.1  # probability of one more cause
_NEEDED = 3.0  # sd from nothing, beside the others, below which a cause is not needed
_MOST = 4000
_GRID = 61
_WIDE = 6.0
_SAYS_NOTHING = (Verdict.UNKNOWN, Verdict.NAMED_UNKNOWN, Verdict.BAD_DATA)


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
        All experiments together, per group, with the 95 % interval.
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
    agreement: float | None
    rivals: Mapping[str, float]
    named_by: tuple[str, ...]

    @property
    def excluded(self) -> bool:
        """Whether one experiment excludes the size of another."""
        return self.agreement is not None and self.agreement < EXCLUDED


@dataclass(frozen=True)
class JointDiagnosis:
    """The answer about several experiments.

    Parameters
    ----------
    verdict
        One word.
    causes
        Of the most probable combination.
    singles
        The experiments.
    open_in
        Experiments in which something is left that no name explains.
    """

    verdict: Verdict
    causes: tuple[JointSize, ...]
    singles: tuple[SingleDiagnosis, ...]
    open_in: tuple[str, ...]

    @property
    def agreed(self) -> bool:
        """Whether its causes are an answer; else they only came nearest to one."""
        return self.verdict in (Verdict.NAMED, Verdict.AMBIGUOUS, Verdict.NAMED_UNKNOWN)


@dataclass(frozen=True)
class _Finding:
    """What one experiment names, and the candidates for it."""

    single: int
    candidates: tuple[JointCause, ...]


def diagnose_together(
    singles: Sequence[SingleDiagnosis], table: Mapping[str, Effect]
) -> JointDiagnosis:
    """One answer from the diagnoses of several experiments.

    Parameters
    ----------
    singles
        Each with its own diagnosis.
    table
        Effects by name.
    """
    usable = [s for s in singles if s.found.verdict is not Verdict.BAD_DATA]
    findings = [
        _Finding(i, _candidates(item, usable, table))
        for i, single in enumerate(usable)
        for item in single.findings
    ]
    causes = _Hypotheses(usable, findings, table).answer() if findings else ()
    open_in = tuple(s.name for s in usable if s.found.verdict in _SAYS_NOTHING)
    return JointDiagnosis(_verdict(usable, causes, open_in), causes, tuple(singles), open_in)


def _verdict(
    usable: Sequence[SingleDiagnosis], causes: Sequence[JointSize], open_in: Sequence[str]
) -> Verdict:
    own = [s.found.verdict for s in usable]
    if not own:
        return Verdict.BAD_DATA
    if any(c.excluded for c in causes):
        return Verdict.UNKNOWN
    if not causes:
        if open_in:
            return Verdict.UNKNOWN
        return Verdict.NONE if Verdict.NONE in own else Verdict.UNDERPOWERED
    several = any(len(c.rivals) > 1 for c in causes)
    if open_in:
        return Verdict.UNKNOWN if several else Verdict.NAMED_UNKNOWN
    return Verdict.AMBIGUOUS if several else Verdict.NAMED


def _candidates(
    item: Found, singles: Sequence[SingleDiagnosis], table: Mapping[str, Effect]
) -> tuple[JointCause, ...]:
    """A named cause and its rivals, in every place and shape that one of the experiments has."""
    named = item.cause.signature
    signatures = [named, *item.cause.places, *item.cause.rivals]
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


class _Hypotheses:
    """All combinations of one candidate per finding, weighed."""

    def __init__(
        self,
        singles: Sequence[SingleDiagnosis],
        findings: Sequence[_Finding],
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
        causes = []
        for cause in dict.fromkeys(best):
            covered = [i for i, c in enumerate(best) if c == cause]
            rivals: dict[str, float] = {}
            for combination, share in zip(chosen, shares, strict=True):
                name = combination[covered[0]].effect
                rivals[name] = rivals.get(name, 0.0) + float(share)
            names = tuple(self.singles[self.findings[i].single].name for i in covered)
            causes.append(self._sized(cause, best, _credible(rivals, cause.effect), names))
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
            total += np.log((_FURTHER if number else 1.0) / (_ONE_OF * self._shapes(cause, covered)))
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
        return effect.of_recording or self.singles[e].found.verdict in _SAYS_NOTHING

    def _of_group(self, cause: JointCause, seen: Mapping[int, SizeSeen], naming: set[int]) -> float:
        """Of one size: ``log ∫ p Π L db − log ∫ p L₀ db`` with L₀ of the surest that names it."""
        sure = [e for e in seen if e in naming]
        if not sure:
            return 0.0
        first = min(sure, key=lambda e: seen[e].sd)
        effect = self.table[cause.effect]
        size = next(p for p in effect.sizes if p.name == cause.parameter)
        b = _grid(
            list(seen.values()), size.prior_sd, size.lower - size.neutral, size.upper - size.neutral
        )
        start = stats.cauchy.logpdf(b, scale=size.prior_sd) + _log_likelihood(b, seen[first])
        others = np.zeros_like(b)
        for e, one in seen.items():
            if e != first:
                others = others + _log_likelihood(b, one, against_none=e not in naming)
        widths = _widths(b)
        predicted = logsumexp(start + others, b=widths) - logsumexp(start, b=widths)
        # an experiment that holds a cause which its own diagnosis does not name is no evidence for
        # it: what it holds may be that of a rival
        return min(float(predicted), 0.0)

    def _sized(
        self,
        cause: JointCause,
        best: Combination,
        rivals: Mapping[str, float],
        named_by: tuple[str, ...],
    ) -> JointSize:
        beside = tuple(c for c in dict.fromkeys(best) if c != cause)
        seen: dict[str, tuple[SizeSeen | None, ...]] = {}
        unseen: dict[str, str] = {}
        counted: list[tuple[SizeSeen | None, ...]] = []
        for e, single in enumerate(self.singles):
            sizes = self._sizes(e, cause, beside)
            if not any(sizes):
                reason = single.why_unseen(cause.effect)
                unseen[single.name] = reason or "the calibration absorbs it"
                continue
            seen[single.name] = sizes
            if single.name in named_by or not self._says_nothing(e, cause):
                counted.append(sizes)
        groups = [[s[g] for s in counted if s[g] is not None] for g in range(len(cause.groups))]
        known = [[s for s in group if s is not None] for group in groups]
        return JointSize(
            cause, seen, unseen,
            tuple(_together(group)[0] for group in known),
            _agreement(known), rivals, named_by,
        )  # fmt: skip


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


def _grid(seen: Sequence[SizeSeen], usual: float, low: float, high: float) -> FloatArray:
    """Sizes at which an integrand is looked at: dense where an experiment has its own."""
    parts = [np.linspace(-10.0, 10.0, 2 * _GRID) * usual]
    for one in seen:
        for wide in (1.0, 0.2 * abs(one.size) / one.sd):
            parts.append(one.size + np.linspace(-_WIDE, _WIDE, _GRID) * one.sd * max(wide, 0.3))
    b = np.unique(np.clip(np.concatenate(parts), low, high))
    return b if b.size > 1 else np.array([b[0] - usual, b[0]])


def _widths(b: FloatArray) -> FloatArray:
    """Weights of the trapezoid rule."""
    return np.asarray(np.gradient(b))


def _log_likelihood(b: FloatArray, seen: SizeSeen, *, against_none: bool = False) -> FloatArray:
    """Log of Student's law of a size that an experiment prefers, were it b.

    Relative to the best size, or to no such cause.
    """
    parts = []
    for share, weight in FORM_ERRORS:
        spread = np.hypot(seen.sd, share * b)
        t = _log_student((seen.size - b) / spread, seen.freedom)
        parts.append(np.log(weight) + t - np.log(spread / seen.sd))
    found = logsumexp(np.stack(parts), axis=0)
    if against_none:
        found = found - _log_student(np.array(seen.size / seen.sd), seen.freedom)
    return np.asarray(found)


def _log_student(t: FloatArray, freedom: float) -> FloatArray:
    return np.asarray(-0.5 * (freedom + 1.0) * np.log1p(t**2 / freedom))


def _together(seen: Sequence[SizeSeen]) -> tuple[Interval, float]:
    """The common size with its 95 % interval, and ``Σ (size − common)²/sd²``.

    Experiments that disagree by more than their sd widen the interval by what they do.
    """
    if not seen:
        return Interval(np.nan, np.nan, np.nan), 0.0
    size = np.array([s.size for s in seen])
    spread = np.array([s.sd for s in seen])
    weights = 1.0 / spread**2
    common = float(weights @ size / weights.sum())
    chi2 = float(weights @ (size - common) ** 2)
    wider = np.sqrt(max(chi2 / max(len(seen) - 1, 1), 1.0))
    freedom = float(sum(s.freedom for s in seen))
    half = float(stats.t.ppf(0.975, freedom) * wider / np.sqrt(weights.sum()))
    return Interval(common, common - half, common + half), chi2


def _agreement(groups: Sequence[Sequence[SizeSeen]]) -> float | None:
    """P of the same sizes in all experiments, with the largest form error that is allowed for."""
    chi2, freedom = 0.0, 0
    largest = FORM_ERRORS[-1][0]
    for seen in groups:
        if len(seen) < 2:
            continue
        common = _together(seen)[0].value
        wide = [SizeSeen(s.size, float(np.hypot(s.sd, largest * common)), s.freedom) for s in seen]
        chi2 += _together(wide)[1]
        freedom += len(seen) - 1
    return float(stats.chi2.sf(chi2, freedom)) if freedom else None
