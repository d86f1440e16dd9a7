"""The layout of a text log, guessed from its lines."""

from __future__ import annotations

import csv
import gzip
import json
import re
import zlib
from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path

from footcal_cli.errors import DataError
from footcal_cli.sniff.freeform import carried_between, free_form
from footcal_cli.sniff.tokens import NOTHING, is_moment, is_number, number_signs, worth
from footcal_cli.sniff.units import looks_like_units
from footcal_cli.tables.delimited import before_power_was_lost
from footcal_cli.tables.foreign import READERS, is_of_documents
from footcal_cli.tables.reading import BLANKS, Layout
from footcal_cli.tables.textfiles import regular_file, unreadable

_MOST = 2**20
"""Bytes that are looked at."""
_PROGRAMS = {
    (".xlsx", ".xls", ".xlsm", ".ods"): "save the sheet as CSV",
    (".tdms", ".tdm"): "export it as CSV (DIAdem, LabVIEW, or npTDMS: tdmsinfo, as_dataframe)",
    (".ulg",): "run `ulog2csv` on it, which writes a CSV for each topic",
    (".pkl", ".pickle", ".feather"): "write it with DataFrame.to_csv",
    (".acq", ".adicht", ".dat", ".edf"): "export it as CSV from the program that recorded it",
}
"""Suffixes of binary files that footcal does not read, and what turns them into text."""
_COMMENTS = ("#", "%", "//", "!", ";", "'")
_SEPARATORS = (",", ";", "\t", "|", BLANKS)
_ALIKE = 0.7
"""Share of lines that must be alike for a layout to be taken."""
_SPARSE = 0.1
"""Share of rows with more empty cells than numbers from which a table is sparse."""
_CALLED = {",": "commas", ";": "semicolons", "\t": "tabs", "|": "bars", BLANKS: "blanks"}


@dataclass(frozen=True)
class TextGuess:
    """How a text log seems to be laid out.

    Parameters
    ----------
    layout
        The guess.
    units
        What a row of units says of each column; empty without one.
    said
        What was noticed, a short sentence each.
    above
        Lines above the rows.
    """

    layout: Layout
    units: tuple[str, ...] = ()
    said: tuple[str, ...] = ()
    above: tuple[str, ...] = ()


def guess_text(path: Path) -> TextGuess:
    """Guess encoding, separator, decimal sign, preamble, header and row of units.

    Raises
    ------
    DataError
        No text, or no rows that are alike.
    """
    text, encoding = _decoded(path)
    lines = text.splitlines()
    if len(text) > _MOST // 2 and len(lines) > 1:
        lines = lines[:-1]
    if not any(line.strip() for line in lines):
        raise DataError("the file is empty", file=path, remedy="record or export the log again")
    if _is_json(text):
        raise DataError(
            "JSON, not a table", file=path,
            remedy=f"run `footcal convert {path} --out {path.stem}.parquet`, then footcal init on "
            "what it writes",
        )  # fmt: skip
    if is_of_documents(text):
        raise DataError(
            "messages as `ros2 topic echo` prints them, not a table", file=path,
            remedy=f"run `footcal convert {path} --out {path.stem}.parquet`, then footcal init on "
            "what it writes",
        )  # fmt: skip
    said = [] if encoding == "utf-8" else [f"encoding {encoding}"]
    free = free_form(lines, encoding)
    if free is not None:
        return TextGuess(free, (), (*said, "no fields: values are found in each line by a pattern"))
    lines = [x for x in lines if "-" not in x or "|" not in x or x.strip("|-: \t")]  # Markdown's
    found = max(
        (_Body.of(lines, separator) for separator in _SEPARATORS), key=lambda body: body.score
    )
    if found.share < _ALIKE or found.numbers == 0:
        raise DataError(
            "no rows of numbers that are alike", file=path,
            remedy="export one table of numbers per file, its columns named in the first line",
        )  # fmt: skip
    guess = _laid_out(lines, found, encoding)
    until, last = _end(lines, found, guess.layout.comment)
    said += [f"the table ends above '{until}'"] if until else []
    layout = replace(guess.layout, thousands=found.thousands, until=until)
    carried = carried_between([x for x in lines if not found.is_row(x)])
    layout = replace(layout, carried=carried)
    said += ["lines between the rows say what holds below"] if carried else []
    if until and not guess.units and len(last) == found.width and looks_like_units(last):
        guess = replace(guess, units=tuple(last), said=(*guess.said, "units below the rows"))
    top = found.begins_at(lines)
    layout = _restarted(layout, lines, top)
    said += ["the header stands there again, left out"] if layout.comment in lines[:top] else []
    return TextGuess(layout, guess.units, (*said, *guess.said), tuple(lines[:top]))


def _restarted(layout: Layout, lines: list[str], top: int) -> Layout:
    """A log whose header stands between its rows again: lines like it are left out."""
    header = lines[top - 1] if top else ""
    if layout.comment or not layout.header or header.strip() not in map(str.strip, lines[top:]):
        return layout
    names = tuple(fields_of(header, layout.separator))
    return replace(layout, comment=header.strip(), header=False, names=names)


def _is_json(text: str) -> bool:
    """Whether a text begins with an object in JSON, alone or as the first of a list."""
    start = text.lstrip().removeprefix("[").lstrip()
    if not start.startswith("{"):
        return False
    try:
        json.JSONDecoder().raw_decode(start)
    except ValueError:
        return False
    return True


def _decoded(path: Path) -> tuple[str, str]:
    """The first part of a text and its encoding."""
    regular_file(path)
    opener = gzip.open if path.suffix.lower() == ".gz" else open
    try:
        with opener(path, "rb") as stream:
            content: bytes = stream.read(_MOST)
    except (OSError, EOFError, zlib.error) as error:
        raise unreadable(path, error) from None
    if content[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return content[: len(content) // 2 * 2].decode("utf-16", errors="ignore"), "utf-16"
    if content[:1] != b"\0":
        content = before_power_was_lost(content)
    if b"\0" in content:
        raise DataError("a binary file, not text", file=path, remedy=_opened_by(path))
    try:
        return content.decode("utf-8-sig"), "utf-8"
    except UnicodeDecodeError as error:
        if error.start > len(content) - 4 and len(content) == _MOST:
            return content.decode("utf-8-sig", errors="ignore"), "utf-8"
    encoding = "cp1252" if any(0x80 <= byte < 0xA0 for byte in content) else "latin-1"
    return content.decode(encoding, errors="replace"), encoding


def _opened_by(path: Path) -> str:
    """What makes a table of a binary file, by its suffix."""
    suffix = path.suffix.lower()
    if suffix in READERS:
        return (
            f"run `footcal convert {path} --out {path.stem}.parquet`, then footcal init on what "
            "it writes"
        )
    program = next((said for names, said in _PROGRAMS.items() if suffix in names), "")
    if program:
        return f"{program}, then footcal init on that"
    return (
        f"export it as CSV; footcal convert reads {' '.join(sorted(READERS))}, but no "
        f"'{suffix or path.name}'"
    )


def fields_of(line: str, separator: str) -> list[str]:
    """Fields of a line, stripped."""
    if separator == BLANKS:
        return line.split()
    return [f.strip() for f in next(csv.reader([line.strip("\r\n")], delimiter=separator), [])]


def _filled_fields(line: str, separator: str) -> list[str]:
    """Fields of a line up to the last that is not empty."""
    return fields_of(line.rstrip(separator), separator)


@dataclass(frozen=True)
class _Body:
    """The rows of a text under one separator.

    `share` of the lines have `width` fields; `numbers` of these hold numbers, in `numeric` columns;
    `sparse` where many rows lack half of them, as topics do that take turns.
    """

    separator: str
    decimal: str
    thousands: str
    width: int
    share: float
    numbers: float
    score: float
    numeric: tuple[int, ...]
    sparse: bool

    @classmethod
    def of(cls, lines: list[str], separator: str) -> _Body:
        written = [line for line in lines if line.strip()]
        tail = written[len(written) // 3 :][:400] if len(written) > 6 else written[-3:] or written
        tail = [line for line in tail if not line.lstrip().startswith(("#", "%", "//"))] or tail
        split = [_filled_fields(line, separator) for line in tail]
        width, alike = Counter(map(len, split)).most_common(1)[0]
        open_ended = [fields_of(line, separator) for line in tail]
        longer, more = Counter(map(len, open_ended)).most_common(1)[0]
        if more > alike or (more == alike and any(len(row) > width for row in split)):
            split, width = open_ended, longer  # cells at the end of rows may be empty
        rows = [row for row in split if len(row) == width]
        signs = number_signs([f for row in rows for f in row], separator)
        worths = [[worth(field, *signs) for field in row] for row in rows]
        share = len(rows) / len(split)
        numeric = tuple(
            i for i in range(width)
            if sum(is_number(row[i], *signs) or row[i] == "" for row in rows) > 0.8 * len(rows)
            and any(is_number(row[i], *signs) for row in rows)
        )  # fmt: skip
        moments = sum(
            sum(is_moment(row[i]) for row in rows) > 0.8 * len(rows) for i in range(width)
        )
        score = share * sum(map(sum, worths)) / len(rows)
        halves = [sum(not row[i] for i in numeric) * 2 > len(numeric) for row in rows]
        sparse = sum(halves) > _SPARSE * len(rows)
        return cls(separator, *signs, width, share, len(numeric) + moments, score, numeric, sparse)

    def begins_at(self, lines: list[str]) -> int:
        """Where the rows begin: a line above them may hold a number or two beside its words."""
        whole = (i for i, line in enumerate(lines) if self.is_row(line, whole=True))
        some = (i for i, line in enumerate(lines) if self.is_row(line))
        return next(whole, next(some, 0))

    def is_row(self, line: str, *, whole: bool = False) -> bool:
        """Whether a line is a row; `whole`: no word stands where numbers should."""
        fields = _filled_fields(line, self.separator)
        if len(fields) < self.width:
            fields = fields_of(line, self.separator)[: self.width]
        if len(fields) != self.width:
            return False
        if not self.numeric:
            return any(is_moment(field) for field in fields)
        good = [is_number(fields[i], self.decimal, self.thousands) for i in self.numeric]
        if whole:
            nothing = [fields[i].lower() in NOTHING for i in self.numeric]
            return any(good) and all(a or b for a, b in zip(good, nothing, strict=True))
        if self.sparse and any(good):
            return all(ok or not fields[i] for i, ok in zip(self.numeric, good, strict=True))
        return sum(good) >= max(1, (len(good) + 1) // 2)


def _laid_out(lines: list[str], body: _Body, encoding: str) -> TextGuess:
    """Header, preamble, units and comments around the rows."""
    first = body.begins_at(lines)
    comment = _comment(lines[first:], body)
    above = [(i, line) for i, line in enumerate(lines[:first]) if line.strip()]
    names: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    header_at: int | None = None
    candidates = [(i, _header_fields(line, body, comment)) for i, line in above]
    candidates = [(i, fields) for i, fields in candidates if fields]
    if candidates:
        header_at, fields = candidates.pop()
        if candidates and looks_like_units(fields):
            units = tuple(fields)
            header_at, fields = candidates.pop()
        units = units or _units_above([x for i, x in above if i < header_at], body)
        names = tuple(_qualified(fields, [x for i, x in above if i < header_at], body))
    said = [f"fields separated by {_CALLED[body.separator]}"] if body.width > 1 else []
    if body.decimal == ",":
        said.append("decimal commas")
    if body.thousands:
        said.append(f"'{body.thousands}' between thousands")
    if units:
        said.append("a row of units below the header")
    separator, decimal = body.separator, "," if body.decimal == "," else "."
    kept = [i for i in range(first) if not (comment and lines[i].lstrip().startswith(comment))]
    if header_at is None:
        said.append("no header")
        skip = len(kept)
        layout = Layout(separator, decimal, encoding, comment, skip, header=False)  # type: ignore[arg-type]
        return TextGuess(layout, (), tuple(said))
    own = fields_of(lines[header_at].rstrip(separator), separator)
    readable = header_at in kept and tuple(own) == names and len(set(own)) == len(own)
    readable &= all(name.strip() for name in own) and len(own) == body.width
    # the plain reader takes what follows the last separator for a column
    readable &= not lines[header_at].rstrip("\r\n").endswith(separator)
    if readable:
        skip = sum(i < header_at for i in kept)
        # blank lines between count as lines below the header
        below = sum(i > header_at for i in kept)
        layout = Layout(separator, decimal, encoding, comment, skip, skip_below=below)  # type: ignore[arg-type]
    else:
        names = _once(names)
        layout = Layout(separator, decimal, encoding, comment, len(kept), False, names)  # type: ignore[arg-type]
        said.append("names put together from the lines above the rows")
    if layout.skip_rows:
        said.append(f"{layout.skip_rows} lines above the header")
    return TextGuess(layout, units, tuple(said))


def _end(lines: list[str], body: _Body, comment: str) -> tuple[str, list[str]]:
    """What the line begins with above which the table ends, and its fields; empty if it goes on.

    A remark below the rows, or a second table: two lines that are no rows, or none after it.
    """
    first = body.begins_at(lines)
    written = [
        line for line in lines[first:]
        if line.strip(f" \t\r\n{body.separator}")
        and not (comment and line.lstrip().startswith(comment))
    ]  # fmt: skip
    rows = [body.is_row(line) for line in written]
    for at, line in enumerate(written):
        fields = fields_of(line, body.separator)
        word = fields[0] if fields else ""
        ends = not any(rows[at : at + 2]) if at + 1 < len(rows) else not rows[at]
        if not rows[at] and ends and re.match(r"[^\W\d]", word) and not is_number(word, "."):
            return word, fields
        if not rows[at] and not ends:
            break
    return "", []


def _comment(lines: list[str], body: _Body) -> str:
    """What lines between the rows begin with that are none."""
    others = [line.lstrip() for line in lines if line.strip() and not body.is_row(line)]
    for sign in _COMMENTS:
        if any(line.startswith(sign) for line in others):
            return sign
    return ""


def _header_fields(line: str, body: _Body, comment: str) -> list[str]:
    """Names in a line above the rows, empty where it is none."""
    plain = line.strip("\r\n")
    for sign in ("#", "%", "//", comment):
        if sign and plain.lstrip().startswith(sign):
            bare = plain.lstrip().removeprefix(sign).strip()
            fields = _split(bare, body)
            if fields and sign == "%" and " " not in plain[:2]:
                return _split(plain, body)  # rostopic's %time
            return fields
    return _split(plain, body)


def _split(line: str, body: _Body) -> list[str]:
    fields = fields_of(line.rstrip(body.separator), body.separator)
    if len(fields) == body.width - 1 and body.separator != BLANKS and body.width > 2:
        fields = fields_of(line, body.separator)
    if body.width < len(fields) <= body.width + 2 and body.separator != BLANKS:
        fields = fields[: body.width]  # rows without the comments that the header announces
    if len(fields) != body.width and body.separator == BLANKS:
        fields = [f.strip() for f in re.split(r"\t+|\s{2,}|,\s*|;\s*", line.strip())]
    if len(fields) != body.width:
        return []
    words = [f for f in fields if f and not is_number(f, body.decimal)]
    return fields if len(words) * 2 >= sum(bool(f) for f in fields) and words else []


def _units_above(above: list[str], body: _Body) -> tuple[str, ...]:
    """Units in a line that says so: ``Y_Unit_Label, Volts, Newtons``; empty without one."""
    for line in above:
        word, *others = fields_of(line.rstrip(body.separator), body.separator)[: body.width] or [""]
        said = re.search(r"(?i)(?:^|[\W_])(?:units?|einheit(?:en)?|unités?)(?:[\W_]|$)", word)
        if said and len(others) == body.width - 1 and looks_like_units(others):
            return ("", *others)
    return ()


def _qualified(fields: list[str], above: list[str], body: _Body) -> list[str]:
    """Names that stand there twice, after the groups in the rows above them (merged cells)."""
    for line in reversed(above):
        if len(set(fields)) == len(fields) or body.separator == BLANKS:
            break
        row = fields_of(line, body.separator)
        row = [*row, *[""] * (body.width - len(row))][: body.width]
        groups, last = [], ""
        for word in row:
            last = word or last
            groups.append(last)
        if len(set(filter(None, groups))) > 1 and not any(
            is_number(word, body.decimal) for word in row
        ):
            fields = [f"{g} {f}".strip() for g, f in zip(groups, fields, strict=True)]
    return fields


def _once(names: tuple[str, ...]) -> tuple[str, ...]:
    """Names made different, none empty."""
    seen: Counter[str] = Counter()
    made = []
    for i, name in enumerate(names):
        plain = name.strip() or f"column_{i + 1}"
        seen[plain] += 1
        made.append(plain if seen[plain] == 1 else f"{plain}.{seen[plain]}")
    return tuple(made)
