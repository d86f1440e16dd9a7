"""What hangs below the cells of a foot: its weight while the foot is in the air, and its inertia.

A plate of mass m that cells drive is accelerated with the foot: together they feel ``−m a``. In the
middle of a swing a foot is accelerated downwards by metres per second squared, which reads as load
without load; in the totals, where the other foot stands, it reads as a cell that is wrong.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from footcal_cli.core.contact import airborne
from footcal_cli.core.effects.contract import Scope, columns_of
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray

PLATE_STATE, PLATE_MASS = "plate_weight", "plate_mass"
PLATE_SD_N = 1.0
PLATE_MASS_SHARE = 0.05
"""Prior sd of what is accelerated below the cells of a foot, of the robot's mass: what a whole foot
weighs, at most."""
UNITS: Mapping[str, str] = {PLATE_STATE: "N", PLATE_MASS: "kg"}


def hanging_of(log: Log) -> FloatArray:
    """How much of each foot's reading is that of a foot in the air, 0 to 1, shape (n, feet)."""
    logged = log.known.get("airborne")
    return airborne(log.known["contact"]) if logged is None else logged


def plate_priors(log: Log, feet: Sequence[str], sd: Mapping[str, float]) -> dict[str, float]:
    """Names of what may hang below the feet, weights first, and their prior sd.

    Parameters
    ----------
    sd
        Prior sd by kind where it is not the default.
    """
    found = {f"{foot}.{PLATE_STATE}": sd.get(PLATE_STATE, PLATE_SD_N) for foot in feet}
    if "foot_acc_mps2" in log.known:
        usual = PLATE_MASS_SHARE * float(np.median(log.known["mass_kg"]))
        found |= {f"{foot}.{PLATE_MASS}": sd.get(PLATE_MASS, usual) for foot in feet}
    return found


def per_plate(log: Log, names: Sequence[str]) -> FloatArray:
    """Newtons that a foot's cells together lack per unit of each state, shape (n, states)."""
    feet = len(columns_of(Scope.FOOT, log.channels))
    lacking = {PLATE_STATE: hanging_of(log)}
    if "foot_acc_mps2" in log.known:
        lacking[PLATE_MASS] = np.nan_to_num(log.known["foot_acc_mps2"][:, :, 2])
    kinds = [name.rsplit(".", 1)[-1] for name in names]
    columns = [lacking[kind][:, i % feet] for i, kind in enumerate(kinds)]
    return np.stack(columns, axis=1) if columns else np.zeros((len(log), 0))


def lacking_n(log: Log, names: Sequence[str], values: FloatArray) -> FloatArray:
    """What each cell feels less than the ground does, N, (n, c); `values` (n, states)."""
    feet = columns_of(Scope.FOOT, log.channels)
    each = per_plate(log, names) * values
    lacking = np.zeros(log.readings.shape)
    for i in range(len(names)):
        columns = feet[i % len(feet)]
        lacking[:, columns] += each[:, i : i + 1] / columns.size
    return lacking
