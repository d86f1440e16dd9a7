"""Which encoding a text is in that is no UTF-8: by the words that it would have."""

from __future__ import annotations

import re
from contextlib import suppress

_CYRILLIC = re.compile(r"(?<![A-Za-z])(?:[А-ЯЁ]?[а-яё]{2,}|[А-ЯЁ]{2,})(?![A-Za-z])")
"""A word in Cyrillic letters alone, capitals at its beginning or throughout."""
_ALONE = re.compile(r"(?<![A-Za-zА-Яа-яЁё])[А-Яа-яЁё](?![A-Za-zА-Яа-яЁё])")
"""A letter by itself: a unit, as newtons are written, or a western one between blanks."""
_SIGNS = frozenset("°·±²³µ№×÷℃Ωμ")
"""What stands next to numbers in any language."""
_NEARLY_ALL, _LEAST, _MANY = 0.8, 4, 0.2
_CJK = re.compile(r"[\u3001-\u30ff\u4e00-\u9fff\uff01-\uff5e]")


def encoding_of(content: bytes) -> str:
    """Of Cyrillic, Chinese and Japanese their Windows' own; else ``latin-1`` or ``cp1252``.

    In Cyrillic whole words stand above 127, where other European languages have single letters
    among plain ones. Chinese has two such bytes for each character, and no single ones; Japanese
    begins most of its characters with bytes that western texts hardly have.
    """
    high = sum(byte > 127 for byte in content)
    text = content.decode("cp1251", errors="ignore")
    cyrillic = sum(map(len, _CYRILLIC.findall(text)))
    beside = len(_ALONE.findall(text)) + sum(sign in _SIGNS for sign in text)
    if cyrillic >= max(_LEAST, _NEARLY_ALL * (high - beside)):
        return "cp1251"
    with suppress(UnicodeDecodeError):
        words = _beyond_ascii(content.decode("gb18030"))
        # each of two bytes: single ones are letters of western languages
        if high >= _LEAST and 2 * len(words) == high and _all_cjk(words):
            return "gb18030"
    low = sum(0x80 <= byte < 0xA0 for byte in content)
    if low > _MANY * high:
        with suppress(UnicodeDecodeError):
            if _all_cjk(_beyond_ascii(content.decode("shift_jis"))):
                return "shift_jis"
    if low:
        with suppress(UnicodeDecodeError):
            content.decode("cp1252")
            return "cp1252"
    return "latin-1"


def _beyond_ascii(text: str) -> list[str]:
    return [letter for letter in text if ord(letter) > 127]


def _all_cjk(letters: list[str]) -> bool:
    """Whether letters are Chinese or Japanese, with signs of units between them."""
    words = [letter for letter in letters if letter not in _SIGNS]
    return bool(words) and all(map(_CJK.match, words))
