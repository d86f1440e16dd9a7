"""From a problem to a verdict: detect, name, look for rivals, ask whether the name is enough."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footcal_cli.core.diagnosis.answer import Cause, Diagnosis, Verdict
from footcal_cli.core.diagnosis.detection import Detection, detect
from footcal_cli.core.diagnosis.evidence_table import evidence_rows
from footcal_cli.core.diagnosis.features import features_of
from footcal_cli.core.diagnosis.few_sessions import are_few_sessions
from footcal_cli.core.diagnosis.form import Form, form_of
from footcal_cli.core.diagnosis.gain import rms_gain
from footcal_cli.core.diagnosis.library import Library, library
from footcal_cli.core.diagnosis.rules import LEVEL_SHARE, Rules
from footcal_cli.core.diagnosis.search import Search, Step, search, sizes_of
from footcal_cli.core.diagnosis.yardsticks import yardsticks
from footcal_cli.core.inference.evidence import jackknife_interval, sign_patterns, smallest_p
from footcal_cli.core.inference.grams import Grams, whitened_grams
from footcal_cli.core.inference.linear import scaled_inverse
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.inference.scores import cosines, held_out_loss
from footcal_cli.core.parameters import IntArray


def diagnose(
    problem: Problem,
    rules: Rules | None = None,
    seed: int = 0,
    start_loss: float | None = None,
    failed: frozenset[str] = frozenset(),
) -> Diagnosis:
    """Run the whole procedure on arrays.

    Parameters
    ----------
    problem
        Residual, calibration, candidates.
    rules
        Thresholds.
    seed
        Of sign patterns and permutations where they are drawn.
    start_loss
        Held-out squared error before anything was named, where `problem` holds accepted effects.
    failed
        Effects that did not stand their refit and are not named again.
    """
    rules = rules or Rules()
    features = features_of(problem)
    grams, _ = whitened_grams(problem, features.columns)
    signs = sign_patterns(grams.blocks, seed)
    visible, smallest = yardsticks(problem, grams)
    lib = library(problem, grams, visible, smallest, rules)
    before = detect(problem, grams, features, grams.calibration, signs)
    found = search(lib, signs, rules, seed, start_loss, failed)
    after, form, removed = before, None, 0.0
    if found.steps:
        accepted = problem.columns[:, [lib.index(s.column) for s in found.steps]]
        after = detect(problem, grams, features, found.base, signs, accepted)
        form = form_of(_with(problem, lib, found.base), accepted, signs)
        removed = _removed(grams, found)
    causes = _causes(lib, found)
    return Diagnosis(
        verdict=_verdict(lib, found, after, form, removed, rules),
        causes=causes,
        effects=evidence_rows(lib, found, rules),
        before=before,
        after=after,
        form=form,
        share=share_of(removed, after, form),
        search=found,
        library=lib,
        grams=grams,
        features=features,
        rules=rules,
    )


def leftover(detection: Detection, rules: Rules) -> bool:
    """Whether something is left that a name should exist for.

    A dependence on the recorded signals must be worth something, on blocks it was not fitted to or
    beyond chance, and larger than what matters: in long recordings the slightest imperfection is
    significant.
    """
    if detection.p >= rules.alpha_unknown:
        return False
    bent = bool(detection.bends_with(rules.alpha_unknown))
    worth = max(detection.ceiling, detection.curve.share if bent else 0.0)
    return left_apart(detection, rules) or worth >= max(rules.smallest_gain, detection.tolerated)


def left_apart(detection: Detection, rules: Rules) -> bool:
    """Whether something is left that is no dependence on a signal: a line, a wander, spells."""
    apart = min(
        detection.line_p / LEVEL_SHARE["line"],
        detection.between_p / LEVEL_SHARE["between"],
        detection.spell_p / LEVEL_SHARE["spell"],
    )
    return apart < rules.alpha_unknown


def _with(problem: Problem, lib: Library, base: IntArray) -> Problem:
    """The problem with the candidates of a base accepted."""
    taken = [lib.index(int(c)) for c in np.intersect1d(base, lib.grams.candidates)]
    return problem.holding(problem.columns[:, taken])


def _removed(grams: Grams, found: Search) -> float:
    """Held-out squared error that the names remove."""
    start = held_out_loss(grams.inner, grams.calibration, grams.plain).sum()
    end = held_out_loss(grams.inner, found.base, grams.plain).sum()
    return float(start - end)


def share_of(named: float, after: Detection, form: Form | None) -> float:
    """Share of what can be explained that the names explain.

    Parameters
    ----------
    named
        Held-out squared error that the names remove.
    after, form
        What is left once they are in.
    """
    bought = 0.0 if form is None else form.bought
    return _share(named, max(float(after.flexible_gain.sum()), bought))


def _share(named: float, left: float) -> float:
    """Named gain over named gain plus what is left to gain."""
    return max(named, 0.0) / max(max(named, 0.0) + max(left, 0.0), 1e-300)


def look_alike(lib: Library, columns: IntArray, rules: Rules) -> bool:
    """Whether two of the named look so alike that together they may copy what has no name."""
    cos = np.abs(cosines(lib.grams.inner, lib.grams.calibration, columns))
    return bool(np.any(np.triu(cos, 1) > rules.alike_together))


def enough(
    named: float,
    after: Detection,
    form: Form | None,
    rules: Rules,
    *,
    between: bool,
    several: bool = False,
) -> bool:
    """Whether the names explain what is wrong well enough to be said.

    Parameters
    ----------
    named
        Held-out squared error that they remove.
    after, form
        What is left once they are in.
    rules
        Thresholds.
    between
        Whether a named effect acts between blocks: it has not explained a calibration that still
        follows temperature or time.
    several
        Whether a name has rivals: a set says of what kind it is, and less of its form.
    """
    if between and after.between_p / LEVEL_SHARE["between"] < rules.alpha_unknown:
        return False
    most = rules.share_set if several else 1.0
    bent = form is not None and form.p < rules.alpha_form
    needed = rules.share_partly if leftover(after, rules) else rules.share_named
    constant = form is None or not bent or _share(named, form.bought) >= min(rules.share_form, most)
    return constant and share_of(named, after, form) >= min(needed, most)


def _verdict(
    lib: Library,
    found: Search,
    after: Detection,
    form: Form | None,
    removed: float,
    rules: Rules,
) -> Verdict:
    both = bool(np.any(lib.between & lib.testable) and np.any(~lib.between & lib.testable))
    level = rules.alpha_name / (2.0 if both else 1.0)
    scattered = are_few_sessions(lib.problem) and bool(found.steps)
    if smallest_p(float(lib.grams.blocks)) > level and not scattered:
        return Verdict.UNDERPOWERED
    left = leftover(after, rules)
    if not found.steps:
        return Verdict.UNKNOWN if left else Verdict.NONE
    named = np.array([lib.index(step.column) for step in found.steps])
    between = bool(lib.between[named].any())
    columns = np.array([step.column for step in found.steps])
    if not enough(removed, after, form, rules, between=between) or look_alike(lib, columns, rules):
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
                gain=rms_gain(step.loss, step.gain),
                blocks_better=int(np.sum(step.gain > 0)),
                heterogeneity=_heterogeneity(lib, found.steps, i),
                rivals=tuple(signatures[lib.index(c)] for c in step.rivals),
                places=tuple(signatures[lib.index(c)] for c in step.places),
            )
        )
    return tuple(causes)


def _heterogeneity(lib: Library, steps: Sequence[Step], which: int) -> float:
    """I² of the sizes fitted to single blocks, calibration shared: 1 − (B − 1)/Q."""
    grams = lib.grams
    others = np.array([s.column for i, s in enumerate(steps) if i != which], dtype=np.int64)
    base = np.concatenate([grams.calibration, others])
    column = steps[which].column
    used = np.concatenate([base, [column, grams.inner.last]])
    products = grams.inner.part(used, used)
    total = products.sum(axis=0)
    gamma = scaled_inverse(total[:-2, :-2], 1e-10) @ total[:-2, -2:]
    weights = np.vstack([-gamma, np.eye(2)])
    reduced = weights.T @ products @ weights
    information, score = reduced[:, 0, 0], reduced[:, 0, 1]
    size = score.sum() / max(information.sum(), 1e-300)
    spread = np.sum((score - information * size) ** 2 / np.maximum(information, 1e-300))
    rows = max(float(grams.blocks), 2.0)
    return float(np.clip(1.0 - (rows - 1.0) / max(spread, 1e-300), 0.0, 1.0))
