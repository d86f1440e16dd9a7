"""A cell whose scale leaves those of the others. Room: core, checks; `static-init` asks."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footcal_cli.core import chances
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.quality import Finding

_FEWEST_CELLS, _BY_CHANCE = 4, 0.01
"""Cells of which one may be unlike the others, and how often that is said of none."""


def check_gain_apart(
    channels: Sequence[str], gain: FloatArray, covariance: FloatArray, prior: FloatArray
) -> list[Finding]:
    """Find the cell whose scale moved against the mean of the others, beyond what was known of it.

    ``z = wᵀγ / √(wᵀ (P₀ − P) w)`` with w a cell less the mean of the others, Bonferroni over the
    cells: a wrong mass moves all scales alike. The estimate and its prior differ by chance as far
    as the fit made it surer.

    Parameters
    ----------
    gain
        Relative change γ of each scale, shape (c,).
    covariance, prior
        P and P₀ of the gains, shape (c, c).
    """
    c = len(channels)
    if c < _FEWEST_CELLS:
        return []
    apart = np.eye(c) - (1.0 - np.eye(c)) / (c - 1)
    moved = apart @ gain
    sd = np.sqrt(np.diag(apart @ covariance @ apart.T))
    by_chance = np.diag(apart @ (prior - covariance) @ apart.T)
    z = np.abs(moved) / np.sqrt(np.where(by_chance > 0.0, by_chance, np.inf))
    most = int(np.argmax(z))
    if 2.0 * c * float(chances.norm_sf(z[most])) > _BY_CHANCE or sd[most] > abs(moved[most]) / 2.0:
        return []
    return [
        Finding(
            "gain_apart", "warning", channels[most],
            f"its scale comes out {100 * abs(moved[most]):.2g} ± {100 * sd[most]:.1g} % "
            f"{'above' if moved[most] > 0 else 'below'} those of the other cells, which is not by "
            "chance: its gain changed since it was calibrated, or another error goes into it",
            "calibrate this cell again with weights; footcal diagnose --experiment stand, from the "
            "calibration before this one, says what else it may be",
        )
    ]  # fmt: skip
