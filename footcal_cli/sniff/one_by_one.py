"""A file for each mark on a plate, whose name says where it is.

Room: sniff; asked by several. The files are looked at as one log, whose rows know their file.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.sniff.experiment import plan_of
from footcal_cli.sniff.file_loads import Names
from footcal_cli.sniff.file_names import Part
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, as_one
from footcal_cli.sniff.levers import with_levers
from footcal_cli.sniff.names import NameGuess
from footcal_cli.sniff.numbered import numbered
from footcal_cli.sniff.plan import Entry, LogPlan
from footcal_cli.sniff.units import metres_per

_LEAST_MARKS = 4
_PLACE = re.compile(
    r"(?<![A-Za-z])x[ =_]?([-+]?\d+(?:[.p]\d+)?)(mm|cm|m)?[ ,;_]*y[ =_]?([-+]?\d+(?:[.p]\d+)?)"
    r"(mm|cm|m)?(?!\d|\.\d)",
    re.IGNORECASE,
)
"""``x-150_y200``, ``x10mm y20mm``: where something stood."""
_WRITTEN = ("mm", "cm", "m")
_NEARLY = 0.2
"""How far the span of a CoP may be from that of the marks, where it says their unit."""


def marked_files(group: list[FileGuess]) -> Part | None:
    """Files of one mark on a plate each, whose names say where it is: a force and moments in each.

    The unit of the places is said, or it is the one in which the CoP spans what they do.
    """
    names = [file.path.name for file in group]
    found = [_PLACE.search(name) for name in names]
    if len(group) < _LEAST_MARKS or any(f is None for f in found):
        return None
    places = np.array([[_number(f[1]), _number(f[3])] for f in found if f])
    said = {f[i] for f in found if f for i in (2, 4)}
    rows = [file.rows for file in group]
    for unit in (said & {*_WRITTEN}) if len(said) == 1 and said != {None} else _WRITTEN:
        holes = tuple(
            ColumnGuess(f"\0{a}", NameGuess("hole", a, unit=unit), unit, "likely", "names",
                        np.repeat(places[:, i], rows))
            for i, a in enumerate("xy")
        )  # fmt: skip
        whole = as_one(group, holes)
        plan = plan_of(whole)
        if plan is None or plan.role != "cop_points" or not _spans(whole, holes, unit):
            continue
        expressions = (r"(?i)(?<![A-Za-z])x[ =_]?([-+]?\d+(?:\.\d+)?)",
                       r"(?i)(?<![A-Za-z])y[ =_]?([-+]?\d+(?:\.\d+)?)")  # fmt: skip
        why = "the files' names" + ("" if said != {None} else ", in the unit of the CoP")
        entries = {**plan.entries} | {
            f"hole_{a}_m": Entry(file_name=expression, unit=unit, why=why)
            for a, expression in zip("xy", expressions, strict=True)
        }
        kind = f"{plan.kind}, a file for each point"
        return _part(group, replace(plan, entries=entries, kind=kind), Names.of(names))
    return None


def _number(text: str) -> float:
    return float(text.replace("p", "."))


def _spans(file: FileGuess, holes: Sequence[ColumnGuess], unit: str) -> bool:
    """Whether the CoP of a log spans what the marks do in a unit."""
    cops = {c.name.axis: c for c in with_levers(numbered(file)).of("cop")}
    for hole in holes:
        cop = cops.get(hole.name.axis)
        if cop is None or cop.values is None or hole.values is None:
            return False
        ours, theirs = np.nanstd(hole.values) * metres_per(unit), np.nanstd(cop.values)
        if abs(theirs * metres_per(cop.unit) / ours - 1.0) > _NEARLY:
            return False
    return True


def _part(group: Sequence[FileGuess], plan: LogPlan, names: Names) -> Part:
    return Part(replace(plan, file=group[0]), tuple(file.path for file in group), names.match)
