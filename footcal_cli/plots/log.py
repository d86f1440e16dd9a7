"""Figures of raw logs: every channel over time, with what is wrong where it is."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core.parameters import BoolArray, FloatArray
from footcal_cli.core.signals import peaks_kept
from footcal_cli.plots.style import AFTER, BAD, BEFORE, CELL_COLOURS, REFERENCE, new_figure, tidy

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Drawing = Callable[[], "Figure"]
"""A figure that is drawn when it is written."""
BINS = 1200
"""Points of a curve, however long the log: the smallest and the largest of every stretch."""
MOST_PANELS = 24
_MOST_MARKS = 2000


@dataclass(frozen=True)
class Panel:
    """One strip of a figure.

    Parameters
    ----------
    name
        Printed beside it.
    series
        Curves by label, of any kind of number, shape (n,) each.
    wrong
        What was found about the whole channel, in words; empty where nothing was.
    marked
        Samples to mark by what is wrong with them, shape (n,) each.
    """

    name: str
    series: Mapping[str, FloatArray]
    wrong: str = ""
    marked: Mapping[str, BoolArray] = field(default_factory=dict)


def plot_channels(
    x: FloatArray,
    panels: Sequence[Panel],
    *,
    label: str,
    gaps: Sequence[tuple[float, float]] = (),
    breaks: Sequence[tuple[float, str]] = (),
) -> Figure:
    """Channels as strips above each other; orange is what was found.

    Parameters
    ----------
    x
        Shape (n,).
    label
        Of x.
    gaps
        Stretches without samples.
    breaks
        Where a part of the log begins, and its name.
    """
    shown = sorted(panels, key=lambda p: not (p.wrong or p.marked))[:MOST_PANELS]
    shown = [p for p in panels if p in shown]
    figure = new_figure(max(0.62 * len(shown) + 0.9, 2.4))
    all_axes = figure.subplots(len(shown), 1, sharex=True, squeeze=False)[:, 0]
    legend: dict[str, Artist] = {}
    for axes, panel in zip(all_axes, shown, strict=True):
        _strip(axes, x, panel, legend, [start for start, _ in gaps])
        for start, stop in gaps[:200]:
            axes.axvspan(start, stop, color="#f3d9c9", linewidth=0)
        for at, _ in breaks:
            axes.axvline(at, color=BEFORE, linewidth=0.6)
    top = all_axes[0]
    for at, name in breaks:
        top.annotate(name, (at, 1.0), xycoords=("data", "axes fraction"), fontsize=7,
                     xytext=(2, 2), textcoords="offset points", color=BEFORE)  # fmt: skip
    all_axes[-1].set_xlabel(label, fontsize=9)
    if gaps:
        legend["gap"] = top.axvspan(gaps[0][0], gaps[0][0], color="#f3d9c9")
    if legend:
        figure.legend(
            list(legend.values()), list(legend), fontsize=8, frameon=False, ncols=6,
            loc="outside lower left",
        )  # fmt: skip
    return figure


def _strip(
    axes: Axes, x: FloatArray, panel: Panel, legend: dict[str, Artist], cuts: Sequence[float]
) -> None:
    several = len(panel.series) > 1
    every = np.concatenate([np.asarray(values) for values in panel.series.values()])
    finite = every[np.isfinite(every)]
    del every
    # no line runs across a gap
    cut = np.searchsorted(x, cuts, side="right")
    along = np.insert(x, cut, cuts)
    for i, (name, values) in enumerate(panel.series.items()):
        colour = CELL_COLOURS[i] if several else BAD if panel.wrong else AFTER
        drawn = np.insert(np.asarray(values, dtype=np.float64), cut, np.nan)
        kept = peaks_kept(drawn, 2 * BINS)
        (line,) = axes.plot(along[kept], drawn[kept], color=colour, linewidth=0.8)
        if several:
            legend.setdefault(name, line)
    first = next(iter(panel.series.values()))
    styles = {"single sample far off": ("o", BAD), "end code": ("s", CELL_COLOURS[5])}
    for what, flags in panel.marked.items():
        at = np.flatnonzero(flags)
        at = at[:: -(-at.size // _MOST_MARKS) or 1]
        if not at.size:
            continue
        if what in styles:
            marker, colour = styles[what]
            (line,) = axes.plot(x[at], first[at], marker, color=colour, markersize=4)
        else:  # lost or frozen: there is nothing to mark but when
            level = np.full(at.size, 0.04)
            (line,) = axes.plot(x[at], level, "|", color=BAD if what == "frozen" else REFERENCE,
                                transform=axes.get_xaxis_transform(), markersize=6)  # fmt: skip
        legend.setdefault(what, line)
    tidy(axes)
    axes.tick_params(labelsize=7)
    axes.locator_params(axis="y", nbins=3)
    if finite.size and np.abs(finite).max() < 1e9:
        axes.yaxis.set_major_formatter(_thousands)
    axes.set_ylabel(panel.name, fontsize=8, rotation=0, ha="right", va="center",
                    color=BAD if panel.wrong else REFERENCE)  # fmt: skip
    if panel.wrong:
        axes.set_title(panel.wrong, loc="right", fontsize=7.5, color=BAD, pad=1)


def _thousands(value: float, _: float) -> str:
    """A tick with its thousands set apart: 8,250,000."""
    return f"{value:,.6g}".replace("-", "−") if abs(value) < 1e4 else f"{value:,.0f}"


def plot_weights(
    channels: Mapping[str, tuple[FloatArray, FloatArray]], wrong: Mapping[str, str]
) -> Figure:
    """Known load against counts, one panel per channel, with its straight line.

    Parameters
    ----------
    channels
        Channel -> counts and load in N, shape (n,) each.
    wrong
        Channel -> what was found.
    """
    names = sorted(channels, key=lambda name: name not in wrong)[:MOST_PANELS]
    names = [name for name in channels if name in names]
    across = min(4, len(names))
    down = int(np.ceil(len(names) / across))
    figure = new_figure(2.3 * down + 0.3, width_in=max(2.4 * across, 4.0))
    grid = figure.subplots(down, across, squeeze=False)
    for i, name in enumerate(names):
        axes = grid[i // across, i % across]
        counts, load = channels[name]
        good = np.isfinite(counts) & np.isfinite(load)
        counts, load = counts[good] / 1e3, load[good]
        some = slice(None, None, max(counts.size // BINS, 1))
        colour = BAD if name in wrong else AFTER
        axes.plot(counts[some], load[some], "o", color=colour, markersize=3)
        if counts.size > 1 and np.ptp(counts) > 0 and np.abs(counts).max() < 1e12:
            middle = counts.mean()
            slope, level = np.polyfit(counts - middle, load, 1)
            ends = np.array([counts.min(), counts.max()])
            axes.plot(ends, slope * (ends - middle) + level, color=REFERENCE, linewidth=0.8)
        tidy(axes, name, "counts (10³)" if i + across >= len(names) else "",
             "load (N)" if i % across == 0 else "")  # fmt: skip
        axes.locator_params(axis="x", nbins=3)
        if name in wrong:
            axes.set_title(f"{name}: {wrong[name]}", loc="left", fontsize=8, color=BAD)
    for axes in grid.ravel()[len(names) :]:
        axes.set_visible(False)
    return figure
