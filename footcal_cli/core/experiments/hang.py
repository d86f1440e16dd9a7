"""Hanging leg: no ground contact, so the transducer carries the leg's weight and nothing else."""

from __future__ import annotations

import numpy as np

from footcal_cli.core.effects.calibration import AXES, AXIS_UNITS, OFFSET
from footcal_cli.core.effects.six_axis_beliefs import HANG_TILT, LEG_COM, LEG_WEIGHT
from footcal_cli.core.experiments.contract import Balance, Experiment
from footcal_cli.core.log import Log
from footcal_cli.core.spatial import cross


def hang_balance(log: Log) -> Balance:
    """Measured − demanded wrench, ``w − [m (g u − r̈); r × m (g u − r̈)]``, (n, 6).

    [Wu], eqs. (4)-(7), with the acceleration r̈ of a leg that turns, where it is known.
    """
    felt = log.known["gravity_dir"] - log.known.get("leg_acc_g", np.zeros((len(log), 3)))
    force_t = log.known["leg_weight_n"][:, None] * felt
    demanded = np.hstack([force_t, cross(log.known["leg_com_m"], force_t)])
    error = log.readings - demanded
    return Balance(AXES, AXIS_UNITS, error, np.isfinite(error))


EXPERIMENT = Experiment(
    name="hang",
    known={
        "phase_rad": "shaft angle, (n,), rad",
        "gravity_dir": "unit direction of gravity in the transducer frame, (n, 3)",
        "leg_weight_n": "weight of the leg, (n,), N",
        "leg_com_m": "leg centre of mass in the transducer frame, (n, 3), m",
    },
    balance=hang_balance,
    calibration=tuple(e.name for e in (OFFSET, LEG_WEIGHT, LEG_COM, HANG_TILT)),
)
