"""Zeros that were read before a cause: what changes a transducer changes its zero too.

A pose that is balanced by six sums knows of no leg's zero; hanging knows it, of the transducer as
it was. With another matrix, or with a case that takes up load, the same bridges rest at another
reading, ``ẑ = C z``: of a leg with such a cause hanging no longer knows the zero.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.core.diagnosis.answer import Cause
from footcal_cli.core.diagnosis.library import Library
from footcal_cli.core.effects.contract import Effect, Trait
from footcal_cli.core.inference.case import Case
from footcal_cli.core.inference.evidence import Interval, sign_flip_max_t
from footcal_cli.core.inference.grams import whitened_grams
from footcal_cli.core.inference.linear import left_by
from footcal_cli.core.inference.problem import Problem, Signature
from footcal_cli.core.inference.scores import held_out_loss, scores
from footcal_cli.core.inference.signatures import calibration_columns
from footcal_cli.core.parameters import FloatArray, Parameter, ParameterSet

_RCOND, _NOTHING = 1e-9, 1e-6


def changed(table: Mapping[str, Effect], causes: Sequence[Cause]) -> list[str]:
    """Who has a cause of its own that changes its zero; what all have alike is no change of one."""
    owners = (_changed_by(table, cause.signature) for cause in causes)
    return list(dict.fromkeys(owner for owner in owners if owner is not None))


def _changed_by(table: Mapping[str, Effect], signature: Signature) -> str | None:
    """Whose zero a candidate changes, None where nobody's alone."""
    return _alone_in(signature) if Trait.ZERO_TOO in table[signature.effect].traits else None


def _shown_by(table: Mapping[str, Effect], signature: Signature) -> str | None:
    """Whose zero a candidate changes, or has a constant part of its own next to, None elsewhere."""
    if any(p.beside for p in table[signature.effect].sizes):
        return _alone_in(signature)
    return _changed_by(table, signature)


def _alone_in(signature: Signature) -> str | None:
    """The owner of a candidate with one size for one sensor, None of all others."""
    if len(signature.owners) != 1:
        return None
    owner, members = signature.owners[0]
    return owner if len(members) == 1 else None


def known_zeros(case: Case) -> list[str]:
    """Owners of what was known of the calibration before these logs."""
    return list(dict.fromkeys(p.name.rsplit(".", 1)[0] for p in _known(case)))


def zero_columns(case: Case, rows: Problem, owner: str) -> FloatArray:
    """What the known calibration of an owner does to the residual, free, shape (m, z)."""
    mine = ParameterSet(tuple(p for p in _known(case) if p.name.rsplit(".", 1)[0] == owner))
    return calibration_columns(replace(case, calibration=mine), rows)[0]


def is_zero(rows: Problem, zero: FloatArray, signature: Signature) -> bool:
    """Whether a candidate changes nothing but the zero, whose columns are (m, z)."""
    if signature not in rows.signatures:
        return False
    column = rows.columns[:, rows.signatures.index(signature)]
    left = left_by(zero, column[:, None], _RCOND)[:, 0]
    return float(left @ left) <= _NOTHING * float(column @ column)


def _known(case: Case) -> list[Parameter]:
    if case.known is None or case.drifts:
        return []
    sure = np.diagonal(case.known) > 0.0
    return [p for p, known in zip(case.calibration, sure, strict=True) if known]


def with_their_zeros(
    lib: Library,
    zeros: Mapping[str, FloatArray],
    table: Mapping[str, Effect],
    signs: FloatArray,
    level: float,
) -> Iterator[tuple[Signature, Interval, float]]:
    """Causes that surely explain something beside a free zero of their owner, as they do that.

    Parameters
    ----------
    lib
        Candidates.
    zeros
        Of each owner, from `zero_columns`.
    table
        Effects by name.
    signs
        Sign patterns of the blocks.
    level
        Of being something, for each owner's family.

    Yields
    ------
    signature, size, gain
        Of each effect and owner the shape that explains most, its size, and the held-out squared
        error that it removes together with the zero.
    """
    kin: dict[str, list[int]] = {}
    for k, signature in enumerate(lib.problem.signatures):
        owner = _shown_by(table, signature)
        if owner is not None and owner in zeros:
            kin.setdefault(owner, []).append(k)
    if not kin:
        return
    grams, _ = whitened_grams(lib.problem, np.hstack([zeros[owner] for owner in kin]))
    ends = np.cumsum([zeros[owner].shape[1] for owner in kin])[:-1]
    start = float(held_out_loss(grams.inner, grams.calibration).sum())
    for mine, zero in zip(kin.values(), np.split(grams.features, ends), strict=True):
        base = np.concatenate([grams.calibration, zero])
        found = scores(grams.inner, base, grams.candidates[mine])
        p = sign_flip_max_t(found.score, signs).p
        explained = np.sum(found.score, axis=0) ** 2 / np.maximum(
            np.sum(found.information, axis=0), np.finfo(float).tiny
        )
        names = [lib.problem.signatures[k].effect for k in mine]
        for effect in dict.fromkeys(names):
            best = max((i for i, n in enumerate(names) if n == effect), key=lambda i: explained[i])
            if p[best] >= level:
                continue
            whole = np.append(base, grams.candidates[mine[best]])
            size = float(found.size[best])
            signature = lib.problem.signatures[mine[best]]
            gain = start - float(held_out_loss(grams.inner, whole).sum())
            yield signature, Interval(size, size, size), gain
