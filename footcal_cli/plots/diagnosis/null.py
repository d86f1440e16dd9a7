"""The largest statistic under random signs of blocks."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core.diagnosis.investigation import Investigation
from footcal_cli.plots.style import BAD, BEFORE, REFERENCE, legend_below, new_figure, tidy

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def caption(found: Investigation) -> str:
    """How to read the figure, and why an effect beyond chance need not be a cause."""
    beyond = (
        " An effect beyond chance is a cause only if its size is possible and it predicts blocks "
        "that were left out."
    )
    return (
        "Grey: the largest statistic of the whole table when whole blocks change sign at random; "
        "orange: that of the data." + ("" if found.found else beyond)
    )


def in_words(found: Investigation) -> str:
    """The statistic of the data against its 1 % limit by chance."""
    null = found.rounds[0].search.first.null_max
    if not null.size:
        return "Too few blocks for random signs."
    limit = float(np.quantile(null, 0.99))
    return f"{null[0]:.2f} in the data; by chance 1 % lie above {limit:.2f}."


def plot_null(found: Investigation) -> Figure:
    """Null distribution of the largest statistic and the observed one."""
    evidence = found.rounds[0].search.first
    figure = new_figure(2.8)
    axes = figure.add_subplot()
    null = evidence.null_max
    if null.size:
        axes.hist(null, bins=40, color=BEFORE)
        axes.axvline(null[0], color=BAD, linewidth=2, label="the data")
        axes.axvline(
            np.quantile(null, 0.99), color=REFERENCE, linewidth=1, linestyle=":",
            label="1 % by chance",
        )  # fmt: skip
        legend_below(figure)
    tidy(axes, "Largest statistic |T| of all effects: the data, and with random signs of blocks",
         "largest |T|", "random sign patterns")  # fmt: skip
    return figure
