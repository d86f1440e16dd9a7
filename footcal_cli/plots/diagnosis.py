"""Figures of a diagnosis: what is left, whether it is chance, and what the effect changes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from footcal_cli.core.diagnosis.engine import EffectStatus
from footcal_cli.core.diagnosis.investigation import Investigation
from footcal_cli.core.diagnosis.movement import Movement
from footcal_cli.core.diagnosis.problem import Problem, Signature
from footcal_cli.core.parameters import FloatArray
from footcal_cli.plots.style import AFTER, BAD, BEFORE, CELL_COLOURS, REFERENCE, new_figure, tidy

DRIVER_CAPTION = (
    "What is left against the signal that tells it best, before and after the named effect; "
    "points are rows, the thick line their mean with its 95 % band over blocks. It should be flat."
)
LINE_UP_CAPTION = (
    "Nineteen of these panels show what chance makes of these data, one shows the data. If you can "
    "pick it, that alone is p = 1/20. The answer stands upside down below."
)
GAINS_CAPTION = "Error of each block when it is left out of the fit: before and after."
LADDER_CAPTION = (
    "How the held-out error falls: each effect added first and added last, down to what any "
    "function of the recorded signals could reach."
)
ISOLABILITY_CAPTION = (
    "Which effects look alike in these data beside the calibration: |cos| of what stays visible of "
    "them. Outlined: pairs that no analysis of these data can separate."
)
MOVEMENT_CAPTION = (
    "How far each calibration parameter moves when the effect enters the model, in its own sd."
)
NULL_CAPTION = (
    "The largest statistic over the whole table when whole blocks change sign at random, and the "
    "one of the data."
)
_PANELS = 20
_BINS = 12
_MOST_POINTS = 3000


def _driver(found: Investigation) -> tuple[str, FloatArray]:
    """The recorded signal that tells most about the first residual."""
    problem, detection = found.problem, found.rounds[0].before
    names = [n for n in detection.groups if n in problem.regressors]
    if not names:
        return "row", np.arange(float(problem.residual.size))
    p = {n: detection.group_p[detection.groups.index(n)] for n in names}
    best = min(names, key=lambda n: (p[n], -_bin_variance(problem, n)))
    return best, problem.regressors[best]


def _bin_variance(problem: Problem, name: str) -> float:
    """How much of the residual the means over bins of a signal carry."""
    left = _left(problem)
    _, mean, _ = _binned(problem.regressors[name], left, problem.block)
    return float(np.nanvar(mean)) if mean.size else 0.0


def _left(problem: Problem) -> FloatArray:
    """Residual after the calibration (and accepted effects), in units of noise, shape (m,)."""
    bare = replace(problem, columns=problem.residual[:, None], signatures=_ONE)
    return bare.left()[:, 0]


_ONE = (Signature("residual", "", "", ""),)


def _binned(
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


def _main_output(found: Investigation) -> int:
    """The output whose residual depends most on the driver."""
    _, driver = _driver(found)
    problem = found.problem
    left = _left(problem)
    score = []
    for o in range(len(problem.outputs)):
        rows = problem.output == o
        if rows.sum() < 5:
            score.append(0.0)
            continue
        _, mean, _ = _binned(driver[rows], left[rows], problem.block[rows])
        score.append(float(np.nanvar(mean)))
    return int(np.argmax(score))


def plot_driver(found: Investigation) -> Figure:
    """Residual against its driver, before (fitted effect drawn through) and after."""
    name, driver = _driver(found)
    output = _main_output(found)
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
        left = (_left(problem) * problem.noise)[rows]
        x = driver[rows]
        thin = np.arange(rows.size)[:: max(rows.size // _MOST_POINTS, 1)]
        axes.scatter(
            x[thin], left[thin], s=4, alpha=0.35, linewidths=0,
            c=[CELL_COLOURS[b % len(CELL_COLOURS)] for b in problem.block[rows][thin]],
        )  # fmt: skip
        middle, mean, half = _binned(x, left, problem.block[rows])
        axes.fill_between(middle, mean - half, mean + half, color=AFTER, alpha=0.25, linewidth=0)
        axes.plot(middle, mean, color=AFTER, linewidth=2.2, label="mean, 95 % over blocks")
        if stage == "before" and found.found and found.model is not None:
            fitted = _fitted_effect(found)[rows] * problem.noise[rows]
            xs, ys, _ = _binned(x, fitted, problem.block[rows])
            axes.plot(xs, ys, "--", color=BAD, linewidth=1.8, label="fitted effect")
        axes.axhline(0, color=REFERENCE, linewidth=0.8)
        title = "Before: should be flat" if stage == "before" else "After: should be flat"
        tidy(axes, title, name, f"left in {problem.outputs[output]} ({unit})" if i == 0 else "")
        axes.legend(fontsize=7.5, frameon=False)
        spread = np.quantile(np.abs(left), 0.99) if left.size else 1.0
        if i == 0:
            axes.set_ylim(-1.3 * spread, 1.3 * spread)
    return figure


def _fitted_effect(found: Investigation) -> FloatArray:
    """What the named effects add to the residual, beside the calibration, shape (m,)."""
    before, after = _left(found.problem), _left_plain(found)
    return before - after


def _left_plain(found: Investigation) -> FloatArray:
    """Residual of the extended model after the calibration alone."""
    return _left(replace(found.problem, residual=found.final.residual))


def plot_line_up(found: Investigation, seed: int) -> Figure:
    """The data among nineteen data sets whose blocks had their signs flipped."""
    name, driver = _driver(found)
    output = _main_output(found)
    problem = found.problem
    rows = np.flatnonzero(problem.output == output)
    left = _left(problem)[rows]
    rng = np.random.default_rng(seed + 1)
    place = int(rng.integers(_PANELS))
    figure = new_figure(5.6)
    grid = figure.subplots(4, 5, sharex=True, sharey=True)
    spread = 0.0
    for i, axes in enumerate(grid.ravel()):
        signs = np.ones(problem.blocks)
        if i != place:
            signs = rng.choice([-1.0, 1.0], problem.blocks)
        values = left * signs[problem.block[rows]]
        middle, mean, half = _binned(driver[rows], values, problem.block[rows])
        spread = max(spread, float(np.max(np.abs(mean) + half, initial=0.0)))
        axes.fill_between(middle, mean - half, mean + half, color=AFTER, alpha=0.25, linewidth=0)
        axes.plot(middle, mean, color=AFTER, linewidth=1.4)
        axes.axhline(0, color=REFERENCE, linewidth=0.6)
        tidy(axes, f"{i + 1}")
        axes.tick_params(labelsize=6)
    grid.ravel()[0].set_ylim(-1.1 * spread - 1e-12, 1.1 * spread + 1e-12)
    figure.supxlabel(name, fontsize=9)
    figure.supylabel("mean of what is left (noise sd)", fontsize=9)
    figure.text(0.99, 0.005, f"panel {place + 1}", rotation=180, fontsize=7, ha="right")
    return figure


def plot_gains(found: Investigation) -> Figure:
    """Error of each held-out block before and after."""
    gain = max(found.gains, key=lambda g: g.change.value)
    blocks = np.arange(1, len(gain.per_block) + 1)
    figure = new_figure(3.2)
    axes = figure.add_subplot()
    axes.vlines(blocks, gain.per_block[:, 1], gain.per_block[:, 0], color="#c9ced6", linewidth=1.2)
    axes.plot(blocks, gain.per_block[:, 0], "o", color=BEFORE, markersize=5, label="before")
    if found.found:
        axes.plot(blocks, gain.per_block[:, 1], "o", color=AFTER, markersize=5, label="after")
    better = int(np.sum(gain.per_block[:, 1] < gain.per_block[:, 0]))
    title = f"{gain.output}: better in {better} of {blocks.size} held-out blocks"
    tidy(axes, title if found.found else f"{gain.output}: error of each held-out block", "block",
         f"RMS error ({gain.unit})")  # fmt: skip
    axes.set_ylim(bottom=0)
    axes.legend(fontsize=8, frameon=False)
    return figure


def plot_ladder(found: Investigation) -> Figure:
    """Error from the baseline to the noise floor; each effect first and last."""
    steps = [("baseline", _rms(found.rounds[0].before.loss, found.problem), BEFORE)]
    for i, item in enumerate(found.found):
        loss = found.rounds[i + 1].before.loss if i + 1 < len(found.rounds) else None
        if loss is not None:
            label = f"+ {item.cause.signature.effect}".replace("_", " ")
            steps.append((label, _rms(loss, found.problem), AFTER))
    last = found.rounds[-1]
    floor = last.before.loss.sum() - max(float(last.before.flexible_gain.sum()), 0.0)
    steps.append(
        ("any function of\nthe signals", _rms(np.array([floor]), found.problem), "#009E73")
    )
    if not found.case.drifts and found.problem.blocks > 2:
        free = _free_rms(found)
        steps.append(("calibration free\nin every block", free, "#7A5C00"))
    figure = new_figure(3.2)
    axes = figure.add_subplot()
    for i, (_, value, colour) in enumerate(steps):
        axes.bar(i, value, color=colour, width=0.6)
        axes.text(i, value, f"{value:.3g}", ha="center", va="bottom", fontsize=8)
    axes.set_xticks(range(len(steps)), [s[0] for s in steps], fontsize=8)
    tidy(axes, "Held-out error over all outputs", "", "RMS error (noise sd of the baseline)")
    axes.tick_params(axis="x", labelsize=8)
    return figure


def _rms(loss: FloatArray, problem: Problem) -> float:
    return float(np.sqrt(max(float(np.sum(loss)), 0.0) / problem.residual.size))


def _free_rms(found: Investigation) -> float:
    """Repeatability floor: what is left when every block has a calibration of its own."""
    from footcal_cli.core.diagnosis.whitening import residual_within_blocks

    left = residual_within_blocks(found.final)
    return float(np.sqrt(np.mean(left**2)))


def plot_isolability(found: Investigation) -> Figure:
    """|cos| of the visible signatures, one row per effect where it explains most."""
    problem = found.problem
    chosen, labels = [], []
    index = {s: i for i, s in enumerate(problem.signatures)}
    for row in found.rounds[0].effects:
        if row.status is EffectStatus.NOT_TESTABLE and row.visible < 0.02:
            continue
        if row.signature in index:
            chosen.append(index[row.signature])
            labels.append(row.signature.effect.replace("_", " "))
    if not chosen:
        figure = new_figure(1.2)
        figure.text(0.5, 0.5, "No effect is visible in these data.", ha="center")
        return figure
    part = replace(
        problem,
        columns=problem.columns[:, chosen],
        signatures=tuple(problem.signatures[i] for i in chosen),
    )
    left = part.left()
    norm = np.sqrt(np.sum(left**2, axis=0))
    unit = left / np.where(norm > 0, norm, 1.0)
    cos = np.abs(unit.T @ unit)
    order = _clustered(cos)
    cos, labels = cos[np.ix_(order, order)], [labels[i] for i in order]
    k = len(labels)
    figure = new_figure(0.27 * k + 1.8, width_in=min(0.27 * k + 3.4, 8.5))
    axes = figure.add_subplot()
    image = axes.imshow(cos, cmap="Blues", vmin=0, vmax=1)
    for i in range(k):
        for j in range(k):
            if i != j and cos[i, j] > 0.95:
                axes.add_patch(
                    Rectangle((j - 0.5, i - 0.5), 1, 1, fill=False, edgecolor=BAD, linewidth=1.4)
                )
    axes.set_xticks(range(k), labels, rotation=90, fontsize=7)
    axes.set_yticks(range(k), labels, fontsize=7)
    axes.set_title("|cos| of visible signatures; outlined above 0.95", loc="left", fontsize=10)
    figure.colorbar(image, ax=axes, shrink=0.7).ax.tick_params(labelsize=7)
    return figure


def _clustered(cos: FloatArray) -> list[int]:
    """An order that keeps look-alikes together: nearest neighbour after nearest neighbour."""
    rest = list(range(len(cos)))
    order = [rest.pop(0)]
    while rest:
        nearest = max(rest, key=lambda j: cos[order[-1], j])
        rest.remove(nearest)
        order.append(nearest)
    return order


def plot_movement(moved: Sequence[Movement]) -> Figure:
    """Movement of each parameter in units of its sd."""
    figure = new_figure(0.22 * len(moved) + 1.2)
    axes = figure.add_subplot()
    places = np.arange(len(moved))[::-1]
    steps = np.array([m.in_sd for m in moved])
    axes.barh(places, steps, color=[BAD if abs(s) > 3 else AFTER for s in steps], height=0.6)
    axes.axvline(0, color=REFERENCE, linewidth=0.8)
    axes.axvspan(-2, 2, color="#e8f1f8", zorder=0)
    axes.set_yticks(places, [m.name for m in moved])
    tidy(axes, "Movement of the calibration (shaded: within 2 sd)", "moved (sd)", "")
    return figure


def plot_null(found: Investigation) -> Figure:
    """Null distribution of the largest statistic and the observed one."""
    evidence = found.rounds[0].search.first
    figure = new_figure(2.8)
    axes = figure.add_subplot()
    null = evidence.null_max
    if null.size:
        axes.hist(null, bins=40, color="#c9ced6")
        axes.axvline(null[0], color=BAD, linewidth=2, label="the data")
        axes.axvline(
            np.quantile(null, 0.99), color=REFERENCE, linewidth=1, linestyle=":",
            label="1 % by chance",
        )  # fmt: skip
        axes.legend(fontsize=8, frameon=False)
    tidy(axes, "Largest statistic over the table under random signs of blocks", "max |T|",
         "sign patterns")  # fmt: skip
    return figure
