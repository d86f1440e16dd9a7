"""Which shapes of an effect are tried: the table's grid, in the units of these very logs."""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from itertools import product

import numpy as np

from footcal_cli.core.chain import Chain, Link
from footcal_cli.core.effects.contract import (
    OF_THE_LOGS,
    Effect,
    EffectParameter,
    GridOf,
    Scope,
    Trait,
    columns_of,
    is_six_axis,
)
from footcal_cli.core.inference.case import Case, channels_of
from footcal_cli.core.inference.linear import left_by
from footcal_cli.core.log import Log

MOST_SHAPES = 30
"""Shapes tried of an effect whose grid is its own; labels and holes are all tried."""
MOST_LABELS = 40
"""More distinct loads than this are no set of weights but a running reference."""
SAME_LABEL = 1e-3
"""Written loads that differ by less than this share are one weight."""
_LARGEST = 0.99
_RCOND = 1e-9
_LOOP = 0.3
"""Share of what a play adds to an axis that no gain adds: two levels of load show a gain alone."""
_EARLY_S = (5.0, 10.0, 20.0, 30.0, 60.0, 120.0)
"""Where a cell is loaded at a few visits a jump is looked for at the beginning only."""
_PAUSE = 5.0  # a pause is so many times the usual step between rows
_NEAR_PAUSE = 0.01  # of the rows
_MOST_PAUSES = 11


def shapes_of(case: Case, effect: Effect, units: Sequence[str] = ()) -> list[dict[str, float]]:
    """Every combination of the shape parameters worth trying on these logs.

    Empty where the logs offer none (no set of weights whose label could be wrong).

    Parameters
    ----------
    units
        Who would carry it. Axes of a transducer differ in range and unit: what is a share of the
        largest load is one of theirs. Cells share the range of the largest among them.
    """
    names = [s.name for s in effect.shapes]
    shapes = [
        dict(zip(names, values, strict=True))
        for values in product(*(_grid(case, effect, s, units) for s in effect.shapes))
    ]
    if Trait.SYMMETRIC in effect.traits:
        first, second = names
        return [s for s in shapes if s[first] < s[second]]
    own = any(s.grid_of in OF_THE_LOGS for s in effect.shapes)
    return shapes if own else shapes[:MOST_SHAPES]


def forms_by_unit(
    case: Case, effect: Effect, units: Sequence[str]
) -> list[dict[str, dict[str, float]]]:
    """Shapes worth trying, of each unit: the same of all, but of axes with their own range.

    An axis is left out of those that open no loop at the loads it had.
    """
    if not (
        any(s.grid_of is GridOf.LOAD for s in effect.shapes) and is_six_axis(channels_of(case.logs))
    ):
        return [dict.fromkeys(units, shape) for shape in shapes_of(case, effect)]
    each = [shapes_of(case, effect, (unit,)) for unit in units]
    forms = [dict(zip(units, shapes, strict=True)) for shapes in zip(*each, strict=True)]
    if Trait.MEMORY not in effect.traits:
        return forms
    truths = [case.chain.remove(log, case.values)[0] for log in case.logs]
    return [{u: f for u, f in form.items() if _opens(truths, effect, u, f)} for form in forms]


def _opens(logs: Sequence[Log], effect: Effect, unit: str, shape: Mapping[str, float]) -> bool:
    """Whether what it adds to an axis is more than a gain of its load and a zero."""
    size = effect.size
    chain = Chain((Link(effect, {unit: (unit,)}),))
    values = {f"{unit}.{size.name}": size.prior_sd} | {f"{unit}.{k}": v for k, v in shape.items()}
    here = [log for log in logs if unit in log.channels]
    load = np.concatenate([log.readings[:, log.channels.index(unit)] for log in here])
    shown = [chain.apply(log, values)[0].readings[:, log.channels.index(unit)] for log in here]
    added = np.concatenate(shown) - load
    line = np.column_stack([load, np.ones_like(load)])
    return float(np.std(left_by(line, added, _RCOND))) > _LOOP * float(np.sqrt(np.mean(added**2)))


def _grid(case: Case, effect: Effect, shape: EffectParameter, units: Sequence[str]) -> list[float]:
    if shape.grid_of is GridOf.LABEL:
        return labels_of(case)
    if shape.grid_of is GridOf.HOLE:
        return [float(h) for h in holes_in_use(case)]
    if shape.grid_of is GridOf.PIECE:
        return [float(p) for p in pieces_in_use(case)]
    if shape.grid_of is GridOf.LOAD:
        mine = set(units) if is_six_axis(channels_of(case.logs)) else set()
        largest = max(_largest(case, log, effect.scope, mine) for log in case.logs)
        return [float(np.clip(v * largest, shape.lower, shape.upper)) for v in shape.grid]
    if shape.grid_of is GridOf.SPAN and case.experiment.few_visits:
        return list(_EARLY_S)
    if shape.grid_of is GridOf.SPAN:
        longest = max(case.logs, key=lambda log: float(np.ptp(log.time_s)))
        return possible_times(longest, shape.grid)
    if shape.grid_of is GridOf.RATE:
        longest_s = max(float(np.ptp(log.time_s)) for log in case.logs) or np.inf
        return [float(np.clip(v / longest_s, shape.lower, shape.upper)) for v in shape.grid]
    if shape.unit == "channel":
        return [v for v in shape.grid if v < len(channels_of(case.logs))] or [shape.neutral]
    return list(shape.grid)


def _largest(case: Case, log: Log, scope: Scope, among: Container[str]) -> float:
    """Largest load of a cell, or of a foot for what acts on its sum, without outliers."""
    force = np.abs(case.chain.remove(log, case.values)[0].readings)
    if scope is Scope.FOOT:
        force = np.stack([force[:, c].sum(axis=1) for c in columns_of(scope, log.channels)], 1)
    elif mine := [c for c, channel in enumerate(log.channels) if channel in among]:
        force = force[:, mine]
    return max(float(np.nanquantile(force, _LARGEST, axis=0).max()), 1e-6)


def possible_times(log: Log, shares: Sequence[float]) -> list[float]:
    """Times since the start at which something may have happened, s: in pauses, and in between.

    What happened in a pause changed everything after it and nothing before: a time a few rows
    early would look the same and leave another trace once both sides have their own tilts.

    Parameters
    ----------
    shares
        Of the rows of the log.
    """
    since = log.time_s - log.time_s[0]
    steps = np.diff(since)
    if not steps.size:
        return []
    pauses = np.flatnonzero(steps > _PAUSE * np.median(steps)) + 1
    rows = (np.array(shares) * since.size).astype(np.int64)
    apart = np.abs(rows[:, None] - pauses[None]).min(axis=1, initial=since.size)
    rows = np.union1d(rows[apart > _NEAR_PAUSE * since.size], pauses[:_MOST_PAUSES])
    return [float(since[row]) for row in rows]


def labels_of(case: Case) -> list[float]:
    """Distinct written loads but zero, smallest first; none where the load runs freely."""
    written = np.concatenate([log.known["load_n"].ravel() for log in case.logs])
    written = np.unique(written[np.isfinite(written)])
    if not written.size:
        return []
    least = SAME_LABEL * float(np.abs(written).max())
    written = written[np.abs(written) > least]
    labels: list[float] = []
    for load in written:
        if not labels or abs(load - labels[-1]) > SAME_LABEL * abs(load):
            labels.append(float(load))
    return labels if len(labels) <= MOST_LABELS else []


def holes_in_use(case: Case) -> list[int]:
    """Numbers of the holes in use."""
    numbers = [log.known["hole"] if "hole" in log.known else log.block.astype(float)
               for log in case.logs]  # fmt: skip
    return [int(n) for n in np.unique(np.concatenate(numbers)) if n >= 0]


def pieces_in_use(case: Case) -> list[int]:
    """Numbers of the pieces that lie in stacks of several written loads.

    One that lies under a single load cannot be distinguished from that load's label.
    """
    logs = [log for log in case.logs if "pieces" in log.known]
    if not logs:
        return []
    stack = np.concatenate([log.known["pieces"] for log in logs]).astype(np.int64)
    load = np.concatenate([log.known["load_n"][:, 0] for log in logs])
    found = []
    for piece in range(int(stack.max()).bit_length()):
        under = load[(stack >> piece & 1).astype(bool) & np.isfinite(load)]
        if under.size and np.ptp(under) > SAME_LABEL * np.abs(under).max():
            found.append(piece)
    return found
