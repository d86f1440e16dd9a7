"""Held-out errors block by block."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core.diagnosis.gain import Gain
from footcal_cli.core.diagnosis.investigation import Investigation
from footcal_cli.plots.style import AFTER, BEFORE, legend_below, new_figure, tidy
from footcal_cli.plots.words import capital, output_words

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def clearest(found: Investigation) -> Gain:
    """The output whose error falls most."""
    return max(found.gains, key=lambda g: g.change.value)


def in_words(found: Investigation) -> str:
    """Held-out error before and after, of the output whose error falls most."""
    gain = clearest(found)
    blocks = len(gain.per_block)
    if not found.found:
        return f"RMS error of the {output_words(gain.output)} {gain.before:.3g} {gain.unit}."
    better = int(np.sum(gain.per_block[:, 1] < gain.per_block[:, 0]))
    return (
        f"The error of the {output_words(gain.output)} goes from {gain.before:.3g} to "
        f"{gain.after:.3g} {gain.unit}; it falls in {better} of {blocks} blocks."
    )


def plot_gains(found: Investigation) -> Figure:
    """Error of each held-out block before and after."""
    gain = clearest(found)
    name = capital(output_words(gain.output))
    blocks = np.arange(1, len(gain.per_block) + 1)
    figure = new_figure(3.2)
    axes = figure.add_subplot()
    axes.vlines(blocks, gain.per_block[:, 1], gain.per_block[:, 0], color="#c9ced6", linewidth=1.2)
    axes.plot(
        blocks, gain.per_block[:, 0], "o", color=BEFORE, markersize=5, markerfacecolor="white",
        label="before" if found.found else "no effect in the model",
    )  # fmt: skip
    if found.found:
        axes.plot(blocks, gain.per_block[:, 1], "o", color=AFTER, markersize=5, label="after")
    better = int(np.sum(gain.per_block[:, 1] < gain.per_block[:, 0]))
    title = f"{name}: better in {better} of {blocks.size} held-out blocks"
    tidy(axes, title if found.found else f"{name}: error of each held-out block", "held-out block",
         f"RMS error ({gain.unit})")  # fmt: skip
    axes.set_ylim(bottom=0)
    legend_below(figure)
    return figure
