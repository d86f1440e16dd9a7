"""Wrenches of the ground on the feet over time ([Wu], Figs. 8 and 9)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core.effects.calibration import AXES, AXIS_UNITS
from footcal_cli.core.parameters import FloatArray
from footcal_cli.plots.style import AFTER, BEFORE, CELL_COLOURS, REFERENCE, new_figure, tidy

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MOST_SAMPLES = 4000
_BINS = 60
_TOGETHER_RAD = 0.5
_AXES = tuple(zip(AXES, AXIS_UNITS, strict=True))


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
    style = "-" if along.startswith("time") else "."  # poses follow in no order
    for k, leg in enumerate(legs):
        for i, (axis, unit) in enumerate(_AXES):
            axes = grid[i][k]
            axes.plot(t, before[::step, k, i], style, color=BEFORE, linewidth=0.9, markersize=2)
            axes.plot(t, after[::step, k, i], style, color=AFTER, linewidth=0.9, markersize=2)
            axes.axhline(0.0, color=REFERENCE, linewidth=0.5)
            tidy(axes, leg if i == 0 else "", along if i == 5 else "",
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


def plot_groups(
    phase_rad: FloatArray,
    before: FloatArray,
    after: FloatArray,
    legs: Sequence[str],
    groups: Sequence[Sequence[int]],
) -> Figure:
    """Foot wrenches over the shaft angle, legs that step together in one column (Figs. 8, 9).

    Parameters
    ----------
    phase_rad
        Shaft angles, shape (n, K).
    before, after
        Shape (n, K, 6); thin and thick.
    groups
        Numbers of the legs of each group.
    """
    figure = new_figure(9.0)
    grid = figure.subplots(6, len(groups), sharex=True, sharey="row", squeeze=False)
    edges = np.linspace(-np.pi, np.pi, _BINS + 1)  # straight down in the middle
    turned = np.angle(np.exp(1j * phase_rad))
    middle = np.rad2deg(0.5 * (edges[1:] + edges[:-1]))
    for j, (column, group) in enumerate(zip(grid.T, groups, strict=True)):
        for colour, k in zip(CELL_COLOURS, group, strict=False):
            at = np.clip(np.digitize(turned[:, k], edges) - 1, 0, _BINS - 1)
            for values, width, alpha in ((before, 0.8, 0.55), (after, 1.8, 1.0)):
                lines = np.full((_BINS, 6), np.nan)
                for b in np.unique(at):
                    lines[b] = np.nanmedian(values[at == b, k], axis=0)
                for i, axes in enumerate(column):
                    axes.plot(middle, lines[:, i], color=colour, linewidth=width, alpha=alpha,
                              label=legs[k] if values is after else None)  # fmt: skip
        for i, (axes, (axis, unit)) in enumerate(zip(column, _AXES, strict=True)):
            axes.axhline(0.0, color=REFERENCE, linewidth=0.5)
            axes.set_xticks([-180, -90, 0, 90, 180])
            title = " · ".join(legs[k] for k in group) if i == 0 else ""
            below = "shaft angle (°), 0 straight down" if i == len(_AXES) - 1 else ""
            tidy(axes, title, below, f"{axis} ({unit})" if j == 0 else "")
        column[0].legend(fontsize=8, frameon=False, loc="upper left")
    figure.supxlabel("thin: tare in the air, nominal mounting; thick: calibrated; medians over "
                     "the cycles", fontsize=8)  # fmt: skip
    return figure


def stepping_together(phase_rad: FloatArray) -> tuple[tuple[int, ...], ...]:
    """Legs whose shafts stay within `_TOGETHER_RAD` of each other on the circle, as groups.

    Parameters
    ----------
    phase_rad
        Shape (n, K).
    """
    groups: list[list[int]] = []
    for k in range(phase_rad.shape[1]):
        for group in groups:
            between = np.exp(1j * (phase_rad[:, k] - phase_rad[:, group[0]])).mean()
            if abs(between) > np.cos(_TOGETHER_RAD) and abs(np.angle(between)) < _TOGETHER_RAD:
                group.append(k)
                break
        else:
            groups.append([k])
    return tuple(tuple(group) for group in groups)
