"""Logs with the same columns of which each is of another cell, and logs that say the same twice.

Room: sniff; asked by several.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.sniff.experiment import plan_of
from footcal_cli.sniff.file_names import Part
from footcal_cli.sniff.groups import wrenches
from footcal_cli.sniff.guesses import FileGuess
from footcal_cli.sniff.loads import loads_and_cells
from footcal_cli.sniff.numbered import numbered
from footcal_cli.sniff.plan import LogPlan
from footcal_cli.sniff.weights import follow

_SAME = 1e-3
"""How far two copies of a force may be apart, as a share of its size."""


def by_experiment(group: list[FileGuess]) -> list[list[FileGuess]]:
    """Logs with the same columns in groups: a robot that hangs and one that stands are two.

    So are logs of cells in each of which another one carries the known load.
    """
    if len(group) < 2 or not wrenches(numbered(group[0])):
        return _by_loaded_cell(group)
    found: dict[str, list[FileGuess]] = {}
    for file in group:
        plan = plan_of(file)
        found.setdefault("" if plan is None else plan.role, []).append(file)
    kinds = found.keys() - {"hang"}
    return list(found.values()) if len(found) == 2 and kinds < {"poses", "still"} else [group]


def _by_loaded_cell(group: list[FileGuess]) -> list[list[FileGuess]]:
    """Logs in groups by the cell that carries the known load, where the others stand still."""
    found: dict[tuple[str, ...], list[FileGuess]] = {}
    for file in group if len(group) > 1 else ():
        loads, cells = loads_and_cells(file)
        following, idle = follow(loads[0], cells) if loads and cells else ([], [])
        if not idle or len(following) != 1:
            return [group]
        found.setdefault((following[0].column,), []).append(file)
    return list(found.values()) if len(found) > 1 else [group]


def without_twins(parts: list[Part]) -> list[Part]:
    """Logs without those whose vertical forces are of plates that another log has with their CoP.

    A C3D holds both: what came out of the amplifiers, and force and CoP of each plate.
    """
    whole = [p for p in parts if any(name.endswith("_cop_x_m") for name in p.plan.entries)]
    if len(whole) != 1 or len(parts) < 2:
        return parts
    forces = _vertical(whole[0].plan)
    twins = [
        part for part in parts
        if part is not whole[0] and part.plan.role == whole[0].plan.role
        and (own := _vertical(part.plan)) and all(_among(v, forces) for v in own)
    ]  # fmt: skip
    said = tuple(
        f"{', '.join(path.name for path in twin.paths)}: left out, the same forces without a CoP"
        for twin in twins
    )
    plan = replace(whole[0].plan, warnings=(*whole[0].plan.warnings, *said))
    return [replace(p, plan=plan) if p is whole[0] else p for p in parts if p not in twins]


def _vertical(plan: LogPlan) -> list[FloatArray]:
    """Vertical forces of the plates of a plan."""
    names = ("_fz_n", "_counts")
    columns = [e.column for name, e in plan.entries.items() if name.endswith(names)]
    return [c.values for c in columns if c is not None and c.values is not None]


def _among(values: FloatArray, others: Sequence[FloatArray]) -> bool:
    """Whether one of other columns has the same values, up to their sign."""
    size = _SAME * float(np.nanmax(np.abs(values), initial=0.0))
    return any(
        o.shape == values.shape and np.nanmax(np.abs(np.abs(o) - np.abs(values))) <= size
        for o in others
    )
