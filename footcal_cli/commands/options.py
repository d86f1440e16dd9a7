"""The command line: every command's function made of its option model and what all share."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from inspect import Parameter, Signature, signature
from pathlib import Path
from types import UnionType
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeVar, Union, get_args, get_origin

import typer

from footcal_cli.recipe import CommandOptions
from footcal_cli.recipe.options import Flag

if TYPE_CHECKING:
    from footcal_cli.report.outcome import Outcome

AnyOptions = TypeVar("AnyOptions", bound=CommandOptions)
Given = dict[str, Any]
"""What the command line gave, by the name of the option; None where it gave nothing."""

LogArguments = Annotated[
    list[Path] | None,
    typer.Argument(metavar="LOG", help="Logs (CSV, CSV.gz, Parquet); replace \\[data]."),
]
RecipeFile = Annotated[
    Path | None, typer.Option("--recipe", metavar="FILE.toml", help="Robot, columns, options.")
]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace what is there.")]
Quiet = Annotated[bool, typer.Option("--quiet", help="Print errors only.")]
_FIRST: Mapping[str, tuple[Any, Any]] = {
    "logs": (LogArguments, None),
    "recipe": (RecipeFile, None),
    "parameters": (
        Annotated[
            Path | None,
            typer.Option(
                "--parameters", metavar="FILE.json", help="The calibration to start from."
            ),
        ],
        None,
    ),
}
_LAST: Mapping[str, tuple[Any, Any]] = {
    "reference": (
        Annotated[
            Path | None,
            typer.Option(
                "--reference",
                metavar="FILE.json",
                help="Gate: exit 1 where a parameter differs too much from this calibration "
                "(limits in \\[gates]).",
            ),
        ],
        None,
    ),
    "strict_findings": (
        Annotated[
            bool | None,
            typer.Option(
                "--strict-findings", help="Exit 1 where the data show a warning or an alarm."
            ),
        ],
        None,
    ),
    "out": (
        Annotated[
            Path, typer.Option("--out", "-o", metavar="DIR", help="Run folder to write.")
        ],
        ...,
    ),
    "overwrite": (Overwrite, False),
    "seed": (
        Annotated[int, typer.Option("--seed", metavar="N", help="Seed of the random numbers.")], 0,
    ),
    "no_pictures": (
        Annotated[bool, typer.Option("--no-pictures", help="Draw no figures.")], False,
    ),
    "quiet": (Quiet, False),
}  # fmt: skip


def command(
    model: type[AnyOptions],
    *,
    lacks: Collection[str] = (),
    shared: Mapping[str, Any] | None = None,
    extra: Mapping[str, Any] | None = None,
    opening: Callable[[Given], None] | None = None,
    goes_on: bool = False,
) -> Callable[[Callable[..., Outcome]], Callable[..., None]]:
    """Make a command of a function that takes its session and returns its outcome.

    Parameters
    ----------
    model
        The command's options; fields with a `Flag` are options of the command line.
    lacks
        Shared options that would change nothing here.
    shared
        Other words for shared options, as typer's annotations.
    extra
        Options that are no settings, as typer's annotations.
    opening
        May end the command, or change what was given, before anything is read. What the function
        asks for besides its session it gets by name.
    goes_on
        Whether the run folder is gone on with.
    """

    def made(work: Callable[..., Outcome]) -> Callable[..., None]:
        name = work.__name__.replace("_", "-")
        flags = flags_of(model)
        common = {
            k: ((shared or {}).get(k, a), d)
            for k, (a, d) in (*_FIRST.items(), *_LAST.items())
            if k not in lacks
        }
        common["out"] = (common["out"][0], Path(f"out/{name}"))
        wanted = list(signature(work).parameters)[1:]
        rows = {k: common[k] for k in _FIRST if k in common}
        rows |= {k: (annotation, None) for k, (_, annotation) in flags.items()}
        rows |= {k: (annotation, None) for k, annotation in (extra or {}).items()}
        rows |= {k: common[k] for k in _LAST if k in common}

        def run(**words: Any) -> None:
            given = {k: default for k, (_, default) in rows.items()} | words
            if opening is not None:
                opening(given)
            session = begin(name, model, given, overrides_of(model, given), goes_on=goes_on)
            raise typer.Exit(session.finish(work(session, **{k: given[k] for k in wanted})))

        return _asking(run, work, rows)

    return made


def without_folder(
    model: type[AnyOptions], first: Mapping[str, Any], last: Mapping[str, Any]
) -> Callable[[Callable[[Given], None]], Callable[..., None]]:
    """Make a command that writes no run folder, of a function that takes what was given.

    `first` and `last` are its words before and behind those of its options: typer's annotation and
    the default of each.
    """

    def made(work: Callable[[Given], None]) -> Callable[..., None]:
        flags = {k: (annotation, None) for k, (_, annotation) in flags_of(model).items()}
        rows = {**first, **flags, **last}

        def run(**words: Any) -> None:
            work({k: default for k, (_, default) in rows.items()} | words)

        return _asking(run, work, rows)

    return made


def _asking(
    run: Callable[..., None], work: Callable[..., Any], rows: Mapping[str, tuple[Any, Any]]
) -> Callable[..., None]:
    """`run` with the name and words of `work` and one keyword for each row."""
    run.__name__, run.__module__, run.__doc__ = work.__name__, work.__module__, work.__doc__
    run.__signature__ = Signature(  # type: ignore[attr-defined]
        [
            Parameter(k, Parameter.KEYWORD_ONLY, default=default, annotation=annotation)
            for k, (annotation, default) in rows.items()
        ]
    )
    run.__annotations__ = {k: annotation for k, (annotation, _) in rows.items()}
    return run


def overrides_of(model: type[CommandOptions], given: Given) -> Given:
    """Fields of a model that the command line gave; those that are None leave the recipe's."""
    every = {field: given[k] for k, (field, _) in flags_of(model).items()}
    return {k: tuple(v) or None if isinstance(v, list) else v for k, v in every.items()}


def begin(
    name: str, model: type[AnyOptions], given: Given, overrides: Given, *, goes_on: bool = False
) -> Any:
    """Open the session of a command; `overrides` as of `overrides_of`."""
    from footcal_cli.commands import option_tables
    from footcal_cli.session.request import Request
    from footcal_cli.session.session import Session

    request = Request(
        command=name,
        logs=tuple(given.get("logs") or ()),
        recipe=given["recipe"],
        parameters=given.get("parameters"),
        out=given["out"],
        overwrite=given["overwrite"],
        seed=given.get("seed", 0),
        quiet=given["quiet"],
        overrides={
            **overrides,
            "strict_findings": given.get("strict_findings"),
            "pictures": False if given.get("no_pictures") else None,
        },
        goes_on=goes_on,
        reference=given.get("reference"),
    )
    return Session(request, model, option_tables())


def flags_of(model: type[CommandOptions]) -> dict[str, tuple[str, Any]]:
    """Options of the command line that a model has: name -> its field and typer's annotation."""
    found = {}
    for field, about in model.model_fields.items():
        flag = next((item for item in about.metadata if isinstance(item, Flag)), None)
        if flag is not None:
            name = flag.name or field
            option = typer.Option(
                f"--{name.replace('_', '-')}", metavar=flag.metavar, help=flag.help
            )
            found[name] = (field, Annotated[_asked_as(about.annotation), option])
    return found


def _asked_as(annotation: Any) -> Any:
    """Type of a field on the command line, which is None where the option is not given."""
    if get_origin(annotation) is Annotated:
        return _asked_as(get_args(annotation)[0])
    if get_origin(annotation) in (Union, UnionType):
        return _asked_as(next(a for a in get_args(annotation) if a is not type(None)))
    if get_origin(annotation) is Literal:
        return str | None
    if get_origin(annotation) is tuple:
        return list[str] | None
    return annotation | None
