"""The data hidden among what chance makes of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core.diagnosis.investigation import Investigation
from footcal_cli.core.diagnosis.material import left_over
from footcal_cli.plots.diagnosis.residuals import binned, driver_of, main_output
from footcal_cli.plots.style import AFTER, REFERENCE, new_figure, tidy
from footcal_cli.plots.words import signal_label

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LINE_UP_CAPTION = (
    "Nineteen panels show residuals with random signs, one shows the data. Picking the right one "
    "at sight is evidence at p = 1/20."
)


_PANELS = 20


def place_of_data(seed: int) -> int:
    """Number of the panel that shows the data, from 1."""
    return int(np.random.default_rng(seed + 1).integers(_PANELS)) + 1


def plot_line_up(found: Investigation, seed: int) -> Figure:
    """The data among nineteen data sets whose blocks had their signs flipped."""
    name, driver = driver_of(found)
    output = main_output(found)
    problem = found.problem
    rows = np.flatnonzero(problem.output == output)
    left = left_over(problem)[rows]
    rng = np.random.default_rng(seed + 1)
    place = int(rng.integers(_PANELS))  # the first draw, as in `place_of_data`
    figure = new_figure(5.6)
    grid = figure.subplots(4, 5, sharex=True, sharey=True)
    spread = 0.0
    for i, axes in enumerate(grid.ravel()):
        signs = np.ones(problem.blocks)
        if i != place:
            signs = rng.choice([-1.0, 1.0], problem.blocks)
        values = left * signs[problem.block[rows]]
        middle, mean, half = binned(driver[rows], values, problem.block[rows])
        spread = max(spread, float(np.max(np.abs(mean) + half, initial=0.0)))
        axes.fill_between(middle, mean - half, mean + half, color=AFTER, alpha=0.25, linewidth=0)
        axes.plot(middle, mean, color=AFTER, linewidth=1.4)
        axes.axhline(0, color=REFERENCE, linewidth=0.6)
        tidy(axes, f"{i + 1}")
        axes.tick_params(labelsize=6)
    grid.ravel()[0].set_ylim(-1.1 * spread - 1e-12, 1.1 * spread + 1e-12)
    figure.supxlabel(signal_label(name), fontsize=9)
    figure.supylabel("mean residual (noise sd)", fontsize=9)
    return figure
