"""Readings that leave their level at once and come back: a plug or a wire that loses contact.

Room: checks; asked by the session, of legs that hang, whose loads change slowly.
"""

from __future__ import annotations

import numpy as np

from footcal_cli.core.effects.calibration import AXES
from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray
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
_FEWEST = 50
_NEAR = 3
"""Samples that tell the level before and after a spell."""


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
        How the sensor was held and turned, shape (n, k): where that steps, the load does.
    resolution
        Step of the converter.
    """
    found = np.zeros(reading.size, dtype=bool)
    good = np.flatnonzero(np.isfinite(reading))
    if good.size < _FEWEST:
        return found
    level, steps = reading[good], np.diff(reading[good])
    size = np.abs(steps)
    beside = np.maximum(np.r_[0.0, size[:-1]], np.r_[size[1:], 0.0])
    # what moves takes several samples
    abrupt = (size > ABRUPT * max(median_sd(steps), resolution)) & (beside < BACK * size)
    if held is not None:
        turned = np.abs(np.diff(held[good], axis=0))
        abrupt &= ~np.any(turned > ABRUPT * np.nanmedian(turned, axis=0), axis=1)
    edges = np.flatnonzero(abrupt)
    longest, end = LONGEST * good.size, -1
    for out in edges:
        if out <= end:
            continue
        later = edges[(edges > out) & (edges <= out + longest)]
        back = _back(level, int(out), later, steps[out])
        if back is not None:
            found[good[out] + 1 : good[back] + 1] = True
            end = back
        elif good.size - out <= longest:
            found[good[out] + 1 :] = True
        elif out <= longest:
            found[: good[out] + 1] = True
    return found


def _back(level: FloatArray, out: int, later: IntArray, step: float) -> int | None:
    """The first of some later steps after which the level is what it was before a step."""
    before = float(np.median(level[max(out + 1 - _NEAR, 0) : out + 1]))
    for back in later:
        after = float(np.median(level[back + 1 : back + 1 + _NEAR]))
        if abs(after - before) <= BACK * abs(step):
            return int(back)
    return None


def spells_of(wrench: FloatArray, held: FloatArray | None = None) -> BoolArray:
    """`find_spells` of each axis of one recording of a leg, shape (n, 6)."""
    steps = [resolution_of(wrench[:, :3])] * 3 + [resolution_of(wrench[:, 3:])] * 3
    return np.stack(
        [find_spells(axis, held, step) for axis, step in zip(wrench.T, steps, strict=True)], 1
    )


def is_loose(lost: BoolArray) -> bool:
    """Whether an axis, from its samples of spells, shape (n,), loses contact again and again."""
    return len(stretches(lost)) >= OFTEN


def check_spells(leg: str, wrench: FloatArray, lost: BoolArray) -> list[Finding]:
    """Say of a leg that an axis or all of them lose contact again and again.

    Parameters
    ----------
    wrench, lost
        All recordings of the leg one after the other, and `spells_of` them, shape (n, 6).
    """
    runs = [stretches(axis) for axis in lost.T]
    loose = [i for i, axis in enumerate(lost.T) if is_loose(axis)]
    if not loose:
        return []
    worst = max(loose, key=lambda i: len(runs[i]))
    lengths = [stop - start for start, stop in runs[worst]]
    away = [
        abs(float(np.nanmedian(wrench[start:stop, worst]) - wrench[start - 1, worst]))
        for start, stop in runs[worst]
    ]
    unit = "N" if worst < 3 else "Nm"
    which = AXES[worst] if len(loose) == 1 else f"{AXES[worst]} and {len(loose) - 1} more"
    return [
        Finding(
            "intermittent_contact", "warning", leg,
            f"{which}: {len(runs[worst])} times the reading leaves its level from one sample to "
            f"the next, by up to {max(away):.3g} {unit}, and is back after {min(lengths)} to "
            f"{max(lengths)} samples",
            "move its cable and plug while you watch the reading, mend them and record again",
        )
    ]  # fmt: skip
