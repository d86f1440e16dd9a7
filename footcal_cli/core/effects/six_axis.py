"""Distortions of six-axis transducers at the hips (or in the feet): mounting, gains, drag.

A wrench is ``[fx fy fz tx ty tz]`` in the transducer's nominal frame, torque about its nominal
origin, until the mounting effects move it to where and how the transducer really sits.
"""

from __future__ import annotations

import numpy as np

from footcal_cli.core.effects.calibration import AXES, per_axis, wrench_of
from footcal_cli.core.effects.contract import (
    ArrayTransform,
    Effect,
    EffectParameter,
    Scope,
    Stage,
    State,
    Theta,
    Trait,
    on_wrenches,
    over,
    plus,
    times,
)
from footcal_cli.core.effects.memory import moment, plus_since, settling, settling_rate
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.spatial import cross

COUPLINGS = tuple(f"{g}{a}_{g}{b}" for g in "ft" for a in "xyz" for b in "xyz" if a != b)
"""``fx_fz``: what of fz shows up in fx."""
HUNG_OR_STOOD = ("hang", "pose")
HIPS_AND_ANKLES = (*HUNG_OR_STOOD, "stand", "walk")
"""A transducer under load: hanging and posing on hips, standing and walking on ankles."""


def leg_phase(log: Log) -> FloatArray:
    """Shaft angle of each leg, shape (n, legs)."""
    legs = len(log.channels) // 6
    return np.broadcast_to(log.known["phase_rad"].reshape(len(log), -1), (len(log), legs))


def _rotations(theta: Theta) -> FloatArray:
    vectors = np.stack([theta[f"mount_rot_{axis}"] for axis in "xyz"], axis=-1)
    from scipy.spatial.transform import Rotation

    return Rotation.from_rotvec(vectors).as_matrix()


def _rotated(wrenches: FloatArray, rotations: FloatArray) -> FloatArray:
    """Force and torque of each leg turned by its rotation (legs, 3, 3)."""
    pair = wrenches.reshape(*wrenches.shape[:2], 2, 3)
    turned: FloatArray = np.einsum("kij,nkwj->nkwi", rotations, pair).reshape(wrenches.shape)
    return turned


def _mount(w: FloatArray, _log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    return _rotated(w, _rotations(theta).transpose(0, 2, 1)), state


def _unmount(w: FloatArray, _log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    return _rotated(w, _rotations(theta)), state


def _about(sign: float) -> ArrayTransform:
    def moved(w: FloatArray, _log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
        place = np.stack([theta[f"mount_pos_{axis}"] for axis in "xyz"], axis=-1)
        lever = cross(place, w[..., :3])
        return np.concatenate([w[..., :3], w[..., 3:] + sign * lever], axis=-1), state

    return moved


def _gain(_log: Log, theta: Theta) -> FloatArray:
    return 1.0 + wrench_of(theta, "gain")


def _coupling(theta: Theta) -> FloatArray:
    """Matrix (legs, 6, 6) from true to shown wrenches."""
    legs = theta[f"coupling_{COUPLINGS[0]}"].size
    matrix = np.tile(np.eye(6), (legs, 1, 1))
    for name in COUPLINGS:
        to, of = name.split("_")
        matrix[:, AXES.index(to), AXES.index(of)] = theta[f"coupling_{name}"]
    return matrix


def _couple(w: FloatArray, _log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    return np.einsum("kij,nkj->nki", _coupling(theta), w), state


def _uncouple(w: FloatArray, _log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    pure = np.linalg.solve(_coupling(theta), w.transpose(1, 2, 0))
    return np.asarray(pure.transpose(2, 0, 1)), state


def _flipped(_log: Log, theta: Theta) -> FloatArray:
    return 1.0 - 2.0 * wrench_of(theta, "flip")


def _strain_of(theta: Theta) -> FloatArray:
    return np.stack([theta[f"strain_{axis}"] for axis in AXES[:3]], axis=-1)


def _strain(w: FloatArray, _log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    strain, force = _strain_of(theta), w[..., :3]
    load = np.linalg.norm(force, axis=-1, keepdims=True)
    bridged = theta["strain_bridged"][:, None]
    felt = strain * ((1.0 - bridged) * load + bridged * force)
    return np.concatenate([force + felt, w[..., 3:]], axis=-1), state


def _unstrain(w: FloatArray, _log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    strain, bridged = _strain_of(theta), theta["strain_bridged"][:, None]
    passed = 1.0 + bridged * strain
    force, strain = w[..., :3] / passed, (1.0 - bridged) * strain / passed
    rest = 1.0 - np.sum(strain**2, axis=-1)
    along = np.sum(strain * force, axis=-1)
    load = (np.sqrt(along**2 + rest * np.sum(force**2, axis=-1)) - along) / rest
    return np.concatenate([force - strain * load[..., None], w[..., 3:]], axis=-1), state


def _drag(log: Log, theta: Theta) -> FloatArray:
    if "phase_rad" not in log.known:
        return np.zeros(1)
    phase = leg_phase(log)[..., None]
    sine = np.stack([theta[f"cable_{axis}_sin"] for axis in AXES[:3]], axis=-1)
    cosine = np.stack([theta[f"cable_{axis}_cos"] for axis in AXES[:3]], axis=-1)
    mean = np.stack([theta[f"cable_{axis}_mean"] for axis in AXES[:3]], axis=-1)
    pull = mean + sine * np.sin(phase) + cosine * np.cos(phase)
    return np.concatenate([pull, np.zeros_like(pull)], axis=-1)


def _drift(since_s: FloatArray, theta: Theta) -> FloatArray:
    late = settling(since_s[:, None], theta["drift_settling"])
    return late[..., None] * wrench_of(theta, "offset_drift")


def _change(since_s: FloatArray, theta: Theta) -> FloatArray:
    after = since_s[:, None, None] >= theta["change_time"][:, None]
    return after * wrench_of(theta, "offset_change")


def _shift(_log: Log, theta: Theta) -> FloatArray:
    return wrench_of(theta, "zero_shift")


MOUNT_TRANSLATION = Effect(
    name="mount_translation",
    traits=(Trait.MOUNTING, Trait.LINEAR),
    stage=Stage.SIX_AXIS,
    scope=Scope.LEG,
    parameters=tuple(
        EffectParameter(f"mount_pos_{axis}", "m", 0.0, -0.2, 0.2, 0.005) for axis in "xyz"
    ),
    apply=on_wrenches(_about(-1.0)),
    remove=on_wrenches(_about(1.0)),
    experiments=("pose", "stand", "walk"),
    formula="τ_measured = τ − p̃ × f: true origin = nominal origin + p̃, in nominal transducer axes",
    source="Wu & Revzen, eqs. (8)(9)",
    remedy="calibrate: pose-calib; check the transducer's screws and spacers",
    mimics=("com_offset", "leg_com", "scale_matrix"),
    separates="standing poses with large internal forces; the sum with p_BC is all that shows",
)

MOUNT_ROTATION = Effect(
    name="mount_rotation",
    traits=(Trait.MOUNTING, Trait.LINEAR),
    stage=Stage.SIX_AXIS,
    scope=Scope.LEG,
    parameters=tuple(
        EffectParameter(f"mount_rot_{axis}", "rad", 0.0, -3.2, 3.2, 0.02) for axis in "xyz"
    ),
    apply=on_wrenches(_mount),
    remove=on_wrenches(_unmount),
    experiments=HIPS_AND_ANKLES,
    formula="w_measured = R̃ᵀ w, force and torque alike; R̃ turns by the vector mount_rot",
    source="Wu & Revzen, eqs. (8)(9), about the hip (METHODS: fifth model)",
    remedy="calibrate: pose-calib; check the mounting screws of that leg",
    mimics=("body_tilt", "hang_tilt", "cross_coupling"),
    separates="hanging in two pairs of orientations (each leg's share) and poses (the common one)",
)

SCALE_MATRIX = Effect(
    name="scale_matrix",
    traits=(Trait.AXIS_GAIN, Trait.LINEAR, Trait.ZERO_TOO),
    stage=Stage.SIX_AXIS,
    scope=Scope.LEG,
    parameters=tuple(EffectParameter(f"gain_{axis}", "-", 0.0, -0.4, 0.4, 0.02) for axis in AXES),
    apply=on_wrenches(times(_gain)),
    remove=on_wrenches(over(_gain)),
    experiments=HIPS_AND_ANKLES,
    formula="w_measured = (1 + γ) w, axis by axis",
    source="Wu & Revzen, section I-C (in-situ calibration matrices)",
    remedy="send the transducer to be recalibrated, or keep the gains",
    mimics=("cross_coupling", "leg_weight", "robot_weight", "mass"),
    separates="a known weight on the toe of that leg",
)

CROSS_COUPLING = Effect(
    name="cross_coupling",
    traits=(Trait.LINEAR, Trait.ZERO_TOO),
    stage=Stage.SIX_AXIS,
    scope=Scope.LEG,
    parameters=tuple(
        EffectParameter(f"coupling_{name}", "-", 0.0, -0.4, 0.4, 0.01) for name in COUPLINGS
    ),
    apply=on_wrenches(_couple),
    remove=on_wrenches(_uncouple),
    experiments=HIPS_AND_ANKLES,
    formula="w_measured = C w, ones on the diagonal, forces into forces and torques into torques",
    source="six-axis data sheets (crosstalk); Wu & Revzen, section I-C",
    remedy="send the transducer to be recalibrated, or keep the matrix",
    mimics=("scale_matrix", "mount_rotation"),
    separates="a known weight on the toe of that leg in three orientations",
)

AXIS_FLIP = Effect(
    name="axis_flip",
    traits=(Trait.AXIS_GAIN, Trait.LINEAR, Trait.SWITCH, Trait.ZERO_TOO),
    stage=Stage.SIX_AXIS,
    scope=Scope.LEG,
    parameters=tuple(EffectParameter(f"flip_{axis}", "-", 0.0, 0.0, 1.0, 0.3) for axis in AXES),
    apply=on_wrenches(times(_flipped)),
    remove=on_wrenches(over(_flipped)),
    experiments=HIPS_AND_ANKLES,
    formula="w_measured = (1 − 2 s) w, s = 1 for a flipped axis",
    source="METHODS: transducers mounted turned by π about z read −x where others read +x",
    remedy="correct that leg's axes in the recipe",
    mimics=("mount_rotation", "sign_flip"),
    separates="pull the leg along each axis by hand",
)

CASE_STRAIN = Effect(
    name="case_strain",
    traits=(Trait.ZERO_TOO,),
    stage=Stage.SIX_AXIS,
    scope=Scope.LEG,
    parameters=(
        *(EffectParameter(f"strain_{axis}", "-", 0.0, -0.4, 0.4, 0.02) for axis in AXES[:3]),
        EffectParameter("strain_bridged", "form", 0.0, 0.0, 1.0, 1.0, True, (0.0, 1.0)),
    ),
    apply=on_wrenches(_strain),
    remove=on_wrenches(_unstrain),
    experiments=("pose",),
    formula="f_measured = f + s ‖f‖ where the load strains the case, which the transducer feels; "
    "f + s f axis by axis where the case bridges the transducer and carries a share",
    source="Wu & Revzen, section I-D: rubber bands on the case shift the reading by 1–3 N",
    remedy="free the case: nothing may touch it but its two faces",
    mimics=("robot_weight", "cross_coupling", "scale_matrix"),
    separates="hang the robot by its legs: the strain keeps its sign when the load turns over; "
    "a bridge is a gain until the case is freed",
)

CABLE_DRAG = Effect(
    name="cable_drag",
    stage=Stage.SIX_AXIS,
    scope=Scope.LEG,
    parameters=tuple(
        EffectParameter(f"cable_{axis}_{part}", "N", 0.0, -20.0, 20.0, usual, beside=part == "mean")
        for axis in AXES[:3]
        for part, usual in (("sin", 0.3), ("cos", 0.3), ("mean", 1.0))
    ),
    apply=on_wrenches(plus(_drag)),
    remove=on_wrenches(plus(_drag, -1.0)),
    experiments=HUNG_OR_STOOD,
    formula="f_measured = f + a sin φ + b cos φ + c; hanging legs show c as an offset",
    source="motor cables that bridge the transducer and bend with the leg",
    remedy="give the leg's cable a loose loop across the transducer",
    needs=("phase_rad",),
    mimics=("leg_com", "leg_weight"),
    separates="turn the legs with the cable untied",
)

OFFSET_DRIFT = Effect(
    name="offset_drift",
    traits=(Trait.TIMED, Trait.MEMORY, Trait.ZERO),
    stage=Stage.SIX_AXIS,
    scope=Scope.LEG,
    parameters=(*per_axis("offset_drift", 2e-4, 2e-5, 10.0, "/s"), settling_rate()),
    apply=on_wrenches(plus_since(_drift)),
    remove=on_wrenches(plus_since(_drift, -1.0)),
    experiments=HIPS_AND_ANKLES,
    of_recording=True,
    formula="w_measured = w + k t₁ (1 − exp(−r t)) / (1 − exp(−r t₁)), t₁ = 30 min; r = 0: k t",
    source="Wu & Revzen, section V: offsets moved by up to 10 N in six months",
    remedy="let the electronics warm up for 20 minutes; calibrate offsets before each use",
    mimics=("offset_change", "temperature_bias"),
    separates="hang the robot again at the end of the session",
)

ZERO_SHIFT = Effect(
    name="zero_shift",
    stage=Stage.SIX_AXIS,
    scope=Scope.LEG,
    parameters=per_axis("zero_shift", 1.0, 0.1, 100.0),
    apply=on_wrenches(plus(_shift)),
    remove=on_wrenches(plus(_shift, -1.0)),
    experiments=("pose",),
    formula="w_measured = w + Δ: the offset moved since it was calibrated",
    source="Wu & Revzen, section V: offsets moved by up to 10 N in six months",
    remedy="repeat hang-calib just before the robot stands, or find new offsets from tripods",
    mimics=("offset", "offset_change", "robot_weight"),
    separates="hang the robot again",
)

OFFSET_CHANGE = Effect(
    name="offset_change",
    traits=(Trait.TIMED, Trait.MEMORY),
    stage=Stage.SIX_AXIS,
    scope=Scope.LEG,
    parameters=(*per_axis("offset_change", 1.0, 0.1, 100.0), moment("change_time", 20)),
    apply=on_wrenches(plus_since(_change)),
    remove=on_wrenches(plus_since(_change, -1.0)),
    experiments=HIPS_AND_ANKLES,
    of_recording=True,
    formula="w_measured = w + Δ for t − t₀ ≥ t_Δ",
    source="Wu & Revzen, section V; a blow, a tightened screw, a cable caught",
    remedy="repeat hang-calib after whatever happened then",
    mimics=("offset_drift", "offset"),
    separates="hang the robot before and after",
)

EFFECTS = (
    CABLE_DRAG,
    MOUNT_TRANSLATION,
    MOUNT_ROTATION,
    CASE_STRAIN,
    CROSS_COUPLING,
    SCALE_MATRIX,
    AXIS_FLIP,
    OFFSET_DRIFT,
    ZERO_SHIFT,
    OFFSET_CHANGE,
)
"""In the order in which a wrench passes them."""
