"""What the body's model and inertial unit get wrong: mass, CoM, tilt, acceleration, momentum.

Corrections are what must be added to a belief: truth = believed + correction. Body axes are those
of the mean heading of the feet.
"""

from __future__ import annotations

import numpy as np

from footcal_cli.core.effects.contract import (
    DRIFT_TAKES_IT,
    Effect,
    EffectParameter,
    Scope,
    Stage,
    State,
    Theta,
    Trait,
    on_known,
    over,
    plus,
    times,
)
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray

BALANCED = ("stand", "walk")


def heading_rad(log: Log) -> FloatArray:
    """Direction the body faces: the mean yaw of the feet, shape (n,); 0 where none is known."""
    yaw = log.known.get("foot_yaw_rad")
    if yaw is None:
        return np.zeros(len(log))
    heading: FloatArray = np.arctan2(np.sin(yaw).mean(axis=1), np.cos(yaw).mean(axis=1))
    return heading


def turned_about_z(vector: FloatArray, yaw_rad: FloatArray) -> FloatArray:
    """Vectors (..., 3) turned about z by yaws (n,), shape (n, 3)."""
    cos, sin = np.cos(yaw_rad), np.sin(yaw_rad)
    x, y, z = np.moveaxis(np.broadcast_to(vector, (yaw_rad.size, 3)), -1, 0)
    return np.stack([cos * x - sin * y, sin * x + cos * y, z], axis=-1)


def _triple(theta: Theta, prefix: str) -> FloatArray:
    return np.array([theta[f"{prefix}_{axis}"][0] for axis in "xyz"])


def _tilting(theta: Theta, roll: str, pitch: str) -> FloatArray:
    """Rotation by roll about x, then pitch about y, shape (3, 3)."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_euler("xy", [theta[roll][0], theta[pitch][0]]).as_matrix()


def _see_tilted(acc: FloatArray, log: Log, tilt: FloatArray, yaw_rad: FloatArray) -> FloatArray:
    """Acceleration without gravity as an inertial unit shows it whose frame is rotated by tilt."""
    gravity = np.zeros_like(acc)
    gravity[:, 2] = log.known["gravity_mps2"]
    specific = turned_about_z(acc + gravity, -yaw_rad) @ tilt
    return turned_about_z(specific, yaw_rad) - gravity


def _imu_tilt(acc: FloatArray, log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    tilt = _tilting(theta, "imu_roll", "imu_pitch")
    return _see_tilted(acc, log, tilt, heading_rad(log)), state


def _imu_level(acc: FloatArray, log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    tilt = _tilting(theta, "imu_roll", "imu_pitch")
    return _see_tilted(acc, log, tilt.T, heading_rad(log)), state


def _slope(acc: FloatArray, log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    tilt = _tilting(theta, "floor_roll", "floor_pitch")
    return _see_tilted(acc, log, tilt, np.zeros(len(log))), state


def _unslope(acc: FloatArray, log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    tilt = _tilting(theta, "floor_roll", "floor_pitch")
    return _see_tilted(acc, log, tilt.T, np.zeros(len(log))), state


def _accel_bias(log: Log, theta: Theta) -> FloatArray:
    return turned_about_z(_triple(theta, "accel_bias"), heading_rad(log))


def _gain(acc: FloatArray, log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    return scaled_in_body(acc, log, 1.0 + level_share(theta, "accel_gain")), state


def _ungain(acc: FloatArray, log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    return scaled_in_body(acc, log, 1.0 / (1.0 + level_share(theta, "accel_gain"))), state


def level_share(theta: Theta, kind: str) -> FloatArray:
    """Share ahead and to the left; what changes upwards is seen as a force."""
    return np.array([theta[f"{kind}_x"][0], theta[f"{kind}_y"][0], 0.0])


def scaled_in_body(acc: FloatArray, log: Log, by: FloatArray) -> FloatArray:
    """Accelerations (n, 3) times a number per axis of the body, shape (n, 3)."""
    yaw_rad = heading_rad(log)
    return turned_about_z(turned_about_z(acc, -yaw_rad) * by, yaw_rad)


def _com(log: Log, theta: Theta) -> FloatArray:
    return turned_about_z(_triple(theta, "com_correction"), heading_rad(log))


def _mass(_log: Log, theta: Theta) -> FloatArray:
    return theta["mass_correction"][:1]


def _kept(_log: Log, theta: Theta) -> FloatArray:
    return 1.0 - theta["angmom_loss"][:1]


MASS = Effect(
    name="mass",
    traits=(Trait.BELIEF, Trait.ALL_ALIKE),
    unseen_walking=DRIFT_TAKES_IT + "put a certified weight on the standing robot",
    stage=Stage.BODY,
    scope=Scope.ROBOT,
    parameters=(EffectParameter("mass_correction", "kg", 0.0, -20.0, 20.0, 0.1),),
    apply=on_known("mass_kg", plus(_mass, -1.0)),
    remove=on_known("mass_kg", plus(_mass)),
    experiments=BALANCED,
    formula="true mass = believed mass + δ",
    source="NAO CoP self-calibration, eq. (9)",
    remedy="weigh the robot as it walks, battery and cables included",
    needs=("mass_kg",),
    mimics=("scale_bias", "load_bypass", "scale_matrix"),
    separates="a certified weight put on the standing robot",
)

COM_OFFSET = Effect(
    name="com_offset",
    stage=Stage.BODY,
    scope=Scope.ROBOT,
    parameters=tuple(
        EffectParameter(f"com_correction_{axis}", "m", 0.0, -0.2, 0.2, 0.005) for axis in "xyz"
    ),
    apply=on_known("com_m", plus(_com, -1.0)),
    remove=on_known("com_m", plus(_com)),
    experiments=BALANCED,
    formula="true CoM = believed CoM + R(heading) δ",
    source="NAO CoP self-calibration, eqs. (10)(11): CoM from the robot's own model",
    remedy="correct the masses in the robot's model; suspend the robot to find its CoM",
    needs=("com_m",),
    mimics=("imu_tilt", "accel_bias", "floor_slope"),
    separates="squats at three heights",
)

IMU_TILT = Effect(
    name="imu_tilt",
    stage=Stage.BODY,
    scope=Scope.ROBOT,
    parameters=(
        EffectParameter("imu_roll", "rad", 0.0, -0.5, 0.5, 0.01),
        EffectParameter("imu_pitch", "rad", 0.0, -0.5, 0.5, 0.01),
    ),
    apply=on_known("com_acc_mps2", _imu_tilt),
    remove=on_known("com_acc_mps2", _imu_level),
    experiments=("walk",),
    formula="a_shown = Rᵀ (a + g e_z) − g e_z, R: roll about x, then pitch about y, body axes",
    source="NAO CoP self-calibration, section 5.1 (IMU misalignment)",
    remedy="level the inertial unit, or calibrate it on a flat plate",
    needs=("com_acc_mps2",),
    mimics=("accel_bias", "com_offset", "floor_slope"),
    separates="flip the inertial unit (accelerometer bias), squat (CoM), turn on the spot (floor)",
)

FLOOR_SLOPE = Effect(
    name="floor_slope",
    stage=Stage.BODY,
    scope=Scope.ROBOT,
    parameters=(
        EffectParameter("floor_roll", "rad", 0.0, -0.5, 0.5, 0.01),
        EffectParameter("floor_pitch", "rad", 0.0, -0.5, 0.5, 0.01),
    ),
    apply=on_known("com_acc_mps2", _slope),
    remove=on_known("com_acc_mps2", _unslope),
    experiments=("walk",),
    of_recording=True,
    formula="as imu_tilt, with axes fixed to the floor",
    source="gravity is not normal to the floor; NAO CoP self-calibration, eqs. (10)(11) take "
    "ground at z = 0",
    remedy="put a spirit level on the floor",
    needs=("com_acc_mps2",),
    mimics=("imu_tilt", "accel_bias", "com_offset"),
    separates="turn on the spot while walking",
)

ACCEL_BIAS = Effect(
    name="accel_bias",
    stage=Stage.BODY,
    scope=Scope.ROBOT,
    parameters=tuple(
        EffectParameter(f"accel_bias_{axis}", "m/s²", 0.0, -1.0, 1.0, 0.1) for axis in "xyz"
    ),
    apply=on_known("com_acc_mps2", plus(_accel_bias)),
    remove=on_known("com_acc_mps2", plus(_accel_bias, -1.0)),
    experiments=("walk",),
    formula="a_shown = a + R(heading) b",
    source="NAO CoP self-calibration, open points (IMU bias)",
    remedy="re-zero the accelerometer at rest",
    needs=("com_acc_mps2",),
    mimics=("imu_tilt", "com_offset", "floor_slope"),
    separates="flip the inertial unit; squat",
)

ACCEL_GAIN = Effect(
    name="accel_gain",
    stage=Stage.BODY,
    scope=Scope.ROBOT,
    parameters=tuple(
        EffectParameter(f"accel_gain_{axis}", "-", 0.0, -0.5, 0.5, 0.05) for axis in "xy"
    ),
    apply=on_known("com_acc_mps2", _gain),
    remove=on_known("com_acc_mps2", _ungain),
    experiments=("walk",),
    formula="a_shown = R(heading) diag(1 + s_x, 1 + s_y, 1) R(heading)ᵀ a, gravity not included",
    source="data sheets of inertial units: scale factor; derivatives of smoothed positions fall "
    "short of their peaks",
    remedy="check the range of the accelerometer, or differentiate with a shorter window",
    needs=("com_acc_mps2",),
    mimics=("com_offset", "angular_momentum", "accel_bias"),
    separates="squats at three heights: the lever of an acceleration is the height of the CoM",
)

ANGULAR_MOMENTUM = Effect(
    name="angular_momentum",
    stage=Stage.BODY,
    scope=Scope.ROBOT,
    parameters=(EffectParameter("angmom_loss", "-", 0.0, -2.0, 0.95, 0.1),),
    apply=on_known("angmom_rate_nm", times(_kept)),
    remove=on_known("angmom_rate_nm", over(_kept)),
    experiments=("walk",),
    formula="L̇_shown = (1 − s) L̇",
    source="NAO CoP self-calibration, eqs. (10)(11); dropping L̇ biases scales by 10–30 %",
    remedy="include the legs' inertias in the model that computes angular momentum",
    needs=("angmom_rate_nm",),
    mimics=("cell_position", "delay"),
    separates="walk faster: L̇ grows with the square of the speed",
)


EFFECTS = (MASS, COM_OFFSET, IMU_TILT, FLOOR_SLOPE, ACCEL_BIAS, ACCEL_GAIN, ANGULAR_MOMENTUM)
