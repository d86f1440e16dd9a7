"""Twelve more logs, written after the mends of the thirty-first and run once on them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from tests.strangers.legged import _hung
from tests.strangers.rigs import (
    Array,
    G,
    Made,
    Rng,
    cell,
    rows,
    steps,
    tool_truth,
    truth_of,
    wrist,
    write,
)
from tests.strangers.thirty_first_robots import _HELD, _HIPS, _SIX, _posed, _renamed
from tests.strangers.thirty_first_stands import _counts, _march, _owner, _scales, _stances


def portuguese_sheet(to: Path, rng: Rng) -> Made:
    """Excel: the cell once per block, kilogram-force, millivolts with decimal commas."""
    names = ("Dianteira esquerda", "Dianteira direita", "Traseira esquerda", "Traseira direita")
    cells, lines = {n: cell(rng, "volt") for n in names}, ["Célula;Peso (kgf);Leitura (V)"]
    for name, one in cells.items():
        said = name
        for kgf in (0, 2, 4, 6, 8, 4, 0):
            read = float(one.read(np.array(kgf * G), rng, whole=False))
            lines.append(f"{said};{kgf};{read:.5f}".replace(".", ","))
            said = ""
    return Made([write(to / "calibração.csv", lines, "cp1252", "\r\n")], truth_of(cells, 80))


def dutch_sensors(to: Path, rng: Rng) -> Made:
    """Four sensors read, a column says which one was pressed by its number."""
    cells = {f"sensor_{i}": cell(rng, "hx_small") for i in (1, 2, 3, 4)}
    lines = ["tijd\tdrukpunt\tgewicht [g]\tsensor_1\tsensor_2\tsensor_3\tsensor_4"]
    t = 0.0
    for point, name in enumerate(cells, 1):
        for g in (0, 250, 500, 1000, 0):
            for _ in range(4):
                read = [c.read(np.array(g / 1000 * G * (n == name)), rng)
                        for n, c in cells.items()]  # fmt: skip
                said = "\t".join(f"{v:.0f}" for v in read)
                lines.append(f"{t:.2f}\t{point}\t{g}\t{said}")
                t += 0.25
    truth = truth_of({str(i): c for i, c in enumerate(cells.values(), 1)})
    return Made([write(to / "meting.txt", lines)], truth)


def german_events(to: Path, rng: Rng) -> Made:
    """A recorder with remarks of what was done: `500 g aufgelegt`, `abgenommen`."""
    one, lines, t = cell(rng), ["Zeit [s];Rohwert;Bemerkung"], 0.0
    for said, g in (("leer", 0), ("500 g aufgelegt", 500), ("abgenommen", 0),
                    ("1000 g aufgelegt", 1000), ("abgenommen", 0), ("2000 g aufgelegt", 2000),
                    ("abgenommen", 0)):  # fmt: skip
        for i in range(60):
            read = one.read(np.array(g / 1000 * G), rng)
            lines.append(f"{t:.1f};{read:.0f};{said if i == 0 else ''}".replace(".", ","))
            t += 0.1
    return Made([write(to / "Messung.csv", lines, "latin-1")], truth_of(one))


def german_files(to: Path, rng: Rng) -> Made:
    """A file for each corner, weight and direction: `VL_2kg_aufwärts.txt`."""
    cells, paths = {n: cell(rng) for n in ("VL", "VR", "HL", "HR")}, []
    for name, one in cells.items():
        for way, loads in (("aufwärts", (0, 1, 2, 5)), ("abwärts", (2, 1, 0))):
            for kg in loads:
                read = one.read(steps((kg * G,), 12), rng)
                paths.append(write(to / f"{name}_{kg}kg_{way}.txt", [f"{v:.0f}" for v in read]))
    return Made(paths, truth_of({n.lower(): c for n, c in cells.items()}, 50))


def faces_along_y(to: Path, rng: Rng) -> Made:
    """A robot that faces the laboratory's y: cells and markers in one table, millimetres."""
    stand = _stances(rng)
    read, scale = _counts(stand.cells, rng)
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    head = ["time_s", *(f"{s}_{p}" for s in ("left", "right") for p in ("fl", "fr", "rl", "rr"))]
    head += [f"{n}_{a}_mm" for n in ("com", "left_foot", "right_foot") for a in "xyz"]
    places = [1e3 * at @ turn.T + rng.normal(0, 0.1, at.shape)
              for at in (stand.com, stand.feet[:, 0], stand.feet[:, 1])]  # fmt: skip
    lines = [",".join(head), *rows(stand.time, *read.T, *np.hstack(places).T, form="%.9g")]
    names = [f"{s}_{p}" for s in ("left", "right") for p in ("fl", "fr", "rl", "rr")]
    return Made([write(to / "stand.csv", lines)], _scales(names, scale), "cells sit",
                fill=_owner())  # fmt: skip


def italian_soles(to: Path, rng: Rng) -> Made:
    """Toe and heel, inner and outer, of `piede sx` and `piede dx`; the mass stands above."""
    stand = _stances(rng)
    read, scale = _counts(stand.cells, rng)
    where = ("punta est", "punta int", "tallone est", "tallone int")
    head = ["tempo (s)", *(f"piede {s} {p}" for s in ("sx", "dx") for p in where)]
    head += [f"baricentro {a} (m)" for a in "xyz"]
    lines = ["robot: Nino; massa: 5,2 kg", ";".join(head)]
    lines += [x.replace(".", ",") for x in
              rows(stand.time, *read.T, *stand.com.T, sep=";", form="%.9g")]  # fmt: skip
    found = [f"{s}_{p.replace(' ', '_')}" for s in ("piede_sx", "piede_dx") for p in where]
    truth = _scales(found, scale)
    return Made([write(to / "in_piedi.csv", lines)], truth, "cells sit", fill=_owner())


def spanish_walk(to: Path, rng: Rng) -> Made:
    """`pie_izq_1 … pie_der_4`, the CoM as `cdm_x`, feet as `pos_pie_izq_x`."""
    walk = _march(rng)
    read, scale = _counts(walk.cells, rng)
    head = ["tiempo", *(f"pie_{s}_{i}" for s in ("izq", "der") for i in range(1, 5))]
    head += [f"cdm_{a}" for a in "xyz"]
    head += [f"pos_pie_{s}_{a}" for s in ("izq", "der") for a in "xyz"]
    body = [*walk.com.T, *walk.feet.reshape(-1, 6).T]
    lines = ["\t".join(head), *rows(walk.time, *read.T, *body, sep="\t", form="%.9g")]
    names = [f"{side}_{i}" for side in ("left", "right") for i in range(1, 5)]
    return Made([write(to / "marcha.tsv", lines)], _scales(names, scale), "cells sit",
                fill=_owner())  # fmt: skip


def six_files_and_imu(to: Path, rng: Rng) -> Made:
    """`front_left_ft.csv …` with ns stamps, an IMU whose quaternion is `orientation.x …`."""
    names = ("front_left", "middle_left", "rear_left", "rear_right", "middle_right", "front_right")
    wrenches, t, body, truth = _hung(rng, names)
    ns = np.round(1e9 * t).astype(np.int64) + 1_779_100_000_000_000_000
    paths = []
    for name, wrench in wrenches.items():
        lines = ["timestamp_ns,force.x,force.y,force.z,torque.x,torque.y,torque.z"]
        lines += [f"{n},{x}" for n, x in zip(ns, rows(*wrench.T, form="%.6g"), strict=True)]
        paths.append(write(to / f"{name}_ft.csv", lines))
    lines = ["timestamp_ns,orientation.x,orientation.y,orientation.z,orientation.w"]
    lines += [f"{n + 700_000},{x}" for n, x in zip(ns, rows(*body.as_quat().T, form="%.7g"),
                                                   strict=True)]  # fmt: skip
    called = dict(zip(names, ("fl", "ml", "rl", "rr", "mr", "fr"), strict=True))
    return Made([*paths, write(to / "imu.csv", lines)], _renamed(truth, called))


def milligravity(to: Path, rng: Rng) -> Made:
    """An accelerometer in mg beside a sensor in N and N·mm, numbered samples at a rate above."""
    made, wrenches, body = wrist(rng)
    acc = 1e3 * body.inv().apply([0.0, 0.0, 1.0]) + rng.normal(0, 4, (len(wrenches), 3))
    head = "Sample;Fx [N];Fy [N];Fz [N];Mx [Nmm];My [Nmm];Mz [Nmm];accX [mg];accY [mg];accZ [mg]"
    scaled = wrenches * np.array([1.0] * 3 + [1e3] * 3)
    lines = ["Sampling rate: 125 Hz", head,
             *rows(np.arange(len(acc)), *scaled.T, *acc.T, sep=";", form="%.6g")]  # fmt: skip
    return Made([write(to / "tool.csv", lines)], tool_truth(made))


def nested_legs(to: Path, rng: Rng) -> Made:
    """JSON lines: `{"legs": {"FL": {"f": […], "m": […]}}, "rpy_deg": […]}`."""
    wrenches, t, body, truth = _hung(rng, ("FL", "FR", "RL", "RR"))
    angles, lines = body.as_euler("xyz", degrees=True), []
    for i, at in enumerate(t):
        legs = {n: {"force": w[i, :3].round(5).tolist(), "torque": w[i, 3:].round(6).tolist()}
                for n, w in wrenches.items()}  # fmt: skip
        said = dict(zip(("roll", "pitch", "yaw"), angles[i].round(5).tolist(), strict=True))
        lines.append(json.dumps({"t": round(float(at), 3), "legs": legs, "rpy_deg": said}))
    called = {n: n.lower() for n in wrenches}
    return Made([write(to / "hang.jsonl", lines)], _renamed(truth, called))


def poses_in_time_alone(to: Path, rng: Rng) -> Made:
    """`L1 … R3` hung and stood, stamps alone, the hips in a sheet of centimetres."""
    names = ("L1", "L2", "L3", "R3", "R2", "R1")
    hang, stand, hung, stood, truth = _posed(rng, names)
    paths = []
    for file, wrench, body in (("suspended", hang, hung), ("standing", stand, stood)):
        head = ["time_s", "roll_deg", "pitch_deg", "yaw_deg", *(f"{n}_{a}" for n in names
                                                                for a in _SIX)]  # fmt: skip
        angles = body.as_euler("xyz", degrees=True)
        data: Array = np.hstack([wrench[n] for n in names])
        lines = [",".join(head), *rows(np.arange(len(data)) / 50, *angles.T, *data.T,
                                       form="%.7g")]  # fmt: skip
        paths.append(write(to / f"{file}.csv", lines))
    sheet = ["hip,x_cm,y_cm,z_cm", *(f"{n},{x:.1f},{y:.1f},{z:.1f}" for n, (x, y, z) in
                                     zip(names, 1e2 * _HIPS, strict=True))]  # fmt: skip
    return Made([*paths, write(to / "hips.csv", sheet)], truth)


def stood_first(to: Path, rng: Rng) -> Made:
    """A stand with pose numbers and another table for the hanging: other columns, another order."""
    names = tuple(f"hip{i}" for i in range(1, 7))
    hang, stand, hung, stood, truth = _posed(rng, names)
    head = ["time", "pose", *(f"{n}_{a}" for n in names for a in _SIX), "qw", "qx", "qy", "qz"]
    n = len(stood)
    q = np.roll(stood.as_quat(), 1, axis=1)
    lines = [",".join(head), *rows(np.arange(n) / 50, np.arange(n) // _HELD + 1, *np.hstack(
        [stand[k] for k in names]).T, *q.T, form="%.8g")]  # fmt: skip
    first = write(to / "a_poses.csv", lines)
    head = ["t", "qw", "qx", "qy", "qz", *(f"{n}_{a}" for n in names for a in _SIX)]
    q = np.roll(hung.as_quat(), 1, axis=1)
    lines = [",".join(head), *rows(np.arange(len(q)) / 50, *q.T, *np.hstack(
        [hang[k] for k in names]).T, form="%.8g")]  # fmt: skip
    called = {n: f"hip_{n[3]}" for n in names}
    return Made([first, write(to / "b_hang.csv", lines)], _renamed(truth, called))


THIRTY_SECOND = (
    portuguese_sheet, dutch_sensors, german_events, german_files, faces_along_y, italian_soles,
    spanish_walk, six_files_and_imu, milligravity, nested_legs, poses_in_time_alone, stood_first,
)  # fmt: skip
