"""Held-out errors block by block."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core.diagnosis.investigation import Investigation
from footcal_cli.plots.style import AFTER, BEFORE, legend_below, new_figure, tidy

if TYPE_CHECKING:
    from matplotlib.figure import Figure

GAINS_CAPTION = "Error of each block when it is left out of the fit: before and after."


def plot_gains(found: Investigation) -> Figure:
    """Error of each held-out block before and after."""
    gain = max(found.gains, key=lambda g: g.change.value)
    blocks = np.arange(1, len(gain.per_block) + 1)
    figure = new_figure(3.2)
    axes = figure.add_subplot()
    axes.vlines(blocks, gain.per_block[:, 1], gain.per_block[:, 0], color="#c9ced6", linewidth=1.2)
    axes.plot(blocks, gain.per_block[:, 0], "o", color=BEFORE, markersize=5, label="before")
    if found.found:
        axes.plot(blocks, gain.per_block[:, 1], "o", color=AFTER, markersize=5, label="after")
    better = int(np.sum(gain.per_block[:, 1] < gain.per_block[:, 0]))
    title = f"{gain.output}: better in {better} of {blocks.size} held-out blocks"
    tidy(axes, title if found.found else f"{gain.output}: error of each held-out block", "block",
         f"RMS error ({gain.unit})")  # fmt: skip
    axes.set_ylim(bottom=0)
    legend_below(figure)
    return figure
