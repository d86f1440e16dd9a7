"""The candidates of a diagnosis by column, and the causes they are alternatives of."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.inference.grams import Grams
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.inference.scores import Scores, scores, visible_products
from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray


@dataclass(frozen=True)
class Library:
    """All candidates.

    Parameters
    ----------
    problem, grams
        The data.
    causes
        (effect, parameter, where), in order of appearance.
    columns
        Gram columns of each cause (its shapes).
    visible, smallest
        Visible fraction and smallest size that matters of each candidate, shape (k,).
    between
        Which candidates are seen between blocks rather than within, shape (k,).
    testable
        Candidates with enough visible fraction, shape (k,).
    local
        Candidates that act on a single one of many places (a hole), shape (k,).
    likeness
        Number of independent tests that the candidates count as, where known beforehand (0: not).
    """

    problem: Problem
    grams: Grams
    causes: tuple[tuple[str, str, str], ...]
    columns: tuple[IntArray, ...]
    visible: FloatArray
    smallest: FloatArray
    between: BoolArray
    testable: BoolArray
    local: BoolArray
    likeness: float = 0.0

    @cached_property
    def products(self) -> FloatArray:
        """Inner products of what calibration leaves of the candidates, shape (k, k)."""
        grams = self.grams
        return visible_products(grams.inner, grams.calibration, grams.candidates)[1]

    @cached_property
    def alone(self) -> Scores:
        """Scores of all candidates, each beside the calibration alone."""
        return scores(self.grams.inner, self.grams.calibration, self.grams.candidates)

    def index(self, column: int) -> int:
        """Number of a Gram column among the candidates."""
        return column - int(self.grams.candidates[0])


def library(
    problem: Problem, grams: Grams, visible: FloatArray, smallest: FloatArray, rules: Rules
) -> Library:
    """Sort the candidates into causes, within- and between-block ones, testable or not."""
    groups: dict[tuple[str, str, str], list[int]] = {}
    whole = scores(grams.inner, grams.calibration, grams.candidates)
    inside = scores(grams.within, grams.calibration, grams.candidates)
    total = whole.information.sum(axis=0)
    share = np.divide(
        inside.information.sum(axis=0), total, out=np.zeros_like(total), where=total > 0
    )
    # a known calibration cannot move far enough for its own curvature to be all that is visible
    floor = 0.0 if problem.known is not None else rules.visible_floor
    testable = (visible >= floor) & (whole.inside == 0)
    for i, signature in enumerate(problem.signatures):
        if whole.inside[i] == 0:
            # what is barely visible is never named, but may be a rival of what is
            groups.setdefault(signature.cause, []).append(int(grams.candidates[i]))
    return Library(
        problem=problem,
        grams=grams,
        causes=tuple(groups),
        columns=tuple(np.array(c, dtype=np.int64) for c in groups.values()),
        visible=visible,
        smallest=smallest,
        between=(share < rules.between_share) & problem.alike & (not problem.drifts),
        testable=testable,
        local=np.array([any(n == "hole" for n, _ in s.shape) for s in problem.signatures], bool),
    )
