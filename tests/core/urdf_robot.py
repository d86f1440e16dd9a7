"""The biped of `sample_data/physics` as a URDF, and its motion as MuJoCo knows it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco  # type: ignore[import-untyped, unused-ignore]
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tests.conftest import REPOSITORY

Array = NDArray[np.float64]
_H = 1e-4


def biped() -> Any:
    return mujoco.MjModel.from_xml_path(str(REPOSITORY / "sample_data" / "physics" / "biped.xml"))


def joint_names(model: Any) -> list[str]:
    return [str(model.joint(i).name) for i in range(1, model.njnt)]


def urdf_of(model: Any) -> str:
    """Every body a link, several joints of one body a chain of links without mass."""
    parts = ['<robot name="biped">']
    for b in range(1, model.nbody):
        name = model.body(b).name
        turned = Rotation.from_quat(np.roll(model.body_iquat[b], -1)).as_matrix()
        inertia = turned @ np.diag(model.body_inertia[b]) @ turned.T
        parts.append(
            f'<link name="{name}"><inertial><origin xyz="{_text(model.body_ipos[b])}"/>'
            f'<mass value="{model.body_mass[b]!r}"/><inertia '
            + " ".join(
                f'i{"xyz"[i]}{"xyz"[j]}="{inertia[i, j]!r}"' for i in range(3) for j in range(i, 3)
            )
            + '/></inertial><visual><geometry><mesh filename="package://none/lost.stl"/>'
            "</geometry></visual></link>"
        )
        joints = [j for j in range(1, model.njnt) if model.jnt_bodyid[j] == b]
        parent = model.body(model.body_parentid[b]).name
        for j in joints:
            last = j == joints[-1]
            child = name if last else f"{model.joint(j).name}_link"
            if not last:
                parts.append(f'<link name="{child}"/>')
            place = model.body_pos[b] if j == joints[0] else np.zeros(3)
            parts.append(
                f'<joint name="{model.joint(j).name}" type="revolute"><parent link="{parent}"/>'
                f'<child link="{child}"/><origin xyz="{_text(place)}"/>'
                f'<axis xyz="{_text(model.jnt_axis[j])}"/>'
                '<limit lower="-3" upper="3" effort="1" velocity="1"/></joint>'
            )
            parent = child
    for foot in ("left", "right"):
        site = model.site(f"{foot}_sole")
        parts.append(
            f'<link name="{foot}_sole"/><joint name="{foot}_sole_joint" type="fixed">'
            f'<parent link="{foot}_foot"/><child link="{foot}_sole"/>'
            f'<origin xyz="{_text(site.pos)}"/></joint>'
        )
    return "\n".join([*parts, "</robot>"]).replace("np.float64(", "").replace(")", "")


def _text(vector: Array) -> str:
    return " ".join(repr(float(v)) for v in vector)


def write_urdf(folder: Path, text: str | None = None) -> Path:
    path = folder / "robot.urdf"
    path.write_text(urdf_of(biped()) if text is None else text, encoding="utf-8")
    return path


def posture_at(t: float) -> Array:
    """A smooth gait-like motion, qpos (19,): every joint and the base move and turn."""
    q = np.zeros(19)
    q[:3] = [0.05 * t + 0.01 * np.sin(5 * t), 0.02 * np.sin(4 * t), 0.27 + 0.005 * np.sin(9 * t)]
    rpy = [0.05 * np.sin(4 * t + 1), 0.06 * np.sin(7 * t), 0.2 * np.sin(1.5 * t)]
    q[3:7] = np.roll(Rotation.from_euler("xyz", rpy).as_quat(), 1)
    k = np.arange(12)
    q[7:] = 0.25 * np.sin((2.5 + 0.4 * k) * t + k) + 0.05 * np.sin(12.0 * t + 2 * k)
    return q


class Truth:
    """CoM and angular momentum of the motion, differentiated in steps of 0.1 ms."""

    def __init__(self) -> None:
        self.model = biped()
        self.data = mujoco.MjData(self.model)

    def _at(self, t: float) -> tuple[Array, Array]:
        velocity = np.zeros(self.model.nv)
        mujoco.mj_differentiatePos(
            self.model, velocity, 2 * _H, posture_at(t - _H), posture_at(t + _H)
        )
        self.data.qpos[:], self.data.qvel[:] = posture_at(t), velocity
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)
        mujoco.mj_comVel(self.model, self.data)
        mujoco.mj_subtreeVel(self.model, self.data)
        return (
            np.array(self.data.subtree_com[0]),
            np.array(self.data.subtree_angmom[0]),
        )

    def com(self, time_s: Array) -> Array:
        return np.array([self._at(t)[0] for t in time_s])

    def com_acc(self, time_s: Array) -> Array:
        step = 1e-3
        before, now, after = (self.com(time_s + d) for d in (-step, 0.0, step))
        return np.asarray((before - 2 * now + after) / step**2)

    def angmom_rate(self, time_s: Array) -> Array:
        step = 5e-4
        return np.array(
            [(self._at(t + step)[1] - self._at(t - step)[1]) / (2 * step) for t in time_s]
        )

    def soles(self, time_s: Array) -> Array:
        """Positions (n, 2, 3) of left and right sole."""
        found = []
        for t in time_s:
            self._at(t)
            found.append([np.array(self.data.site(f"{f}_sole").xpos) for f in ("left", "right")])
        return np.array(found)
