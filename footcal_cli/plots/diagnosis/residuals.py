"""Residual against the signal that predicts it best, before and after."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core.diagnosis.answer import Verdict
from footcal_cli.core.diagnosis.investigation import Investigation
from footcal_cli.core.diagnosis.material import left_over
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.parameters import FloatArray
from footcal_cli.plots.style import (
    AFTER,
    BAD,
    CELL_COLOURS,
    REFERENCE,
    legend_below,
    new_figure,
    tidy,
)
from footcal_cli.plots.words import output_words, signal_label, signal_words

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MOST_POINTS = 3000
_BINS = 12
_FEWEST_ROWS = 5
_NEARLY = 0.6  # of the clearest signal's dependence: the first recorded one will do


def binned(
    x: FloatArray, y: FloatArray, block: np.ndarray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Middle, mean and half width of the 95 % interval over blocks of each bin of x."""
    distinct = np.unique(x)
    if distinct.size <= _BINS:
        edges = np.append(distinct, np.inf)
    else:
        edges = np.unique(np.quantile(x, np.linspace(0, 1, _BINS + 1)))
        edges[-1] = np.inf
    middle, mean, half = [], [], []
    for low, high in pairwise(edges):
        inside = (x >= low) & (x < high)
        if not inside.any():
            continue
        sums = np.bincount(block[inside], weights=y[inside])
        count = np.bincount(block[inside])
        each = sums[count > 0] / count[count > 0]
        middle.append(float(np.mean(x[inside])))
        mean.append(float(np.mean(y[inside])))
        half.append(1.96 * float(np.std(each)) / np.sqrt(max(each.size, 1)))
    return np.array(middle), np.array(mean), np.array(half)


def _bin_variance(problem: Problem, name: str) -> float:
    """How much of the residual the means over bins of a signal carry."""
    left = left_over(problem)
    _, mean, _ = binned(problem.regressors[name], left, problem.block)
    return float(np.nanvar(mean)) if mean.size else 0.0


def driver_of(found: Investigation) -> tuple[str, FloatArray]:
    """The recorded signal that tells most about the first residual."""
    problem, detection = found.problem, found.rounds[0].before
    names = [n for n in detection.groups if n in problem.regressors]
    if not names:
        return "row", np.arange(float(problem.residual.size))
    p = {n: detection.group_p[detection.groups.index(n)] for n in names}
    # tests ask what repeats over blocks; where readings are wrong the largest error is shown
    stopped = found.verdict is Verdict.BAD_DATA
    clearest = [n for n in names if stopped or p[n] <= min(p.values())]
    explained = {n: _bin_variance(problem, n) for n in clearest}
    best = next(n for n in clearest if explained[n] >= _NEARLY * max(explained.values()))
    return best, problem.regressors[best]


def main_output(found: Investigation) -> int:
    """The output whose residual the named effect lowers most; without one, see the driver.

    Held-out errors choose the output that the verdict states; what is drawn is the residual.
    """
    problem = found.problem
    if found.found:
        falls = [_rms(found.final, o) / (_rms(problem, o) or np.inf) for o in _drawable(problem)]
        return _drawable(problem)[int(np.argmin(falls))] if falls else 0
    _, driver = driver_of(found)
    left = left_over(problem)
    score = []
    for o in range(len(problem.outputs)):
        rows = problem.output == o
        if rows.sum() < _FEWEST_ROWS:
            score.append(0.0)
            continue
        _, mean, _ = binned(driver[rows], left[rows], problem.block[rows])
        score.append(float(np.nanvar(mean)))
    return int(np.argmax(score))


def caption(*, named: bool) -> str:
    """How to read the figure."""
    stages = "Residual against the signal that predicts it best, without and with the identified "
    how = "Points: rows; line: their mean with its 95 % band over blocks. It should be flat."
    return f"{stages}effect in the model. {how}" if named else how


def _drawable(problem: Problem) -> list[int]:
    """Outputs with enough rows for a figure."""
    counts = np.bincount(problem.output, minlength=len(problem.outputs))
    return [int(o) for o in np.flatnonzero(counts >= _FEWEST_ROWS)]


def _rms(problem: Problem, output: int) -> float:
    """RMS residual of an output, in its unit."""
    left = (left_over(problem) * problem.noise)[problem.output == output]
    return float(np.sqrt(np.mean(left**2))) if left.size else 0.0


def in_words(found: Investigation) -> str:
    """RMS residual of the output that is drawn, before and after."""
    output, (name, _) = main_output(found), driver_of(found)
    stages = {"before": found.problem, **({"after": found.final} if found.found else {})}
    unit, of = found.problem.units[output], output_words(found.problem.outputs[output])
    rms = [f"{_rms(problem, output):.3g} {unit} {stage}" for stage, problem in stages.items()]
    listed = ", ".join(rms) if found.found else rms[0].removesuffix(" before")
    return f"RMS residual of the {of} against {signal_words(name)}: {listed}."


def plot_driver(found: Investigation) -> Figure:
    """Residual against its driver, before (fitted effect drawn through) and after."""
    name, driver = driver_of(found)
    output = main_output(found)
    panels = [("before", found.problem)]
    if found.found:
        panels.append(("after", found.final))
    figure = new_figure(3.6)
    shared = None
    unit = found.problem.units[output]
    for i, (stage, problem) in enumerate(panels):
        axes = figure.add_subplot(1, len(panels), i + 1, sharey=shared)
        shared = axes
        rows = np.flatnonzero(problem.output == output)
        left = (left_over(problem) * problem.noise)[rows]
        x = driver[rows]
        thin = np.arange(rows.size)[:: max(rows.size // _MOST_POINTS, 1)]
        axes.scatter(
            x[thin], left[thin], s=4, alpha=0.35, linewidths=0,
            c=[CELL_COLOURS[b % len(CELL_COLOURS)] for b in problem.block[rows][thin]],
        )  # fmt: skip
        middle, mean, half = binned(x, left, problem.block[rows])
        axes.fill_between(middle, mean - half, mean + half, color=AFTER, alpha=0.25, linewidth=0)
        axes.plot(middle, mean, color=AFTER, linewidth=2.2, label="mean, 95 % over blocks")
        if stage == "before" and found.found and found.model is not None:
            fitted = _fitted_effect(found)[rows] * problem.noise[rows]
            xs, ys, _ = binned(x, fitted, problem.block[rows])
            axes.plot(xs, ys, "--", color=BAD, linewidth=1.8, label="fitted effect")
        axes.axhline(0, color=REFERENCE, linewidth=0.8)
        title = f"{stage.capitalize()}: should be flat" if found.found else "Should be flat"
        of = output_words(problem.outputs[output])
        tidy(axes, title, signal_label(name), f"residual of the {of} ({unit})" if i == 0 else "")
        spread = float(np.quantile(np.abs(left), 0.99)) if left.size else 0.0
        if i == 0:
            axes.set_ylim(-1.3 * (spread or 1.0), 1.3 * (spread or 1.0))
    legend_below(figure)
    return figure


def _fitted_effect(found: Investigation) -> FloatArray:
    """What the named effects add to the residual, beside the calibration, shape (m,)."""
    before, after = left_over(found.problem), _left_plain(found)
    return before - after


def _left_plain(found: Investigation) -> FloatArray:
    """Residual of the extended model after the calibration alone."""
    return left_over(replace(found.problem, residual=found.final.residual))
