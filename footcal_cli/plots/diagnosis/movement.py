"""How far the calibration moves."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core.diagnosis.movement import Movement
from footcal_cli.plots.style import AFTER, BAD, REFERENCE, new_figure, tidy

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOVEMENT_CAPTION = (
    "How far each calibration parameter moves when the effect enters the model, in its own sd."
)


_NOTABLE_SD = 3.0


def in_words(moved: Sequence[Movement]) -> str:
    """The parameter that moves most."""
    most = max(moved, key=lambda m: abs(m.in_sd))
    in_sd = f"{most.in_sd:+.1f}".replace("-", "−")
    beyond = sum(abs(m.in_sd) > _NOTABLE_SD for m in moved)
    return (
        f"{most.name} moves most, by {in_sd} sd; {beyond} of {len(moved)} parameters move by "
        f"more than {_NOTABLE_SD:g} sd."
    )


def plot_movement(moved: Sequence[Movement]) -> Figure:
    """Movement of each parameter in units of its sd."""
    figure = new_figure(0.22 * len(moved) + 1.2)
    axes = figure.add_subplot()
    places = np.arange(len(moved))[::-1]
    steps = np.array([m.in_sd for m in moved])
    axes.barh(
        places, steps, color=[BAD if abs(s) > _NOTABLE_SD else AFTER for s in steps], height=0.6
    )
    axes.axvline(0, color=REFERENCE, linewidth=0.8)
    axes.axvspan(-2, 2, color="#e8f1f8", zorder=0)
    axes.set_yticks(places, [m.name for m in moved])
    tidy(axes, "Movement of the calibration (shaded: within 2 sd)", "moved (sd)", "")
    return figure
