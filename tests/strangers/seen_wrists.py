"""Two thirds of the corpus, II: six-axis transducers with what hangs on them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tests.strangers.rigs import (
    Array,
    Made,
    Rng,
    Tool,
    attitudes,
    rows,
    tool,
    tool_truth,
    write,
)

ROS = [f"field.wrench.{k}.{a}" for k in ("force", "torque") for a in "xyz"]


def _wrist(rng: Rng, hold: int = 25, poses: int = 12) -> tuple[Tool, Array, Array, Array, Array]:
    from scipy.spatial.transform import Rotation

    made = tool(rng)
    rot, rpy = attitudes(rng, poses, hold)
    return made, made.read(-rot[:, 2, :], rng), rot, rpy, Rotation.from_matrix(rot).as_quat()


def wrist_quaternion(to: Path, rng: Rng) -> Made:
    made, wrench, _, _, q = _wrist(rng)
    t = np.arange(len(q)) * 0.01
    head = "time,fx,fy,fz,tx,ty,tz,qx,qy,qz,qw"
    return Made([write(to / "wrist.csv", [head, *rows(t, *wrench.T, *q.T)])], tool_truth(made))


def wrist_rpy_degrees(to: Path, rng: Rng) -> Made:
    made, wrench, _, rpy, _ = _wrist(rng)
    t = np.arange(len(rpy)) * 10.0
    head = "t_ms;Fx_N;Fy_N;Fz_N;Mx_Nm;My_Nm;Mz_Nm;roll_deg;pitch_deg;yaw_deg"
    return Made(
        [write(to / "tool.csv", [head, *rows(t, *wrench.T, *np.degrees(rpy).T, sep=";")])],
        tool_truth(made),
    )


def wrist_matrix(to: Path, rng: Rng) -> Made:
    made, wrench, rot, _, _ = _wrist(rng)
    t = np.arange(len(rot)) * 0.008
    head = ",".join(
        [
            "time_s",
            *(f"force_{a}" for a in "xyz"),
            *(f"torque_{a}" for a in "xyz"),
            *(f"r{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3)),
        ]
    )
    return Made(
        [write(to / "flange.csv", [head, *rows(t, *wrench.T, *rot.reshape(-1, 9).T)])],
        tool_truth(made),
    )


def ros_wrench_with_pose(to: Path, rng: Rng) -> Made:
    made, wrench, _, _, q = _wrist(rng)
    ns = 1_700_000_000_000_000_000 + np.arange(len(q)) * 8_000_000
    head = ",".join(["%time", *ROS, *(f"field.pose.orientation.{a}" for a in "xyzw")])
    lines = [
        f"{n}," + ",".join(f"{v:.8g}" for v in (*w, *o))
        for n, w, o in zip(ns, wrench, q, strict=True)
    ]
    return Made([write(to / "_ft_sensor.csv", [head, *lines])], tool_truth(made))


def ros_wrench_alone(to: Path, rng: Rng) -> Made:
    _, wrench, _, _, _ = _wrist(rng)
    t0 = 1_600_000_000_000_000_000
    head = ",".join(["%time", *(f"field.header.{h}" for h in ("seq", "stamp", "frame_id")), *ROS])
    lines = [
        f"{t0 + i * 8_000_000},{i},{t0 + i * 8_000_000},wrist," + ",".join(f"{v:.6g}" for v in w)
        for i, w in enumerate(wrench)
    ]
    return Made([write(to / "ur3_wrench.csv", [head, *lines])], says="attitude")


def netft_torque_first(to: Path, rng: Rng) -> Made:
    _, wrench, _, _, _ = _wrist(rng)
    swapped = np.hstack([wrench[:, 3:], wrench[:, :3]])
    return Made(
        [write(to / "netft.txt", ["Tx Ty Tz Fx Fy Fz", *rows(*swapped.T, sep=" ")])],
        says="attitude",
    )


def orientations_named(to: Path, rng: Rng) -> Made:
    made = tool(rng)
    axes = {
        "+x": (1, 0, 0),
        "-x": (-1, 0, 0),
        "+y": (0, 1, 0),
        "-y": (0, -1, 0),
        "+z": (0, 0, 1),
        "-z": (0, 0, -1),
    }
    lines, t = [], 0.0
    for name, g in axes.items():
        for w in made.read(np.tile(np.array(g, float), (60, 1)), rng):
            lines.append(f"{t:.3f},{name}," + ",".join(f"{v:.6g}" for v in w))
            t += 0.01
    return Made(
        [write(to / "flip.csv", ["t_s,orientation,Fx,Fy,Fz,Tx,Ty,Tz", *lines])], tool_truth(made)
    )


SEEN_WRISTS = (
    wrist_quaternion, wrist_rpy_degrees, wrist_matrix, ros_wrench_with_pose, ros_wrench_alone,
    netft_torque_first, orientations_named,
)  # fmt: skip
