"""Logs that footcal reads as they are (CSV, Parquet): passed through, so that all can be joined."""

from __future__ import annotations

from pathlib import Path

from footcal_cli.formats.arrays import stream_of
from footcal_cli.formats.contract import Clock, Stream
from footcal_cli.tables import read_all


def streams(path: Path, _clock: Clock) -> tuple[Stream, ...]:
    """The one table of the file under its own names.

    Raises
    ------
    DataError
        Empty, truncated, no header, or rows of another width.
    """
    kind = "Parquet" if path.suffix.lower() in {".parquet", ".pq"} else "CSV"
    return (stream_of(path.name.split(".")[0], kind, read_all(path)),)
