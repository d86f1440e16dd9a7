"""Figures of `kinematics`: path of the CoM, its acceleration, heights of the feet."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core.kinematics import Accelerations, Posture
from footcal_cli.core.parameters import FloatArray
from footcal_cli.plots.style import AFTER, BEFORE, CELL_COLOURS, legend_below, new_figure, tidy

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_SHOWN_S = 6.0


def plot_path(posture: Posture, feet: Sequence[str]) -> Figure:
    """CoM and feet from above."""
    figure = new_figure(3.4)
    axes = figure.subplots()
    axes.plot(posture.com_m[:, 0], posture.com_m[:, 1], color=AFTER, label="CoM")
    for i, (foot, colour) in enumerate(zip(feet, CELL_COLOURS[1:], strict=False)):
        place = posture.feet_m[:, i]
        axes.plot(place[:, 0], place[:, 1], color=colour, linewidth=0.8, label=foot)
    axes.set_aspect("equal", adjustable="datalim")
    tidy(axes, "From above", "x (m)", "y (m)")
    legend_below(figure)
    return figure


def plot_accelerations(time_s: FloatArray, found: Accelerations) -> Figure:
    """Central differences and what the low-pass leaves of them, ± 2 sd of its noise."""
    figure = new_figure(5.0)
    panels = figure.subplots(3, 2, sharex=True)
    rows = time_s <= time_s[0] + _SHOWN_S
    columns = (
        (found.com_acc_mps2, found.com_acc_low_mps2, found.com_acc_sd_mps2, "c̈", "m/s²"),
        (found.angmom_rate_nm, found.angmom_rate_low_nm, found.angmom_rate_sd_nm, "L̇", "N·m"),
    )
    for column, (raw, low, sd, symbol, unit) in enumerate(columns):
        for axis, name in enumerate("xyz"):
            axes = panels[axis, column]
            axes.plot(time_s[rows], raw[rows, axis], color=BEFORE, linewidth=0.6)
            axes.plot(time_s[rows], low[rows, axis], color=AFTER, linewidth=1.2)
            if np.isfinite(sd[axis]):
                axes.fill_between(
                    time_s[rows], low[rows, axis] - 2 * sd[axis], low[rows, axis] + 2 * sd[axis],
                    color=AFTER, alpha=0.2, linewidth=0,
                )  # fmt: skip
            tidy(axes, f"{symbol} {name}", "time (s)" if axis == 2 else "", unit)
    return figure


def plot_heights(time_s: FloatArray, posture: Posture, feet: Sequence[str]) -> Figure:
    """Heights of the feet over the ground."""
    figure = new_figure(2.6)
    axes = figure.subplots()
    for i, (foot, colour) in enumerate(zip(feet, CELL_COLOURS, strict=False)):
        axes.plot(time_s, 1e3 * posture.feet_m[:, i, 2], color=colour, linewidth=1.0, label=foot)
    tidy(axes, "Height of the feet", "time (s)", "mm")
    legend_below(figure)
    return figure
