"""Logs as laboratories keep them, II: six-axis transducers with what hangs on them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from tests.strangers.legged import _hung
from tests.strangers.rigs import Array, Made, Rng, Tool, attitudes, rows, tool, tool_truth, write

SIDES = {"X down": (1, 0, 0), "X up": (-1, 0, 0), "Y down": (0, 1, 0), "Y up": (0, -1, 0),
         "Z down": (0, 0, 1), "Z up": (0, 0, -1)}  # fmt: skip


def _wrist(rng: Rng, poses: int = 12, hold: int = 25) -> tuple[Tool, Array, Rotation]:
    """Tool, wrenches [F, τ], attitudes of the sensor (body to world, z up)."""
    made = tool(rng)
    rot, _ = attitudes(rng, poses, hold)
    return made, made.read(-rot[:, 2, :], rng), Rotation.from_matrix(rot)


def qualisys_6d(to: Path, rng: Rng) -> Made:
    """Qualisys Track Manager: a 6D file, its matrix column by column; the wrench apart."""
    made, wrench, rot = _wrist(rng, 12, 40)
    n = len(wrench)
    head = [f"NO_OF_FRAMES\t{n}", "NO_OF_CAMERAS\t8", "NO_OF_BODIES\t1", "FREQUENCY\t100",
            "TIME_STAMP\t2024-03-12, 14:02:11\t5.2", "DATA_INCLUDED\t6D", "BODY_NAMES\tgripper",
            "\t".join(["Frame", "Time", "X", "Y", "Z", "Roll", "Pitch", "Yaw", "Residual",
                       *(f"Rot[{i}]" for i in range(9))])]  # fmt: skip
    columns = rot.as_matrix().transpose(0, 2, 1).reshape(-1, 9)
    body = rows(np.arange(1, n + 1), np.arange(n) / 100, *rng.normal(400, 1, (3, n)),
                *rot.as_euler("xyz", degrees=True).T, np.full(n, 0.4), *columns.T,
                sep="\t")  # fmt: skip
    ft = ["Time\tFx\tFy\tFz\tMx\tMy\tMz", *rows(np.arange(n) / 100, *wrench.T, sep="\t")]
    return Made([write(to / "ft.tsv", ft), write(to / "trial1_6D.tsv", [*head, *body])],
                tool_truth(made))  # fmt: skip


def moments_first_mm(to: Path, rng: Rng) -> Made:
    """Moments before forces, N·mm in brackets, a quaternion scalar first."""
    made, wrench, rot = _wrist(rng)
    q = np.roll(rot.as_quat(), 1, axis=1)
    head = "Mx(Nmm);My(Nmm);Mz(Nmm);Fx(N);Fy(N);Fz(N);qw;qx;qy;qz"
    body = rows(*(1e3 * wrench[:, 3:]).T, *wrench[:, :3].T, *q.T, sep=";")
    return Made([write(to / "sensor.csv", [head, *body])], tool_truth(made))


def bagpy_topics(to: Path, rng: Rng) -> Made:
    """A CSV per topic by bagpy: Time, seq, stamp in two columns, the frame's name."""
    made, wrench, rot = _wrist(rng)
    top = "Time,header.seq,header.stamp.secs,header.stamp.nsecs,header.frame_id"
    one = [top + "".join(f",wrench.{k}.{a}" for k in ("force", "torque") for a in "xyz")]
    two = [top + "".join(f",orientation.{a}" for a in "xyzw") + ",orientation_covariance_0"
           + "".join(f",angular_velocity.{a}" for a in "xyz")]  # fmt: skip
    for i, (w, q) in enumerate(zip(wrench, rot.as_quat(), strict=True)):
        for late, lines, values in ((0, one, w), (1, two, (*q, 0.0, 0.001, 0.0, -0.001))):
            s = 1_700_000_000 + 0.01 * i + 0.003 * late
            stamp = f"{s:.6f},{i},{int(s)},{round((s % 1) * 1e9)},{'imu' if late else 'ft'}"
            lines.append(stamp + "".join(f",{v:.8g}" for v in values))
    return Made([write(to / "ft_sensor-raw.csv", one), write(to / "imu-data.csv", two)],
                tool_truth(made))  # fmt: skip


def franka_state(to: Path, rng: Rng) -> Made:
    """libfranka: `O_T_EE` as sixteen numbers column by column, a sensor's wrench by number."""
    made, wrench, rot = _wrist(rng)
    n = len(wrench)
    pose = np.tile(np.eye(4), (n, 1, 1))
    pose[:, :3, :3], pose[:, :3, 3] = rot.as_matrix(), [0.4, 0.1, 0.5]
    head = ["time", *(f"O_T_EE_{i}" for i in range(16)), *(f"ft_{i}" for i in range(6))]
    body = rows(np.arange(n) / 1000, *pose.transpose(0, 2, 1).reshape(n, 16).T, *wrench.T)
    return Made([write(to / "franka.csv", [",".join(head), *body])], tool_truth(made))


def abb_quaternion(to: Path, rng: Rng) -> Made:
    """ABB: q1 … q4, scalar first."""
    made, wrench, rot = _wrist(rng)
    q = np.roll(rot.as_quat(), 1, axis=1)
    head = "time,x,y,z,q1,q2,q3,q4,Fx,Fy,Fz,Tx,Ty,Tz"
    body = rows(np.arange(len(q)) * 0.004, *np.tile([[512.0], [3.0], [700.0]], len(q)), *q.T,
                *wrench.T)  # fmt: skip
    return Made([write(to / "irb.csv", [head, *body])], tool_truth(made))


def fanuc_wpr(to: Path, rng: Rng) -> Made:
    """FANUC: W, P, R in degrees about fixed x, y, z."""
    made, wrench, rot = _wrist(rng)
    head = "Time(ms),X(mm),Y(mm),Z(mm),W(deg),P(deg),R(deg),Fx(N),Fy(N),Fz(N),Mx(Nm),My(Nm),Mz(Nm)"
    n = len(wrench)
    body = rows(np.arange(n) * 8.0, *np.tile([[512.0], [3.0], [700.0]], n),
                *rot.as_euler("xyz", degrees=True).T, *wrench.T)  # fmt: skip
    return Made([write(to / "fanuc.csv", [head, *body])], tool_truth(made))


def pounds_and_gravity(to: Path, rng: Rng) -> Made:
    """American units of forces and torques, gravity in the sensor's frame in g."""
    made, wrench, rot = _wrist(rng)
    g = -rot.as_matrix()[:, 2, :]
    lbf = 4.4482216152605
    head = "t_s,Fx_lbf,Fy_lbf,Fz_lbf,Tx_lbf-in,Ty_lbf-in,Tz_lbf-in,gravity_x,gravity_y,gravity_z"
    body = rows(np.arange(len(g)) / 50, *(wrench[:, :3] / lbf).T,
                *(wrench[:, 3:] / (lbf * 0.0254)).T, *g.T)  # fmt: skip
    return Made([write(to / "ati_us.csv", [head, *body])], tool_truth(made))


def six_rows_by_hand(to: Path, rng: Rng) -> Made:
    """Six averages noted by hand, a row for each side down."""
    made = tool(rng)
    lines = ["Position\tFx\tFy\tFz\tMx\tMy\tMz"]
    for name, down in SIDES.items():
        w = made.read(np.tile(np.array(down, float), (400, 1)), rng).mean(axis=0)
        lines.append(name + "\t" + "\t".join(f"{v:.3f}" for v in w).replace(".", ","))
    return Made([write(to / "lagen.txt", lines)], tool_truth(made))


def heading_and_bank(to: Path, rng: Rng) -> Made:
    """Angles of an attitude reference: heading, pitch, bank in degrees."""
    made, wrench, rot = _wrist(rng)
    bank, pitch, heading = rot.as_euler("xyz", degrees=True).T
    head = "time_ms,heading_deg,pitch_deg,bank_deg,Fx_N,Fy_N,Fz_N,Mx_Nm,My_Nm,Mz_Nm"
    body = rows(np.arange(len(wrench)) * 10.0, heading, pitch, bank, *wrench.T)
    return Made([write(to / "ahrs.csv", [head, *body])], tool_truth(made))


def accelerometer_in_g(to: Path, rng: Rng) -> Made:
    """A sensor with its own accelerometer, in g, short names, torques before forces."""
    made, wrench, rot = _wrist(rng, 14, 40)
    acc = rot.inv().apply([0.0, 0.0, 1.0]) + rng.normal(0, 0.002, (len(wrench), 3))
    head = "timestamp_us,tx,ty,tz,fx,fy,fz,ax_g,ay_g,az_g,temp_C"
    body = rows(np.arange(len(acc)) * 1e4 + 8e8, *wrench[:, 3:].T, *wrench[:, :3].T, *acc.T,
                np.full(len(acc), 30.2))  # fmt: skip
    return Made([write(to / "smart_ft.csv", [head, *body])], tool_truth(made))


def legs_by_number(to: Path, rng: Rng) -> Made:
    """A hexapod hung up, a row per leg and stamp, legs by number, angles in degrees."""
    wrenches, t, body, truth = _hung(rng, ("1", "2", "3", "4", "5", "6"))
    rpy = body.as_euler("xyz", degrees=True)
    lines = ["time;leg;fx;fy;fz;tx;ty;tz;roll;pitch;yaw"]
    for i, at in enumerate(t):
        for leg, w in wrenches.items():
            values = (*w[i], *rpy[i])
            lines.append(f"{at:.3f};{leg};" + ";".join(f"{v:.6g}" for v in values))
    return Made([write(to / "hexapod.csv", lines)], truth)


def upside_down_files(to: Path, rng: Rng) -> Made:
    """A file per side in a folder that names it, headers of ATI's DAQ program with gauges."""
    made, paths = tool(rng), []
    for name, down in SIDES.items():
        folder = to / name.replace(" ", "_")
        folder.mkdir()
        wrench = made.read(np.tile(np.array(down, float), (50, 1)), rng)
        head = ['"Force X (N)","Force Y (N)","Force Z (N)","Torque X (N-m)","Torque Y (N-m)",'
                '"Torque Z (N-m)","Time"']  # fmt: skip
        lines = [",".join(f"{v:.5f}" for v in w) + f",{i / 50:.2f}" for i, w in enumerate(wrench)]
        paths.append(write(folder / "ft.csv", [*head, *lines]))
    return Made(paths, tool_truth(made))


def wrist_alone_no_attitude(to: Path, rng: Rng) -> Made:
    """A wrench alone by LabVIEW's spreadsheet writer: no header at all, tabs, time first."""
    _, wrench, _ = _wrist(rng)
    body = rows(np.arange(len(wrench)) / 100, *wrench.T, sep="\t", form="%.6f")
    return Made([write(to / "spreadsheet.txt", body)], says="attitude")


SEVENTH_WRISTS = (
    qualisys_6d, moments_first_mm, bagpy_topics, franka_state, abb_quaternion, fanuc_wpr,
    pounds_and_gravity, six_rows_by_hand, heading_and_bank, accelerometer_in_g, legs_by_number,
    upside_down_files, wrist_alone_no_attitude,
)  # fmt: skip
