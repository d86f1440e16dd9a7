"""What ``diagnose`` says of several experiments together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from footcal_cli.core.diagnosis.joint import JointDiagnosis
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.effects.contract import Effect
from footcal_cli.intake.cases.shared import CaseRead
from footcal_cli.records.results import FindingRecord, RmseRecord
from footcal_cli.report import Report
from footcal_cli.report.outcome import Outcome
from footcal_cli.sheets.diagnosis.joint import (
    experiment_sheet,
    joint_record,
    joint_verdict,
    size_sheet,
    unseen_sheet,
)
from footcal_cli.sheets.diagnosis.report import rmse_of


def joint_outcome(
    title: str,
    joint: JointDiagnosis,
    reads: Sequence[CaseRead],
    table: Mapping[str, Effect],
    rules: Rules,
    seed: int,
    alone: Sequence[str],
) -> Outcome:
    """One verdict on several experiments; `alone` are the options that diagnose each by itself."""
    singles = joint.singles
    findings = [
        FindingRecord.of(f).model_copy(update={"where": f"{one.name}: {f.where}"})
        for one, read in zip(singles, reads, strict=True)
        for f in read.findings
    ]
    record = joint_record(joint, table, findings, rules, seed)
    rows = tuple(
        row.model_copy(update={"quantity": f"{one.name}: {row.quantity}"})
        for one in singles
        for row in rmse_of(one.found).rows
    )
    return Outcome(
        usable=record.verdict != "bad-data",
        diagnosis=record.verdict,
        report=Report(
            title=f"{title}: {' + '.join(one.name for one in singles)}",
            verdict=joint_verdict(joint, table),
            lead_sheets=(size_sheet(joint), experiment_sheet(joint)),
            sheets=(unseen_sheet(joint),),
            findings=tuple(findings),
            footer=(
                "Each experiment by itself: footcal diagnose with its logs alone "
                f"({'; '.join(alone)}).",
                rules.sentence(),
            ),
        ),
        rmse=RmseRecord(rows=rows),
        records={"diagnosis.json": record},
    )
