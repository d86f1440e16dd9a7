"""Two causes of different kinds against each other, each in every form of its kind.

What one loop of hysteresis gets wrong another one with a longer reach makes good: plays of several
reaches add up to any rate-independent loop (Prandtl and Ishlinskii), and several time constants to
any linear creep. A bypass that touches softly is several bypasses, and no curve of the cells. Which
kind it is must not hang on the one shape that a refit found.
"""

from __future__ import annotations

import numpy as np

from footcal_cli.core.diagnosis.answer import Cause
from footcal_cli.core.diagnosis.dictionary import CURVED, MEMORIES, SUMMED, kind_of, left_with
from footcal_cli.core.diagnosis.form import FORM
from footcal_cli.core.diagnosis.rivals import Tried
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.subject import Subject
from footcal_cli.core.effects import TABLE
from footcal_cli.core.inference.evidence import sign_flip_mean
from footcal_cli.core.inference.linear import unit_columns
from footcal_cli.core.inference.whitening import Noise
from footcal_cli.core.parameters import FloatArray

_COMPARED = ({TABLE[name].remedy for name in MEMORIES}, {CURVED, SUMMED})
"""Kinds that are distinguished so, any two of one group: what cells remember, what loads bend."""


def surer(
    subject: Subject, one: Tried, other: Tried, noise: Noise, signs: FloatArray, rules: Rules
) -> bool:
    """Whether one cause explains what another kind of it does not, whatever the form of each.

    ``E_j = L(kind j) − L(both kinds)`` is what a kind leaves to the other one on left-out blocks,
    in rows of equal noise; ``E_other > 2 E_one`` by the signs of the blocks.
    """
    if not _of_two_kinds(one.cause, other.cause):
        return False
    mine, its = (_every_form(subject, t.cause) for t in (one, other))
    fair, beside = (subject.without_credit(t.bare, t.fitted) for t in (one, other))
    both = left_with(fair, np.hstack([mine, its]), noise)
    excess = left_with(fair, mine, noise) - both
    others = left_with(beside, its, noise) - both
    return sign_flip_mean(others - FORM * excess, signs) < rules.alpha_left


def _of_two_kinds(one: Cause, other: Cause) -> bool:
    """Whether both are of one group, with two kinds."""
    kinds = {kind_of(cause.signature.effect) for cause in (one, other)}
    return len(kinds) > 1 and any(kinds <= group for group in _COMPARED)


def _every_form(subject: Subject, cause: Cause) -> FloatArray:
    """What is of a cause's kind in its place, in every shape, shape (m, k)."""
    kind, where = kind_of(cause.signature.effect), cause.signature.where
    columns = [
        i for i, s in enumerate(subject.problem.signatures)
        if kind_of(s.effect) == kind and s.where == where
    ]  # fmt: skip
    return unit_columns(subject.problem.columns[:, columns])
