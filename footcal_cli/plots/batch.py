"""Figures of `batch`: parameters over sessions, and where their spread comes from."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core.fleet import Budget, ParameterSeries
from footcal_cli.plots.style import (
    BAD,
    BEFORE,
    CELL_COLOURS,
    REFERENCE,
    legend_below,
    new_figure,
    tidy,
)
from footcal_cli.plots.words import words
from footcal_cli.records.display_units import display_unit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_PANELS = 12
_MOST_POINTS = 400
_SOURCES = dict(zip(("repeatability", "day", "operator"), CELL_COLOURS, strict=False))


def plot_series(series: Sequence[ParameterSeries], dated: bool) -> Figure:
    """Each parameter over the sessions with 95 % intervals; levels, change points, outliers.

    Parameters
    ----------
    series
        Of one kind of parameter; a panel per parameter, a colour per robot.
    dated
        Whether time is in days; else sessions are numbered.
    """
    names = list(dict.fromkeys(one.parameter for one in series))[:MOST_PANELS]
    robots = sorted({one.robot for one in series})
    columns = 1 if len(names) == 1 else 2
    rows = -(-len(names) // columns)
    figure = new_figure(2.0 * rows + 0.5)
    panels = figure.subplots(rows, columns, sharex=True, squeeze=False).ravel()
    for axes in panels[len(names) :]:
        axes.set_visible(False)
    for axes, name in zip(panels, names, strict=False):
        factor, unit = _unit_of(series, name)
        for one in (s for s in series if s.parameter == name):
            k = robots.index(one.robot)
            start = factor * one.levels[0].value if len(robots) > 1 else 0.0
            values = factor * one.values
            colour = CELL_COLOURS[k] if k < len(CELL_COLOURS) else BEFORE
            # interval bars of many sessions: every so many-th, but all that lie apart
            every = -(-one.time.size // _MOST_POINTS)
            shown = (np.arange(one.time.size) % every == 0) | one.outlying
            axes.errorbar(
                one.time[shown], values[shown] - start, 2.0 * factor * one.sd[shown], fmt="o",
                markersize=3, linewidth=0.8, color=colour, label=one.robot,
            )  # fmt: skip
            for number, level in enumerate(one.levels):
                inside = one.time[one.segment == number]
                height = factor * level.value - start
                if one.drifting and one.trend is not None:
                    ends = np.array([one.time.min(), one.time.max()])
                    drift = factor * one.trend.slope * (ends - one.time.mean())
                    axes.plot(ends, height + drift, color=colour, linewidth=1.4)
                elif inside.size:
                    axes.plot([inside.min(), inside.max()], [height] * 2, color=colour)
            for change in one.changes:
                between = 0.5 * (one.time[change.first_after - 1] + one.time[change.first_after])
                axes.axvline(between, color=BAD, linestyle="--", linewidth=1.0)
            apart = one.outlying
            axes.plot(
                one.time[apart], values[apart] - start, "o", markersize=9,
                markerfacecolor="none", markeredgecolor=BAD, linestyle="none",
            )  # fmt: skip
        kind = words(name.rsplit(".", 1)[-1])
        tidy(axes, name, "", f"{kind} ({unit})" if unit not in ("", "-") else kind)
    for axes in panels[max(len(names) - columns, 0) : len(names)]:
        axes.set_xlabel("days since the first session" if dated else "session", fontsize=9)
        axes.xaxis.set_tick_params(labelbottom=True)
    if 1 < len(robots) <= len(CELL_COLOURS):
        legend_below(figure)
    return figure


def _unit_of(series: Sequence[ParameterSeries], name: str) -> tuple[float, str]:
    """Factor and unit in which a parameter of all robots is drawn."""
    own = [one for one in series if one.parameter == name]
    return display_unit(own[0].unit, np.concatenate([one.values for one in own]))


def plot_budgets(budgets: Sequence[Budget]) -> Figure:
    """Variance of one robot's parameter by source, and what the fits claim."""
    shown = [b for b in budgets if b.components][: 2 * MOST_PANELS]
    figure = new_figure(0.28 * len(shown) + 1.2)
    axes = figure.subplots()
    place = np.arange(len(shown))[::-1]
    whole = np.array([max(b.gauge_sd, b.claimed_sd, 1e-300) for b in shown])
    start = np.zeros(len(shown))
    for name, colour in _SOURCES.items():
        share = np.array([b.sd_of(name) ** 2 for b in shown]) / whole**2
        if share.any():
            axes.barh(place, share, left=start, color=colour, label=name, height=0.7)
            start = start + share
    claimed = np.array([b.claimed_sd for b in shown]) ** 2 / whole**2
    axes.plot(claimed, place, "|", color=REFERENCE, markersize=11, label="claimed by the fits")
    axes.set_yticks(place, [b.parameter for b in shown])
    axes.set_xlim(0.0, 1.02)
    tidy(
        axes,
        "Variance by source",
        "share of the larger of total and claimed variance of one robot",
        "",
    )
    legend_below(figure)
    return figure
