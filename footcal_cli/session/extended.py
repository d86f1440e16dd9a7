"""The calibration that a diagnosis leaves: the one given, with what was named put in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from footcal_cli.core.diagnosis.investigation import Investigation
from footcal_cli.core.diagnosis.joint import JointDiagnosis
from footcal_cli.core.diagnosis.joint_hypotheses import JointSize
from footcal_cli.core.diagnosis.movement import Movement
from footcal_cli.core.effects.contract import Effect
from footcal_cli.core.inference.case import Case
from footcal_cli.core.parameters import Status
from footcal_cli.records.effects import record_of_effect
from footcal_cli.records.results import ParameterRecord, ParametersRecord
from footcal_cli.session.calibration import CELLS, Conventions, calibration_record
from footcal_cli.session.session import Session


def _conventions(given: ParametersRecord | None) -> Conventions:
    if given is None:
        return CELLS
    return Conventions(given.sign_convention, given.frame, given.expressed_at)


def extended(
    session: Session[Any],
    given: ParametersRecord | None,
    case: Case,
    found: Investigation,
    moved: Sequence[Movement],
    before: Mapping[str, ParameterRecord],
) -> ParametersRecord:
    """The calibration with the named effects in it; `before` stands before the case's channels."""
    parameters = {**before, **(given.parameters if given is not None else {})}
    after = {m.name: (m.after, m.sd) for m in moved}
    for parameter in case.calibration:
        value, sd = after.get(
            parameter.name, (case.values.get(parameter.name, parameter.value), None)
        )
        if parameter.name in after or parameter.name not in parameters:
            parameters[parameter.name] = ParameterRecord(
                value=value, sd=sd, unit=parameter.unit, status=Status.ESTIMATED
            )
    effects = list(given.effects) if given is not None else []
    if found.model is not None:
        units = {
            f"{owner}.{p.name}": p.unit
            for link in found.model.chain.links
            for owner in link.owners
            for p in link.effect.parameters
        }
        sd_of = {
            name: (interval.high - interval.low) / 4.0
            for name, interval in zip(found.model.names, found.model.intervals, strict=True)
        }
        for item in found.found:
            signature = item.cause.signature
            effects.append(
                record_of_effect(item.effect, dict(signature.owners), session.recipe.effect)
            )
        for name, unit in units.items():
            if name in found.model.values and name not in parameters:
                parameters[name] = ParameterRecord(
                    value=float(found.model.values[name]),
                    sd=sd_of.get(name),
                    unit=unit,
                    status=Status.ESTIMATED if name in sd_of else Status.FIXED,
                )
    return calibration_record(
        session,
        _conventions(given),
        parameters,
        covariance=given.covariance if given is not None and not moved else (),
        fitted_range=given.fitted_range if given is not None else {},
        effects=effects,
    )


def extended_together(
    session: Session[Any], joint: JointDiagnosis, cases: Sequence[Case], table: Mapping[str, Effect]
) -> ParametersRecord:
    """The calibration with the causes that all experiments agree on, at their common sizes."""
    given = session.parameters
    parameters = dict(given.parameters) if given is not None else {}
    # a calibration that drifts is that of its recording; a constant one of an earlier experiment
    # is not changed by a later one
    for case in sorted(cases, key=lambda case: case.drifts):
        for p in case.calibration:
            if p.name not in parameters:
                value = case.values.get(p.name, p.value)
                parameters[p.name] = ParameterRecord(
                    value=value, sd=None, unit=p.unit, status=Status.ESTIMATED
                )
    effects = list(given.effects) if given is not None else []
    for item in joint.causes if joint.agreed else ():
        owners = {
            owner: tuple(sorted(group))
            for owner, group in zip(_owners(item), item.cause.groups, strict=True)
        }
        effects.append(record_of_effect(table[item.cause.effect], owners, session.recipe.effect))
        for number, owner in enumerate(owners):
            parameters |= _values(item, number, owner, table[item.cause.effect])
    return calibration_record(
        session, _conventions(given), parameters,
        covariance=given.covariance if given is not None else (),
        fitted_range=given.fitted_range if given is not None else {},
        effects=effects,
    )  # fmt: skip


def _owners(item: JointSize) -> list[str]:
    """A name for each group: its only unit, or ``all``."""
    return [min(g) if len(g) == 1 else item.cause.owner_of(g) for g in item.cause.groups]


def _values(item: JointSize, number: int, owner: str, effect: Effect) -> dict[str, ParameterRecord]:
    interval, shape = item.size[number], dict(item.shape)
    found = {}
    for p in effect.parameters:
        value, sd, status = shape.get(p.name, p.neutral), None, Status.FIXED
        if p.name == item.cause.parameter:
            value = p.neutral + interval.value
            sd, status = (interval.high - interval.low) / 4.0, Status.ESTIMATED
        found[f"{owner}.{p.name}"] = ParameterRecord(
            value=float(value), sd=sd, unit=p.unit, status=status
        )
    return found
