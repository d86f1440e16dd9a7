"""Cells whose readings are exchanged: another order of the channels fits known weights at once."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.quality import Finding

MUCH_BETTER = 0.25
"""RMS error after exchanging two channels over that before, below which they are exchanged."""
CLEARLY = 0.5
"""And below this share of the next best exchange."""


def check_exchanged_cells(
    counts: FloatArray,
    names: Sequence[str],
    cell_m: FloatArray,
    hole_m: FloatArray,
    load_n: FloatArray,
) -> list[Finding]:
    """Fit scale and bias of all cells to placements, in the given order and with pairs exchanged.

    ``Σ (c_i S_i + d_i) = W`` and ``Σ (p_i − h)(c_i S_i + d_i) = 0`` (seed 1, eqs. (1)–(5), (8)).

    Parameters
    ----------
    counts
        Readings, shape (n, c).
    names
        Of the cells, c of them.
    cell_m, hole_m
        Where cells and weights are, foot frame, shapes (c, 2) and (n, 2).
    load_n
        Weights, shape (n,).
    """
    count = len(names)
    if len(load_n) < 2 * count + 2:
        return []
    given = _misfit(counts, cell_m, hole_m, load_n)
    tried = []
    for a, b in combinations(range(count), 2):
        order = np.arange(count)
        order[[a, b]] = b, a
        tried.append((_misfit(counts[:, order], cell_m, hole_m, load_n), names[a], names[b]))
    tried.sort()
    best, first, second = tried[0]
    if best > MUCH_BETTER * given or (len(tried) > 1 and best > CLEARLY * tried[1][0]):
        return []
    return [
        Finding(
            "exchanged_channels", "alarm", f"{first}, {second}",
            f"the readings of {first} and {second} look exchanged: with their names exchanged the "
            f"error of the weights falls to {best / given:.1%}",
            "press one of the two cells by hand; exchange the plugs or the names in the recipe",
        )
    ]  # fmt: skip


def _misfit(
    counts: FloatArray, cell_m: FloatArray, hole_m: FloatArray, load_n: FloatArray
) -> float:
    """RMS error of force and moments, the latter over the foot's half-width, in N."""
    lever = float(np.abs(cell_m - cell_m.mean(axis=0)).max())
    readings = np.hstack([counts - counts.mean(axis=0), np.ones_like(counts)])
    arms = np.tile(cell_m.T[:, None, :] - hole_m.T[:, :, None], (1, 1, 2)) / lever
    design = np.vstack([readings, *(readings * arm for arm in arms)])
    target = np.concatenate([load_n, np.zeros(2 * len(load_n))])
    norm = np.sqrt(np.mean(design**2, axis=0))
    norm = np.where(norm > 0, norm, 1.0)
    fitted = np.linalg.lstsq(design / norm, target, rcond=1e-9)[0]
    return float(np.sqrt(np.mean((target - design / norm @ fitted) ** 2)))
