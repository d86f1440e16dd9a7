"""Arms and robots of people nobody met, hung and in poses, as their tools log them."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from tests.strangers.legged import _hung, _legs
from tests.strangers.rigs import (
    Array,
    G,
    Made,
    Rng,
    Truth,
    rows,
    tool_truth,
    wrist,
    write,
)


def arm_by_g(to: Path, rng: Rng) -> Made:
    """A tool with an accelerometer in g on it, the clock's milliseconds, spaces between."""
    made, wrenches, body = wrist(rng)
    acc = body.inv().apply([0.0, 0.0, 1.0]) + rng.normal(0, 0.004, (len(wrenches), 3))
    begin = datetime(2026, 5, 18, 23, 59, 50)
    lines = ["time Fx Fy Fz Mx My Mz ax(g) ay(g) az(g)"]
    for i, row in enumerate(np.hstack([wrenches, acc])):
        stamp = (begin + timedelta(seconds=0.02 * i)).strftime("%H:%M:%S.%f")[:-3]
        lines.append(" ".join([stamp, *(f"{v:.4f}" for v in row)]))
    return Made([write(to / "tool.txt", lines)], tool_truth(made))


def legs_in_their_files(to: Path, rng: Rng) -> Made:
    """`LF.txt … RH.txt` and `imu.txt`: rows by their number, the rate in a line above."""
    wrenches, _, body, truth = _hung(rng, ("LF", "RF", "LH", "RH"))
    n, paths = len(body), []
    for name, wrench in wrenches.items():
        lines = [f"# ATI Mini45 {name}", "# rate = 50 Hz", "# n Fx Fy Fz Tx Ty Tz [N, Nm]"]
        lines += rows(np.arange(n), *wrench.T, sep=" ", form="%.5g")
        paths.append(write(to / f"{name}.txt", lines))
    angles = body.as_euler("xyz", degrees=True)
    lines = ["# xsens, 50 Hz", "# n roll pitch yaw [deg]",
             *rows(np.arange(n), *angles.T, sep=" ", form="%.6g")]  # fmt: skip
    named = _renamed(truth, {"LF": "fl", "RF": "fr", "LH": "hl", "RH": "hr"})
    return Made([*paths, write(to / "imu.txt", lines)], named)


def italian_hexapod(to: Path, rng: Rng) -> Made:
    """Legs `SX1 … DX3`, angles `rollio, beccheggio, imbardata`, decimal commas."""
    names = ("SX1", "SX2", "SX3", "DX3", "DX2", "DX1")
    wrenches, t, body, truth = _hung(rng, names)
    head = ["Tempo [s]", "Rollio [°]", "Beccheggio [°]", "Imbardata [°]"]
    units = ("N", "N", "N", "Nm", "Nm", "Nm")
    head += [f"{leg} {a} [{u}]" for leg in names
             for a, u in zip(("Fx", "Fy", "Fz", "Mx", "My", "Mz"), units, strict=True)]  # fmt: skip
    data = rows(t, *body.as_euler("xyz", degrees=True).T,
                *np.hstack([wrenches[n] for n in names]).T, sep=";", form="%.5f")  # fmt: skip
    lines = [";".join(head), *(x.replace(".", ",") for x in data)]
    return Made(
        [write(to / "appeso.csv", lines)],
        _renamed(truth, {n: f"{n[:2].lower()}_{n[2]}" for n in names}),
    )


def _renamed(truth: Truth, names: dict[str, str]) -> Truth:
    """The truth of legs under the names that footcal gives them."""

    def named(values: Mapping[str, float]) -> dict[str, float]:
        return {names[(p := n.split("."))[0]] + "." + p[1]: v for n, v in values.items()}

    return Truth(named(truth.values), named(truth.within))


def vicon_helical(to: Path, rng: Rng) -> Made:
    """Nexus: the sensor as a device at 500 Hz, the body as a segment of helical angles at 100."""
    made, _, body = wrist(rng, hold=60)
    fine = Rotation.from_quat(np.repeat(body.as_quat(), 5, axis=0))
    wrench = made.read(-fine.as_matrix()[:, 2, :], rng)
    frames = np.arange(len(body))
    lines = ["Devices", "500", ",,FT Sensor - Force,,,FT Sensor - Moment,,",
             "Frame,Sub Frame,Fx,Fy,Fz,Mx,My,Mz", ",,N,N,N,N.mm,N.mm,N.mm"]  # fmt: skip
    scaled = wrench * np.array([1.0] * 3 + [1e3] * 3)
    number, sub = np.repeat(frames + 1, 5), np.tile(np.arange(5), len(body))
    lines += rows(number, sub, *scaled.T, form="%.7g")
    lines += ["", "Segments", "100", ",,arm:flange,,,,,", "Frame,Sub Frame,RX,RY,RZ,TX,TY,TZ",
              ",,deg,deg,deg,mm,mm,mm"]  # fmt: skip
    turn = np.degrees(body.as_rotvec())
    place = 1e3 * rng.normal(0, 0.2, (len(body), 3))
    lines += rows(frames + 1, np.zeros(len(body)), *turn.T, *place.T, form="%.7g")
    return Made([write(to / "Trial 07.csv", lines, end="\r\n")], tool_truth(made), "attitude")


def ros_with_losses(to: Path, rng: Rng) -> Made:
    """`/ft_sensor/wrench.wrench.force.x` beside `/tf` of the flange; rows doubled and lost."""
    made, wrench, body = wrist(rng, hold=40)
    keep = np.sort(rng.choice(len(wrench), int(0.95 * len(wrench)), replace=False))
    keep = np.sort(np.concatenate([keep, keep[::40]]))
    head = ["/ft_sensor/wrench.header.stamp.sec", "/ft_sensor/wrench.header.stamp.nanosec"]
    head += [f"/ft_sensor/wrench.wrench.{k}.{a}" for k in ("force", "torque") for a in "xyz"]
    head += [f"/tf.base_link.flange.rotation.{a}" for a in "wxyz"]
    ns = 1_779_000_000_000_000_000 + (8_000_000 * np.arange(len(wrench)))
    lines, q = [",".join(head)], np.roll(body.as_quat(), 1, axis=1)
    for i in keep:
        values = [f"{v:.6f}" for v in [*wrench[i], *q[i]]]
        if i % 97 == 5:
            values[2] = "nan"
        lines.append(",".join([f"{ns[i] // 10**9}", f"{ns[i] % 10**9}", *values]))
    return Made([write(to / "bag.csv", lines)], tool_truth(made))


_HELD = 120
"""Rows of a pose that is stood in."""
_HIPS = np.array([[0.2, 0.1, 0.0], [0.0, 0.14, 0.0], [-0.2, 0.1, 0.0],
                  [-0.2, -0.1, 0.0], [0.0, -0.14, 0.0], [0.2, -0.1, 0.0]])  # fmt: skip


def _posed(rng: Rng, names: tuple[str, ...], poses: int = 30) -> tuple[
    dict[str, Array], dict[str, Array], Rotation, Rotation, Truth
]:  # fmt: skip
    """A hexapod hung in 14 attitudes, then stood in poses: wrenches, attitudes, the truth.

    A transducer feels all that acts on its leg: gravity, and the ground in a stand.
    """
    trunk = 9.0
    legs = _legs(rng, names)
    hung = Rotation.from_euler("xyz", np.repeat(
        rng.uniform([-1.2, -1.2, -3], [1.2, 1.2, 3], (14, 3)), 30, axis=0))  # fmt: skip
    stood = Rotation.from_euler("xyz", np.repeat(
        rng.uniform(-0.25, 0.25, (poses, 3)), _HELD, axis=0))  # fmt: skip
    down, under = hung.inv().apply([0, 0, -1.0]), stood.inv().apply([0, 0, -1.0])
    hang: dict[str, Array] = {}
    stand: dict[str, Array] = {}
    values: dict[str, float] = {}
    within: dict[str, float] = {}
    whole, moment = trunk * G, np.array([0.01, -0.005, 0.02]) * trunk * G
    feet = []
    for at, (tool, frame) in zip(_HIPS, legs.values(), strict=True):
        whole += tool.weight_n
        moment = moment + tool.weight_n * (at + frame.apply(tool.com_m))
        out = np.array([at[0], at[1], 0.0]) / np.hypot(at[0], at[1])
        feet.append(at + 0.12 * out + [0, 0, -0.2])
    com = moment / whole
    pushes = np.zeros((len(under), len(names), 3))
    for k in range(0, len(under), _HELD):
        tripod = k // _HELD % 6
        standing = np.arange(6) if tripod % 3 else np.array([0, 2, 4] if tripod else [1, 3, 5])
        grip = np.zeros((6, 3 * standing.size))
        for j, f in enumerate(standing):
            grip[:3, 3 * j : 3 * j + 3] = np.eye(3)
            grip[3:, 3 * j : 3 * j + 3] = np.cross(np.eye(3), feet[f], axisa=0, axisb=0).T * -1
        need = -np.concatenate([whole * under[k], np.cross(com, whole * under[k])])
        force = np.linalg.pinv(grip) @ need
        null = np.eye(force.size) - np.linalg.pinv(grip) @ grip
        force = force + null @ rng.normal(0, 6, force.size)
        assert np.allclose(grip @ force, need)
        for j, f in enumerate(standing):
            pushes[k : k + _HELD, f] = force[3 * j : 3 * j + 3]
    for i, (name, (tool, frame)) in enumerate(legs.items()):
        hang[name] = tool.read(frame.inv().apply(down), rng)
        arm = feet[i] - _HIPS[i]
        felt = np.hstack([frame.inv().apply(pushes[:, i]),
                          frame.inv().apply(np.cross(arm, pushes[:, i]))])  # fmt: skip
        stand[name] = tool.read(frame.inv().apply(under), rng) + felt
        truth = tool_truth(tool, name)
        values |= truth.values
        within |= truth.within
    return hang, stand, hung, stood, Truth(values, within)


_SIX = ("fx", "fy", "fz", "tx", "ty", "tz")


def german_poses(to: Path, rng: Rng) -> Made:
    """A row for each leg and sample: `Pose;Bein;Fx …;Rollen;Nicken;Gieren`, hung and stood."""
    names = ("VL", "ML", "HL", "HR", "MR", "VR")
    hang, stand, hung, stood, truth = _posed(rng, names)
    paths = []
    for file, wrench, body, hold in (
        ("haengend", hang, hung, 30),
        ("stehend", stand, stood, _HELD),
    ):
        angles = body.as_euler("xyz", degrees=True)
        lines = ["Zeit;Pose;Bein;Fx;Fy;Fz;Mx;My;Mz;Rollen;Nicken;Gieren",
                 "s;;;N;N;N;Nm;Nm;Nm;Grad;Grad;Grad"]  # fmt: skip
        for i in range(len(angles)):
            for leg in names:
                said = [f"{i / 50:.2f}", f"{i // hold + 1}", leg]
                said += [f"{v:.5f}" for v in (*wrench[leg][i], *angles[i])]
                lines.append(";".join(said).replace(".", ","))
        paths.append(write(to / f"{file}.csv", lines, "cp1252"))
    return Made(paths, truth)


def numbered_legs_and_hips(to: Path, rng: Rng) -> Made:
    """`leg_1_fx …` hung and stood, quaternions, a sheet of where the hips are in mm."""
    names = tuple(f"leg_{i}" for i in range(1, 7))
    hang, stand, hung, stood, truth = _posed(rng, names)
    paths = []
    for file, wrench, body, hold in (("hang", hang, hung, 30), ("stand", stand, stood, _HELD)):
        head = ["t", "pose", *(f"imu_q{a}" for a in "wxyz")]
        head += [f"{leg}_{a}" for leg in names for a in _SIX]
        q = np.roll(body.as_quat(), 1, axis=1)
        n = len(q)
        lines = [",".join(head), *rows(np.arange(n) / 50, np.arange(n) // hold, *q.T, *np.hstack(
            [wrench[leg] for leg in names]).T, form="%.8g")]  # fmt: skip
        paths.append(write(to / f"{file}.csv", lines))
    sheet = ["leg,x_mm,y_mm,z_mm", *(f"{n},{x:.1f},{y:.1f},{z:.1f}" for n, (x, y, z) in
                                     zip(names, 1e3 * _HIPS, strict=True))]  # fmt: skip
    return Made([*paths, write(to / "hips.csv", sheet)], truth)


THIRTY_FIRST_ROBOTS = (
    arm_by_g, legs_in_their_files, italian_hexapod, vicon_helical, ros_with_losses, german_poses,
    numbered_legs_and_hips,
)  # fmt: skip
