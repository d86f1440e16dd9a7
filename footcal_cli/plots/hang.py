"""Figures of hanging legs: residual violins, CoM against phase, tilts ([Wu], Figs. 4, 5, 7)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core.effects.calibration import AXES, AXIS_UNITS
from footcal_cli.core.hang.binned import BinnedCom
from footcal_cli.core.hang.joint import HangFit
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.spatial import tangent_basis
from footcal_cli.core.study.stepwise import StepwiseFit
from footcal_cli.plots.style import (
    AFTER,
    BEFORE,
    CELL_COLOURS,
    MARKERS,
    REFERENCE,
    new_figure,
    tidy,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_VIOLIN_POINTS = 100
_VIOLIN_SAMPLES = 3000
_AXES = tuple(zip(AXES, AXIS_UNITS, strict=True))
_SEEN_MM = 50.0
"""A fitted CoM known worse than this is not drawn."""
_SHOWN = {"before": BEFORE, "after": AFTER}


def draw_violins(
    axes: Axes, samples: list[FloatArray], places: FloatArray, colour: str, width: float
) -> None:
    """One violin per sample set; sets without spread become a line."""
    for values, place in zip(samples, places, strict=True):
        values = values[np.isfinite(values)]
        if values.size < 2 or np.ptp(values) < 1e-12:
            axes.plot([place], [values.mean() if values.size else 0.0], "_", color=colour)
            continue
        step = max(values.size // _VIOLIN_SAMPLES, 1)
        parts = axes.violinplot(
            [values[::step]], [place], widths=width, points=_VIOLIN_POINTS, showextrema=False
        )
        for body in parts["bodies"]:  # type: ignore[attr-defined]  # a list of collections
            body.set_facecolor(colour)
            body.set_alpha(0.75)
            body.set_linewidth(0.0)


def plot_residuals(residuals: Mapping[str, Mapping[str, FloatArray]]) -> Figure:
    """Violins of force and torque residuals, legs side by side, before and after."""
    legs = list(residuals["after"])
    figure = new_figure(5.4)
    grid = figure.subplots(2, 3, squeeze=False)
    for i, (axis, unit) in enumerate(_AXES):
        axes = grid[i // 3][i % 3]
        for k, (stage, colour) in enumerate(_SHOWN.items()):
            samples = [residuals[stage][leg][:, i] for leg in legs]
            draw_violins(axes, samples, np.arange(float(len(legs))) + 0.4 * k - 0.2, colour, 0.38)
        axes.axhline(0.0, color=REFERENCE, linewidth=0.7)
        axes.set_xticks(range(len(legs)), legs)
        tidy(axes, axis, "", f"measured − model ({unit})" if i % 3 == 0 else "")
    for stage, colour in _SHOWN.items():
        grid[0][0].plot([], [], color=colour, linewidth=6, alpha=0.75, label=stage)
    figure.legend(*grid[0][0].get_legend_handles_labels(), loc="outside lower center", ncols=2,
                  frameon=False, fontsize=9)  # fmt: skip
    return figure


def plot_com(fits: Mapping[str, HangFit | StepwiseFit], binned: Mapping[str, BinnedCom]) -> Figure:
    """CoM of every leg against the shaft angle: bands of the data, and the fitted series."""
    across = min(3, len(fits))
    down = int(np.ceil(len(fits) / across))
    figure = new_figure(2.6 * down + 0.5)
    grid = figure.subplots(down, across, squeeze=False, sharex=True, sharey=True)
    phase = np.linspace(0.0, 2 * np.pi, 200)
    for i, (leg, fit) in enumerate(fits.items()):
        axes = grid[i // across][i % across]
        data = binned[leg]
        com = 1e3 * fit.com_t_m(phase)
        seen = isinstance(fit, StepwiseFit) or 1e3 * fit.com_sd_m(phase).max(axis=0) < _SEEN_MM
        for a, name in enumerate("xyz"):
            colour = CELL_COLOURS[a]
            for low, high, alpha in (
                (data.low95_m, data.high95_m, 0.15),
                (data.low_m, data.high_m, 0.35),
            ):
                axes.fill_between(
                    data.phase_rad, 1e3 * low[:, a], 1e3 * high[:, a],
                    color=colour, alpha=alpha, linewidth=0,
                )  # fmt: skip
            axes.plot(data.phase_rad, 1e3 * data.median_m[:, a], "o", color=colour, markersize=2.5)
            if np.broadcast_to(seen, 3)[a]:
                axes.plot(phase, com[:, a], "--", color=REFERENCE, linewidth=0.9)
            axes.plot([], [], color=colour, linewidth=3, label=name)
        axes.plot([], [], "--", color=REFERENCE, linewidth=0.9, label="fitted")
        axes.set_xticks([0, np.pi, 2 * np.pi], ["0", "π", "2π"])
        tidy(
            axes,
            leg,
            "shaft angle φ (rad)" if i // across == down - 1 else "",
            "leg CoM (mm)" if i % across == 0 else "",
        )
    for j in range(len(fits), down * across):
        grid[j // across][j % across].set_visible(False)
    figure.legend(*grid[0][0].get_legend_handles_labels(), loc="outside lower center", ncols=4,
                  frameon=False, fontsize=9)  # fmt: skip
    return figure


def plot_tilts(fits: Mapping[str, HangFit], gravity_dir_t: Mapping[str, FloatArray]) -> Figure:
    """Where gravity pointed in each orientation, seen along the named axis.

    Parameters
    ----------
    fits
        For the names and nominal directions of the orientations.
    gravity_dir_t
        Leg -> the direction that the shown method found, shape (L, 3).
    """
    from matplotlib.ticker import MaxNLocator

    first = next(iter(fits.values()))
    count = min(len(first.model.log_labels()), 4)
    figure = new_figure(3.3, width_in=2.3 * count + 0.8)
    grid = figure.subplots(1, count, squeeze=False)
    names = first.model.log_labels()[:count]
    widest = 1.0
    for j, label in enumerate(names):
        axes = grid[0][j]
        for i, (leg, fit) in enumerate(fits.items()):
            labels = fit.model.log_labels()
            if label not in labels:
                continue
            at = labels.index(label)
            basis = tangent_basis(fit.model.nominal_dir_t[at])
            basis = basis * np.sign(basis[np.argmax(np.abs(basis), axis=0), [0, 1]])
            lean = np.rad2deg(basis.T @ gravity_dir_t[leg][at])
            widest = max(widest, float(np.abs(lean).max()))
            axes.plot(*lean, MARKERS[i % len(MARKERS)], color=CELL_COLOURS[i % len(CELL_COLOURS)],
                      markersize=5,
                      label=leg)  # fmt: skip
        axes.axhline(0, color=REFERENCE, linewidth=0.6)
        axes.axvline(0, color=REFERENCE, linewidth=0.6)
        axes.set_aspect("equal")
        across = [a for a in "xyz" if a != label[-1]] if label[-1] in "xyz" else ["a", "b"]
        tidy(axes, label.replace("plus_", "+").replace("minus_", "−").replace("log_", "log "),
             f"towards {across[0]} (°)", f"towards {across[1]} (°)" if j == 0 else "")  # fmt: skip
    for axes in grid[0]:
        axes.set_xlim(-1.2 * widest, 1.2 * widest)
        axes.set_ylim(-1.2 * widest, 1.2 * widest)
        axes.xaxis.set_major_locator(MaxNLocator(5, symmetric=True))
        axes.yaxis.set_major_locator(MaxNLocator(5, symmetric=True))
    figure.legend(*grid[0][0].get_legend_handles_labels(), loc="outside lower center", ncols=6,
                  frameon=False, fontsize=8)  # fmt: skip
    return figure
