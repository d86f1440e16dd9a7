"""The layout of a text log, guessed from its lines."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from pathlib import Path

from footcal_cli.errors import DataError
from footcal_cli.sniff.encodings import encoding_of
from footcal_cli.sniff.ends import end, ends, far_end, once_named, refuse_said_below
from footcal_cli.sniff.freeform import carried_between, free_form
from footcal_cli.sniff.header import (
    header_fields,
    name_of_the_index,
    names_otherwise,
    once,
    parted,
    properties,
    qualified,
    units_above,
    with_units_said,
)
from footcal_cli.sniff.names import are_names
from footcal_cli.sniff.rows import Body, best_body, fields_of, on_its_side
from footcal_cli.sniff.sections import refuse_frames, sections
from footcal_cli.sniff.units import looks_like_units
from footcal_cli.tables.delimited import before_power_was_lost, upright
from footcal_cli.tables.drawn import TEX, is_rule, with_plain_numbers
from footcal_cli.tables.foreign import (
    READERS,
    is_of_cards,
    is_of_documents,
    is_one_message,
    kind_of_records,
)
from footcal_cli.tables.reading import BLANKS, Layout
from footcal_cli.tables.textfiles import first_bytes, regular_file
from footcal_cli.tables.workbooks import is_workbook, other_sheets

_MOST = 2**20
"""Bytes that are looked at."""
_PROGRAMS = {
    (".tdms", ".tdm"): "export it as CSV (DIAdem, LabVIEW, or npTDMS: tdmsinfo, as_dataframe)",
    (".ulg",): "run `ulog2csv` on it, which writes a CSV for each topic",
    (".pkl", ".pickle", ".feather"): "write it with DataFrame.to_csv",
    (".acq", ".adicht", ".dat", ".edf"): "export it as CSV from the program that recorded it",
}
"""Suffixes of binary files that footcal does not read, and what turns them into text."""
_COMMENTS = ("#", "%", "//", "!", ";", "'")
_SEPARATORS = (",", ";", "\t", "|", TEX, BLANKS)
_ALIKE = 0.7
"""Share of lines that must be alike for a layout to be taken."""
_FRAME = re.compile(r"\b\w*can\d*\s+[0-9A-Fa-f]{3,8}(?:#|\s+\[\d\])|^[tTrR][0-9A-F]{4,}$")
"""A frame of a bus as candump or a serial adapter (slcan) writes it."""
_FACTOR = re.compile(r"\s*1\.0e[+-]\d+\s*\*\s*")
_COMPOUND = re.compile(r"\d+\s*(?:lbs?|st|kg)\.?\s+\d+(?:\.\d+)?\s*(?:oz|lbs?|g)\b")
_PAIR = re.compile(r"\d\s*(?:kg|g|N|lbs?|oz|lbf|kgf)\s*(?:->|→|=>|:|=)\s*[-+]?\d")
"""``200 g -> 8130000``."""
_FRACTION = re.compile(r"(?<![\d/.-])(?:\d+/\d+|\d*\s?[½¼¾⅓⅔⅛⅜⅝⅞])\s*(?:lbs?|oz|kg|g)\b")
_ABOVE = 40
_LEAST_TABLE, _LEAST_WIDE = 6, 3
"""Rows and columns of a second table in a text."""
_CALLED = {
    ",": "commas",
    ";": "semicolons",
    "\t": "tabs",
    "|": "bars",
    TEX: "ampersands",
    BLANKS: "blanks",
}


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
    lines = with_plain_numbers(text).splitlines()
    if len(text) > _MOST // 2 and len(lines) > 1:
        lines = lines[:-1]
    if not any(line.strip() for line in lines):
        raise DataError("the file is empty", file=path, remedy="record or export the log again")
    if is_of_documents(text):
        raise _to_be_converted("messages as `ros2 topic echo` prints them", path)
    if is_one_message(text):
        raise DataError(
            "one message as `ros2 topic echo` prints it: one reading determines nothing", file=path,
            remedy="log for longer (ros2 topic echo --csv TOPIC > log.csv), the sensor under "
            "several known weights or its tool in a dozen directions",
        )  # fmt: skip
    if records := kind_of_records(text):
        raise _to_be_converted(f"records in {records}", path)
    begun = lines[:_ABOVE]
    rows = [line for line in begun if not line.lstrip().startswith(_COMMENTS)]
    if mixed := [pair[0] for line in rows if (pair := _COMPOUND.search(line))]:
        raise DataError(
            f"'{mixed[-1]}': two units in one value", file=path,
            remedy="write it as one number in one unit, named in the column (0.5 lb for 0 lb 8 oz)",
            example=("load_kg,counts", "0,8212638", "0.2268,8141214"),
        )  # fmt: skip
    if parts := [part[0] for line in rows if (part := _FRACTION.search(line))]:
        raise DataError(
            f"'{parts[-1]}': a fraction is no number here", file=path,
            remedy="write it with decimals (1.25 lb for 1 1/4 lb)",
            example=("load_lb,counts", "0,8212638", "1.25,8141214"),
        )  # fmt: skip
    several = [line.strip() for line in rows if len(_PAIR.findall(line)) > 1]
    if len(several) > 1:
        raise DataError(
            f"'{several[0]}': several weights and their readings in one line", file=path,
            remedy="write each in a line of its own, with the cell, the weight and its reading",
            example=("cell,load_g,counts", "fl,0,8212638", "fl,500,8141214"),
        )  # fmt: skip
    factor = next((line.strip() for line in lines[:_ABOVE] if _FACTOR.fullmatch(line)), "")
    if factor:
        raise DataError(
            f"a matrix as MATLAB shows it: all its numbers are to be taken '{factor}'", file=path,
            remedy="write it with writematrix(cal, 'cal.csv'), or set `format long g` before",
            example=("load_n,counts", "0,300", "10,802"),
        )  # fmt: skip
    said = [] if encoding == "utf-8" else [f"encoding {encoding}"]
    if is_workbook(path) and (others := other_sheets(path)):
        said.append(
            f"its fullest sheet; left out: {', '.join(others)} (save each as CSV to use it)"
        )
    free = free_form(lines, encoding)
    if free is not None:
        _refuse_two_tables(path, lines, free)
        refuse_said_below(path, lines, re.compile(free.line).search, free.carried)
        return TextGuess(free, (), (*said, "no fields: values are found in each line by a pattern"))
    side = on_its_side(lines)
    lines = upright(lines, side) if side else lines
    said += ["the sheet lies on its side"] if side else []
    found = best_body(lines, [side] if side else _SEPARATORS)
    if found.share < _ALIKE or found.numbers == 0:
        if is_of_cards(text):
            raise _to_be_converted("a record on several lines", path)
        raise DataError(
            "no rows of numbers that are alike", file=path,
            remedy=_written_by_machines(lines)
            or "export one table of numbers per file, its columns named in the first line",
        )  # fmt: skip
    refuse_frames(path, lines, found)
    carried = carried_between([x for x in lines if not found.is_row(x)]) or sections(lines, found)
    between = [x for x in lines if not (carried and re.search(carried, x))]
    guess = _laid_out(between, found, encoding)
    layout = replace(guess.layout, carried=carried)
    if carried and all(re.search(carried, x) for x in lines if _a_comment(x, layout)):
        layout = replace(layout, comment="")  # those lines are read; others may be the header again
    until, last = end(once_named(between, found), found, guess.layout.comment)
    refuse_said_below(path, lines, found.is_row, carried)
    said += [ends(until, between, found)] if until else []
    if not until and not carried and len(text) > _MOST // 2:
        until, below = far_end(path, encoding, _MOST, found)
        lost = f", {below} rows below it are not read" * bool(below)
        said += [f"the table ends above '{until}'{lost}"] if until else []
    layout = replace(layout, thousands=found.thousands, until=until)
    said += ["lines between the rows say what holds below"] if carried else []
    if until and not guess.units and len(last) == found.width and looks_like_units(last):
        guess = replace(guess, units=tuple(last), said=(*guess.said, "units below the rows"))
    top = found.begins_at(between)
    layout = replace(_restarted(layout, between, top), turned=bool(side))
    again = bool(layout.comment) and layout.comment in map(str.strip, between[:top])
    said += ["the header stands there again, left out"] if again else []
    above = tuple(lines[: found.begins_at(lines)])
    return TextGuess(layout, guess.units, (*said, *guess.said), above)


def _a_comment(line: str, layout: Layout) -> bool:
    return bool(layout.comment) and line.lstrip().startswith(layout.comment)


def _restarted(layout: Layout, lines: list[str], top: int) -> Layout:
    """A log whose header, or a line that says a run begins, stands between its rows again."""
    header = lines[top - 1].strip() if top and not is_rule(lines[top - 1]) else ""
    if layout.comment or not header or header not in map(str.strip, lines[top:]):
        return layout
    if layout.header:
        names = tuple(fields_of(header, layout.separator))
        return replace(layout, comment=header, header=False, names=names)
    counted = sum(line.lstrip().startswith(header) for line in lines[:top])
    return replace(layout, comment=header, skip_rows=max(0, layout.skip_rows - counted))


def _refuse_two_tables(path: Path, lines: list[str], layout: Layout) -> None:
    """Refuse a text of which a pattern reads one table, where another has a row for each of its.

    Raises
    ------
    DataError
        It is one.
    """
    if not layout.line or layout.carried:
        return
    others = [x for x in lines if x.strip() and not is_rule(x) and not re.search(layout.line, x)]
    rows = sum(bool(re.search(layout.line, x)) for x in lines)
    if rows < _LEAST_TABLE or len(others) < rows:
        return
    body = best_body(others, _SEPARATORS)
    if sum(body.is_row(x, whole=True) for x in others) == rows and body.width >= _LEAST_WIDE:
        raise DataError(
            f"two tables in one file, {rows} rows each", file=path,
            remedy="write them side by side, a row for each: what was felt (fx … tz, or readings) "
            "and what goes with it (loads, or the attitude: qx qy qz qw, or r11 … r33)",
        )  # fmt: skip


def _written_by_machines(lines: list[str]) -> str:
    """What makes a table of messages whose bytes only a description of them explains."""
    written = [line for line in lines if line.strip()]
    frames = sum(bool(_FRAME.search(line)) for line in written)
    if frames < _ALIKE * len(written):
        return ""
    return (
        "frames of a bus: decode them with the description of its messages (a DBC file: cantools, "
        "python-can) into one table of numbers, its columns named in the first line"
    )


def _to_be_converted(kind: str, path: Path) -> DataError:
    return DataError(
        f"{kind}, not a table", file=path,
        remedy=f"run `footcal convert {path} --out {path.stem}.parquet`, then footcal init on "
        "what it writes",
    )  # fmt: skip


def _decoded(path: Path) -> tuple[str, str]:
    """The first part of a text and its encoding."""
    regular_file(path)
    content = first_bytes(path, _MOST)
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
    encoding = encoding_of(content)
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


def _laid_out(lines: list[str], body: Body, encoding: str) -> TextGuess:
    """Header, preamble, units and comments around the rows."""
    first = body.begins_at(lines)
    comment = _comment(lines[first:], body)
    above = [
        (i, line) for i, line in enumerate(lines[:first]) if line.strip() and not is_rule(line)
    ]
    names: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    header_at: int | None = None
    candidates = [(i, header_fields(line, body, comment)) for i, line in above]
    candidates, units = parted([(i, fields) for i, fields in candidates if fields])
    if keyed := properties(above, body):
        header_at, fields, units = keyed
        names = tuple(fields)
    elif not candidates and (otherwise := names_otherwise(above, body)) is not None:
        header_at, found = otherwise
        names = tuple(found)
    elif candidates:
        header_at, fields = candidates.pop()
        if candidates and not units and looks_like_units(fields) and not are_names(fields):
            units = tuple(fields)
            header_at, fields = candidates.pop()
        elif candidates and not units:
            header_at, fields = with_units_said([*candidates, (header_at, fields)])
        units = units or units_above([x for i, x in above if i < header_at], body)
        fields = name_of_the_index(fields, lines[header_at + 1 : first], body)
        names = tuple(qualified(fields, [x for i, x in above if i < header_at], body))
    said = [f"fields separated by {_CALLED[body.separator]}"] if body.width > 1 else []
    if body.decimal == ",":
        said.append("decimal commas")
    if body.thousands:
        said.append(f"'{body.thousands}' between thousands")
    if units:
        said.append("a row of units below the header")
    separator, decimal = body.separator, body.decimal
    kept = [i for i in range(first) if not (comment and lines[i].lstrip().startswith(comment))]
    if header_at is None:
        said.append("no header")
        skip = len(kept)
        layout = Layout(separator, decimal, encoding, comment, skip, header=False)
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
        layout = Layout(separator, decimal, encoding, comment, skip, skip_below=below)
    else:
        names = once(names)
        layout = Layout(separator, decimal, encoding, comment, len(kept), False, names)
        said.append("names put together from the lines above the rows")
    if layout.skip_rows:
        said.append(f"{layout.skip_rows} line{'s' * (layout.skip_rows > 1)} above the header")
    return TextGuess(layout, units, tuple(said))


def _comment(lines: list[str], body: Body) -> str:
    """What lines between the rows begin with that are none."""
    others = [line.lstrip() for line in lines if line.strip() and not body.is_row(line)]
    for sign in _COMMENTS:
        if any(line.startswith(sign) for line in others):
            return sign
    return ""
