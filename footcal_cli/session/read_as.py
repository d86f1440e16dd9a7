"""How the columns of logs were read, for run.json, report and terminal."""

from __future__ import annotations

from collections.abc import Mapping

from footcal_cli.records.results import ParametersRecord, ReadColumnRecord
from footcal_cli.tables.table import ReadColumn

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


def in_units_of_readings(
    record: ParametersRecord, read_as: Mapping[str, Mapping[str, ReadColumnRecord]]
) -> ParametersRecord:
    """The calibration with the units that its readings were in: N per volt for a voltage."""
    units = {
        name.removesuffix("counts").removesuffix("_"): column.canonical_unit
        for columns in read_as.values()
        for name, column in columns.items()
        if name.endswith("counts") and column.canonical_unit not in ("", "count")
    }
    if not units:
        return record
    changed = {}
    for name, parameter in record.parameters.items():
        unit = units.get(name.rpartition(".")[0], units.get(""))
        if unit is not None and "count" in parameter.unit:
            parameter = parameter.model_copy(update={"unit": parameter.unit.replace("count", unit)})
        changed[name] = parameter
    return record.model_copy(update={"parameters": changed})


def _both(one: Span, other: Span) -> Span:
    if one is None or other is None:
        return one or other
    return min(one[0], other[0]), max(one[1], other[1])
