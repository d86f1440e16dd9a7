"""Whether notes say that y points to the right: footcal's points to the left.

Room: sniff; asked by said_above. ``y toward medial side`` of a left foot is to the right.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

from footcal_cli.sniff.listed_places import sides_said
from footcal_cli.sniff.plan import LogPlan
from footcal_cli.sniff.vocabulary import SIDES

_MEDIAL = ("medial", "inner", "inside", "innen", "intérieur", "interior", "interno", "wewn", "uchi")
_LATERAL = (
    "lateral",
    "outer",
    "outside",
    "außen",
    "aussen",
    "extérieur",
    "exterior",
    "zewn",
    "soto",
)
_SIDE = ("side", "hand", "direction", "seite", "rand", "positive", "is")
_Y = re.compile(r"(?<![\w.*])[+]?[yY](?:\s*[-=:>→+]+\s*|\s+)((?:[^\W\d_]+[ ]+){0,3}[^\W\d_]+)")
"""An axis y and up to four words behind it, without a comma between them."""


def with_left_asked(plan: LogPlan) -> LogPlan:
    """Placements with a warning where a line above says that y of the holes points to the right.

    In a log of feet, y may be to the right because z is down: the body's stream says that.
    """
    if plan.role != "placements":
        return plan
    line = next((x for x in plan.file.text.above if points_right(x, plan.file.text.above)), None)
    if line is None:
        return plan
    said = (
        f"y points to the right ('{line.strip()}'), footcal's to the left: for a robot write y of "
        "cells and holes with the other sign"
    )
    return replace(plan, warnings=(*plan.warnings, said))


def points_right(line: str, above: Sequence[str] = ()) -> bool:
    """Whether a line says that y points to the right; of one foot, by what all lines say it is.

    >>> points_right("x forward, y right, z down")
    True
    >>> points_right("y toward medial side", ["Left foot"])
    True
    """
    feet = {*sides_said("\n".join(above))}
    inward = {"left": "right", "right": "left"}.get(feet.pop() if len(feet) == 1 else "", "")
    for found in _Y.finditer(line):
        for word, after in pairwise([*found[1].lower().split(), ""]):
            if len(after) > 1 and after not in _SIDE:
                continue  # of the right foot
            side = SIDES.get(word, "") if len(word) > 2 else ""
            if word.startswith(_MEDIAL):
                side = inward
            elif word.startswith(_LATERAL):
                side = {"left": "right", "right": "left"}.get(inward, "")
            if side:
                return side == "right"
    return False
