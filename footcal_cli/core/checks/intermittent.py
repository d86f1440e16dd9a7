"""Readings that leave their level at once and come back: a plug or a wire that loses contact.

Room: checks; asked by the session. What hangs is loaded slowly: one axis is enough. Under a foot a
cell is suspected where none of its siblings steps with it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footcal_cli.core.effects.calibration import AXES
from footcal_cli.core.parameters import BoolArray, FloatArray
from footcal_cli.core.quality import Finding
from footcal_cli.core.readings import resolution_of
from footcal_cli.core.signals import median_sd, stretches

ABRUPT = 12.0
"""Usual sd of the steps from one sample to the next beyond which a step is abrupt."""
BACK = 0.25
"""Share of the step out that may be missing when the reading has come back, and that the steps
before and after it may have."""
LONGEST = 0.1
"""Share of a recording that a spell may last; what stays away longer is another load."""
OFTEN = 3
"""A loose contact comes back; fewer spells may be somebody who touched the leg."""
LEAST = 0.1
"""Share of the usual span, of a cell or of the axes of its kind, that a lost contact takes away at
least; a sole that sticks takes less, and so does slow noise that goes on after a pause."""
_FEWEST = 50
_NEAR = 3
"""Samples that tell the level before and after a spell."""
_TRIED = 8
"""Later steps that may be the way back: a foot that walks steps all the time."""
_TOGETHER = 2
"""Samples by which the steps of one impact differ between cells."""
_MOVED = 0.2
"""Share of its span by which a sibling changes in those samples where the foot's load does: at
30 Hz a touch-down is over within one, and no step of it stands out of the others."""


def find_spells(
    reading: FloatArray, held: FloatArray | None = None, resolution: float = 0.0
) -> BoolArray:
    """Samples, two or more, between a step away from a level and one back to it, shape (n,).

    Beyond a step that has no other one are the few samples before it or after it, at an end.

    Parameters
    ----------
    reading
        One recording in order of time, NaN where a sample was lost, shape (n,).
    held
        How the sensor was held and turned, shape (n, k): where that steps, the load does. NaN
        where it was not recorded.
    resolution
        Step of the converter.
    """
    found = np.zeros(reading.size, dtype=bool)
    finite = np.isfinite(reading)
    level = reading if finite.all() else reading[finite]
    if level.size < _FEWEST:
        return found
    steps = np.diff(level)
    edges = np.flatnonzero(_abrupt(steps, resolution))
    # what moves takes several samples
    around = np.abs(np.r_[0.0, steps, 0.0][edges[:, None] + [0, 2]])
    edges = edges[around.max(axis=1, initial=0.0) < BACK * np.abs(steps[edges])]
    if not edges.size:
        return found
    good = np.flatnonzero(finite)
    if held is not None:
        turned = np.abs(np.diff(_between(held)[good], axis=0))
        edges = edges[~np.any(turned[edges] > ABRUPT * np.nanmedian(turned, axis=0), axis=1)]
        if not edges.size:
            return found
    longest, end, levels = LONGEST * good.size, -1, _levels(level)
    for i, out in enumerate(edges):
        if out <= end:
            continue
        later = edges[i + 1 : i + 1 + _TRIED]
        later, near = later[later <= out + longest], BACK * abs(steps[out])
        back = next((b for b in later if abs(levels[b + _NEAR] - levels[out]) <= near), None)
        if back is not None:
            found[good[out] + 1 : good[back] + 1] = True
            end = back
        elif good.size - out <= longest:
            found[good[out] + 1 :] = True
        elif out <= longest:
            found[: good[out] + 1] = True
    return found


def _between(held: FloatArray) -> FloatArray:
    """Columns (n, k) with what is missing put in between its neighbours; zero without any."""
    at, filled = np.arange(len(held)), np.zeros_like(held)
    for i, column in enumerate(held.T):
        known = np.isfinite(column)
        if known.any():
            filled[:, i] = np.interp(at, at[known], column[known])
    return filled


def _abrupt(steps: FloatArray, resolution: float) -> BoolArray:
    """Steps that no noise makes, shape (n,)."""
    known = np.isfinite(steps)
    usual = median_sd(steps if known.all() else steps[known]) if known.any() else 0.0
    return np.abs(steps) > ABRUPT * max(usual, resolution)


def _levels(values: FloatArray) -> FloatArray:
    """Median of each sample and the two before it, beyond the end of the last one, (n + 3,)."""
    ends = np.r_[np.repeat(values[0], _NEAR - 1), values, np.repeat(values[-1], _NEAR)]
    first, second, third = ends[:-2], ends[1:-1], ends[2:]
    larger = np.maximum(first, second)
    return np.asarray(np.maximum(np.minimum(first, second), np.minimum(larger, third)))


def steps_of_axes(wrench: FloatArray) -> FloatArray:
    """Step of the converter of each axis of a leg, from all that was recorded of it, shape (6,).

    A heavy robot's leg takes two or three values in one recording: those do not show a step.
    """
    return np.repeat([resolution_of(wrench[:, :3]), resolution_of(wrench[:, 3:])], 3)


def spells_of(
    wrench: FloatArray, held: FloatArray | None = None, steps: FloatArray | None = None
) -> BoolArray:
    """`find_spells` of each axis of one recording of a leg, shape (n, 6).

    Parameters
    ----------
    steps
        `steps_of_axes` the leg, shape (6,); None: of this recording.
    """
    own = steps_of_axes(wrench) if steps is None else steps
    return np.stack(
        [find_spells(axis, held, step) for axis, step in zip(wrench.T, own, strict=True)], 1
    )


def loose_axes(wrench: FloatArray, lost: BoolArray) -> BoolArray:
    """Which axes lose contact again and again, and a good part of such a load with it, shape (6,).

    Parameters
    ----------
    wrench, lost
        All recordings of a leg one after the other, and `spells_of` them, shape (n, 6).
    """
    found = np.zeros(lost.shape[1], dtype=bool)
    for i, spells in enumerate(map(stretches, lost.T)):
        if len(spells) < OFTEN:
            continue
        kind = wrench[:, :3] if i < len(AXES) // 2 else wrench[:, 3:]
        least = LEAST * float(np.max(np.subtract(*np.nanpercentile(kind, [98, 2], axis=0))))
        found[i] = sum(_away(wrench[:, i], *spell) >= least for spell in spells) >= OFTEN
    return found


def _away(reading: FloatArray, start: int, stop: int) -> float:
    """How far a spell is from the nearer of its ends: beyond one may be another recording."""
    ends = [reading[at] for at in (start - 1, stop) if 0 <= at < reading.size]
    away = np.abs(np.nanmedian(reading[start:stop]) - np.array(ends))
    return float(np.nanmin(away)) if np.isfinite(away).any() else 0.0


def check_spells(leg: str, wrench: FloatArray, lost: BoolArray) -> list[Finding]:
    """Say of a leg that an axis or all of them lose contact again and again.

    Parameters
    ----------
    wrench, lost
        As for `loose_axes`.
    """
    loose = np.flatnonzero(loose_axes(wrench, lost)).tolist()
    if not loose:
        return []
    worst = max(loose, key=lambda i: len(stretches(lost[:, i])))
    which = AXES[worst] if len(loose) == 1 else f"{AXES[worst]} and {len(loose) - 1} more"
    unit = "N" if worst < len(AXES) // 2 else "Nm"
    return [_finding(leg, f"{which}: ", wrench[:, worst], stretches(lost[:, worst]), unit)]


def check_loose_cells(readings: FloatArray, names: Sequence[str]) -> list[Finding]:
    """Find cells of one foot that lose contact again and again while their siblings are calm.

    Parameters
    ----------
    readings
        Shape (n, c), NaN where a sample was lost.
    """
    if len(names) < 2:
        return []
    resolution = resolution_of(readings)
    # cell by cell: what is made of all cells of a long log at once is as large as it is
    steps = np.stack(
        [_abrupt(np.diff(column), resolution) | _moving(column) for column in readings.T], 1
    )
    found = []
    for i, name in enumerate(names):
        own = readings[:, i]
        spells = [s for s in stretches(find_spells(own, None, resolution)) if s[0] > 0]
        if len(spells) < OFTEN:
            continue
        least = LEAST * float(np.subtract(*np.nanpercentile(own, [98, 2])))
        others = np.asarray(np.delete(steps, i, axis=1).any(axis=1))
        alone = [
            (start, stop) for start, stop in spells
            if abs(own[start] - own[start - 1]) >= least
            and not _near(others, start - 1) and not _near(others, stop - 1)
        ]  # fmt: skip
        if len(alone) >= OFTEN:
            found.append(_finding(name, "", own, alone, "counts"))
    return found


def _moving(reading: FloatArray) -> BoolArray:
    """Whether a cell is on its way to another load from one sample to the next, shape (n − 1,)."""
    lowest, highest, later = reading[1:].copy(), reading[1:].copy(), reading[1:]
    for by in range(1, _TOGETHER + 2):
        # a sample that was lost hides no other
        for at, seen in ((slice(by, None), slice(-by)), (slice(-by), slice(by, None))):
            np.fmin(lowest[at], later[seen], out=lowest[at])
            np.fmax(highest[at], later[seen], out=highest[at])
    there = reading[np.isfinite(reading)]
    span = float(np.subtract(*np.percentile(there, [98, 2]))) if there.size else 0.0
    highest -= lowest
    return np.asarray(highest > _MOVED * span)


def _near(flags: BoolArray, at: int) -> bool:
    return bool(flags[max(at - _TOGETHER, 0) : at + _TOGETHER + 1].any())


def _finding(
    where: str, which: str, reading: FloatArray, spells: Sequence[tuple[int, int]], unit: str
) -> Finding:
    lengths = [stop - start for start, stop in spells]
    away = [_away(reading, *spell) for spell in spells]
    return Finding(
        "intermittent_contact", "warning", where,
        f"{which}{len(spells)} times the reading leaves its level from one sample to the next, by "
        f"up to {max(away, default=0.0):,.3g} {unit}, and is back after {min(lengths)} to "
        f"{max(lengths)} samples",
        "move its cable and plug while you watch the reading, mend them and record again",
    )  # fmt: skip
