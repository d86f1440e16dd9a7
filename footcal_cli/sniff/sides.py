"""Which axis points along gravity, by words such as ``hang_plus_x``, ``-z up`` or ``nose down``.

Room: sniff; asked for names of orientations.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from footcal_cli.core.parameters import FloatArray

_UP = (
    "up|upwards?|top|oben|hoch|auf|aufwärts|haut|arriba|su|sopra|alto|cima|boven|omhoog|upp|uppåt|"
    "ylös|ylos|yukar[ıi]|gór[aęy]|gora|nahoru|fel|вверх|上"
)
_DOWN = (
    "down|downwards?|unten|runter|ab|abwärts|bas|abajo|giu|giù|sotto|basso|baixo|beneden|omlaag|"
    "ned|nedåt|alas|aşağ[ıi]|asagi|dół|dol|dolů|dolu|вниз|下"
)
_FILLED = (
    r"(?:(?:axis|achse|eje|axe|asse|is|points?|pointing|nach|zeigt|hacia|vers|verso|para)[ _-]*)*"
)
"""What may stand between an axis and the way it points: ``x points up``, ``z hacia arriba``."""
_SIGNED = re.compile(
    r"(?:(?:^|[^a-z])(?P<word>plus|minus|pos|neg|positive|negative)[ _]*"
    r"|(?:^|[^a-z0-9])(?P<sign>[+-])[ _]*|(?:^|[^a-z]))"
    rf"(?P<axis>[xyz])(?:[ _]*(?P<before>[+-])(?=[ _]))?"
    rf"(?:[ _-]*{_FILLED}(?P<way>{_UP}|{_DOWN})(?=[^a-z]|$)"
    r"|[ _]*(?P<after>plus|minus|pos|neg|positive|negative|[+-])(?=[^a-z]|$)|(?=[^a-z]|$))"
)
"""An axis with its sign before or after it, and whether it points up or down."""
_WAY_FIRST = re.compile(
    rf"(?:^|[^a-z])(?P<way>{_UP}|{_DOWN})[ _]*(?:is|=)?[ _]*(?P<sign>[+-]?)(?P<axis>[xyz])(?![a-z])"
)
"""``up_x``, ``down -z``."""
_TWO_LETTERS = re.compile(
    r"(?:^|[^a-z0-9+-])(?P<sign>[+-]?)(?P<axis>[xyz])[ _-]?(?P<way>[ud])(?=\.|$)"
)
"""``zu``, ``hang_xd``."""
_LETTER = re.compile(
    r"(?:^|[^a-z0-9+-])(?P<sign>[+-]?)(?P<axis>[xyz])[ _-]?(?P<way>[a-z])(?=[^a-z]|$)"
)
_UP_AND_DOWN = ("ud", "nd", "hb", "gd", "sg", "hr")
"""First letters of up and down in a language: nahoru and dolů, haut and bas, su and giù."""
_BARE = re.compile(r"(?:^|[^a-z0-9])([xyz])(?=[^a-z0-9]|$)")
_CAMEL = re.compile(r"(?<=[a-z])(?=[XYZ])")
_SIDES_OF_A_BODY = {
    axis: re.compile(
        rf"(?:^|[^a-z])(?:{words})[ _-]*(?:side|seite)?[ _-]*{_FILLED}"
        rf"(?:(?P<up>{_UP})|{_DOWN})(?![a-z])"
    )
    for axis, words in {
        "+x": "nose|head|front|bow|snout|toes?|kopf|nase|schnauze|vorn|vorne|bug|cabeza|nariz|"
        "morro|hocico|tete|tête|nez|avant|museau|testa|naso|muso|cabeca|cabeça|focinho|kop|neus",
        "-x": "tail|rear|stern|heels?|heck|schwanz|hinten|cola|popa|queue|arriere|arrière|coda|"
        "rabo|cauda|staart",
        "+y": "left|links|izquierda|gauche|sinistra|esquerda",
        "-y": "right|rechts|derecha|droite|destra|direita",
        "-z": "feet|legs|belly|bottom|soles?|bauch|beine|fuesse|füße|unterseite|vientre|panza|"
        "patas|ventre|pattes|pancia|zampe|barriga|buik",
        "+z": "roof|lid|spine|top|back|ruecken|rücken|deckel|oberseite|espalda|lomo|dos|schiena|"
        "dorso|costas|rug",
    }.items()
}  # fmt: skip
"""Sides of a body whose x points forward and y to the left, and whether they are said to be up."""
_POSTURES = {"upright|right[ _-]?side[ _-]?up|aufrecht": "-z",
             "upside[ _-]?down|inverted|kopfüber|kopfueber|kopfunter": "+z"}  # fmt: skip
"""Words for a whole body, and the axis along gravity."""
_NEGATIVE = ("minus", "neg", "negative", "-")
_OPPOSITE = {"+": "-", "-": "+"}


def orientation_in(word: str) -> str | None:
    """``+x`` … ``-z``, the axis along gravity, of a name such as ``hang_plus_x`` or ``-x up``."""
    return side_in(word)[0]


def side_in(word: str) -> tuple[str | None, bool]:
    """The axis along gravity as `orientation_in` reads it, and whether up or down is said of it."""
    small = _CAMEL.sub("_", word).lower()
    if (both := _TWO_LETTERS.search(small)) is not None:
        return _along(both["axis"], both["sign"], up=both["way"] == "u"), True
    for posture, axis in _POSTURES.items():
        if re.search(rf"(?:^|[^a-z])(?:{posture})(?![a-z])", small):
            return axis, True
    signed = [*_SIGNED.finditer(small)]
    ways = [found for found in signed if found["way"]] or [*_WAY_FIRST.finditer(small)]
    for found in ways or signed:
        parts = found.groupdict()
        sign = next((parts[k] for k in ("word", "sign", "after", "before") if parts.get(k)), "")
        if sign or parts["way"]:
            up = bool(parts["way"]) and _points_up(parts["way"])
            return _along(parts["axis"], sign, up=up), bool(parts["way"])
    for axis, side in _SIDES_OF_A_BODY.items():
        if (said := side.search(small)) is not None:
            return (axis if not said["up"] else opposite(axis)), True
    return None, False


def sides_in(words: Sequence[str]) -> dict[str, tuple[str | None, bool]]:
    """`side_in` of words that stand together: next to ``-x`` a bare ``x`` is the positive axis."""
    if lettered := _by_letters(words):
        return lettered
    sides = {word: side_in(word) for word in words}
    signed = any(axis is not None and not said for axis, said in sides.values())
    for word, (axis, _) in sides.items():
        bare = _BARE.findall(word.lower())
        if signed and axis is None and len(bare) == 1:
            sides[word] = f"+{bare[0]}", False
    return sides


def _by_letters(words: Sequence[str]) -> dict[str, tuple[str | None, bool]]:
    """Sides by the letter behind an axis in each word, ``xN`` and ``xD``; empty without a pair."""
    found = {word: _LETTER.search(word.lower()) for word in words}
    ways = {one["way"] for one in found.values() if one}
    pair = next((p for p in _UP_AND_DOWN if ways == {*p}), None)
    if pair is None or not all(found.values()):
        return {}
    return {
        word: (_along(one["axis"], one["sign"], up=one["way"] == pair[0]), True)
        for word, one in found.items() if one
    }  # fmt: skip


def says_up(name: str) -> bool | None:
    """Whether a column is called after the axis that points up, or after the one down; else None.

    ``up_axis`` is up, ``eje_abajo`` down.
    """
    for words, up in ((_UP, True), (_DOWN, False)):
        if re.search(rf"(?:^|[^a-z])(?:{words})(?![a-z])", name.lower()):
            return up
    return None


def opposite(orientation: str) -> str:
    """The axis of the other sign."""
    return _OPPOSITE[orientation[0]] + orientation[1]


def pulls(orientation: str) -> FloatArray:
    """Direction of gravity along an axis ``+x`` … ``-z``, shape (3,)."""
    sign = 1.0 if orientation[0] == "+" else -1.0
    return np.asarray(sign * np.eye(3)["xyz".index(orientation[1])])


def _points_up(way: str) -> bool:
    return re.fullmatch(_UP, way) is not None


def _along(axis: str, sign: str | None, *, up: bool) -> str:
    return ("-" if ((sign in _NEGATIVE) + up) % 2 else "+") + axis
