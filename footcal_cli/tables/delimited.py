"""Text logs as tables: names and cells of CSV and its relatives, by the layout of the file."""

from __future__ import annotations

import csv
import io
import re
import warnings
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core.parameters import IntArray
from footcal_cli.errors import DataError
from footcal_cli.tables.carried import Carried, carried_names
from footcal_cli.tables.drawn import is_rule, undrawn, with_plain_numbers, with_whole_remarks
from footcal_cli.tables.reading import BLANKS, Layout
from footcal_cli.tables.textfiles import first_bytes, short, unreadable

if TYPE_CHECKING:  # imported where it is used: a refusal does not wait for it
    import pandas as pd

MOST_BYTES = 4 * 1024**3
"""Of a text log, unpacked."""
LONGEST_HEADER = 2**20
_ZEROS = 4
_AS_CSV = "export it as CSV (UTF-8) or Parquet, or run `footcal init` on it"


def text_names(path: Path, layout: Layout) -> list[str]:
    """Column names of a text log.

    Raises
    ------
    DataError
        Not text, or a header that cannot be read.
    """
    if layout.plain:
        return _csv_header(path)
    if layout.line:
        own = list(re.compile(layout.line).groupindex)
        return list(dict.fromkeys((*carried_names(layout.carried), *own)))
    return [*_own_names(_lines(path, layout), layout), *carried_names(layout.carried)]


def _own_names(found: _Lines, layout: Layout) -> list[str]:
    """Names of the fields of the rows."""
    if layout.names:
        return list(layout.names)
    if found.header is not None:
        return _named(_fields(found.header, layout))
    width = max((len(_fields(line, layout)) for line in found.rows[:50]), default=0)
    return [f"column_{i + 1}" for i in range(width)]


def text_table(path: Path, layout: Layout, texts: Collection[str]) -> tuple[pd.DataFrame, IntArray]:
    """All columns of a text log, and the line of every row, counted from 1.

    Parameters
    ----------
    path, layout
        The file and how it is laid out.
    texts
        Columns kept as strings whatever they look like.

    Raises
    ------
    DataError
        The file cannot be read to its end as its layout says.
    """
    if layout.plain:
        frame = frame_of(_with_plain_signs(_bytes(path)), path, texts)
        said = ~frame.isna().all(axis=1).to_numpy() | (frame.shape[1] == 1)  # no line of commas
        return frame[said].reset_index(drop=True), np.flatnonzero(said) + 2
    if layout.line:
        return _searched(path, layout)
    import pandas as pd

    found = _lines(path, layout)
    lines, numbers = found.rows, found.numbers
    if not lines:
        raise DataError("no rows", file=path, remedy="record the log again")
    names = _own_names(found, layout)
    widest, at = _widest(lines, layout)
    trailing = widest == len(names) + 1 and all(
        line.rstrip("\r\n").endswith(layout.separator) for line in lines
    )
    if widest > len(names) and not trailing and layout.separator != BLANKS:
        lines = with_whole_remarks(lines, layout.separator, len(names))
        widest, at = _widest(lines, layout)
    if widest > len(names) and not trailing:
        raise DataError(
            f"{widest} fields under a header of {len(names)}", file=path,
            row=f"line {numbers[-at]}", value=short(lines[-at].strip()),
            remedy="correct separator, decimal or names in [[files]]",
        )  # fmt: skip
    wanted = [*names, "\0trailing"] if trailing else names
    thousands = layout.thousands
    if not thousands.isascii():  # blanks of other widths
        lines = [re.sub(rf"(?<=\d){thousands}(?=\d{{3}}(?!\d))", "", line) for line in lines]
        thousands = ""
    try:
        frame = pd.read_csv(
            io.StringIO("".join(undrawn(x, layout.separator).rstrip("\r\n") + "\n" for x in lines)),
            sep=r"\s+" if layout.separator == BLANKS else layout.separator,
            decimal=layout.decimal, thousands=thousands or None, header=None,
            names=wanted, index_col=False, dtype=dict.fromkeys(texts, str),
            skipinitialspace=True, low_memory=False, skip_blank_lines=False,
        )  # fmt: skip
    except (pd.errors.ParserError, pd.errors.EmptyDataError, csv.Error) as error:
        raise unreadable(path, error) from None
    frame = frame[names]
    if found.carried:
        between = pd.DataFrame(found.carried, index=frame.index)
        frame = pd.concat([frame, _as_numbers(between, layout)], axis=1)
    return frame, np.array(numbers, dtype=np.int64)


def _widest(lines: Sequence[str], layout: Layout) -> tuple[int, int]:
    """Most fields of a line, and less the number of the first that has them."""
    return max((len(_fields(line, layout)), -i) for i, line in enumerate(lines))


def _with_plain_signs(content: bytes) -> bytes:
    """A text whose minus is that of mathematics, or stands behind its numbers, with plain ones."""
    if has_plain_signs(content[:LONGEST_HEADER]):
        return content
    try:
        return with_plain_numbers(content.decode("utf-8-sig")).encode()
    except UnicodeDecodeError:
        return content


def has_plain_signs(start: bytes) -> bool:
    """Whether the start of a text has its minus before its numbers, and exponents with E."""
    begun = start.decode("utf-8", errors="replace")
    return with_plain_numbers(begun) == begun


def before_power_was_lost(content: bytes) -> bytes:
    """A text without the zero bytes that a logger without power leaves at its end.

    The line that breaks off there goes too: its last number may lack digits.
    """
    kept = content.rstrip(b"\0")
    if len(content) - len(kept) < _ZEROS or b"\0" in kept:
        return content
    return kept[: kept.rfind(b"\n") + 1]


def _named(fields: Sequence[str]) -> list[str]:
    """Header fields as names: an empty one gets its number, one that repeats a count."""
    seen: dict[str, int] = {}
    names = []
    for i, raw in enumerate(fields):
        name = raw.strip() or f"column_{i + 1}"
        seen[name] = seen.get(name, 0) + 1
        names.append(name if seen[name] == 1 else f"{name}.{seen[name]}")
    while len(names) > 1 and not fields[len(names) - 1].strip():
        names.pop()  # separators at the end of the line
    return names


def _fields(line: str, layout: Layout) -> list[str]:
    line = undrawn(line, layout.separator)
    if layout.separator == BLANKS:
        return line.split()
    return next(csv.reader([line.strip("\r\n")], delimiter=layout.separator), [])


def decoded(path: Path, layout: Layout) -> str:
    """The text of a log in its encoding.

    Raises
    ------
    DataError
        Another encoding.
    """
    content = _bytes(path)
    encoding = "utf-8-sig" if layout.encoding.lower() in ("utf-8", "utf8") else layout.encoding
    try:
        return with_plain_numbers(content.decode(encoding))
    except UnicodeDecodeError as error:
        raise DataError(
            f"not {layout.encoding} text: byte 0x{content[error.start]:02x}", file=path,
            row=f"line {content.count(bytes([10]), 0, error.start) + 1}",
            remedy="give its encoding in [[files]]; `footcal init` guesses it",
        ) from None  # fmt: skip


@dataclass(frozen=True)
class _Lines:
    """Lines of rows, their numbers from 1, the header's line, and what holds for each row."""

    rows: list[str]
    numbers: list[int]
    header: str | None
    carried: list[dict[str, str | None]]


def _lines(path: Path, layout: Layout) -> _Lines:
    """The lines of a table, without remarks and what stands around it."""
    kept: list[str] = []
    numbers: list[int] = []
    carried: list[dict[str, str | None]] = []
    header: str | None = None
    above: set[str] = set()
    between = Carried(layout.carried)
    skip = layout.skip_rows
    below = layout.skip_below
    waits = layout.header
    lines = decoded(path, layout).splitlines()
    lines = upright(lines, layout.separator) if layout.turned else lines
    for number, line in enumerate(lines, start=1):
        if between.takes(line):
            continue
        if layout.comment and line.lstrip().startswith(layout.comment):
            continue
        if layout.until and kept and line.lstrip(" \t").startswith(layout.until):
            break
        if skip:
            skip -= 1
            above.add(line.strip())
        elif waits:
            if line.strip() and not is_rule(line):
                header, waits = line, False
                above.add(line.strip())
        elif below:
            below -= 1
        elif is_rule(line) or (line.strip() in above and re.search(r"[^\W\d]{2}", line)):
            continue  # or a header that stands there again
        elif line.strip(f"\r\n\t \f\x1a\0{layout.separator}"):
            kept.append(line)
            numbers.append(number)
            if between.some:
                carried.append(between.holds)
    return _Lines(kept, numbers, header, carried)


def upright(lines: Sequence[str], separator: str) -> list[str]:
    """Lines of a sheet that lies on its side, turned: its columns as lines."""
    layout = Layout(separator=separator)
    fields = [_fields(line, layout) for line in lines if line.strip(f" \t\r\n{separator}")]
    text = io.StringIO()
    csv.writer(text, delimiter=separator, lineterminator="\n").writerows(
        zip_longest(*fields, fillvalue="")
    )
    return text.getvalue().splitlines()


def _searched(path: Path, layout: Layout) -> tuple[pd.DataFrame, IntArray]:
    """Rows that a regular expression finds, with what was carried on from lines above."""
    import pandas as pd

    row = re.compile(layout.line)
    between = Carried(layout.carried)
    rows, numbers = [], []
    for number, line in enumerate(decoded(path, layout).splitlines(), start=1):
        found = row.search(line)
        if found is not None:
            rows.append({**between.holds, **found.groupdict()})
            numbers.append(number)
        else:
            between.takes(line)
    if not rows:
        raise DataError(
            "no line is a row", file=path, remedy="correct `line` in [[files]] of the recipe"
        )
    return _as_numbers(pd.DataFrame(rows), layout), np.array(numbers, dtype=np.int64)


def _as_numbers(frame: pd.DataFrame, layout: Layout) -> pd.DataFrame:
    """Texts that are numbers throughout, as numbers."""
    import pandas as pd

    for name in frame:
        words = frame[name]
        if layout.decimal == ",":
            words = words.str.replace(",", ".", regex=False)
        parsed = pd.to_numeric(words, errors="coerce")
        frame[name] = parsed if parsed.notna().equals(words.notna()) else frame[name]
    return frame


def _bytes(path: Path) -> bytes:
    """A text log's content, unpacked."""
    content = first_bytes(path, MOST_BYTES + 1)
    if len(content) > MOST_BYTES:
        raise DataError(
            f"more than {MOST_BYTES / 1024**3:.0f} GB of text", file=path,
            remedy="split it, or export it as Parquet",
        )  # fmt: skip
    return before_power_was_lost(content)


def _csv_header(path: Path) -> list[str]:
    start = before_power_was_lost(first_bytes(path, LONGEST_HEADER))
    end = start.find(b"\n")
    if end < 0 and len(start) == LONGEST_HEADER:
        raise DataError(
            "a first line of more than a megabyte", file=path, remedy="export it as CSV or Parquet"
        )
    if b"\0" in start or start[:2] in (b"\xff\xfe", b"\xfe\xff"):
        raise DataError(
            "not UTF-8 text (UTF-16, or a binary file)", file=path, remedy=_AS_CSV, foreign=True
        )
    try:
        text = start.decode("utf-8-sig", errors="strict" if end < 0 else "replace")
        if "\N{REPLACEMENT CHARACTER}" in text.partition("\n")[0]:
            raise UnicodeError
        return [_spoken(n) for n in next(csv.reader(io.StringIO(text, newline="")), [])]
    except UnicodeError:
        raise DataError(
            "not readable as UTF-8 text", file=path, remedy=_AS_CSV, foreign=True
        ) from None
    except csv.Error as error:
        raise DataError(
            f"the header cannot be read: {error}", file=path, remedy=_AS_CSV, foreign=True
        ) from None


def frame_of(content: bytes, path: Path, texts: Collection[str]) -> pd.DataFrame:
    """All columns of the text of a CSV file."""
    import pandas as pd

    _refuse_foreign_bytes(content, path)
    try:
        frame = _parsed(content, texts)
    except (pd.errors.ParserWarning, pd.errors.ParserError, pd.errors.EmptyDataError, csv.Error):
        frame = _parsed_again(content, path, texts)
    _refuse_cut_line(content, path)
    return frame.rename(columns=_spoken)


def _parsed(content: bytes, texts: Collection[str]) -> pd.DataFrame:
    import pandas as pd

    with warnings.catch_warnings():
        # a row with more fields than the header (a decimal comma?) would lose its tail
        warnings.simplefilter("error", pd.errors.ParserWarning)
        return pd.read_csv(
            # the whole text at once: a reader that Ctrl-C interrupts would say "truncated"
            io.BytesIO(content), dtype=dict.fromkeys(texts, str), encoding="utf-8-sig",
            skipinitialspace=True, low_memory=False, index_col=False,
        )  # fmt: skip


def _parsed_again(content: bytes, path: Path, texts: Collection[str]) -> pd.DataFrame:
    """A text that cannot be read as it is, with the remarks at the ends of its lines quoted."""
    import pandas as pd

    first, *others = content.decode("utf-8").split("\n")
    whole = with_whole_remarks(others, ",", first.count(",") + 1)
    try:
        return _parsed("\n".join([first, *whole]).encode(), texts)
    except pd.errors.ParserWarning:
        raise DataError(
            "a row has more fields than the header (a decimal comma?)", file=path,
            remedy="write decimal points, or one field per column", foreign=True,
        ) from None  # fmt: skip
    except (pd.errors.ParserError, pd.errors.EmptyDataError, csv.Error) as error:
        raise unreadable(path, error) from None


def _spoken(name: str) -> str:
    """A name on one line: a sheet's header may break it."""
    return " ".join(name.split()) if "\n" in name else name.strip()


def _refuse_foreign_bytes(content: bytes, path: Path) -> None:
    at = content.find(b"\0")
    problem = "a NUL byte" if at >= 0 else ""
    if at < 0:
        try:
            content.decode("utf-8")
        except UnicodeDecodeError as error:
            at = error.start
            problem = f"not UTF-8 text: byte 0x{content[at]:02x}"
    if problem:
        raise DataError(
            problem, file=path, row=f"line {content.count(bytes([10]), 0, at) + 1}",
            remedy=_AS_CSV, foreign=True,
        )  # fmt: skip


def _refuse_cut_line(content: bytes, path: Path) -> None:
    """Refuse a last line that ends before its last field."""
    last = content[content.rfind(b"\n") + 1 :]
    first = content[: content.find(b"\n")]
    if last.strip() and b'"' not in last + first and last.count(b",") < first.count(b","):
        raise DataError(
            "the last line is cut off", file=path, row=f"line {content.count(bytes([10])) + 1}",
            value=short(last.decode("utf-8")), remedy="copy the file again, or take the line out",
        )  # fmt: skip
