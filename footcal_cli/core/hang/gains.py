"""Axes of unequal gain: forces in many attitudes that are no weight turned, but a weight mixed.

Room: core, hang; asked by its sheet. With the direction d of gravity in the transducer,
``f = K d + o``; one weight and one mounting allow ``K = m g Q`` with Q a rotation alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footcal_cli.core import chances
from footcal_cli.core.hang.runs import HangRun

_FEWEST = 8
"""Attitudes asked for: twelve numbers are fitted to three forces in each."""
_SURE, _MATTERS = 1e-6, 0.01
_MORE = 5.0  # numbers that K has beyond a weight and a rotation


@dataclass(frozen=True)
class UnequalGains:
    """What the forces of a hanging show of their axes.

    Parameters
    ----------
    spread
        Largest less smallest singular value of K, over their mean.
    offset_moved_n
        How far the offsets lie from those of a weight and a rotation, N, at most.
    """

    spread: float
    offset_moved_n: float


def unequal_gains(runs: Sequence[HangRun]) -> UnequalGains | None:
    """Gains that differ surely and by more than a hundredth; None where nothing says so.

    ``F = ((RSS' − RSS) / 5) / (RSS / (3 n − 12))`` of the means of n attitudes, RSS' with K a
    scaled rotation (Procrustes), RSS with K free.
    """
    way = np.array([run.nominal_dir_t for run in runs])
    force = np.array([run.wrench[:, :3].mean(axis=0) for run in runs])
    if len(runs) < _FEWEST or np.linalg.matrix_rank(way - way.mean(axis=0), tol=0.1) < 3:
        return None
    d, f = way - way.mean(axis=0), force - force.mean(axis=0)
    free = np.linalg.lstsq(d, f)[0]
    left, size, right = np.linalg.svd(d.T @ f)
    sign = np.array([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
    turned = (left * (sign * (size @ sign) / 3.0 / np.mean(np.sum(d**2, axis=0)))) @ right
    turned *= np.sum((d @ turned) * f) / np.sum((d @ turned) ** 2)
    rest, bound = (float(np.sum((f - d @ k) ** 2)) for k in (free, turned))
    many = 3.0 * len(runs) - 12.0
    gains = np.linalg.svd(free, compute_uv=False)
    spread = float(np.ptp(gains) / gains.mean())
    sure = chances.f_sf((bound - rest) / _MORE / max(rest / many, 1e-300), _MORE, many) < _SURE
    moved = float(np.abs(way.mean(axis=0) @ (free - turned)).max())
    return UnequalGains(spread, moved) if sure and spread > _MATTERS else None
