"""``footcal convert``: logs of other tools as Parquet that a recipe can name the columns of."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer
from pydantic import Field

from footcal_cli.commands.options import (
    Given,
    Overwrite,
    Quiet,
    RecipeFile,
    overrides_of,
    without_folder,
)
from footcal_cli.recipe import CommandOptions
from footcal_cli.recipe.options import Flag

if TYPE_CHECKING:
    from footcal_cli.formats.contract import Stream


class ConvertOptions(CommandOptions):
    """``[convert]`` of a recipe.

    `topics` are the streams to write, all that can be where none is named; `time` takes the stamp
    of the message's header or of the recorder; `join` puts all of them on the stamps of `clock`
    (the first topic where none is named), a partner no farther than `tolerance_s`.
    """

    topics: Annotated[
        tuple[str, ...],
        Flag("A topic or table to write; repeatable.", name="topic", metavar="NAME"),
    ] = ()
    time: Annotated[
        Literal["header", "log"],
        Flag("Time stamp of a message: its header's (header, default) or the recorder's (log)."),
    ] = "header"
    join: Annotated[
        Literal["nearest", "previous"] | None,
        Flag("Write one table of all topics, joined by the nearest or the previous time stamp."),
    ] = None
    clock: Annotated[
        str | None,
        Flag("Topic whose time stamps are the rows of the joined table.", metavar="NAME"),
    ] = None
    tolerance_s: Annotated[
        float | None, Flag("Largest difference of joined time stamps, in seconds.")
    ] = Field(default=None, gt=0)


_FIRST: dict[str, Any] = {
    "sources": (
        Annotated[
            list[Path] | None,
            typer.Argument(metavar="SRC", help="Logs of other tools; replace \\[data] convert."),
        ],
        None,
    ),
    "recipe": (RecipeFile, None),
    "show": (
        Annotated[bool, typer.Option("--list", help="Print what is inside and write nothing.")],
        False,
    ),
}
_LAST: dict[str, Any] = {
    "out": (
        Annotated[
            Path,
            typer.Option(
                "--out", "-o", metavar="FILE.parquet|DIR", help="File or folder to write."
            ),
        ],
        Path("out/convert"),
    ),
    "overwrite": (Overwrite, False),
    "quiet": (Quiet, False),
}


@without_folder(ConvertOptions, _FIRST, _LAST)
def convert(given: Given) -> None:
    """Convert bags, MCAP, C3D, OpenSim, MATLAB, HDF5 and JSON to Parquet, sheets to CSV."""
    from footcal_cli.commands import option_tables
    from footcal_cli.errors import UsageError
    from footcal_cli.formats.detect import open_source
    from footcal_cli.formats.into_tables import jobs_of, targets_of, write_tables
    from footcal_cli.recipe import Recipe, read_recipe
    from footcal_cli.tables.workbooks import is_workbook

    recipe = given["recipe"]
    read = read_recipe(recipe, option_tables()) if recipe is not None else Recipe()
    options = read.options_for(ConvertOptions, "convert", overrides_of(ConvertOptions, given))
    paths = list(given["sources"] or ()) or read.data_paths("convert")
    if not paths:
        raise UsageError(
            "no log to convert given", file=recipe,
            remedy="name a SRC on the command line or 'convert' in [data]",
        )  # fmt: skip
    books = [path for path in paths if is_workbook(path)]
    if books:
        _convert_sheets(books, paths, given)
        return
    found = {path: open_source(path, options.time) for path in paths}
    if given["show"]:
        for path, streams in found.items():
            typer.echo("\n".join(_listing(path, streams)))
        return
    jobs = jobs_of(found, options)
    said = write_tables(jobs, targets_of(jobs, given["out"], given["overwrite"]), options)
    if not given["quiet"]:
        typer.echo("\n".join(said))


def _convert_sheets(books: list[Path], paths: list[Path], given: Given) -> None:
    """Write every filled sheet of workbooks as a CSV file of the same rows.

    Raises
    ------
    UsageError
        Other kinds of files among them, no folder to write to, a file that is there already, or
        two sheets that would get one name.
    """
    from footcal_cli.errors import UsageError
    from footcal_cli.formats.into_tables import all_or_none, plain_name, refuse_taken
    from footcal_cli.tables.textfiles import regular_file
    from footcal_cli.tables.workbooks import sheet_texts

    out: Path = given["out"]
    if len(books) < len(paths) or out.suffix or out.is_file():
        raise UsageError(
            "sheets of workbooks are written as CSV into a folder, other logs as Parquet",
            file=books[0], remedy="convert workbooks by themselves, --out a folder",
        )  # fmt: skip
    texts: list[tuple[Path, bytes]] = []
    for book in books:
        regular_file(book)
        for sheet, text in sheet_texts(book).items():
            name = plain_name(f"{book.stem}_{sheet}" if len(books) > 1 else sheet)
            texts.append((out / f"{name}.csv", text))
    said = [f"{path}  {len(text.splitlines())} rows" for path, text in texts]
    if given["show"]:
        typer.echo("\n".join(said))
        return
    targets = [path for path, _ in texts]
    refuse_taken(targets, given["overwrite"])
    with all_or_none(targets) as waiting:
        for path, (_, text) in zip(waiting, texts, strict=True):
            path.write_bytes(text)
    if not given["quiet"]:
        typer.echo("\n".join(said))


def _listing(path: Path, streams: tuple[Stream, ...]) -> Iterator[str]:
    yield f"{path}"
    for stream in streams:
        rate = f"{stream.rate_hz:.4g} Hz" if stream.rate_hz else "rate unknown"
        yield f"  {stream.name}  {stream.kind}  {stream.rows} rows  {rate}  {stream.clock}".rstrip()
        for column in stream.columns:
            yield f"      {column}"
        for what in stream.left_out:
            yield f"      left out: {what}"
