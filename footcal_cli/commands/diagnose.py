"""``footcal diagnose``: what the simulation gets wrong, named, sized and proved, or not."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer
from pydantic import Field

from footcal_cli.commands.options import (
    Logs,
    Out,
    Overwrite,
    ParametersFile,
    Quiet,
    RecipeFile,
    Seed,
    begin,
)
from footcal_cli.recipe import CommandOptions

if TYPE_CHECKING:
    from footcal_cli.commands.parts.diagnose_cases import CaseRead
    from footcal_cli.core.diagnosis.investigation import Investigation
    from footcal_cli.core.diagnosis.movement import Movement
    from footcal_cli.core.effects.contract import Effect
    from footcal_cli.records import ParametersRecord, RmseRecord
    from footcal_cli.report import Picture
    from footcal_cli.session import Outcome, Session


class DiagnoseOptions(CommandOptions):
    """``[diagnose]`` of a recipe."""

    experiment: Literal["weights", "placements", "stand", "walk", "hang", "pose"] = "weights"
    tolerance_n: float | None = Field(default=None, gt=0)
    tolerance_mm: float = Field(default=1.0, gt=0)
    without: tuple[str, ...] = ()
    most_effects: int = Field(default=4, ge=1, le=4)
    delay_s: float = 0.02


def diagnose(
    logs: Logs = None,
    recipe: RecipeFile = None,
    parameters: ParametersFile = None,
    experiment: Annotated[
        str | None,
        typer.Option("--experiment", metavar="KIND", help="weights, placements, stand, walk."),
    ] = None,
    tolerance_n: Annotated[
        float | None,
        typer.Option("--tolerance-n", help="Smallest RMS error of a force that matters."),
    ] = None,
    tolerance_mm: Annotated[
        float | None,
        typer.Option("--tolerance-mm", help="Smallest error of the centre of pressure."),
    ] = None,
    without: Annotated[
        list[str] | None,
        typer.Option("--without", metavar="EFFECT", help="Leave an effect out of the table."),
    ] = None,
    explain: Annotated[
        str | None, typer.Option("--explain", metavar="EFFECT", help="Explain an effect and stop.")
    ] = None,
    out: Out = Path("out/diagnose"),
    overwrite: Overwrite = False,
    seed: Seed = 0,
    quiet: Quiet = False,
) -> None:
    """Say what the model gets wrong: name the cause, extend the model, measure the gain."""
    if explain is not None:
        typer.echo(_explained(explain))
        raise typer.Exit
    session = begin(
        "diagnose",
        DiagnoseOptions,
        logs=logs,
        recipe=recipe,
        parameters=parameters,
        out=out,
        overwrite=overwrite,
        seed=seed,
        quiet=quiet,
        experiment=experiment,
        tolerance_n=tolerance_n,
        tolerance_mm=tolerance_mm,
        without=tuple(without) if without else None,
    )
    raise typer.Exit(session.finish(_diagnose(session)))


def _explained(name: str) -> str:
    """Formula, source, look-alikes and remedy of an effect."""
    from footcal_cli.core.effects import UnknownEffectError, find_effect
    from footcal_cli.errors import UsageError

    try:
        effect = find_effect(name)
    except UnknownEffectError as error:
        raise UsageError(
            f"no effect named '{name}'",
            remedy=f"did you mean '{error.nearest}'?" if error.nearest else "see footcal effects",
        ) from None
    sizes = ", ".join(f"{p.name} ({p.unit})" for p in effect.parameters)
    return "\n".join(
        (
            f"{effect.name}: {effect.formula}",
            f"  parameters   {sizes}",
            f"  seen in      {', '.join(effect.experiments)}",
            f"  looks like   {', '.join(effect.mimics) or 'nothing else in the table'}",
            f"  separated by {effect.separates or '–'}",
            f"  what to do   {effect.remedy}",
            f"  source       {effect.source}",
        )
    )


def _table(session: Session[DiagnoseOptions]) -> dict[str, Effect]:
    """The table of effects without those left out."""
    from footcal_cli.core.effects import TABLE
    from footcal_cli.errors import UsageError, nearest

    for name in session.options.without:
        if name not in TABLE:
            raise UsageError(
                f"--without: no effect named '{name}'{nearest(name, TABLE)}",
                remedy="see footcal effects",
            )
    return {k: v for k, v in TABLE.items() if k not in session.options.without}


def _diagnose(session: Session[DiagnoseOptions]) -> Outcome:
    from footcal_cli.commands.parts.diagnose_cases import read_case
    from footcal_cli.core.diagnosis.investigation import investigate
    from footcal_cli.core.diagnosis.movement import movements
    from footcal_cli.core.diagnosis.rules import Rules
    from footcal_cli.core.diagnosis.signals import describe
    from footcal_cli.records import FindingRecord
    from footcal_cli.report import Report
    from footcal_cli.session import Outcome
    from footcal_cli.sheets.diagnosis.answer import answer_of
    from footcal_cli.sheets.diagnosis.evidence import evidence_sheet, untested_sheet
    from footcal_cli.sheets.diagnosis.experiment import menu_sheets
    from footcal_cli.sheets.diagnosis.gains import gain_sheets, method_note, movement_sheets
    from footcal_cli.sheets.diagnosis.record import record_of
    from footcal_cli.sheets.diagnosis.unknown import card_sheets

    table = _table(session)
    rules = Rules(most_effects=session.options.most_effects)
    with session.step("read"):
        read = read_case(session)
    usable = {k: v for k, v in table.items() if k not in read.untested}
    with session.step("diagnose"):
        found = investigate(read.case, usable, describe, rules, session.request.seed)
        moved = movements(read.case, found.problem, found.final)
    answer = answer_of(found, table, read.findings, read.untested)
    with session.step("draw"):
        pictures = _pictures(found, moved, session.request.seed)
    return Outcome(
        report=Report(
            title=f"Diagnosis of {session.recipe.robot.name}: {read.case.experiment.name}",
            verdict=answer.verdict,
            pictures=pictures,
            lead_sheets=(evidence_sheet(found, read.untested),),
            sheets=(
                *gain_sheets(found),
                *menu_sheets(answer),
                *card_sheets(found),
                *movement_sheets(moved),
                untested_sheet(found, read.untested),
            ),
            findings=tuple(FindingRecord.of(f) for f in read.findings),
            footer=(rules.sentence(), method_note(found, session.request.seed)),
        ),
        rmse=_rmse(found),
        records={
            "diagnosis.json": record_of(found, answer, read, rules, session.request.seed),
            "parameters_extended.json": _extended(session, found, moved, read),
        },
    )


def _pictures(found: Investigation, moved: tuple[Movement, ...], seed: int) -> tuple[Picture, ...]:
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
        Picture("residual_against_driver", residuals.plot_driver(found), residuals.DRIVER_CAPTION),
        Picture("line_up", line_up.plot_line_up(found, seed), line_up.LINE_UP_CAPTION),
        Picture("gain_per_block", gains.plot_gains(found), gains.GAINS_CAPTION),
        Picture("ladder", ladder.plot_ladder(found), ladder.LADDER_CAPTION),
        Picture(
            "isolability", isolability.plot_isolability(found), isolability.ISOLABILITY_CAPTION
        ),
    ]
    if moved and found.found:
        drawn.append(Picture("movement", movement.plot_movement(moved), movement.MOVEMENT_CAPTION))
    drawn.append(Picture("null_gallery", null.plot_null(found), null.NULL_CAPTION))
    return tuple(drawn)


def _rmse(found: Investigation) -> RmseRecord:
    """Held-out errors of the baseline and of the extended model, per output."""
    from footcal_cli.records import RmseRecord, RmseRow

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
    from footcal_cli.core.parameters import Status
    from footcal_cli.records import EffectRecord, ParameterRecord, ParametersRecord

    given = session.parameters
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
    if found.model is not None and found.verdict in ("named", "named+unknown", "ambiguous"):
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
            effects.append(EffectRecord(effect=signature.effect, owners=dict(signature.owners)))
        for name, unit in units.items():
            if name in found.model.values and name not in parameters:
                parameters[name] = ParameterRecord(
                    value=float(found.model.values[name]),
                    sd=sd_of.get(name),
                    unit=unit,
                    status=Status.ESTIMATED if name in sd_of else Status.FIXED,
                )
    return ParametersRecord(
        command="diagnose",
        created=session.created(),
        robot=session.recipe.robot.name,
        gravity_mps2=session.recipe.robot.gravity_mps2,
        sign_convention=given.sign_convention
        if given is not None
        else "force = scale * counts + bias, positive when the cell is pressed",
        frame=given.frame if given is not None else "each cell's own axis",
        expressed_at=given.expressed_at if given is not None else "the cell",
        parameters=parameters,
        covariance=given.covariance if given is not None and not moved else (),
        fitted_range=given.fitted_range if given is not None else {},
        effects=tuple(effects),
        inputs=session.inputs,
    )
