"""How the columns of logs were read, for run.json, report and terminal."""

from __future__ import annotations

from footcal_cli.records.results import ReadColumnRecord
from footcal_cli.tables import ReadColumn

Span = tuple[float, float] | None


def record_of(column: ReadColumn, earlier: ReadColumnRecord | None) -> ReadColumnRecord:
    """The record of a column; `earlier` is that of an earlier piece of the same log."""
    written, read = column.as_written, column.as_read
    if earlier is not None:
        written, read = _both(written, earlier.as_written), _both(read, earlier.as_read)
    return ReadColumnRecord(
        name=column.name,
        source=column.source,
        unit=column.unit,
        canonical_unit=column.canonical_unit,
        as_written=written,
        as_read=read,
    )


def _both(one: Span, other: Span) -> Span:
    if one is None or other is None:
        return one or other
    return min(one[0], other[0]), max(one[1], other[1])
