"""Figure of a full matrix: which reading goes into which load."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core.bench.matrix import MatrixFit
from footcal_cli.plots.style import AFTER, BEFORE, CELL_COLOURS, new_figure, tidy

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def plot_matrix(channels: Sequence[str], outputs: Sequence[str], fit: MatrixFit) -> Figure:
    """Off-diagonal elements in percent of the largest of their row, with 95 % intervals."""
    count, wide = fit.matrix.shape
    spread = fit.reading_high - fit.reading_low
    moved = fit.matrix * spread
    largest = np.abs(moved).max(axis=1, keepdims=True)
    half = (fit.ci95[:, 1] - fit.ci95[:, 0]).reshape(count, wide + 1)[:, :wide] / 2.0 * spread
    share, width = 100.0 * moved / largest, 100.0 * half / largest
    figure = new_figure(0.5 * count + 1.4)
    axes = figure.add_subplot()
    for i in range(count):
        for j in range(wide):
            if abs(share[i, j]) > 99.999:
                continue
            place = -i + 0.5 * (0.5 - (j + 0.5) / wide)
            sure = abs(share[i, j]) > width[i, j]
            colour = CELL_COLOURS[j % len(CELL_COLOURS)] if sure else BEFORE
            axes.plot([share[i, j] - width[i, j], share[i, j] + width[i, j]], [place, place],
                      color=colour, linewidth=1.6)  # fmt: skip
            axes.plot(share[i, j], place, "o", color=colour, markersize=4)
    for j, channel in enumerate(channels):
        axes.plot([], [], "o", color=CELL_COLOURS[j % len(CELL_COLOURS)], label=channel)
    axes.axvline(0, color=AFTER, linewidth=0.8)
    axes.set_ylim(-count + 0.4, 0.6)
    axes.set_yticks([-i for i in range(count)], list(outputs))
    tidy(axes, "What each reading adds to each load besides the main one",
         "% of the row's largest element", "")  # fmt: skip
    axes.legend(fontsize=8, frameon=False, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure
