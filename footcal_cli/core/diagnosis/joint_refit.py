"""Sizes of the causes of a joint diagnosis, from a full refit of each experiment.

Signatures are derivatives: good enough to compare causes, off by some per cent of a size that is
stated.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from footcal_cli.core.diagnosis.answer import Cause
from footcal_cli.core.diagnosis.joint_sizes import JointCause, SingleDiagnosis, SizeSeen
from footcal_cli.core.diagnosis.signals import describe
from footcal_cli.core.diagnosis.subject import Subject
from footcal_cli.core.effects.contract import Effect
from footcal_cli.core.inference.evidence import Interval
from footcal_cli.core.inference.problem import Signature

_SDS = 4.0  # in a 95 % interval


@dataclass(frozen=True)
class RefittedCause:
    """A cause in one experiment after the refit of all that it sees.

    Parameters
    ----------
    sizes
        Of each group; None where it does not act here.
    shape
        Values of the shape parameters, fitted or held, of the group that is surest.
    """

    sizes: tuple[SizeSeen | None, ...]
    shape: Mapping[str, float]


def refitted_together(
    single: SingleDiagnosis,
    causes: Sequence[JointCause],
    linear: Mapping[JointCause, tuple[SizeSeen | None, ...]],
    table: Mapping[str, Effect],
) -> dict[JointCause, RefittedCause]:
    """Causes that one experiment sees, refitted together.

    Parameters
    ----------
    single
        The experiment.
    causes
        Those to be put into its model.
    linear
        Their sizes by their signatures, to start from.
    table
        Effects by name.
    """
    found = single.found
    subject = Subject(found.case, found.problem, table, describe)
    accepted, start = [], {}
    for cause in causes:
        signature, groups = _here(single, cause)
        effect = table[cause.effect]
        size = next(p for p in effect.sizes if p.name == cause.parameter)
        shape = dict(signature.shape)
        for (owner, _), g in zip(signature.owners, groups, strict=True):
            known = linear[cause][g]
            for p in effect.parameters:
                value = shape.get(p.name, p.neutral)
                if p is size and known is not None:
                    most = max(3.0 * p.prior_sd, *np.abs(p.far), 0.0)
                    inside = float(np.clip(known.size, -most, most))
                    value = float(np.clip(p.neutral + inside, p.lower, p.upper))
                start[f"{owner}.{p.name}"] = value
        accepted.append((cause, signature, groups))
    nothing = Interval(0.0, 0.0, 0.0)
    model = subject.refitted(
        [Cause(s, nothing, 1.0, nothing, 0, 0.0, (), ()) for _, s, _ in accepted], start
    )
    out = {}
    for cause, signature, groups in accepted:
        effect = table[cause.effect]
        size = next(p for p in effect.sizes if p.name == cause.parameter)
        sizes: list[SizeSeen | None] = [None] * len(cause.groups)
        shapes: dict[int, dict[str, float]] = {}
        for (owner, _), g in zip(signature.owners, groups, strict=True):
            name, known = f"{owner}.{size.name}", linear[cause][g]
            if name not in model.names or known is None:
                continue
            interval = model.intervals[model.names.index(name)]
            sd = (interval.high - interval.low) / _SDS
            sizes[g] = SizeSeen(interval.value - size.neutral, sd, known.freedom)
            shapes[g] = {p.name: model.values[f"{owner}.{p.name}"] for p in effect.shapes}
        sure = {g: one.sureness for g, one in enumerate(sizes) if one is not None}
        shape = shapes[max(sure, key=lambda g: sure[g])] if sure else {}
        out[cause] = RefittedCause(tuple(sizes), shape)
    return out


def _here(single: SingleDiagnosis, cause: JointCause) -> tuple[Signature, list[int]]:
    """The signature of a cause in one experiment, and which of its groups it has there."""
    signatures = single.found.problem.signatures
    columns = single.columns(cause)
    groups = [g for g, column in enumerate(columns) if column >= 0]
    first = signatures[columns[groups[0]]]
    owners = tuple(owner for g in groups for owner in signatures[columns[g]].owners)
    where = first.where if len(groups) == 1 else cause.where
    signature = Signature(
        first.effect, first.parameter, where, first.unit, first.shape, first.lower, first.upper,
        owners,
    )  # fmt: skip
    return signature, groups
