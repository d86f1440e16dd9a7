"""From a problem to a verdict: detect, name, look for rivals, ask whether the name is enough."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from scipy import stats

from footcal_cli.core.diagnosis.detection import LEVEL_SHARE, Detection, detect
from footcal_cli.core.diagnosis.features import Features, features_of
from footcal_cli.core.diagnosis.problem import Problem, Signature
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.scores import coefficients, held_out_gains, held_out_loss
from footcal_cli.core.diagnosis.search import (
    Evidence,
    Library,
    Search,
    Step,
    library,
    search,
    sizes_of,
    weigh,
)
from footcal_cli.core.diagnosis.whitening import Grams, whitened_grams
from footcal_cli.core.evidence import (
    Interval,
    jackknife_interval,
    mean_interval,
    sign_patterns,
    smallest_p,
)
from footcal_cli.core.parameters import FloatArray, IntArray


class Verdict(StrEnum):
    """What a diagnosis ends with; exactly one."""

    NONE = "none"
    NAMED = "named"
    AMBIGUOUS = "ambiguous"
    NAMED_UNKNOWN = "named+unknown"
    UNKNOWN = "unknown"
    UNDERPOWERED = "underpowered"
    BAD_DATA = "bad-data"


class EffectStatus(StrEnum):
    """What can be said about one effect."""

    PRESENT = "present"
    ABSENT = "absent"
    UNDECIDED = "undecided"
    NOT_TESTABLE = "not_testable"


@dataclass(frozen=True)
class Cause:
    """A named effect.

    Parameters
    ----------
    signature
        Effect, place, parameter, shape.
    size
        With its 95 % interval over blocks.
    p
        Family-wise p when it was accepted.
    gain
        Held-out reduction of the RMS error when it was accepted, as a share of the RMS before,
        with the interval over blocks.
    blocks_better
        Number of held-out blocks it improves.
    heterogeneity
        I²: share of the scatter of its size over blocks that is not noise.
    rivals, places
        Other effects that do as well; the same effect elsewhere.
    """

    signature: Signature
    size: Interval
    p: float
    gain: Interval
    blocks_better: int
    heterogeneity: float
    rivals: tuple[Signature, ...]
    places: tuple[Signature, ...]


@dataclass(frozen=True)
class EffectRow:
    """One line of the evidence table.

    Parameters
    ----------
    signature
        The effect where and in the shape in which it explains most.
    size
        With its 95 % interval; on top of what was named.
    smallest
        Smallest size that matters, in the effect's unit.
    detectable
        Size that would have been found with the wanted power, in the effect's unit.
    visible
        Share of the effect that calibration cannot absorb.
    p, gain
        Family-wise p, and held-out reduction of the squared error as a share.
    informative
        Effective number of informative blocks.
    blocks_better
        Held-out blocks it improves.
    status, reason
        What can be said and why.
    """

    signature: Signature
    size: Interval
    smallest: float
    detectable: float
    visible: float
    p: float
    gain: float
    informative: float
    blocks_better: int
    status: EffectStatus
    reason: str


@dataclass(frozen=True)
class Diagnosis:
    """The answer of the engine.

    Parameters
    ----------
    verdict
        One word.
    causes
        Named effects in the order in which they were accepted.
    effects
        One row per effect of the library, by gain.
    before, after
        Library-free evidence on the baseline and on the extended model.
    share
        Named gain over named gain plus what could still be explained.
    search, library, grams, features
        The working, for figures.
    nested
        Held-out share of the RMS error removed when the selection is repeated in every fold, with
        the interval over blocks.
    rules
        Thresholds.
    """

    verdict: Verdict
    causes: tuple[Cause, ...]
    effects: tuple[EffectRow, ...]
    before: Detection
    after: Detection
    share: float
    search: Search
    library: Library
    grams: Grams
    features: Features
    nested: Interval
    rules: Rules

    @property
    def smallest_p(self) -> float:
        """Smallest p that so many blocks can reach."""
        return float(smallest_p(float(self.grams.blocks)))


def diagnose(problem: Problem, rules: Rules | None = None, seed: int = 0) -> Diagnosis:
    """Run the whole procedure on arrays.

    Parameters
    ----------
    problem
        Residual, calibration, candidates.
    rules
        Thresholds.
    seed
        Of sign patterns and permutations where they are drawn.
    """
    rules = rules or Rules()
    features = features_of(problem)
    grams, whitener = whitened_grams(problem, features.columns)
    signs = sign_patterns(grams.blocks, seed)
    visible, smallest = _yardsticks(problem, grams)
    lib = library(problem, grams, visible, rules)
    before = detect(problem, grams, features, whitener, grams.calibration, signs)
    found = search(lib, signs, rules, seed, smallest)
    after = before
    if found.steps:
        accepted = problem.columns[:, [lib.index(s.column) for s in found.steps]]
        after = detect(problem, grams, features, whitener, found.base, signs, accepted)
    share = _share(grams, found, after)
    causes = _causes(lib, found)
    return Diagnosis(
        verdict=_verdict(grams, lib, found, before, after, share, rules),
        causes=causes,
        effects=_rows(lib, found, smallest, signs, rules, seed),
        before=before,
        after=after,
        share=share,
        search=found,
        library=lib,
        grams=grams,
        features=features,
        nested=_nested(lib, found.steps),
        rules=rules,
    )


def _yardsticks(problem: Problem, grams: Grams) -> tuple[FloatArray, FloatArray]:
    """Visible fraction and smallest size that matters of each candidate."""
    if problem.tracking is None:
        left = problem.left()
        return problem.visible(left), problem.smallest_sizes(left)
    smallest = np.full(len(problem.signatures), np.inf)
    for o in range(len(problem.outputs)):
        rows = problem.output == o
        if not rows.any():
            continue
        rms = np.sqrt(grams.energy[o, grams.candidates] / rows.sum()) * problem.noise[rows][0]
        with np.errstate(divide="ignore"):
            smallest = np.minimum(smallest, problem.tolerance[o] / rms)
    return grams.visible[grams.candidates], smallest


def leftover(detection: Detection, rules: Rules) -> bool:
    """Whether something is left that a name should exist for.

    A dependence on the recorded signals must be worth something on blocks it was not fitted to;
    in long recordings the slightest imperfection is significant.
    """
    if detection.p >= rules.alpha_unknown:
        return False
    apart = min(
        detection.line_p / LEVEL_SHARE["line"], detection.between_p / LEVEL_SHARE["between"]
    )
    return apart < rules.alpha_unknown or detection.ceiling >= rules.smallest_gain


def _share(grams: Grams, found: Search, after: Detection) -> float:
    """Named gain over named gain plus the leftover that a flexible learner still explains."""
    if not found.steps:
        return 0.0
    start = held_out_loss(grams.inner, grams.calibration, grams.plain).sum()
    end = held_out_loss(grams.inner, found.base, grams.plain).sum()
    named = max(float(start - end), 0.0)
    left = max(float(after.flexible_gain.sum()), 0.0)
    return named / (named + left) if named + left > 0 else 0.0


def _verdict(
    grams: Grams,
    lib: Library,
    found: Search,
    before: Detection,
    after: Detection,
    share: float,
    rules: Rules,
) -> Verdict:
    both = bool(np.any(lib.between & lib.testable) and np.any(~lib.between & lib.testable))
    level = rules.alpha_name / (2.0 if both else 1.0)
    if smallest_p(float(grams.blocks)) > level:
        return Verdict.UNDERPOWERED
    if not found.steps:
        return Verdict.UNKNOWN if leftover(before, rules) else Verdict.NONE
    left = leftover(after, rules)
    if share < rules.share_named or (left and share < rules.share_partly):
        return Verdict.UNKNOWN
    if any(step.rivals for step in found.steps):
        return Verdict.AMBIGUOUS
    return Verdict.NAMED_UNKNOWN if left else Verdict.NAMED


def _causes(lib: Library, found: Search) -> tuple[Cause, ...]:
    """Accepted effects with joint sizes and their scatter over blocks."""
    if not found.steps:
        return ()
    sizes, without = sizes_of(lib, found.steps)
    signatures = lib.problem.signatures
    causes = []
    for i, step in enumerate(found.steps):
        causes.append(
            Cause(
                signature=signatures[lib.index(step.column)],
                size=jackknife_interval(float(sizes[i]), without[:, i]),
                p=step.p,
                gain=_rms_gain(step.loss, step.gain),
                blocks_better=int(np.sum(step.gain > 0)),
                heterogeneity=_heterogeneity(lib, found.steps, i),
                rivals=tuple(signatures[lib.index(c)] for c in step.rivals),
                places=tuple(signatures[lib.index(c)] for c in step.places),
            )
        )
    return tuple(causes)


def _rms_gain(loss: FloatArray, gain: FloatArray) -> Interval:
    """Relative reduction of the RMS error with a jackknife interval over blocks."""

    def share(before: float, bought: float) -> float:
        return 1.0 - float(np.sqrt(max(before - bought, 0.0) / max(before, 1e-300)))

    value = share(loss.sum(), gain.sum())
    without = np.array(
        [share(loss.sum() - a, gain.sum() - g) for a, g in zip(loss, gain, strict=True)]
    )
    return jackknife_interval(value, without)


def _heterogeneity(lib: Library, steps: Sequence[Step], which: int) -> float:
    """I² of the sizes fitted to single blocks, calibration shared: 1 − (B − 1)/Q."""
    grams = lib.grams
    last = grams.inner.shape[1] - 1
    others = np.array([s.column for i, s in enumerate(steps) if i != which], dtype=np.int64)
    base = np.concatenate([grams.calibration, others])
    column = steps[which].column
    wanted = np.array([column, last])
    total = grams.inner.sum(axis=0)
    gamma = (
        np.linalg.pinv(total[np.ix_(base, base)], rcond=1e-10, hermitian=True)
        @ total[np.ix_(base, wanted)]
    )
    weights = np.zeros((grams.inner.shape[1], 2))
    weights[wanted, [0, 1]] = 1.0
    weights[base] = -gamma
    reduced = np.einsum("ik,bij,jl->bkl", weights, grams.inner, weights, optimize=True)
    information, score = reduced[:, 0, 0], reduced[:, 0, 1]
    size = score.sum() / max(information.sum(), 1e-300)
    spread = np.sum((score - information * size) ** 2 / np.maximum(information, 1e-300))
    rows = max(float(grams.blocks), 2.0)
    return float(np.clip(1.0 - (rows - 1.0) / max(spread, 1e-300), 0.0, 1.0))


def _rows(
    lib: Library,
    found: Search,
    smallest: FloatArray,
    signs: FloatArray,
    rules: Rules,
    seed: int,
) -> tuple[EffectRow, ...]:
    """The evidence table: every effect once, the accepted ones as they were accepted."""
    problem, grams = lib.problem, lib.grams
    last = found.last
    loss = float(held_out_loss(grams.inner, found.base, grams.plain).sum())
    critical = _critical(found.first, rules)
    steps = {problem.signatures[lib.index(s.column)].effect: s for s in found.steps}
    rivals = {
        problem.signatures[lib.index(c)].effect: problem.signatures[lib.index(s.column)].effect
        for s in found.steps
        for c in s.rivals
    }
    rows: list[EffectRow] = []
    for effect in dict.fromkeys(s.effect for s in problem.signatures):
        causes = [
            c
            for c, cause in enumerate(lib.causes)
            if cause[0] == effect and any(lib.testable[lib.index(int(x))] for x in lib.columns[c])
        ]
        if not causes:
            rows.append(_untestable(problem, lib, effect, smallest))
            continue
        step = steps.get(effect)
        evidence = found.first if effect in rivals else last
        if step is not None:
            rows.append(_accepted_row(lib, found, step, smallest, critical))
            continue
        # where too few blocks know of it nothing can be said; look where something can
        known = [c for c in causes if smallest_p(evidence.informative[c]) <= rules.alpha_name]
        causes = known or causes
        best = causes[int(np.argmax(evidence.gain.sum(axis=0)[causes]))]
        column = int(evidence.best[best])
        at = lib.index(column)
        size = jackknife_interval(float(evidence.size[best]), evidence.size_without[:, best])
        se = (size.high - size.low) / 2.0 / max(_student(grams.blocks), 1e-9)
        status, reason = _status(
            size, float(smallest[at]), float(evidence.informative[best]), rules
        )
        if effect in rivals:
            status, reason = EffectStatus.UNDECIDED, f"explains as much as {rivals[effect]}"
        gain = evidence.plain_gain[:, best]
        rows.append(
            EffectRow(
                signature=problem.signatures[at],
                size=size,
                smallest=float(smallest[at]),
                detectable=_detectable(se, grams.blocks, critical, rules),
                visible=float(lib.visible[at]),
                p=float(evidence.p[best]),
                gain=float(gain.sum()) / max(loss, 1e-300),
                informative=float(evidence.informative[best]),
                blocks_better=int(np.sum(gain > 0)),
                status=status,
                reason=reason,
            )
        )
    return tuple(sorted(rows, key=lambda r: (r.status is EffectStatus.NOT_TESTABLE, -r.gain)))


def _student(blocks: int) -> float:
    return float(stats.t.ppf(0.975, max(blocks - 1, 1)))


def _critical(evidence: Evidence, rules: Rules) -> float:
    if not evidence.null_max.size:
        return np.inf
    return float(np.quantile(evidence.null_max, 1.0 - rules.alpha_name / 2.0, method="higher"))


_FLIPPED_TOO = (
    1.3  # an effect that is there widens its own sign-flip null; measured on four effects
)


def _detectable(se: float, blocks: int, critical: float, rules: Rules) -> float:
    """Size found with the wanted power: T = √B μ/√(1 + μ²) must exceed its critical value."""
    if not np.isfinite(se) or critical**2 >= blocks:
        return np.inf
    needed = critical / np.sqrt(1.0 - critical**2 / blocks)
    return float(_FLIPPED_TOO * se * (needed + stats.norm.ppf(rules.power)))


def _status(
    size: Interval, smallest: float, informative: float, rules: Rules
) -> tuple[EffectStatus, str]:
    if smallest_p(informative) > rules.alpha_name:
        return EffectStatus.NOT_TESTABLE, f"only {informative:.1f} informative blocks"
    if size.low > smallest or size.high < -smallest:
        return EffectStatus.UNDECIDED, "its interval excludes zero but it did not stand the tests"
    if -smallest < size.low and size.high < smallest:
        return EffectStatus.ABSENT, "interval within the sizes that do not matter"
    if size.high - size.low > 2.0 * smallest:
        return EffectStatus.NOT_TESTABLE, "interval wider than the sizes that matter"
    return EffectStatus.UNDECIDED, "interval straddles the smallest size that matters"


def _accepted_row(
    lib: Library, found: Search, step: Step, smallest: FloatArray, critical: float
) -> EffectRow:
    at = lib.index(step.column)
    sizes, without = sizes_of(lib, found.steps)
    which = found.steps.index(step)
    size = jackknife_interval(float(sizes[which]), without[:, which])
    first = found.first
    cause = lib.causes.index(lib.problem.signatures[at].cause)
    matters = size.low > smallest[at] or size.high < -smallest[at]
    status = EffectStatus.PRESENT if matters and not step.rivals else EffectStatus.UNDECIDED
    others = ", ".join(
        dict.fromkeys(lib.problem.signatures[lib.index(c)].effect for c in step.rivals)
    )
    reason = (
        f"explains as much as {others}" if step.rivals
        else "interval beyond the smallest size that matters" if matters
        else "found, but its interval reaches below the smallest size that matters"
    )  # fmt: skip
    se = (size.high - size.low) / 2.0 / max(_student(lib.grams.blocks), 1e-9)
    return EffectRow(
        signature=lib.problem.signatures[at],
        size=size,
        smallest=float(smallest[at]),
        detectable=_detectable(se, lib.grams.blocks, critical, Rules()),
        visible=float(lib.visible[at]),
        p=step.p,
        gain=float(step.gain.sum() / max(step.loss.sum(), 1e-300)),
        informative=float(first.informative[cause]),
        blocks_better=int(np.sum(step.gain > 0)),
        status=status,
        reason=reason,
    )


def _untestable(problem: Problem, lib: Library, effect: str, smallest: FloatArray) -> EffectRow:
    members = [i for i, s in enumerate(problem.signatures) if s.effect == effect]
    at = members[int(np.argmax(lib.visible[members]))]
    acts = bool(np.any(problem.columns[:, at]))
    reason = (
        f"only {lib.visible[at]:.1%} of it is visible beside the calibration"
        if acts
        else "its driver did not move"
    )
    nothing = Interval(0.0, -np.inf, np.inf)
    return EffectRow(
        problem.signatures[at], nothing, float(smallest[at]), np.inf, float(lib.visible[at]),
        1.0, 0.0, 0.0, 0, EffectStatus.NOT_TESTABLE, reason,
    )  # fmt: skip


def _nested(lib: Library, steps: Sequence[Step]) -> Interval:
    """Repeat the selection in every fold: the gain that a new recording may expect."""
    grams = lib.grams
    errors = np.zeros((grams.blocks, 2))
    if not steps:
        return mean_interval(np.zeros(grams.blocks))
    for b in range(grams.blocks):
        others = np.delete(np.arange(grams.blocks), b)
        for stage, base in enumerate((grams.calibration, _selected(lib, others, len(steps)))):
            fitted = _fit(grams.inner[others].sum(axis=0), base)
            own = grams.plain[b]
            used = np.append(base, own.shape[0] - 1)
            w = np.append(-fitted, 1.0)
            errors[b, stage] = w @ own[np.ix_(used, used)] @ w
    return _rms_gain(errors[:, 0], errors[:, 0] - errors[:, 1])


def _fit(gram: FloatArray, base: IntArray) -> FloatArray:
    return coefficients(gram, base, np.array([gram.shape[0] - 1]))[:, 0]


def _selected(lib: Library, blocks: IntArray, steps: int) -> IntArray:
    """Base chosen by held-out gain on some of the blocks alone."""
    grams = lib.grams
    inner, plain = grams.inner[blocks], grams.plain[blocks]
    base = grams.calibration
    groups = list(lib.columns)
    for _ in range(steps):
        gains = held_out_gains(inner, plain, base, groups).white.sum(axis=0)
        best = int(np.argmax(gains))
        if gains[best] <= 0:
            break
        total = inner.sum(axis=0)
        drops = []
        for column in groups[best]:
            with_it = np.append(base, column)
            fitted = _fit(total, with_it)
            drops.append(fitted @ total[with_it, -1])
        base = np.append(base, groups[best][int(np.argmax(drops))])
        groups.pop(best)
    return base


__all__ = ["Cause", "Diagnosis", "EffectRow", "EffectStatus", "Verdict", "diagnose", "weigh"]
