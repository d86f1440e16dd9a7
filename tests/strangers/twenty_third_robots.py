"""Wrists, ankles, plates and insoles as motion software, robots and databases export them.

Written before it was run; `docs/bring_your_log.md` has its first count.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from tests.strangers.rigs import (
    Array,
    Cell,
    G,
    Made,
    Rng,
    Tool,
    Truth,
    cell,
    rows,
    settling,
    steps,
    tool_truth,
    truth_of,
    wrist,
    write,
)

_WRENCH = [f"{what}.{a}" for what in ("force", "torque") for a in "xyz"]
_FT = ["Fx", "Fy", "Fz", "Tx", "Ty", "Tz"]
_NS = 1_710_237_600_000_000_000


def _noisy_holds(
    rng: Rng, hold_s: float, rate_hz: float = 50.0
) -> tuple[Tool, Array, Array, Array]:
    """A wrist that turns between holds: t, wrenches, quaternions, one row after the other."""
    from scipy.spatial.transform import Rotation, Slerp

    poses, move = 14, 2.0
    turns = Rotation.from_euler("xyz", rng.uniform([-3.1, -1.4, -3.1], [3.1, 1.4, 3.1], (poses, 3)))
    knots = np.repeat(np.arange(poses) * (hold_s + move), 2)
    knots[1::2] += hold_s
    t = np.arange(0, knots[-1], 1 / rate_hz)
    rot = Slerp(knots, turns[np.repeat(np.arange(poses), 2)])(t)
    made = Tool(float(rng.uniform(6, 14)), np.array([0.004, -0.006, 0.07]), rng.normal(0, 1, 6)
                * np.array([5, 5, 5, 0.3, 0.3, 0.3]))  # fmt: skip
    return made, t, made.read(rot.inv().apply([0.0, 0.0, -1.0]), rng), rot.as_quat()


def rostopic_echo_p(to: Path, rng: Rng) -> Made:
    """`rostopic echo -p`: % before the names, the wrench and the pose in one custom message."""
    made, wrench, rot = wrist(rng)
    names = ["%time", "field.header.seq", "field.header.stamp", "field.header.frame_id"]
    names += [f"field.wrench.{n}" for n in _WRENCH]
    names += [f"field.pose.orientation.{a}" for a in "xyzw"]
    lines = [",".join(names)]
    for i, body in enumerate(rows(*wrench.T, *rot.as_quat().T, form="%.6f")):
        at = _NS + 20_000_000 * i
        lines.append(f"{at + 41_000},{i},{at},ft_sensor,{body}")
    return Made([write(to / "ft.csv", lines)], tool_truth(made))


def rostopic_two_topics(to: Path, rng: Rng) -> Made:
    """Two `rostopic echo -p` files: a wrench at 50 Hz and an inertial unit at 100 Hz."""
    made, wrench, rot = wrist(rng, 12, 50)
    names = ["%time", "field.header.seq", *(f"field.wrench.{n}" for n in _WRENCH)]
    lines, turns = [",".join(names)], ["%time,field.header.seq," + ",".join(
        f"field.orientation.{a}" for a in "xyzw")]  # fmt: skip
    for i, body in enumerate(rows(*wrench.T, form="%.6f")):
        lines.append(f"{_NS + 20_000_000 * i},{i},{body}")
    for i, body in enumerate(rows(*np.repeat(rot.as_quat(), 2, axis=0).T, form="%.6f")):
        turns.append(f"{_NS + 10_000_000 * i},{i},{body}")
    return Made([write(to / "ft.csv", lines), write(to / "imu.csv", turns)], tool_truth(made))


def plotjuggler_sparse(to: Path, rng: Rng) -> Made:
    """PlotJuggler's CSV: topics with slashes, the attitude only in every other row."""
    made, wrench, rot = wrist(rng, 12, 50)
    names = ["__time", *(f"/ft/wrench/{n.replace('.', '/')}" for n in _WRENCH)]
    names += [f"/imu/orientation/{a}" for a in "xyzw"]
    lines = [",".join(names)]
    felt, turned = rows(*wrench.T, form="%.6f"), rows(*rot.as_quat().T, form="%.6f")
    for i in range(len(wrench)):
        lines.append(f"{1710237600 + 0.02 * i:.6f},{felt[i]},{turned[i] if i % 2 == 0 else ',,,'}")
    return Made([write(to / "pj.csv", lines)], tool_truth(made))


def hold_of_five_seconds(to: Path, rng: Rng) -> Made:
    """A moving stream with holds of five seconds, two seconds between."""
    made, t, wrench, quat = _noisy_holds(rng, 5.0)
    body = rows(t, *wrench.T, *quat.T, form="%.6f")
    return Made([write(to / "arm.csv", [",".join(["t", *_FT, "qx", "qy", "qz", "qw"]), *body])],
                tool_truth(made))  # fmt: skip


def hold_of_two_seconds(to: Path, rng: Rng) -> Made:
    """A moving stream with holds of two seconds, two seconds between."""
    made, t, wrench, quat = _noisy_holds(rng, 2.0)
    body = rows(t, *wrench.T, *quat.T, form="%.6f")
    return Made([write(to / "arm.csv", [",".join(["t", *_FT, "qx", "qy", "qz", "qw"]), *body])],
                tool_truth(made))  # fmt: skip


def ati_daq_log(to: Path, rng: Rng) -> Made:
    """ATI DAQ FT: a preamble, quoted names with units, the attitude pasted in degrees."""
    made, wrench, rot = wrist(rng)
    angles = rot.as_euler("ZYX", degrees=True)
    names = ['"Fx (N)"', '"Fy (N)"', '"Fz (N)"', '"Tx (N-mm)"', '"Ty (N-mm)"', '"Tz (N-mm)"',
             '"Yaw (deg)"', '"Pitch (deg)"', '"Roll (deg)"']  # fmt: skip
    scaled = wrench * np.repeat([1.0, 1e3], 3)
    lines = ["ATI DAQ F/T Demo", "Serial: FT12345", "", ",".join(names),
             *rows(*scaled.T, *angles.T, form="%.5f")]  # fmt: skip
    return Made([write(to / "ati.csv", lines)], tool_truth(made))


def onrobot_decinewtons(to: Path, rng: Rng) -> Made:
    """OptoForce's counts: forces in 0.1 N and torques in 0.001 Nm, said in the names."""
    made, wrench, rot = wrist(rng)
    names = [f"F{a} [0.01 N]" for a in "xyz"] + [f"T{a} [0.001 Nm]" for a in "xyz"]
    counts = np.round(wrench * np.repeat([100.0, 1000.0], 3))
    lines = [";".join([*names, "qw", "qx", "qy", "qz"])]
    lines += rows(*counts.T, *rot.as_quat()[:, [3, 0, 1, 2]].T, sep=";", form="%.6g")
    return Made([write(to / "hex.csv", lines)], tool_truth(made))


def bota_with_temperature(to: Path, rng: Rng) -> Made:
    """Bota's log: status words, temperature, and its inertial unit's acceleration."""
    made, wrench, rot = wrist(rng)
    acc = rot.inv().apply([0, 0, G]) + rng.normal(0, 0.02, (len(wrench), 3))
    names = ["timestamp", "status", *(f"wrench_{n.replace('.', '_')}" for n in _WRENCH),
             "temperature", *(f"imu_acc_{a}" for a in "xyz")]  # fmt: skip
    n = len(wrench)
    lines = rows(1e-3 * np.arange(n), np.zeros(n), *wrench.T, 30 + 1e-3 * np.arange(n), *acc.T)
    return Made([write(to / "bota.csv", [",".join(names), *lines])], tool_truth(made))


def robotiq_terminal(to: Path, rng: Rng) -> Made:
    """Robotiq's stream as a terminal shows it: `( fx , fy , … )`, nothing about attitudes."""
    _, wrench, _ = wrist(rng, 8, 10)
    lines = ["( " + " , ".join(f"{v:.3f}" for v in w) + " )" for w in wrench]
    return Made([write(to / "robotiq.txt", lines)], says="attitude")


def kistler_two_dimensions(to: Path, rng: Rng) -> Made:
    """A plate at nine points: Fz, Mx and My, and where the rod stood; its CoP is -My/Fz, Mx/Fz."""
    lines = ["x_mm,y_mm,Fz (N),Mx (Nm),My (Nm)"]
    for x in (-150, 0, 150):
        for y in (-200, 0, 200):
            for _ in range(3):
                fz = rng.normal(400, 5)
                at = np.array([x, y]) * 1.02 + [2.0, -3.0] + rng.normal(0, 0.2, 2)
                lines.append(f"{x},{y},{fz:.2f},{fz * at[1] * 1e-3:.4f},{-fz * at[0] * 1e-3:.4f}")
    return Made([write(to / "spots.csv", lines)], cop_within_m=1.5e-3)


def bertec_fz_cop(to: Path, rng: Rng) -> Made:
    """Weights in the middle of a plate: a file for each, Fz, Mx, My, COPx, COPy."""
    one, paths = Cell(1.03, -4.0, 0.4), []
    for kg in (0, 10, 20, 40):
        fz = one.read(np.full(60, kg * G), rng, whole=False)
        mx, my = rng.normal(0, 0.1, (2, 60))
        lines = ["Time,Fz,Mx,My,COPx,COPy", "s,N,N.m,N.m,m,m"]
        lines += rows(np.arange(60) / 100, fz, mx, my, -my / (fz + 10), mx / (fz + 10), form="%.5f")
        paths.append(write(to / f"plate_{kg}kg.csv", lines))
    return Made(paths, truth_of(one, 400))


def amti_netforce_moving(to: Path, rng: Rng) -> Made:
    """AMTI NetForce: six columns without names, nothing said: a refusal that leads on."""
    body = rows(*rng.normal(0, 1, (6, 200)), form="%.4f")
    return Made([write(to / "trial01.txt", body)], says="attitude")


def opensim_mot_two_plates(to: Path, rng: Rng) -> Made:
    """OpenSim's .mot: who stood is in no place, so the next step is a weight."""
    t, n = np.arange(200) / 100, 200
    names = ["time"]
    columns: list[Array] = [t]
    for side, share in (("r", 0.5), ("l", 0.5)):
        names += [f"ground_force_{side}_v{a}" for a in "xyz"]
        names += [f"ground_force_{side}_p{a}" for a in "xyz"]
        up = share * 700 + rng.normal(0, 1, n)
        columns += [rng.normal(0, 1, n), up, rng.normal(0, 1, n)]
        columns += list(rng.normal(0, 0.01, (3, n)))
    lines = ["grf.mot", "version=1", "nRows=200", f"nColumns={len(names)}", "inDegrees=no",
             "endheader", "\t".join(names), *rows(*columns, sep="\t", form="%.6f")]  # fmt: skip
    return Made([write(to / "grf.mot", lines)], says="weigh")


def nexus_one_plate_weights(to: Path, rng: Rng) -> Made:
    """Vicon Nexus: `Devices`, the rate, names, units, a file for each weight."""
    one, paths = Cell(-1.02, 3.0, 0.5), []
    for kg in (0, 5, 10, 20):
        fz = one.read(np.full(80, kg * G), rng, whole=False)
        lines = ["Devices", "1000", ",,AMTI - Force,,,AMTI - Moment,,",
                 "Frame,Sub Frame,Fx,Fy,Fz,Mx,My,Mz", ",,N,N,N,N.mm,N.mm,N.mm"]  # fmt: skip
        lines += rows(1 + np.arange(80) // 10, np.arange(80) % 10, *rng.normal(0, 0.3, (2, 80)),
                      fz, *rng.normal(0, 9, (3, 80)), form="%.6g")  # fmt: skip
        paths.append(write(to / f"Trial {kg}kg.csv", lines, end="\r\n"))
    return Made(paths, truth_of(one, 200))


def moticon_insole(to: Path, rng: Rng) -> Made:
    """Moticon: total forces of two insoles, a person whose weight nobody wrote."""
    t = np.arange(300) / 100
    left = np.clip(350 + 340 * np.sin(5 * t), 0, None) + rng.normal(0, 2, 300)
    lines = ["# Name: walk 1", "# sampling rate: 100 Hz", "#",
             "time[s]\tleft total force[N]\tleft center of pressure X\tright total force[N]\t"
             "right center of pressure X",
             *rows(t, left, rng.normal(0, 0.1, 300), 700 - left, rng.normal(0, 0.1, 300),
                   sep="\t", form="%.4f")]  # fmt: skip
    return Made([write(to / "moticon.txt", lines)], says="weigh")


def pedar_fgt(to: Path, rng: Rng) -> Made:
    """Pedar's .fgt: forces in N of both feet, known masses stood on them one after another."""
    one = Cell(1.08, 6.0, 1.0)
    lines = ["file name: calib", "sensor type: pedar", "", "time[secs]\tmass[kg]\tforce left [N]"]
    kg = steps((0, 20, 40, 80), 20)
    lines += rows(np.arange(kg.size) / 50, kg, one.read(kg * G, rng, whole=False), sep="\t",
                  form="%.4f")  # fmt: skip
    return Made([write(to / "calib.fgt.txt", lines)], truth_of(one, 800))


def ankle_of_biped_hung(to: Path, rng: Rng) -> Made:
    """Two ankles hung by hand in poses; a row for each pose with leg, gravity in the frame."""
    lines = ["pose,ankle,g_x,g_y,g_z,fx,fy,fz,mx,my,mz"]
    values: dict[str, float] = {}
    within: dict[str, float] = {}
    for leg in ("left", "right"):
        made, wrench, rot = wrist(rng, 20, 1)
        down = rot.inv().apply([0.0, 0.0, -1.0])
        lines += [f"{i},{leg},{body}" for i, body in enumerate(rows(*down.T, *wrench.T,
                                                                 form="%.5f"))]  # fmt: skip
        truth = tool_truth(made, leg)
        values |= truth.values
        within |= truth.within
    return Made([write(to / "ankles.csv", lines)], Truth(values, within))


def json_of_topics(to: Path, rng: Rng) -> Made:
    """A rosbag as JSON lines: a topic, a stamp, a message in each line."""
    made, wrench, rot = wrist(rng)
    lines = []
    for i, (w, q) in enumerate(zip(wrench, rot.as_quat(), strict=True)):
        at = 1710237600 + 0.02 * i
        lines.append(json.dumps({"topic": "/ft", "t": at, "msg": {"wrench": {
            "force": dict(zip("xyz", w[:3].round(5), strict=True)),
            "torque": dict(zip("xyz", w[3:].round(5), strict=True))}}}))  # fmt: skip
        lines.append(json.dumps({"topic": "/imu", "t": at + 0.001, "msg": {
            "orientation": dict(zip("xyzw", q.round(6), strict=True))}}))  # fmt: skip
    return Made([write(to / "bag.jsonl", lines)], tool_truth(made))


def matrices_and_a_hang_log(to: Path, rng: Rng) -> Made:
    """A hang log with stamps, and a file of rotation matrices, nine numbers a line, with stamps."""
    made, wrench, rot = wrist(rng, 14, 20)
    t = 0.02 * np.arange(len(wrench))
    lines = [",".join(["t", *_FT]), *rows(t, *wrench.T, form="%.5f")]
    turns = ["t," + ",".join(f"R{i}{j}" for i in "123" for j in "123"),
             *rows(t, *rot.as_matrix().reshape(-1, 9).T, form="%.6f")]  # fmt: skip
    return Made([write(to / "ft.csv", lines), write(to / "rot.csv", turns)], tool_truth(made))


def walk_without_weights(to: Path, rng: Rng) -> Made:
    """Counts of four feet in a walk: nothing known stood on them."""
    t = np.arange(400) / 100
    feet = {leg: cell(rng) for leg in ("FL", "FR", "RL", "RR")}
    read = [one.read(np.clip(60 * np.sin(6 * t + i), 0, None), rng)
            for i, one in enumerate(feet.values())]  # fmt: skip
    lines = [",".join(["time_s", *(f"{leg}_foot_raw" for leg in feet)]),
             *rows(t, *read, form="%.10g")]  # fmt: skip
    return Made([write(to / "walk.csv", lines)], says="weigh")


def holds_of_weights_short(to: Path, rng: Rng) -> Made:
    """One cell, a stream in which weights lie for five seconds; the notes say which."""
    one = cell(rng)
    load = settling([0, 9.80665, 19.6133, 49.03325, 0], 5, 10, 1.5)
    lines = ["# loads in order: 0, 1, 2, 5, 0 kg", "t,raw",
             *rows(np.arange(load.size) / 10, one.read(load, rng))]  # fmt: skip
    return Made([write(to / "stairs.csv", lines)], truth_of(one, 50))


def flat_message_with_groups(to: Path, rng: Rng) -> Made:
    """A bag as rosbag_to_csv flattens it: groups as empty columns, bare axes behind them."""
    made, wrench, rot = wrist(rng)
    lines = ["rosbagTimestamp,header,seq,stamp,secs,nsecs,frame_id,wrench,force,x,y,z,torque,x.1,"
             "y.1,z.1,roll_deg,pitch_deg,yaw_deg"]  # fmt: skip
    turned = rot.as_euler("xyz", degrees=True)
    for i, (w, e) in enumerate(zip(wrench, turned, strict=True)):
        sec, nanosec = divmod(_NS + 20_000_000 * i, 10**9)
        force, torque, angles = (rows(*v[:, None], form="%.5f")[0] for v in (w[:3], w[3:], e))
        lines.append(f"{sec},,{i},,{sec},{nanosec},ft,,,{force},,{torque},{angles}")
    return Made([write(to / "bag.csv", lines)], tool_truth(made))


def topics_for_legs(to: Path, rng: Rng) -> Made:
    """Two legs that are called by their topics, slashes and all."""
    lines = ["topic,fx,fy,fz,tx,ty,tz,qx,qy,qz,qw"]
    values: dict[str, float] = {}
    within: dict[str, float] = {}
    for leg in ("left", "right"):
        made, wrench, rot = wrist(rng, 14, 10)
        lines += [f"/ft/{leg},{x}" for x in rows(*wrench.T, *rot.as_quat().T, form="%.5f")]
        truth = tool_truth(made, leg)
        values |= truth.values
        within |= truth.within
    return Made([write(to / "legs.csv", lines)], Truth(values, within))


TWENTY_THIRD_ROBOTS = (
    rostopic_echo_p, rostopic_two_topics, plotjuggler_sparse, hold_of_five_seconds,
    hold_of_two_seconds, ati_daq_log, onrobot_decinewtons, bota_with_temperature,
    robotiq_terminal, kistler_two_dimensions, bertec_fz_cop, amti_netforce_moving,
    opensim_mot_two_plates, nexus_one_plate_weights, moticon_insole, pedar_fgt,
    ankle_of_biped_hung, json_of_topics, matrices_and_a_hang_log, walk_without_weights,
    holds_of_weights_short, flat_message_with_groups, topics_for_legs,
)  # fmt: skip
