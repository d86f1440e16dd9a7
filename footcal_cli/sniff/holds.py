"""Loads that stand still in a recording without a load column: how many, at which readings."""

from __future__ import annotations

import numpy as np

from footcal_cli.core.bench.plateaus import PlateauOptions, find_plateaus
from footcal_cli.core.parameters import FloatArray
from footcal_cli.sniff.plan import Blank
from footcal_cli.sniff.texts import FEW

_FEWEST, _ROWS_A_HOLD = 3, 8
_SHORT_S = 4.0
"""Holds shorter than this need other options: by default 3 s of them must stand still."""


def short_holds(time_s: FloatArray, load: FloatArray) -> tuple[str, ...]:
    """Options for a recording whose known load stays for less than 4 s at a time; empty otherwise.

    Half of the shortest hold must stand still, looked at in windows of a third of it. Where
    most of the time passed in longer holds, these are enough; a load of many values is a reference
    in motion.

    Parameters
    ----------
    time_s, load
        Shape (n,).
    """
    good = np.isfinite(time_s) & np.isfinite(load)
    at, put = time_s[good], load[good]
    starts = np.flatnonzero(np.r_[True, np.diff(put) != 0])
    levels = np.unique(put).size
    if starts.size < _FEWEST or levels > FEW or put.size < _ROWS_A_HOLD * starts.size:
        return ()
    stayed = np.diff(np.r_[at[starts], at[-1]])
    rows = np.diff(np.r_[starts, put.size])
    short = stayed < _SHORT_S
    if stayed[short].sum() <= stayed[~short].sum():
        return ()
    shortest = float(stayed[rows >= _ROWS_A_HOLD].min(initial=_SHORT_S))
    if not 0 < shortest < _SHORT_S:
        return ()
    said = f"window_s = {shortest / 3:.3g}, min_hold_s = {shortest / 2:.3g}"
    return (f"plateaus = {{ {said} }}    # likely: each load stayed for {shortest:.3g} s or more",)


def blank_loads(time_s: FloatArray, reading: FloatArray) -> Blank:
    """The loads to be filled in, with what was found of their holds.

    Parameters
    ----------
    time_s, reading
        Shape (n,).
    """
    good = np.isfinite(reading) & np.isfinite(time_s)
    order = np.argsort(time_s[good], kind="stable")
    found = find_plateaus(time_s[good][order], reading[good][order], PlateauOptions())
    levels = np.unique(found.level).size
    medians = [
        f"{np.median(found.median[found.level == level]):.6g}"
        for level in np.unique(found.level)[:12]
    ]
    if not levels:
        said = "no hold was found; widen min_hold_s and max_scatter"
    else:
        said = f"{levels} holds were found, at readings of {', '.join(medians)}"
    places = ", ".join(" " for _ in range(max(levels, 2)))
    return Blank(
        ("# [offline_fit.plateaus]", f'# loads = "{places} kg"    # in order of time: {said}'),
        "the log does not say which loads were put on",
    )
