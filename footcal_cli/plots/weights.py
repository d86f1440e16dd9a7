"""Figures of known weights on single load cells."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core.bench.regression import AffineFit
from footcal_cli.core.parameters import FloatArray
from footcal_cli.plots.style import AFTER, BAD, CELL_COLOURS, MARKERS, new_figure, tidy
from footcal_cli.records.display_units import display_unit

if TYPE_CHECKING:
    from matplotlib.figure import Figure


_MANY_COUNTS = 2000.0
"""From this range on counts are drawn in reading."""


def plot_loads_against_counts(fits: Sequence[AffineFit], tolerance_n: float) -> Figure:
    """Per channel: load against counts with the fitted line, and the residual below."""
    across = min(4, len(fits))
    down = int(np.ceil(len(fits) / across))
    figure = new_figure(3.1 * down + 0.3, width_in=2.9 * across)
    grid = figure.add_gridspec(2 * down, across, height_ratios=[2.2, 1.0] * down)
    worst = max(max(fit.worst_n for fit in fits), tolerance_n) * 1.25
    for i, fit in enumerate(fits):
        row, column = divmod(i, across)
        upper = figure.add_subplot(grid[2 * row, column])
        lower = figure.add_subplot(grid[2 * row + 1, column], sharex=upper)
        colour = AFTER if fit.worst_n <= tolerance_n else BAD
        offset = fit.counts - fit.centre_counts
        many = float(np.abs(offset).max()) >= _MANY_COUNTS
        reading = offset / 1e3 if many else offset
        order = np.argsort(reading)
        upper.plot(reading[order], fit.predicted_n[order], color=colour, linewidth=1.2)
        upper.plot(reading, fit.load_n, "o", color="#1b1f24", markersize=4)
        tidy(upper, fit.channel, "", "load (N)" if column == 0 else "")
        upper.tick_params(labelbottom=False)
        lower.axhspan(-tolerance_n, tolerance_n, color="#e8f1f8")
        lower.vlines(reading, 0, fit.residual_n, color=colour, linewidth=1.4)
        lower.plot(reading, fit.residual_n, "o", color=colour, markersize=3.5)
        lower.axhline(0, color="#1b1f24", linewidth=0.7)
        lower.set_ylim(-worst, worst)
        tidy(
            lower,
            "",
            "counts − mean (10³)" if many else "counts − mean",
            "residual (N)" if column == 0 else "",
        )
    return figure


def mean_residuals(fit: AffineFit) -> tuple[FloatArray, FloatArray]:
    """Each known load of a channel, and the mean residual there, newtons."""
    loads = np.unique(fit.load_n)
    return loads, np.array([fit.residual_n[fit.load_n == load].mean() for load in loads])


def plot_residuals(fits: Sequence[AffineFit], tolerance_n: float) -> Figure:
    """Residuals of all channels on one axis against load: a shared bend is seen at once."""
    figure = new_figure(3.8)
    axes = figure.add_subplot()
    axes.axhspan(-tolerance_n, tolerance_n, color="#e8f1f8", label=f"± {tolerance_n:.3g} N asked")
    for i, fit in enumerate(fits):
        loads, mean = mean_residuals(fit)
        colour = CELL_COLOURS[i % len(CELL_COLOURS)]
        axes.plot(loads, mean, f"{MARKERS[i % len(MARKERS)]}-", color=colour, linewidth=1.2,
                  markersize=4, label=fit.channel)  # fmt: skip
    axes.axhline(0, color="#1b1f24", linewidth=0.8)
    tidy(axes, "Mean residual of the straight line (should be flat)", "known load (N)",
         "measured − known (N)")  # fmt: skip
    axes.legend(fontsize=8, ncols=1, frameon=False, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure


def plot_scales(fits: Sequence[AffineFit]) -> Figure:
    """Scales with 95 % intervals side by side."""
    figure = new_figure(0.34 * len(fits) + 1.2)
    axes = figure.add_subplot()
    places = np.arange(len(fits))[::-1]
    factor, unit = display_unit("N/count", [fit.scale_n_per_count for fit in fits])
    for place, fit in zip(places, fits, strict=True):
        low, high = factor * fit.ci95[0]
        axes.plot([low, high], [place, place], color=AFTER, linewidth=2.2, alpha=0.6)
        axes.plot(factor * fit.scale_n_per_count, place, "o", color=AFTER, markersize=5)
    axes.set_yticks(places, [fit.channel for fit in fits])
    tidy(axes, "Scale of each cell with 95 % interval", f"scale ({unit})", "")
    return figure
