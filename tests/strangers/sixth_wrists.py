"""Logs as tools write them, IV: transducers with what hangs on them, and how they were held."""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from tests.strangers.rigs import (
    Array,
    Made,
    Rng,
    Tool,
    Truth,
    attitudes,
    rows,
    tool,
    tool_truth,
    write,
)

SIDES = {"+x": (1, 0, 0), "-x": (-1, 0, 0), "+y": (0, 1, 0), "-y": (0, -1, 0),
         "+z": (0, 0, 1), "-z": (0, 0, -1)}  # fmt: skip


def _wrist(rng: Rng, poses: int = 12, hold: int = 25) -> tuple[Tool, Array, Rotation]:
    """Tool, wrenches, attitudes of the sensor (body to world, z up)."""
    made = tool(rng)
    rot, _ = attitudes(rng, poses, hold)
    return made, made.read(-rot[:, 2, :], rng), Rotation.from_matrix(rot)


def _turned(rng: Rng, poses: int, hold: int, move: int) -> tuple[Tool, Array, Rotation, Array]:
    """A wrist that stops and goes: wrench, attitudes, whether it moves."""
    made = tool(rng)
    rot, _ = attitudes(rng, poses, 1)
    keys = Rotation.from_matrix(rot)
    parts, moving = [Rotation.concatenate([keys[0]] * hold)], [np.zeros(hold, bool)]
    for a, b in pairwise(keys):
        s = np.linspace(0, 1, move)
        turn = (a.inv() * b).as_rotvec()
        parts.append(a * Rotation.from_rotvec((3 * s**2 - 2 * s**3)[:, None] * turn))
        parts.append(Rotation.concatenate([b] * hold))
        moving += [np.ones(move, bool), np.zeros(hold, bool)]
    path, moves = Rotation.concatenate(parts), np.concatenate(moving)
    wrench = made.read(path.inv().apply([0.0, 0.0, -1.0]), rng)
    wrench[moves] += rng.normal(0, 1, (int(moves.sum()), 6)) * [1.5] * 1
    return made, wrench, path, moves


def ati_rdt_counts(to: Path, rng: Rng) -> Made:
    """ATI's Net F/T demo: counts, their worth stated above the table; a file per side."""
    made, paths = tool(rng), []
    for name, down in SIDES.items():
        wrench = made.read(np.tile(np.array(down, float), (60, 1)), rng) * 1e6
        head = ["FT Serial: FT12345", "RDT Sample Rate: 100", "Force Units: N",
                "Counts per Unit Force: 1000000", "Torque Units: Nm",
                "Counts per Unit Torque: 1000000",
                "Status (hex),RDT Sequence,F/T Sequence,Fx,Fy,Fz,Tx,Ty,Tz,Time"]  # fmt: skip
        lines = [f'0x00000000,{i + 1},{70000 + 70 * i},' + ",".join(f"{v:.0f}" for v in w)
                 + f",10:11:{12 + i // 100:02d}.{10 * (i % 100):03d} AM"
                 for i, w in enumerate(wrench)]  # fmt: skip
        paths.append(write(to / f"gravity_{name}.csv", [*head, *lines], end="\r\n"))
    return Made(paths, tool_truth(made))


def foxglove_two_topics(to: Path, rng: Rng) -> Made:
    """Foxglove's export of two topics: time of receipt and header in two columns each."""
    made, wrench, rot = _wrist(rng)
    one = ["receiveTime,header.stamp.sec,header.stamp.nanosec,header.frame_id,"
           + ",".join(f"wrench.{k}.{a}" for k in ("force", "torque") for a in "xyz")]  # fmt: skip
    two = ["receiveTime,header.stamp.sec,header.stamp.nanosec,header.frame_id,"
           + ",".join(f"orientation.{a}" for a in "xyzw")]  # fmt: skip
    for i, (w, q) in enumerate(zip(wrench, rot.as_quat(), strict=True)):
        for late, lines, values, frame in ((0, one, w, "ft"), (2_300_000, two, q, "imu")):
            ns = i * 10_000_000 + late
            stamp = f"{1_700_000_000 + ns // 10**9},{ns % 10**9}"
            lines.append(f"{1_700_000_000 + ns // 10**9}.{(ns + 900_000) % 10**9:09d},{stamp},"
                         f"{frame}," + ",".join(f"{v:.8g}" for v in values))  # fmt: skip
    return Made([write(to / "ft_wrench.csv", one), write(to / "imu_data.csv", two)],
                tool_truth(made))  # fmt: skip


def ros2_echo_yaml(to: Path, rng: Rng) -> Made:
    """`ros2 topic echo /ft > plus_x.txt`: a YAML document per message; a file per side."""
    made, paths = tool(rng), []
    for name, down in SIDES.items():
        lines: list[str] = []
        for i, w in enumerate(made.read(np.tile(np.array(down, float), (40, 1)), rng)):
            lines += ["header:", "  stamp:", "    sec: 1700000000"]
            lines += [f"    nanosec: {i * 10_000_000}", "  frame_id: ft_sensor", "wrench:"]
            for j, kind in enumerate(("force", "torque")):
                lines.append(f"  {kind}:")
                lines += [f"    {a}: {float(w[3 * j + k])!r}" for k, a in enumerate("xyz")]
            lines.append("---")
        word = {"+": "plus", "-": "minus"}[name[0]]
        paths.append(write(to / f"{word}_{name[1]}_down.txt", lines))
    return Made(paths, tool_truth(made))


def bota_stop_and_go(to: Path, rng: Rng) -> Made:
    """Bota's sensor with its own accelerometer, turned by an arm that stops at ten attitudes."""
    made, wrench, rot, moves = _turned(rng, 10, 150, 80)
    acc = rot.inv().apply([0.0, 0.0, 9.81]) + rng.normal(0, 0.02, (len(wrench), 3))
    acc[moves] += rng.normal(0, 0.6, (int(moves.sum()), 3))
    head = ("timestamp_us,status,fx,fy,fz,mx,my,mz,acc_x,acc_y,acc_z,gyro_x,gyro_y,gyro_z,"
            "temperature")  # fmt: skip
    n = len(wrench)
    gyro = rng.normal(0, 0.002, (n, 3))
    gyro[moves] += rng.normal(0.5, 0.2, (int(moves.sum()), 3))
    body = rows(1e4 * np.arange(n) + 5e9, np.zeros(n), *wrench.T, *acc.T, *gyro.T,
                np.full(n, 31.5))  # fmt: skip
    return Made([write(to / "bota.csv", [head, *body])], tool_truth(made))


def weiss_kms40(to: Path, rng: Rng) -> Made:
    """Weiss's KMS40 over its socket: `F={…},stamp`; a capture per side."""
    made, paths = tool(rng), []
    for name, down in SIDES.items():
        wrench = made.read(np.tile(np.array(down, float), (50, 1)), rng)
        lines = ["F={" + ",".join(f"{v:.4f}" for v in w) + "}," + str(123000 + 2 * i)
                 for i, w in enumerate(wrench)]  # fmt: skip
        paths.append(write(to / f"kms40_{name}.txt", lines))
    return Made(paths, tool_truth(made))


def yarp_dumper(to: Path, rng: Rng) -> Made:
    """yarpdatadumper: a folder per port, no names: count, stamp, values (rpy in degrees first)."""
    made, wrench, rot = _wrist(rng, 14, 30)
    rpy = rot.as_euler("xyz", degrees=True)
    acc = rot.inv().apply([0.0, 0.0, 9.80665])
    paths: list[Path] = []
    for folder, table in (
        ("right_arm_ft", wrench),
        ("inertial", np.hstack([rpy, acc, rng.normal(0, 1e-3, (len(acc), 3)), acc * 0 + 0.4])),
    ):
        (to / folder).mkdir()
        lines = [f"{i} {1_700_000_000 + 0.01 * i + 0.001 * len(paths):.6f} "
                 + " ".join(f"{v:.8g}" for v in row) for i, row in enumerate(table)]  # fmt: skip
        paths.append(write(to / folder / "data.log", lines))
    return Made(paths, tool_truth(made))


def mujoco_state(to: Path, rng: Rng) -> Made:
    """MuJoCo: sensordata by number, a free joint's seven positions (quaternion scalar first)."""
    made, wrench, rot = _wrist(rng)
    n = len(wrench)
    q = np.roll(rot.as_quat(), 1, axis=1)
    head = ["time", *(f"qpos_{i}" for i in range(7)), *(f"sensordata_{i}" for i in range(6))]
    body = rows(0.002 * np.arange(n), *np.tile([[0.4], [0.1], [0.9]], n), *q.T, *wrench.T)
    return Made([write(to / "mujoco.csv", [",".join(head), *body])], tool_truth(made))


def pybullet_tuples(to: Path, rng: Rng) -> Made:
    """PyBullet through pandas: six reaction forces and a quaternion as texts of tuples."""
    made, wrench, rot = _wrist(rng)
    lines = [",t,joint_reaction,link_orientation"]
    for i, (w, q) in enumerate(zip(wrench.tolist(), rot.as_quat().tolist(), strict=True)):
        lines.append(f'{i},{i / 240:.5f},"{tuple(w)}","{tuple(q)}"')
    return Made([write(to / "bullet.csv", lines)], tool_truth(made))


def px4_attitude(to: Path, rng: Rng) -> Made:
    """PX4: µs since boot, `q[0..3]` from forward-right-down to north-east-down; the wrench apart.

    The transducer's axes are the vehicle's; down is +z of the world.
    """
    made = tool(rng)
    rot = Rotation.from_matrix(attitudes(rng, 14, 40)[0])
    wrench = made.read(rot.inv().apply([0.0, 0.0, 1.0]), rng)
    q = np.roll(rot.as_quat(), 1, axis=1)
    t = 34_567_890 + 4000.0 * np.arange(len(q))
    names = [
        "timestamp",
        *(f"q[{i}]" for i in range(4)),
        *(f"delta_q_reset[{i}]" for i in range(4)),
    ]
    one = [",".join(names), *rows(t, *q.T, *np.tile([[1.0], [0], [0], [0]], len(q)))]
    two = ["timestamp,force[0],force[1],force[2],torque[0],torque[1],torque[2]",
           *rows(t + 900, *wrench.T)]  # fmt: skip
    return Made([write(to / "log_12_ft_sensor_0.csv", two),
                 write(to / "log_12_vehicle_attitude_0.csv", one)], tool_truth(made))  # fmt: skip


def motive_y_up(to: Path, rng: Rng) -> Made:
    """OptiTrack's Motive: five rows of header, y points up, position in mm; the wrench apart."""
    made = tool(rng)
    rot = Rotation.from_matrix(attitudes(rng, 12, 50)[0])
    wrench = made.read(rot.inv().apply([0.0, -1.0, 0.0]), rng)
    n = len(wrench)
    head = ["Format Version,1.23,Take Name,Take 001,Capture Frame Rate,100.0,Rotation Type,"
            "Quaternion,Length Units,Millimeters", "",
            ",Type" + ",Rigid Body" * 7, ",Name" + ",gripper" * 7, ",ID" + ",1" * 7,
            "," + ",Rotation" * 4 + ",Position" * 3,
            "Frame,Time (Seconds),X,Y,Z,W,X,Y,Z"]  # fmt: skip
    body = rows(np.arange(n), np.arange(n) / 100, *rot.as_quat().T,
                *rng.normal([[300], [900], [100]], 1, (3, n)))  # fmt: skip
    ft = ["Time (s),Fx (N),Fy (N),Fz (N),Mx (N.m),My (N.m),Mz (N.m)",
          *rows(np.arange(n) / 100, *wrench.T)]  # fmt: skip
    return Made([write(to / "ft.csv", ft), write(to / "take001.csv", [*head, *body])],
                tool_truth(made))  # fmt: skip


def unity_left_handed(to: Path, rng: Rng) -> Made:
    """Unity: left-handed and y up; the same products of components hold."""
    made = tool(rng)
    rot = Rotation.from_matrix(attitudes(rng, 12, 30)[0])
    wrench = made.read(rot.inv().apply([0.0, -1.0, 0.0]), rng)
    head = "Time.time,force.x,force.y,force.z,torque.x,torque.y,torque.z,rot.x,rot.y,rot.z,rot.w"
    body = rows(0.02 * np.arange(len(wrench)), *wrench.T, *rot.as_quat().T, form="%.6f")
    return Made([write(to / "unity.csv", [head, *body])], tool_truth(made))


def torque_first_spatial(to: Path, rng: Rng) -> Made:
    """A dynamics library's spatial force, [n; f] as `wrench_0 … 5`, and a matrix row by row."""
    made, wrench, rot = _wrist(rng)
    head = ["t", *(f"R_{i}{j}" for i in range(3) for j in range(3)),
            *(f"spatial_force_{i}" for i in range(6))]  # fmt: skip
    body = rows(1e-3 * np.arange(len(wrench)), *rot.as_matrix().reshape(-1, 9).T,
                *wrench[:, 3:].T, *wrench[:, :3].T)  # fmt: skip
    return Made([write(to / "spatial.csv", [",".join(head), *body])], tool_truth(made))


def hdf5_groups(to: Path, rng: Rng) -> Made:
    """HDF5: a group per device, units and the order of the quaternion as attributes."""
    import h5py

    made, wrench, rot = _wrist(rng)
    stamps = 1_700_000_000_000_000_000 + np.arange(len(wrench)) * 10_000_000
    with h5py.File(to / "session.h5", "w") as file:
        file.attrs["subject"] = "gripper"
        for group, parts in (
            ("sensors/ft", {"force": (wrench[:, :3], "N"), "torque": (wrench[:, 3:], "Nm")}),
            ("sensors/imu", {"quat": (np.roll(rot.as_quat(), 1, axis=1), "")}),
        ):
            made_group = file.create_group(group)
            made_group.create_dataset("t", data=stamps).attrs["unit"] = "ns"
            for name, (data, unit) in parts.items():
                made_group.create_dataset(name, data=data).attrs["unit"] = unit
        file["sensors/imu/quat"].attrs["order"] = "wxyz"
    return Made([to / "session.h5"], tool_truth(made))


def parquet_of_structs(to: Path, rng: Rng) -> Made:
    """Parquet with a struct per wrench and a list per quaternion, stamps as times of day."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    made, wrench, rot = _wrist(rng)
    ns = 1_700_000_000_000_000_000 + np.arange(len(wrench)) * 10_000_000
    table = pa.table({
        "timestamp": pa.array(ns, pa.timestamp("ns", tz="UTC")),
        "wrench": pa.array([{"force": dict(zip("xyz", w[:3], strict=True)),
                             "torque": dict(zip("xyz", w[3:], strict=True))}
                            for w in wrench.tolist()]),
        "orientation_xyzw": pa.array(rot.as_quat().tolist()),
    })  # fmt: skip
    pq.write_table(table, to / "wrist.parquet")
    return Made([to / "wrist.parquet"], tool_truth(made))


def json_lines_nested(to: Path, rng: Rng) -> Made:
    """rosbridge: a JSON object per line, the message two levels down."""
    made, wrench, rot = _wrist(rng)
    lines = []
    for i, (w, q) in enumerate(zip(wrench.tolist(), rot.as_quat().tolist(), strict=True)):
        lines.append(json.dumps({
            "op": "publish", "topic": "/wrist",
            "msg": {"stamp": {"secs": 1_700_000_000 + i // 100, "nsecs": (i % 100) * 10_000_000},
                    "force": dict(zip("xyz", w[:3], strict=True)),
                    "torque": dict(zip("xyz", w[3:], strict=True)),
                    "orientation": dict(zip("xyzw", q, strict=True))},
        }))  # fmt: skip
    return Made([write(to / "rosbridge.jsonl", lines)], tool_truth(made))


def known_wrenches_on_an_ankle(to: Path, rng: Rng) -> Made:
    """A transducer in a rig with weights on an arm: the wrench put on stands beside its reading."""
    gain = np.eye(6) + rng.normal(0, 0.02, (6, 6))
    offset = rng.normal(0, 1, 6) * [5, 5, 5, 0.3, 0.3, 0.3]
    put = rng.uniform(-1, 1, (48, 6)) * [100, 100, 200, 10, 10, 10]
    put = np.repeat(put, 4, axis=0)
    noise = rng.normal(0, 1, put.shape) * [0.05] * 1
    reading = np.linalg.solve(gain, put.T).T + offset + noise * [1, 1, 1, 0.05, 0.05, 0.05]
    axes = ("fx", "fy", "fz", "mx", "my", "mz")
    head = [f"{a}_applied" for a in axes] + [f"{a}_measured" for a in axes]
    # put = gain (reading − offset): a matrix, and a bias for each axis
    out = ("fx", "fy", "fz", "tx", "ty", "tz")
    values = {f"{a}.bias": float(v) for a, v in zip(out, -gain @ offset, strict=True)}
    values |= {"fx.scale": float(gain[0, 0]), "fx.scale_from_fz": float(gain[0, 2])}
    values |= {"tx.scale_from_mx": float(gain[3, 3]), "tz.scale_from_fy": float(gain[5, 1])}
    within = {n: 0.002 if "scale" in n else 0.2 if n[0] == "f" else 0.02 for n in values}
    return Made([write(to / "rig.csv", [",".join(head), *rows(*put.T, *reading.T)])],
                Truth(values, within))  # fmt: skip


SIXTH_WRISTS = (
    ati_rdt_counts, foxglove_two_topics, ros2_echo_yaml, bota_stop_and_go, weiss_kms40,
    yarp_dumper, mujoco_state, pybullet_tuples, px4_attitude, motive_y_up, unity_left_handed,
    torque_first_spatial, hdf5_groups, parquet_of_structs, json_lines_nested,
    known_wrenches_on_an_ankle,
)  # fmt: skip
