"""Tables of web pages, as scales and converters with a page of their own show them.

Room: formats; opened by `footcal_cli.formats.detect`.
"""

from __future__ import annotations

from html.parser import HTMLParser
from pathlib import Path

from footcal_cli.errors import DataError
from footcal_cli.formats.contract import ClockOf, Stream
from footcal_cli.formats.records import table_of

_LEAST = 2


def streams(path: Path, _clock: ClockOf) -> tuple[Stream, ...]:
    """Every table with a row of names and two rows below it.

    Raises
    ------
    DataError
        No such table.
    """
    page = _Tables()
    page.feed(path.read_text(encoding="utf-8-sig", errors="replace"))
    stem, found = path.name.split(".")[0], []
    for number, rows in enumerate(page.tables):
        names, wide = rows[0] if rows else [], [row for row in rows[1:] if any(row)]
        alike = [dict(zip(names, row, strict=True)) for row in wide if len(row) == len(names)]
        if len(alike) >= _LEAST and all(names) and len({*names}) == len(names):
            name = f"{stem}_{number + 1}" if len(page.tables) > 1 else stem
            found.append(table_of(name, "table of a web page", alike))
    if not found:
        raise DataError(
            "a web page without a table of readings", file=path,
            remedy="copy what it shows into a text, its columns named in the first line",
        )  # fmt: skip
    return tuple(found)


class _Tables(HTMLParser):
    """Texts of all cells; of tables within tables, the inner rows stand apart."""

    def __init__(self) -> None:
        super().__init__()
        self.tables: list[list[list[str]]] = []
        self._open: list[list[list[str]]] = []
        self._inside = False

    def handle_starttag(self, tag: str, attrs: object) -> None:
        """A table, a row or a cell begins; end tags of the last two may be missing."""
        if tag == "table":
            self._open.append([])
            self.tables.append(self._open[-1])
        elif tag == "tr" and self._open:
            self._open[-1].append([])
        elif tag in ("td", "th") and self._open and self._open[-1]:
            self._open[-1][-1].append("")
        if tag in ("table", "tr", "td", "th", "script", "style"):
            self._inside = tag in ("td", "th")

    def handle_endtag(self, tag: str) -> None:
        """What began ends."""
        if tag == "table" and self._open:
            self._open.pop()
        if tag in ("td", "th", "tr", "table"):
            self._inside = False

    def handle_data(self, data: str) -> None:
        """Text of the open cell."""
        row = self._open[-1][-1] if self._open and self._open[-1] else []
        if self._inside and row:
            row[-1] = " ".join(f"{row[-1]} {data}".split())
