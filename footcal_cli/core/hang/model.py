"""The wrench of a hanging leg, exact in the tilt, as coefficients of a few regressors.

``w = offset + [m (g u − r̈); r × m (g u − r̈)]`` with ``u = exp([s]) e``: e is the nominal direction
of gravity in the transducer frame and s the small turn between nominal and true of that log
([Wu], eqs. (4)-(7), with the full rotation instead of ``I + [s]``, and with the acceleration r̈
of a leg that turns). With ``r(φ) = Σ_h r_h z_h(φ)``, z = (1, sin φ, cos φ, sin 2φ …), the part of
gravity is linear in z, with coefficients that `hang.effect.HangResidual` reads off the residual.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from footcal_cli.core.effects.calibration import AXES, AXIS_UNITS, OFFSET
from footcal_cli.core.effects.cells import TEMPERATURE_BIAS
from footcal_cli.core.effects.six_axis import OFFSET_DRIFT
from footcal_cli.core.parameters import FloatArray, IntArray, Parameter, ParameterSet
from footcal_cli.core.spatial import left_jacobian, rotation_exp, skew, tangent_basis

WARMTH, DRIFT = TEMPERATURE_BIAS.name, OFFSET_DRIFT.name
"""Stems of the offsets' change per degC and per s, one per axis."""
Tilt = Literal["per_log", "mount", "none"]

_NEAR_AXIS = np.cos(np.deg2rad(30.0))
_WEIGHT_SD_N = 100.0
_OFFSET_SD = (1000.0, 1000.0, 1000.0, 100.0, 100.0, 100.0)
_COM_SD_M = 1.0
_PHASE_CONDITION = 1e-4
_BASE_SD_RAD = 0.02
"""A robot's base stands level to about a degree."""


@dataclass(frozen=True)
class HangModel:
    """Which terms a leg's hanging wrench has.

    Parameters
    ----------
    nominal_dir_t
        Nominal direction of gravity per log in the transducer frame, shape (L, 3).
    order
        Harmonics of the shaft angle in ``r(φ)``.
    tilt
        ``per_log``: every log hangs askew in its own way; ``mount``: one turn for all logs (a
        sensor on a wrist whose orientations are known but for its own mounting); ``none``.
    tilt_sd_rad
        Prior sd of each component of s.
    level_t
        Horizontal axes x and y of the world in which attitudes were measured, in the transducer
        frame, shape (L, 3, 2): that world's z need not be vertical. None: not known.
    temperature, drift
        Whether the six offsets follow temperature, and time.
    gravity_mps2
        Turns a weight into a mass.
    """

    leg: str
    nominal_dir_t: FloatArray
    order: int
    tilt: Tilt = "per_log"
    tilt_sd_rad: float = 0.2
    level_t: FloatArray | None = None
    temperature: bool = False
    drift: bool = False
    gravity_mps2: float = 9.80665

    @property
    def com_columns(self) -> int:
        """Regressors of ``r(φ)``: the mean, then sine and cosine of each harmonic."""
        return 1 + 2 * self.order

    def regressors(
        self, phase_rad: FloatArray, temperature_degc: FloatArray, time_s: FloatArray
    ) -> FloatArray:
        """The z of each sample, shape (n, d): 1, sin φ, cos φ, sin 2φ …, temperature, time."""
        rows = np.empty((self.regressor_count, phase_rad.size))
        return self.regressors_into(rows, phase_rad, temperature_degc, time_s)

    @property
    def regressor_count(self) -> int:
        """Number d of regressors."""
        return self.com_columns + self.temperature + self.drift

    def regressors_into(
        self,
        rows: FloatArray,
        phase_rad: FloatArray,
        temperature_degc: FloatArray,
        time_s: FloatArray,
    ) -> FloatArray:
        """The `regressors`, written into rows (d, n) of what others share."""
        _fourier_rows(phase_rad, rows[: self.com_columns])
        if self.temperature:
            rows[self.com_columns] = temperature_degc
        if self.drift:
            rows[-1] = time_s
        return rows.T

    def among(self, full: HangModel) -> IntArray:
        """Which regressors of a model with more harmonics are its own."""
        total = full.com_columns + self.temperature + self.drift
        return np.asarray(np.r_[: self.com_columns, full.com_columns : total], dtype=np.int64)

    def seen_order(self, grams: Sequence[FloatArray]) -> int:
        """Harmonics that the shaft angles can tell apart; 0 for a leg that does not turn.

        Parameters
        ----------
        grams
            ``zᵀ z`` of each log, shape (d, d).
        """
        columns = self.com_columns
        gram = np.sum([g[:columns, :columns] for g in grams], axis=0)
        for order in range(self.order, 0, -1):
            kept = 1 + 2 * order
            if np.linalg.eigvalsh(gram[:kept, :kept] / gram[0, 0])[0] > _PHASE_CONDITION:
                return order
        return 0

    @cached_property
    def tilt_design(self) -> FloatArray:
        """``ds/da``: turn of each log per tilt parameter, shape (L, 3, n_tilt)."""
        logs = self.nominal_dir_t.shape[0]
        if self.tilt == "none":
            return np.zeros((logs, 3, 0))
        if self.tilt == "mount":  # a sensor turned by R feels Rᵀ e
            return np.broadcast_to(-np.eye(3), (logs, 3, 3)).copy()
        design = np.zeros((logs, 3, logs, 2))
        each = np.arange(logs)
        design[each, :, each] = self.tilt_basis
        return design.reshape(logs, 3, 2 * logs)

    @cached_property
    def tilt_basis(self) -> FloatArray:
        """Two axes at right angles to each nominal direction, shape (L, 3, 2)."""
        basis = tangent_basis(self.nominal_dir_t)
        flip = np.sign(np.take_along_axis(basis, np.argmax(abs(basis), axis=1)[:, None], axis=1))
        return np.asarray(basis * flip)

    @property
    def base_design(self) -> FloatArray:
        """What one rad of the base's tilt adds to each nominal direction, shape (L, 3, 2 or 0)."""
        if self.tilt == "mount" and self.level_t is not None:
            return self.level_t
        return np.zeros((self.nominal_dir_t.shape[0], 3, 0))

    def tilt_names(self) -> tuple[str, ...]:
        """Names of the tilt parameters without the owner."""
        if self.tilt == "none":
            return ()
        if self.tilt == "mount":
            base = [f"base_tilt_{axis}" for axis in "xy"] if self.base_design.size else []
            return (*(f"mount_rot_{axis}" for axis in "xyz"), *base)
        names = []
        for label, basis in zip(self.log_labels(), self.tilt_basis, strict=True):
            axes = ["xyz"[i] for i in np.argmax(np.abs(basis), axis=0)]
            axes = axes if axes[0] != axes[1] else ["a", "b"]
            names += [f"hang_tilt_{label}_{axis}" for axis in axes]
        return tuple(names)

    def log_labels(self) -> tuple[str, ...]:
        """``plus_x`` for a log with +x along gravity, ``log_7`` where no axis says it uniquely."""
        axis = np.argmax(np.abs(self.nominal_dir_t), axis=1)
        along = np.take_along_axis(self.nominal_dir_t, axis[:, None], axis=1)[:, 0]
        labels = [
            f"{'plus' if a > 0 else 'minus'}_{'xyz'[i]}" for i, a in zip(axis, along, strict=True)
        ]
        if min(np.abs(along), default=1.0) < _NEAR_AXIS or len(set(labels)) < len(labels):
            return tuple(f"log_{i + 1}" for i in range(len(labels)))
        return tuple(labels)

    def com_names(self) -> tuple[str, ...]:
        """Names of the CoM coefficients, axis by axis."""
        harmonics = ["mean"]
        for h in range(1, self.order + 1):
            harmonics += [f"sin{h if h > 1 else ''}", f"cos{h if h > 1 else ''}"]
        return tuple(f"com_{axis}_{harmonic}" for axis in "xyz" for harmonic in harmonics)

    def parameters(self, weight_n: float) -> ParameterSet:
        """Weight, offsets, CoM, temperature, drift, tilt, with priors that say almost nothing.

        Parameters
        ----------
        weight_n
            Believed weight of the leg, kept where no orientation shows it.
        """
        rows: list[tuple[str, str, float]] = [("weight", "N", _WEIGHT_SD_N)]
        for suffix, unit, share in (
            (OFFSET.name, "", 1.0),
            (WARMTH, "/degC", 0.1 * self.temperature),
            (DRIFT, "/s", 0.01 * self.drift),
        ):
            if share > 0.0:
                rows += [
                    (f"{suffix}_{axis}", axis_unit + unit, share * sd)
                    for axis, axis_unit, sd in zip(AXES, AXIS_UNITS, _OFFSET_SD, strict=True)
                ]
        rows += [(name, "m", _COM_SD_M) for name in self.com_names()]
        rows += [
            (name, "rad", _BASE_SD_RAD if name.startswith("base") else self.tilt_sd_rad)
            for name in self.tilt_names()
        ]
        return ParameterSet(
            tuple(
                Parameter(f"{self.leg}.{name}", unit, 0.0 if i else weight_n, sd)
                for i, (name, unit, sd) in enumerate(rows)
            )
        )

    def split(self, theta: FloatArray) -> HangValues:
        """Name the pieces of a parameter vector, shape (n,)."""
        sizes = [1, 6, 6 * self.temperature, 6 * self.drift, 3 * self.com_columns]
        weight, offset, temperature, drift, com, tilt = np.split(theta, np.cumsum(sizes))
        return HangValues(
            weight_n=float(weight[0]),
            offset=offset,
            temperature_bias=temperature,
            offset_drift=drift,
            com_m=com.reshape(3, self.com_columns),
            tilt=tilt,
        )

    def join(self, values: HangValues) -> FloatArray:
        """The parameter vector of named pieces."""
        return np.concatenate(
            [
                [values.weight_n],
                values.offset,
                values.temperature_bias,
                values.offset_drift,
                values.com_m.ravel(),
                values.tilt,
            ]
        )

    def gravity_dir_t(self, tilt: FloatArray) -> FloatArray:
        """True direction of gravity per log, ``exp([s]) (e + B b) / |e + B b|``, shape (L, 3).

        Parameters
        ----------
        tilt
            What gives s, then the tilt b of the base, as `tilt_names` has them.
        """
        lean, turns = self.base_design, self.tilt_design.shape[2]
        down = self.nominal_dir_t + lean @ tilt[turns:]
        down = down / np.linalg.norm(down, axis=1, keepdims=True)
        turned = rotation_exp(self.tilt_design @ tilt[:turns]) @ down[..., None]
        return np.asarray(turned[..., 0])

    def gravity_jacobian(self, tilt: FloatArray) -> FloatArray:
        """Change of `gravity_dir_t` per tilt parameter, shape (L, 3, n_tilt)."""
        unit, lean, turns = self.gravity_dir_t(tilt), self.base_design, self.tilt_design.shape[2]
        turn = self.tilt_design @ tilt[:turns]
        moved = -skew(unit) @ left_jacobian(turn) @ self.tilt_design
        if not lean.size:
            return np.asarray(moved)
        size = np.linalg.norm(self.nominal_dir_t + lean @ tilt[turns:], axis=1)
        leaned = rotation_exp(turn) @ lean / size[:, None, None]
        across = leaned - unit[:, :, None] * np.einsum("li,lib->lb", unit, leaned)[:, None, :]
        return np.concatenate([moved, across], axis=2)

    def coefficient_jacobian(self, theta: FloatArray) -> FloatArray:
        """``dC/dθ`` of the residual ``w − z Cᵀ`` of a leg at rest, shape (L, 6, d, n)."""
        values = self.split(theta)
        unit = self.gravity_dir_t(values.tilt)
        logs, columns = unit.shape[0], self.com_columns
        table = np.zeros((logs, 6, columns + self.temperature + self.drift, theta.size))
        table[:, :3, 0, 0] = unit
        table[:, 3:, :columns, 0] = -skew(unit) @ values.com_m
        at = 1
        each = np.arange(6)
        for column, used in ((0, True), (columns, self.temperature), (-1, self.drift)):
            if used:
                table[:, each, column, at + each] = 1.0
                at += 6
        lever = np.broadcast_to(-skew(values.weight_n * unit)[:, :, None], (logs, 3, columns, 3))
        own = np.arange(columns)
        block = table[:, 3:, :columns, at : at + 3 * columns].reshape(logs, 3, columns, 3, columns)
        block[:, :, own, :, own] = np.moveaxis(lever, 2, 0)
        table[:, 3:, :columns, at : at + 3 * columns] = block.reshape(logs, 3, columns, -1)
        at += 3 * columns
        turn = values.weight_n * self.gravity_jacobian(values.tilt)
        table[:, :3, 0, at:] = turn
        table[:, 3:, :columns, at:] = np.einsum("cij,ljt->lict", skew(values.com_m.T), turn)
        return table


@dataclass(frozen=True)
class HangValues:
    """What a hanging leg is made of.

    Parameters
    ----------
    weight_n
        Weight of the leg, m g.
    offset
        Wrench that the transducer reads without load, shape (6,), N and Nm.
    temperature_bias, offset_drift
        Change of the offset per degC and per s, shape (6,), or empty.
    com_m
        Coefficients of ``r(φ)`` in the transducer frame, shape (3, 1 + 2 order), m.
    tilt
        How it hangs askew, as `HangModel.tilt_names` has it, rad.
    """

    weight_n: float
    offset: FloatArray
    temperature_bias: FloatArray
    offset_drift: FloatArray
    com_m: FloatArray
    tilt: FloatArray


def leg_com_t_m(com_m: FloatArray, phase_rad: FloatArray) -> FloatArray:
    """Leg CoM ``r(φ)`` from its Fourier coefficients (3, 1 + 2 order), shape (..., 3), m."""
    columns = fourier_columns(phase_rad, (com_m.shape[1] - 1) // 2)
    return np.asarray(np.stack(columns, axis=-1) @ com_m.T)


def leg_com_acc_t_mps2(
    com_m: FloatArray, phase_rad: FloatArray, speed: FloatArray, acceleration: FloatArray
) -> FloatArray:
    """``r̈ = r″(φ) φ̇² + r′(φ) φ̈`` of the leg CoM, shape (n, 3), m/s²."""
    order = (com_m.shape[1] - 1) // 2
    columns = fourier_columns(phase_rad, order)
    moved = [np.zeros_like(phase_rad)]
    for h in range(1, order + 1):
        sine, cosine = columns[2 * h - 1], columns[2 * h]
        moved += [
            h * cosine * acceleration - h**2 * sine * speed**2,
            -h * sine * acceleration - h**2 * cosine * speed**2,
        ]
    return np.asarray(np.stack(moved, axis=-1) @ com_m.T)


def fourier_columns(phase_rad: FloatArray, order: int) -> list[FloatArray]:
    """1, sin φ, cos φ, sin 2φ, cos 2φ … of shaft angles of any shape."""
    rows = np.empty((1 + 2 * order, phase_rad.size))
    _fourier_rows(phase_rad.ravel(), rows)
    return list(rows.reshape(-1, *phase_rad.shape))


def _fourier_rows(phase_rad: FloatArray, rows: FloatArray) -> None:
    """Fill rows with 1, sin φ, cos φ, sin 2φ, cos 2φ …, by the sums of angles."""
    rows[0] = 1.0
    if len(rows) == 1:
        return
    sine, cosine = np.sin(phase_rad, out=rows[1]), np.cos(phase_rad, out=rows[2])
    spare = np.empty_like(sine)
    for at in range(3, len(rows), 2):
        before_sine, before_cosine, next_sine, next_cosine = rows[at - 2 : at + 2]
        np.multiply(before_sine, cosine, out=next_sine)
        np.add(next_sine, np.multiply(before_cosine, sine, out=spare), out=next_sine)
        np.multiply(before_cosine, cosine, out=next_cosine)
        np.subtract(next_cosine, np.multiply(before_sine, sine, out=spare), out=next_cosine)
