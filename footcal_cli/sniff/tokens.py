"""What one cell of a text file looks like: a number, a date, a word, or two fields run together."""

from __future__ import annotations

import re
from typing import Literal

Decimal = Literal[".", ","]
POINT = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
COMMA = re.compile(r"[+-]?(?:\d+,\d+|\d+)(?:[eE][+-]?\d+)?")
_COMMA_ONLY = re.compile(r"[+-]?\d+,\d+(?:[eE][+-]?\d+)?")
_POINT_ONLY = re.compile(r"[+-]?\d*\.\d+(?:[eE][+-]?\d+)?")
_GROUPED = re.compile(r"[+-]?\d{1,3}(?:([.,' _\u00a0\u202f])\d{3})(?:\1\d{3})*((?!\1)[.,]\d+)?")
_TIME_OF_DAY = r"\d{1,2}:\d\d(?::\d\d(?:[.,]\d+)?)?(?: ?[AP]M)?"
_MONTH = r"(?i:jan|feb|mar|apr|may|jun|jul|aug|sep|oct|nov|dec)[a-z]*"
DAY = re.compile(
    r"\d{4}[-/.]\d\d?[-/.]\d\d?|\d\d?[./-]\d\d?[./-]\d{2,4}"
    rf"|\d\d?[- /]{_MONTH}[- /]\d{{4}}|\d{{4}}-{_MONTH}-\d\d?"
)
_DATE = re.compile(
    rf"(?:{DAY.pattern})(?:[T _]{_TIME_OF_DAY})?(?: ?(?:Z|UTC|GMT|[+-]\d\d(?::?\d\d)?))?"
)
_TIME = re.compile(_TIME_OF_DAY)
_WITH_UNIT = re.compile(
    r"([+-]?(?:\d{1,3}(?:[,.' \u00a0\u202f]\d{3})+(?:[.,]\d+)?|\d+[.,]?\d*|[.,]\d+)"
    r"(?:[eE][+-]?\d+)?)\s*([A-Za-zµ%°]{1,6})"
)
FRACTION = re.compile(r"([+-]?\d+)\s*/\s*(\d{3,})")
"""A reading beside its full scale: ``2048/4095``."""
_WORD = re.compile(r"[^\d;\t|,][^;\t|,]*")
PLUS_MINUS = re.compile(r"([-+]?\d+(?:[.,]\d+)?)\s*(?:±|\+/-|\+-)\s*\d+(?:[.,]\d+)?")
"""A mean with its scatter."""
_WITHIN = re.compile(
    r"\d+(?:[.,]\d+)?\s*[A-Za-zµ]{1,3}\s*(?:±|\+/-|\+-)\s*\d+(?:[.,]\d+)?\s*[A-Za-zµ%]{0,3}"
)
"""A weight with its tolerance: ``500 g ± 0.1 g``."""
SIDES = 3
"""Sides on which a sensor hangs, that determine its weight and offsets."""
IN_WORDS = re.compile(
    r"(?<![\w.+-])(?<!\d,)([-+]?\d+(?:[.,]\d+)?)\s*(kg|g|mg|N|kN|mN|lb|lbs|lbf|oz|kgf|gf)(?!\w)"
)
"""A weight with its unit among words."""
SUM_OF_WEIGHTS = re.compile(
    r"(?:\d{1,2}\s*[x×*]\s*)?{0}(?:\s*(?:\+|&|and|plus|und|et)\s*(?:\d{1,2}\s*[x×*]\s*)?{0})*".replace(
        "{0}", r"\d+(?:[.,]\d+)?\s*(?:kg|g|mg|N|kN|mN|lb|lbs|lbf|oz|kgf|gf)"
    )
)
"""Weights that lie there together: ``1 lb + 2.5 lb``, ``2 x 500 g``."""
HEXADECIMAL = re.compile(r"0[xX][0-9A-Fa-f]{1,12}")
NOTHING = {"", "nan", "na", "n/a", "null", "none", "-nan", "inf", "-inf", "-", "--", "#n/a",
           "#div/0!", "#value!", "#ref!", "#num!", "#name?", "#null!"}  # fmt: skip


def is_number(text: str, decimal: str, thousands: str = "") -> bool:
    """Whether a cell is a number with that decimal sign, in groups of three digits if so."""
    if thousands and thousands in text:
        found = _GROUPED.fullmatch(text)
        if found is None or found[1] != thousands:
            return False
        text = text.replace(thousands, "")
    if text[:2] in ("0x", "0X"):
        return bool(HEXADECIMAL.fullmatch(text))
    return bool((POINT if decimal == "." else COMMA).fullmatch(text))


def is_moment(text: str) -> bool:
    """Whether a cell is a date or a time of day."""
    return bool(_DATE.fullmatch(text) or _TIME.fullmatch(text))


def with_unit(text: str) -> tuple[str, str] | None:
    """Number and unit of a cell such as ``0.5 kg`` or ``8,388,123 cts``."""
    text = text.strip()
    if not text or not (text[-1].isalpha() or text[-1] in "%°"):  # most cells are numbers
        return None
    found = _WITH_UNIT.fullmatch(text)
    return (found[1], found[2]) if found else None


def worth(text: str, decimal: str, thousands: str = "") -> float:
    """How well a cell stands as one field: numbers 1, words a little, fields run together −1."""
    if text.lower() in NOTHING:
        return 0.0
    if is_number(text, decimal, thousands) or is_moment(text):
        return 1.0
    if PLUS_MINUS.fullmatch(text) or _WITHIN.fullmatch(text):
        return 1.0
    if with_unit(text) or FRACTION.fullmatch(text) or SUM_OF_WEIGHTS.fullmatch(text):
        return 0.7
    return 0.1 if _WORD.fullmatch(text) else -1.0


def number_signs(texts: list[str], separator: str) -> tuple[Decimal, str]:
    """The decimal sign of fields, and the sign between groups of thousands, empty for none.

    Two of a sign in one number are between groups, or one before the other sign, or one that is
    neither point nor comma; so is one that always has three digits after it where other numbers
    have the other sign. One sign alone (``8.388``) is the decimal one, but in a text that is itself
    separated by commas.
    """
    texts = [pair[0] if (pair := with_unit(text)) else text for text in texts]
    texts = [
        found[1] if ("±" in text or "+" in text) and (found := PLUS_MINUS.fullmatch(text)) else text
        for text in texts
    ]
    grouped = [found for text in texts if (found := _GROUPED.fullmatch(text))]
    twice = {
        found[1] for found in grouped
        if found[2] or found[0].count(found[1]) > 1 or found[1] not in ".,"
    }  # fmt: skip
    commas = [text for text in texts if "," in text and _COMMA_ONLY.fullmatch(text)]
    points = [text for text in texts if "." in text and _POINT_ONLY.fullmatch(text)]
    whole = {sign: _all_grouped(alone) for sign, alone in ((",", commas), (".", points))}
    if len(twice) == 1:
        sign = twice.pop()
        return ("," if sign == "." or (sign != "," and len(commas) > len(points)) else "."), sign
    if separator == ",":
        return ".", "," if whole[","] else ""
    if commas and points and whole[","] != whole["."]:
        return (".", ",") if whole[","] else (",", ".")
    return ("," if len(commas) > len(points) else "."), ""


def _all_grouped(texts: list[str]) -> bool:
    """Whether all of some numbers can be groups of thousands; ``0,500`` cannot."""
    found = [_GROUPED.fullmatch(text) for text in texts]
    return bool(texts) and all(f and not f[0].lstrip("+-").startswith("0") for f in found)


def date_format(texts: list[str]) -> str | None:
    """``strptime`` format of dates that are not ISO 8601, None where no common one fits."""
    from datetime import datetime

    dates = ("%d.%m.%Y", "%Y/%m/%d", "%Y-%m-%d", "%Y.%m.%d", "%m/%d/%Y", "%d/%m/%Y", "%d-%m-%Y",
             "%d.%m.%y", "%d-%b-%Y", "%d %b %Y", "%d %B %Y", "%d/%b/%Y", "%Y-%b-%d",
             "")  # fmt: skip
    times = ("%H:%M:%S.%f", "%H:%M:%S,%f", "%H:%M:%S", "%I:%M:%S %p", "%I:%M:%S.%f %p", "%H:%M")
    for date in dates:
        for time in times:
            for between in (" ", "T", "_") if date else ("",):
                form = f"{date}{between}{time}"
                try:
                    for text in texts:
                        datetime.strptime(text, form)
                except ValueError:
                    continue
                return form
    return None
