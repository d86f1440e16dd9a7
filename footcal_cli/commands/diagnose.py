"""``footcal diagnose``: what the simulation gets wrong, named, sized and proved, or not."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer
from pydantic import Field

from footcal_cli.commands.options import (
    Logs,
    NoPictures,
    Out,
    Overwrite,
    ParametersFile,
    Quiet,
    RecipeFile,
    Seed,
    StrictFindings,
    begin,
)
from footcal_cli.recipe import CommandOptions

if TYPE_CHECKING:
    from collections.abc import Sequence

    from footcal_cli.commands.parts.diagnose_groups import Group
    from footcal_cli.core.effects.contract import Effect
    from footcal_cli.session.session import Outcome, Session


class DiagnoseOptions(CommandOptions):
    """``[diagnose]`` of a recipe."""

    experiment: Literal["weights", "placements", "stand", "walk", "hang", "pose"] = "weights"
    tolerance_n: float | None = Field(default=None, gt=0)
    tolerance_mm: float = Field(default=1.0, gt=0)
    without: tuple[str, ...] = ()
    most_effects: int = Field(default=4, ge=1, le=4)
    delay_s: float = 0.02
    between: tuple[str, ...] = ()
    after: Path | None = None


def diagnose(
    logs: Logs = None,
    recipe: RecipeFile = None,
    parameters: ParametersFile = None,
    experiment: Annotated[
        str | None,
        typer.Option(
            "--experiment", metavar="KIND", help="weights, placements, stand, walk, hang, pose."
        ),
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
    plan: Annotated[
        bool,
        typer.Option("--plan", help="Only the next experiment; LOG is a diagnosis.json, or none."),
    ] = False,
    between: Annotated[
        list[str] | None,
        typer.Option("--between", metavar="EFFECT", help="Rivals that --plan should distinguish."),
    ] = None,
    after: Annotated[
        Path | None,
        typer.Option(
            "--after",
            metavar="FILE",
            help="diagnosis.json of the log before, whose rivals this log should distinguish.",
        ),
    ] = None,
    strict_findings: StrictFindings = None,
    out: Out = Path("out/diagnose"),
    overwrite: Overwrite = False,
    seed: Seed = 0,
    no_pictures: NoPictures = False,
    quiet: Quiet = False,
) -> None:
    """Say what the model gets wrong: name its cause, extend the model, state the gain."""
    if explain is not None:
        from footcal_cli.commands.parts.diagnose_explain import explained

        typer.echo(explained(explain))
        raise typer.Exit
    from footcal_cli.commands.parts.diagnose_groups import groups_of

    groups = groups_of(logs or ())
    if len(groups) == 1:  # a folder is its logs
        experiment, parameters = groups[0].kind, parameters or groups[0].parameters
    session = begin(
        "diagnose",
        DiagnoseOptions,
        logs=[path for group in groups for path in group.logs] or logs,
        recipe=recipe,
        parameters=parameters,
        out=out,
        overwrite=overwrite,
        seed=seed,
        quiet=quiet,
        no_pictures=no_pictures,
        strict_findings=strict_findings,
        experiment=experiment,
        tolerance_n=tolerance_n,
        tolerance_mm=tolerance_mm,
        without=tuple(without) if without else None,
        between=tuple(between) if between else None,
        after=after,
    )
    if len(groups) > 1:
        raise typer.Exit(session.finish(_diagnose_together(session, groups)))
    raise typer.Exit(session.finish(_planned(session) if plan else _diagnose(session, groups)))


def _diagnose_together(session: Session[DiagnoseOptions], groups: Sequence[Group]) -> Outcome:
    from footcal_cli.commands.parts.diagnose_joint import diagnosed_together

    session.refuse_missing_logs("")
    return diagnosed_together(session, groups, _table(session))


def _planned(session: Session[DiagnoseOptions]) -> Outcome:
    from footcal_cli.commands.parts.diagnose_plan import planned

    return planned(session)


def _table(session: Session[DiagnoseOptions]) -> dict[str, Effect]:
    """The table of effects without those left out."""
    from footcal_cli.records.effects import known_effect

    for name in session.options.without:
        known_effect(name, session.table, "--without")
    return {k: v for k, v in session.table.items() if k not in session.options.without}


def _diagnose(session: Session[DiagnoseOptions], groups: Sequence[Group]) -> Outcome:
    session.refuse_missing_logs(session.options.experiment)
    from footcal_cli.commands.parts.diagnose_cases import read_case
    from footcal_cli.commands.parts.diagnose_outcome import outcome_of
    from footcal_cli.core.diagnosis.investigation import investigate
    from footcal_cli.core.diagnosis.rules import Rules
    from footcal_cli.core.diagnosis.signals import describe
    from footcal_cli.core.quality import stopping

    table = _table(session)
    rules = Rules(most_effects=session.options.most_effects)
    # of a folder only those files are logs that are of the kind
    reader = session.part(groups[0].logs, None, session.options) if groups else session
    with session.step("read"):
        read = read_case(reader)
        read.findings.extend(reader.noted)
    usable = {k: v for k, v in table.items() if k not in read.untested}
    with session.step("diagnose"):
        stopped = bool(stopping(read.findings))
        found = investigate(
            read.case, usable, describe, rules, session.request.seed, stopped=stopped
        )
    return outcome_of(session, read, found, usable, rules)
