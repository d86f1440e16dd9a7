"""Logs as tools write them, II: motion laboratories, arms, walking robots.

Each shape was written down before it was run for the first time.
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from tests.strangers.rigs import (
    Array,
    G,
    Made,
    Rng,
    Tool,
    Truth,
    attitudes,
    cell,
    filled,
    rows,
    settling,
    tool,
    tool_truth,
    truth_of,
    write,
)

AXES = np.vstack([np.eye(3), -np.eye(3)])


def _wrist(rng: Rng, poses: int = 12, hold: int = 25) -> tuple[Tool, Array, Rotation]:
    """Tool, wrenches, attitudes of the sensor (body to world)."""
    made = tool(rng)
    rot, _ = attitudes(rng, poses, hold)
    return made, made.read(-rot[:, 2, :], rng), Rotation.from_matrix(rot)


def qualisys_plate_weights(to: Path, rng: Rng) -> Made:
    """QTM's TSV of a force plate, a file per mass: keys and values above, CoP in mm."""
    paths, gain = [], 1.05
    for kg in (0, 5, 10, 20):
        n = 300
        fz = rng.normal(0, 0.3, n) + (kg * G - 4.0) / gain
        other = rng.normal(0, 0.1, (5, n))
        head = [
            f"NO_OF_SAMPLES\t{n}", "FREQUENCY\t1000", "DESCRIPTION\t--",
            "TIME_STAMP\t2024-03-11, 10:11:12", "FIRST_SAMPLE\t1",
            "FORCE_PLATE_NAME\tForce-plate 1", "FORCE_PLATE_TYPE\tKistler",
            "FORCE_PLATE_LENGTH\t600.000000", "FORCE_PLATE_WIDTH\t400.000000",
            "SAMPLE\tTIME\tForce_X\tForce_Y\tForce_Z\tMoment_X\tMoment_Y\tMoment_Z"
            "\tCOP_X\tCOP_Y\tCOP_Z",
        ]  # fmt: skip
        t = np.arange(n) / 1000
        body = rows(np.arange(1.0, n + 1), t, other[0], other[1], fz, *other[2:],
                    *rng.normal(20, 2, (2, n)), np.zeros(n), sep="\t", form="%.6f")  # fmt: skip
        paths.append(write(to / f"plate_{kg}kg_f_1.tsv", [*head, *body]))
    return Made(paths, truth_of(type(cell(rng))(gain, 4.0, 0.3), 200))


def bioware_points(to: Path, rng: Rng) -> Made:
    """Kistler BioWare: a rod pressed on known points, CoP as Ax and Ay; the points in a table."""
    lines = ["point,x [mm],y [mm],Fz [N],Ax [mm],Ay [mm]"]
    for i, x in enumerate((-200, -100, 0, 100, 200)):
        for j, y in enumerate((-150, 0, 150)):
            ax, ay = 1.02 * x + 4 + rng.normal(0, 0.3), 0.98 * y - 3 + rng.normal(0, 0.3)
            lines.append(f"P{i}{j},{x},{y},{rng.normal(500, 5):.2f},{ax:.3f},{ay:.3f}")
    return Made([write(to / "points.csv", lines)], cop_within_m=1.5e-3)


def visual3d_ascii(to: Path, rng: Rng) -> Made:
    """Visual3D's export of a quiet trial per mass: names spread over rows of the header."""
    paths, gain = [], 1.04
    for kg in (0, 5, 10, 20):
        n = 200
        fz = rng.normal(0, 0.3, n) + (kg * G - 2.0) / gain
        file = f"c:\\data\\w{kg}.c3d"
        head = ["\t" + "\t".join([file] * 6), "\tFP1\tFP1\tFP1\tFP1\tFP1\tFP1",
                "\tFORCE\tFORCE\tFORCE\tMOMENT\tMOMENT\tMOMENT", "\t" + "\t".join(["ORIGINAL"] * 6),
                "ITEM\tX\tY\tZ\tX\tY\tZ"]  # fmt: skip
        body = rows(np.arange(1.0, n + 1), *rng.normal(0, 0.1, (2, n)), fz,
                    *rng.normal(0, 0.1, (3, n)), sep="\t", form="%.5f")  # fmt: skip
        paths.append(write(to / f"w{kg}kg.txt", [*head, *body]))
    return Made(paths, truth_of(type(cell(rng))(gain, 2.0, 0.3), 200))


def opensim_grf(to: Path, rng: Rng) -> Made:
    """OpenSim's ground reactions: y points up, two plates, points of application."""
    n = 400
    names, data = ["time"], [np.arange(n) / 1000]
    for prefix in ("", "1_"):
        names += [f"{prefix}ground_force_v{a}" for a in "xyz"]
        data += [rng.normal(0, 1, n), rng.normal(360, 2, n), rng.normal(0, 1, n)]
        names += [f"{prefix}ground_force_p{a}" for a in "xyz"]
        data += [rng.normal(0.1, 0.002, n), np.zeros(n), rng.normal(0.2, 0.002, n)]
        names += [f"{prefix}ground_torque_{a}" for a in "xyz"]
        data += [np.zeros(n), rng.normal(0, 0.1, n), np.zeros(n)]
    head = ["subject01_grf.mot", "version=1", f"nRows={n}", f"nColumns={len(names)}",
            "inDegrees=yes", "endheader", "\t".join(names)]  # fmt: skip
    return Made([write(to / "grf.mot", [*head, *rows(*data, sep="\t")])], says="weigh")


def plotjuggler_sparse(to: Path, rng: Rng) -> Made:
    """PlotJuggler's table of two topics: a cell is empty where the other topic spoke."""
    made, wrench, rot = _wrist(rng)
    quat = rot.as_quat()
    names = ["__time"]
    names += [f"/bota/wrench/wrench/{k}/{a}" for k in ("force", "torque") for a in "xyz"]
    names += [f"/bota/imu/orientation/{a}" for a in "xyzw"]
    lines = [",".join(names)]
    for i, (w, q) in enumerate(zip(wrench, quat, strict=True)):
        t = 1_700_000_000 + 0.01 * i
        lines.append(f"{t:.6f}," + ",".join(f"{v:.6g}" for v in w) + ",,,,")
        lines.append(f"{t + 0.003:.6f},,,,,,," + ",".join(f"{v:.8f}" for v in q))
    return Made([write(to / "plotjuggler.csv", lines)], tool_truth(made))


def ur_rtde_rotation_vector(to: Path, rng: Rng) -> Made:
    """UR's recorder: blanks, an attitude as rotation vector, the wrench of the flange sensor."""
    made, wrench, rot = _wrist(rng)
    vector = rot.as_rotvec()
    names = ["timestamp", *(f"actual_TCP_pose_{i}" for i in range(6)),
             *(f"ft_raw_wrench_{i}" for i in range(6))]  # fmt: skip
    t = 1000 + np.arange(len(wrench)) * 0.008
    place = rng.normal(0.4, 0.01, (3, len(wrench)))
    lines = [" ".join(names), *rows(t, *place, *vector.T, *wrench.T, sep=" ", form="%.8g")]
    return Made([write(to / "robot_data.csv", lines)], tool_truth(made))


def franka_matrix(to: Path, rng: Rng) -> Made:
    """Franka: the flange as sixteen numbers, column by column, beside a wrench."""
    made, wrench, rot = _wrist(rng)
    names = ["time", *(f"O_T_EE[{i}]" for i in range(16)), *(f"ft_wrench[{i}]" for i in range(6))]
    matrix = np.zeros((len(wrench), 4, 4))
    matrix[:, :3, :3], matrix[:, 3, 3] = rot.as_matrix(), 1.0
    matrix[:, :3, 3] = [0.4, 0.1, 0.5]
    flat = np.swapaxes(matrix, 1, 2).reshape(-1, 16)
    lines = [",".join(names), *rows(np.arange(len(wrench)) * 1e-3, *flat.T, *wrench.T)]
    return Made([write(to / "franka_state.csv", lines)], tool_truth(made))


def sides_in_comments(to: Path, rng: Rng) -> Made:
    """An ATI console log: which axis points down is typed as a comment between the rows."""
    made = tool(rng)
    lines = ["# ATI Mini45, bias not set", "t,Fx,Fy,Fz,Tx,Ty,Tz"]
    i = 0
    for name, g in zip(("+X", "+Y", "+Z", "-X", "-Y", "-Z"), AXES, strict=True):
        lines.append(f"# {name} down")
        for w in made.read(np.tile(g, (80, 1)), rng):
            lines.append(f"{i / 100:.2f}," + ",".join(f"{v:.5f}" for v in w))
            i += 1
    return Made([write(to / "mini45.csv", lines)], tool_truth(made))


def turned_by_hand(to: Path, rng: Rng) -> Made:
    """A sensor with an IMU, turned by hand between holds; nothing says when it was still."""
    made = tool(rng)
    attitude, _ = attitudes(rng, 10, 1)
    keys = Rotation.from_matrix(attitude)
    parts = []
    for a, b in pairwise(keys):
        parts.append(Rotation.concatenate([a] * 150))
        turn = (a.inv() * b).as_rotvec()
        s = np.linspace(0, 1, 100)
        parts.append(a * Rotation.from_rotvec((3 * s**2 - 2 * s**3)[:, None] * turn))
    rot = Rotation.concatenate([*parts, Rotation.concatenate([keys[-1]] * 150)])
    up = rot.inv().apply([0.0, 0.0, 1.0])
    wrench = made.read(-up, rng)
    # a hand at work: forces of the turning, not of the weight
    moving = np.linalg.norm(np.diff(up, axis=0, prepend=up[:1]), axis=1) > 1e-6
    wrench[moving] += rng.normal(0, 2.0, (int(moving.sum()), 6)) * [1, 1, 1, 0.1, 0.1, 0.1]
    lines = ["t_s,fx,fy,fz,tx,ty,tz,qx,qy,qz,qw",
             *rows(np.arange(len(up)) * 0.01, *wrench.T, *rot.as_quat().T)]  # fmt: skip
    return Made([write(to / "by_hand.csv", lines)], tool_truth(made))


def unitree_lowstate(to: Path, rng: Rng) -> Made:
    """Unitree's low state: ticks in ms, four feet as whole numbers, FR first, IMU beside."""
    n = 600
    names = ["tick", *(f"imuState.quaternion[{i}]" for i in range(4))]
    names += [f"imuState.accelerometer[{i}]" for i in range(3)]
    names += [f"{name}[{i}]" for name in ("footForce", "footForceEst") for i in range(4)]
    feet = np.round(rng.normal(120, 2, (4, n)))
    data = [123456 + 2.0 * np.arange(n), np.ones(n), *np.zeros((3, n)), *np.zeros((2, n)),
            np.full(n, 9.81), *feet, *np.zeros((4, n))]  # fmt: skip
    return Made([write(to / "lowstate.csv", [",".join(names), *rows(*data)])], says="weigh")


def anymal_long(to: Path, rng: Rng) -> Made:
    """ANYmal: one row per foot and stamp, three axes in the world's frame."""
    lines = ["stamp_ns,foot,force_x,force_y,force_z,in_contact"]
    for i in range(200):
        for foot in ("LF_FOOT", "RF_FOOT", "LH_FOOT", "RH_FOOT"):
            f = rng.normal([0, 0, 125], [1, 1, 2])
            lines.append(f"{1_700_000_000_000_000_000 + i * 2_500_000},{foot},"
                         + ",".join(f"{v:.3f}" for v in f) + ",1")  # fmt: skip
    return Made([write(to / "contacts.csv", lines)], says="weigh")


def spot_two_ankles_bagpy(to: Path, rng: Rng) -> Made:
    """bagpy: a file per topic, both ankles of a biped, header stamps in two columns."""
    paths, n = [], 400
    for side, ns in (("left", 0), ("right", 400_000)):
        names = ["Time", "header.seq", "header.stamp.secs", "header.stamp.nsecs",
                 "header.frame_id", *(f"wrench.{k}.{a}" for k in ("force", "torque")
                                      for a in "xyz")]  # fmt: skip
        lines = [",".join(names)]
        for i in range(n):
            total = i * 5_000_000 + ns
            w = rng.normal([0, 0, 190, 0, 0, 0], [1, 1, 2, 0.1, 0.1, 0.1])
            lines.append(
                f"{1_700_000_000 + total * 1e-9:.6f},{i},{1_700_000_000 + total // 10**9},"
                f"{total % 10**9},{side}_sole," + ",".join(f"{v:.6g}" for v in w)
            )
        paths.append(write(to / f"{side}_ankle_ft.csv", lines))
    return Made(paths, says="weigh")


def insole_force_and_cop(to: Path, rng: Rng) -> Made:
    """Pedar-like: total force and CoP of each foot, tabs, two lines of remarks."""
    n = 500
    head = ["file name:\tS03_walk.sol", "sensor type:\tinsole", "",
            "time[secs]\tleft force[N]\tleft x[mm]\tleft y[mm]\tright force[N]\tright x[mm]"
            "\tright y[mm]"]  # fmt: skip
    data = [np.arange(n) / 50]
    for _ in "LR":
        data += [rng.normal(360, 4, n), rng.normal(35, 1, n), rng.normal(120, 3, n)]
    return Made([write(to / "pedar.txt", [*head, *rows(*data, sep="\t", form="%.2f")])],
                says="weigh")  # fmt: skip


def plates_under_each_foot(to: Path, rng: Rng) -> Made:
    """Two plates of an estimator: only Fz and CoP in m, the mass known to the person."""
    share = settling([0.3, 0.5, 0.7, 0.4, 0.6], 5, 100)
    n = share.size
    mass, gain = 70.0, (1.05, 0.97)
    left, right = share * mass * G, (1 - share) * mass * G
    data = [np.arange(n) / 100, left / gain[0] + rng.normal(0, 1, n), rng.normal(0.01, 1e-3, n),
            rng.normal(0.1, 1e-3, n), right / gain[1] + rng.normal(0, 1, n),
            rng.normal(0.01, 1e-3, n), rng.normal(-0.1, 1e-3, n)]  # fmt: skip
    head = "time_s,fz_left,cop_x_left,cop_y_left,fz_right,cop_x_right,cop_y_right"
    cells = {f"{side}_p{i}.scale": g for side, g in zip(("left", "right"), gain, strict=True)
             for i in (1, 2, 3)}  # fmt: skip
    truth = Truth(cells, dict.fromkeys(cells, 0.03))  # only sums are seen
    return Made([write(to / "plates.csv", [head, *rows(*data)])], truth, says="weigh",
                fill=filled(mass_kg=f"{mass}"))  # fmt: skip


def onrobot_counts_rpy(to: Path, rng: Rng) -> Made:
    """OnRobot HEX: forces in tenths of a newton as whole numbers, the arm's angles in degrees."""
    made, wrench, rot = _wrist(rng)
    rpy = np.degrees(rot.as_euler("xyz"))
    lines = ["# OnRobot HEX-E v2; unit of force 0.1 N, of torque 0.01 Nm",
             "sample;Fx [0.1 N];Fy [0.1 N];Fz [0.1 N];Tx [0.01 Nm];Ty [0.01 Nm];Tz [0.01 Nm];"
             "Rx [deg];Ry [deg];Rz [deg]"]  # fmt: skip
    lines += [f"{i};" + ";".join(f"{10 * v:.0f}" for v in w[:3]) + ";"
              + ";".join(f"{100 * v:.0f}" for v in w[3:]) + ";"
              + ";".join(f"{a:.3f}" for a in angle)
              for i, (w, angle) in enumerate(zip(wrench, rpy, strict=True))]  # fmt: skip
    return Made([write(to / "hex.csv", lines)], tool_truth(made))


def stream_of_a_press(to: Path, rng: Rng) -> Made:
    """Two sensors of different rates in one table: the slow one repeats its last value."""
    one = cell(rng)
    load = settling([0, 5, 10, 20, 0], 5, 80)
    slow = np.repeat(load[::8], 8)[: load.size] + 0.0
    lines = ["timestamp_ns,ref_force_N,hx711_raw"]
    t = 1_700_000_000_000_000_000 + np.arange(load.size, dtype=np.int64) * 12_500_000
    lines += [f"{a},{b:.3f},{c:.0f}" for a, b, c in zip(t, slow, one.read(load, rng), strict=True)]
    return Made([write(to / "press.csv", lines)], truth_of(one))


FIFTH = (
    qualisys_plate_weights, bioware_points, visual3d_ascii, opensim_grf, plotjuggler_sparse,
    ur_rtde_rotation_vector, franka_matrix, sides_in_comments, turned_by_hand, unitree_lowstate,
    anymal_long, spot_two_ankles_bagpy, insole_force_and_cop, plates_under_each_foot,
    onrobot_counts_rpy, stream_of_a_press,
)  # fmt: skip
