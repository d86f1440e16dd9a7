"""A known weight over a known hole: the cells of one foot must carry it there."""

from __future__ import annotations

import numpy as np

from footcal_cli.core.effects.calibration import SCALE_BIAS
from footcal_cli.core.experiments.contract import Balance, Experiment
from footcal_cli.core.log import Log


def balance(log: Log) -> Balance:
    """Total force against the weight, and the moment of the cell forces about the hole.

    ``Σ F_i − load`` in N and ``Σ (p_i − hole) F_i`` in Nm: the latter is the CoP error times Fz
    ([NAO], eqs. (3)–(5), (8)), linear in the forces and defined at the smallest weight.
    """
    forces = log.readings
    arms = log.known["cell_pos_m"] - log.known["hole_m"][:, None, :]
    fz = forces.sum(axis=1) - log.known["load_n"].reshape(len(log), -1).sum(axis=1)
    moments = np.einsum("nc,nck->nk", forces, arms)
    error = np.column_stack([fz, moments])
    foot = log.channels[0].split("_", 1)[0]
    return Balance(
        (f"{foot}.fz", f"{foot}.moment_x", f"{foot}.moment_y"),
        ("N", "Nm", "Nm"),
        error,
        np.isfinite(error),
    )


EXPERIMENT = Experiment(
    name="placements",
    known={
        "load_n": "weight of the placement, N, shape (n,)",
        "hole_m": "where it acts, foot frame, m, shape (n, 2)",
        "cell_pos_m": "believed cell positions, foot frame, m, shape (n, c, 2)",
        "temperature_degc": "temperature of the cells, °C, shape (n,), optional",
    },
    balance=balance,
    calibration=(SCALE_BIAS.name,),
    few_visits=True,
)
