"""LabVIEW measurement files of several segments, each with a header of its own, as one table.

The form: National Instruments, "Specification for the LabVIEW Measurement File (.lvm)".
Room: formats; opened by `footcal_cli.formats.detect`.
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

from footcal_cli.errors import DataError
from footcal_cli.formats.contract import ClockOf, Stream, with_unit
from footcal_cli.formats.records import table_of
from footcal_cli.tables.foreign import END_OF_HEADER

_LEAST = 2


def streams(path: Path, _clock: ClockOf) -> tuple[Stream, ...]:
    """The rows of all segments, with the number of the segment as their run.

    Raises
    ------
    DataError
        No segment has rows.
    """
    text = path.read_text(encoding="utf-8-sig", errors="replace")
    first, *segments = text.split(END_OF_HEADER)
    comma = "Decimal_Separator\t," in first or "Decimal_Separator," in first
    separator = "," if "Separator\tComma" in first or "Separator,Comma" in first else "\t"
    rows: list[dict[str, str]] = []
    for number, (above, below) in enumerate(pairwise(segments), start=1):
        said: dict[str, list[str]] = {}
        for line in reversed(above.splitlines()):
            word, *others = line.split(separator)
            said.setdefault(word, others)
        names, *table = below.strip("\r\n").splitlines() or [""]
        units = ["", *said.get("Y_Unit_Label", [])]
        called = [
            with_unit(name, units[i] if i < len(units) else "")
            for i, name in enumerate(names.strip("\r\n").split(separator)) if name != "Comment"
        ]  # fmt: skip
        for line in table:
            fields = [field.strip() for field in line.split(separator)]
            if not fields[0]:
                break
            numbers = [f.replace(",", ".") if comma else f for f in fields]
            rows.append({"run": str(number), **dict(zip(called, numbers, strict=False))})
    if len(rows) < _LEAST:
        raise DataError("no rows in any segment", file=path, remedy="export it again as one table")
    return (table_of(path.name.split(".")[0], "LabVIEW segments", rows),)
