"""``footcal apply``: a calibration on a log: forces, centres of pressure, foot wrenches."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

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
    from footcal_cli.session.session import Outcome, Session


class ApplyOptions(CommandOptions):
    """``[apply]`` of a recipe.

    `chassis_com_m` is used where the calibration does not say which chassis CoM it means;
    `least_force_n` is the load below which a foot has no centre of pressure; `cop_correction` is a
    ``cop_correction.json`` of offline-fit.
    """

    chassis_com_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    least_force_n: float = Field(default=5.0, gt=0)
    cop_correction: str | None = None


def apply(
    logs: Logs = None,
    recipe: RecipeFile = None,
    parameters: ParametersFile = None,
    cop_correction: Annotated[
        Path | None,
        typer.Option(
            "--cop-correction", metavar="FILE", help="cop_correction.json of offline-fit."
        ),
    ] = None,
    strict_findings: StrictFindings = None,
    out: Out = Path("out/apply"),
    overwrite: Overwrite = False,
    seed: Seed = 0,
    no_pictures: NoPictures = False,
    quiet: Quiet = False,
) -> None:
    """Turn a log into calibrated forces, centres of pressure or foot wrenches."""
    session = begin(
        "apply",
        ApplyOptions,
        logs=logs,
        recipe=recipe,
        parameters=parameters,
        out=out,
        overwrite=overwrite,
        seed=seed,
        quiet=quiet,
        no_pictures=no_pictures,
        strict_findings=strict_findings,
        cop_correction=None if cop_correction is None else str(cop_correction),
    )
    raise typer.Exit(session.finish(_applied(session)))


def _applied(session: Session[ApplyOptions]) -> Outcome:
    from footcal_cli.errors import UsageError

    robot = session.recipe.robot
    if session.parameters is None:
        raise UsageError("no calibration given", remedy="give --parameters FILE.json")
    if robot.legs:
        from footcal_cli.commands.parts.apply_legs import apply_legs

        return apply_legs(session)
    if robot.cell_names:
        from footcal_cli.commands.parts.apply_cells import apply_cells

        return apply_cells(session)
    raise UsageError(
        "the recipe names neither legs nor load cells", file=session.recipe.path,
        remedy="add [robot.legs.…], [robot.feet.…] or channels",
    )  # fmt: skip
