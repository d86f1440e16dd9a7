"""What the hanging logs already know of a robot that now stands: one Gaussian per leg.

Offsets and weight go into the standing fit with their joint covariance. And because the whole
robot hung at once, the directions of gravity that two transducers felt differ by their relative
mounting: ``R_k u_kl = v_l`` for every leg k and log l, with the robot's attitude ``v_l`` unknown.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.hang.joint import HangFit
from footcal_cli.core.hang.model import HangModel
from footcal_cli.core.inference.linear import inverse_root
from footcal_cli.core.parameters import Estimates, FloatArray, Status
from footcal_cli.core.pose.data import Geometry
from footcal_cli.core.pose.model import Mounting
from footcal_cli.core.spatial import skew, tangent_basis

_SAME_LOG = 0.95
_TWO_DIRECTIONS = 0.3
_ALIGNING_ROUNDS = 3


@dataclass(frozen=True)
class LegKnowledge:
    """Estimates of one leg that its hanging logs give.

    Parameters
    ----------
    offset
        Shape (6,).
    gravity_dir_t
        Direction of gravity per log in the true transducer frame, shape (L, 3).
    nominal_dir_t
        Nominal ones, shape (L, 3).
    covariance
        Of offset, weight, and the directions along `tangent_basis`, shape (7 + 2L, 7 + 2L).
    com_m
        Fourier coefficients of the leg's CoM, shape (3, 1 + 2 order).
    """

    offset: FloatArray
    weight_n: float
    gravity_dir_t: FloatArray
    nominal_dir_t: FloatArray
    covariance: FloatArray
    com_m: FloatArray

    def moved(self, sd: FloatArray) -> LegKnowledge:
        """The same with offsets that may have moved since, by an sd of shape (6,)."""
        covariance = self.covariance.copy()
        covariance[range(6), range(6)] += sd**2
        return replace(self, covariance=covariance)

    def without_directions(self) -> LegKnowledge:
        """The same without what the directions of gravity say."""
        none = np.zeros((0, 3))
        return replace(
            self, gravity_dir_t=none, nominal_dir_t=none, covariance=self.covariance[:7, :7]
        )


def leg_knowledge(fit: HangFit) -> LegKnowledge:
    """What a standing fit takes over from a hanging fit."""
    return knowledge_of(fit.model, fit.estimates)


def knowledge_of(model: HangModel, estimates: Estimates) -> LegKnowledge:
    """The same from stored estimates; `model` says how its parameters are laid out."""
    values = model.split(estimates.values)
    direction = model.gravity_dir_t(values.tilt)
    logs, tilts = direction.shape[0], values.tilt.size
    size = estimates.values.size
    carry = np.zeros((7 + 2 * logs, size))
    carry[np.arange(6), 1 + np.arange(6)] = 1.0
    carry[6, 0] = 1.0
    leans = np.swapaxes(tangent_basis(direction), -1, -2) @ model.gravity_jacobian(values.tilt)
    carry[7:, size - tilts :] = leans.reshape(2 * logs, tilts)
    return LegKnowledge(
        values.offset,
        values.weight_n,
        direction,
        model.nominal_dir_t,
        carry @ estimates.covariance @ carry.T,
        values.com_m,
    )


def stored_knowledge(
    leg: str,
    values: Mapping[str, float],
    covariance_of: Callable[[tuple[str, ...]], FloatArray],
    named_by_body: FloatArray | None = None,
) -> LegKnowledge:
    """Knowledge from stored parameters ``<leg>.<name>``, as `hang-calib` names them.

    Orientations whose names do not say a direction (``log_3``) contribute no direction.

    Parameters
    ----------
    named_by_body
        Nominal rotation transducer to body where the logs were named after the body's axes, (3, 3):
        a log is stored under the transducer's axis that is nearest, and that may be 30° away.

    Raises
    ------
    KeyError
        Where offset, weight or CoM are missing; names the parameter.
    """
    order = 0
    while f"{leg}.com_x_sin{order + 1 if order else ''}" in values:
        order += 1
    pattern = re.compile(rf"{re.escape(leg)}\.hang_tilt_(plus|minus)_([xyz])_[xyz]")
    labels = dict.fromkeys(m.groups() for name in values if (m := pattern.fullmatch(name)))
    axes = np.array(
        [(1.0 if sign == "plus" else -1.0) * np.eye(3)["xyz".index(a)] for sign, a in labels]
    ).reshape(-1, 3)
    if named_by_body is not None:
        axes = nearest_axis(axes @ named_by_body.T) @ named_by_body
    model = HangModel(
        leg,
        axes,
        order,
        temperature=f"{leg}.temperature_bias_fx" in values,
        drift=f"{leg}.offset_drift_fx" in values,
    )
    names = model.parameters(0.0).names
    stored = Estimates(
        names,
        ("",) * len(names),
        np.array([values[name] for name in names]),
        covariance_of(names),
        (Status.ESTIMATED,) * len(names),
    )
    return knowledge_of(model, stored)


def nearest_axis(direction: FloatArray) -> FloatArray:
    """The axis ±x, ±y or ±z that is nearest to each direction, shape (n, 3)."""
    largest = np.argmax(np.abs(direction), axis=1)
    sign = np.sign(np.take_along_axis(direction, largest[:, None], axis=1))
    return np.asarray(sign * np.eye(3)[largest])


@dataclass(frozen=True)
class HangRows:
    """Residual rows of all legs, ``L⁻¹ [o − ô; m g − m̂g; tangents of R_kᵀ v_l − u_kl]``.

    Parameters
    ----------
    log_of
        Which hanging direction of the robot each leg's log belongs to, per leg (L_k,).
    logs
        Number of distinct hanging logs.
    whiten
        Inverse roots of the covariances.
    bases
        Two axes across each direction, transposed, per leg (L_k, 2, 3).
    fixed
        Derivative of offset and weight rows, per leg (7 + 2 L_k, 13K + 1 + 2L).
    """

    legs: tuple[LegKnowledge, ...]
    log_of: tuple[tuple[int, ...], ...]
    logs: int
    whiten: tuple[FloatArray, ...]
    bases: tuple[FloatArray, ...]
    fixed: tuple[FloatArray, ...]

    @classmethod
    def of(cls, geometry: Geometry, legs: tuple[LegKnowledge, ...]) -> tuple[HangRows, FloatArray]:
        """Match the legs' logs by the body axis along gravity; also those axes, shape (L, 3)."""
        axes: list[FloatArray] = []
        log_of = []
        for rot, leg in zip(geometry.rot_bt, legs, strict=True):
            own = []
            for direction in leg.nominal_dir_t @ rot.T:
                same = [i for i, axis in enumerate(axes) if axis @ direction > _SAME_LOG]
                own.append(same[0] if same else len(axes))
                if not same:
                    axes.append(direction)
            log_of.append(tuple(own))
        whiten = tuple(inverse_root(leg.covariance) for leg in legs)
        directions = np.array(axes).reshape(-1, 3)
        bases = tuple(np.swapaxes(tangent_basis(leg.gravity_dir_t), -1, -2) for leg in legs)
        count, fixed = len(legs), []
        for k, chosen in enumerate(log_of):
            slope = np.zeros((7 + 2 * len(chosen), 13 * count + 1 + 2 * len(axes)))
            slope[:6, 6 * count + 6 * k : 6 * count + 6 * k + 6] = np.eye(6)
            slope[6, 12 * count + k] = 1.0
            fixed.append(slope)
        rows = cls(legs, tuple(log_of), len(axes), whiten, bases, tuple(fixed))
        return rows, directions

    def aligned(self, geometry: Geometry, direction_b: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Rotations that bring the legs' felt directions together, and those directions.

        Alternates Wahba's problem per leg with the mean over legs; legs with fewer than two
        different directions stay nominal. Shapes (K, 3, 3) and (L, 3).
        """
        turn = np.broadcast_to(np.eye(3), (len(self.legs), 3, 3)).copy()
        felt = [
            leg.gravity_dir_t @ rot.T for leg, rot in zip(self.legs, geometry.rot_bt, strict=True)
        ]
        for _ in range(_ALIGNING_ROUNDS if self.logs else 0):
            total = np.zeros_like(direction_b)
            for k, own in enumerate(felt):
                chosen = list(self.log_of[k])
                left, size, right = np.linalg.svd(direction_b[chosen].T @ own)
                if size[1] > _TWO_DIRECTIONS:
                    flip = np.diag([1.0, 1.0, np.linalg.det(left @ right)])
                    turn[k] = left @ flip @ right
                np.add.at(total, chosen, own @ turn[k].T)
            direction_b = total / np.linalg.norm(total, axis=1, keepdims=True)
        return turn, direction_b

    def rows(
        self, geometry: Geometry, mounting: Mounting, tangent: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Whitened residual (m,) and its derivative by all unknowns (m, 13K + 1 + 2L)."""
        count = len(self.legs)
        rot = mounting.turn_b @ geometry.rot_bt
        levers = np.swapaxes(rot, -1, -2)[:, None] @ skew(mounting.hang_dir_b)[None]
        leans = np.swapaxes(rot, -1, -2)[:, None] @ tangent[None]
        residuals, slopes = [], []
        for k, leg in enumerate(self.legs):
            chosen = list(self.log_of[k])
            basis = self.bases[k]
            felt = mounting.hang_dir_b[chosen] @ rot[k]
            residual = np.empty(7 + 2 * len(chosen))
            residual[:6] = mounting.offset[k] - leg.offset
            residual[6] = mounting.leg_weight_n[k] - leg.weight_n
            residual[7:] = (basis @ felt[..., None])[..., 0].ravel()
            slope = self.fixed[k].copy()
            turned = (basis @ levers[k, chosen]).reshape(-1, 3)
            # The directions follow the mean turn of all legs (see `model.moved`).
            slope[7:, : 3 * count].reshape(-1, count, 3)[:] = -turned[:, None] / count
            slope[7:, 3 * k : 3 * k + 3] += turned
            leaning = slope[7:, slope.shape[1] - 2 * self.logs :]
            leaning = leaning.reshape(len(chosen), 2, self.logs, 2)
            leaning[range(len(chosen)), :, chosen] = basis @ leans[k, chosen]
            residuals.append(self.whiten[k] @ residual)
            slopes.append(self.whiten[k] @ slope)
        return np.concatenate(residuals), np.concatenate(slopes)
