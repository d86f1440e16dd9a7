"""What a walk is compared with besides its own motion: true forces, an offline calibration."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footcal_cli.core.log import Log
from footcal_cli.core.online.belief import Belief
from footcal_cli.core.online.replay import Replayed, corrected
from footcal_cli.core.parameters import Estimates, FloatArray
from footcal_cli.core.signals import low_pass_stretches


@dataclass(frozen=True)
class References:
    """What a walk is compared with besides its own motion.

    Parameters
    ----------
    truth_n
        True cell forces in the band of the cells, shape (n, c).
    baseline
        An offline calibration.
    """

    truth_n: FloatArray | None = None
    baseline: Estimates | None = None


def in_band(truth_n: FloatArray, rate_hz: float, *, causal: bool) -> FloatArray:
    """True forces in the band of the cells, shape (n, c)."""
    good = np.asarray(np.isfinite(truth_n).all(axis=1))
    return low_pass_stretches(truth_n, good, rate_hz, causal=causal)


def by_truth(log: Log, belief: Belief, truth_n: FloatArray, min_force_n: float) -> Replayed:
    """The true forces as if a calibration had produced them."""
    change = truth_n - belief.forces(log.readings)
    nothing = np.zeros(truth_n.shape)
    return corrected("true", log, belief, nothing, change, min_force_n=min_force_n)


def by_estimates(log: Log, belief: Belief, estimates: Estimates, min_force_n: float) -> Replayed:
    """What an offline calibration makes of the walk."""
    scale = np.array([estimates[f"{name}.scale"] for name in belief.channels])
    bias = np.array([estimates[f"{name}.bias"] for name in belief.channels])
    gain = scale / belief.scale_n_per_count - 1.0
    shape = log.readings.shape
    return corrected(
        "baseline", log, belief, np.broadcast_to(gain, shape),
        np.broadcast_to(bias - belief.bias_n * (1.0 + gain), shape), min_force_n=min_force_n,
    )  # fmt: skip
