"""Leg CoM straight from the torques, bin by bin of the shaft angle: a picture of the data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from footcal_cli.core.hang.joint import HangFit
from footcal_cli.core.hang.runs import HangRun
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.spatial import skew

_WELL_SEEN = 0.05
_BINS = 36
_QUANTILES = (0.025, 0.25, 0.5, 0.75, 0.975)


@dataclass(frozen=True)
class BinnedCom:
    """Spread of the leg CoM over cycles ([Wu], Figs. 4 and 7).

    Parameters
    ----------
    phase_rad
        Middle of each bin, shape (b,).
    median_m, low_m, high_m
        Median and quartiles over cycles, shape (b, 3); nan where no orientation shows the CoM.
    low95_m, high95_m
        Between which 95 % of the cycles lie.
    """

    phase_rad: FloatArray
    median_m: FloatArray
    low_m: FloatArray
    high_m: FloatArray
    low95_m: FloatArray
    high95_m: FloatArray


class Hanging(Protocol):
    """A fit of a hanging leg that knows no motion of the leg: weight, offset (6,), gravity."""

    @property
    def weight_n(self) -> float: ...  # noqa: D102 - named above
    @property
    def offset(self) -> FloatArray: ...  # noqa: D102

    def gravity_dir_t(self, runs: Sequence[HangRun]) -> FloatArray:
        """Direction of gravity per run in the transducer frame, shape (L, 3)."""


def binned_com(fit: HangFit | Hanging, runs: Sequence[HangRun]) -> BinnedCom:
    """Solve ``τ − τ_o = r × m g u`` per bin and cycle over all orientations ([Wu], III-A.3).

    Offset, weight and directions are those of the fit that is shown.
    """
    down, torques = _arms(fit, runs)
    rows, counted = [], []
    for run, torque in zip(runs, torques, strict=True):
        turned = np.unwrap(run.phase_rad)
        cycle = np.floor((turned - turned.min()) / (2 * np.pi)).astype(int)
        place = np.floor(np.mod(run.phase_rad, 2 * np.pi) / (2 * np.pi) * _BINS).astype(int) % _BINS
        total = np.zeros((cycle.max() + 1, _BINS, 3))
        count = np.zeros((cycle.max() + 1, _BINS))
        np.add.at(total, (cycle, place), torque)
        np.add.at(count, (cycle, place), 1.0)
        rows.append(np.where(count[..., None] > 0, total / np.maximum(count, 1)[..., None], np.nan))
        counted.append(total.shape[0])
    cycles = min(counted)
    lever = -skew(down)
    normal = np.einsum("lji,ljk->ik", lever, lever)
    phase = (np.arange(_BINS) + 0.5) / _BINS * 2 * np.pi
    if np.linalg.eigvalsh(normal)[0] < _WELL_SEEN * np.linalg.eigvalsh(normal)[-1]:
        nothing = np.full((_BINS, 3), np.nan)
        return BinnedCom(phase, nothing, nothing, nothing, nothing, nothing)
    right = sum(
        (rows[i][:cycles] @ lever[i] for i in range(len(runs))), start=np.zeros((cycles, _BINS, 3))
    )
    each = np.linalg.solve(normal, right[..., None])[..., 0]
    whole = np.isfinite(each).all(axis=(1, 2))
    spread = np.quantile(each[whole] if whole.any() else each, _QUANTILES, axis=0)
    low95, low, median, high, high95 = spread
    return BinnedCom(phase, median, low, high, low95, high95)


def _arms(fit: HangFit | Hanging, runs: Sequence[HangRun]) -> tuple[FloatArray, list[FloatArray]]:
    """Leg weight as a vector per run (L, 3), and torques of leg weight alone per run (n, 3)."""
    if not isinstance(fit, HangFit):
        down = fit.weight_n * fit.gravity_dir_t(runs)
        return down, [run.wrench[:, 3:] - fit.offset[3:] for run in runs]
    torques = [rest[:, 3:] - fit.values.offset[3:] for rest in fit.at_rest(runs)]
    return fit.values.weight_n * fit.gravity_dir_t, torques
