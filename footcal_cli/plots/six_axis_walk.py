"""Figures of `online-replay` on six-axis feet."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core.effects.calibration import AXES
from footcal_cli.core.online.filter import Track
from footcal_cli.core.online.jumps import BiasJump
from footcal_cli.core.online.six_axis_replay import SixAxisReplay
from footcal_cli.plots.style import (
    AFTER,
    BEFORE,
    CELL_COLOURS,
    REFERENCE,
    legend_below,
    new_figure,
    tidy,
)
from footcal_cli.plots.words import capital

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def plot_vertical(found: SixAxisReplay) -> Figure:
    """Total vertical force before and after, against what the model's mass demands."""
    figure = new_figure(3.0)
    axes = figure.subplots()
    time_s = found.merged.log.time_s
    for column, colour, label in (
        (0, BEFORE, "as logged"),
        (1, AFTER, "calibrated"),
        (2, REFERENCE, "mass of the model × (g + CoM acceleration)"),
    ):
        axes.plot(time_s, found.vertical_n[:, column], color=colour, linewidth=1.0, label=label)
    tidy(axes, "Total vertical force on both feet", "time (s)", "force (N)")
    legend_below(figure)
    return figure


def plot_swing(found: SixAxisReplay) -> Figure:
    """What each foot's transducer reads in the air, before and after, axis by axis."""
    names = found.rows.outputs[found.rows.totals :]
    feet = tuple(dict.fromkeys(name.split(".")[0] for name in names))
    figure = new_figure(3.4)
    panels = figure.subplots(2, len(feet), sharey="row", squeeze=False)
    place = np.arange(3)
    for k, foot in enumerate(feet):
        for row, (axes_names, unit) in enumerate(((AXES[:3], "N"), (AXES[3:], "Nm"))):
            axes = panels[row, k]
            for shift, colour, errors in (
                (-0.18, BEFORE, found.before),
                (0.18, AFTER, found.after),
            ):
                columns = [found.rows.totals + names.index(f"{foot}.{a}") for a in axes_names]
                mean = np.nanmean(errors[:, columns], axis=0)
                spread = np.nanstd(errors[:, columns], axis=0)
                axes.errorbar(
                    place + shift, mean, yerr=2 * spread, fmt="o", color=colour, markersize=4,
                    capsize=3,
                )  # fmt: skip
            axes.axhline(0.0, color=REFERENCE, linewidth=0.6)
            axes.set_xticks(place, list(axes_names))
            label = f"reading ({unit})" if k == 0 else ""
            tidy(axes, f"{capital(foot)} foot in the air, ± 2 sd" if row == 0 else "", "", label)
    return figure


def plot_offsets(
    track: Track, smoothed: Track, feet: Sequence[str], jumps: Sequence[BiasJump]
) -> Figure:
    """Offsets over time with ± 2 sd of the filter; the smoother's as a line; jumps dashed."""
    figure = new_figure(4.4)
    panels = figure.subplots(2, len(feet), sharex=True, squeeze=False)
    for k, foot in enumerate(feet):
        for row, (axes_names, unit) in enumerate(((AXES[:3], "N"), (AXES[3:], "Nm"))):
            axes = panels[row, k]
            for colour, axis in zip(CELL_COLOURS, axes_names, strict=False):
                i = track.names.index(f"{foot}.offset_{axis}")
                value, sd = track.values[:, i], track.sd[:, i]
                axes.fill_between(
                    track.time_s, value - 2 * sd, value + 2 * sd, color=colour, alpha=0.15,
                    linewidth=0,
                )  # fmt: skip
                axes.plot(
                    track.time_s, smoothed.values[:, i], color=colour, linewidth=1.2, label=axis
                )
                for jump in jumps:
                    if jump.name == track.names[i]:
                        axes.axvline(jump.onset_s, color=colour, linewidth=1.0, linestyle="--")
            spread = np.nanmax(np.abs(smoothed.values[:, [
                track.names.index(f"{foot}.offset_{a}") for a in axes_names]]))  # fmt: skip
            axes.set_ylim(-2.0 * spread - 0.1, 2.0 * spread + 0.1)
            label = f"offset ({unit})" if k == 0 else ""
            title = f"{capital(foot)} foot" if row == 0 else ""
            tidy(axes, title, "time (s)" if row else "", label)
    legend_below(figure, columns=6)
    return figure
