"""Wrenches of the ground on the feet over time (seed 2, Figs. 8 and 9)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.plots.style import AFTER, BEFORE, REFERENCE, new_figure, tidy

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MOST_SAMPLES = 4000
_AXES = (("fx", "N"), ("fy", "N"), ("fz", "N"), ("tx", "Nm"), ("ty", "Nm"), ("tz", "Nm"))


def plot_feet(
    time_s: FloatArray,
    before: FloatArray,
    after: FloatArray,
    legs: Sequence[str],
    along: str = "time (s)",
) -> Figure:
    """One column per foot, one row per component; before in grey, after in blue."""
    step = max(time_s.size // _MOST_SAMPLES, 1)
    figure = new_figure(9.0, width_in=2.0 * len(legs) + 0.8)
    grid = figure.subplots(6, len(legs), sharex=True, sharey="row", squeeze=False)
    t = time_s[::step] - time_s[0]
    for k, leg in enumerate(legs):
        for i, (axis, unit) in enumerate(_AXES):
            axes = grid[i][k]
            axes.plot(t, before[::step, k, i], color=BEFORE, linewidth=0.9)
            axes.plot(t, after[::step, k, i], color=AFTER, linewidth=0.9)
            axes.axhline(0.0, color=REFERENCE, linewidth=0.5)
            tidy(axes, leg.upper() if i == 0 else "", along if i == 5 else "",
                 f"{axis} ({unit})" if k == 0 else "")  # fmt: skip
    for i in range(6):
        both = np.concatenate([before[:, :, i].ravel(), after[:, :, i].ravel()])
        low, high = np.quantile(both[np.isfinite(both)], [0.002, 0.998])
        room = 0.08 * max(high - low, 1e-3)
        grid[i][0].set_ylim(low - room, high + room)
    grid[0][0].plot([], [], color=BEFORE, label="tare in the air, nominal mounting")
    grid[0][0].plot([], [], color=AFTER, label="calibrated")
    figure.legend(*grid[0][0].get_legend_handles_labels(), loc="outside lower center", ncols=2,
                  frameon=False, fontsize=9)  # fmt: skip
    return figure
