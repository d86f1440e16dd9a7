"""What the hanging logs already know of a robot that now stands: one Gaussian per leg.

Offsets and weight go into the standing fit with their joint covariance. And because the whole
robot hung at once, the directions of gravity that two transducers felt differ by their relative
mounting: ``R_k u_kl = v_l`` for every leg k and log l, with the robot's attitude ``v_l`` unknown.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.hang.joint import HangFit
from footcal_cli.core.hang.model import HangModel
from footcal_cli.core.inference.linear import inverse_root
from footcal_cli.core.parameters import Estimates, FloatArray, IntArray, Status
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
    alike
        The legs by their number of logs; rows are in this order.
    """

    legs: tuple[LegKnowledge, ...]
    log_of: tuple[tuple[int, ...], ...]
    logs: int
    alike: tuple[_Alike, ...]

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
        rows = cls(legs, tuple(log_of), len(axes), _Alike.of(legs, log_of, len(axes)))
        return rows, np.array(axes).reshape(-1, 3)

    def aligned(self, geometry: Geometry, direction_b: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Rotations that bring the legs' felt directions together, and those directions.

        Alternates Wahba's problem per leg with the mean over legs; legs with fewer than two
        different directions stay nominal. Shapes (K, 3, 3) and (L, 3).
        """
        turn = np.broadcast_to(np.eye(3), (len(self.legs), 3, 3)).copy()
        for _ in range(_ALIGNING_ROUNDS if self.logs else 0):
            total = np.zeros_like(direction_b)
            for same in self.alike:
                felt = same.gravity_dir_t @ np.swapaxes(geometry.rot_bt[same.legs], 1, 2)
                seen = np.swapaxes(direction_b[same.log_of], 1, 2) @ felt
                left, size, right = np.linalg.svd(seen)
                left[..., 2] *= np.linalg.det(left @ right)[:, None]
                enough = size[:, 1, None, None] > _TWO_DIRECTIONS
                turn[same.legs] = np.where(enough, left @ right, turn[same.legs])
                turned = felt @ np.swapaxes(turn[same.legs], 1, 2)
                np.add.at(total, same.log_of.ravel(), turned.reshape(-1, 3))
            direction_b = total / np.linalg.norm(total, axis=1, keepdims=True)
        return turn, direction_b

    def rows(
        self, geometry: Geometry, mounting: Mounting, tangent: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Whitened residual (m,) and its derivative by all unknowns (m, 13K + 1 + 2L)."""
        count = len(self.legs)
        rot = mounting.turn_b @ geometry.rot_bt
        back = np.swapaxes(rot, -1, -2)[:, None]
        levers, leans = back @ skew(mounting.hang_dir_b), back @ tangent
        residuals, slopes = [], []
        for same in self.alike:
            chosen, basis = same.log_of, same.bases
            legs, logs = chosen.shape
            each = same.legs[:, None]
            felt = mounting.hang_dir_b[chosen] @ rot[same.legs]
            residual = np.empty((legs, 7 + 2 * logs))
            residual[:, :6] = mounting.offset[same.legs]
            residual[:, 6] = mounting.leg_weight_n[same.legs]
            residual[:, :7] -= same.known
            residual[:, 7:] = (basis @ felt[..., None]).reshape(legs, -1)
            slope = same.fixed.copy()
            turned = (basis @ levers[each, chosen]).reshape(legs, -1, 3)
            # The directions follow the mean turn of all legs (see `model.moved`).
            by_turn = slope[:, 7:, : 3 * count].reshape(legs, -1, count, 3)
            by_turn -= turned[:, :, None] / count
            by_turn[np.arange(legs), :, same.legs] += turned
            slope[:, 7:, : 3 * count] = by_turn.reshape(legs, -1, 3 * count)
            by_lean = np.zeros((legs, logs, 2, self.logs, 2))
            by_lean[np.arange(legs)[:, None], np.arange(logs), :, chosen] = (
                basis @ leans[each, chosen]
            )
            slope[:, 7:, slope.shape[2] - 2 * self.logs :] = by_lean.reshape(
                legs, 2 * logs, 2 * self.logs
            )
            residuals.append((same.whiten @ residual[..., None]).ravel())
            slopes.append((same.whiten @ slope).reshape(residual.size, -1))
        return np.concatenate(residuals), np.concatenate(slopes)


@dataclass(frozen=True)
class _Alike:
    """Legs that hung in equally many logs, L_k of them: their rows are made at once.

    Parameters
    ----------
    legs
        Their numbers, shape (a,).
    log_of
        As in `HangRows`, shape (a, L_k).
    known
        Offset and weight, shape (a, 7).
    gravity_dir_t
        As in `LegKnowledge`, shape (a, L_k, 3).
    whiten
        Inverse roots of the covariances, shape (a, 7 + 2 L_k, 7 + 2 L_k).
    bases
        Two axes across each direction, transposed, shape (a, L_k, 2, 3).
    fixed
        Derivative of offset and weight rows, shape (a, 7 + 2 L_k, 13K + 1 + 2L).
    """

    legs: IntArray
    log_of: IntArray
    known: FloatArray
    gravity_dir_t: FloatArray
    whiten: FloatArray
    bases: FloatArray
    fixed: FloatArray

    @classmethod
    def of(
        cls, legs: tuple[LegKnowledge, ...], log_of: Sequence[Sequence[int]], logs: int
    ) -> tuple[_Alike, ...]:
        """Legs by their number of logs, of which there are so many in all."""
        groups: dict[int, list[int]] = {}
        for k, chosen in enumerate(log_of):
            groups.setdefault(len(chosen), []).append(k)
        count, found = len(legs), []
        for many, own in groups.items():
            fixed = np.zeros((len(own), 7 + 2 * many, 13 * count + 1 + 2 * logs))
            for i, k in enumerate(own):
                fixed[i, :6, 6 * count + 6 * k : 6 * count + 6 * k + 6] = np.eye(6)
                fixed[i, 6, 12 * count + k] = 1.0
            felt = np.stack([legs[k].gravity_dir_t for k in own])
            found.append(
                cls(
                    np.array(own),
                    np.array([log_of[k] for k in own], dtype=np.int64).reshape(len(own), many),
                    np.array([[*legs[k].offset, legs[k].weight_n] for k in own]),
                    felt,
                    inverse_root(np.stack([legs[k].covariance for k in own])),
                    np.swapaxes(tangent_basis(felt), -1, -2),
                    fixed,
                )
            )
        return tuple(found)
