"""Calibrated forces of a log over time, and the centre of pressure under each foot."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.plots.style import (
    AFTER,
    BEFORE,
    CELL_COLOURS,
    REFERENCE,
    legend_below,
    new_figure,
    tidy,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST_DOTS = 20_000


@dataclass(frozen=True)
class FootOutline:
    """Where the cells of a foot lie, shape (c, 2), and its outline, in metres in its frame."""

    cells_m: FloatArray
    outline_m: Sequence[tuple[float, float]] = ()


def plot_forces(
    time_s: FloatArray, forces_n: Mapping[str, FloatArray], weight_n: float | None
) -> Figure:
    """Vertical force of every foot, or of every cell, their sum, and the robot's weight."""
    figure = new_figure(3.0)
    axes = figure.subplots()
    for (name, force), colour in zip(forces_n.items(), CELL_COLOURS * len(forces_n), strict=False):
        axes.plot(time_s, force, color=colour, linewidth=1.2, label=name)
    if len(forces_n) > 1:
        total = np.sum(list(forces_n.values()), axis=0)
        axes.plot(time_s, total, color=REFERENCE, linewidth=1.0, label="sum")
    if weight_n is not None:
        axes.axhline(weight_n, color=BEFORE, linestyle="--", linewidth=1.2, label="robot's weight")
    tidy(axes, "Vertical force after calibration", "time (s)", "force (N)")
    legend_below(figure, columns=8)
    return figure


def plot_cop_in_feet(cop_m: Mapping[str, FloatArray], feet: Mapping[str, FootOutline]) -> Figure:
    """CoP under every foot in its own frame, with cells and outline."""
    figure = new_figure(4.2)
    panels = figure.subplots(1, len(feet), squeeze=False, sharey=True)[0]
    for axes, (name, foot) in zip(panels, feet.items(), strict=True):
        draw_foot(axes, f"{name.capitalize()} foot", cop_m[name], foot)
    panels[0].set_ylabel("forward (mm)", fontsize=9)
    return figure


def along_the_foot(cop_m: Mapping[str, FloatArray]) -> str:
    """Where the CoP (n, 2) of each foot lies along it, in one sentence."""
    spans = []
    for name, places in cop_m.items():
        forward = 1e3 * places[np.isfinite(places[:, 0]), 0]
        low, high = np.quantile(forward, (0.05, 0.95)) if forward.size else (np.nan, np.nan)
        span = f"{low:z.0f} … {high:z.0f} mm".replace("-", "−") if forward.size else "none"
        spans.append(f"{name} {span}")
    return f"90 % of the CoP along the foot: {', '.join(spans)}."


def draw_foot(axes: Axes, title: str, cop_m: FloatArray, foot: FootOutline) -> None:
    """A foot from above, its front up: CoP (n, 2), cells and outline in millimetres."""
    dots = 1e3 * cop_m[:: max(-(-len(cop_m) // _MOST_DOTS), 1)]
    axes.plot(-dots[:, 1], dots[:, 0], ".", markersize=1.0, color=AFTER)
    axes.plot(-1e3 * foot.cells_m[:, 1], 1e3 * foot.cells_m[:, 0], "s", color=REFERENCE,
              markersize=5)  # fmt: skip
    if len(foot.outline_m):
        closed = 1e3 * np.array([*foot.outline_m, foot.outline_m[0]])
        axes.plot(-closed[:, 1], closed[:, 0], color=BEFORE, linewidth=1.2)
    axes.set_aspect("equal")
    tidy(axes, title, "to the right (mm)")
