"""Parts of a bench calibration put together: one report, parameters.json, what has changed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pandas as pd

    from footcal_cli.commands.offline_fit import OfflineFitOptions
    from footcal_cli.commands.parts.bench_report import Part
    from footcal_cli.core.bench.changes import Change
    from footcal_cli.core.bench.cop_study import FootStudy
    from footcal_cli.core.bench.study import ChannelStudy
    from footcal_cli.core.parameters import Estimates
    from footcal_cli.records.results import CopCorrectionsRecord, ParametersRecord, VerdictRecord
    from footcal_cli.session.session import Outcome, Session


def outcome_of(
    session: Session[OfflineFitOptions],
    parts: Sequence[Part],
    studies: Sequence[ChannelStudy],
    estimates: Sequence[Estimates],
    feet: Sequence[FootStudy],
    gates_missed: tuple[str, ...],
) -> Outcome:
    """One run folder of all parts."""
    from functools import partial

    from footcal_cli.records.results import FindingRecord, RmseRecord
    from footcal_cli.report import Report
    from footcal_cli.session.session import Outcome
    from footcal_cli.sheets.ladder import change_sheet

    changes, since = _changes(session, estimates, feet)
    # placements are what weights are for: they come first
    ordered = list(reversed(parts))
    lead = [part.sheets[0] for part in ordered if part.sheets]
    if changes:
        lead.append(change_sheet(changes, since))
    rejected: dict[str, int] = {}
    for part in parts:
        rejected |= part.rejected
    corrections = _corrections(feet)
    return Outcome(
        report=Report(
            title=f"Offline calibration of {session.recipe.robot.name}",
            verdict=_verdict(ordered, changes, since),
            pictures=tuple(picture for part in ordered for picture in part.pictures),
            lead_sheets=tuple(lead),
            sheets=tuple(sheet for part in ordered for sheet in part.sheets[1:]),
            findings=tuple(FindingRecord.of(f) for part in parts for f in part.findings),
            footer=tuple(line for part in parts for line in part.footer),
        ),
        rmse=RmseRecord(rows=tuple(r for part in parts for r in part.rows), rejected=rejected),
        parameters=_parameters(session, studies, estimates, feet),
        records={} if corrections is None else {"cop_correction.json": corrections},
        files={
            name: partial(_write_frame, frame)
            for part in parts
            for name, frame in part.files.items()
        },
        gates_missed=gates_missed,
    )


def _write_frame(frame: pd.DataFrame, path: Path) -> None:
    from footcal_cli.tables.table import write_parquet

    write_parquet(frame, path)


def _verdict(parts: Sequence[Part], changes: Sequence[Change], since: str) -> VerdictRecord:
    """The first part's sentence, the other parts as details, then what changed."""
    from footcal_cli.records.results import VerdictRecord
    from footcal_cli.sheets.ladder import NOTABLE_P

    ordered = [part.verdict for part in parts]
    order = ("good", "warning", "bad")
    level = max((verdict.level for verdict in ordered), key=order.index)
    details = list(ordered[0].details)
    for verdict in ordered[1:]:
        details += [verdict.sentence, *verdict.details]
    notable = [change for change in changes if change.p_value < NOTABLE_P]
    if notable:
        details.append("Changed: " + "; ".join(c.sentence(since) for c in notable[:6]) + ".")
    elif changes:
        details.append(f"Nothing changed since {since} beyond what chance explains.")
    return VerdictRecord(level=level, sentence=ordered[0].sentence, details=tuple(details))


def _changes(
    session: Session[OfflineFitOptions],
    estimates: Sequence[Estimates],
    feet: Sequence[FootStudy],
) -> tuple[tuple[Change, ...], str]:
    """Parameters against those of --parameters, with the date of the earlier calibration."""
    from footcal_cli.core.bench.changes import Earlier, find_changes

    before = session.parameters
    if before is None:
        return (), ""
    known = {
        name: Earlier(p.value, p.sd, p.unit)
        for name, p in before.parameters.items()
        if p.sd is not None and p.sd > 0
    }
    groups = list(estimates)
    groups += [e for found in feet if (e := found.estimates) is not None]
    found = [change for group in groups for change in find_changes(group, known)]
    found.sort(key=lambda change: change.p_value)
    return tuple(found), before.created[:10]


def _corrections(feet: Sequence[FootStudy]) -> CopCorrectionsRecord | None:
    """The best polynomial of every foot, as [NAO] has it."""
    from footcal_cli.records.results import CopCorrectionRecord, CopCorrectionsRecord

    found = {}
    for foot in feet:
        at = foot.study.empirical
        if at is None or foot.study.results[at].name == "none":
            continue
        result = foot.study.results[at]
        coefficients = result.fit.coefficients()
        found[foot.foot] = CopCorrectionRecord(
            model=result.name,
            terms=result.fit.model.terms(foot.rows.cells),
            coefficients_x=tuple(float(c) for c in coefficients[:, 0]),
            coefficients_y=tuple(float(c) for c in coefficients[:, 1]),
            ridge=result.fit.ridge,
            left_out_rmse_m=result.left_out.rmse,
            placements=result.groups,
            chosen=result is foot.study.chosen,
        )
    return CopCorrectionsRecord(feet=found) if found else None


def _parameters(
    session: Session[OfflineFitOptions],
    studies: Sequence[ChannelStudy],
    estimates: Sequence[Estimates],
    feet: Sequence[FootStudy],
) -> ParametersRecord | None:
    """Channels and, where physics was chosen, the corrections of cells by their placements."""
    from footcal_cli.commands.parts.calibration_record import CELLS, calibration_record
    from footcal_cli.records.results import (
        EffectRecord,
        ParameterRecord,
        Range,
        covariance_blocks,
        parameter_records,
    )
    from footcal_cli.sheets.ladder import effect_records, fitted_ranges

    parameters: dict[str, ParameterRecord] = {}
    ranges: dict[str, dict[str, Range]] = {}
    earlier = session.parameters
    effects = list(effect_records(studies))
    if not estimates and earlier is not None:
        parameters |= earlier.parameters
        ranges |= earlier.fitted_range
        effects += list(earlier.effects)
    for group in estimates:
        parameters |= parameter_records(group)
    for study in studies:
        ranges[study.channel] = fitted_ranges(study)
    groups = list(estimates)
    for found in feet:
        if found.estimates is None:
            continue
        parameters |= parameter_records(found.estimates)
        groups.append(found.estimates)
        for channel, change in found.bias_changes().items():
            name = f"{channel}.bias"
            old = parameters[name]
            parameters[name] = old.model_copy(update={"value": old.value + change})
        for effect in found.effects():
            owners: dict[str, tuple[str, ...]] = {c: (c,) for c in found.rows.cells}
            effects.append(EffectRecord(effect=effect, owners=owners))
    if not parameters:
        return None
    return calibration_record(
        session,
        replace(CELLS, frame=f"{CELLS.frame}; positions in the foot frame"),
        parameters,
        covariance=covariance_blocks(*groups),
        fitted_range=ranges,
        effects=effects,
    )
