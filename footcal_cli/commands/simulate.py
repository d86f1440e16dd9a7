"""``footcal simulate``: what the sensors of a robot would have shown, and what was true."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, get_args

import typer

from footcal_cli.commands.options import command
from footcal_cli.recipe.options import SimulateOptions
from footcal_cli.records.own_effects import ExperimentName

if TYPE_CHECKING:
    from footcal_cli.report.outcome import Outcome
    from footcal_cli.session.session import Session

_MOTION = Annotated[
    list[Path] | None,
    typer.Argument(
        metavar="MOTION",
        help="A recorded stand or walk with its true cell loads, in place of the planned one.",
    ),
]


@command(SimulateOptions, lacks=("reference",), shared={"logs": _MOTION})
def simulate(session: Session[SimulateOptions]) -> Outcome:
    """Simulate an experiment with any effects; write its logs and its truth."""
    from footcal_cli.errors import UsageError

    options = session.options
    if options.experiment is None:
        raise UsageError(
            "no experiment named", file=session.recipe.path,
            remedy=f"add --experiment, one of {', '.join(get_args(ExperimentName))}",
        )  # fmt: skip
    from dataclasses import replace

    from footcal_cli.core.simulation.scenario import simulate as simulated
    from footcal_cli.intake.scenario import (
        motion_of,
        parse_effect,
        plans_of,
        robot_of,
        spread_of,
        truth_of,
    )
    from footcal_cli.sheets.simulated import outcome_of

    robot = robot_of(session, options.experiment)
    requests = [parse_effect(text, session.table) for text in options.effects]
    plans = plans_of(session, robot)
    motion = motion_of(session, robot)
    with session.step("simulate"):
        scenario = simulated(
            options.experiment,
            robot,
            plans,
            requests,
            seed=session.request.seed,
            motion=motion,
            spread=spread_of(session),
            given=None if session.parameters is None else session.parameters.values,
        )
    found = outcome_of(session.recipe.robot.name, options.experiment, scenario, requests)
    return replace(found, records={"truth.json": truth_of(session, scenario, plans, robot)})
