"""Figures of `static-init`: stances, directions, parameters."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core.next_stance import CurvePoint
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.static_init import StanceErrors
from footcal_cli.plots.style import (
    AFTER,
    BAD,
    BEFORE,
    REFERENCE,
    legend_below,
    log_axis_up,
    new_figure,
    tidy,
)  # fmt: skip

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_WORDS = {
    "before": "prior alone",
    "after": "prior and stances",
    "least squares": "least squares, no prior",
}
_STAGES = {"before": BEFORE, "after": AFTER, "least squares": BAD}


def plot_stances(errors: Sequence[StanceErrors]) -> Figure:
    """Error of each stance's CoP and force, predicted from the others where there are several."""
    from matplotlib.ticker import MaxNLocator

    held_out = any(e.held_out for e in errors)
    shown = [e for e in errors if e.held_out == held_out]
    figure = new_figure(3.0)
    left, right = figure.subplots(1, 2)
    for e in shown:
        number = np.arange(1, e.vgrf_n.size + 1)
        cop = 1e3 * np.linalg.norm(e.cop_m, axis=1)
        # errors of least squares run off the scale: they are the point, not the axis
        left.plot(number, cop, "o-", color=_STAGES[e.stage], label=e.stage, markersize=4)
        right.plot(number, e.vgrf_n, "o-", color=_STAGES[e.stage], label=e.stage, markersize=4)
    log_axis_up(left)
    how = "predicted from the other stances" if held_out else "of the fitted stance"
    tidy(left, f"CoP, {how}", "stance", "CoP error (mm)")
    tidy(right, f"Total force, {how}", "stance", "total force error (N)")
    usual = max(float(np.abs(e.vgrf_n).max()) for e in shown if e.stage != "least squares")
    right.set_ylim(-1.2 * usual, 1.2 * usual)
    right.axhline(0.0, color=REFERENCE, linewidth=0.8)
    for axes in (left, right):
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    legend_below(figure)
    return figure


def plot_curve(curve: Sequence[CurvePoint]) -> Figure:
    """CoP error on the next stance against the number of stances used."""
    figure = new_figure(2.8)
    axes = figure.subplots()
    used = [point.stances for point in curve]
    for stage, values in (
        ("before", [point.before_m for point in curve]),
        ("after", [point.after_m for point in curve]),
        ("least squares", [point.least_squares_m for point in curve]),
    ):
        axes.plot(used, 1e3 * np.array(values), "o-", color=_STAGES[stage], label=_WORDS[stage])
    axes.set_xscale("log")
    log_axis_up(axes)
    axes.set_xticks(used, [str(n) for n in used])
    axes.minorticks_off()
    tidy(axes, "CoP error on the stance that follows", "stances used", "CoP error (mm)")
    legend_below(figure)
    return figure


def plot_directions(singular_values: FloatArray, rank: int) -> Figure:
    """How well each direction is seen: prior sd over the sd that the stances alone would leave."""
    from matplotlib.ticker import MaxNLocator

    figure = new_figure(2.6)
    axes = figure.subplots()
    number = np.arange(1, singular_values.size + 1)
    shown = np.maximum(singular_values, 1e-3)
    colours = [AFTER if i < rank else BEFORE for i in range(number.size)]
    axes.bar(number, shown, color=colours, bottom=0.0)
    axes.axhline(1.0, color=REFERENCE, linewidth=0.8, linestyle="--")
    log_axis_up(axes)
    axes.set_ylim(1e-3, max(20.0, 2.0 * float(shown.max())))
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    tidy(
        axes,
        f"{rank} of {number.size} parameter directions seen; above the dashed line better than by "
        "the prior",
        "direction, best seen first",
        "prior sd / sd from the data",
    )
    return figure


def plot_beliefs(
    names: Sequence[str], units: Sequence[str], prior_sd: FloatArray, value: FloatArray,
    sd: FloatArray, estimated: Sequence[bool],
) -> Figure:  # fmt: skip
    """Each unknown in prior sd: where standing put it, and how far it can still be off."""
    figure = new_figure(0.26 * len(names) + 1.0)
    axes = figure.subplots()
    place = np.arange(len(names))[::-1]
    axes.axvspan(-2.0, 2.0, color="#eef1f4")
    for y, v, s, p, known in zip(place, value, sd, prior_sd, estimated, strict=True):
        colour = AFTER if known else BEFORE
        axes.errorbar(v / p, y, xerr=2.0 * s / p, fmt="o", color=colour, markersize=5, capsize=2,
                      markerfacecolor=colour if known else "white")  # fmt: skip
    axes.set_yticks(
        place, [n if u == "-" else f"{n} ({u})" for n, u in zip(names, units, strict=True)]
    )
    axes.axvline(0.0, color=REFERENCE, linewidth=0.8)
    tidy(
        axes,
        "Change against the prior, ± 2 sd (filled: estimated, hollow: prior kept)",
        "change (prior sd)",
        "",
    )
    return figure
