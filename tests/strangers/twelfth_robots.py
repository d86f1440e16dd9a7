"""Logs as laboratories keep them, VIII: wrists, plates, insoles and legs.

Written before it was run; `docs/bring_your_log.md` has its first count.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tests.strangers.rigs import (
    Array,
    G,
    Made,
    Rng,
    Truth,
    filled,
    rows,
    settling,
    tool,
    tool_truth,
    wrist,
    write,
)


def kinova_kortex(to: Path, rng: Rng) -> Made:
    """Kortex feedback: `tool_pose_theta_x` in degrees, fixed axes x, y, z; joints beside."""
    made, wrench, rot = wrist(rng)
    n = len(wrench)
    names = [*(f"joint_{i}_position" for i in range(7)), *(f"tool_pose_{a}" for a in "xyz"),
             *(f"tool_pose_theta_{a}" for a in "xyz"),
             *(f"tool_external_wrench_{k}_{a}" for k in ("force", "torque") for a in "xyz"),
             ]  # fmt: skip
    theta = rot.as_euler("xyz", degrees=True)
    body = rows(0.01 * np.arange(n), *rng.uniform(0, 360, (7, n)), *np.tile([[0.4], [0], [0.5]], n),
                *theta.T, *wrench.T, form="%.6g")  # fmt: skip
    return Made([write(to / "kortex.csv", [",".join(["time_s", *names]), *body])],
                tool_truth(made))  # fmt: skip


def kawasaki_oat(to: Path, rng: Rng) -> Made:
    """Kawasaki: O, A, T in degrees turn about z, y and the new z."""
    made, wrench, rot = wrist(rng)
    oat = rot.as_euler("ZYZ", degrees=True)
    body = rows(*np.tile([[400.0], [10.0], [500.0]], len(wrench)), *oat.T, *wrench.T, form="%.5f")
    return Made([write(to / "as_log.csv", ["X,Y,Z,O,A,T,Fx,Fy,Fz,Mx,My,Mz", *body])],
                tool_truth(made))  # fmt: skip


def xsens_quat(to: Path, rng: Rng) -> Made:
    """MT Manager's export: comments above, `Quat_q0 … q3` scalar first, the wrench beside."""
    made, wrench, rot = wrist(rng)
    n, q = len(wrench), np.roll(rot.as_quat(), 1, axis=1)
    head = ["// General information:", "//  MT Manager version: 2022.0", "//  Update Rate: 100.0Hz",
            "PacketCounter,SampleTimeFine,Quat_q0,Quat_q1,Quat_q2,Quat_q3,FX,FY,FZ,TX,TY,TZ",
            ]  # fmt: skip
    body = rows(41_000 + np.arange(n), 100 * np.arange(n), *q.T, *wrench.T, form="%.6f")
    return Made([write(to / "MT_0800.txt", [*head, *body])], tool_truth(made))


def german_orientations(to: Path, rng: Rng) -> Made:
    """A file for each orientation, named in German, decimal commas."""
    made, paths = tool(rng), []
    sides = {"X_oben": (-1, 0, 0), "X_unten": (1, 0, 0), "Y_oben": (0, -1, 0),
             "Y_unten": (0, 1, 0), "Z_oben": (0, 0, -1), "Z_unten": (0, 0, 1)}  # fmt: skip
    for name, down in sides.items():
        wrench = made.read(np.tile(np.array(down, float), (50, 1)), rng)
        body = [
            x.replace(".", ",") for x in rows(np.arange(50) / 50, *wrench.T, sep=";", form="%.4f")
        ]
        head = "Zeit [s];Fx [N];Fy [N];Fz [N];Mx [Nm];My [Nm];Mz [Nm]"
        paths.append(write(to / f"{name}.csv", [head, *body], "cp1252"))
    return Made(paths, tool_truth(made))


def zeros_where_lost(to: Path, rng: Rng) -> Made:
    """A driver that writes six zeros where it had no packet: one row in thirty."""
    made, wrench, rot = wrist(rng)
    wrench[rng.permutation(len(wrench))[: len(wrench) // 30]] = 0.0
    body = rows(0.008 * np.arange(len(wrench)), *wrench.T, *rot.as_quat().T, form="%.5f")
    head = "t,Fx,Fy,Fz,Tx,Ty,Tz,qx,qy,qz,qw"
    return Made([write(to / "udp.csv", [head, *body])], tool_truth(made))


def gauges_under_known_wrenches(to: Path, rng: Rng) -> Made:
    """Six gauges in volts and the wrench that a rig put on: a matrix."""
    gain = np.diag([40.0, 40, 90, 4, 4, 4]) + rng.normal(0, 0.4, (6, 6))
    offset = rng.normal(0, 0.2, 6)
    put = np.repeat(rng.uniform(-1, 1, (40, 6)) * [100, 100, 200, 10, 10, 10], 5, axis=0)
    volts = np.linalg.solve(gain, put.T).T + offset + rng.normal(0, 2e-4, put.shape)
    head = [f"Gauge{i} (V)" for i in range(6)]
    head += [f"Applied {a} ({u})" for a, u in zip(
        ("Fx", "Fy", "Fz", "Tx", "Ty", "Tz"), ("N",) * 3 + ("Nm",) * 3, strict=True)]  # fmt: skip
    out = ("fx", "fy", "fz", "tx", "ty", "tz")
    values = {f"{a}.bias": float(v) for a, v in zip(out, -gain @ offset, strict=True)}
    within = {n: 0.2 if n[0] == "f" else 0.02 for n in values}
    return Made([write(to / "rig.csv", [",".join(head), *rows(*volts.T, *put.T, form="%.6f")])],
                Truth(values, within))  # fmt: skip


def _stand(mass: float, gain: tuple[float, float], rng: Rng) -> tuple[Array, Array]:
    """Vertical forces of two plates that a person shifts weight between, and CoP (2, n, 2)."""
    share = settling([0.35, 0.55, 0.7, 0.4, 0.6, 0.5], 5, 50)
    parts = np.array([share, 1 - share])
    fz = parts * mass * G / np.array(gain)[:, None] + rng.normal(0, 1, parts.shape)
    return fz, rng.normal(0, 0.004, (2, share.size, 2))


def _plates(gain: tuple[float, float], names: tuple[str, str]) -> Truth:
    cells = {f"{n}_p{i}.scale": g for n, g in zip(names, gain, strict=True) for i in (1, 2, 3)}
    return Truth(cells, dict.fromkeys(cells, 0.1))


def nexus_two_plates(to: Path, rng: Rng) -> Made:
    """Nexus: devices named over their columns, frames and sub frames, force on the plate (down)."""
    mass, gain = 73.0, (1.05, 0.96)
    fz, cop = _stand(mass, gain, rng)
    n = fz.shape[1]
    over, names, units, data = ["", ""], ["Frame", "Sub Frame"], ["", ""], [
        1.0 + np.arange(n) // 10, np.arange(n) % 10.0]  # fmt: skip
    for k in (0, 1):
        kinds = (("Force", "F", "N"), ("Moment", "M", "N.mm"), ("CoP", "C", "mm"))
        for kind, letter, unit in kinds:
            over += [f"Imported AMTI OR6 #{k + 1} - {kind}", "", ""]
            names += [f"{letter}{a}" for a in "xyz"]
            units += [unit] * 3
        x, y = 1e3 * cop[k].T
        data += [*rng.normal(0, 1, (2, n)), -fz[k], -y * fz[k], x * fz[k], np.zeros(n), x, y,
                 np.zeros(n)]  # fmt: skip
    lines = ["Devices", "500", *(",".join(x) for x in (over, names, units)),
             *rows(*data, form="%.6g")]  # fmt: skip
    return Made([write(to / "Static01.csv", lines, end="\r\n")], says="weigh")


def zebris_german(to: Path, rng: Rng) -> Made:
    """Zebris: force and CoP of both feet in German, decimal commas; mass to fill in."""
    mass, gain = 81.0, (1.06, 0.95)
    fz, cop = _stand(mass, gain, rng)
    names, data = ["Zeit [ms]"], [20.0 * np.arange(fz.shape[1])]
    for k, side in enumerate(("links", "rechts")):
        names += [f"Kraft {side} [N]", f"COP X {side} [mm]", f"COP Y {side} [mm]"]
        data += [fz[k], *(1e3 * cop[k].T)]
    body = [x.replace(".", ",") for x in rows(*data, sep=";", form="%.3f")]
    return Made([write(to / "stand.csv", [";".join(names), *body], "cp1252")],
                _plates(gain, ("left", "right")), says="weigh",
                fill=filled(mass_kg=f"{mass}"))  # fmt: skip


def mokka_ascii(to: Path, rng: Rng) -> Made:
    """Mokka's ASCII of a C3D: analog channels by plate number, force on the plate; mass asked."""
    fz, _ = _stand(70.0, (1.05, 0.96), rng)
    n = fz.shape[1]
    names, units, data = ["Time"], ["s"], [np.arange(n) / 50]
    for k in (0, 1):
        names += [f"{a}{k + 1}" for a in ("Fx", "Fy", "Fz", "Mx", "My", "Mz")]
        units += ["N"] * 3 + ["Nmm"] * 3
        data += [*rng.normal(0, 1, (2, n)), -fz[k], *rng.normal(0, 2e3, (3, n))]
    head = ["First frame:\t1", f"Last frame:\t{n}", "Point frequency:\t50", "Analog frequency:\t50",
            "", "\t".join(names), "\t".join(units)]  # fmt: skip
    return Made([write(to / "trial.txt", [*head, *rows(*data, sep="\t", form="%.5f")])],
                says="weigh")  # fmt: skip


def motek_dflow(to: Path, rng: Rng) -> Made:
    """Motek's D-Flow: y is up, `FP1.CopX`, `FP1.ForY`; mass to fill in."""
    mass, gain = 66.0, (1.04, 0.96)
    fz, cop = _stand(mass, gain, rng)
    n = int(fz.shape[1])
    names, data = ["TimeStamp", "FrameNumber"], [12.0 + np.arange(n) / 50, 1.0 + np.arange(n)]
    for k in (0, 1):
        names += [f"FP{k + 1}.{a}" for a in ("CopX", "CopY", "CopZ", "ForX", "ForY", "ForZ", "MomX",
                                             "MomY", "MomZ")]  # fmt: skip
        x, z = cop[k].T
        data += [x + 0.2 * (2 * k - 1), np.zeros(n), z, rng.normal(0, 1, n), fz[k],
                 rng.normal(0, 1, n), *np.zeros((3, n))]  # fmt: skip
    return Made([write(to / "treadmill.txt", ["\t".join(names), *rows(*data, sep="\t",
                                                                      form="%.6f")])],
                says="weigh")  # fmt: skip


def unitree_sdk_csv(to: Path, rng: Rng) -> Made:
    """Unitree's low state in columns: raw and estimated foot force, quaternion, joints; asked."""
    n = 300
    names = ["tick", *(f"imu_quaternion_{i}" for i in range(4)),
             *(f"motor_q_{i}" for i in range(12)), *(f"foot_force_{i}" for i in range(4)),
             *(f"foot_force_est_{i}" for i in range(4))]  # fmt: skip
    feet = rng.normal(30, 2, (4, n))
    body = rows(2.0 * np.arange(n), np.ones(n), *rng.normal(0, 1e-3, (3, n)),
                *rng.normal(0.7, 1e-3, (12, n)), *np.round(feet), *np.round(0.9 * feet),
                form="%.6g")  # fmt: skip
    return Made([write(to / "lowstate.csv", [",".join(names), *body])], says="weigh")


def noraxon_myopressure(to: Path, rng: Rng) -> Made:
    """Noraxon: names with commas inside quotes, zones and their sum per foot; mass asked."""
    n = 300
    names, data = ["time", "Activity", "Marker"], [np.arange(n) / 100, np.zeros(n), np.zeros(n)]
    for side in ("LT", "RT"):
        zones = rng.normal(115, 3, (3, n))
        names += [f'"{side} Insole-{z}, Force (N)"' for z in ("Heel", "Mid", "Toe")]
        names.append(f'"{side} Insole-Total, Force (N)"')
        data += [*zones, zones.sum(axis=0)]
    return Made([write(to / "mr.csv", ["MR3.18", ",".join(names), *rows(*data, form="%.4f")])],
                says="weigh")  # fmt: skip


def ros_control_introspection(to: Path, rng: Rng) -> Made:
    """A humanoid's introspection: `left_ankle_ft - force - z`, six axes a side; mass asked."""
    n = 300
    names, data = ["__time"], [1.7e9 + np.arange(n) / 100]
    for side in ("left", "right"):
        names += [f"{side}_ankle_ft - {k} - {a}" for k in ("force", "torque") for a in "XYZ"]
        data += [*rng.normal(0, 1, (2, n)), rng.normal(440, 2, n), *rng.normal(0, 0.5, (3, n))]
    return Made([write(to / "introspection.csv", [",".join(names), *rows(*data, form="%.6f")])],
                says="weigh")  # fmt: skip


TWELFTH_ROBOTS = (
    kinova_kortex, kawasaki_oat, xsens_quat, german_orientations, zeros_where_lost,
    gauges_under_known_wrenches, nexus_two_plates, zebris_german, mokka_ascii, motek_dflow,
    unitree_sdk_csv, noraxon_myopressure, ros_control_introspection,
)  # fmt: skip
