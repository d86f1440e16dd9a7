"""Logs as laboratories keep them, X: more arms, simulators' printouts, treadmills, soles.

Written before it was run; `docs/bring_your_log.md` has its first count.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from tests.strangers.rigs import (
    Array,
    G,
    Made,
    Rng,
    Truth,
    cell,
    on_two_plates,
    rows,
    tool,
    tool_truth,
    truth_of,
    wrist,
    write,
)


def kinova_feedback(to: Path, rng: Rng) -> Made:
    """Kinova's base feedback: pose of the tool with angles theta in degrees, wrench of the tool."""
    made, wrench, rot = wrist(rng)
    place = np.tile([[0.4], [0.1], [0.5]], len(wrench))
    names = ["frame_id", *(f"tool_pose_{a}" for a in "xyz"),
             *(f"tool_pose_theta_{a}" for a in "xyz"),
             *(f"sensor_wrench_force_{a}" for a in "xyz"),
             *(f"sensor_wrench_torque_{a}" for a in "xyz")]  # fmt: skip
    body = rows(np.arange(len(wrench)), *place, *rot.as_euler("xyz", degrees=True).T, *wrench.T,
                form="%.6g")  # fmt: skip
    return Made([write(to / "feedback.csv", [",".join(names), *body])], tool_truth(made))


def xarm_report(to: Path, rng: Rng) -> Made:
    """xArm: roll, pitch, yaw in degrees; raw forces beside forces without the tool."""
    made, wrench, rot = wrist(rng)
    free = rng.normal(0, 0.03, wrench.shape)
    names = ["t", "x", "y", "z", "roll", "pitch", "yaw",
             *(f"ft_ext_{a}" for a in ("fx", "fy", "fz", "tx", "ty", "tz")),
             *(f"ft_raw_{a}" for a in ("fx", "fy", "fz", "tx", "ty", "tz"))]  # fmt: skip
    place = np.tile([[300.0], [0.0], [200.0]], len(wrench))
    body = rows(0.01 * np.arange(len(wrench)), *place, *rot.as_euler("xyz", degrees=True).T,
                *free.T, *wrench.T, form="%.5f")  # fmt: skip
    return Made([write(to / "xarm.csv", [",".join(names), *body])], tool_truth(made))


def yaskawa_pulse(to: Path, rng: Rng) -> Made:
    """Yaskawa: Rx, Ry, Rz in degrees about fixed axes, tabs, a job's name in each row."""
    made, wrench, rot = wrist(rng)
    lines = ["JOB\tX[mm]\tY[mm]\tZ[mm]\tRx[deg]\tRy[deg]\tRz[deg]\tFx[N]\tFy[N]\tFz[N]\t"
             "Mx[Nm]\tMy[Nm]\tMz[Nm]"]  # fmt: skip
    angle = rot.as_euler("xyz", degrees=True)
    for a, w in zip(angle, wrench, strict=True):
        lines.append("\t".join(["FTCAL", "800.0", "12.0", "400.0",
                                *(f"{v:.4f}" for v in (*a, *w))]))  # fmt: skip
    return Made([write(to / "motoman.txt", lines)], tool_truth(made))


def flexiv_states(to: Path, rng: Rng) -> Made:
    """Flexiv: a pose of seven numbers, scalar first, lists of the raw sensor in brackets."""
    made, wrench, rot = wrist(rng)
    q = np.roll(rot.as_quat(), 1, axis=1)
    lines = ["tcp_pose;ft_sensor_raw"]
    for a, w in zip(q, wrench, strict=True):
        pose = ", ".join(f"{v:.6f}" for v in (0.5, 0.1, 0.4, *a))
        lines.append(f"[{pose}];[{', '.join(f'{v:.5f}' for v in w)}]")
    return Made([write(to / "rizon.csv", lines)], tool_truth(made))


def ur_record(to: Path, rng: Rng) -> Made:
    """Universal Robots' `record.py`: blanks, `actual_TCP_pose_0` …, a raw wrench in the flange."""
    made, wrench, rot = wrist(rng)
    place = np.tile([[0.3], [-0.2], [0.5]], len(wrench))
    names = ["timestamp", *(f"actual_TCP_pose_{i}" for i in range(6)),
             *(f"ft_raw_wrench_{i}" for i in range(6))]  # fmt: skip
    body = rows(0.002 * np.arange(len(wrench)), *place, *rot.as_rotvec().T, *wrench.T, sep=" ",
                form="%.7f")  # fmt: skip
    return Made([write(to / "robot_data.csv", [" ".join(names), *body])], tool_truth(made))


def gz_topic_echo(to: Path, rng: Rng) -> Made:
    """`gz topic -e`: messages as nested blocks of braces, without an attitude."""
    _, wrench, _ = wrist(rng)
    lines = []
    for w in wrench[:40]:
        lines += ["force {", *(f"  {a}: {v:.5f}" for a, v in zip("xyz", w[:3], strict=True)), "}",
                  "torque {", *(f"  {a}: {v:.5f}" for a, v in zip("xyz", w[3:], strict=True)),
                  "}", ""]  # fmt: skip
    return Made([write(to / "ft.txt", lines)], says="attitude")


def isaac_tensors(to: Path, rng: Rng) -> Made:
    """Torch's print of a step: `tensor([[…]])`, wrench and quaternion (w first) on a line."""
    made, wrench, rot = wrist(rng, hold=6)
    q = np.roll(rot.as_quat(), 1, axis=1)
    lines = []
    for i, (w, a) in enumerate(zip(wrench, q, strict=True)):
        force = ", ".join(f"{v:.5f}" for v in w)
        turn = ", ".join(f"{v:.6f}" for v in a)
        lines.append(f"step {i} wrench tensor([[{force}]]) quat tensor([[{turn}]])")
    return Made([write(to / "rollout.txt", lines)], tool_truth(made))


def slashes_in_names(to: Path, rng: Rng) -> Made:
    """rqt's export: topics with slashes and indices as names, seconds as stamps."""
    made, wrench, rot = wrist(rng)
    names = ["__time", *(f"/arm/ft/wrench/force/{a}" for a in "xyz"),
             *(f"/arm/ft/wrench/torque/{a}" for a in "xyz"),
             *(f"/arm/ee/pose/orientation/{a}" for a in "xyzw")]  # fmt: skip
    body = rows(1.7e9 + 0.01 * np.arange(len(wrench)), *wrench.T, *rot.as_quat().T, form="%.6f")
    return Made([write(to / "export.csv", [",".join(names), *body])], tool_truth(made))


def six_legs_hung(to: Path, rng: Rng) -> Made:
    """A hexapod in a frame that turns: six transducers, `L1_Fx`, the frame's roll and pitch."""
    rolls = np.repeat(np.linspace(0, 2 * np.pi, 10, endpoint=False), 20)
    pitch = np.repeat(rng.uniform(-0.6, 0.6, 10), 20)
    rot = Rotation.from_euler("xyz", np.column_stack([rolls, pitch, 0 * rolls]))
    down = -rot.as_matrix()[:, 2, :]
    names, columns, truth = ["t", "frame_roll_deg", "frame_pitch_deg"], list[Array](), Truth()
    for leg, ours in zip(("LF", "LM", "LH", "RF", "RM", "RH"), ("fl", "ml", "hl", "fr", "mr", "hr"),
                         strict=True):  # fmt: skip
        made = tool(rng)
        columns += list(made.read(down, rng).T)
        names += [f"{leg}_{a}" for a in ("Fx", "Fy", "Fz", "Tx", "Ty", "Tz")]
        part = tool_truth(made, ours)
        truth = Truth({**truth.values, **part.values}, {**truth.within, **part.within})
    body = rows(0.05 * np.arange(len(rolls)), np.degrees(rolls), np.degrees(pitch), *columns,
                form="%.6g")  # fmt: skip
    return Made([write(to / "frame.csv", [",".join(names), *body])], truth)


def motek_dflow(to: Path, rng: Rng) -> Made:
    """D-Flow of a treadmill: `FP1.CopX`, `FP1.ForY` upwards, two belts, tabs."""
    fz = on_two_plates(75.0, (1.03, 0.97), rng)
    n = fz.shape[1]
    names, columns = ["TimeStamp", "FrameNumber"], [np.arange(n) / 50, np.arange(n, dtype=float)]
    for plate, force in zip(("FP1", "FP2"), fz, strict=True):
        cop = rng.normal(0, 0.004, (2, n))
        quiet = rng.normal(0, 0.5, (2, n))
        names += [f"{plate}.{a}" for a in ("CopX", "CopY", "CopZ", "ForX", "ForY", "ForZ")]
        columns += [cop[0], np.zeros(n), cop[1], quiet[0], force, quiet[1]]
    body = rows(*columns, sep="\t", form="%.6f")
    return Made([write(to / "mocap_module.txt", ["\t".join(names), *body])], says="weigh")


def naoqi_paths(to: Path, rng: Rng) -> Made:
    """NAO's memory keys as names, eight cells in kilograms, no stamps."""
    n = 300
    keys = [f"Device/SubDeviceList/{s}Foot/FSR/{c}/Sensor/Value" for s in "LR"
            for c in ("FrontLeft", "FrontRight", "RearLeft", "RearRight")]  # fmt: skip
    body = rows(*rng.normal(0.66, 0.02, (8, n)), form="%.4f")
    return Made([write(to / "memory.csv", [",".join(keys), *body])], says="weigh")


def bipedal_soles_pads(to: Path, rng: Rng) -> Made:
    """An insole of sixteen pads a side, `L0 … L15`: no cells to calibrate one by one."""
    n = 200
    names = ["ms", *(f"{s}{i}" for s in "LR" for i in range(16))]
    body = rows(10.0 * np.arange(n), *rng.integers(100, 900, (32, n)).astype(float), form="%.0f")
    return Made([write(to / "pads.csv", [",".join(names), *body])], says="weigh")


def one_foot_on_a_bench(to: Path, rng: Rng) -> Made:
    """A foot of four cells, each loaded alone, its corner named in the row: `toe-left` …"""
    cells = {name: cell(rng) for name in ("fl", "fr", "rl", "rr")}
    spoken = {"fl": "toe-left", "fr": "toe-right", "rl": "heel-left", "rr": "heel-right"}
    lines = ["corner,kg,adc"]
    for name, one in cells.items():
        for kg in (0.0, 0.5, 1.0, 2.0):
            for c in one.read(np.full(3, kg * G), rng):
                lines.append(f"{spoken[name]},{kg:g},{c:.0f}")
    named = {spoken[name]: one for name, one in cells.items()}
    return Made([write(to / "corners.csv", lines)], truth_of(named))


def wrench_in_columns_of_a_sheet(to: Path, rng: Rng) -> Made:
    """Poses by hand: roll and pitch of a vise in degrees, six numbers of a display."""
    made, wrench, _ = wrist(rng, poses=14, hold=1)
    roll, pitch = rng.uniform(-180, 180, 14), rng.uniform(-80, 80, 14)
    rot = Rotation.from_euler("xyz", np.column_stack([roll, pitch, 0 * roll]), degrees=True)
    wrench = made.read(-rot.as_matrix()[:, 2, :], rng)
    lines = ["Rollwinkel [°];Nickwinkel [°];Fx [N];Fy [N];Fz [N];Mx [Nm];My [Nm];Mz [Nm]"]
    lines += [x.replace(".", ",") for x in rows(roll, pitch, *wrench.T, sep=";", form="%.4f")]
    return Made([write(to / "schraubstock.csv", lines)], tool_truth(made))


def quadruped_mit_feet(to: Path, rng: Rng) -> Made:
    """A dog's estimator: contact forces as `f_0_z` … `f_3_z`, contacts, a base quaternion."""
    n = 300
    names = ["t", *(f"q_{a}" for a in "wxyz"), *(f"f_{i}_{a}" for i in range(4) for a in "xyz"),
             *(f"contact_{i}" for i in range(4))]  # fmt: skip
    force = np.vstack([rng.normal((0, 0, 29)[k % 3], 0.5, n) for k in range(12)])
    body = rows(np.arange(n) / 500, np.ones(n), *np.zeros((3, n)), *force, *np.ones((4, n)),
                form="%.4f")  # fmt: skip
    return Made([write(to / "mini.csv", [",".join(names), *body])], says="weigh")


FOURTEENTH_ROBOTS = (
    kinova_feedback, xarm_report, yaskawa_pulse, flexiv_states, ur_record, gz_topic_echo,
    isaac_tensors, slashes_in_names, six_legs_hung, motek_dflow, naoqi_paths, bipedal_soles_pads,
    one_foot_on_a_bench, wrench_in_columns_of_a_sheet, quadruped_mit_feet,
)  # fmt: skip
