"""Weights said in words: ``1 lb + 2.5 lb``, ``2 x 500 g``, ``empty``.

Room: sniff; asked for texts of columns and for lines without fields.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

from footcal_cli.sniff.tokens import IN_WORDS
from footcal_cli.sniff.units import MASSES, WEIGHTS, known_unit

_JOINED = re.compile(r"\s*(?:\+|&|and|plus|und|et|y|e)\s*", re.IGNORECASE)
_TOLERANCE = re.compile(r"\s*(?:±|\+/-|\+-)\s*\d[\d.,]*\s*[A-Za-zµ%]*$")
_JOINTS = re.compile(r"(?<=\w)\s*([x×*+&])\s*(?=\d)", re.IGNORECASE)
_TIMES = re.compile(r"(?<![\w.,])(\d{1,2})\s*[x×*]\s*$", re.IGNORECASE)
DASHES = frozenset({"-", "--", "---", "\u2013", "\u2014"})
"""What people write where nothing lay on a cell, or where they wrote nothing down."""
_NEGATIVE = re.compile(r"-[\d.,]")
_NOTHING = re.compile(
    r"(?:it'?s |all |is |still |again )*(?:empty|nothing|no (?:load|weights?)|none|zero|unloaded|"
    r"tare|tara|off|bare|removed?|abgenommen|entfernt|enlevée?|retirée?|leer|unbelastet|ohne last|"
    r"vide|à vide|vuoto|scarico|vac[ií]o|vazio)"
    r"(?: again| on it| on| all| everything)?",
    re.IGNORECASE,
)
_DECORATED = re.compile(r"^[\W_]+|[\W_]+$")


def says_nothing(text: str) -> bool:
    """Whether a text says that nothing lies there: ``empty``, ``--- TARE ---``."""
    return _NOTHING.fullmatch(_DECORATED.sub("", text)) is not None


def or_nothing(expression: str, remarks: Iterable[str]) -> str:
    """An expression for lines that say a load, which finds those that say that none lies there too.

    Parameters
    ----------
    expression
        With groups as `footcal_cli.tables.carried` reads them, the load first.
    remarks
        Lines that are no rows: ``empty``, or the words before a load with such a word behind them.
    """
    group = re.search(r"\(\?P<(?:added_)?(load\w*)>", expression)
    if group is None:
        return expression
    before = _compiled(expression[: group.start()]) or re.compile("^")
    others = [line.strip() for line in remarks if not re.search(expression, line)]
    rest = [line[found.end() :] for line in others if (found := before.match(line))]
    said = {_DECORATED.sub("", text) for text in (*others, *rest) if says_nothing(text)}
    if not said:
        return expression
    words = "|".join(map(re.escape, sorted(said, key=lambda word: (-len(word), word))))
    start = rf"(?:^|{before.pattern})[\W_]*" if before.pattern != "^" else r"^[\W_]*"
    return rf"{expression}|{start}(?P<zero_{group[1]}>{words})[\W_]*$"


def _compiled(expression: str) -> re.Pattern[str] | None:
    """A part of an expression; None where it is none by itself."""
    try:
        return re.compile(expression)
    except re.error:
        return None


def said_weight(text: str) -> list[tuple[float, str]] | None:
    """Weights that a text adds up, with their units; empty for none put on, None for other words.

    Between two weights stands what joins them: of ``5 kg cell, 1 kg`` the sum is none.
    """
    text = text.strip(" \t.,;:!*#")
    text = _TOLERANCE.sub("", text)
    if text in DASHES:
        return []
    text = text if _NEGATIVE.match(text) else text.strip("- ")
    if _NOTHING.fullmatch(text) or text == "0":
        return []
    text = _JOINTS.sub(r" \1 ", text)
    found = list(IN_WORDS.finditer(text))
    said, end = [], 0
    for at, one in enumerate(found):
        before = text[end : one.start()]
        times = _TIMES.search(before)
        plain = before[: times.start()] if times else before
        if re.search(r"\d", plain) or (at and not _JOINED.fullmatch(plain)):
            return None
        unit = known_unit(one[2])
        if unit is None or one[1].startswith("-"):
            return None
        said.append((float(one[1].replace(",", ".")) * (int(times[1]) if times else 1), unit))
        end = one.end()
    return said if said and not re.search(r"\d", text[end:]) else None


def sums_of(texts: Iterable[str]) -> tuple[dict[str, float], str] | None:
    """The load that each text says, in one unit, and the unit; None where a text says none.

    In the unit of all, or in kg or N where they differ.
    """
    said = {text: said_weight(text) for text in texts}
    units = {unit for parts in said.values() for _, unit in parts or ()}
    if not units or any(parts is None for parts in said.values()):
        return None
    sizes = next((s for s in (MASSES, WEIGHTS) if units <= s.keys()), None)
    if len(units) > 1 and sizes is None:
        return None
    unit = next(iter(units)) if len(units) == 1 else "kg" if sizes is MASSES else "N"
    return {
        text: sum(n if u == unit else n * (sizes or {})[u] for n, u in parts or ())
        for text, parts in said.items()
    }, unit
