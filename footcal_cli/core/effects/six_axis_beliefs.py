"""What is believed of a legged robot's weights, leg CoMs and attitude, and how far it is off.

truth = believed + correction, or truth = rotation of what is believed.
"""

from __future__ import annotations

import numpy as np

from footcal_cli.core.effects.contract import (
    Effect,
    EffectParameter,
    Scope,
    Stage,
    State,
    Theta,
    Trait,
    on_known,
    plus,
)
from footcal_cli.core.effects.six_axis import leg_phase
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray

HANGINGS = {"px": (1, 0, 0), "mx": (-1, 0, 0), "pz": (0, 0, 1), "mz": (0, 0, -1)}
"""Transducer axis along gravity: +x, −x, +z, −z (Wu & Revzen, section III-A)."""
TILTS = tuple(f"tilt_{name}_{axis}" for name in HANGINGS for axis in "xyz" if axis != name[1])
"""Small rotations of each hanging about the two transducer axes across gravity."""


def _leg_weight(log: Log, theta: Theta) -> FloatArray:
    correction = theta["weight_correction"]
    return correction if log.known["leg_weight_n"].ndim > 1 else correction[:1]


def _leg_com(log: Log, theta: Theta) -> FloatArray:
    phase = leg_phase(log)
    sine, cosine = np.sin(phase), np.cos(phase)

    def part(axis: str) -> FloatArray:
        swing, mean = (theta[f"com_correction_{axis}_{term}"] for term in ("sin", "mean"))
        return swing * sine + theta[f"com_correction_{axis}_cos"] * cosine + mean

    level = np.broadcast_to(theta["com_correction_y_mean"], phase.shape)
    error = np.stack([part("x"), level, part("z")], axis=-1)
    return error.reshape(log.known["leg_com_m"].shape)


def _robot_weight(_log: Log, theta: Theta) -> FloatArray:
    return theta["robot_weight_correction"][:1]


def _hang_rotation(gravity_dir: FloatArray, theta: Theta) -> FloatArray:
    """Rotation from believed to true direction of gravity, row by row, shape (n, 3, 3)."""
    from scipy.spatial.transform import Rotation

    axes = np.array(list(HANGINGS.values()), dtype=float)
    vectors = np.zeros((len(axes), 3))
    for i, name in enumerate(HANGINGS):
        for j, axis in enumerate("xyz"):
            if axis != name[1]:
                vectors[i, j] = theta[f"tilt_{name}_{axis}"][0]
    hanging = np.argmax(gravity_dir @ axes.T, axis=1)
    rotation: FloatArray = Rotation.from_rotvec(vectors).as_matrix()[hanging]
    return rotation


def _hang_straight(
    d: FloatArray, _log: Log, theta: Theta, state: State
) -> tuple[FloatArray, State]:
    believed: FloatArray = np.einsum("nji,nj->ni", _hang_rotation(d, theta), d)
    return believed, state


def _hang_tilted(d: FloatArray, _log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    true: FloatArray = np.einsum("nij,nj->ni", _hang_rotation(d, theta), d)
    return true, state


def _tilt_matrix(theta: Theta) -> FloatArray:
    from scipy.spatial.transform import Rotation

    return Rotation.from_euler("xy", [theta["body_roll"][0], theta["body_pitch"][0]]).as_matrix()


def _believe_tilted(
    r: FloatArray, _log: Log, theta: Theta, state: State
) -> tuple[FloatArray, State]:
    return r @ _tilt_matrix(theta).T, state


def _right_tilt(r: FloatArray, _log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    return r @ _tilt_matrix(theta), state


LEG_WEIGHT = Effect(
    name="leg_weight",
    traits=(Trait.BELIEF, Trait.HUNG),
    stage=Stage.BODY,
    scope=Scope.LEG,
    parameters=(EffectParameter("weight_correction", "N", 0.0, -50.0, 50.0, 0.3),),
    apply=on_known("leg_weight_n", plus(_leg_weight, -1.0)),
    remove=on_known("leg_weight_n", plus(_leg_weight)),
    experiments=("hang", "pose"),
    formula="true m_k g = believed m_k g + δ",
    source="Wu & Revzen, eqs. (2)–(7), Table II",
    remedy="calibrate: hang-calib; weigh the leg with everything beyond the transducer",
    needs=("leg_weight_n",),
    mimics=("robot_weight", "scale_matrix"),
    separates="hanging in two opposite orientations",
)

LEG_COM = Effect(
    name="leg_com",
    traits=(Trait.BELIEF, Trait.HUNG),
    stage=Stage.BODY,
    scope=Scope.LEG,
    parameters=tuple(
        EffectParameter(f"com_correction_{part}", "m", 0.0, -0.5, 0.5, 0.005)
        for part in ("x_sin", "x_cos", "x_mean", "y_mean", "z_sin", "z_cos", "z_mean")
    ),
    apply=on_known("leg_com_m", plus(_leg_com, -1.0)),
    remove=on_known("leg_com_m", plus(_leg_com)),
    experiments=("hang",),
    formula="true r(φ) = believed r(φ) + sin, cos and mean in x and z, mean in y",
    source="Wu & Revzen, section III-A-3: r(φ) = A sin(φ + C) + D",
    remedy="calibrate: hang-calib; correct the masses in the leg's model",
    needs=("leg_com_m", "phase_rad"),
    mimics=("offset", "cable_drag", "mount_translation"),
    separates="hanging along x and along z: each shows what the other cannot",
)

HANG_TILT = Effect(
    name="hang_tilt",
    traits=(Trait.BELIEF, Trait.HUNG),
    stage=Stage.BODY,
    scope=Scope.LEG,
    parameters=tuple(EffectParameter(tilt, "rad", 0.0, -0.5, 0.5, 0.035) for tilt in TILTS),
    apply=on_known("gravity_dir", _hang_straight),
    remove=on_known("gravity_dir", _hang_tilted),
    experiments=("hang",),
    of_recording=True,
    formula="true direction of gravity = exp([s]) · nominal direction, one s per orientation",
    source="Wu & Revzen, eqs. (4)–(7)",
    remedy="nothing: hang-calib estimates it; hang the robot from two points if it sways",
    needs=("gravity_dir",),
    mimics=("mount_rotation", "offset"),
    separates="opposite orientations: a tilt turns with the robot, an offset does not",
)

ROBOT_WEIGHT = Effect(
    name="robot_weight",
    traits=(Trait.BELIEF,),
    stage=Stage.BODY,
    scope=Scope.ROBOT,
    parameters=(EffectParameter("robot_weight_correction", "N", 0.0, -200.0, 200.0, 1.0),),
    apply=on_known("robot_weight_n", plus(_robot_weight, -1.0)),
    remove=on_known("robot_weight_n", plus(_robot_weight)),
    experiments=("pose",),
    formula="true M g = believed M g + δ",
    source="Wu & Revzen, eq. (8): G; 8.18 kg on a hanging scale",
    remedy="weigh the robot with battery and cables",
    needs=("robot_weight_n",),
    mimics=("leg_weight", "case_strain", "scale_matrix"),
    separates="a scale; leg weights from hang-calib",
)

BODY_TILT = Effect(
    name="body_tilt",
    traits=(Trait.BELIEF,),
    stage=Stage.BODY,
    scope=Scope.ROBOT,
    parameters=(
        EffectParameter("body_roll", "rad", 0.0, -0.5, 0.5, 0.01),
        EffectParameter("body_pitch", "rad", 0.0, -0.5, 0.5, 0.01),
    ),
    apply=on_known("rot_wb", _believe_tilted),
    remove=on_known("rot_wb", _right_tilt),
    experiments=("pose",),
    of_recording=True,
    formula="true R_wb = believed R_wb · R, R: roll about x, then pitch about y, body axes",
    source="Wu & Revzen, section I-B: markers define the body frame",
    remedy="define the marker frame with the chassis on a levelled plate",
    needs=("rot_wb",),
    mimics=("mount_rotation",),
    separates="no pose can (it equals a common mounting rotation); put a spirit level on it",
)

EFFECTS = (LEG_WEIGHT, LEG_COM, HANG_TILT, ROBOT_WEIGHT, BODY_TILT)
