"""A jump in a walk: what the channel shows in each swing, before and after it is modelled."""

from __future__ import annotations

from typing import TYPE_CHECKING

from footcal_cli.core.diagnosis.investigation import Found, Investigation
from footcal_cli.core.diagnosis.jumps import at_rest
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.parameters import FloatArray
from footcal_cli.plots.style import AFTER, BEFORE, REFERENCE, legend_below, new_figure, tidy
from footcal_cli.plots.words import words

if TYPE_CHECKING:
    from matplotlib.figure import Figure

JUMP_CAPTION = (
    "Points: mean of the channel in each swing, where it should show nothing, with and without the "
    "jump in the model. They should lie on one level."
)


def channel_of(found: Investigation) -> str:
    """The channel that jumped: a cell, or the surest axis of a transducer."""
    item = found.found[0]
    traces = found.problem.traces
    if traces is None or item.owner in traces.names:
        return item.owner
    sizes = dict(zip(item.parameter_names, item.intervals, strict=True))
    axes = {name.rsplit("_", 1)[1]: size for name, size in sizes.items()}
    seen = [axis for axis in axes if f"{item.owner}.{axis}" in traces.names]
    surest = max(seen, key=lambda axis: abs(axes[axis].value) / (axes[axis].high - axes[axis].low))
    return f"{item.owner}.{surest}"


def _moment_s(item: Found) -> float:
    return next(iter(item.placed.values()))


def _levels(found: Investigation, problem: Problem) -> tuple[FloatArray, FloatArray, str]:
    """When, since the start, and what the channel shows in each swing, and its unit."""
    time_s, mean, unit = at_rest(problem, channel_of(found))
    return time_s - float(found.case.logs[0].time_s[0]), mean, unit


def in_words(found: Investigation) -> str:
    """The mean before and after the jump."""
    time_s, mean, unit = _levels(found, found.problem)
    after = time_s >= _moment_s(found.found[0])
    return (
        f"{channel_of(found)} shows {mean[~after].mean():.3g} {unit} in the swings before "
        f"{_moment_s(found.found[0]):.1f} s and {mean[after].mean():.3g} {unit} after."
    ).replace("-", "−")


def plot_jump(found: Investigation) -> Figure:
    """Mean of each swing over time."""
    figure = new_figure(3.2)
    axes = figure.add_subplot()
    unit = ""
    for problem, colour, label in (
        (found.problem, BEFORE, "without the jump in the model"),
        (found.final, AFTER, "with it"),
    ):
        time_s, mean, unit = _levels(found, problem)
        axes.plot(time_s, mean, "o", color=colour, markersize=4, label=label)
    axes.axhline(0, color=REFERENCE, linewidth=0.8)
    axes.axvline(_moment_s(found.found[0]), color=REFERENCE, linewidth=1.0, linestyle="--")
    effect = words(found.found[0].cause.signature.effect)
    tidy(
        axes, f"{channel_of(found)} in the air: {effect} at {_moment_s(found.found[0]):.1f} s",
        "time since the start (s)", f"mean of a swing ({unit})",
    )  # fmt: skip
    axes.margins(y=0.15)
    legend_below(figure)
    return figure
