"""Logs as people keep them, XII, of robots: phones on tools, simulators, arms, feet, plates.

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
    rows,
    settling,
    tool,
    tool_truth,
    wrist,
    write,
)

AXES = ("fx", "fy", "fz", "tx", "ty", "tz")


def _at_rest(rot: Rotation, rng: Rng) -> Array:
    """What an accelerometer on the tool shows, m/s², shape (n, 3)."""
    up = rot.as_matrix()[:, 2, :]
    return np.asarray(G * up + rng.normal(0, 0.02, up.shape))


def phyphox_on_the_tool(to: Path, rng: Rng) -> Made:
    """A phone taped to the tool: its accelerometer in a file, the wrench in another."""
    made, wrench, rot = wrist(rng)
    t = 0.02 * np.arange(len(wrench))
    acc = _at_rest(rot, rng)
    phone = ['"Time (s)","Acceleration x (m/s^2)","Acceleration y (m/s^2)",'
             '"Acceleration z (m/s^2)","Absolute acceleration (m/s^2)"']  # fmt: skip
    phone += rows(t, *acc.T, np.linalg.norm(acc, axis=1), form="%.9E")
    ours = ["t,Fx,Fy,Fz,Tx,Ty,Tz", *rows(t, *wrench.T, form="%.5f")]
    return Made([write(to / "wrench.csv", ours), write(to / "Raw Data.csv", phone)],
                tool_truth(made))  # fmt: skip


def sensor_logger_zyx(to: Path, rng: Rng) -> Made:
    """A phone's app that writes z before y before x, in nanoseconds of the epoch."""
    made, wrench, rot = wrist(rng)
    second = 0.02 * np.arange(len(wrench))
    acc = _at_rest(rot, rng)
    phone = ["time,seconds_elapsed,z,y,x"]
    phone += [f"{1710237600000000000 + round(s * 1e9)},{s:.4f},{a[2]:.6f},{a[1]:.6f},{a[0]:.6f}"
              for s, a in zip(second, acc, strict=True)]  # fmt: skip
    ours = ["epoch_s," + ",".join(AXES)]
    ours += [f"{1710237600 + s:.3f}," + ",".join(f"{v:.5f}" for v in w)
             for s, w in zip(second, wrench, strict=True)]  # fmt: skip
    return Made([write(to / "ft.csv", ours), write(to / "TotalAcceleration.csv", phone)],
                tool_truth(made))  # fmt: skip


def isaac_lab(to: Path, rng: Rng) -> Made:
    """Isaac Lab: `quat_w` is the quaternion in the world, its scalar first."""
    made, wrench, rot = wrist(rng)
    q = np.roll(rot.as_quat(), 1, axis=1)
    names = ["step", "env_id", *(f"ee_quat_w[{i}]" for i in range(4)),
             *(f"ee_wrench_b[{i}]" for i in range(6))]  # fmt: skip
    body = rows(np.arange(len(q)), np.zeros(len(q)), *q.T, *wrench.T, form="%.6g")
    return Made([write(to / "rollout.csv", [",".join(names), *body])], tool_truth(made))


def mujoco_xmat(to: Path, rng: Rng) -> Made:
    """MuJoCo: sites' matrices in nine numbers, force and torque of a site."""
    made, wrench, rot = wrist(rng)
    names = ["time", *(f"site_xmat_{i}" for i in range(9)), *(f"ft_force_{i}" for i in range(3)),
             *(f"ft_torque_{i}" for i in range(3))]  # fmt: skip
    body = rows(0.002 * np.arange(len(wrench)), *rot.as_matrix().reshape(-1, 9).T, *wrench.T,
                form="%.6g")  # fmt: skip
    return Made([write(to / "sensordata.csv", [",".join(names), *body])], tool_truth(made))


def simulink_inspector(to: Path, rng: Rng) -> Made:
    """Simulink's inspector: elements in brackets, a row of units and one of interpolation."""
    made, wrench, rot = wrist(rng)
    q = np.roll(rot.as_quat(), 1, axis=1)
    names = ["time", *(f"quat({i})" for i in range(1, 5)), *(f"F({i})" for i in range(1, 4)),
             *(f"M({i})" for i in range(1, 4))]  # fmt: skip
    unit = ["", *["Unit: 1"] * 4, *["Unit: N"] * 3, *["Unit: N*m"] * 3]
    kind = ["", *["Interp: linear"] * 10]
    body = rows(0.01 * np.arange(len(wrench)), *q.T, *wrench.T, form="%.6g")
    lines = [",".join(x) for x in (names, unit, kind)] + body
    return Made([write(to / "run1.csv", lines)], tool_truth(made))


def abb_robtarget(to: Path, rng: Rng) -> Made:
    """ABB's robtargets as texts, `[[x,y,z],[q1,q2,q3,q4],…]`, before the six forces."""
    made, wrench, rot = wrist(rng)
    q = np.roll(rot.as_quat(), 1, axis=1)
    lines = ["Target;Fx;Fy;Fz;Mx;My;Mz"]
    for a, w in zip(q, wrench, strict=True):
        turn = ",".join(f"{v:.6f}" for v in a)
        lines.append(f"[[600.0,0.0,700.0],[{turn}],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];"
                     + ";".join(f"{v:.5f}" for v in w))  # fmt: skip
    return Made([write(to / "targets.csv", lines)], tool_truth(made))


def kuka_rsi_xml(to: Path, rng: Rng) -> Made:
    """KUKA's sensor interface: a telegram on each line, A B C in attributes."""
    made, wrench, rot = wrist(rng)
    lines = []
    for i, (a, w) in enumerate(zip(rot.as_euler("ZYX", degrees=True), wrench, strict=True)):
        force = " ".join(f'{n}="{v:.5f}"' for n, v in zip(("Fx", "Fy", "Fz", "Tx", "Ty", "Tz"), w,
                                                          strict=True))  # fmt: skip
        lines.append(f'<Rob Type="KUKA"><RIst X="600.0" Y="0.0" Z="700.0" A="{a[0]:.4f}" '
                     f'B="{a[1]:.4f}" C="{a[2]:.4f}" /><FT {force} /><IPOC>{4208163 + 4 * i}'
                     "</IPOC></Rob>")  # fmt: skip
    return Made([write(to / "rsi.log", lines)], tool_truth(made))


def epson_uvw(to: Path, rng: Rng) -> Made:
    """Epson: U, V, W in degrees about z, y and x."""
    made, wrench, rot = wrist(rng)
    place = np.tile([[0.0], [400.0], [300.0]], len(wrench))
    body = rows(*place, *rot.as_euler("ZYX", degrees=True).T, *wrench.T, form="%.5f")
    return Made([write(to / "rc700.csv", ["X,Y,Z,U,V,W,Fx,Fy,Fz,Tx,Ty,Tz", *body])],
                tool_truth(made))  # fmt: skip


def melfa_positions(to: Path, rng: Rng) -> Made:
    """Mitsubishi: positions in round brackets, A B C about fixed axes, in degrees."""
    made, wrench, rot = wrist(rng)
    lines = ["P_Curr\tP_FsCurF"]
    for a, w in zip(rot.as_euler("xyz", degrees=True), wrench, strict=True):
        pose = ",".join(f"{v:+.4f}" for v in (300.0, 0.0, 400.0, *a))
        lines.append(f"({pose})(7,0)\t({','.join(f'{v:+.5f}' for v in w)})")
    return Made([write(to / "melfa.txt", lines)], tool_truth(made))


def coppelia_angles(to: Path, rng: Rng) -> Made:
    """CoppeliaSim: alpha, beta, gamma about x, the turned y and the turned z."""
    made, wrench, rot = wrist(rng)
    names = ["Simulation time", "alpha", "beta", "gamma", *(f"forceSensor.{a}" for a in AXES)]
    body = rows(0.05 * np.arange(len(wrench)), *rot.as_euler("XYZ", degrees=True).T, *wrench.T,
                form="%.5f")  # fmt: skip
    return Made([write(to / "graph.csv", [",".join(names), *body])], tool_truth(made))


def quadruped_sides_down(to: Path, rng: Rng) -> Made:
    """A four-legged robot held by its trunk, which side was below in a column."""
    sides = {"feet down": (0, 0, -1), "feet up": (0, 0, 1), "nose down": (1, 0, 0),
             "tail down": (-1, 0, 0), "left side down": (0, 1, 0),
             "right side down": (0, -1, 0)}  # fmt: skip
    legs = {leg: tool(rng) for leg in ("LF", "RF", "LH", "RH")}
    ours = {"LF": "fl", "RF": "fr", "LH": "hl", "RH": "hr"}
    lines = ["pose," + ",".join(f"{leg}_{a}" for leg in legs for a in AXES)]
    for side, down in sides.items():
        way = np.tile(np.array(down, float), (30, 1))
        read = np.hstack([made.read(way, rng) for made in legs.values()])
        lines += [f"{side}," + ",".join(f"{v:.5f}" for v in row) for row in read]
    truth = Truth()
    for leg, made in legs.items():
        part = tool_truth(made, ours[leg])
        truth = Truth({**truth.values, **part.values}, {**truth.within, **part.within})
    return Made([write(to / "held.csv", lines)], truth)


def file_per_leg(to: Path, rng: Rng) -> Made:
    """A file for each leg of a hexapod, turned one after the other with its own attitude."""
    paths, truth = [], Truth()
    for name in ("L1", "L2", "L3", "R1", "R2", "R3"):
        made, wrench, rot = wrist(rng)
        head = "t,qw,qx,qy,qz,fx,fy,fz,tx,ty,tz"
        q = np.roll(rot.as_quat(), 1, axis=1)
        body = rows(0.01 * np.arange(len(q)), *q.T, *wrench.T, form="%.6g")
        paths.append(write(to / f"leg_{name}.csv", [head, *body]))
        part = tool_truth(made, name)
        truth = Truth({**truth.values, **part.values}, {**truth.within, **part.within})
    return Made(paths, truth)


def webots_feet(to: Path, rng: Rng) -> Made:
    """Webots: a NAO's feet as forces of three axes, standing."""
    share = settling([0.35, 0.55, 0.7, 0.4, 0.6, 0.5], 5, 50)
    left, right = share * 5.3 * G, (1 - share) * 5.3 * G
    side = rng.normal(0, 0.05, (4, share.size))
    body = rows(np.arange(share.size) * 0.02, side[0], side[1], left / 1.03, side[2], side[3],
                right / 0.98, form="%.4f")  # fmt: skip
    head = "time,LFsr_x,LFsr_y,LFsr_z,RFsr_x,RFsr_y,RFsr_z"
    return Made([write(to / "webots.csv", [head, *body])], says="weigh")


def _standing(rng: Rng) -> Array:
    """Counts of eight cells under two feet while a robot sways, shape (8, n)."""
    side = settling([0.35, 0.6, 0.45, 0.7, 0.5], 5, 50)
    fore = settling([0.5, 0.3, 0.65, 0.4, 0.55], 5, 50)
    parts = [s * f * 0.5 for s in (side, 1 - side) for f in (fore, fore, 1 - fore, 1 - fore)]
    load = np.array(parts) * 5.3 * G
    gain = rng.uniform(0.02, 0.03, (8, 1))
    return np.round(load / gain + rng.uniform(200, 400, (8, 1)) + rng.normal(0, 1, load.shape))


def japanese_feet(to: Path, rng: Rng) -> Made:
    """Cells under two feet named in Japanese."""
    names = [f"{s}足_{a}" for s in ("左", "右") for a in ("前右", "前左", "後右", "後左")]
    read = _standing(rng)
    body = rows(np.arange(read.shape[1]) / 50, *read)
    return Made([write(to / "起立.csv", [",".join(["時刻[s]", *names]), *body], "cp932")],
                says="weigh")  # fmt: skip


def spanish_feet(to: Path, rng: Rng) -> Made:
    """Cells under two feet named in Spanish."""
    names = [f"{s}_{a}" for s in ("izq", "der") for a in ("punta_int", "punta_ext", "talon_int",
                                                          "talon_ext")]  # fmt: skip
    read = _standing(rng)
    body = rows(np.arange(read.shape[1]) / 50, *read, sep=";", form="%.2f")
    return Made([write(to / "de_pie.csv", [";".join(["tiempo", *names]), *body])], says="weigh")


def plate_of_four_corners(to: Path, rng: Rng) -> Made:
    """A known weight at points of a plate on four cells, which read newtons."""
    corners = np.array([(200, 150), (200, -150), (-200, 150), (-200, -150)]) / 1000
    gain = rng.uniform(0.97, 1.03, 4)
    lines = ["x [mm];y [mm];Fref [N];fz1 [N];fz2 [N];fz3 [N];fz4 [N]"]
    for x in (-120, -40, 40, 120):
        for y in (-90, -30, 30, 90):
            share = (1 + x / 1000 / 0.2 * np.sign(corners[:, 0])) * (
                1 + y / 1000 / 0.15 * np.sign(corners[:, 1])) / 4  # fmt: skip
            for _ in range(3):
                fz = 100 * share / gain + rng.normal(0, 0.03, 4)
                lines.append(f"{x};{y};100;" + ";".join(f"{v:.3f}".replace(".", ",") for v in fz))
    return Made([write(to / "platte.csv", lines)], says="sit")


def points_in_inches(to: Path, rng: Rng) -> Made:
    """Where a stylus stood and what the plate said, in inches."""
    lines = ["Target X (in),Target Y (in),Measured X (in),Measured Y (in)"]
    for x in (-6, -3, 0, 3, 6):
        for y in (-4, -2, 0, 2, 4):
            for _ in range(3):
                u, v = np.array([1.02 * x + 0.06, 0.99 * y - 0.08]) + rng.normal(0, 0.008, 2)
                lines.append(f"{x},{y},{u:.4f},{v:.4f}")
    return Made([write(to / "spot check.csv", lines)], cop_within_m=0.4e-3)


SIXTEENTH_ROBOTS = (
    phyphox_on_the_tool, sensor_logger_zyx, isaac_lab, mujoco_xmat, simulink_inspector,
    abb_robtarget, kuka_rsi_xml, epson_uvw, melfa_positions, coppelia_angles,
    quadruped_sides_down, file_per_leg, webots_feet, japanese_feet, spanish_feet,
    plate_of_four_corners, points_in_inches,
)  # fmt: skip
