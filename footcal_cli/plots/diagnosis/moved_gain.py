"""The gain of each cell of a walk against what its calibration allows."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core.diagnosis.answer import MovedGain
from footcal_cli.plots.style import AFTER, BAD, REFERENCE, new_figure, tidy

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CAPTION = (
    "Points: gain of each cell as the walk shows it, with 95 % intervals. Shaded: 95 % of what a "
    "mounting moves. A gain that has moved shows in no residual, since the calibration follows it."
)


def in_words(gains: Sequence[MovedGain]) -> str:
    """What has moved, and how far the others are off at most."""
    moved = ", ".join(f"{g.cell} by {_percent(g)} %" for g in gains if g.certain)
    others = [g for g in gains if not g.certain]
    if not others:
        return f"{moved}."
    most = max(others, key=lambda g: abs(g.change.value))
    return f"{moved}; of the others {most.cell} by most, {_percent(most)} %."


def plot_moved_gain(gains: Sequence[MovedGain]) -> Figure:
    """Change of each gain with its interval, over what a mounting moves."""
    figure = new_figure(0.3 * len(gains) + 1.3)
    axes = figure.add_subplot()
    for place, gain in zip(np.arange(len(gains))[::-1], gains, strict=True):
        change, allowed = gain.change, 196.0 * gain.mounting_sd
        axes.fill_betweenx(
            [place - 0.4, place + 0.4], -allowed, allowed, color="#e8f1f8", linewidth=0, zorder=0
        )
        colour = BAD if gain.certain else AFTER
        axes.plot([100.0 * change.low, 100.0 * change.high], [place, place], color=colour)
        axes.plot(100.0 * change.value, place, "o", color=colour)
    axes.axvline(0, color=REFERENCE, linewidth=0.8)
    axes.set_yticks(np.arange(len(gains))[::-1], [gain.cell for gain in gains])
    tidy(axes, "Gain against the calibration (shaded: what a mounting moves)", "change (%)", "")
    return figure


def _percent(gain: MovedGain) -> str:
    return f"{100.0 * gain.change.value:+.1f}".replace("-", "\u2212")
