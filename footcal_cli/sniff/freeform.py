"""Logs without fields, such as a serial monitor's: one value per line between words."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import replace

from footcal_cli.sniff.said_weights import or_nothing, said_weight, sums_of
from footcal_cli.sniff.sides import orientation_in
from footcal_cli.sniff.tokens import SIDES
from footcal_cli.sniff.vocabulary import COUNTED
from footcal_cli.tables.reading import Layout

_NUMBER = r"[+-]?(?:\d+\.\d+|\d+)(?:[eE][+-]?\d+)?"
_STAMP = r"(?:\d{4}-\d\d-\d\d[ T])?\d\d:\d\d:\d\d(?:[.,]\d+)?"
_LABEL = r"[A-Za-z_]\w*"
_PIECE = re.compile(
    rf"(?P<stamp>{_STAMP})|(?<![\w.])(?P<number>{_NUMBER})(?!\w*\d)|(?<=\w=)(?P<label>{_LABEL})"
)
_NUMBERED_WORDS = re.compile(rf"{_PIECE.pattern}|(?<![\w.])(?P<word>[A-Za-z]+\d+)(?!\w)")
"""Of a sensor that is named with a number, as ``LC3``."""
_NUMBERED = re.compile(r"[A-Za-z]\d")
_SIGNS = {"number": "\x01", "stamp": "\x02"}
_LEAST = 0.4
_FEW = 2
"""Numbers in a row that may stand without words when loads were typed between the rows."""
_BOUND = re.compile(r"[A-Za-z)\]]['\"]?\s*[:=]|->|→|[A-Za-z]['\"]\s*,\s*\x01")
"""What binds a word to a value: not a table's separator."""
_BRACKETED = re.compile(r"[(\[{]\s*\x01(?:\s*[,;]?\s*\x01){1,23}\s*[)\]}][,;]?")
"""A row of numbers in brackets, as programs print their lists."""
_LEAST_OF_A_LIST = 6
_KEY = re.compile(r"([A-Za-z_][\w.]*)\s*[=:]\s*[\x01\x03]")
_KEYED = re.compile(r"[A-Za-z_][\w.]*\s*[=:]\s*\x01")
"""A number with its name before it: ``fx=0.12``."""
_MOST_KEYED = 40
_FIELD = {
    sign: re.compile(rf"(?:\[(?:[^\[\]]|\[[^\[\]]*\])*\]|\"[^\"]*\"|[^{sign}\[\]\"])+")
    for sign in (",", ";", "\t")
}
"""A field of a row with lists in brackets or quotes."""
_MOST_BESIDE = 4
"""Numbers in a line that says a load: the time before it, say."""
_BINDS = r"\s*(?::|=|->|→)+\s*"
_SAID = re.compile(rf"(\S[^:=→]*?){_BINDS}{_NUMBER}(?:\s*[A-Za-z]+)?")
_LEAST_SAID = 3
"""Different loads before readings."""
_LOAD_GROUP = re.compile(rf"\(\?P<load(?:_\w+)?>{re.escape(_NUMBER)}\)(?:(?:\\s[*+])?([A-Za-z]+))?")
"""The group of a load in an expression, and the unit behind it."""
_UNITS = {"kg", "g", "N", "lb", "mg", "kN", "lbs", "oz", "mN"}
_PUT_ON = r"added?|adding|plus|zugelegt|dazu|hinzu|ajout[eé]\w*|añadid\w*|aggiunt\w*|another"
_TAKEN_OFF = (
    r"removed?|removing|minus|took off|taken off|entfernt|abgenommen|weggenommen|enlev[eé]\w*|"
    r"retir[eé]\w*|quitad\w*|tolt\w*"
)
_HEAVY = re.compile(r"weight|load|mass|gewicht|last|poids|peso|known|put|add|tare|empty|leer", re.I)


def free_form(lines: list[str], encoding: str) -> Layout | None:
    """A layout of lines that say the same with other numbers, None where there are none.

    Two shapes of line may alternate: readings, and the loads that hold from there on.
    """
    written = [line.strip() for line in lines if line.strip()]
    shaped = [_shape(line) for line in written]
    shapes = Counter(shaped)
    counted = Counter(
        _shape(line, _NUMBERED_WORDS) if _NUMBERED.search(line) else shape
        for line, shape in zip(written, shaped, strict=True)
    )
    if max(counted.values(), default=0) > max(shapes.values(), default=0):
        shapes = counted  # lines of several sensors, each with its name
    ranked = [shape for shape, _ in shapes.most_common(12) if "\x01" in shape]
    if not ranked:
        return None
    # a list below each remark: as many of the one as of the other
    row = max(ranked, key=lambda s: (shapes[s], bool(_BRACKETED.fullmatch(s))))
    count = shapes[row]
    said = _said_before(written)
    if said and sum(bool(re.match(said, line)) for line in written) > max(count, _LEAST_SAID):
        return Layout(encoding=encoding, line=said)
    most = count if _BRACKETED.fullmatch(row) else count - 1
    typed = [s for s in ranked if s != row and _load_of(s) is not None and shapes[s] <= most]
    if count < 3 or count + sum(shapes[s] for s in typed) < _LEAST * len(written):
        return None
    listed = _BRACKETED.search(row) and row.count("\x01") >= _LEAST_OF_A_LIST
    if listed or _BRACKETED.fullmatch(row):
        expression = _expression(row, "column")
        if _BRACKETED.fullmatch(row):
            # an array within another has brackets more at both ends
            named = _named_above(written, row, expression)
            above = _expression(typed[0], "load") if typed else ""
            return Layout(encoding=encoding, line=rf"^[\s\[(]*{named[1:]}", carried=above)
        return Layout(encoding=encoding, line=_named_by_header(written, row, expression))
    if any(sign in row for sign in (",\x01", ";\x01", "\t\x01")) and not _BOUND.search(row):
        return None
    few = len(re.findall("[\x01\x02]", row)) <= _FEW
    if not (_BOUND.search(row) or (typed and few)):
        return None
    numbers = row.count("\x01")
    keyed = len(_KEYED.findall(row)) >= numbers - 1
    if numbers > _MOST_BESIDE and not (keyed and numbers <= _MOST_KEYED):
        return None
    expression = _expression(row, "reading")
    if numbers > _MOST_BESIDE:
        expression = _renamed(expression, _KEY.findall(row))
    layout = Layout(encoding=encoding, line=expression)
    if typed:
        remarks = [line for line in written if _shape(line) != row]
        between = moved_between(remarks) or _any_of(typed)
        layout = replace(layout, carried=or_nothing(between, remarks))
    return layout


def _any_of(shapes: Sequence[str]) -> str:
    """An expression for lines of several shapes that say a load, each in its own unit."""
    first, *others = (_expression(shape, "load") for shape in shapes)
    parts = [_LOAD_GROUP.split(each, maxsplit=1) for each in (first, *others)]
    units = list(dict.fromkeys(unit for _, unit, _ in parts))
    if not others or None in units:
        return first
    before, after = (
        "|".join(dict.fromkeys(part[i].removesuffix(r"(?!\w)") for part in parts)) for i in (0, 2)
    )
    unit = "|".join(sorted(units, key=len, reverse=True))
    return rf"(?:{before})(?P<load>{_NUMBER}\s*(?:{unit}))(?!\w)(?:{after})"


def _said_before(written: list[str]) -> str:
    """An expression for lines that say a load in words before a reading; empty without.

    ``empty: 8347750``, ``1 lb + 2.5 lb: 8241003``: such lines are of several shapes.
    """
    found = [
        m for line in written if (m := _SAID.fullmatch(line)) and said_weight(m[1]) is not None
    ]
    words = list(dict.fromkeys(m[1] for m in found))
    if len(words) < _LEAST_SAID or sums_of(words) is None or len(found) < _LEAST * len(written):
        return ""
    called = "|".join(map(re.escape, sorted(words, key=len, reverse=True)))
    return rf"^(?P<load>{called}){_BINDS}(?P<reading>{_NUMBER})(?!\w)"


def _renamed(expression: str, names: Sequence[str]) -> str:
    """An expression whose groups have other names, in their order; as it was where one is none."""
    plain = [re.sub(r"\W+", "_", name).strip("_") for name in names]
    groups = re.findall(r"\(\?P<(\w+)>", expression)
    called = [new or old for old, new in zip(groups, plain, strict=False)] + groups[len(plain) :]
    if len({*called}) < len(called) or not all(name.isidentifier() for name in called):
        return expression
    new = iter(called)
    return re.sub(r"\(\?P<\w+>", lambda _: f"(?P<{next(new)}>", expression)


def _named_by_header(written: list[str], row: str, expression: str) -> str:
    """An expression for rows with lists in them, named as the line above the first of them says."""
    at = next(i for i, line in enumerate(written) if _shape(line) == row)
    for sign in ",;\t":
        fields = [f for f in _FIELD[sign].findall(row) if f]
        names = [name.strip().strip('"') for name in written[at - 1].split(sign)] if at else []
        if len(names) == len(fields) > 1:
            counts = [len(re.findall("[\x01\x02\x03]", field)) for field in fields]
            if 1 not in counts:
                continue  # lists alone: their numbers say what they hold
            each = [
                [name] if n == 1 else [f"{name}_{i}" for i in range(1, n + 1)]
                for name, n in zip(names, counts, strict=True)
            ]
            return _renamed(expression, [name for own in each for name in own])
    return expression


def _named_above(written: list[str], row: str, expression: str) -> str:
    """An expression for rows in brackets with the names that a remark above them gives."""
    at = next(i for i, line in enumerate(written) if _shape(line) == row)
    for line in written[max(at - 2, 0) : at]:
        words = re.split(r"[,;\t]", line.strip("#%/ "))
        names = [re.sub(r"\W+", "_", word).strip("_") for word in words]
        good = all(name.isidentifier() for name in names) and len({*names}) == len(names)
        if good and len(names) == row.count("\x01"):
            for i, name in enumerate(names, 1):
                expression = expression.replace(f"(?P<column_{i}>", f"(?P<{name}>")
            return expression
    return expression


def moved_between(remarks: Iterable[str]) -> str:
    """A regular expression for lines that say what was put on top or taken off; empty without.

    All name one unit. A sign before each number (``+500 g``, ``-500 g``) says the same.
    """
    parts: dict[str, str] = {}
    for unit in sorted(_UNITS, key=len, reverse=True):
        number = rf"(?P<{{}}_load_{unit.lower()}>{{}}\d+(?:[.,]\d+)?)\s?{unit}\b"
        signed = rf"^[\s#%;/!'*>]*{number.format('added', '[+-]')}"
        parts[unit] = "|".join(
            rf"^[^\d\n]*\b(?i:{words})\b[^\d\n+-]*?{number.format(way, '')}"
            for way, words in (("added", _PUT_ON), ("removed", _TAKEN_OFF))
        )
        for expression in (parts[unit], signed):
            if sum(bool(re.search(expression, line)) for line in remarks) > 1:
                return expression
    return ""


def carried_between(remarks: list[str]) -> str:
    """A regular expression for lines between rows that say a load or which way a sensor hangs.

    Parameters
    ----------
    remarks
        The lines of a table that are no rows. Empty where they say no such thing.
    """
    if moved := moved_between(remarks):
        return or_nothing(moved, remarks)
    sign = r"^[\s#%;/!'*>-]*"
    unit = "|".join(sorted(_UNITS, key=len, reverse=True))
    weighed = re.compile(
        rf"{sign}(?:[^\d\n]*?[\s:=])?(?P<load>\d+(?:[.,]\d+)?\s?(?:{unit}))[\s#%*=>-]*$"
    )
    named = re.compile(
        rf"{sign}[^\d\n]*?(?i:{_HEAVY.pattern})[^\d\n]*?(?P<load>\d+(?:[.,]\d+)?)\s*$"
    )
    for expression in (weighed, named):
        loads = {found["load"] for line in remarks if (found := expression.search(line))}
        if len(loads) > 1:
            return or_nothing(expression.pattern, remarks)
    turned = re.compile(r"^\s*[#%;/!'*>]+\s*(?P<orientation>.*\S)\s*$")
    words = [found["orientation"] for line in remarks if (found := turned.search(line))]
    axes = [orientation_in(word) for word in words]
    first = next((i for i, axis in enumerate(axes) if axis), len(axes))
    sides = set(axes[first:])
    return turned.pattern if len(sides) >= SIDES and None not in sides else ""


def _shape(line: str, pieces: re.Pattern[str] = _PIECE) -> str:
    """A line with its numbers, stamps and words behind ``=`` as one control character each."""
    return pieces.sub(lambda found: _SIGNS.get(found.lastgroup or "", "\x03"), line)


def _load_of(shape: str) -> int | None:
    """Which number of a shape is a load, counted from 0; None where none is.

    It is the one with a unit, or the only one, behind a word for weights.
    """
    if "\x03" in shape:
        return None
    after = re.findall(r"\x01(?:\s*([A-Za-z]+))?", shape)
    weighed = [i for i, unit in enumerate(after) if unit in _UNITS]
    if len(weighed) == 1 and len(after) <= _MOST_BESIDE:
        return weighed[0]
    return 0 if len(after) == 1 and _HEAVY.search(shape) else None


def _expression(shape: str, called: str) -> str:
    """A regular expression for a shape; groups are named after the words before them."""
    made = "^"
    names: Counter[str] = Counter()
    pieces = re.split(r"(\x01|\x02|\x03)", shape)
    load = _load_of(shape) if called == "load" else None
    numbers, listed = 0, ""
    for at, piece in enumerate(pieces):
        if piece == "\x01":
            numbers += 1
            if load is not None and numbers - 1 != load:
                made += rf"(?:{_NUMBER})"
                continue
        elif called == "column":
            listed = _list_named(piece, listed)
        if piece == "\x03":
            name = _name(_before(pieces, at)[-1:], "label")
            names[name] += 1
            made += rf"(?P<{_numbered(name, names)}>{_LABEL})"
            continue
        if piece == "\x02" and called == "load":
            made += rf"(?:{_STAMP})"
        elif piece == "\x02":
            names["time"] += 1
            made += rf"(?P<{_numbered('time', names)}>{_STAMP})"
        elif piece == "\x01":
            name = _name(made_words, called) if (made_words := _before(pieces, at)) else called
            unit = re.match(r"\s*([A-Za-z]+)\b", pieces[at + 1]) if at + 1 < len(pieces) else None
            if unit and unit[1] in _UNITS:
                name = f"{name}_{unit[1].lower()}"
            name = (listed or called) if called == "column" else name
            names[name] += 1
            named = f"{name}_{names[name]}" if called == "column" else _numbered(name, names)
            made += rf"(?P<{named}>{_NUMBER})"
        else:
            blank = r"\s*" if piece.strip() else r"\s+"
            made += blank.join(re.escape(part) for part in re.split(r"\s+", piece))
    # a number at the end is no part of a word: `250g` is no reading of 250
    return f"{made}(?!\\w)" if shape.endswith("\x01") else made


def _list_named(piece: str, before: str) -> str:
    """Name of the list that numbers behind a piece of a line stand in; empty for none.

    ``pose=[…]`` has one, and ``p[…]``, as poses are written in URScript.
    """
    opened = re.search(r"([A-Za-z]\w*)?\s*[:=]?\s*[(\[{]\s*$", piece)
    if opened:
        word = (opened[1] or "").lower()
        return "pose" if word == "p" else word if len(word) > 2 else ""
    return "" if re.search(r"[)\]}]", piece) else before


def _numbered(name: str, names: Counter[str]) -> str:
    return name if names[name] == 1 else f"{name}_{names[name]}"


def _before(pieces: list[str], at: int) -> list[str]:
    """Words just before a number."""
    return re.findall(r"[A-Za-z][A-Za-z0-9]*", pieces[at - 1] if at else "")


def _name(words: list[str], called: str) -> str:
    if not words:  # no letter of Latin stands before it
        return called
    if called == "load":
        return f"load_{words[-1].lower()}" if words[-1] in _UNITS else called
    if not words:
        return called
    words = words[-1:] if words[-1].lower() in (*COUNTED, "channel") else words[-2:]
    name = "_".join(words).lower()
    return name if name.isidentifier() else called
