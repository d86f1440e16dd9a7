"""Known weights on load cells: what a channel reads must equal what lies on it."""

from __future__ import annotations

import numpy as np

from footcal_cli.core.effects.calibration import AXES, AXIS_UNITS, SCALE_BIAS
from footcal_cli.core.experiments.contract import Balance, Experiment
from footcal_cli.core.log import Log


def balance(log: Log) -> Balance:
    """Readings minus known loads per channel, ``F_i − load_i``: [NAO], eqs. (1)(2).

    A six-axis sensor has ``wrench`` (n, 6) in place of ``load_n``. Rows whose load is unknown (NaN:
    a weight being changed) do not count.
    """
    if "wrench" in log.known:
        known, outputs, units = log.known["wrench"], AXES, AXIS_UNITS
    else:
        known = log.known["load_n"].reshape(len(log), -1)
        outputs, units = log.channels, ("N",) * len(log.channels)
    if known.shape[1] != len(log.channels):
        raise ValueError(f"{known.shape[1]} known loads for {len(log.channels)} channels")
    error = log.readings - known
    return Balance(outputs, units, error, np.isfinite(error))


EXPERIMENT = Experiment(
    name="weights",
    known={
        "load_n": "true load on each channel, N, shape (n, c) or (n,); NaN where unknown",
        "wrench": "true wrench on a six-axis sensor, N and Nm, shape (n, 6), in place of load_n",
        "temperature_degc": "temperature of the cells, °C, shape (n,), optional",
        "direction": "+1 loading, −1 unloading, 0 unknown, shape (n,), optional",
    },
    balance=balance,
    calibration=(SCALE_BIAS.name,),
    few_visits=True,
)
