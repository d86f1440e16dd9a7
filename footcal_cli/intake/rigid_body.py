"""Rigid-body kinematics of a URDF: the only module that knows Pinocchio.

Carpentier et al., The Pinocchio C++ library, IEEE/SICE SII 2019. Meshes are never opened.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from footcal_cli.core.kinematics import Posture
from footcal_cli.core.parameters import FloatArray
from footcal_cli.errors import DataError, UsageError, missing_library, nearest
from footcal_cli.tables.textfiles import read_text

INSTALL = "pip install 'pin>=3.1'"
_LARGEST_URDF_BYTES = 64 * 2**20
_UNITS = {"revolute": "rad", "continuous": "rad", "prismatic": "m"}


@dataclass(frozen=True)
class Mimic:
    """A joint that follows another: ``q = multiplier · q_of + offset``."""

    of: str
    multiplier: float
    offset: float


@dataclass(frozen=True)
class RigidBody:
    """A robot whose base moves freely.

    Parameters
    ----------
    model
        Pinocchio's.
    units
        Joint -> ``rad`` or ``m``, in the model's order.
    mimics
        Joints that follow others.
    mass_kg
        Of all links.
    """

    model: Any
    units: Mapping[str, str]
    mimics: Mapping[str, Mimic]
    mass_kg: float

    @property
    def frames(self) -> tuple[str, ...]:
        """Names of links and joints that a foot can be."""
        return tuple(str(frame.name) for frame in self.model.frames)

    def require_frame(self, name: str) -> str:
        """The name, if the model has it.

        Raises
        ------
        UsageError
            It has not.
        """
        if name not in self.frames:
            raise UsageError(
                f"the URDF has no link '{name}'{nearest(name, self.frames)}",
                remedy='name the link of each foot: [kinematics.feet] left = "l_sole"',
            )
        return name

    def followed(self, positions: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
        """Positions of all joints, those that follow others filled in.

        Raises
        ------
        UsageError
            A joint has no position.
        """
        known = dict(positions)
        for _ in self.mimics:  # one may follow another that follows
            for name, mimic in self.mimics.items():
                if name not in known and mimic.of in known:
                    known[name] = mimic.multiplier * known[mimic.of] + mimic.offset
        missing = [name for name in self.units if name not in known]
        if missing:
            raise UsageError(
                f"{len(missing)} of {len(self.units)} joints have no position: "
                + ", ".join(missing[:6]) + (" …" if len(missing) > 6 else ""),
                remedy="map their columns in [kinematics.joints], or say where they stand in "
                "[kinematics.fixed] (joint = value in rad or m)",
            )  # fmt: skip
        return known

    def posture(
        self,
        time_s: FloatArray,
        base_m: FloatArray,
        base_quaternion: FloatArray,
        positions: Mapping[str, FloatArray],
        feet: Sequence[str],
    ) -> Posture:
        """CoM, angular momentum and foot poses along a motion.

        The velocity between two rows is the constant twist that leads from one to the next, and the
        momentum is that of the posture half-way.

        Parameters
        ----------
        time_s
            Increasing stamps, shape (n,).
        base_m, base_quaternion
            Shape (n, 3) and, x y z w of unit length, (n, 4); NaN where lost.
        positions
            Joint -> rad or m, shape (n,), all joints.
        """
        pin = _pinocchio()
        model, data = self.model, self.model.createData()
        q = self._configurations(base_m, base_quaternion, positions)
        n, whole = len(q), np.asarray(np.isfinite(q).all(axis=1))
        frames = [model.getFrameId(name) for name in feet]
        com, momentum = np.full((n, 3), np.nan), np.full((max(n - 1, 0), 3), np.nan)
        feet_m, turned = np.full((n, len(feet), 3), np.nan), np.full((n, len(feet), 4), np.nan)
        for k in range(n):
            if not whole[k]:
                continue
            com[k] = pin.centerOfMass(model, data, q[k])
            pin.updateFramePlacements(model, data)
            for i, frame in enumerate(frames):
                pose = data.oMf[frame]
                feet_m[k, i] = pose.translation
                turned[k, i] = pin.Quaternion(pose.rotation).coeffs()
            if k and whole[k - 1]:
                velocity = pin.difference(model, q[k - 1], q[k]) / (time_s[k] - time_s[k - 1])
                half_way = pin.interpolate(model, q[k - 1], q[k], 0.5)
                hg = pin.computeCentroidalMomentum(model, data, half_way, velocity)
                momentum[k - 1] = hg.angular
        return Posture(com, momentum, feet_m, turned)

    def _configurations(
        self, base_m: FloatArray, base_quaternion: FloatArray, positions: Mapping[str, FloatArray]
    ) -> FloatArray:
        """Pinocchio's q of every row, shape (n, nq)."""
        q = np.empty((len(base_m), self.model.nq))
        q[:, :3], q[:, 3:7] = base_m, base_quaternion
        for name in self.units:
            joint = self.model.getJointId(name)
            at, width = self.model.idx_qs[joint], self.model.nqs[joint]
            if width == 2:  # a continuous joint is a point on the unit circle
                q[:, at], q[:, at + 1] = np.cos(positions[name]), np.sin(positions[name])
            else:
                q[:, at] = positions[name]
        return q


def read_urdf(path: Path) -> RigidBody:
    """Read a robot.

    Raises
    ------
    UsageError
        Pinocchio is not installed, or there is no such file.
    DataError
        The file is no URDF of a robot with mass, or a joint is floating or planar.
    """
    pin = _pinocchio()
    text = read_text(path, at_most=_LARGEST_URDF_BYTES)
    try:
        root = ElementTree.fromstring(text)
    except (ElementTree.ParseError, ValueError) as error:
        raise DataError(
            f"not a URDF: {error}", file=path, remedy="expand a xacro first: xacro in.xacro > out"
        ) from None
    units: dict[str, str] = {}
    mimics: dict[str, Mimic] = {}
    for joint in root.findall("joint"):
        name, kind = joint.get("name", ""), joint.get("type", "")
        if kind == "fixed":
            continue
        if kind not in _UNITS:
            raise DataError(
                f"joint '{name}' is {kind}; only revolute, continuous, prismatic and fixed ones "
                "are known", file=path,
                remedy="let the base link be the root of the URDF: it moves freely anyway",
            )  # fmt: skip
        units[name] = _UNITS[kind]
        follows = joint.find("mimic")
        if follows is not None:
            mimics[name] = Mimic(
                follows.get("joint", ""),
                float(follows.get("multiplier", 1.0)),
                float(follows.get("offset", 0.0)),
            )
    try:
        model = pin.buildModelFromXML(text, pin.JointModelFreeFlyer())
    except (ValueError, RuntimeError) as error:
        raise DataError(
            f"not a URDF of one robot: {error}", file=path, remedy="check it with check_urdf"
        ) from None
    mass = float(pin.computeTotalMass(model))
    if not mass > 0:
        raise DataError("no link has a mass", file=path, remedy="give links <inertial>")
    ordered = {str(name): units[str(name)] for name in model.names if str(name) in units}
    return RigidBody(model, ordered, mimics, mass)


def _pinocchio() -> Any:
    try:
        import pinocchio
    except ImportError as error:
        raise missing_library(
            "pinocchio", error, "kinematics needs Pinocchio, which is not installed", INSTALL
        ) from None
    return pinocchio
