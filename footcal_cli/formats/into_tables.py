"""Tables of foreign files written as Parquet: which streams, under which names, all or none.

Room: formats; convert and init write so.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Literal, Protocol

import numpy as np

from footcal_cli.errors import DataError, UsageError, nearest
from footcal_cli.formats.arrays import pieces
from footcal_cli.formats.contract import Arrays, Stream, seconds_each
from footcal_cli.formats.join import joined
from footcal_cli.tables.logfiles import write_parquet_pieces


class ConversionAsked(Protocol):
    """What is asked of a conversion: ``[convert]`` of a recipe."""

    @property
    def topics(self) -> tuple[str, ...]:
        """Streams to write; all where none is named."""

    @property
    def join(self) -> Literal["nearest", "previous"] | None:
        """How streams are put on one clock; None: a table each."""

    @property
    def clock(self) -> str | None:
        """The stream whose stamps are the rows of the joined table."""

    @property
    def tolerance_s(self) -> float | None:
        """Largest difference of joined stamps."""


class TableToWrite:
    """What one output file is made of: one stream, or several to be joined."""

    def __init__(self, source: Path, streams: tuple[Stream, ...]) -> None:
        self.source = source
        self.streams = streams

    @property
    def name(self) -> str:
        """Of its file."""
        return "joined" if len(self.streams) > 1 else plain_name(self.streams[0].name)


def plain_name(name: str) -> str:
    """A topic or variable as part of a file or column name: ``/left/cells`` is ``left_cells``."""
    return "_".join(part for part in name.replace("/", " ").replace(".", " ").split())


def jobs_of(
    found: Mapping[Path, tuple[Stream, ...]], options: ConversionAsked
) -> list[TableToWrite]:
    """Which streams are written, by source.

    Raises
    ------
    UsageError
        A topic that no source has, or a join that says too little.
    """
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
            jobs += [TableToWrite(path, (stream,)) for stream in chosen]
            continue
        clock = options.clock or (options.topics[0] if options.topics else chosen[0].name)
        chosen.sort(key=lambda stream: stream.name != clock)
        if chosen[0].name != clock:
            raise UsageError(f"the clock '{clock}' is not among the topics to join", file=path,
                             remedy="add it with --topic")  # fmt: skip
        jobs.append(TableToWrite(path, tuple(chosen)))
    return jobs


def targets_of(jobs: list[TableToWrite], out: Path, overwrite: bool) -> list[Path]:
    """A file for each job, none of them there yet unless it may be replaced."""
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
            name = f"{stem}_{job.name}" if many and job.name != plain_name(stem) else job.name
            targets.append(out / f"{name}.parquet")
    refuse_taken(targets, overwrite, "convert the sources one by one")
    return targets


def refuse_taken(
    targets: Sequence[Path], overwrite: bool, remedy: str = "rename one of the two sheets"
) -> None:
    """Refuse a name that two tables would get (`remedy`), or that a file has already."""
    twice = [path for path in targets if targets.count(path) > 1]
    if twice:
        raise UsageError("two tables would get this name", file=twice[0], remedy=remedy)
    for path in targets:
        if path.exists() and not overwrite:
            raise UsageError("the file is there already", file=path,
                             remedy="name another --out or --overwrite")  # fmt: skip


@contextmanager
def all_or_none(targets: Sequence[Path]) -> Iterator[list[Path]]:
    """Temporary names to write to, renamed to `targets` when all are complete."""
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


def write_tables(
    jobs: Sequence[TableToWrite], targets: Sequence[Path], options: ConversionAsked
) -> list[str]:
    """Write every table, none where one cannot be written, and give a line on each."""
    said: list[str] = []
    with all_or_none(targets) as waiting:
        for job, target, path in zip(jobs, targets, waiting, strict=True):
            seen = _Span(job.streams[0].time)
            notes: list[str] = []
            rows = write_parquet_pieces(seen.watched(_pieces(job, options, notes)), path)
            said += [f"{target}  {rows} rows{seen.words()}  {_from(job)}", *notes]
            said += [f"  left out of {s.name}: {what}" for s in job.streams for what in s.left_out]
    return said


def _from(job: TableToWrite) -> str:
    streams = ", ".join(f"{stream.name} ({stream.kind})" for stream in job.streams)
    return f"from {streams} of {job.source}, {job.streams[0].clock}"


def _pieces(job: TableToWrite, options: ConversionAsked, notes: list[str]) -> Iterator[Arrays]:
    if len(job.streams) == 1:
        yield from job.streams[0].chunks()
        return
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
        read[plain_name(stream.name)] = (columns, stream.time)
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
        if self.time is None or self.first is None or self.last is None:
            return ""
        scale = seconds_each(self.time)
        length_s = (self.last - self.first) * scale
        rate = f", {(self.rows - 1) / length_s:.4g} Hz" if length_s > 0 else ""
        return f"  {self.first * scale:.9g} … {self.last * scale:.9g} s ({length_s:.6g} s{rate})"
