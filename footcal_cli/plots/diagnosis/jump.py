"""What happens once: what the channel shows in each swing or hold, with and without its cause."""

from __future__ import annotations

from typing import TYPE_CHECKING

from footcal_cli.core.diagnosis.investigation import Found, Investigation
from footcal_cli.core.diagnosis.jumps import at_rest, held
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.parameters import FloatArray
from footcal_cli.plots.style import AFTER, BEFORE, REFERENCE, legend_below, new_figure, tidy
from footcal_cli.plots.words import words

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def caption(found: Investigation) -> str:
    """What the points are."""
    where = "swing, where it should show nothing," if found.problem.drifts else "hold"
    return (
        f"Points: mean residual of the channel in each {where} with and without the cause in the "
        "model. They should lie on one level."
    )


def title(found: Investigation) -> str:
    """Of the picture."""
    if found.problem.drifts:
        return "The channel in the air, swing by swing"
    return "Residual of the channel, hold by hold"


def channel_of(found: Investigation) -> str:
    """The channel that jumped: a cell, or the surest axis of a transducer."""
    item = found.found[0]
    traces = found.problem.traces
    if traces is None or item.owner in traces.names:
        return item.owner
    sizes = dict(zip(item.parameter_names, item.intervals, strict=True))
    axes = {name.rsplit("_", 1)[1]: size for name, size in sizes.items()}
    known = {*traces.names, *(f"{item.owner}.{output}" for output in found.problem.outputs)}
    seen = [axis for axis in axes if f"{item.owner}.{axis}" in known]
    surest = max(seen, key=lambda axis: abs(axes[axis].value) / (axes[axis].high - axes[axis].low))
    return f"{item.owner}.{surest}"


def _moment_s(item: Found) -> float | None:
    """When it happened; None of what goes on all the time."""
    return next(iter(item.placed.values()), None)


def _parts(found: Investigation) -> str:
    return "swing" if found.problem.drifts else "hold"


def _levels(found: Investigation, problem: Problem) -> tuple[FloatArray, FloatArray, str]:
    """When, since the start, and what the channel shows in each swing or hold, and its unit."""
    channel = channel_of(found)
    if problem.drifts:
        time_s, mean, unit = at_rest(problem, channel)
    else:
        time_s, mean, unit = held(problem, channel.rsplit(".", 1)[-1])
    return time_s - float(found.case.logs[0].time_s[0]), mean, unit


def in_words(found: Investigation) -> str:
    """The mean before and after it happened, or at both ends."""
    time_s, mean, unit = _levels(found, found.problem)
    moment, part = _moment_s(found.found[0]), _parts(found)
    if moment is None:
        first, last, where = mean[0], mean[-1], f"the first {part} and {{}} in the last"
    else:
        after = time_s >= moment
        first, last = mean[~after].mean(), mean[after].mean()
        where = f"the {part}s before {moment:.1f} s and {{}} after"
    shown = f"{channel_of(found)} shows {first:.3g} {unit} in {where.format(f'{last:.3g} {unit}')}."
    return shown.replace("-", "−")


def plot_jump(found: Investigation) -> Figure:
    """Mean of each swing over time."""
    figure = new_figure(3.2)
    axes = figure.add_subplot()
    unit = ""
    for problem, colour, label in (
        (found.problem, BEFORE, "without the cause in the model"),
        (found.final, AFTER, "with it"),
    ):
        time_s, mean, unit = _levels(found, problem)
        axes.plot(time_s, mean, "o", color=colour, markersize=4, label=label)
    axes.axhline(0, color=REFERENCE, linewidth=0.8)
    moment, effect = _moment_s(found.found[0]), words(found.found[0].cause.signature.effect)
    if moment is not None:
        axes.axvline(moment, color=REFERENCE, linewidth=1.0, linestyle="--")
        effect += f" at {moment:.1f} s"
    channel = channel_of(found) + " in the air" * found.problem.drifts
    tidy(
        axes, f"{channel}: {effect}",
        "time since the start (s)", f"mean of a {_parts(found)} ({unit})",
    )  # fmt: skip
    axes.margins(y=0.15)
    legend_below(figure)
    return figure
