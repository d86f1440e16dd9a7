"""``footcal check``: what is wrong with a log, and nothing else."""

from __future__ import annotations

from typing import TYPE_CHECKING

from footcal_cli.commands.options import command
from footcal_cli.recipe import CommandOptions

if TYPE_CHECKING:
    from footcal_cli.report.outcome import Outcome
    from footcal_cli.session.session import Session


class CheckOptions(CommandOptions):
    """``[check]`` of a recipe."""

    intended_load_n: tuple[float, float] | None = None


@command(CheckOptions, lacks=("reference", "seed"))
def check(session: Session[CheckOptions]) -> Outcome:
    """Look for what is wrong with a log and against its recipe; draw the log."""
    from footcal_cli.intake.every_kind import compare, read_every_kind
    from footcal_cli.sheets.log import outcome_of

    with session.step("read"):
        tables = read_every_kind(session)
        compare(session, tables, session.options.intended_load_n)
    return outcome_of(tables, session.recipe.robot, session.noted)
