"""What lines above a table say of gravity: ``g = 9,8156 m/s2``, which makes kg newtons.

Room: sniff; asked by said_above.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

from footcal_cli.sniff.plan import LogPlan

_NUMBER = r"(?P<{}>9[.,][78]\d{{0,5}})(?![\d.,]*\d)"
_SAID = re.compile(
    rf"(?:(?<![\w.])g(?:_?n|_?0|_?loc(?:al)?)?|\b(?i:gravi\w*|gravedad|pesanteur|erdbeschleunigung|"
    rf"fallbeschleunigung|tyngde\w*|tyngd\w*|przyspieszenie\w*|zwaarte\w*)|重力加速度|重力)"
    rf"[^\d\n=:≈]{{0,30}}[\s=:≈]\s*{_NUMBER.format('named')}"
    rf"|(?<![\d.,]){_NUMBER.format('of')}\s*(?:m\s*/\s*s(?:\^?2|²)|m·?s(?:\^?-2|⁻²)|N\s*/\s*kg)"
)
"""A letter g or a word before it, or its unit behind it."""
_RANGE = (9.76, 9.84)
"""From high mountains at the equator to the poles."""


def gravity_in(above: Sequence[str]) -> tuple[float, str] | None:
    """Gravity in m/s² and the line that says it; None where none or several do.

    >>> gravity_in(["Loads are masses, g = 9,8156 m/s2 here."])
    (9.8156, 'Loads are masses, g = 9,8156 m/s2 here.')
    """
    found: dict[float, str] = {}
    for line in above:
        for said in _SAID.finditer(line):
            g = float((said["named"] or said["of"]).replace(",", "."))
            if _RANGE[0] <= g <= _RANGE[1]:
                found.setdefault(g, line.strip())
    return next(iter(found.items())) if len(found) == 1 else None


def with_gravity(plan: LogPlan) -> LogPlan:
    """The plan with the gravity that a line above its table says."""
    said = gravity_in(plan.file.text.above)
    if said is None:
        return plan
    line = f"gravity_mps2 = {said[0]:g}    # likely: '{said[1]}'"
    return replace(plan, robot=(line, *plan.robot))
