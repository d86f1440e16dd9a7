"""Logs as tools write them, V: robots on their feet, insoles, and robots hung up."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from tests.strangers.legged import _hung
from tests.strangers.rigs import Cell, G, Made, Rng, Truth, filled, rows, settling, write


def go2_lowstate_json(to: Path, rng: Rng) -> Made:
    """Unitree Go2, `lowstate` as JSON lines: four feet in a list, joints in a list of objects."""
    lines = []
    for i in range(400):
        lines.append(json.dumps({
            "tick": 1000 + 2 * i, "foot_force": [int(v) for v in rng.normal(36, 1, 4)],
            "imu_state": {"quaternion": [1.0, 0.0, 0.0, 0.0],
                          "accelerometer": rng.normal([0, 0, 9.81], 0.02).tolist()},
            "motor_state": [{"q": 0.1, "dq": 0.0} for _ in range(12)],
        }))  # fmt: skip
    return Made([write(to / "lowstate.jsonl", lines)], says="weigh")


def anymal_with_contacts_long(to: Path, rng: Rng) -> Made:
    """One row per foot and stamp, forces only; a person weighs the robot and all is there."""
    share = settling([0.25, 0.35, 0.2, 0.3], 4, 100)
    lines = ["timestamp,foot,Fx,Fy,Fz"]
    feet = {"LF": 0.5 - share, "RF": share, "LH": share, "RH": 0.5 - share}
    for i in range(share.size):
        for foot, part in feet.items():
            f = [rng.normal(0, 1), rng.normal(0, 1), 500 * part[i] + rng.normal(0, 0.5)]
            lines.append(f"{i / 100:.3f},{foot}," + ",".join(f"{v:.4f}" for v in f))
    names = dict.fromkeys(("fl", "fr", "hl", "hr"))
    truth = {f"{name}_foot.scale": 1.0 for name in names}
    return Made([write(to / "feet_long.csv", lines)], Truth(truth, dict.fromkeys(truth, 0.02)),
                says="weigh", fill=filled(mass_kg=f"{500 / G:.4f}"))  # fmt: skip


def isaac_contact_forces(to: Path, rng: Rng) -> Made:
    """Isaac: net contact forces of four feet, three numbers each, flattened by number."""
    n = 300
    force = np.zeros((n, 12))
    force[:, 2::3] = rng.normal(30, 1, (n, 4))
    head = ["step", "sim_time", *(f"net_contact_force[{i}]" for i in range(12))]
    body = rows(np.arange(n), np.arange(n) / 200, *force.T)
    return Made([write(to / "isaac.csv", [",".join(head), *body])], says="weigh")


def nao_qi_log(to: Path, rng: Rng) -> Made:
    """NAO through ALMemory: keys as long as paths, forces in kg, other keys beside."""
    n = 500
    side = {"L": "LFoot", "R": "RFoot"}
    names = [f"Device/SubDeviceList/{foot}/FSR/{where}/Sensor/Value"
             for foot in side.values()
             for where in ("FrontLeft", "FrontRight", "RearLeft", "RearRight")]  # fmt: skip
    names += [f"Device/SubDeviceList/InertialSensor/Acc{a}/Sensor/Value" for a in "XYZ"]
    data = [rng.normal(0.65, 0.01, n) for _ in range(8)]
    data += [rng.normal(0, 0.02, n), rng.normal(0, 0.02, n), rng.normal(-9.81, 0.02, n)]
    head = ["timestamp_ms", *names]
    body = rows(10.0 * np.arange(n), *data, sep=";")
    return Made([write(to / "naoqi.csv", [";".join(head), *body])], says="weigh")


def icub3_front_and_rear(to: Path, rng: Rng) -> Made:
    """iCub 3: two transducers in each foot, front and rear, whole-body names."""
    n, names, data = 300, ["time"], [np.arange(300) / 100]
    for foot in ("left", "right"):
        for part in ("front", "rear"):
            names += [f"{foot}_foot_{part}_ft_{a}" for a in ("fx", "fy", "fz", "mx", "my", "mz")]
            data += [*rng.normal(0, 0.5, (2, n)), rng.normal(82, 1, n), *rng.normal(0, 0.1, (3, n))]
    return Made([write(to / "wbd_dump.csv", [",".join(names), *rows(*data)])], says="weigh")


def pressure_matrix(to: Path, rng: Rng) -> Made:
    """Tekscan's F-Scan as ASCII: a matrix of cells per frame, nothing that a force can be of."""
    head = ["DATA_TYPE MOVIE", "VERSION F-Scan 7.0", "ROWS 12", "COLS 6", "ROW_SPACING 5.08 mm",
            "COL_SPACING 5.08 mm", "SECONDS_PER_FRAME 0.01", "UNITS RAW", "START_FRAME 1",
            "END_FRAME 20", "ASCII_DATA @@"]  # fmt: skip
    lines = list(head)
    for frame in range(20):
        lines += ["", f"Frame {frame + 1}"]
        lines += [",".join(str(v) for v in rng.integers(0, 120, 6)) for _ in range(12)]
    return Made([write(to / "fscan.asf", lines)], says="force")


def fscan_force_and_cof(to: Path, rng: Rng) -> Made:
    """F-Scan's graph export: force and centre of force of both feet, blank lines, frames."""
    n = 400
    head = ["F-Scan Version 7.00", "Patient: X", "",
            "Frame,Time (s),Left Force (N),Left COF X (mm),Left COF Y (mm),Right Force (N),"
            "Right COF X (mm),Right COF Y (mm)"]  # fmt: skip
    data = [np.arange(1.0, n + 1), np.arange(n) / 100]
    for _ in "LR":
        data += [rng.normal(350, 3, n), rng.normal(30, 1, n), rng.normal(110, 2, n)]
    return Made([write(to / "fscan_graph.csv", [*head, *rows(*data, form="%.3f")])], says="weigh")


def two_plates_shared(to: Path, rng: Rng) -> Made:
    """Bertec's acquisition: two plates, a person who shifts; whole wrenches, CoP missing."""
    share = settling([0.5, 0.3, 0.7, 0.45, 0.6, 0.5], 4, 100)
    n, weight, names, data = share.size, 68.0 * G, ["Time"], [np.arange(share.size) / 100]
    for i, part in ((1, share), (2, 1 - share)):
        names += [f"FP{i}_{a}" for a in ("Fx", "Fy", "Fz", "Mx", "My", "Mz")]
        fz = weight * part
        data += [*rng.normal(0, 0.5, (2, n)), fz + rng.normal(0, 1, n),
                 0.1 * fz + rng.normal(0, 0.3, n), -0.02 * fz + rng.normal(0, 0.3, n),
                 rng.normal(0, 0.2, n)]  # fmt: skip
    return Made([write(to / "bertec.csv", [",".join(names), *rows(*data)])], says="weigh")


def hung_by_accelerometer(to: Path, rng: Rng) -> Made:
    """A quadruped hung in fourteen attitudes; of its body only the accelerometer is known."""
    wrenches, t, body, truth = _hung(rng, ("fl", "fr", "rl", "rr"))
    acc = body.inv().apply([0.0, 0.0, 9.81]) + rng.normal(0, 0.02, (len(t), 3))
    head = ["t_s", *(f"base_acc_{a}" for a in "xyz")]
    head += [
        f"{leg.upper()}_hip_{axis}"
        for leg in wrenches
        for axis in ("fx", "fy", "fz", "tx", "ty", "tz")
    ]
    body_rows = rows(t, *acc.T, *np.hstack(list(wrenches.values())).T, form="%.7g")
    return Made([write(to / "hung.csv", [",".join(head), *body_rows])], truth)


def solo_torque_first_nwu(to: Path, rng: Rng) -> Made:
    """A quadruped hung up: `[τ; F]` per hip, a quaternion scalar first, north-east-down world."""
    wrenches, t, body, truth = _hung(rng, ("fl", "fr", "hl", "hr"))
    flip = Rotation.from_euler("x", 180, degrees=True)
    q = np.roll((flip * body).as_quat(), 1, axis=1)
    head = ["time", "base_qw", "base_qx", "base_qy", "base_qz"]
    head += [
        f"{leg.upper()}_{axis}" for leg in wrenches for axis in ("tx", "ty", "tz", "fx", "fy", "fz")
    ]
    data = np.hstack([np.roll(w, 3, axis=1) for w in wrenches.values()])
    body_rows = rows(t, *q.T, *data.T, form="%.7g")
    return Made([write(to / "hung_ned.csv", [",".join(head), *body_rows])], truth)


def four_cells_a_leg_long(to: Path, rng: Rng) -> Made:
    """A row per cell: milliseconds, foot, corner, counts."""
    lines = ["t_ms;foot;corner;raw"]
    cells = {
        (f, c): Cell(0.02, -6.0, 1.0) for f in ("left", "right") for c in ("fl", "fr", "rl", "rr")
    }
    for i in range(300):
        for (foot, corner), one in cells.items():
            lines.append(f"{5 * i};{foot};{corner};{one.read(np.asarray(8.0), rng):.0f}")
    return Made([write(to / "cells_long.csv", lines)], says="where the cells sit")


def plates_weighed(to: Path, rng: Rng) -> Made:
    """Two scales under a biped, kg and mm, German: a person adds the mass and gets the scales."""
    share = settling([0.3, 0.5, 0.7, 0.4, 0.6], 5, 50)
    n, mass, gain = share.size, 30.0, (1.06, 0.96)
    left, right = share * mass / gain[0], (1 - share) * mass / gain[1]
    names = ("Zeit [ms]", "Links Kraft [kg]", "Links CoP x [mm]", "Links CoP y [mm]",
             "Rechts Kraft [kg]", "Rechts CoP x [mm]", "Rechts CoP y [mm]")  # fmt: skip
    data = [20.0 * np.arange(n), left + rng.normal(0, 0.03, n), rng.normal(10, 1, n),
            rng.normal(60, 1, n), right + rng.normal(0, 0.03, n), rng.normal(10, 1, n),
            rng.normal(-60, 1, n)]  # fmt: skip
    lines = [";".join(names), *(x.replace(".", ",") for x in rows(*data, sep=";", form="%.4f"))]
    cells = {f"{side}_p{i}.scale": g for side, g in zip(("left", "right"), gain, strict=True)
             for i in (1, 2, 3)}  # fmt: skip
    within = {name: 0.03 * g for name, g in cells.items()}
    return Made([write(to / "waagen.csv", lines, encoding="latin-1")], Truth(cells, within),
                says="weigh", fill=filled(mass_kg=f"{mass}"))  # fmt: skip


SIXTH_ROBOTS = (
    go2_lowstate_json, anymal_with_contacts_long, isaac_contact_forces, nao_qi_log,
    icub3_front_and_rear, pressure_matrix, fscan_force_and_cof, two_plates_shared,
    hung_by_accelerometer, solo_torque_first_nwu, four_cells_a_leg_long, plates_weighed,
)  # fmt: skip
