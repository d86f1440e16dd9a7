"""One row per effect of the library: its size, its tests, and what can be said of it."""

from __future__ import annotations

import numpy as np
from scipy import stats

from footcal_cli.core.diagnosis.answer import EffectRow, EffectStatus
from footcal_cli.core.diagnosis.library import Library
from footcal_cli.core.diagnosis.problem import Problem
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.scores import held_out_loss
from footcal_cli.core.diagnosis.search import Search, Step, sizes_of
from footcal_cli.core.diagnosis.weighing import Evidence
from footcal_cli.core.evidence import Interval, jackknife_interval, smallest_p
from footcal_cli.core.parameters import FloatArray


def evidence_rows(
    lib: Library, found: Search, smallest: FloatArray, signs: FloatArray, rules: Rules, seed: int
) -> tuple[EffectRow, ...]:
    """The evidence table: every effect once, the accepted ones as they were accepted."""
    problem, grams = lib.problem, lib.grams
    last = found.last
    alone, beside = (
        float(held_out_loss(grams.inner, base, grams.plain).sum())
        for base in (grams.calibration, found.base)
    )
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
        # a rival is weighed where the accepted one was, all others beside it
        evidence, loss = (found.first, alone) if effect in rivals else (last, beside)
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
