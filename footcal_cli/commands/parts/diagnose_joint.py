"""Several experiments as one diagnosis: each by itself first, then all together."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from footcal_cli.commands.diagnose import DiagnoseOptions
    from footcal_cli.commands.parts.diagnose_cases import CaseRead
    from footcal_cli.commands.parts.diagnose_groups import Group
    from footcal_cli.core.diagnosis.joint import JointDiagnosis
    from footcal_cli.core.diagnosis.joint_hypotheses import JointSize
    from footcal_cli.core.diagnosis.joint_sizes import SingleDiagnosis
    from footcal_cli.core.diagnosis.rules import Rules
    from footcal_cli.core.effects.contract import Effect
    from footcal_cli.records.results import ParameterRecord, ParametersRecord, RmseRecord
    from footcal_cli.session.session import Outcome, Session


def diagnosed_together(
    session: Session[DiagnoseOptions], groups: Sequence[Group], table: Mapping[str, Effect]
) -> Outcome:
    """One verdict on several experiments."""
    from footcal_cli.core.diagnosis.joint import diagnose_together
    from footcal_cli.core.diagnosis.rules import Rules
    from footcal_cli.records.results import FindingRecord
    from footcal_cli.report import Report
    from footcal_cli.session.session import Outcome
    from footcal_cli.sheets.diagnosis.joint import (
        experiment_sheet,
        joint_record,
        joint_verdict,
        size_sheet,
        unseen_sheet,
    )

    rules = Rules(most_effects=session.options.most_effects)
    reads: list[CaseRead] = []
    singles: list[SingleDiagnosis] = []
    for group in session.progress(groups, "diagnose", len(groups)):
        read, single = _single(session, group, table, rules)
        reads.append(read)
        singles.append(single)
    with session.step("together"):
        joint = diagnose_together(singles, table)
    findings = [
        FindingRecord.of(f).model_copy(update={"where": f"{one.name}: {f.where}"})
        for one, read in zip(singles, reads, strict=True)
        for f in read.findings
    ]
    record = joint_record(joint, table, findings, rules, session.request.seed)
    kinds = " + ".join(one.name for one in singles)
    return Outcome(
        usable=record.verdict != "bad-data",
        diagnosis=record.verdict,
        report=Report(
            title=f"Diagnosis of {session.recipe.robot.name}: {kinds}",
            verdict=joint_verdict(joint, table),
            lead_sheets=(size_sheet(joint), experiment_sheet(joint)),
            sheets=(unseen_sheet(joint),),
            findings=tuple(findings),
            footer=(
                "Each experiment by itself: footcal diagnose with its logs alone "
                f"({'; '.join(_alone(session, group) for group in groups)}).",
                rules.sentence(),
            ),
        ),
        rmse=_rmse(singles),
        records={
            "diagnosis.json": record,
            "parameters_extended.json": _extended(session, joint, reads, table),
        },
    )


def _single(
    session: Session[DiagnoseOptions],
    group: Group,
    table: Mapping[str, Effect],
    rules: Rules,
) -> tuple[CaseRead, SingleDiagnosis]:
    """The diagnosis of one experiment by itself."""
    from footcal_cli.commands.parts.diagnose_cases import read_case
    from footcal_cli.core.diagnosis.investigation import investigate
    from footcal_cli.core.diagnosis.joint_sizes import SingleDiagnosis
    from footcal_cli.core.diagnosis.signals import describe
    from footcal_cli.core.quality import stopping

    options = session.options.model_copy(update={"experiment": group.kind})
    part = session.part(group.logs, group.parameters, options)
    with session.step(f"read {group.name}"):
        read = read_case(part)
        if not group.whole_folder:
            part.refuse_unread()
        read.findings.extend(part.noted)
    usable = {k: v for k, v in table.items() if k not in read.untested}
    with session.step(f"diagnose {group.name}"):
        found = investigate(
            read.case, usable, describe, rules, session.request.seed,
            stopped=bool(stopping(read.findings)),
        )  # fmt: skip
    return read, SingleDiagnosis(group.name, found, read.untested)


def _alone(session: Session[DiagnoseOptions], group: Group) -> str:
    import shlex

    words = [path.as_posix() for path in group.logs] + ["--experiment", group.kind]
    parameters = group.parameters or session.request.parameters
    if parameters is not None:
        words += ["--parameters", parameters.as_posix()]
    return shlex.join(words)


def _rmse(singles: Sequence[SingleDiagnosis]) -> RmseRecord:
    """Held-out errors of every experiment, with its own names in the model."""
    from footcal_cli.commands.parts.diagnose_outcome import rmse_of
    from footcal_cli.records.results import RmseRecord

    rows = [
        row.model_copy(update={"quantity": f"{single.name}: {row.quantity}"})
        for single in singles
        for row in rmse_of(single.found).rows
    ]
    return RmseRecord(rows=tuple(rows))


def _extended(
    session: Session[DiagnoseOptions],
    joint: JointDiagnosis,
    reads: Sequence[CaseRead],
    table: Mapping[str, Effect],
) -> ParametersRecord:
    """The calibration with the causes that all experiments agree on, at their common sizes."""
    from footcal_cli.commands.parts.calibration_record import CELLS, Conventions, calibration_record
    from footcal_cli.core.parameters import Status
    from footcal_cli.records.effects import record_of_effect
    from footcal_cli.records.results import ParameterRecord

    given = session.parameters
    parameters = dict(given.parameters) if given is not None else {}
    # a calibration that drifts is that of its recording; a constant one of an earlier experiment
    # is not changed by a later one
    for read in sorted(reads, key=lambda read: read.case.drifts):
        for p in read.case.calibration:
            if p.name not in parameters:
                value = read.case.values.get(p.name, p.value)
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
    conventions = CELLS
    if given is not None:
        conventions = Conventions(given.sign_convention, given.frame, given.expressed_at)
    return calibration_record(
        session, conventions, parameters,
        covariance=given.covariance if given is not None else (),
        fitted_range=given.fitted_range if given is not None else {},
        effects=effects,
    )  # fmt: skip


def _owners(item: JointSize) -> list[str]:
    """A name for each group: its only unit, or ``all``."""
    return [min(g) if len(g) == 1 else item.cause.owner_of(g) for g in item.cause.groups]


def _values(item: JointSize, number: int, owner: str, effect: Effect) -> dict[str, ParameterRecord]:
    from footcal_cli.core.parameters import Status
    from footcal_cli.records.results import ParameterRecord

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
