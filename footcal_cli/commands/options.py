"""The command line that all commands share."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeVar

import typer

from footcal_cli.recipe import CommandOptions

if TYPE_CHECKING:
    from footcal_cli.session.session import Session

Options = TypeVar("Options", bound=CommandOptions)

Logs = Annotated[
    list[Path] | None,
    typer.Argument(metavar="[LOG]...", help="Logs (CSV, CSV.gz, Parquet); replace \\[data]."),
]
RecipeFile = Annotated[
    Path | None, typer.Option("--recipe", metavar="FILE.toml", help="Robot, columns, options.")
]
ParametersFile = Annotated[
    Path | None,
    typer.Option("--parameters", metavar="FILE.json", help="The calibration to start from."),
]
ReferenceFile = Annotated[
    Path | None,
    typer.Option(
        "--reference",
        metavar="FILE.json",
        help="Gate: exit 1 where a parameter left this calibration ([gates] says by how much).",
    ),
]
Out = Annotated[Path, typer.Option("--out", metavar="DIR", help="Run folder to write.")]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace a run folder.")]
Seed = Annotated[int, typer.Option("--seed", metavar="N", help="Seed of all that is random.")]
Quiet = Annotated[bool, typer.Option("--quiet", help="Print errors only.")]
StrictFindings = Annotated[
    bool | None,
    typer.Option("--strict-findings", help="Exit 1 where the data show a warning or an alarm."),
]
NoPictures = Annotated[bool, typer.Option("--no-pictures", help="Draw no figures.")]


def begin(
    command: str,
    options_model: type[Options],
    /,
    *,
    logs: list[Path] | None,
    recipe: Path | None,
    parameters: Path | None = None,
    reference: Path | None = None,
    out: Path,
    overwrite: bool,
    seed: int = 0,
    quiet: bool,
    no_pictures: bool = False,
    goes_on: bool = False,
    **overrides: object,
) -> Session[Options]:
    """Open the session of a command; `overrides` that are None leave the recipe's value."""
    from footcal_cli.commands import option_tables
    from footcal_cli.session.session import Request, Session

    request = Request(
        command=command,
        logs=tuple(logs or ()),
        recipe=recipe,
        parameters=parameters,
        out=out,
        overwrite=overwrite,
        seed=seed,
        quiet=quiet,
        overrides={**overrides, "pictures": False if no_pictures else None},
        goes_on=goes_on,
        reference=reference,
    )
    return Session(request, options_model, option_tables())
