"""How the error falls, effect by effect, down to what is possible."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from footcal_cli.core.diagnosis.investigation import Investigation
from footcal_cli.core.diagnosis.problem import Problem
from footcal_cli.core.parameters import FloatArray
from footcal_cli.plots.style import AFTER, BEFORE, new_figure, tidy

LADDER_CAPTION = (
    "How the held-out error falls: each effect added first and added last, down to what any "
    "function of the recorded signals could reach."
)


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
