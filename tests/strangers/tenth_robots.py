"""Logs as laboratories keep them, VI: wrists, plates, insoles and legs.

Written before it was run; `docs/bring_your_log.md` has its first count.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tests.strangers.rigs import (
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


def rostopic_p(to: Path, rng: Rng) -> Made:
    """`rostopic echo -p`: wrench and pose topics, each a file with its own stamps."""
    made, wrench, rot = wrist(rng)
    t = 1_700_000_000_000_000_000 + 10_000_000 * np.arange(len(wrench))
    axes = [f"field.wrench.{k}.{a}" for k in ("force", "torque") for a in "xyz"]
    ft = ["%time,field.header.seq,field.header.stamp,field.header.frame_id," + ",".join(axes)]
    ft += [f"{a},{i},{a},ft_link," + ",".join(f"{v:.6f}" for v in w)
           for i, (a, w) in enumerate(zip(t, wrench, strict=True))]  # fmt: skip
    pose = ["%time,field.header.seq,field.header.stamp,field.header.frame_id,"
            + ",".join([*(f"field.pose.position.{a}" for a in "xyz"),
                        *(f"field.pose.orientation.{a}" for a in "xyzw")])]  # fmt: skip
    pose += [f"{a},{i},{a},base," + ",".join(f"{v:.6f}" for v in (0.4, 0.1, 0.5, *q)) for i, (a, q)
             in enumerate(zip(t + 2_000_000, rot.as_quat(), strict=True))]  # fmt: skip
    return Made([write(to / "ft.csv", ft), write(to / "pose.csv", pose)], tool_truth(made))


def ros2_echo_csv(to: Path, rng: Rng) -> Made:
    """`ros2 topic echo --csv` of a wrench: no header at all; orientations in the files' names."""
    made, paths = tool(rng), []
    sides = {"x_up": (-1, 0, 0), "x_down": (1, 0, 0), "y_up": (0, -1, 0), "y_down": (0, 1, 0),
             "z_up": (0, 0, -1), "z_down": (0, 0, 1)}  # fmt: skip
    for k, (name, down) in enumerate(sides.items()):
        wrench = made.read(np.tile(np.array(down, float), (60, 1)), rng)
        lines = [f"{1700000000 + 60 * k + i // 100},{10_000_000 * (i % 100)},ft_sensor,"
                 + ",".join(f"{v:.6f}" for v in w) for i, w in enumerate(wrench)]  # fmt: skip
        paths.append(write(to / f"{name}.csv", lines))
    return Made(paths, tool_truth(made))


def robotiq_ft300(to: Path, rng: Rng) -> Made:
    """Robotiq's stream: six numbers in brackets, beside the arm's quaternion in columns."""
    made, wrench, rot = wrist(rng)
    lines = ["time;ft300;qx;qy;qz;qw"]
    for i, (w, q) in enumerate(zip(wrench, rot.as_quat(), strict=True)):
        lines.append(f"{i / 100:.2f};({' , '.join(f'{v:.3f}' for v in w)});"
                     + ";".join(f"{v:.6f}" for v in q))  # fmt: skip
    return Made([write(to / "ft300.csv", lines)], tool_truth(made))


def onrobot_hex(to: Path, rng: Rng) -> Made:
    """OnRobot's data visualisation: names with units, roll-pitch-yaw of the arm in degrees."""
    made, wrench, rot = wrist(rng)
    yaw, pitch, roll = rot.as_euler("ZYX", degrees=True).T
    head = (
        "Time [s], Fx [N], Fy [N], Fz [N], Tx [Nm], Ty [Nm], Tz [Nm], Rx [deg], Ry [deg], Rz [deg]"
    )
    body = rows(np.arange(len(wrench)) / 100, *wrench.T, roll, pitch, yaw, form="%.5f", sep=", ")
    return Made([write(to / "hex_e.csv", [head, *body])], tool_truth(made))


def ati_netft_demo(to: Path, rng: Rng) -> Made:
    """The ATI NET F/T demo's file: a head of settings, status and sequences, a file per side."""
    made, paths = tool(rng), []
    sides = {"+X": (1, 0, 0), "-X": (-1, 0, 0), "+Y": (0, 1, 0), "-Y": (0, -1, 0), "+Z": (0, 0, 1),
             "-Z": (0, 0, -1)}  # fmt: skip
    for name, down in sides.items():
        head = [
            'Start Time: "3/12/24 10:02:33 AM"',
            "RDT Sample Rate: 100",
            'Force Units: "N", Counts per Unit Force: 1000000.0',
            'Torque Units: "Nm", Counts per Unit Torque: 1000000.0',
            "Status (hex), RDT Sequence, F/T Sequence, Fx, Fy, Fz, Tx, Ty, Tz, Time",
        ]
        wrench = made.read(np.tile(np.array(down, float), (50, 1)), rng)
        body = [f'0x00000000, {i + 1}, {1000 + 70 * i}, '
                + ", ".join(f"{v:.5f}" for v in w) + f', "3/12/24 10:02:{33 + i // 100} AM"'
                for i, w in enumerate(wrench)]  # fmt: skip
        paths.append(write(to / f"gravity {name}.csv", [*head, *body]))
    return Made(paths, tool_truth(made))


def plotjuggler_odometry(to: Path, rng: Rng) -> Made:
    """PlotJuggler: topics at their own rates in one table, empty where a topic had no sample."""
    made, wrench, rot = wrist(rng, hold=50)
    names = ["__time", *(f"/ft/wrench/{k}/{a}" for k in ("force", "torque") for a in "xyz"),
             *(f"/imu/orientation/{a}" for a in "xyzw")]  # fmt: skip
    lines = [",".join(names)]
    for i, (w, q) in enumerate(zip(wrench, rot.as_quat(), strict=True)):
        lines.append(f"{1.7e9 + i / 100:.4f}," + ",".join(f"{v:.6f}" for v in w) + "," * 4)
        if i % 2 == 0:
            lines.append(f"{1.7e9 + i / 100 + 0.004:.4f}," + "," * 6
                         + ",".join(f"{v:.6f}" for v in q))  # fmt: skip
    return Made([write(to / "plotjuggler.csv", lines)], tool_truth(made))


def mc_rtc_log(to: Path, rng: Rng) -> Made:
    """mc_rtc's CSV: semicolons, couple before force, ankles, the base's quaternion; mass asked."""
    n = 300
    names, data = ["t"], [np.arange(n) / 200]
    for side in ("Left", "Right"):
        names += [f"{side}FootForceSensor_{k}{a}" for k in ("c", "f") for a in "xyz"]
        data += [*rng.normal(0, 0.5, (3, n)), *rng.normal(0, 1, (2, n)), rng.normal(190, 2, n)]
    names += [f"ff_q{a}" for a in "wxyz"]
    data += [np.ones(n), *rng.normal(0, 1e-3, (3, n))]
    return Made([write(to / "mc-control.csv", [";".join(names), *rows(*data, sep=";")])],
                says="weigh")  # fmt: skip


def naoqi_memory(to: Path, rng: Rng) -> Made:
    """ALMemory keys as names, eight cells in kg, the two angles of the body."""
    keys = [f"Device/SubDeviceList/{s}Foot/FSR/{p}/Sensor/Value" for s in "LR"
            for p in ("FrontLeft", "FrontRight", "RearLeft", "RearRight")]  # fmt: skip
    keys += [f"Device/SubDeviceList/InertialSensor/Angle{a}/Sensor/Value" for a in "XY"]
    n = 200
    data = [np.arange(n) / 100, *rng.normal(0.65, 0.01, (8, n)), *rng.normal(0, 0.01, (2, n))]
    return Made([write(to / "memory.csv", ["time," + ",".join(keys), *rows(*data)])],
                says="where the cells sit")  # fmt: skip


def qualisys_force_tsv(to: Path, rng: Rng) -> Made:
    """QTM: a force plate a file, a head of settings above the names; mass to fill in."""
    share = settling([0.35, 0.55, 0.7, 0.4, 0.6, 0.5], 5, 50)
    n, mass, gain, paths = share.size, 68.0, (1.05, 0.96), []
    for k, (part, g) in enumerate(zip((share, 1 - share), gain, strict=True), 1):
        head = [f"NO_OF_SAMPLES\t{n}", "FREQUENCY\t50", "DESCRIPTION\tForce data in local "
                "force plate coordinates", f"FORCE_PLATE_NAME\tPlate {k}",
                "FORCE_PLATE_LENGTH\t600",
                "SAMPLE\tTIME\tForce_X\tForce_Y\tForce_Z\tMoment_X\tMoment_Y\tMoment_Z\tCOP_X"
                "\tCOP_Y\tCOP_Z"]  # fmt: skip
        fz = part * mass * G / g + rng.normal(0, 1, n)
        cop = rng.normal(0, 4, (2, n))
        body = rows(np.arange(1, n + 1), np.arange(n) / 50, *rng.normal(0, 1, (2, n)), fz,
                    cop[1] * fz / 1e3, -cop[0] * fz / 1e3, np.zeros(n), *cop, np.zeros(n), sep="\t",
                    form="%.6g")  # fmt: skip
        paths.append(write(to / f"stand_f_{k}.tsv", [*head, *body]))
    return Made(paths, says="weigh")


def opensim_mot(to: Path, rng: Rng) -> Made:
    """OpenSim's ground reactions: `ground_force_vy` is up; mass to fill in."""
    share = settling([0.35, 0.55, 0.7, 0.4, 0.6, 0.5], 5, 50)
    n, mass, gain = share.size, 72.0, (1.05, 0.96)
    names, data = ["time"], [np.arange(n) / 50]
    for pre, part, g in zip(("", "1_"), (share, 1 - share), gain, strict=True):
        names += [f"{pre}ground_force_{k}{a}" for k in "vp" for a in "xyz"]
        data += [rng.normal(0, 1, n), part * mass * G / g + rng.normal(0, 1, n),
                 rng.normal(0, 1, n), rng.normal(0.1, 0.004, n), np.zeros(n),
                 rng.normal(0.1 if pre else -0.1, 0.004, n)]  # fmt: skip
    head = ["grf.mot", "version=1", f"nRows={n}", f"nColumns={len(names)}", "inDegrees=yes",
            "endheader", "\t".join(names)]  # fmt: skip
    return Made([write(to / "grf.mot", [*head, *rows(*data, sep="\t")])], says="weigh")


def pedar_asc(to: Path, rng: Rng) -> Made:
    """Novel pedar's force file: left and right force and CoP in mm; mass to fill in."""
    share = settling([0.3, 0.5, 0.7, 0.4, 0.6, 0.5], 5, 50)
    n, mass, gain = share.size, 80.0, (1.06, 0.95)
    head = ["pedar-x  force and cop", "file name\tsubject01", "date/time\t12.03.24 10:02", "",
            "time[secs]\tleft force[N]\tleft x[mm]\tleft y[mm]\tright force[N]\tright x[mm]"
            "\tright y[mm]"]  # fmt: skip
    data = [np.arange(n) / 50]
    for part, g in zip((share, 1 - share), gain, strict=True):
        data += [part * mass * G / g + rng.normal(0, 2, n), rng.normal(45, 2, n),
                 rng.normal(120, 3, n)]  # fmt: skip
    cells = {f"{s}_p{i}.scale": g for s, g in zip(("left", "right"), gain, strict=True)
             for i in (1, 2, 3)}  # fmt: skip
    return Made([write(to / "subject01.fgt", [*head, *rows(*data, sep="\t", form="%.3f")])],
                Truth(cells, dict.fromkeys(cells, 0.1)), says="weigh",
                fill=filled(mass_kg=f"{mass}"))  # fmt: skip


def loadsol_txt(to: Path, rng: Rng) -> Made:
    """Loadsol: two insoles with three zones each and their sum, a stamp for each side."""
    n = 400
    head = ["loadsol data", "Insole L 2701-0211\t\t\t\t\tInsole R 2701-0212",
            "Time [sec]\tHeel L [N]\tMedial L [N]\tLateral L [N]\tLeft [N]"
            "\tTime [sec]\tHeel R [N]\tMedial R [N]\tLateral R [N]\tRight [N]"]  # fmt: skip
    data = []
    for _ in "LR":
        zones = rng.normal(115, 3, (3, n))
        data += [np.arange(n) / 100, *zones, zones.sum(axis=0)]
    return Made([write(to / "loadsol.txt", [*head, *rows(*data, sep="\t", form="%.2f")])],
                says="weigh")  # fmt: skip


def row_per_foot_forces(to: Path, rng: Rng) -> Made:
    """A row per foot with force and CoP; mass to fill in."""
    share = settling([0.35, 0.55, 0.7, 0.4, 0.6, 0.5], 5, 50)
    n, mass, gain = share.size, 71.0, (1.04, 0.95)
    lines = ["timestamp_ms,foot,fz_newton,cop_x_mm,cop_y_mm"]
    for i in range(n):
        for name, part, g in zip(("left", "right"), (share[i], 1 - share[i]), gain, strict=True):
            x, y = rng.normal(10, 2, 2)
            lines.append(f"{20 * i},{name},{part * mass * G / g + rng.normal(0, 1):.3f},{x:.2f},"
                         f"{y:.2f}")  # fmt: skip
    cells = {f"{s}_p{i}.scale": g for s, g in zip(("left", "right"), gain, strict=True)
             for i in (1, 2, 3)}  # fmt: skip
    return Made([write(to / "feet.csv", lines)], Truth(cells, dict.fromkeys(cells, 0.1)),
                says="weigh", fill=filled(mass_kg=f"{mass}"))  # fmt: skip


def unitless_wrist(to: Path, rng: Rng) -> Made:
    """Names without units; torques are in N·mm and the numbers show it; rotation in radians."""
    made, wrench, rot = wrist(rng)
    yaw, pitch, roll = rot.as_euler("ZYX").T
    head = "t roll pitch yaw Fx Fy Fz Mx[Nmm] My[Nmm] Mz[Nmm]"
    body = rows(np.arange(len(wrench)) / 125, roll, pitch, yaw, *wrench[:, :3].T,
                *(1e3 * wrench[:, 3:]).T, sep=" ", form="%.6g")  # fmt: skip
    return Made([write(to / "wrist.txt", [head, *body])], tool_truth(made))


TENTH_ROBOTS = (
    rostopic_p, ros2_echo_csv, robotiq_ft300, onrobot_hex, ati_netft_demo, plotjuggler_odometry,
    mc_rtc_log, naoqi_memory, qualisys_force_tsv, opensim_mot, pedar_asc, loadsol_txt,
    row_per_foot_forces, unitless_wrist,
)  # fmt: skip
