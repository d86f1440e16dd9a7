"""Which axis points along gravity, by words such as ``hang_plus_x``, ``-z up`` or ``nose down``.

Room: sniff; asked for names of orientations.
"""

from __future__ import annotations

import re

_UP = "up|oben|hoch|haut|arriba|su|alto|cima|вверх|上"
_DOWN = "down|unten|runter|bas|abajo|giu|giù|basso|baixo|вниз|下"
_SIGNED = re.compile(
    r"(?:(?:^|[^a-z])(?P<word>plus|minus|pos|neg|positive|negative)[ _]*"
    r"|(?:^|[^a-z0-9])(?P<sign>[+-])[ _]*|(?:^|[^a-z]))"
    rf"(?P<axis>[xyz])(?:[ _-]*(?P<way>{_UP}|{_DOWN})(?=[^a-z]|$)"
    r"|[ _]*(?P<after>plus|minus|pos|neg|positive|negative|[+-])(?=[^a-z]|$)|(?=[^a-z]|$))"
)
"""An axis with its sign before or after it, and whether it points up or down."""
_SIDES_OF_A_BODY = {
    axis: re.compile(
        rf"(?:^|[^a-z])(?:{words})[ _-]*(?:side)?[ _-]*(?:(?P<up>{_UP})|{_DOWN})(?![a-z])"
    )
    for axis, words in {
        "+x": "nose|head|front|bow|snout|toes?", "-x": "tail|rear|stern|heels?", "+y": "left",
        "-y": "right", "-z": "feet|legs|belly|bottom|soles?", "+z": "roof|lid|spine",
    }.items()
}  # fmt: skip
"""Sides of a body whose x points forward and y to the left, and whether they are said to be up."""


def orientation_in(word: str) -> str | None:
    """``+x`` … ``-z``, the axis along gravity, of a name such as ``hang_plus_x`` or ``-x up``."""
    for found in _SIGNED.finditer(word.lower()):
        sign = found["word"] or found["sign"] or found["after"]
        if sign or found["way"]:
            up = found["way"] in _UP.split("|")
            turns = (sign in ("minus", "neg", "negative", "-")) + up
            return ("-" if turns % 2 else "+") + found["axis"]
    for axis, side in _SIDES_OF_A_BODY.items():
        if (said := side.search(word.lower())) is not None:
            return axis if not said["up"] else ("-" if axis[0] == "+" else "+") + axis[1]
    return None
