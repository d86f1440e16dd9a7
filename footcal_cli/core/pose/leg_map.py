"""Which leg a residual comes from: what each leg's own readings predict of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footcal_cli.core import chances
from footcal_cli.core.inference.linear import inverse_root
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.pose.data import PoseData
from footcal_cli.core.pose.joint import PoseFit
from footcal_cli.core.pose.problem import feature_noise

_SUSPECT_P = 1e-4
_SUSPECT_SHARE = 0.1
_SLOPES = 36
"""Of six balances by six readings of a leg; six means besides."""


@dataclass(frozen=True)
class LegMap:
    """Residual of the balance by leg and pose.

    Parameters
    ----------
    foretold
        Size of the residual that leg k's readings predict in pose p, in units of the noise,
        shape (K, P). A wrong gain, a twisted axis or a dead channel lights up its leg's row.
    share
        Part of the residual's square that each leg predicts, shape (K,).
    p
        Chance of such a share without any fault, shape (K,); 1 where so few poses are left beside
        the mounting that any leg's readings fit the residual.
    """

    foretold: FloatArray
    share: FloatArray
    p: FloatArray

    @property
    def suspect(self) -> int | None:
        """The leg that does not fit the others, by number: what it predicts is no chance."""
        found = np.flatnonzero((self.p < _SUSPECT_P) & (self.share > _SUSPECT_SHARE))
        return int(found[np.argmax(self.share[found])]) if found.size else None


def leg_map(data: PoseData, fit: PoseFit, noise_sd: FloatArray) -> LegMap:
    """Regress the whitened balance error on each leg's six readings."""
    matrix = fit.matrix
    factor = 1.0 if fit.options.noise_known else fit.noise_factor
    noise = feature_noise(noise_sd, factor * fit.options.attitude_sd_rad)
    root = inverse_root((matrix * noise) @ matrix.T)
    error = data.features() @ matrix.T @ root.T
    poses, legs = data.wrench_t.shape[:2]
    error = error - error.mean(axis=0)
    total = float(np.sum(error**2))
    foretold, share, chance = [], [], []
    for k in range(legs):
        reading = data.wrench_t[:, k] - data.wrench_t[:, k].mean(axis=0)
        slope = np.linalg.lstsq(reading, error, rcond=1e-9)[0]
        own = reading @ slope
        part = float(np.sum(own**2)) / total if total > 0 else 0.0
        foretold.append(np.linalg.norm(own, axis=1))
        share.append(part)
        if fit.left <= _SLOPES + 6:
            chance.append(1.0)
            continue
        freedom = _SLOPES, 6 * poses - _SLOPES - 6
        ratio = part / freedom[0] / max((1.0 - part) / freedom[1], np.finfo(float).tiny)
        chance.append(float(chances.f_sf(ratio, *freedom)))
    return LegMap(np.array(foretold), np.array(share), np.array(chance))
