"""No credit for making noise small, no blame for making it large: what a model does to it.

A gain taken out of a reading is taken out of its noise too. A model that says "the sensor shows
too much" leaves smaller errors than one that says "the robot is lighter" for that reason alone;
a likelihood of the readings would charge it ``log |d truth / d reading|``.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from footcal_cli.core.chain import Chain
from footcal_cli.core.experiments.contract import residual
from footcal_cli.core.inference.case import Case
from footcal_cli.core.inference.ideal import TORQUE_SHARE
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray

_PROBE = 1e-3
"""Size of the noise that is sent through, against the spread of the readings."""


def shrinkage(case: Case, rows: Problem, chain: Chain, values: Mapping[str, float]) -> FloatArray:
    """Noise of each entry under a model over that under the baseline, shape (m,).

    Above 1 too: a dead zone makes the noise of small loads larger where the hinge that equals it
    makes that of large loads smaller, and calibration takes up the rest. But only as far as noise
    that is slow becomes larger: a model that undoes a low-pass makes white noise larger than any
    that the readings have.

    Parameters
    ----------
    case, rows
        The baseline.
    """
    white = _ratio(case, rows, chain, values, slow=False)
    slow = _ratio(case, rows, chain, values, slow=True)
    ratio = np.where(white > 1.0, np.clip(slow, 1.0, white), white)
    return np.asarray(np.maximum(ratio, 1e-3)[rows.output])


def _ratio(
    case: Case, rows: Problem, chain: Chain, values: Mapping[str, float], *, slow: bool
) -> FloatArray:
    """What the model makes of a probe over what the baseline makes of it, shape (outputs,)."""
    before, after = np.zeros(len(rows.outputs)), np.zeros(len(rows.outputs))
    for i, log in enumerate(case.logs):
        here = rows.log == i
        probe = _probe(log, slow=slow)
        for sums, used, at in ((before, case.chain, case.values), (after, chain, values)):
            change = _passed(case, log, probe, used, at)[rows.row[here], rows.column[here]]
            sums += np.bincount(rows.output[here], change**2, minlength=sums.size)
    return np.sqrt(np.divide(after, before, out=np.ones_like(after), where=before > 0))


def _probe(log: Log, *, slow: bool) -> FloatArray:
    """Noise of a thousandth of the readings' spread, torques by their share.

    White, or the same throughout each block.
    """
    rng = np.random.default_rng(0)
    is_torque = np.array([".t" in channel for channel in log.channels])
    size = _PROBE * max(float(np.nanstd(log.readings)), 1e-9)
    noise = rng.standard_normal(log.readings.shape)
    if slow:
        _, block = np.unique(log.block, return_inverse=True)
        noise = noise[block]
    return noise * np.where(is_torque, TORQUE_SHARE, 1.0) * size


def _passed(
    case: Case, log: Log, probe: FloatArray, chain: Chain, values: Mapping[str, float]
) -> FloatArray:
    """What the probe becomes in the balance, shape (n, k)."""
    noisy = residual(case.experiment, chain, log.with_readings(log.readings + probe), values)
    plain = residual(case.experiment, chain, log, values)
    return np.nan_to_num(noisy.error - plain.error)
