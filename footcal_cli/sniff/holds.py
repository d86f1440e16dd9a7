"""Loads that stand still in a recording without a load column: how many, at which readings."""

from __future__ import annotations

import numpy as np

from footcal_cli.core.bench.plateaus import PlateauOptions, find_plateaus
from footcal_cli.core.parameters import FloatArray
from footcal_cli.sniff.plan import Blank


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
