"""What lines above a table say of the cells' sensitivity: ``1120 counts per newton``, in any words.

Room: sniff; asked by said_above.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.sniff.cells import NAMEPLATE, WEIGHTS
from footcal_cli.sniff.guesses import numbers_of
from footcal_cli.sniff.plan import LogPlan
from footcal_cli.sniff.units import GRAVITY_MPS2
from footcal_cli.tables.units import conversion

_NUMBER = r"(?<![\d.,])(?P<number>\d{1,3}(?: \d{3})+|\d+(?:[.,]\d+)?(?:e-?\d+)?)"
_PER = (
    r"\s*(?:/|\bper\b|\bpro\b|\bje\b|\bpar\b|\bpor\b|\bna\b|\bpr\.?|\bpå\b|\bpaa\b|\bza\b|\ba\b)\s*"
)
_FORCE = r"(?P<unit>N|kN|mN|kgf?|g|lbf?|[Nn]ew?tons?|[Nn]iuton\w*|[Nn]jutn\w*)(?![\w/])"
_COUNTS = (
    r"(?:(?i:counts?|cts?|codes?|lsbs?|digits?|bits?|ticks?|steps?|units?|zliczeń|zliczenia|"
    r"impuls\w*|cuentas?|contagens|contagem|conteggi\w*|punti|tellinger|enheter|inkrement\w*|"
    r"zähl\w*|tell\w*|dílků|dilku|jednotek|coups|points|pas|pulsos|sayım|sayim|lukemaa?|hodnot)|"
    r"カウント)"
)
_OF_A_FORCE = re.compile(rf"{_NUMBER}\s*{_COUNTS}{_PER}{_FORCE}")
_OF_A_COUNT = re.compile(rf"{_NUMBER}\s*{_FORCE[:-9]}{_PER}{_COUNTS}(?!\w)")
_OFF_BY = re.compile(
    r"[^\d.;]{0,25}?(?:±|\+[-/]+|\+\s*[-–]|(?i:within|about))\s*(\d+(?:[.,]\d+)?)\s*%"
)


def scale_in(above: Sequence[str]) -> tuple[float, float | None, str] | None:
    """Newtons per count, how far that may be off as a share, and the line; None without one.

    >>> scale_in(["The cells give 1120 counts per newton, +-3 %."])[:2]
    (0.0008928571428571428, 0.03)
    """
    found: dict[float, tuple[float | None, str]] = {}
    text = "\n".join(above)  # a sentence may go on in the next line
    for pattern, counted in ((_OF_A_FORCE, True), (_OF_A_COUNT, False)):
        for said in pattern.finditer(text):
            number = float(re.sub(r"\s", "", said["number"]).replace(",", "."))
            unit = "N" if said["unit"].lower().startswith(("new", "niu", "nj")) else said["unit"]
            one = conversion(unit, "N", GRAVITY_MPS2).slope
            off = _OFF_BY.match(text, said.end())
            sd = float(off[1].replace(",", ".")) / 100 if off else None
            if number > 0:
                line = " ".join(text[said.start() : (off or said).end()].split())
                found.setdefault(one / number if counted else one * number, (sd, line))
    if len(found) != 1:
        return None
    scale, (sd, line) = found.popitem()
    return scale, sd, line


def with_scale(plan: LogPlan) -> LogPlan:
    """The plan with the sensitivity of its cells that a line says, where it was asked for."""
    asked = [blank for blank in plan.blanks if blank in (WEIGHTS, NAMEPLATE)]
    entries = list(plan.read.values())
    counts = entries and all(e.unit is None and e.column is not None for e in entries)
    said = scale_in(plan.file.text.above) if asked and counts else None
    if said is None:
        return plan
    scale, sd, line = said
    lines = (
        f"[robot.nameplate]\nscale_n_per_count = {_sign(plan) * scale:.6g}    # likely: '{line}'"
    )
    if sd is not None:
        lines += f"\nscale_relative_sd = {sd:g}    # likely: the same line"
    blanks = tuple(blank for blank in plan.blanks if blank not in asked)
    return replace(plan, robot=(*plan.robot, lines), blanks=blanks)


def _sign(plan: LogPlan) -> int:
    """Whether readings grow or fall with the load."""
    load = plan.entries.get("load_n")
    if load is None or load.column is None or load.column.values is None:
        return 1
    put = numbers_of(load.column)
    read = [numbers_of(e.column) for e in plan.read.values() if e.column is not None]
    total = np.sum([r for r in read if r.size == put.size], axis=0)
    good = np.isfinite(put) & np.isfinite(total)
    if not good.any() or np.ptp(put[good]) == 0:
        taken = all(e.column is not None and e.column.minus for e in plan.read.values())
        return -1 if taken and np.nanmean(total) < 0 else 1
    return 1 if np.polyfit(put[good], total[good], 1)[0] > 0 else -1
