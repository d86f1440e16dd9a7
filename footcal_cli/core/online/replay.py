"""Forces and centres of pressure of a walk by a calibration, and their errors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footcal_cli.core.centroidal import MIN_FORCE_N, Pressure, Reference, pressure
from footcal_cli.core.effects.contract import Scope, columns_of
from footcal_cli.core.log import Log
from footcal_cli.core.online.belief import Belief
from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray


@dataclass(frozen=True)
class Replayed:
    """Forces and CoP of one method, sample by sample.

    Parameters
    ----------
    method
        ``before window static memory smoother``.
    gain, bias_n
        In force at each sample, momentary errors included, shape (n, c).
    forces_n
        Corrected, shape (n, c).
    total, feet
        Vertical force and CoP of the robot and of each foot.
    """

    method: str
    gain: FloatArray
    bias_n: FloatArray
    forces_n: FloatArray
    total: Pressure
    feet: tuple[Pressure, ...]


def held_until_next(last_sample: IntArray, values: FloatArray, n: int) -> FloatArray:
    """Values of updates held until the next one, per sample; 0 (the belief) before the first.

    Parameters
    ----------
    last_sample
        Sample after which each update is known, shape (u,).
    values
        Shape (u, k).
    """
    update = np.searchsorted(last_sample, np.arange(n), side="right") - 1
    return np.where((update >= 0)[:, None], values[np.maximum(update, 0)], 0.0)


def corrected(
    method: str,
    log: Log,
    belief: Belief,
    gain: FloatArray,
    bias_n: FloatArray,
    below_n: FloatArray | None = None,
    min_force_n: float = MIN_FORCE_N,
) -> Replayed:
    """Forces and CoP with given gains and biases, ``F = (1 + γ) F⁰ + β`` and the plate taken off.

    Parameters
    ----------
    gain, bias_n
        Shape (n, c).
    below_n
        What each cell feels less than the ground does, shape (n, c).
    """
    forces = (1.0 + gain) * belief.forces(log.readings) + bias_n
    feet = columns_of(Scope.FOOT, log.channels)
    if below_n is not None:
        forces = forces + below_n
    points = log.known["cell_pos_m"]
    finite = np.asarray(np.isfinite(forces).all(axis=1))
    total = _absent(pressure(np.nan_to_num(forces), points, min_force_n), finite)
    single = tuple(
        _absent(
            pressure(np.nan_to_num(forces[:, columns]), points[:, columns], min_force_n),
            finite & (log.known["contact"][:, foot] == 1.0),
        )
        for foot, columns in enumerate(feet)
    )
    return Replayed(method, gain, bias_n, forces, total, single)


def _absent(found: Pressure, usable: BoolArray) -> Pressure:
    """The pressure with samples that are not usable absent, never zero."""
    valid = found.valid & usable & np.isfinite(found.cop_m).all(axis=1)
    return Pressure(
        np.where(usable, found.fz_n, np.nan), np.where(valid[:, None], found.cop_m, np.nan), valid
    )


@dataclass(frozen=True)
class Errors:
    """Errors of one method against a reference, per sample; NaN where either is absent.

    Parameters
    ----------
    cop_m
        Shape (n, 2).
    vgrf_n
        Shape (n,).
    foot_cop_m
        Shape (n, feet, 2).
    """

    cop_m: FloatArray
    vgrf_n: FloatArray
    foot_cop_m: FloatArray


def errors_against(ours: Replayed, truth: Replayed | Reference) -> Errors:
    """A calibration minus the reference: another one, the truth, or what the motion demands."""
    n, feet = ours.forces_n.shape[0], len(ours.feet)
    if isinstance(truth, Reference):
        per_foot = np.full((n, feet, 2), np.nan)
        return Errors(ours.total.cop_m - truth.cop_m, ours.total.fz_n - truth.fz_n, per_foot)
    per_foot = np.stack(
        [a.cop_m - b.cop_m for a, b in zip(ours.feet, truth.feet, strict=True)], axis=1
    )
    return Errors(
        ours.total.cop_m - truth.total.cop_m, ours.total.fz_n - truth.total.fz_n, per_foot
    )
