"""Standing and walking on six-axis transducers at the ankles: wrenches by Newton and Euler."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from footcal_cli.core.centroidal import dynamic_reference
from footcal_cli.core.chain import Chain
from footcal_cli.core.experiments.walk import applied_below
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.simulation.biped_logs import Course, Streams, body_stream, planned
from footcal_cli.core.simulation.forces import foot_cops, pulled_apart
from footcal_cli.core.simulation.gait import Motion
from footcal_cli.core.simulation.measure import Simulated, measure
from footcal_cli.core.simulation.noise import stream
from footcal_cli.core.simulation.robots import Biped


@dataclass(frozen=True)
class AnkleLogs:
    """The two streams of a biped on ankle transducers.

    Parameters
    ----------
    wrenches
        On the transducers' clock, with what was true at the same stamps.
    body
        Body stream on its own clock, stamped on arrival; no channels.
    foot_m, foot_quaternion
        Believed foot frames on the body's rows, shapes (n, feet, 3) and (n, feet, 4), x y z w.
    """

    wrenches: Simulated
    body: Log
    foot_m: FloatArray
    foot_quaternion: FloatArray


def ankle_logs(
    course: Course, chain: Chain, values: Mapping[str, float], *, seed: int, streams: Streams
) -> AnkleLogs:
    """Ankle wrenches of a robot whose soles stay flat, in N and Nm, and its body stream.

    Parameters
    ----------
    chain, values
        Offsets and effects.
    """
    robot, motion = course.robot, course.motion_at(streams.clock(course.duration_s))
    foot_m, foot_rot = _foot_frames(robot, motion.foot_m, motion.foot_yaw_rad)
    at = _transducers(robot, motion.time_s, foot_m, foot_rot, moving=course.experiment == "walk")
    done = measure(
        planned(course, motion, streams, at),
        lambda log: ground_wrenches(log, motion, robot.room), chain, values,
        force_noise=streams.force_noise, torque_noise=streams.torque_noise,
        rng=stream(seed, "ankles"),
    )  # fmt: skip
    together = replace(streams, body_rate_hz=streams.cell_rate_hz, body_jitter_s=0.0)
    body, sole_m, yaw = body_stream(course, chain, values, together, seed)
    at_m, rot = _foot_frames(robot, sole_m, yaw)
    quaternion = Rotation.from_matrix(rot.reshape(-1, 3, 3)).as_quat()
    return AnkleLogs(done, body, at_m, quaternion.reshape(*yaw.shape, 4))


def _foot_frames(
    robot: Biped, sole_m: FloatArray, yaw_rad: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Origin (n, feet, 3) and axes (n, feet, 3, 3) of the feet's frames, from their soles."""
    ankles = robot.ankles.values()
    turn = yaw_rad.ravel()[:, None] * np.array([0.0, 0.0, 1.0])
    heading = Rotation.from_rotvec(turn).as_matrix().reshape(*yaw_rad.shape, 3, 3)
    flat = np.stack([ankle.rot_flat for ankle in ankles])
    above = np.array([[0.0, 0.0, ankle.frame_height_m] for ankle in ankles])
    return sole_m + above, np.einsum("nkij,kjl->nkil", heading, flat)


def _transducers(
    robot: Biped, time_s: FloatArray, foot_m: FloatArray, foot_rot: FloatArray, *, moving: bool
) -> dict[str, FloatArray]:
    """Where the transducers are and what hangs below them (`SIX_AXIS_KNOWN` of walking).

    Standing, the feet are put down anew while nobody looks: they accelerate only where `moving`.
    """
    ankles, n = robot.ankles.values(), len(time_s)
    place = np.array([ankle.position_m for ankle in ankles])
    rot = np.einsum("nkij,kjl->nkil", foot_rot, np.stack([a.rot_fs for a in ankles]))
    com = np.array([ankle.com_below_m for ankle in ankles])
    pos = foot_m + np.einsum("nkij,kj->nki", foot_rot, place)
    hanging = pos + np.einsum("nkij,kj->nki", rot, com)
    return {
        "foot_rot_wt": rot,
        "foot_pos_m": pos,
        "foot_weight_n": np.tile([ankle.weight_below_n for ankle in ankles], (n, 1)),
        "foot_com_m": np.tile(com, (n, 1, 1)),
        # differences of differences: smooth enough to be moved in time by parts of a sample
        "foot_acc_mps2": np.gradient(np.gradient(hanging, time_s, axis=0), time_s, axis=0)
        if moving
        else np.zeros_like(hanging),
    }


def ground_wrenches(log: Log, motion: Motion, room: float = 1.0) -> FloatArray:
    """Wrenches (n, 6 feet) that obey the six-axis balance exactly, in each transducer's frame.

    ``f_k = s_k m (c̈ + g)`` acts at the foot's CoP p_k with ``Σ s_k p_k`` the CoP that the motion
    demands ([NAO], eqs. (9)–(11)); what hangs below a transducer is added.

    Parameters
    ----------
    room
        Of the feet, relative to a NAO's (`Biped.room`).
    """
    known = log.known
    reference = dynamic_reference(
        known["com_m"], known["com_acc_mps2"], known["angmom_rate_nm"],
        known["mass_kg"], known["gravity_mps2"],
    )  # fmt: skip
    spread = room * pulled_apart(log.time_s)
    share, cop = foot_cops(reference.cop_m, motion.foot_ref_m, motion.contact, spread)
    whole = known["com_acc_mps2"].copy()
    whole[:, 2] += known["gravity_mps2"]
    force = share[..., None] * (known["mass_kg"][:, None] * whole)[:, None]
    point = np.concatenate([cop, np.zeros((*cop.shape[:2], 1))], axis=-1)
    moment = np.cross(point - known["foot_pos_m"], force)
    back = known["foot_rot_wt"].transpose(0, 1, 3, 2)
    wrench = np.concatenate(
        [np.einsum("nkij,nkj->nki", back, force), np.einsum("nkij,nkj->nki", back, moment)], axis=-1
    )
    wrench += applied_below(log, known["foot_weight_n"])
    return np.asarray(wrench.reshape(len(log), -1))
