"""One row per effect of the library: its size, its tests, and what can be said of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.core import chances
from footcal_cli.core.diagnosis.answer import Diagnosis, EffectRow, EffectStatus
from footcal_cli.core.diagnosis.library import Library
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.search import Search, Step, sizes_of
from footcal_cli.core.diagnosis.weighing import Evidence
from footcal_cli.core.inference.evidence import Interval, jackknife_interval, smallest_p
from footcal_cli.core.inference.problem import Problem, Signature
from footcal_cli.core.inference.scores import held_out_loss

AS_GOOD = "explains as much as "
"""Begins the reason of what is undecided between rivals."""


def evidence_rows(lib: Library, found: Search, rules: Rules) -> tuple[EffectRow, ...]:
    """The evidence table: every effect once, the accepted ones as they were accepted."""
    problem, signatures = lib.problem, lib.problem.signatures
    steps = {signatures[lib.index(s.column)].effect: s for s in found.steps}
    rivals = {
        signatures[lib.index(c)].effect: signatures[lib.index(s.column)].effect
        for s in found.steps
        for c in s.rivals
    }
    rows: list[EffectRow] = []
    for effect in dict.fromkeys(s.effect for s in problem.signatures):
        causes = [
            c for c, cause in enumerate(lib.causes)
            if cause[0] == effect and any(lib.testable[lib.index(int(x))] for x in lib.columns[c])
        ]  # fmt: skip
        if not causes:
            rows.append(_untestable(problem, lib, effect))
        elif effect in steps:
            rows.append(_accepted_row(lib, found, steps[effect], rules))
        elif effect in rivals:
            rows.append(_as_good(_row(lib, found, found.first, causes, rules), rivals[effect]))
        else:
            rows.append(_row(lib, found, found.last, causes, rules))
    return tuple(sorted(rows, key=order_of_row))


def order_of_row(row: EffectRow) -> tuple[bool, bool, float]:
    """By gain; sizes that cannot be come after those that can, and what was not tested last."""
    return row.status is EffectStatus.NOT_TESTABLE, not possible(row), -row.gain


def possible(row: EffectRow) -> bool:
    """Whether the interval reaches a size that the effect can have."""
    signature = row.signature
    return bool(row.size.high >= signature.lower and row.size.low <= signature.upper)


def rival_row(answer: Diagnosis, rival: Signature, named: str) -> EffectRow | None:
    """A rival weighed where the named cause was, not beside it.

    None where the data hide it, and of one that is a rival by its law where it was not weighed.
    """
    lib = answer.library
    causes = [c for c, cause in enumerate(lib.causes) if cause[0] == rival.effect]
    there = [c for c in causes if lib.causes[c][2] == rival.where]
    if not there:
        return None
    row = _row(lib, answer.search, answer.search.first, there, answer.rules)
    return _as_good(row, named)


def found_row(row: EffectRow, rivals: Sequence[str]) -> EffectRow:
    """The row of what was found, by its size; beside rivals it is no more certain than they are."""
    if rivals:
        return _as_good(row, ", ".join(rivals))
    if _matters(row.size, row.smallest):
        reason = "interval beyond the smallest size that matters"
        return replace(row, status=EffectStatus.PRESENT, reason=reason)
    reason = "found, but its interval reaches below the smallest size that matters"
    return replace(row, status=EffectStatus.UNDECIDED, reason=reason)


def _as_good(row: EffectRow, named: str) -> EffectRow:
    return replace(row, status=EffectStatus.UNDECIDED, reason=AS_GOOD + named)


def _row(
    lib: Library, found: Search, evidence: Evidence, causes: Sequence[int], rules: Rules
) -> EffectRow:
    """The row of an effect: the best of its causes by some evidence."""
    grams = lib.grams
    base = grams.calibration if evidence is found.first else found.base
    loss = float(held_out_loss(grams.inner, base, grams.plain).sum())
    # where too few blocks know of it nothing can be said; look where something can
    gains = evidence.gain.sum(axis=0)
    known = [c for c in causes if smallest_p(evidence.informative[c]) <= rules.alpha_name]
    best = max(known or causes, key=lambda c: gains[c])

    def shown(cause: int) -> bool:
        smallest = float(lib.smallest[lib.index(int(evidence.best[cause]))])
        return _matters(evidence.interval(cause), smallest)

    if known and not shown(best):
        # absent of all cells together may be there in one, of which too few blocks know
        hidden = [c for c in causes if c not in known and shown(c)]
        best = max(hidden, key=lambda c: gains[c], default=best)
    at = lib.index(int(evidence.best[best]))
    size = evidence.interval(best)
    se = (size.high - size.low) / 2.0 / max(_student(grams.blocks), 1e-9)
    smallest = float(lib.smallest[at])
    status, reason = _status(size, smallest, float(evidence.informative[best]), rules)
    gain = evidence.plain_gain[:, best]
    return EffectRow(
        signature=lib.problem.signatures[at],
        size=size,
        smallest=smallest,
        detectable=_detectable(se, grams.blocks, _critical(found.first, rules), rules),
        visible=float(lib.visible[at]),
        p=float(evidence.p[best]),
        gain=float(gain.sum()) / max(loss, 1e-300),
        informative=float(evidence.informative[best]),
        blocks_better=int(np.sum(gain > 0)),
        status=status,
        reason=reason,
    )


def _matters(size: Interval, smallest: float) -> bool:
    """Whether the whole interval of a size lies beyond the smallest that matters."""
    return size.low > smallest or size.high < -smallest


def _student(blocks: int) -> float:
    return float(chances.t_ppf(0.975, max(blocks - 1, 1)))


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
    return float(_FLIPPED_TOO * se * (needed + chances.norm_ppf(rules.power)))


def _status(
    size: Interval, smallest: float, informative: float, rules: Rules
) -> tuple[EffectStatus, str]:
    if smallest_p(informative) > rules.alpha_name:
        return EffectStatus.NOT_TESTABLE, f"only {informative:.1f} informative blocks"
    if _matters(size, smallest):
        return EffectStatus.UNDECIDED, "its interval excludes zero but it did not stand the tests"
    if -smallest < size.low and size.high < smallest:
        return EffectStatus.ABSENT, "interval within the sizes that do not matter"
    if size.high - size.low > 2.0 * smallest:
        return EffectStatus.NOT_TESTABLE, "interval wider than the sizes that matter"
    return EffectStatus.UNDECIDED, "interval straddles the smallest size that matters"


def _accepted_row(lib: Library, found: Search, step: Step, rules: Rules) -> EffectRow:
    at = lib.index(step.column)
    smallest, critical = float(lib.smallest[at]), _critical(found.first, rules)
    sizes, without = sizes_of(lib, found.steps)
    which = found.steps.index(step)
    size = jackknife_interval(float(sizes[which]), without[:, which])
    first = found.first
    cause = lib.causes.index(lib.problem.signatures[at].cause)
    others = dict.fromkeys(lib.problem.signatures[lib.index(c)].effect for c in step.rivals)
    se = (size.high - size.low) / 2.0 / max(_student(lib.grams.blocks), 1e-9)
    row = EffectRow(
        signature=lib.problem.signatures[at],
        size=size,
        smallest=smallest,
        detectable=_detectable(se, lib.grams.blocks, critical, rules),
        visible=float(lib.visible[at]),
        p=step.p,
        gain=float(step.gain.sum() / max(step.loss.sum(), 1e-300)),
        informative=float(first.informative[cause]),
        blocks_better=int(np.sum(step.gain > 0)),
        status=EffectStatus.PRESENT,
        reason="",
    )
    return found_row(row, tuple(others))


def _untestable(problem: Problem, lib: Library, effect: str) -> EffectRow:
    members = [i for i, s in enumerate(problem.signatures) if s.effect == effect]
    at = members[int(np.argmax(lib.visible[members]))]
    acts = bool(np.any(problem.columns[:, at]))
    reason = (
        f"the calibration absorbs nearly all of it ({lib.visible[at]:.1%} is visible)"
        if acts
        else "its driver did not move"
    )
    nothing = Interval(0.0, -np.inf, np.inf)
    return EffectRow(
        problem.signatures[at], nothing, float(lib.smallest[at]), np.inf, float(lib.visible[at]),
        1.0, 0.0, 0.0, 0, EffectStatus.NOT_TESTABLE, reason,
    )  # fmt: skip
