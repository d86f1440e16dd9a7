"""Which effects look alike in these data."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from footcal_cli.core.diagnosis.answer import EffectStatus
from footcal_cli.core.diagnosis.investigation import Investigation
from footcal_cli.core.parameters import FloatArray
from footcal_cli.plots.style import BAD, new_figure

ISOLABILITY_CAPTION = (
    "Which effects look alike in these data beside the calibration: |cos| of what stays visible of "
    "them. Outlined: pairs that no analysis of these data can separate."
)


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
