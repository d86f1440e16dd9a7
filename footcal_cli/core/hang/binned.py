"""Leg CoM straight from the torques, bin by bin of the shaft angle: a picture of the data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footcal_cli.core.hang.joint import HangFit
from footcal_cli.core.hang.runs import HangRun
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.spatial import skew

_WELL_SEEN = 0.05


@dataclass(frozen=True)
class BinnedCom:
    """Spread of the leg CoM over cycles (seed 2, Fig. 4).

    Parameters
    ----------
    phase_rad
        Middle of each bin, shape (b,).
    median_m, low_m, high_m
        Median and quartiles over cycles, shape (b, 3); nan where no orientation shows the CoM.
    """

    phase_rad: FloatArray
    median_m: FloatArray
    low_m: FloatArray
    high_m: FloatArray


def binned_com(fit: HangFit, runs: Sequence[HangRun], bins: int = 36) -> BinnedCom:
    """Solve ``τ − τ_o = r × m g u`` per bin and cycle over all orientations (seed 2, III-A.3)."""
    down = fit.values.weight_n * fit.gravity_dir_t
    rows: dict[int, FloatArray] = {}
    counted = []
    for number, run in enumerate(runs):
        turned = np.unwrap(run.phase_rad)
        cycle = np.floor((turned - turned.min()) / (2 * np.pi)).astype(int)
        place = np.floor(np.mod(run.phase_rad, 2 * np.pi) / (2 * np.pi) * bins).astype(int) % bins
        turning = fit.model.inertial_wrench(
            fit.values, run.phase_rad, run.shaft_radps, run.shaft_radps2
        )
        torque = (run.wrench - turning)[:, 3:] - fit.values.offset[3:]
        total = np.zeros((cycle.max() + 1, bins, 3))
        count = np.zeros((cycle.max() + 1, bins))
        np.add.at(total, (cycle, place), torque)
        np.add.at(count, (cycle, place), 1.0)
        rows[number] = np.where(
            count[..., None] > 0, total / np.maximum(count, 1)[..., None], np.nan
        )
        counted.append(total.shape[0])
    cycles = min(counted)
    lever = -skew(down)
    normal = np.einsum("lji,ljk->ik", lever, lever)
    phase = (np.arange(bins) + 0.5) / bins * 2 * np.pi
    if np.linalg.eigvalsh(normal)[0] < _WELL_SEEN * np.linalg.eigvalsh(normal)[-1]:
        nothing = np.full((bins, 3), np.nan)
        return BinnedCom(phase, nothing, nothing, nothing)
    right = sum(
        (rows[i][:cycles] @ lever[i] for i in range(len(runs))), start=np.zeros((cycles, bins, 3))
    )
    each = np.linalg.solve(normal, right[..., None])[..., 0]
    whole = np.isfinite(each).all(axis=(1, 2))
    low, median, high = np.quantile(each[whole] if whole.any() else each, [0.25, 0.5, 0.75], axis=0)
    return BinnedCom(phase, median, low, high)
