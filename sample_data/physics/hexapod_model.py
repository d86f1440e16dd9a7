"""A BigAnt-like hexapod with a six-axis transducer at each hip, for MuJoCo.

Source: [Wu] (in-situ calibration of six-axis transducers on BigAnt), sections I-A and II.
The engine, not the calibration model, decides every wrench; this file only says what is built.

Conventions
-----------
Body frame B: x forward, y left, z up, origin at the geometric centre of the chassis.
Transducer frame ft_k: origin at hip k.  Nominal axes are those of B on the left; legs on the
right are the same module turned by pi about z, so there x points back and y points right.
Mounting error: ``rot_bt = rot_error @ rot_nominal`` and ``pos = pos_nominal + offset``: the
transducer turns about its own hip, and both errors are stated in body axes.
Phase: shaft angle, 0 with the foot straight down; growing phase moves the foot backward in B on
both sides.  So the shaft turns about +y of the transducer on the left and about -y on the right.
Wrench ``[fx fy fz tx ty tz]``: applied by leg and ground on the transducer, torque about the
transducer origin, in the axes of the true (misplaced) transducer.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]

GRAVITY_MPS2 = 9.80665
TOTAL_MASS_KG = 8.18
LEGS = ("fl", "ml", "hl", "fr", "mr", "hr")
#: [Wu], Table II, last row.
LEG_WEIGHT_N = {"fl": 6.2, "ml": 6.2, "hl": 6.2, "fr": 6.4, "mr": 6.2, "hr": 6.1}
#: Nominal transducer origins in B (m): the design file.
NOMINAL_POS_M = {
    "fl": (0.22, 0.14, 0.0),
    "ml": (0.0, 0.16, 0.0),
    "hl": (-0.22, 0.14, 0.0),
    "fr": (0.22, -0.14, 0.0),
    "mr": (0.0, -0.16, 0.0),
    "hr": (-0.22, -0.14, 0.0),
}
#: Shaft and foot in the transducer frame; the foot is a rolling sphere on the crank (m).
SHAFT_POS_M = (0.0, 0.06, 0.02)
FOOT_ARM_M = 0.08
FOOT_OUTWARD_M = 0.03
FOOT_RADIUS_M = 0.08
#: Turning part of each leg (kg); the rest of the leg is bolted to the transducer.
CRANK_MASS_KG = 0.30
TIME_STEP_S = 0.001
#: The conventions in words, for truth files.
CONVENTIONS = {
    "body": "x forward, y left, z up, origin at the chassis centre",
    "body_q": "x y z w, body to world",
    "phase": "shaft angle, 0: foot straight down; grows as the foot moves backward, both sides",
    "wrench": "[fx fy fz tx ty tz] applied by leg and ground on the transducer, torque about its "
    "origin, axes of the true transducer; no offset, no noise",
    "mount": "R_bt = exp(mount_rotvec_b) nominal_rot_bt, p = nominal_pos_b + mount_offset_b",
    "com_t": "amplitude * sin(phase + lead) + centre, true transducer frame",
    "hang": "gravity in body axes = exp(tilt_rotvec_b) times the axis of the orientation",
    "ground": "wrench of the ground on the foot; z up, x along the heading, torque about "
    "reference_com_b_m, fixed in the body",
}


@dataclass(frozen=True)
class Leg:
    """One leg module as it was really built and mounted.

    Attributes
    ----------
    name
        One of `LEGS`.
    mass_kg
        Everything beyond the transducer: bolted part and crank.
    com_amplitude_m, com_angle_rad
        Circle that the leg's CoM runs on: its radius, and its lead on the foot at phase 0.
    com_centre_m
        Centre of that circle in the true transducer frame (x, y, z).
    mount_rotvec_rad, mount_offset_m
        Mounting error, in body axes.
    """

    name: str
    mass_kg: float
    com_amplitude_m: float
    com_angle_rad: float
    com_centre_m: tuple[float, float, float]
    mount_rotvec_rad: tuple[float, float, float]
    mount_offset_m: tuple[float, float, float]

    @property
    def turned(self) -> bool:
        """Whether the module is a right one, turned by pi about z."""
        return self.name.endswith("r")

    @property
    def rot_nominal(self) -> Array:
        """Nominal rotation, transducer to body, shape (3, 3)."""
        return np.diag([-1.0, -1.0, 1.0]) if self.turned else np.eye(3)

    @property
    def rot_bt(self) -> Array:
        """True rotation, transducer to body, shape (3, 3)."""
        error: Array = Rotation.from_rotvec(self.mount_rotvec_rad).as_matrix()
        return error @ self.rot_nominal

    @property
    def pos_b_m(self) -> Array:
        """True transducer origin in the body frame (m), shape (3,)."""
        return np.add(NOMINAL_POS_M[self.name], self.mount_offset_m)

    @property
    def sine_terms(self) -> dict[str, tuple[float, float, float]]:
        """``(A, C, D)`` (m, rad, m) of ``A sin(phase + C) + D`` per axis, true transducer frame.

        [Wu], Fig. 4: x and z follow a sine of the shaft angle and y is constant.
        """
        x, y, z = self.com_centre_m
        lead = self.com_angle_rad if self.turned else self.com_angle_rad + np.pi
        down = self.com_angle_rad - np.pi / 2
        amplitude = self.com_amplitude_m
        return {"x": (amplitude, lead, x), "y": (0.0, 0.0, y), "z": (amplitude, down, z)}

    def com_t_m(self, phase_rad: Array | float) -> Array:
        """CoM of the leg, ``r_k(phase)``, in the true transducer frame (m), shape (..., 3)."""
        phase = np.asarray(phase_rad, dtype=float)
        axes = [a * np.sin(phase + c) + d for a, c, d in self.sine_terms.values()]
        return np.stack(axes, axis=-1)

    def record(self) -> dict[str, Any]:
        """Truth of this leg, ready for JSON."""
        return {
            "mass_kg": self.mass_kg,
            "weight_n": self.mass_kg * GRAVITY_MPS2,
            "com_t": {
                axis: {"amplitude_m": a, "lead_rad": c, "centre_m": d}
                for axis, (a, c, d) in self.sine_terms.items()
            },
            "nominal_pos_b_m": NOMINAL_POS_M[self.name],
            "nominal_rot_bt": self.rot_nominal.tolist(),
            "mount_rotvec_b_rad": self.mount_rotvec_rad,
            "mount_offset_b_m": self.mount_offset_m,
        }


@dataclass(frozen=True)
class Hexapod:
    """The robot as built: six legs and a chassis; everything here is truth."""

    legs: tuple[Leg, ...]
    chassis_com_b_m: tuple[float, float, float]

    @property
    def chassis_mass_kg(self) -> float:
        """``M - sum m_k`` (kg)."""
        return TOTAL_MASS_KG - sum(leg.mass_kg for leg in self.legs)

    @property
    def reference_com_b_m(self) -> Array:
        """CoM of the whole robot in B with every foot straight down (m), shape (3,).

        Origin of the floating-base frame ([Wu], section I-A).
        """
        moment = self.chassis_mass_kg * np.asarray(self.chassis_com_b_m)
        for leg in self.legs:
            moment = moment + leg.mass_kg * (leg.pos_b_m + leg.rot_bt @ leg.com_t_m(0.0))
        com: Array = moment / TOTAL_MASS_KG
        return com

    def record(self) -> dict[str, Any]:
        """Truth of the robot and its legs, ready for JSON."""
        return {
            "robot": {
                "mass_kg": TOTAL_MASS_KG,
                "chassis_mass_kg": self.chassis_mass_kg,
                "chassis_com_b_m": self.chassis_com_b_m,
                "reference_com_b_m": self.reference_com_b_m.tolist(),
            },
            "legs": {leg.name: leg.record() for leg in self.legs},
        }


def draw_hexapod(
    seed: int, mount_rotation_sd_rad: float = 0.035, mount_offset_sd_m: float = 0.003
) -> Hexapod:
    """Draw a robot with build tolerances and mounting errors.

    Parameters
    ----------
    seed
        Same seed, same robot; the two spreads do not change which numbers are drawn.
    mount_rotation_sd_rad, mount_offset_sd_m
        Spread per axis of the mounting errors; 0 gives a perfectly mounted robot.
    """
    rng = np.random.default_rng([seed, 1])
    legs = []
    for name in LEGS:
        amplitude, angle = rng.normal(0.030, 0.001), rng.normal(0.25, 0.05)
        centre = rng.normal((0.004, 0.055, -0.004), 0.002)
        rotvec = mount_rotation_sd_rad * rng.standard_normal(3)
        offset = mount_offset_sd_m * rng.standard_normal(3)
        legs.append(
            Leg(
                name=name,
                mass_kg=LEG_WEIGHT_N[name] / GRAVITY_MPS2,
                com_amplitude_m=float(amplitude),
                com_angle_rad=float(angle),
                com_centre_m=_triple(centre),
                mount_rotvec_rad=_triple(rotvec),
                mount_offset_m=_triple(offset),
            )
        )
    chassis_com = rng.normal((0.035, -0.010, 0.015), 0.002)
    return Hexapod(legs=tuple(legs), chassis_com_b_m=_triple(chassis_com))


def mjcf(robot: Hexapod, *, floating: bool) -> str:
    """MJCF of the robot, free on a floor or with its chassis held fixed in the air.

    The transducer is a body without joint between chassis and leg; its site carries the force
    and torque sensors.  Joint damping is zero on purpose: MuJoCo integrates it implicitly and its
    sensors do not know, which would break the balance; the servo's velocity gain damps instead.
    Soft feet (2 to 3 N/mm) share the load between legs as the plates of BigAnt do.
    """
    root = '<freejoint name="root"/>' if floating else ""
    floor = '<geom name="floor" type="plane" size="0 0 1"/>' if floating else ""
    height = FOOT_ARM_M + FOOT_RADIUS_M - SHAFT_POS_M[2] if floating else 0.0
    legs = "\n".join(_leg_mjcf(leg) for leg in robot.legs)
    actuators = "\n".join(
        f'<position name="{n}_servo" joint="{n}_shaft" kp="60" kv="3"/>' for n in LEGS
    )
    sensors = "\n".join(f'<force site="{n}_ft"/><torque site="{n}_ft"/>' for n in LEGS)
    return f"""
<mujoco model="hexapod">
  <compiler angle="radian" autolimits="true"/>
  <option timestep="{TIME_STEP_S}" gravity="0 0 {-GRAVITY_MPS2}" integrator="Euler"
          cone="elliptic" impratio="3000" solver="Newton" iterations="50" tolerance="1e-12"/>
  <default>
    <geom contype="0" conaffinity="1" condim="4" friction="0.8 0.003 0"
          solref="0.12 0.4" solimp="0.5 0.5 0.001"/>
  </default>
  <worldbody>
    {floor}
    <body name="chassis" pos="0 0 {height}">
      {root}
      <inertial pos="{_text(robot.chassis_com_b_m)}" mass="{robot.chassis_mass_kg!r}"
                diaginertia="0.04 0.10 0.13"/>
{legs}
    </body>
  </worldbody>
  <actuator>{actuators}</actuator>
  <sensor>{sensors}</sensor>
</mujoco>"""


def _leg_mjcf(leg: Leg) -> str:
    """Transducer body with the bolted part of the leg, and the crank with its foot."""
    sign = -1.0 if leg.turned else 1.0
    shaft = np.asarray(SHAFT_POS_M)
    bolted_mass = leg.mass_kg - CRANK_MASS_KG
    bolted_com = (leg.mass_kg * np.asarray(leg.com_centre_m) - CRANK_MASS_KG * shaft) / bolted_mass
    radius = leg.com_amplitude_m * leg.mass_kg / CRANK_MASS_KG
    lead = leg.com_angle_rad
    crank_com = (-sign * radius * np.sin(lead), 0.0, -radius * np.cos(lead))
    quat = Rotation.from_matrix(leg.rot_bt).as_quat(scalar_first=True)
    return f"""
      <body name="{leg.name}_transducer" pos="{_text(leg.pos_b_m)}" quat="{_text(quat)}">
        <site name="{leg.name}_ft"/>
        <inertial pos="{_text(bolted_com)}" mass="{bolted_mass!r}" diaginertia="3e-4 3e-4 3e-4"/>
        <body name="{leg.name}_crank" pos="{_text(shaft)}">
          <joint name="{leg.name}_shaft" type="hinge" axis="0 {sign} 0" armature="0.02"/>
          <inertial pos="{_text(crank_com)}" mass="{CRANK_MASS_KG}" diaginertia="8e-4 8e-4 3e-4"/>
          <geom name="{leg.name}_foot" type="sphere" size="{FOOT_RADIUS_M}" contype="1"
                conaffinity="0" pos="0 {FOOT_OUTWARD_M} {-FOOT_ARM_M}"/>
        </body>
      </body>"""


def _text(values: Array | tuple[float, ...]) -> str:
    return " ".join(repr(float(value)) for value in values)


def _triple(values: Array) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in values)
    return x, y, z


@dataclass(frozen=True)
class Reading:
    """State of the robot at one instant; rows follow `LEGS`.

    Attributes
    ----------
    time_s
        Simulated time.
    phase_rad
        True shaft angles, shape (6,).
    wrench
        Applied wrench per transducer (N, Nm), shape (6, 6).
    quat_wb
        Body to world, x y z w, shape (4,).
    contact
        Whether the foot carries load from the ground, shape (6,).
    ground_wrench_w
        Wrench of the ground on each foot (N, Nm), shape (6, 6), in the floating-base frame:
        z up, x along the heading, torque about `Hexapod.reference_com_b_m`.
    """

    time_s: float
    phase_rad: Array
    wrench: Array
    quat_wb: Array
    contact: NDArray[np.bool_]
    ground_wrench_w: Array


class Rig:
    """The running engine: commands in, readings out.

    Parameters
    ----------
    robot
        What to build.
    gravity_dir_b
        Unit vector of gravity in the body frame.  When given, the chassis is held fixed and
        gravity is turned instead of the robot; when None the robot stands free on a floor.
    phase_rad, rate_radps
        Shaft angles and speeds at the start, shape (6,) or one for all.
    """

    def __init__(
        self,
        robot: Hexapod,
        gravity_dir_b: Array | None = None,
        phase_rad: Array | float = 0.0,
        rate_radps: float = 0.0,
    ) -> None:
        self.robot = robot
        self.model = mujoco.MjModel.from_xml_string(mjcf(robot, floating=gravity_dir_b is None))
        self.data = mujoco.MjData(self.model)
        if gravity_dir_b is not None:
            self.model.opt.gravity[:] = GRAVITY_MPS2 * gravity_dir_b
        joints = [self.model.joint(f"{leg}_shaft") for leg in LEGS]
        self._qpos = np.array([joint.qposadr[0] for joint in joints])
        self._dofs = np.array([joint.dofadr[0] for joint in joints])
        self._chassis = self.model.body("chassis").id
        self._foot = {self.model.geom(f"{leg}_foot").id: i for i, leg in enumerate(LEGS)}
        self.data.qpos[self._qpos] = phase_rad
        self.data.qvel[self._dofs] = rate_radps
        self.data.ctrl[:] = phase_rad

    def step(self, command_rad: Array) -> None:
        """Advance one time step with the servos asked to hold `command_rad`, shape (6,)."""
        self.data.ctrl[:] = command_rad
        mujoco.mj_step(self.model, self.data)

    @property
    def command(self) -> Array:
        """Shaft angles that the servos are asked to hold (rad), shape (6,)."""
        command: Array = self.data.ctrl.copy()
        return command

    def read(self, command_rad: Array) -> Reading:
        """Evaluate everything at the present instant, under the command of this instant.

        MuJoCo's force sensor reports parent on child, that is the transducer on the leg (checked
        on a hanging leg in the tests); the sign is flipped here.
        """
        self.data.ctrl[:] = command_rad
        mujoco.mj_forward(self.model, self.data)
        quat = self.data.xquat[self._chassis]
        ground = self._ground_wrench_w()
        return Reading(
            time_s=float(self.data.time),
            phase_rad=self.data.qpos[self._qpos].copy(),
            wrench=-self.data.sensordata.reshape(len(LEGS), 6),
            quat_wb=quat[[1, 2, 3, 0]].copy(),
            contact=ground[:, 2] > 0.0,
            ground_wrench_w=ground,
        )

    def _ground_wrench_w(self) -> Array:
        rot_wb = self.data.xmat[self._chassis].reshape(3, 3)
        origin = self.data.xpos[self._chassis] + rot_wb @ self.robot.reference_com_b_m
        heading = np.arctan2(rot_wb[1, 0], rot_wb[0, 0])
        to_floating = Rotation.from_euler("z", -heading).as_matrix()
        wrench = np.zeros((len(LEGS), 6))
        local = np.zeros(6)
        for index in range(self.data.ncon):
            contact = self.data.contact[index]
            mujoco.mj_contactForce(self.model, self.data, index, local)
            axes = contact.frame.reshape(3, 3).T
            force = axes @ local[:3]
            torque = axes @ local[3:] + np.cross(contact.pos - origin, force)
            row = wrench[self._foot[contact.geom[1]]]
            row[:3] += to_floating @ force
            row[3:] += to_floating @ torque
        return wrench
