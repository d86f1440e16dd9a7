"""Figures of simulated logs: what was shown over what was true."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core.log import Log
from footcal_cli.plots.style import CELL_COLOURS, REFERENCE, new_figure, tidy

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SHOWN_ROWS = 1600
"""Rows of a picture: twenty seconds of cells."""


def plot_shown_and_true(believed: Log, truth: Log) -> Figure:
    """Readings under the true calibration over the true loads, and their difference."""
    shown = believed
    rows = slice(0, min(SHOWN_ROWS, len(shown)))
    by_time = bool(np.all(np.diff(shown.time_s[rows]) > 0))
    x = shown.time_s[rows] if by_time else np.arange(rows.stop)
    count = min(len(shown.channels), len(CELL_COLOURS))
    figure = new_figure(5.4)
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=[1.6, 1.0])
    for i in range(count):
        upper.plot(x, believed.readings[rows, i], color=CELL_COLOURS[i], linewidth=0.9,
                   label=shown.channels[i])  # fmt: skip
        upper.plot(x, truth.readings[rows, i], color=REFERENCE, linewidth=0.5)
        lower.plot(
            x, believed.readings[rows, i] - truth.readings[rows, i],
            color=CELL_COLOURS[i], linewidth=0.7,
        )  # fmt: skip
    torques = any(name.rpartition(".")[2].startswith("t") for name in shown.channels)
    unit = "N; Nm on torque axes" if torques else "N"
    tidy(upper, "Measured (colour) and true (thin)", "", f"load ({unit})")
    upper.legend(fontsize=8, frameon=False, loc="center left", bbox_to_anchor=(1.0, 0.5))
    tidy(lower, "Measured − true", "time (s)" if by_time else "row", f"difference ({unit})")
    return figure
