"""A robot on legs with hip transducers that hangs and stands, by its own few lines of physics."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from footcal_cli.core.parameters import FloatArray

GRAVITY_MPS2 = 9.80665
AXES = ("fx_n", "fy_n", "fz_n", "tx_nm", "ty_nm", "tz_nm")
LEGS = ("fl", "hl", "fr", "hr")
HIPS_M = np.array([[0.22, 0.14, 0.0], [-0.22, 0.14, 0.0], [0.22, -0.14, 0.0], [-0.22, -0.14, 0.0]])
_SHAFT_M = np.array([[0.0, 0.03, 0.0], [0.06, 0.0, 0.0], [0.0, 0.0, -0.06]])
"""CoM of a leg on its shaft along y: mean, and what sine and cosine of its angle move it by."""
_NOISE = np.array([0.02] * 3 + [0.002] * 3)


@dataclass(frozen=True)
class Robot:
    """Four legs on hips that are not where the recipe says, nor turned as it says.

    Parameters
    ----------
    rpy_rad
        Nominal mounting of each transducer, shape (4, 3).
    turn_rad, shift_m
        Mounting errors along the nominal transducer's axes and the body's, shape (4, 3).
    offset
        Shape (4, 6).
    """

    rng: np.random.Generator
    rpy_rad: FloatArray
    turn_rad: FloatArray
    shift_m: FloatArray
    offset: FloatArray
    mass_kg: float = 12.0
    leg_kg: float = 1.4

    @classmethod
    def drawn(cls, seed: int, rpy_rad: FloatArray) -> Robot:
        """Errors of a degree and of 3 mm, by seed."""
        rng = np.random.default_rng(seed)
        offset = rng.normal(0.0, [3.0] * 3 + [0.2] * 3, (4, 6))
        turn, shift = rng.normal(0.0, 0.0175, (4, 3)), rng.normal(0.0, 0.003, (4, 3))
        return cls(rng, rpy_rad, turn, shift, offset)

    @property
    def nominal(self) -> FloatArray:
        """Transducer to body as the recipe says, shape (4, 3, 3)."""
        return np.asarray(Rotation.from_euler("xyz", self.rpy_rad).as_matrix())

    @property
    def rot_bt(self) -> FloatArray:
        """As it is."""
        return np.asarray(self.nominal @ Rotation.from_rotvec(self.turn_rad).as_matrix())

    @property
    def truth(self) -> dict[str, float]:
        """As ``parameters.json`` names it."""
        nominal = self.nominal
        found = {"robot.weight": self.mass_kg * GRAVITY_MPS2}
        for k, leg in enumerate(LEGS):
            found[f"{leg}.weight"] = self.leg_kg * GRAVITY_MPS2
            moved = nominal[k].T @ self.shift_m[k]
            for i, axis in enumerate("xyz"):
                found[f"{leg}.mount_rot_{axis}"] = self.turn_rad[k, i]
                found[f"{leg}.mount_pos_{axis}"] = moved[i]
            for i, axis in enumerate(AXES):
                found[f"{leg}.offset_{axis.split('_')[0]}"] = self.offset[k, i]
        return {name: float(value) for name, value in found.items()}

    def recipe(self, to: Path) -> Path:
        """Write it."""
        legs = "".join(
            f"[robot.legs.{leg}]\nposition_m = {list(hip)}\nrotation_rpy_rad = {list(rpy)}\n"
            for leg, hip, rpy in zip(LEGS, HIPS_M.tolist(), self.rpy_rad.tolist(), strict=True)
        )
        to.write_text(
            f"[robot]\nname = 'by hand'\nmass_kg = {self.mass_kg}\n{legs}[hang_calib]\n"
            "orientation_of = 'body'\n[pose_calib]\nchassis_com_m = [0.0, 0.0, 0.0]\n"
        )
        return to

    def hanging(self, to: Path) -> Path:
        """Four times by an axis of the body, the shafts turning slowly; write the log."""
        parts = []
        time_s = np.arange(200) / 10.0
        for name, axis in (("+x", 0), ("-x", 0), ("+z", 2), ("-z", 2)):
            down = np.eye(3)[axis] * (1.0 if name[0] == "+" else -1.0)
            down = Rotation.from_rotvec(self.rng.normal(0.0, 0.01, 3)).apply(down)
            for k, leg in enumerate(LEGS):
                rate = 2.0 * np.pi * 2.0 / 20.0
                phase = rate * time_s + k
                com = self._leg_com_m(phase)
                still = self.leg_kg * GRAVITY_MPS2 * (self.rot_bt[k].T @ down)
                force = still + self.leg_kg * rate**2 * (com - _SHAFT_M[0])
                wrench = np.concatenate([force, np.cross(com, force)], axis=1)
                parts.append(self._table(wrench, k, {"orientation": name, "time_s": time_s,
                                                     "leg": leg, "phase_rad": phase}))  # fmt: skip
        pd.concat(parts).to_csv(to, index=False)
        return to

    def standing(self, to: Path, poses: int, tilt_rad: float = 0.12) -> Path:
        """Poses with forces on the feet that balance and squeeze; write the log."""
        parts = []
        for pose in range(poses):
            tilt = self.rng.uniform(-tilt_rad, tilt_rad, 2)
            rot_wb = Rotation.from_euler("zyx", [self.rng.uniform(-3, 3), *tilt])
            down = rot_wb.inv().apply([0.0, 0.0, -1.0])
            phase = self.rng.uniform(-0.6, 0.6, 4)
            hips, com = HIPS_M + self.shift_m, self._leg_com_m(phase)
            own = self.leg_kg * GRAVITY_MPS2 * down
            at = hips + np.einsum("kij,kj->ki", self.rot_bt, com)
            lever = self.leg_kg / self.mass_kg * at.sum(axis=0)  # the chassis' CoM is the origin
            feet = HIPS_M + self.rng.normal(0.0, 0.03, (4, 3)) + [0.0, 0.0, -0.2]
            feet[:, 1] *= 1.6
            ground = self._on_feet(feet - lever, down)
            force = np.einsum("kji,kj->ki", self.rot_bt, ground + own)
            torque = np.cross(at - hips, own) + np.cross(feet - hips, ground)
            torque = np.einsum("kji,kj->ki", self.rot_bt, torque)
            for k, leg in enumerate(LEGS):
                known = {"pose": [pose], "leg": leg, "phase_rad": phase[k], "contact": 1}
                known |= dict(zip([f"body_q{a}" for a in "xyzw"], rot_wb.as_quat(), strict=True))
                parts.append(self._table(np.concatenate([force[k], torque[k]])[None], k, known))
        pd.concat(parts).to_csv(to, index=False)
        return to

    def _on_feet(self, feet_m: FloatArray, down: FloatArray) -> FloatArray:
        """Forces of the ground that hold the robot, shape (4, 3)."""
        turning = np.concatenate([np.cross(f, np.eye(3)).T for f in feet_m], axis=1)
        both = np.concatenate([np.tile(np.eye(3), 4), turning])
        least = np.linalg.pinv(both)
        wanted = np.concatenate([-self.mass_kg * GRAVITY_MPS2 * down, np.zeros(3)])
        squeeze = (np.eye(12) - least @ both) @ self.rng.normal(0.0, 4.0, 12)
        return np.asarray((least @ wanted + squeeze).reshape(4, 3))

    def _leg_com_m(self, phase_rad: FloatArray) -> FloatArray:
        columns = np.stack([np.ones_like(phase_rad), np.sin(phase_rad), np.cos(phase_rad)], axis=1)
        return np.asarray(columns @ _SHAFT_M)

    def _table(self, wrench: FloatArray, leg: int, known: dict[str, object]) -> pd.DataFrame:
        read = wrench + self.offset[leg] + self.rng.normal(0.0, _NOISE, wrench.shape)
        return pd.DataFrame({**known, **dict(zip(AXES, read.T, strict=True))})
