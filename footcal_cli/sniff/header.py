"""Names and units of columns, from the lines above the rows of a text."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence

from footcal_cli.sniff.names import STATISTICS, name_guess
from footcal_cli.sniff.rows import Body, fields_of, filled_fields
from footcal_cli.sniff.tokens import is_number
from footcal_cli.sniff.units import known_unit, looks_like_units, split_unit
from footcal_cli.tables.drawn import undrawn
from footcal_cli.tables.reading import BLANKS

_TYPE = re.compile(
    r"(?i)<?(?:u?int|float)(?:8|16|32|64)?\??>?|<?(?:dbl|chr|num|lgl)>|double|string|object|bool"
)
"""What data frames say of their columns below the names."""
_AT_THE_END = re.compile(r"\s+[\[(][^\[\]()]*[\])]\s*$")
_NAMES = ("name", "names", "channel", "channelname", "channel name", "kanal", "kanalname", "signal")
_UNITS = ("unit", "units", "einheit", "einheiten", "unité", "unitstring")
_SAYS = re.compile(r"([A-Za-z]+):\s+\S")
_PROCESSED = {"Smp", "Avg", "Max", "Min", "Std", "Tot", "Med", "RSq", "WVc", "TMx", "TMn"}
"""What Campbell's loggers made of their samples, below names and units."""


def header_fields(line: str, body: Body, comment: str) -> list[str]:
    """Names in a line above the rows, empty where it is none; units in brackets may end it."""
    return _fields(line, body, comment) or _fields(_AT_THE_END.sub("", line), body, comment)


def _fields(line: str, body: Body, comment: str) -> list[str]:
    plain = _as_rows_are(line.strip("\r\n"), body)
    for sign in ("#", "%", "//", comment):
        if sign and plain.lstrip().startswith(sign):
            bare = plain.lstrip().removeprefix(sign).strip()
            fields = _split(bare, body)
            if fields and sign == "%" and " " not in plain[:2]:
                return _split(plain, body)  # rostopic's %time
            return fields
    return _split(plain, body)


def _as_rows_are(line: str, body: Body) -> str:
    """A wiki's header with the bars of its rows: ``||a||b||``, ``! a !! b``."""
    if body.separator != "|":
        return line
    doubled = re.sub(r"^\s*!", "|", line).replace("!!", "||")
    either = (doubled, doubled.replace("||", "|"))
    return next((x for x in either if len(filled_fields(x, "|")) == body.width), line)


def _split(line: str, body: Body) -> list[str]:
    fields = fields_of(line.rstrip(body.separator), body.separator)
    named = len(fields) > 1 and 2 * len(fields) >= body.width  # else it is a title
    if named and len(fields) < body.width and body.separator != BLANKS:
        whole = fields_of(line, body.separator)
        fields = whole if len(whole) == body.width else fields
    if body.width < len(fields) <= body.width + 2 and body.separator != BLANKS:
        fields = fields[: body.width]  # rows without the comments that the header announces
    numbers = any(is_number(field, body.decimal) for field in fields)
    if len(fields) == body.width - 1 and body.counted and not numbers:
        # R, pandas and Stata number rows under no name
        fields = ["row", *(f.strip('"') if body.separator == BLANKS else f for f in fields)]
    if len(fields) != body.width and body.separator == BLANKS:
        plain = undrawn(line, BLANKS).strip()
        fields = [f.strip() for f in re.split(r"\t+|\s{2,}|,\s*|;\s*", plain)]
    if len(fields) != body.width:
        return []
    words = [f for f in fields if f and not is_number(f, body.decimal)]
    if "Smp" in words and {*words} <= _PROCESSED:
        return []
    if words and all(_TYPE.fullmatch(word) for word in words if word != "row"):
        return []
    return fields if len(words) * 2 >= sum(bool(f) for f in fields) and words else []


def with_units_said(candidates: Sequence[tuple[int, list[str]]]) -> tuple[int, list[str]]:
    """The line of names among lines above the rows: the last, or one that alone says units.

    Recorders write types and serial numbers of their channels between the names and the rows.
    """
    last = candidates[-1]
    said = [sum(split_unit(field)[1] is not None for field in fields) for _, fields in candidates]
    most = max(said)
    if said[-1] == 0 and most * 2 >= len(last[1]):
        return candidates[len(said) - 1 - said[::-1].index(most)]
    return last


def parted(
    candidates: Sequence[tuple[int, list[str]]],
) -> tuple[list[tuple[int, list[str]]], tuple[str, ...]]:
    """Lines of names among lines above the rows, and the units that one of the others says.

    Below the names may stand units and remarks; ``Unit: N`` and ``Interp: linear`` in every field
    are what a program says of its columns.
    """
    kept: list[tuple[int, list[str]]] = []
    units: tuple[str, ...] = ()
    for at, fields in candidates:
        said = [found[1].lower() if (found := _SAYS.match(f)) else "" for f in fields if f]
        if kept and len(said) > 1 and len({*said}) == 1 and said[0]:
            if said[0] in ("unit", "units", "einheit"):
                units = tuple(field.partition(":")[2].strip() for field in fields)
            continue
        kept.append((at, fields))
    for at in range(len(kept) - 1, 0, -1) if not units else ():
        said = [field for field in kept[at][1] if field.strip("[]()- 1")]
        if said and all(known_unit(field) for field in said):
            # of blocks of columns the title stands above the units, the names below
            titled = not _are_quantities(kept[at - 1][1])
            below = [one for one in kept[at + 1 :] if titled and _are_quantities(one[1])]
            return kept[:at] + below, tuple(kept[at][1])
    return kept, units


def _are_quantities(fields: Sequence[str]) -> bool:
    """Whether each field of a row, of two or more, names something that is measured."""
    said = [field for field in fields if field.strip()]
    return len(said) > 1 and all(name_guess(f).quantity not in ("unknown", "other") for f in said)


def names_otherwise(above: Sequence[tuple[int, str]], body: Body) -> tuple[int, list[str]] | None:
    """Names that stand above the rows in another way than these, and their line; None without.

    By another separator (Igor), or the first alone below all others, as pandas prints an index.
    """
    if not above:
        return None
    at, last = above[-1]
    if body.separator == BLANKS and len(above) > 1 and len(last.split()) == 1:
        others = above[-2][1].split()
        if len(others) == body.width - 1 and not any(is_number(x, body.decimal) for x in others):
            return at, [last.strip(), *others]
    for at, line in reversed(above):
        for separator in (",", ";", "\t"):
            fields = [field.strip() for field in line.split(separator)]
            if separator == body.separator or len(fields) + body.indented != body.width:
                continue
            known = [name_guess(field).quantity != "unknown" for field in fields]
            if any(is_number(field, ".") for field in fields) or not all(fields):
                continue
            if len(fields) > 1 and sum(known) * 2 >= len(known):
                return at, [*[""] * body.indented, *fields]
    return None


def properties(
    above: Sequence[tuple[int, str]], body: Body
) -> tuple[int, list[str], tuple[str, ...]] | None:
    """Names and units of lines that say first what they are of (``Name;…``, ``Unit;…``), as DIAdem.

    The rows begin with an empty field then. None where no such line has names.
    """
    said = {}
    for at, line in above if body.indented else ():
        word, *others = fields_of(line, body.separator)
        if len(others) == body.width - 1:
            said[word.strip(": ").lower()] = (at, others)
    named = next((said[word] for word in _NAMES if word in said), None)
    if named is None:
        return None
    _, units = next((said[word] for word in _UNITS if word in said), (0, []))
    return named[0], ["", *named[1]], ("", *units) if units else ()


def name_of_the_index(fields: Sequence[str], below: Sequence[str], body: Body) -> list[str]:
    """Names whose first, if it is empty, stands alone in a line below them, as pandas writes it."""
    alone = [fields_of(line, body.separator) for line in below if body.separator != BLANKS]
    named = [row[0] for row in alone if len(row) == body.width and row[0] and not any(row[1:])]
    return [named[0], *fields[1:]] if named and not fields[0] else list(fields)


def units_above(above: list[str], body: Body) -> tuple[str, ...]:
    """Units in a line that says so: ``Y_Unit_Label, Volts, Newtons``; empty without one."""
    for line in above:
        word, *others = fields_of(line.rstrip(body.separator), body.separator)[: body.width] or [""]
        said = re.search(r"(?i)(?:^|[\W_])(?:units?|einheit(?:en)?|unités?)(?:[\W_]|$)", word)
        if said and len(others) == body.width - 1 and looks_like_units(others):
            return ("", *others)
    return ()


def qualified(fields: list[str], above: list[str], body: Body) -> list[str]:
    """Names that stand there twice, after the groups in the rows above them (merged cells)."""
    for line in reversed(above):
        different = len(set(fields)) == len(fields) and not STATISTICS & {f.lower() for f in fields}
        if different or body.separator == BLANKS:
            break
        row = fields_of(line, body.separator)
        row = [*row, *[""] * (body.width - len(row))][: body.width]
        groups, last = [], ""
        for word in row:
            last = word or last
            groups.append(last)
        if len(set(filter(None, groups))) > (len(set(fields)) < len(fields)) and not any(
            is_number(word, body.decimal) for word in row
        ):
            fields = [f"{g} {f}".strip() for g, f in zip(groups, fields, strict=True)]
    return fields


def once(names: tuple[str, ...]) -> tuple[str, ...]:
    """Names made different, none empty."""
    seen: Counter[str] = Counter()
    made = []
    for i, name in enumerate(names):
        plain = name.strip() or f"column_{i + 1}"
        seen[plain] += 1
        made.append(plain if seen[plain] == 1 else f"{plain}.{seen[plain]}")
    return tuple(made)
