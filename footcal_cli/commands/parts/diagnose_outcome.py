"""What ``diagnose`` writes: report, records, the extended calibration."""

from __future__ import annotations

import shlex
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping

    from footcal_cli.commands.diagnose import DiagnoseOptions
    from footcal_cli.commands.parts.diagnose_cases import CaseRead
    from footcal_cli.core.diagnosis.investigation import Investigation
    from footcal_cli.core.diagnosis.menu import Menu
    from footcal_cli.core.diagnosis.movement import Movement
    from footcal_cli.core.diagnosis.rules import Rules
    from footcal_cli.core.effects.contract import Effect
    from footcal_cli.records.diagnosis import DiagnosisRecord
    from footcal_cli.records.results import ParametersRecord, RmseRecord
    from footcal_cli.report import Picture
    from footcal_cli.session.session import Outcome, Session


def outcome_of(
    session: Session[DiagnoseOptions],
    read: CaseRead,
    found: Investigation,
    table: Mapping[str, Effect],
    rules: Rules,
) -> Outcome:
    """An investigation as everything that people and programs read of it."""
    from dataclasses import replace

    from footcal_cli.commands.parts.diagnose_alone import found_alone, undecided
    from footcal_cli.core.diagnosis.answer import Verdict
    from footcal_cli.core.diagnosis.movement import movements
    from footcal_cli.records.results import FindingRecord
    from footcal_cli.report import Report
    from footcal_cli.session.session import Outcome
    from footcal_cli.sheets.diagnosis.answer import answer_of
    from footcal_cli.sheets.diagnosis.evidence import evidence_sheet, untested_sheet
    from footcal_cli.sheets.diagnosis.experiment import menu_sheets
    from footcal_cli.sheets.diagnosis.followed import (
        after,
        followed_records,
        followed_words,
        left_over,
        suspect_records,
    )
    from footcal_cli.sheets.diagnosis.gains import gain_sheets, method_note, movement_sheets
    from footcal_cli.sheets.diagnosis.record import record_of
    from footcal_cli.sheets.diagnosis.unknown import card_sheets

    seed = session.request.seed
    alone = found_alone(read, found)
    if alone:
        found = replace(found, verdict=Verdict.UNDERPOWERED)
    with session.step("plan"):
        moved = movements(read.case, found.problem, found.final)
        answer = answer_of(found, table, read.findings, read.untested)
        if alone:
            answer = undecided(answer, found, alone)
        if found.model is not None:
            answer = answer.ending_with(_where_it_lies(session))
        became = after(found, _before(session), table)
        left = left_over(found, became)
        if became:
            answer = answer.with_detail(followed_words(became, left))
    pictures = _pictures(found, table, moved, answer.menu, seed)
    record = record_of(found, answer, read, rules, seed)
    return Outcome(
        usable=record.verdict != "bad-data",
        diagnosis=record.verdict,
        report=Report(
            title=f"Diagnosis of {session.recipe.robot.name}: {read.case.experiment.name}",
            verdict=answer.verdict,
            pictures=pictures,
            lead_sheets=(
                evidence_sheet(found, read.untested),
                *card_sheets(found, answer.menu),
                *menu_sheets(answer.menu),
            ),
            sheets=(
                *gain_sheets(found),
                *movement_sheets(moved),
                untested_sheet(found, read.untested),
            ),
            findings=tuple(FindingRecord.of(f) for f in read.findings),
            footer=(
                f"To reproduce: {command_line(session)}",
                rules.sentence(),
                method_note(found, seed),
            ),
        ),
        rmse=rmse_of(found),
        records={
            "diagnosis.json": record.model_copy(
                update={
                    "suspects": suspect_records(found, table),
                    "after": followed_records(became),
                    "survivors": left,
                }
            ),
            "parameters_extended.json": _extended(session, found, moved, read),
        },
    )


def _where_it_lies(session: Session[DiagnoseOptions]) -> str:
    path = session.request.out / "parameters_extended.json"
    return (
        f"The calibration with it: {path.as_posix()}; every command starts from it (--parameters)."
    )


def _before(session: Session[DiagnoseOptions]) -> DiagnosisRecord | None:
    """The diagnosis of the log before."""
    from footcal_cli.records.diagnosis import DiagnosisRecord
    from footcal_cli.records.files import read_record

    path = session.options.after
    return None if path is None else read_record(DiagnosisRecord, path)


def command_line(session: Session[DiagnoseOptions]) -> str:
    """The command that gives this report again."""
    request = session.request
    words = ["footcal", request.command, *(path.as_posix() for path in request.logs)]
    if request.recipe is not None:
        words += ["--recipe", request.recipe.as_posix()]
    if request.parameters is not None:
        words += ["--parameters", request.parameters.as_posix()]
    for name, value in request.overrides.items():
        option = f"--{name.replace('_', '-')}"
        if value is None:
            continue
        if value is False:
            words.append(f"--no-{name}")
        elif isinstance(value, tuple):
            words += [part for item in value for part in (option, str(item))]
        else:
            words += [option, str(value)]
    words += ["--seed", str(request.seed), "--out", request.out.as_posix()]
    return shlex.join(words)


def _pictures(
    found: Investigation,
    table: Mapping[str, Effect],
    moved: tuple[Movement, ...],
    menu: Menu | None,
    seed: int,
) -> tuple[Picture, ...]:
    from footcal_cli.plots.diagnosis import (
        gains,
        isolability,
        ladder,
        line_up,
        movement,
        null,
        residuals,
    )
    from footcal_cli.report import Picture

    drawn = [
        Picture(
            "residual_against_driver",
            lambda: residuals.plot_driver(found),
            residuals.DRIVER_CAPTION,
            title="Residual before and after the identified effect",
        ),
        Picture(
            "line_up",
            lambda: line_up.plot_line_up(found, seed),
            line_up.LINE_UP_CAPTION,
            title="The data among nineteen random panels",
        ),
        Picture(
            "gain_per_block",
            lambda: gains.plot_gains(found),
            gains.GAINS_CAPTION,
            title="Error of each held-out block before and after",
        ),
        Picture(
            "ladder",
            lambda: ladder.plot_ladder(found),
            ladder.LADDER_CAPTION,
            title="Held-out error of each model",
        ),
        Picture(
            "isolability",
            lambda: isolability.plot_isolability(found, table, menu),
            isolability.caption(menu),
            title="Which effects look alike",
        ),
    ]
    if moved and found.found:
        drawn.append(
            Picture(
                "movement",
                lambda: movement.plot_movement(moved),
                movement.MOVEMENT_CAPTION,
                title="Change of each calibration parameter",
            )
        )
    drawn.append(
        Picture(
            "null_gallery",
            lambda: null.plot_null(found),
            null.NULL_CAPTION,
            title="Largest statistic of the data and by chance",
        )
    )
    return tuple(drawn)


def rmse_of(found: Investigation) -> RmseRecord:
    """Held-out errors of the baseline and of the extended model, per output."""
    from footcal_cli.records.results import RmseRecord, RmseRow

    rows = []
    for gain in found.gains:
        n = int((found.problem.output == found.problem.outputs.index(gain.output)).sum())
        for stage, value in (("before", gain.before), ("after", gain.after)):
            rows.append(
                RmseRow(
                    quantity=gain.output, unit=gain.unit, stage=stage, reference="the balance",
                    split="held_out", rmse=value, n=n,
                )
            )  # fmt: skip
    return RmseRecord(rows=tuple(rows))


def _extended(
    session: Session[DiagnoseOptions],
    found: Investigation,
    moved: tuple[Movement, ...],
    read: CaseRead,
) -> ParametersRecord:
    """The calibration with the named effects in it."""
    from footcal_cli.commands.parts.calibration_record import CELLS, Conventions, calibration_record
    from footcal_cli.commands.parts.diagnose_cases import baseline_of
    from footcal_cli.core.parameters import Status
    from footcal_cli.records.effects import record_of_effect
    from footcal_cli.records.results import ParameterRecord

    given = baseline_of(session)
    parameters = dict(given.parameters) if given is not None else {}
    after = {m.name: (m.after, m.sd) for m in moved}
    for parameter in read.case.calibration:
        value, sd = after.get(
            parameter.name, (read.case.values.get(parameter.name, parameter.value), None)
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
    conventions = CELLS
    if given is not None:
        conventions = Conventions(given.sign_convention, given.frame, given.expressed_at)
    return calibration_record(
        session,
        conventions,
        parameters,
        covariance=given.covariance if given is not None and not moved else (),
        fitted_range=given.fitted_range if given is not None else {},
        effects=effects,
    )
