"""How the error falls, effect by effect, down to what is possible."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core.diagnosis.attribution import Attribution, attributions
from footcal_cli.core.diagnosis.gain import output_losses, without_rivals
from footcal_cli.core.diagnosis.investigation import Investigation
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.inference.whitening import residual_within_blocks
from footcal_cli.plots.style import AFTER, BAD, BEFORE, CELL_COLOURS, REFERENCE, new_figure, tidy
from footcal_cli.plots.words import words

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_CEILING, _FLOOR = CELL_COLOURS[2], CELL_COLOURS[6]


def caption(*, several: bool) -> str:
    """How to read the figure."""
    parts = (
        " Right: what each effect gains when it is added first, when it is added last, and on "
        "average over all orders (dot); only the dots add up."
    )
    return (
        "Of the calibration alone, with the identified effects, with any function of the recorded "
        "signals (the most that any cause could explain), and with a separate calibration for "
        "every block (repeatability)." + (parts if several else "")
    )


def in_words(found: Investigation) -> str:
    """The error of each model, in the order of the figure."""
    listed = "; ".join(f"{name} {value:.3g}" for name, value, _ in _steps(found))
    return f"RMS error in units of the noise: {listed}.".replace("\n", " ")


def plot_ladder(found: Investigation) -> Figure:
    """Error from the baseline to the noise floor; each effect first and last."""
    parts = attributions(found) if len(found.found) > 1 else ()
    steps = _steps(found)
    figure = new_figure(0.42 * max(len(steps), 1.6 * len(parts)) + 1.1)
    axes = figure.add_subplot(1, 2 if parts else 1, 1)
    _draw_steps(axes, steps)
    if parts:
        _draw_parts(figure.add_subplot(1, 2, 2), parts)
    return figure


def _steps(found: Investigation) -> list[tuple[str, float, str]]:
    """Label, RMS error and colour of each rung; every model fitted in one and the same noise."""
    noise, last = found.final.law, found.rounds[-1].before
    alone = without_rivals(found.final, found.model)
    start, end = (output_losses(model, noise).sum() for model in (found.problem, alone))
    steps = [("without any effect", _rms(start, found.problem), BEFORE)]
    if found.found:
        names = " + ".join(words(f.cause.signature.effect) for f in found.found)
        steps.append((f"with {names}", _rms(end, found.problem), AFTER))
    explained = float(last.flexible_gain.sum()) / max(float(last.loss.sum()), 1e-300)
    ceiling = _rms(end * (1.0 - np.clip(explained, 0.0, 1.0)), found.problem)
    steps.append(("any function of\nthe other signals", ceiling, _CEILING))
    if not found.case.drifts and found.problem.blocks > 2:
        steps.append(("calibration free\nin every block", _free_rms(found), _FLOOR))
    return steps


def _draw_steps(axes: Axes, steps: Sequence[tuple[str, float, str]]) -> None:
    places = np.arange(len(steps))[::-1]
    axes.barh(places, [s[1] for s in steps], color=[s[2] for s in steps], height=0.62)
    for place, (_, value, _) in zip(places, steps, strict=True):
        axes.text(value, place, f" {value:.3g}", va="center", fontsize=8.5)
    tidy(axes, "Error on held-out blocks, all outputs", "RMS error (units of the noise)", "")
    axes.set_yticks(places, [s[0] for s in steps])
    axes.set_xlim(0, 1.15 * max(s[1] for s in steps))
    axes.grid(visible=False, axis="y")


def _draw_parts(axes: Axes, parts: Sequence[Attribution]) -> None:
    places = np.arange(len(parts))[::-1].astype(float)
    for values, by, colour, label in (
        ([100 * p.first for p in parts], 0.19, BEFORE, "added first"),
        ([100 * p.last for p in parts], -0.19, AFTER, "added last"),
    ):
        axes.barh(places + by, values, height=0.34, color=colour, label=label)
    axes.plot(
        [100 * p.mean for p in parts], places, "o", color=BAD, markersize=6, label="on average"
    )
    axes.axvline(0, color=REFERENCE, linewidth=0.8)
    tidy(axes, "Error that each effect explains", "share of the squared error (%)", "")
    axes.set_yticks(places, [words(p.effect) for p in parts])
    axes.grid(visible=False, axis="y")
    axes.legend(
        fontsize=7.5, frameon=False, ncols=3, loc="upper center", bbox_to_anchor=(0.5, -0.2)
    )


def _rms(loss: float, problem: Problem) -> float:
    return float(np.sqrt(loss / problem.residual.size))


def _free_rms(found: Investigation) -> float:
    """Repeatability floor: what is left when every block has a calibration of its own."""
    return float(np.sqrt(np.mean(residual_within_blocks(found.final) ** 2)))
