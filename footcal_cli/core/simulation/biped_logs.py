"""Standing and walking on load cells: motion, ground forces by Newton and Euler, streams."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from footcal_cli.core.centroidal import dynamic_reference
from footcal_cli.core.chain import Chain
from footcal_cli.core.effects.contract import Stage
from footcal_cli.core.effects.foot import turned
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.simulation.forces import foot_cops, pulled_apart, shares
from footcal_cli.core.simulation.gait import Motion
from footcal_cli.core.simulation.measure import Simulated, counted, measure
from footcal_cli.core.simulation.noise import (
    CELL_NOISE,
    FORCE_NOISE,
    QUIET,
    TORQUE_NOISE,
    SimulatedNoise,
    stream,
)
from footcal_cli.core.simulation.robots import Biped

MotionAt = Callable[[FloatArray], Motion]
"""The motion at any stamps."""
Known = Mapping[str, FloatArray]


_PACKET_S = 5e-4
"""Shortest time between two stamps of the body's telemetry."""


@dataclass(frozen=True)
class Streams:
    """How the two streams of a biped are sampled.

    Parameters
    ----------
    cell_rate_hz, body_rate_hz
        HX711 cells; body telemetry.
    body_delay_s, body_jitter_s
        Time between a body sample and its stamp: mean and sd.
    cell_noise, force_noise, torque_noise
        Of each cell, N; of each axis of an ankle transducer, N and Nm.
    com_noise_m, acc_noise_mps2, angmom_noise_nm
        White noise of the body stream.
    temperature_degc, warming_degc, warming_time_s
        Start, rise and time constant of the cells' temperature.
    """

    cell_rate_hz: float = 80.0
    body_rate_hz: float = 100.0
    body_delay_s: float = 0.020
    body_jitter_s: float = 0.004
    cell_noise: SimulatedNoise = CELL_NOISE
    force_noise: SimulatedNoise = FORCE_NOISE
    torque_noise: SimulatedNoise = TORQUE_NOISE
    com_noise_m: float = 2e-4
    acc_noise_mps2: float = 0.03
    angmom_noise_nm: float = 0.01
    temperature_degc: float = 22.0
    warming_degc: float = 4.0
    warming_time_s: float = 600.0

    def clock(self, duration_s: float) -> FloatArray:
        """Stamps of the sensors at the feet, shape (n,)."""
        return np.arange(float(int(duration_s * self.cell_rate_hz))) / self.cell_rate_hz

    def temperature_at(self, time_s: FloatArray) -> FloatArray:
        """Temperature of the cells, shape (n,)."""
        warmed = 1.0 - np.exp(-time_s / self.warming_time_s)
        return self.temperature_degc + self.warming_degc * warmed


@dataclass(frozen=True)
class Course:
    """What a biped does, and for how long.

    Parameters
    ----------
    experiment
        ``stand`` or ``walk``.
    loads_at
        True cell loads (n, c) at stamps, where a recorded motion brings its own; otherwise
        Newton and Euler.
    """

    experiment: str
    robot: Biped
    motion_at: MotionAt
    duration_s: float
    loads_at: Callable[[FloatArray], FloatArray] | None = None


@dataclass(frozen=True)
class BipedLogs:
    """The two streams of a biped.

    Parameters
    ----------
    cells
        Counts on the cells' clock, with what was true at the same stamps.
    body
        Body stream on its own clock, stamped on arrival; no channels.
    foot_m, foot_yaw_rad
        Believed foot frames on the body's rows, shapes (n, feet, 3) and (n, feet).
    """

    cells: Simulated
    body: Log
    foot_m: FloatArray
    foot_yaw_rad: FloatArray


def cell_positions(robot: Biped, foot_m: FloatArray, foot_yaw_rad: FloatArray) -> FloatArray:
    """Cell positions in the world, shape (n, c, 2)."""
    parts = []
    for i, foot in enumerate(robot.feet):
        x, y = robot.cells_m(foot).T
        parts.append(foot_m[:, i, None, :2] + turned(x, y, foot_yaw_rad[:, i, None]))
    return np.concatenate(parts, axis=1)


def known_of_motion(robot: Biped, motion: Motion) -> dict[str, FloatArray]:
    """What any robot says of its motion (`Log.known` of walking)."""
    rows = len(motion.time_s)
    return {
        "com_m": motion.com_m,
        "com_acc_mps2": motion.com_acc_mps2,
        "angmom_rate_nm": motion.angmom_rate_nm,
        "mass_kg": np.full(rows, robot.mass_kg),
        "gravity_mps2": np.full(rows, robot.gravity_mps2),
        "foot_yaw_rad": motion.foot_yaw_rad,
        "contact": motion.contact,
    }


def planned(course: Course, motion: Motion, streams: Streams, known: Known) -> Log:
    """The log of a robot's channels before anything is measured; `known` of its sensors."""
    robot, time_s = course.robot, motion.time_s
    warm = {"temperature_degc": streams.temperature_at(time_s)}
    return Log(
        course.experiment, robot.channels, time_s, np.zeros((time_s.size, len(robot.channels))),
        {**known_of_motion(robot, motion), **known, **warm}, motion.block,
    )  # fmt: skip


def ground_forces(robot: Biped, log: Log, motion: Motion, spread_m: FloatArray) -> FloatArray:
    """Cell loads (n, c) that obey [NAO], eqs. (9)–(11), exactly.

    Each foot takes the share of the load that its place demands (`foot_cops`), each cell the share
    of its foot (`shares`).
    """
    reference = dynamic_reference(
        log.known["com_m"],
        log.known["com_acc_mps2"],
        log.known["angmom_rate_nm"],
        log.known["mass_kg"],
        log.known["gravity_mps2"],
    )
    share, foot_cop = foot_cops(reference.cop_m, motion.foot_ref_m, motion.contact, spread_m)
    loads = np.zeros(log.readings.shape)
    of = robot.foot_of_channel
    for i in range(len(robot.feet)):
        cells = of == i
        carries = share[:, i] > 0.0
        arms = log.known["cell_pos_m"][carries][:, cells] - foot_cop[carries, i][:, None]
        carried = (share[:, i] * reference.fz_n)[carries, None]
        loads[np.ix_(carries, cells)] = carried * shares(arms)
    return loads


def biped_logs(
    course: Course,
    chain: Chain,
    values: Mapping[str, float],
    *,
    seed: int,
    streams: Streams | None = None,
    to_counts: bool = True,
) -> BipedLogs:
    """Both streams of a standing or walking biped.

    Parameters
    ----------
    to_counts
        Round and clip to the converter's counts (the chain must hold the calibration).
    """
    streams = streams or Streams()
    robot, motion = course.robot, course.motion_at(streams.clock(course.duration_s))
    spread = robot.room * pulled_apart(motion.time_s)
    at = {"cell_pos_m": cell_positions(robot, motion.foot_m, motion.foot_yaw_rad)}

    def loads(log: Log) -> FloatArray:
        if course.loads_at is not None:
            return course.loads_at(motion.time_s)
        return ground_forces(robot, log, motion, spread)

    cells = measure(
        planned(course, motion, streams, at), loads, chain, values,
        force_noise=streams.cell_noise, torque_noise=QUIET, rng=stream(seed, "cells"),
    )  # fmt: skip
    if to_counts:
        cells = replace(cells, log=counted(cells.log, robot))
    body, foot_m, foot_yaw = body_stream(course, chain, values, streams, seed)
    return BipedLogs(cells, body, foot_m, foot_yaw)


def body_stream(
    course: Course, chain: Chain, values: Mapping[str, float], streams: Streams, seed: int
) -> tuple[Log, FloatArray, FloatArray]:
    """The body's log on its own clock, stamped when it arrives."""
    rng = stream(seed, "body")
    rows = int(course.duration_s * streams.body_rate_hz)
    taken = (np.arange(float(rows)) + 0.37) / streams.body_rate_hz
    late = streams.body_delay_s + streams.body_jitter_s * rng.standard_normal(rows)
    # Samples arrive in order, one packet after the other.
    queue = _PACKET_S * np.arange(float(rows))
    stamped = np.maximum.accumulate(taken + np.maximum(late, 0.0) - queue) + queue
    motion = course.motion_at(taken)
    known = known_of_motion(course.robot, motion)
    for name, sd in (
        ("com_m", streams.com_noise_m),
        ("com_acc_mps2", streams.acc_noise_mps2),
        ("angmom_rate_nm", streams.angmom_noise_nm),
    ):
        known[name] = known[name] + sd * rng.standard_normal(known[name].shape)
    log = Log(
        course.experiment,
        (),
        taken,
        np.empty((rows, 0)),
        {**known, "foot_pos_m": motion.foot_m},
        motion.block,
    )
    streamed = Chain(
        tuple(i for i in chain.links if i.effect.stage in (Stage.BODY, Stage.TRANSPORT))
    )
    shown, _ = streamed.apply(log, values)
    body = Log(course.experiment, (), stamped, shown.readings, shown.known, shown.block)
    return body, body.known["foot_pos_m"], body.known["foot_yaw_rad"]


_LEAN_ON_ONE_FOOT, _LIFTED_M = 0.4, 0.02


@dataclass(frozen=True)
class StandPlan:
    """Quiet standing in several stances.

    Parameters
    ----------
    stances, stance_s
        How many on both feet, and how long each is logged.
    one_foot
        How many further stances on one foot, left and right in turn, the other foot lifted.
    replaced
        Whether the feet are put down anew in each stance.
    lean_m, squat_m
        How far the CoM is moved sideways and ahead, less over small feet, and down.
    toes_rad
        Angles by which both feet are turned out, in the stances by turns.
    """

    stances: int = 10
    stance_s: float = 6.0
    one_foot: int = 0
    replaced: bool = True
    lean_m: tuple[float, float] = (0.02, 0.03)
    squat_m: float = 0.04
    sway_m: float = 0.002
    heights: int = field(default=3)
    toes_rad: tuple[float, ...] = (0.0,)

    @property
    def duration_s(self) -> float:
        """Length of the log."""
        return (self.stances + self.one_foot) * self.stance_s


def standing_motion(robot: Biped, plan: StandPlan, seed: int) -> MotionAt:
    """The motion of quiet standing: one stance after the other, a small sway in each."""
    rng = stream(seed, "stances")
    n = plan.stances + plan.one_foot
    side = np.array([robot.half_width_m, -robot.half_width_m])
    moved = plan.replaced * robot.room * np.array([0.03, 0.02]) * rng.uniform(-1.0, 1.0, (n, 2, 2))
    moved[..., 1] = np.abs(moved[..., 1]) * np.sign(side)
    foot_xy = np.stack([np.zeros(2), side], axis=-1) + moved
    yaw = plan.replaced * 0.15 * rng.uniform(-1.0, 1.0, (n, 2))
    yaw = yaw + np.resize(np.asarray(plan.toes_rad), n)[:, None] * [1.0, -1.0]
    middle = np.array([robot.cells_m(foot).mean(axis=0) for foot in robot.feet])
    ref = foot_xy + turned(middle[:, 0], middle[:, 1], yaw)
    lean = robot.room * np.array(plan.lean_m) * rng.uniform(-1.0, 1.0, (n, 2))
    middle_m, contact = ref.mean(axis=1) + lean, np.ones((n, 2))
    alone = np.arange(plan.stances, n)
    standing_foot = (alone - plan.stances) % 2
    contact[alone, 1 - standing_foot] = 0.0
    middle_m[alone] = ref[alone, standing_foot] + _LEAN_ON_ONE_FOOT * lean[alone]
    height = robot.com_height_m - plan.squat_m * (np.arange(n) % plan.heights) / max(
        plan.heights - 1, 1
    )
    rate = 2.0 * np.pi * rng.uniform(0.15, 0.6, (n, 3, 3))
    phase = rng.uniform(0.0, 2.0 * np.pi, (n, 3, 3))
    size = plan.sway_m * np.array([1.0, 0.7, 0.2])[:, None] / 3.0

    def motion_at(time_s: FloatArray) -> Motion:
        stance = np.clip((time_s / plan.stance_s).astype(int), 0, n - 1)
        angle = rate[stance] * time_s[:, None, None] + phase[stance]
        centre = np.column_stack([middle_m, height])
        lifted_m = _LIFTED_M * (1.0 - contact)
        foot_m = np.concatenate([foot_xy, lifted_m[..., None]], axis=-1)
        return Motion(
            time_s=time_s,
            com_m=centre[stance] + (size * np.sin(angle)).sum(axis=-1),
            com_acc_mps2=-(size * rate[stance] ** 2 * np.sin(angle)).sum(axis=-1),
            angmom_rate_nm=np.zeros((len(time_s), 2)),
            foot_m=foot_m[stance],
            foot_yaw_rad=yaw[stance],
            foot_ref_m=ref[stance],
            contact=contact[stance],
            block=stance,
        )

    return motion_at
