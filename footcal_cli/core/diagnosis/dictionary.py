"""Every form of a kind of causes as columns: curves, loops, linear memories."""

from __future__ import annotations

import numpy as np

from footcal_cli.core.diagnosis.answer import Cause
from footcal_cli.core.diagnosis.memories import MEMORIES
from footcal_cli.core.diagnosis.rivals import SMOOTH
from footcal_cli.core.diagnosis.subject import Subject
from footcal_cli.core.diagnosis.unnamed import CURVES
from footcal_cli.core.effects import TABLE
from footcal_cli.core.effects.contract import Scope
from footcal_cli.core.inference.case import Case, channels_of
from footcal_cli.core.inference.linear import unit_columns
from footcal_cli.core.inference.shapes import shapes_of
from footcal_cli.core.inference.signatures import derivative
from footcal_cli.core.parameters import FloatArray

CURVED = "curve"
"""The kind of all curves of a cell's own load."""
COMPLETE = frozenset({CURVED, *(TABLE[name].remedy for name in MEMORIES)})
"""Kinds whose columns add up to every form that a cause of theirs may have."""


def kinds_of(cause: Cause) -> frozenset[str]:
    """The kinds of an effect and of all its rivals."""
    return frozenset(kind_of(s.effect) for s in (cause.signature, *cause.rivals))


def kind_of(effect: str) -> str:
    """The kind of an effect: of a memory its remedy; its own name where it is of none."""
    if effect in CURVES:
        return CURVED
    return TABLE[effect].remedy if effect in MEMORIES else effect


def kinds_at(subject: Subject, ideal: Case, cause: Cause) -> dict[str, FloatArray]:
    """Columns of each kind where a cause acts, each in every shape, shape (m, k)."""
    found: dict[str, list[FloatArray]] = {}
    for name in sorted(MEMORIES | SMOOTH):
        for shape in shapes_of(ideal, TABLE[name]):
            found.setdefault(kind_of(name), []).extend(
                derivative(ideal, subject.problem, TABLE[name], TABLE[name].size, owners, shape,
                           seen=ideal.memory())
                for owners in _places(subject, cause)
            )  # fmt: skip
    return {kind: unit_columns(np.stack(columns, axis=1)) for kind, columns in found.items()}


def _places(subject: Subject, cause: Cause) -> list[dict[str, tuple[str, ...]]]:
    """Owners with one size each: the cells of a cause, all of them where it acts on no cell."""
    if subject.table[cause.signature.effect].scope is Scope.CHANNEL:
        return [{owner: units} for owner, units in cause.signature.owners]
    return [{"all": tuple(channels_of(subject.case.logs))}]
