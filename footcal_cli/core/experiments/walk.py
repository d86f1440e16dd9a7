"""Walking: the ground must do what the motion of the body demands, and a foot in the air nothing.

Cells: total vertical force and horizontal moments about the demanded CoP ([NAO], eqs. (9)–(11),
in the linear form ``Σ (pᵢ − p_ref) fᵢ = 0``), and every cell of a swinging foot reads zero.
Six-axis feet: total force and horizontal moments, and a swinging foot weighs what hangs below its
transducer.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TypedDict

import numpy as np

from footcal_cli.core.centroidal import MIN_FORCE_N, Reference, dynamic_reference, static_reference
from footcal_cli.core.effects.body import ANGULAR_MOMENTUM, COM_OFFSET
from footcal_cli.core.effects.calibration import OFFSET, SCALE_BIAS
from footcal_cli.core.effects.contract import Scope, columns_of, is_six_axis, units_of
from footcal_cli.core.effects.foot import PLATE_INERTIA
from footcal_cli.core.effects.six_axis import MOUNT_TRANSLATION, SCALE_MATRIX
from footcal_cli.core.effects.transport import ACCELERATION_DELAY, DELAY, LAG, SMOOTHING
from footcal_cli.core.effects.usual import (
    CHANGE_OF_FOOT,
    FOOT_INERTIA,
    GAIT_MOMENT,
    LEG_MASS,
    LEG_SWING,
    LIMB_SWING,
)
from footcal_cli.core.experiments.contract import Balance, Experiment, Imperfection
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import BoolArray, FloatArray
from footcal_cli.core.spatial import cross

CELL_TOTALS = ("fz", "mx", "my")
SIX_AXIS_TOTALS = ("fx", "fy", "fz", "mx", "my")

KNOWN: Mapping[str, str] = {
    "com_m": "centre of mass in the world, height above the ground, m, (n, 3)",
    "com_acc_mps2": "its acceleration, gravity not included, m/s², (n, 3)",
    "angmom_rate_nm": "rate of angular momentum about it, x and y, Nm, (n, 2)",
    "mass_kg": "mass that the feet carry, kg, (n,)",
    "gravity_mps2": "m/s², (n,)",
    "cell_pos_m": "believed positions of the cells in the world, m, (n, c, 2)",
    "foot_yaw_rad": "heading of each foot, rad, (n, feet)",
    "contact": "1 loaded, 0 in the air, NaN in transition, (n, feet)",
}
SIX_AXIS_KNOWN: Mapping[str, str] = {
    "foot_rot_wt": "transducer to world, (n, feet, 3, 3)",
    "foot_pos_m": "transducers in the world, height above the ground, m, (n, feet, 3)",
    "foot_weight_n": "weight below each transducer, N, (n, feet)",
    "foot_com_m": "its CoM in the transducer's frame, m, (n, feet, 3)",
    "foot_acc_mps2": "acceleration of what hangs below, gravity not included, m/s², (n, feet, 3)",
}
"""What six-axis feet need beside `KNOWN`, in place of the cells' positions.

`foot_weight_sd_n`, (n, feet), where it is known: how far the weight may be off."""


def balance(log: Log) -> Balance:
    """Forces of a log whose distortions are removed against what the motion demands."""
    if is_six_axis(log.channels):
        return six_axis_balance(log)
    return cell_balance(log, log.of_known(reference_of))


def reference_of(log: Log, *, static: bool = False) -> Reference:
    """Vertical force and CoP that the motion of a log demands; static: Han's assumption."""
    known = log.known
    if static:
        return static_reference(known["com_m"], known["mass_kg"], known["gravity_mps2"])
    return dynamic_reference(
        known["com_m"],
        known["com_acc_mps2"],
        known["angmom_rate_nm"],
        known["mass_kg"],
        known["gravity_mps2"],
    )


def cell_balance(log: Log, reference: Reference) -> Balance:
    """Vertical force (N), moments about the demanded CoP (Nm), swinging cells (N).

    ``fz = Σ fᵢ − F_ref``, ``mx = Σ (yᵢ − p_refʸ) fᵢ``, ``my = −Σ (xᵢ − p_refˣ) fᵢ``.
    """
    forces, known = log.readings, len(CELL_TOTALS)
    # a product is many times faster than a sum over a few columns
    total = forces @ np.ones(forces.shape[1])
    lever_x, lever_y = log.of_known(_levers)
    error = np.empty((len(log), known + forces.shape[1]))
    np.subtract(total, reference.fz_n, out=error[:, 0])
    error[:, 1] = np.einsum("nc,nc->n", lever_y, forces) - reference.cop_m[:, 1] * total
    error[:, 2] = reference.cop_m[:, 0] * total - np.einsum("nc,nc->n", lever_x, forces)
    error[:, known:] = forces
    return Balance(
        outputs=(*CELL_TOTALS, *log.channels),
        units=("N", "Nm", "Nm", *["N"] * len(log.channels)),
        **_counted(log, error, known, reference.fz_n > least_force_n(log)),
    )


def _levers(log: Log) -> tuple[FloatArray, FloatArray]:
    """Places of the cells along x and y, shape (n, c) each."""
    x, y = np.moveaxis(log.known["cell_pos_m"], -1, 0)
    return np.ascontiguousarray(x), np.ascontiguousarray(y)


def least_force_n(log: Log) -> FloatArray | float:
    """ε below which there is no CoP, N: `min_force_n` of the log, (n,), else 5 N."""
    return log.known.get("min_force_n", MIN_FORCE_N)


def six_axis_balance(log: Log) -> Balance:
    """Total force and horizontal moments about the CoM, and wrenches of swinging feet.

    ``Σ R f = m (c̈ + g) − Σ w``, ``Σ [(p − c) × R f + R τ] = L̇ − Σ (p_w − c) × w`` with w the
    weight and inertia of what hangs below each transducer; a swinging foot reads the wrench of w.
    """
    known = log.known
    rot, pos = known["foot_rot_wt"], known["foot_pos_m"]
    wrench = log.readings.reshape(len(log), -1, 6)
    below = wrench - log.of_known(_carried_below)
    force = np.einsum("nkij,nkj->nki", rot, below[..., :3])
    moment = np.einsum("nkij,nkj->nki", rot, below[..., 3:])
    moment = moment + cross(pos - known["com_m"][:, None], force)
    totals = np.concatenate(
        [
            force.sum(axis=1) - log.of_known(_demanded_force),
            moment.sum(axis=1)[:, :2] - known["angmom_rate_nm"],
        ],
        axis=1,
    )
    error = np.concatenate([totals, below.reshape(len(log), -1)], axis=1)
    axis_units = ["N", "N", "N", "Nm", "Nm", "Nm"] * wrench.shape[1]
    return Balance(
        outputs=(*SIX_AXIS_TOTALS, *log.channels),
        units=("N", "N", "N", "Nm", "Nm", *axis_units),
        **_counted(log, error, totals.shape[1], np.ones(len(log), dtype=bool)),
    )


def _carried_below(log: Log) -> FloatArray:
    """Wrench of what hangs below each transducer, shape (n, feet, 6)."""
    return applied_below(log, log.known["foot_weight_n"])


def _demanded_force(log: Log) -> FloatArray:
    """``m (c̈ + g)``, shape (n, 3)."""
    known = log.known
    demanded = known["mass_kg"][:, None] * known["com_acc_mps2"]
    demanded[:, 2] += known["mass_kg"] * known["gravity_mps2"]
    return demanded


def applied_below(log: Log, weight_n: FloatArray) -> FloatArray:
    """Wrench that a weight hanging below a transducer puts on it, (n, feet, 6), its own frame.

    ``f = −Rᵀ (g e_z + p̈) w/g`` at its CoM: a foot that is swung forward pulls back.

    Parameters
    ----------
    log
        For `SIX_AXIS_KNOWN`.
    weight_n
        Shape (n, feet).
    """
    known = log.known
    rot, gravity = known["foot_rot_wt"], known["gravity_mps2"]
    specific = known["foot_acc_mps2"] / gravity[:, None, None]
    specific = specific + np.array([0.0, 0.0, 1.0])
    force = -np.einsum("nkji,nkj->nki", rot, specific) * weight_n[..., None]
    return np.concatenate([force, cross(known["foot_com_m"], force)], axis=-1)


def channel_contact(log: Log) -> FloatArray:
    """Contact of the foot that each channel belongs to, shape (n, c)."""
    scope = Scope.LEG if is_six_axis(log.channels) else Scope.FOOT
    contact = np.empty(log.readings.shape)
    for foot, columns in enumerate(columns_of(scope, log.channels)):
        contact[:, columns] = log.known["contact"][:, foot : foot + 1]
    return contact


def feet_of(log: Log) -> tuple[str, ...]:
    """Names of the feet, in the order of the known per-foot arrays."""
    scope = Scope.LEG if is_six_axis(log.channels) else Scope.FOOT
    return units_of(scope, log.channels)


class _Counted(TypedDict):
    """Errors without what is not a number, and which of them count, shape (n, k) each."""

    error: FloatArray
    valid: BoolArray


def _counted(log: Log, error: FloatArray, totals: int, carried: BoolArray) -> _Counted:
    """Totals count unless all feet are in the air, a channel while its foot surely swings."""
    valid = np.isfinite(error)
    if not valid.all():
        error = np.where(valid, error, 0.0)
    valid[:, :totals] &= (log.of_known(_standing) & carried)[:, None]
    valid[:, totals:] &= log.of_known(_in_the_air)
    return {"error": error, "valid": valid}


def _standing(log: Log) -> BoolArray:
    """Whether any foot is or may be on the ground, shape (n,)."""
    feet = [foot != 0.0 for foot in log.known["contact"].T]
    return np.asarray(np.logical_or.reduce(feet), dtype=bool)


def _in_the_air(log: Log) -> BoolArray:
    """Whether the foot of each channel surely swings, shape (n, c)."""
    return np.equal(channel_contact(log), 0.0)


OF_A_MODEL = Imperfection(
    COM_OFFSET, {"com_correction_x": 2e-3, "com_correction_y": 2e-3}, of_height=True
)
"""The CoM of a CAD model: half a millimetre on a robot whose CoM is 25 cm high."""
OF_THE_BODY = (
    Imperfection(ANGULAR_MOMENTUM, {"angmom_loss": 0.1}),
    Imperfection(LIMB_SWING, {"limb_swing_x": 0.2, "limb_swing_y": 0.2}, bounded=False),
    Imperfection(DELAY, {DELAY.size.name: 0.002}, covers=(LAG.name,)),
    Imperfection(ACCELERATION_DELAY, {ACCELERATION_DELAY.size.name: 0.005}),
    Imperfection(SMOOTHING, {"smoothing": 5e-4}, bounded=False),
    OF_A_MODEL,
)
"""What an ordinary state estimator gets wrong: light limbs left out of the angular momentum, stamps
that are off by milliseconds, differences over a window of some, a CAD model of the masses."""
OF_STEPS = (
    Imperfection(CHANGE_OF_FOOT, {p.name: 0.1 for p in CHANGE_OF_FOOT.sizes}),
    Imperfection(LEG_MASS, {"leg_mass": 0.01}),
    Imperfection(LEG_SWING, {p.name: p.prior_sd for p in LEG_SWING.sizes}, bounded=False),
    Imperfection(GAIT_MOMENT, {p.name: p.prior_sd for p in GAIT_MOMENT.sizes}, bounded=False),
)
"""Of feet that are swung, and of what carries the odometry from one to the other."""
OF_TRANSDUCERS = (
    Imperfection(SCALE_MATRIX, {p.name: 0.0025 for p in SCALE_MATRIX.sizes}),
    Imperfection(MOUNT_TRANSLATION, {p.name: 0.001 for p in MOUNT_TRANSLATION.sizes}),
)
"""Whose data sheets promise half a percent and which are screwed on within some millimetres."""

EXPERIMENT = Experiment(
    name="walk",
    known=KNOWN,
    balance=balance,
    calibration=(SCALE_BIAS.name,),
    imperfections=(
        *OF_THE_BODY,
        *OF_STEPS,
        Imperfection(PLATE_INERTIA, {"plate_mass": 0.1}, bounded=False),
    ),
)

ON_SIX_AXIS = replace(
    EXPERIMENT,
    known={**{k: v for k, v in KNOWN.items() if k != "cell_pos_m"}, **SIX_AXIS_KNOWN},
    calibration=(OFFSET.name,),
    imperfections=(
        *OF_THE_BODY,
        *OF_STEPS,
        *OF_TRANSDUCERS,
        Imperfection(FOOT_INERTIA, {p.name: p.prior_sd for p in FOOT_INERTIA.sizes}, bounded=False),
    ),
)
"""The same on feet with six-axis transducers."""
