"""Lines of tables as programs draw them for people: rules, bars, TeX, exponents of Fortran.

Room: tables; asked by `delimited`, which reads such tables, and by `footcal_cli.sniff.rows`, which
guesses their layout.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from footcal_cli.tables.reading import BLANKS

TEX = "&"
"""The separator of LaTeX's tables; rows end with two backslashes."""
_BARS = str.maketrans(dict.fromkeys("|│┃║¦", " "))
_DRAWN = r"[\s|+:.'=_│┃║├┤┼╞╡╪╫┌┐└┘┬┴─━═╌╴╶-]*"
_RULE = re.compile(
    rf"{_DRAWN}(?:-{{3,}}|[─━═]{{2}}|={{3,}}){_DRAWN}|[\s|:+-]*\|[\s|:+-]*-[\s|:+-]*"
    rf"|\s*(?:```|~~~)\w*\s*|\s*\\[A-Za-z]+\b[^&]*|\s*\{{\|.*|\s*\|\}}\s*"
)
_ROW_END = re.compile(r"\\\\\s*(?:\\[A-Za-z]+\b[^&]*)?$")
_DIGITS = str.maketrans({
    **{chr(zero + i): str(i) for zero in (0x660, 0x6F0, 0x966, 0xFF10) for i in range(10)},
    "\N{MINUS SIGN}": "-",
    "\N{ARABIC DECIMAL SEPARATOR}": ".", "\N{ARABIC THOUSANDS SEPARATOR}": "",
})  # fmt: skip
"""Digits of Arabic, Persian, Devanagari, and those as wide as Chinese characters; a minus."""
_COLOURS = re.compile(r"\x1b\[[0-9;]*[A-Za-z]")
_MINUS_BEHIND = re.compile(r"(?m)(^[ ]*|[;,\t|][ ]*)(\d+(?:[.,]\d+)?)-(?=[ ]*(?:[;,\t|\r]|$))")
_BROKEN = re.compile(r'(?m)(?:^|(?<=[,;\t]))"[^"\n]{0,80}(?:\n[^"\n]{0,80}){1,4}"(?=[,;\t\r\n])')
_LOOKED_AT = 2**16
_EXPONENT = re.compile(r"(?<![\w.])([-+]?(?:\d+\.?\d*|\.\d+))[dD]([-+]\d{2,3})(?!\w)")


def is_rule(line: str) -> bool:
    r"""Whether a line is drawn around rows: ``----+---``, ``|---|``, ``\hline``, ``{|``, ``|}``."""
    return _RULE.fullmatch(line.rstrip("\r\n")) is not None


def undrawn(line: str, separator: str) -> str:
    """A row without what is drawn around its fields: bars between blanks, TeX's end of a row."""
    if separator == BLANKS:
        return line.translate(_BARS)
    return _ROW_END.sub("", line.rstrip()) if separator == TEX else line


def with_plain_numbers(text: str) -> str:
    """A text whose numbers have ASCII digits, and exponents of Fortran (``0.5D+01``) as E.

    Line breaks within quoted fields, as sheets have them in their headers, become blanks; a minus
    behind a number comes before it, and colours of a terminal are left out.
    """
    text = _COLOURS.sub("", text) if "\x1b" in text else text
    if _MINUS_BEHIND.search(text, 0, _LOOKED_AT):
        text = _MINUS_BEHIND.sub(r"\1-\2", text)
    if _BROKEN.search(text, 0, _LOOKED_AT):
        text = _BROKEN.sub(lambda field: " ".join(field[0].split()), text)
    if not text.isascii():
        text = text.translate(_DIGITS)
    some = any(sign in text for sign in ("D+", "D-", "d+", "d-"))
    return _EXPONENT.sub(r"\1E\2", text) if some else text


def with_whole_remarks(lines: Sequence[str], separator: str, width: int) -> list[str]:
    """Rows whose last field is a remark with separators in it, as people type: these are quoted.

    Only where that field holds words or nothing in all rows.

    >>> with_whole_remarks(["1,2.0,", "2,2.1,again, the cable hung"], ",", 3)
    ['1,2.0,', '2,2.1,"again, the cable hung"']
    """
    made = []
    for line in lines:
        bare = line.rstrip("\r\n")
        fields = bare.split(separator)
        if '"' in bare or width < 2:
            return list(lines)
        if len(fields) >= width and fields[width - 1].strip():
            if not re.search(r"[^\W\d_]{2,}", fields[width - 1]):
                return list(lines)
            if len(fields) > width:
                remark = separator.join(fields[width - 1 :])
                line = (
                    f'{separator.join(fields[: width - 1])}{separator}"{remark}"{line[len(bare) :]}'
                )
        made.append(line)
    return made
