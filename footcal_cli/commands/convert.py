"""``footcal convert``: logs of other tools as Parquet that a recipe can name the columns of."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
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
    from footcal_cli.formats.contract import Arrays, Stream


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
    jobs = _jobs(found, options)
    targets = _targets(jobs, given["out"], given["overwrite"])
    _write(list(zip(jobs, targets, strict=True)), options, given["quiet"])


def _convert_sheets(books: list[Path], paths: list[Path], given: Given) -> None:
    """Write every filled sheet of workbooks as a CSV file of the same rows.

    Raises
    ------
    UsageError
        Other kinds of files among them, no folder to write to, a file that is there already, or
        two sheets that would get one name.
    """
    from footcal_cli.errors import UsageError
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
            name = _plain(f"{book.stem}_{sheet}" if len(books) > 1 else sheet)
            texts.append((out / f"{name}.csv", text))
    said = [f"{path}  {len(text.splitlines())} rows" for path, text in texts]
    if given["show"]:
        typer.echo("\n".join(said))
        return
    targets = [path for path, _ in texts]
    _refuse_taken(targets, given["overwrite"])
    with _all_or_none(targets) as waiting:
        for path, (_, text) in zip(waiting, texts, strict=True):
            path.write_bytes(text)
    if not given["quiet"]:
        typer.echo("\n".join(said))


class _Job:
    """What one output file is made of: one stream, or several to be joined."""

    def __init__(self, source: Path, streams: tuple[Stream, ...]) -> None:
        self.source = source
        self.streams = streams

    @property
    def name(self) -> str:
        return "joined" if len(self.streams) > 1 else _plain(self.streams[0].name)


def _plain(name: str) -> str:
    """A topic or variable as part of a file or column name: ``/left/cells`` is ``left_cells``."""
    return "_".join(part for part in name.replace("/", " ").replace(".", " ").split())


def _listing(path: Path, streams: tuple[Stream, ...]) -> Iterator[str]:
    yield f"{path}"
    for stream in streams:
        rate = f"{stream.rate_hz:.4g} Hz" if stream.rate_hz else "rate unknown"
        yield f"  {stream.name}  {stream.kind}  {stream.rows} rows  {rate}  {stream.clock}".rstrip()
        for column in stream.columns:
            yield f"      {column}"
        for what in stream.left_out:
            yield f"      left out: {what}"


def _jobs(found: dict[Path, tuple[Stream, ...]], options: ConvertOptions) -> list[_Job]:
    """Which streams are written, by source.

    Raises
    ------
    UsageError
        A topic that no source has, or a join that says too little.
    """
    from footcal_cli.errors import DataError, UsageError, nearest

    names = {stream.name for streams in found.values() for stream in streams}
    for wanted in (*options.topics, *([options.clock] if options.clock else [])):
        if wanted not in names:
            raise UsageError(
                f"no topic '{wanted}'{nearest(wanted, names)}", file=next(iter(found)),
                remedy=f"one of {', '.join(sorted(names))}",
            )  # fmt: skip
    if options.join is not None and options.tolerance_s is None:
        raise UsageError(
            "a join needs the largest distance of two stamps", remedy="add --tolerance-s, e.g. 0.01"
        )
    if options.join is None and (options.clock or options.tolerance_s):
        raise UsageError("--clock and --tolerance-s belong to --join", remedy="add --join nearest")
    jobs = []
    for path, streams in found.items():
        chosen = [s for s in streams if not options.topics or s.name in options.topics]
        for stream in chosen:
            if options.topics and not stream.readable:
                why = "; ".join(stream.left_out) or "it has no rows"
                raise DataError(f"nothing in '{stream.name}' can be a column: {why}", file=path,
                                remedy="see --list for what can")  # fmt: skip
        chosen = [stream for stream in chosen if stream.readable]
        if not chosen:
            raise DataError("nothing in it can be written as columns", file=path,
                            remedy="see --list for what it holds")  # fmt: skip
        if options.join is None:
            jobs += [_Job(path, (stream,)) for stream in chosen]
            continue
        clock = options.clock or (options.topics[0] if options.topics else chosen[0].name)
        chosen.sort(key=lambda stream: stream.name != clock)
        if chosen[0].name != clock:
            raise UsageError(f"the clock '{clock}' is not among the topics to join", file=path,
                             remedy="add it with --topic")  # fmt: skip
        jobs.append(_Job(path, tuple(chosen)))
    return jobs


def _targets(jobs: list[_Job], out: Path, overwrite: bool) -> list[Path]:
    """A file for each job, none of them there yet unless it may be replaced."""
    from footcal_cli.errors import UsageError

    if out.suffix.lower() in {".parquet", ".pq"}:
        if len(jobs) > 1:
            raise UsageError(
                f"{len(jobs)} tables do not go into one file "
                f"({', '.join(job.name for job in jobs)})", file=out,
                remedy="choose one with --topic, put them on one clock with --join, or give "
                "--out a folder",
            )  # fmt: skip
        targets = [out]
    else:
        if out.is_file():
            raise UsageError("--out is neither a folder nor named .parquet", file=out,
                             remedy="name a folder, or a file ending in .parquet")  # fmt: skip
        many = len({job.source for job in jobs}) > 1
        targets = []
        for job in jobs:
            stem = job.source.name.split(".")[0]
            name = f"{stem}_{job.name}" if many and job.name != _plain(stem) else job.name
            targets.append(out / f"{name}.parquet")
    _refuse_taken(targets, overwrite, "convert the sources one by one")
    return targets


def _refuse_taken(
    targets: Sequence[Path], overwrite: bool, remedy: str = "rename one of the two sheets"
) -> None:
    """Refuse a name that two tables would get (`remedy`), or that a file has already."""
    from footcal_cli.errors import UsageError

    twice = [path for path in targets if targets.count(path) > 1]
    if twice:
        raise UsageError("two tables would get this name", file=twice[0], remedy=remedy)
    for path in targets:
        if path.exists() and not overwrite:
            raise UsageError("the file is there already", file=path,
                             remedy="name another --out or --overwrite")  # fmt: skip


@contextmanager
def _all_or_none(targets: Sequence[Path]) -> Iterator[list[Path]]:
    """Temporary names to write to, renamed to `targets` when all are complete."""
    from footcal_cli.errors import UsageError

    waiting = [path.with_name(f".{path.name}.partial-{os.getpid()}") for path in targets]
    for path in targets:
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise UsageError(f"cannot write there: {error.strerror}", file=path,
                             remedy="name another --out") from None  # fmt: skip
    try:
        yield waiting
        for complete, target in zip(waiting, targets, strict=True):
            complete.replace(target)
    finally:
        for path in waiting:
            path.unlink(missing_ok=True)


def _write(work: list[tuple[_Job, Path]], options: ConvertOptions, quiet: bool) -> None:
    """Write every table, none where one cannot be written, and say so."""
    from footcal_cli.tables.logfiles import write_parquet_pieces

    said: list[str] = []
    with _all_or_none([target for _, target in work]) as waiting:
        for (job, target), path in zip(work, waiting, strict=True):
            seen = _Span(job.streams[0].time)
            notes: list[str] = []
            rows = write_parquet_pieces(seen.watched(_pieces(job, options, notes)), path)
            said += [f"{target}  {rows} rows{seen.words()}  {_from(job)}", *notes]
            said += [f"  left out of {s.name}: {what}" for s in job.streams for what in s.left_out]
    if not quiet:
        typer.echo("\n".join(said))


def _from(job: _Job) -> str:
    streams = ", ".join(f"{stream.name} ({stream.kind})" for stream in job.streams)
    return f"from {streams} of {job.source}, {job.streams[0].clock}"


def _pieces(job: _Job, options: ConvertOptions, notes: list[str]) -> Iterator[Arrays]:
    if len(job.streams) == 1:
        yield from job.streams[0].chunks()
        return
    import numpy as np

    from footcal_cli.errors import DataError
    from footcal_cli.formats.arrays import pieces
    from footcal_cli.formats.join import joined

    assert options.join is not None, "several streams make one table by a join only"
    assert options.tolerance_s is not None, "checked with the join"
    read = {}
    units = set()
    for stream in job.streams:
        if stream.time is None:
            raise DataError(f"'{stream.name}' has no time stamps to join by", file=job.source,
                            remedy="convert it without --join")  # fmt: skip
        chunks = list(stream.chunks())
        columns = {name: np.concatenate([c[name] for c in chunks]) for name in chunks[0]}
        read[_plain(stream.name)] = (columns, stream.time)
        units.add(stream.time.rpartition("_")[2] if "_" in stream.time else "s")
    if len(units) > 1:
        raise DataError(f"stamps in {' and '.join(sorted(units))} are not joined", file=job.source,
                        remedy="convert without --join")  # fmt: skip
    clock = next(iter(read))
    table = joined(read, clock, options.join, options.tolerance_s)
    rows = len(table.columns[read[clock][1]])
    notes += [
        f"  {missing} of {rows} rows of {clock} have no {name} within {options.tolerance_s} s"
        for name, missing in table.unmatched.items()
    ]
    yield from pieces(table.columns)


class _Span:
    """First and last stamp of what passes through."""

    def __init__(self, time: str | None) -> None:
        self.time = time
        self.first: float | int | None = None
        self.last: float | int | None = None
        self.rows = 0

    def watched(self, pieces: Iterator[Arrays]) -> Iterator[Arrays]:
        for piece in pieces:
            if self.time is not None:
                stamps = piece[self.time]
                low, high = stamps.min().item(), stamps.max().item()
                self.first = low if self.first is None else min(self.first, low)
                self.last = high if self.last is None else max(self.last, high)
                self.rows += len(stamps)
            yield piece

    def words(self) -> str:
        from footcal_cli.formats.contract import seconds_each

        if self.time is None or self.first is None or self.last is None:
            return ""
        scale = seconds_each(self.time)
        length_s = (self.last - self.first) * scale
        rate = f", {(self.rows - 1) / length_s:.4g} Hz" if length_s > 0 else ""
        return f"  {self.first * scale:.9g} … {self.last * scale:.9g} s ({length_s:.6g} s{rate})"
