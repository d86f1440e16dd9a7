"""``footcal diagnose``: what the simulation gets wrong, named, sized and proved, or not."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from footcal_cli.commands.options import Given, command
from footcal_cli.recipe.options import DiagnoseOptions

if TYPE_CHECKING:
    from collections.abc import Sequence

    from footcal_cli.core.diagnosis.investigation import Investigation
    from footcal_cli.core.diagnosis.rules import Rules
    from footcal_cli.core.effects.contract import Effect
    from footcal_cli.intake.cases.shared import CaseRead
    from footcal_cli.intake.groups import Group
    from footcal_cli.report.outcome import Outcome
    from footcal_cli.session.session import Session

_EXTRA: dict[str, Any] = {
    "explain": Annotated[
        str | None, typer.Option("--explain", metavar="EFFECT", help="Describe an effect and exit.")
    ],
    "plan": Annotated[
        bool | None,
        typer.Option("--plan", help="Only the next experiment; LOG is a diagnosis.json, or none."),
    ],
}


def _opening(given: Given) -> None:
    """Explain and stop; else a single folder becomes its logs, kind and calibration."""
    from footcal_cli.intake.groups import groups_of

    if given["explain"] is not None:
        from footcal_cli.core.effects import TABLE
        from footcal_cli.records.effects import known_effect
        from footcal_cli.sheets.effects import explained

        typer.echo(explained(known_effect(given["explain"], TABLE)))
        raise typer.Exit
    groups = groups_of(given["logs"] or ())
    given["groups"] = groups
    if groups:
        given["logs"] = [path for group in groups for path in group.logs]
    if len(groups) == 1:
        given["experiment"] = groups[0].kind
        given["parameters"] = given["parameters"] or groups[0].parameters


@command(DiagnoseOptions, lacks=("reference",), extra=_EXTRA, opening=_opening)
def diagnose(
    session: Session[DiagnoseOptions], plan: bool | None, groups: Sequence[Group]
) -> Outcome:
    """Say what the model gets wrong: name its cause, extend the model, state the gain."""
    from footcal_cli.core.diagnosis.rules import Rules
    from footcal_cli.core.log import EXPERIMENT_NAMES
    from footcal_cli.errors import DataError

    if plan and len(groups) < 2:
        return _planned(session)
    session.refuse_missing_logs("" if len(groups) > 1 else session.options.experiment)
    rules = Rules(most_effects=session.options.most_effects)
    if len(groups) > 1:
        return _together(session, groups, rules)
    try:
        return _single(session, groups, rules)
    except DataError as error:
        if error.foreign:  # read as weights, say, and it is a walk
            read_as = session.options.experiment
            others = ", ".join(name for name in EXPERIMENT_NAMES if name != read_as)
            error.remedy = (
                f"it was read as {read_as}; say what it is by --experiment ({others}), "
                f"or {error.remedy}"
            )
        raise


def _planned(session: Session[DiagnoseOptions]) -> Outcome:
    """Only the next experiment, for a pair of effects or for a diagnosis made before."""
    from footcal_cli.core.diagnosis.menu import menu_for
    from footcal_cli.intake.planning import rig_of, rivals_of
    from footcal_cli.sheets.diagnosis.plan import plan_outcome

    table = session.table
    rivals = rivals_of(session)
    names = tuple(dict.fromkeys(r.signature.effect for r in rivals))
    with session.step("plan"):
        menu = menu_for(rivals, table, rig_of(session.recipe.robot, [table[n] for n in names]))
    return plan_outcome(menu, names, table)


def _single(session: Session[DiagnoseOptions], groups: Sequence[Group], rules: Rules) -> Outcome:
    """One experiment."""
    from dataclasses import replace

    from footcal_cli.core.diagnosis.movement import movements
    from footcal_cli.intake.cases.shared import baseline_of
    from footcal_cli.intake.cases.weights import found_alone
    from footcal_cli.records.diagnosis import DiagnosisRecord
    from footcal_cli.records.files import read_record
    from footcal_cli.session.before import begin_before
    from footcal_cli.session.extended import extended
    from footcal_cli.sheets.diagnosis.report import DiagnosisRequest, outcome_of

    request, before = session.request, session.options.after
    begin_before(session)
    # of a folder only those files are logs that are of the kind
    reader = session.part(groups[0].logs) if groups else session
    table = _table(session)
    read, found = _from_before(session, reader, table, rules)
    with session.step("plan"):
        moved = movements(read.case, found.problem, found.final)
        asked = DiagnosisRequest(
            f"Diagnosis of {session.recipe.robot.name}", read.testable(table), rules, request.seed,
            alone=found_alone(reader, read, found),
            before=None if before is None else read_record(DiagnosisRecord, before),
            reproduce=request.command_line,
        )  # fmt: skip
        outcome = outcome_of(read, found, moved, asked)
    if not outcome.usable:
        return outcome  # nothing starts from wrong readings
    record = extended(session, baseline_of(session), read.case, found, moved, read.before)
    return replace(outcome, records={**outcome.records, "parameters_extended.json": record})


def _from_before(
    session: Session[DiagnoseOptions], reader: Session[DiagnoseOptions],
    table: dict[str, Effect], rules: Rules,
) -> tuple[CaseRead, Investigation]:  # fmt: skip
    """Placements first without what `offline-fit` took out of them; with it if that has no name.

    A matrix between all cells is a calibration, and no row of the table.
    """
    from footcal_cli.core.diagnosis.verdicts import NAMING
    from footcal_cli.intake.cases.shared import chose_effects, without_chosen
    from footcal_cli.session.before import digests_of_logs

    whole, placed = reader.parameters, session.options.experiment == "placements"
    if whole is None or not (placed and chose_effects(whole, digests_of_logs(session))):
        return _investigated(session, reader, table, rules)
    reader.parameters = without_chosen(whole)
    read, found = _investigated(session, reader, table, rules)
    if found.verdict in NAMING:
        return read, found
    reader.parameters = whole
    return _investigated(session, reader, table, rules)


def _together(session: Session[DiagnoseOptions], groups: Sequence[Group], rules: Rules) -> Outcome:
    """Several experiments: each by itself first, then all together."""
    import shlex
    from dataclasses import replace

    from footcal_cli.core.diagnosis.joint import diagnose_together
    from footcal_cli.core.diagnosis.joint_sizes import SingleDiagnosis
    from footcal_cli.session.extended import extended_together
    from footcal_cli.sheets.diagnosis.joint import joint_outcome

    table, reads, singles, alone = _table(session), [], [], []
    for group in session.progress(groups, "diagnose", len(groups)):
        part = session.part(group.logs, group.parameters, experiment=group.kind)
        read, found = _investigated(session, part, table, rules, group)
        reads.append(read)
        singles.append(SingleDiagnosis(group.name, found, read.untested))
        words = [path.as_posix() for path in group.logs] + ["--experiment", group.kind]
        parameters = group.parameters or session.request.parameters
        words += [] if parameters is None else ["--parameters", parameters.as_posix()]
        alone.append(shlex.join(words))
    with session.step("together"):
        joint = diagnose_together(singles, table)
    title = f"Diagnosis of {session.recipe.robot.name}"
    outcome = joint_outcome(title, joint, reads, table, rules, session.request.seed, alone)
    record = extended_together(session, joint, [read.case for read in reads], table)
    return replace(outcome, records={**outcome.records, "parameters_extended.json": record})


def _investigated(
    session: Session[DiagnoseOptions],
    reader: Session[DiagnoseOptions],
    table: dict[str, Effect],
    rules: Rules,
    group: Group | None = None,
) -> tuple[CaseRead, Investigation]:
    """One experiment read and investigated by itself."""
    from dataclasses import replace

    from footcal_cli.core.bench_rows import UNEVEN
    from footcal_cli.core.diagnosis.answer import Verdict
    from footcal_cli.core.diagnosis.imperfections import masses_found
    from footcal_cli.core.diagnosis.inquiry import Inquiry
    from footcal_cli.core.diagnosis.investigation import investigate
    from footcal_cli.core.diagnosis.known_gain import with_known_gain
    from footcal_cli.core.diagnosis.moved_gain import with_moved_gain
    from footcal_cli.core.diagnosis.moved_zero import with_moved_zero
    from footcal_cli.core.diagnosis.second_path import against_the_bench, with_second_path
    from footcal_cli.core.diagnosis.signals import describe
    from footcal_cli.core.quality import stopping
    from footcal_cli.intake.cases import read_case
    from footcal_cli.intake.cases.shared import straight_cells

    name = "" if group is None else f" {group.name}"
    with session.step(f"read{name}"):
        read = read_case(reader)
        if group is not None and not group.whole_folder:
            reader.refuse_unread()
        read.findings.extend(reader.noted)
    # how many models of one and more causes are worth a fit shows as it goes
    with session.counted(f"diagnose{name}", "refits", None) as advance:
        found = investigate(
            read.case, read.testable(table), describe, rules, session.request.seed,
            stopped=bool(stopping(read.findings)), advance=advance,
        )  # fmt: skip
        read.findings.extend(masses_found(found.problem))
        if found.odd is not None:
            read.findings.append(found.odd.finding)
        if found.verdict is Verdict.NONE and any(f.code == UNEVEN for f in read.findings):
            found = replace(found, verdict=Verdict.UNKNOWN)  # a cell unlike all others is no noise
        gains = read.like_a_gain(table)
        inquiry = Inquiry(table, describe, rules, session.request.seed, advance)
        again = with_known_gain(found, gains, inquiry)
        again = with_moved_gain(again, read.gains(table), inquiry)
        again = with_moved_zero(again, read.zeros(table), inquiry)
        straight = straight_cells(reader.parameters)
        again = with_second_path(again, table, straight)
        read.findings.extend(against_the_bench(again, straight))
    if again is found:
        return read, found
    answered = {effect for f in again.found for effect in f.cause.effects}
    untested = {n: why for n, why in read.untested.items() if n not in {*gains, *answered}}
    return replace(read, case=again.case, untested=untested), again


def _table(session: Session[DiagnoseOptions]) -> dict[str, Effect]:
    """The table of effects without those left out."""
    from footcal_cli.records.effects import known_effect

    for name in session.options.without:
        known_effect(name, session.table, "--without")
    return {k: v for k, v in session.table.items() if k not in session.options.without}
