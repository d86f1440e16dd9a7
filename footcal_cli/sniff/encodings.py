"""Which encoding a text is in that is no UTF-8: by the words that it would have."""

from __future__ import annotations

import re
from contextlib import suppress

_CYRILLIC = re.compile(r"(?<![A-Za-z])(?:[А-ЯЁ]?[а-яё]{2,}|[А-ЯЁ]{2,})(?![A-Za-z])")
"""A word in Cyrillic letters alone, capitals at its beginning or throughout."""
_NEARLY_ALL, _LEAST, _MANY = 0.8, 4, 0.2
_CJK = re.compile(r"[\u3001-\u30ff\u4e00-\u9fff\uff01-\uff5e]")


def encoding_of(content: bytes) -> str:
    """Of Cyrillic, Chinese and Japanese their Windows' own; else ``latin-1`` or ``cp1252``.

    In Cyrillic whole words stand above 127, where other European languages have single letters
    among plain ones. Chinese has two such bytes for each character, and no single ones; Japanese
    begins most of its characters with bytes that western texts hardly have.
    """
    high = sum(byte > 127 for byte in content)
    cyrillic = sum(map(len, _CYRILLIC.findall(content.decode("cp1251", errors="ignore"))))
    if cyrillic >= max(_LEAST, _NEARLY_ALL * high):
        return "cp1251"
    with suppress(UnicodeDecodeError):
        if high >= _LEAST and 2 * len(_CJK.findall(content.decode("gb18030"))) == high:
            return "gb18030"
    low = sum(0x80 <= byte < 0xA0 for byte in content)
    if low > _MANY * high:
        with suppress(UnicodeDecodeError):
            words = [c for c in content.decode("shift_jis") if ord(c) > 127]
            if all(map(_CJK.match, words)):
                return "shift_jis"
    if low:
        with suppress(UnicodeDecodeError):
            content.decode("cp1252")
            return "cp1252"
    return "latin-1"
