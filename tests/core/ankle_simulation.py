"""Standing and walking on six-axis transducers at the ankles: wrenches by Newton and Euler."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from footcal_cli.core.chain import Chain
from footcal_cli.core.effects.calibration import AXES
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.simulation.ankle_logs import ground_wrenches
from footcal_cli.core.simulation.biped_logs import MotionAt
from footcal_cli.core.simulation.columns import WRENCH_COLUMNS, Columns
from footcal_cli.core.simulation.gait import Motion
from footcal_cli.core.simulation.measure import Simulated, measure
from footcal_cli.core.simulation.noise import SimulatedNoise, stream
from footcal_cli.core.simulation.robots import Biped

HUMANOID_SOLE: Mapping[str, tuple[float, float]] = {
    "fl": (0.12, 0.07),
    "fr": (0.12, -0.07),
    "rl": (-0.09, 0.07),
    "rr": (-0.09, -0.07),
}
"""Corners of a sole, m in the foot frame; the CoP stays within."""


def humanoid() -> Biped:
    """A robot of the size and weight of a small adult; its cells are the corners of its soles."""
    return Biped(
        feet={"left": HUMANOID_SOLE, "right": HUMANOID_SOLE},
        mass_kg=68.6, com_height_m=0.82, half_width_m=0.085,
    )  # fmt: skip


@dataclass(frozen=True)
class Ankles:
    """Transducers at the ankles and how they and the body's stream are sampled.

    Parameters
    ----------
    height_m
        Of the transducers above the soles.
    weight_below_n, com_below_m
        What hangs below each transducer, and its CoM in the transducer's frame.
    rate_hz
        Of both streams, which share a clock.
    force_noise, torque_noise
        Of each axis.
    com_noise_m, acc_noise_mps2, angmom_noise_nm
        White noise of the body's stream.
    temperature_degc, warming_degc_per_s
        Start and rate of the transducers' temperature.
    """

    height_m: float = 0.1
    weight_below_n: float = 19.7
    com_below_m: tuple[float, float, float] = (0.02, 0.0, -0.06)
    rate_hz: float = 50.0
    force_noise: SimulatedNoise = field(default_factory=lambda: SimulatedNoise(white=1.0))
    torque_noise: SimulatedNoise = field(default_factory=lambda: SimulatedNoise(white=0.1))
    com_noise_m: float = 2e-4
    acc_noise_mps2: float = 0.03
    angmom_noise_nm: float = 0.3
    temperature_degc: float = 22.0
    warming_degc_per_s: float = 0.002


def six_axis_channels(robot: Biped) -> tuple[str, ...]:
    """``<foot>.<axis>`` of all feet."""
    return tuple(f"{foot}.{axis}" for foot in robot.feet for axis in AXES)


def six_axis_feet_log(
    experiment: str,
    robot: Biped,
    motion_at: MotionAt,
    duration_s: float,
    chain: Chain,
    values: Mapping[str, float],
    *,
    seed: int,
    ankles: Ankles | None = None,
) -> Simulated:
    """A standing or walking robot's ankle wrenches and its body stream on one clock.

    Parameters
    ----------
    motion_at
        The motion at any stamps.
    chain, values
        Offsets and effects; readings stay in N and Nm.
    """
    ankles = ankles or Ankles()
    clock = np.arange(float(int(duration_s * ankles.rate_hz))) / ankles.rate_hz
    motion = motion_at(clock)
    channels = six_axis_channels(robot)
    planned = Log(
        experiment, channels, clock, np.zeros((clock.size, len(channels))),
        _known(robot, ankles, motion), motion.block,
    )  # fmt: skip
    rng = stream(seed, "ankles")
    done = measure(
        planned, lambda log: ground_wrenches(log, motion), chain, values,
        force_noise=ankles.force_noise, torque_noise=ankles.torque_noise, rng=rng,
    )  # fmt: skip
    noisy = {
        name: done.log.known[name] + sd * rng.standard_normal(done.log.known[name].shape)
        for name, sd in (
            ("com_m", ankles.com_noise_m),
            ("com_acc_mps2", ankles.acc_noise_mps2),
            ("angmom_rate_nm", ankles.angmom_noise_nm),
        )
    }
    return Simulated(done.truth, done.log.with_known(**noisy), done.chain, done.values)


def _known(robot: Biped, ankles: Ankles, motion: Motion) -> dict[str, FloatArray]:
    """What the robot says of itself, in the arrays of `footcal_cli.core.experiments.walk`."""
    n, feet = len(motion.time_s), len(robot.feet)
    cos, sin = np.cos(motion.foot_yaw_rad), np.sin(motion.foot_yaw_rad)
    rot = np.zeros((n, feet, 3, 3))
    rot[..., 0, 0], rot[..., 0, 1], rot[..., 1, 0], rot[..., 1, 1] = cos, -sin, sin, cos
    rot[..., 2, 2] = 1.0
    return {
        "com_m": motion.com_m,
        "com_acc_mps2": motion.com_acc_mps2,
        "angmom_rate_nm": motion.angmom_rate_nm,
        "mass_kg": np.full(n, robot.mass_kg),
        "gravity_mps2": np.full(n, robot.gravity_mps2),
        "foot_yaw_rad": motion.foot_yaw_rad,
        "contact": motion.contact,
        "foot_rot_wt": rot,
        "foot_pos_m": motion.foot_m + np.array([0.0, 0.0, ankles.height_m]),
        "foot_weight_n": np.full((n, feet), ankles.weight_below_n),
        "foot_com_m": np.tile(np.array(ankles.com_below_m), (n, feet, 1)),
        "foot_acc_mps2": _smooth_acceleration(motion.foot_m, motion.time_s),
        "temperature_degc": ankles.temperature_degc + ankles.warming_degc_per_s * motion.time_s,
    }


def _smooth_acceleration(place_m: FloatArray, time_s: FloatArray) -> FloatArray:
    """Differences of differences: smooth enough to be moved in time by parts of a sample."""
    return np.asarray(np.gradient(np.gradient(place_m, time_s, axis=0), time_s, axis=0))


def _vector(name: str, unit: str, array: FloatArray, axes: str = "xyz") -> dict[str, FloatArray]:
    return {f"{name}_{axis}_{unit}": array[:, i] for i, axis in enumerate(axes)}


def six_axis_feet_columns(done: Simulated, feet: Sequence[str], ankles: Ankles) -> Columns:
    """Wrenches and body stream of a robot on ankle transducers, one clock."""
    log = done.log
    known = log.known
    wrenches = {
        f"{foot}_{name}": log.readings[:, 6 * i + j]
        for i, foot in enumerate(feet)
        for j, name in enumerate(WRENCH_COLUMNS)
    }
    columns: dict[str, NDArray[np.generic]] = {
        "time_s": log.time_s,
        **wrenches,
        **_vector("com", "m", known["com_m"]),
        **_vector("com_acc", "mps2", known["com_acc_mps2"]),
        **_vector("angmom_rate", "nm", known["angmom_rate_nm"], "xy"),
    }
    for i, foot in enumerate(feet):
        sole = known["foot_pos_m"][:, i] - np.array([0.0, 0.0, ankles.height_m])
        columns |= _vector(f"{foot}_foot", "m", sole)
        columns[f"{foot}_foot_yaw_rad"] = known["foot_yaw_rad"][:, i]
    return columns
