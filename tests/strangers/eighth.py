"""Logs as laboratories keep them, IV: a short corpus to see whether the mends of the seventh hold.

Written after these mends, before it was run; `docs/bring_your_log.md` has its first count.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from tests.strangers.rigs import (
    Array,
    Cell,
    G,
    Made,
    Rng,
    Tool,
    Truth,
    attitudes,
    cell,
    rows,
    settling,
    steps,
    tool,
    tool_truth,
    truth_of,
    write,
)

LB = 0.45359237


def chinese_sheet(to: Path, rng: Rng) -> Made:
    """Names in Chinese, in the encoding of its Windows."""
    one, kg = cell(rng), steps((0, 1, 2, 5), 5)
    body = rows(np.arange(kg.size), kg, one.read(kg * G, rng))
    return Made([write(to / "标定.csv", ["序号,质量(kg),读数", *body], "gb18030")], truth_of(one))


def russian_sheet(to: Path, rng: Rng) -> Made:
    """Names in Russian, in the encoding of its Windows, decimal commas."""
    one, kg = cell(rng), steps((0, 0.5, 1, 2), 5)
    body = [x.replace(".", ",") for x in rows(kg, one.read(kg * G, rng), sep=";")]
    return Made([write(to / "тензо.csv", ["Масса, кг;Отсчёт АЦП", *body], "cp1251")], truth_of(one))


def italian_sheet(to: Path, rng: Rng) -> Made:
    """Points between thousands, commas for decimals, a row of units."""
    one, grams = Cell(4.6e-4, -45.0, 12.0), steps((0, 250, 500, 1000, 2000), 4)
    lines = ["Prova;Peso;Lettura ADC", ";g;"]
    for i, (g, c) in enumerate(zip(grams, one.read(grams * 1e-3 * G, rng), strict=True)):
        weight = f"{g:,.1f}".replace(",", " ").replace(".", ",").replace(" ", ".")
        lines.append(f"{i + 1};{weight};{c:,.0f}".replace(",000", ",000"))
    lines = [line if i < 2 else ";".join(
        f if j != 2 else f.replace(",", ".") for j, f in enumerate(line.split(";")))
        for i, line in enumerate(lines)]  # fmt: skip
    return Made([write(to / "taratura.csv", lines, "latin-1", "\r\n")], truth_of(one))


def influx_annotated(to: Path, rng: Rng) -> Made:
    """InfluxDB's annotated CSV: rows of types above, a row for each field."""
    cells, grams = {"fl": cell(rng), "fr": cell(rng)}, steps((0, 200, 500, 1000), 5)
    lines = ["#group,false,false,true,true,false,true,true",
             "#datatype,string,long,dateTime:RFC3339,string,double,string,double",
             "#default,_result,,,,,,", ",result,table,_time,cell,_value,_field,load_g"]  # fmt: skip
    for i, g in enumerate(grams):
        for j, (name, one) in enumerate(cells.items()):
            at = f"2024-03-12T10:00:{i:02d}Z"
            c = one.read(np.asarray(g * 1e-3 * G), rng)
            lines.append(f",,{j},{at},{name},{c:.0f},raw,{g:.0f}")
    return Made([write(to / "query.csv", lines)], truth_of(cells, 10))


def readings_in_pounds(to: Path, rng: Rng) -> Made:
    """A file per weight, the display's own load in pounds."""
    one, paths = Cell(1.05, -2.0, 0.02), []
    for pounds in (0, 2, 5, 10):
        read = one.read(np.full(30, pounds * LB * G), rng, whole=False) / (LB * G)
        lines = ["Date,Time,Load (lb)"]
        lines += [f"3/12/2024,10:{pounds:02d}:{i:02d},{v:.4f}" for i, v in enumerate(read)]
        paths.append(write(to / f"cal_{pounds}lb.csv", lines))
    return Made(paths, truth_of(one, 45))


def printed_tuples(to: Path, rng: Rng) -> Made:
    """MicroPython: a tuple of milliseconds and a reading on each line, a file per weight."""
    one, paths = cell(rng), []
    for grams in (0, 250, 500, 1000):
        read = one.read(np.full(20, grams * 1e-3 * G), rng)
        lines = [f"({120 * i + 503}, {c:.0f})" for i, c in enumerate(read)]
        paths.append(write(to / f"scale-{grams}g.txt", lines))
    return Made(paths, truth_of(one, 10))


def json_per_cell(to: Path, rng: Rng) -> Made:
    """A JSON object per reading: the cell by name, the load in an object of its own."""
    cells, lines = {"fl": cell(rng), "rr": cell(rng)}, []
    for name, one in cells.items():
        for g in steps((0, 500, 1000, 2000), 4):
            c = int(one.read(np.asarray(g * 1e-3 * G), rng))
            lines.append(json.dumps({"cell": name, "load": {"g": g}, "raw": c}))
    return Made([write(to / "bench.ndjson", lines)], truth_of(cells))


def days_of_excel(to: Path, rng: Rng) -> Made:
    """Stamps as days since 1900, as a sheet without formats gives them."""
    one, load = cell(rng), settling([0, 5, 10, 20, 10, 0], 5, 10)
    days = 45363.584 + np.arange(load.size) / 864000
    body = [f"{d:.9f},{f:.3f},{c:.0f}" for d, f, c in zip(days, load, one.read(load, rng),
                                                          strict=True)]  # fmt: skip
    return Made([write(to / "press.csv", ["Time,Load (N),ADC", *body])], truth_of(one))


def hours_minutes_seconds(to: Path, rng: Rng) -> Made:
    """Hours, minutes and seconds in a column each."""
    one, newton = cell(rng), steps((0, 5, 10, 20), 12)
    lines = ["Hour,Minute,Second,Load (N),ADC"]
    for i, (f, c) in enumerate(zip(newton, one.read(newton, rng), strict=True)):
        lines.append(f"14,{i // 60},{i % 60},{f:g},{c:.0f}")
    return Made([write(to / "logger.csv", lines)], truth_of(one))


def turned_sensor(to: Path, rng: Rng) -> Made:
    """A sensor that reads compression as negative newtons, masses beside it."""
    one, kg = Cell(-1.04, -1.3, 0.02), steps((0, 0.5, 1, 2), 6)
    body = rows(kg, one.read(kg * G, rng, whole=False), sep="\t", form="%.4f")
    return Made([write(to / "compression.tsv", ["mass (kg)\tmeasured force (N)", *body])],
                truth_of(one))  # fmt: skip


def steps_in_another_file(to: Path, rng: Rng) -> Made:
    """What was put on at each step stands in a file of its own."""
    one, kg = cell(rng), (0, 1, 2, 5)
    lines = ["step,raw"]
    for i, k in enumerate(kg):
        lines += [f"{i},{c:.0f}" for c in one.read(np.full(10, k * G), rng)]
    plan = ["step,load_kg", *(f"{i},{k}" for i, k in enumerate(kg))]
    return Made([write(to / "readings.csv", lines), write(to / "steps.csv", plan)], truth_of(one))


def mean_in_the_last_row(to: Path, rng: Rng) -> Made:
    """A sheet with its averages in the last row."""
    one, kg = cell(rng), steps((0, 1, 2, 5), 5)
    read = one.read(kg * G, rng)
    lines = ["No.,Load (kg),Reading", *rows(np.arange(1, kg.size + 1), kg, read)]
    lines.append(f"Average,{kg.mean():.3f},{read.mean():.1f}")
    return Made([write(to / "sheet.csv", lines)], truth_of(one))


def _wrist(rng: Rng, poses: int = 12, hold: int = 25) -> tuple[Tool, Array, Rotation]:
    made = tool(rng)
    rot, _ = attitudes(rng, poses, hold)
    return made, made.read(-rot[:, 2, :], rng), Rotation.from_matrix(rot)


def printed_lists_per_side(to: Path, rng: Rng) -> Made:
    """A driver's stream: six numbers in brackets with blanks, a file per side."""
    made, paths = tool(rng), []
    sides = {"x_plus": (1, 0, 0), "x_minus": (-1, 0, 0), "y_plus": (0, 1, 0), "y_minus":
             (0, -1, 0), "z_plus": (0, 0, 1), "z_minus": (0, 0, -1)}  # fmt: skip
    for name, down in sides.items():
        wrench = made.read(np.tile(np.array(down, float), (40, 1)), rng)
        lines = ["( " + " , ".join(f"{v:.3f}" for v in w) + " )" for w in wrench]
        paths.append(write(to / f"{name}.txt", lines))
    return Made(paths, tool_truth(made))


def vicon_segment(to: Path, rng: Rng) -> Made:
    """Nexus: a segment's rotation vector in degrees and its place, TX TY TZ no torques."""
    made, wrench, rot = _wrist(rng, 12, 40)
    n = len(wrench)
    head = ("Frame,RX (deg),RY (deg),RZ (deg),TX (mm),TY (mm),TZ (mm),"
            "Fx (N),Fy (N),Fz (N),Mx (N.mm),My (N.mm),Mz (N.mm)")  # fmt: skip
    body = rows(np.arange(n), *np.degrees(rot.as_rotvec()).T, *rng.normal(500, 1, (3, n)),
                *wrench[:, :3].T, *(1e3 * wrench[:, 3:]).T)  # fmt: skip
    return Made([write(to / "nexus.csv", [head, *body])], tool_truth(made))


def plain_names(to: Path, rng: Rng) -> Made:
    """Snake case, scalar first, epoch seconds."""
    made, wrench, rot = _wrist(rng)
    q = np.roll(rot.as_quat(), 1, axis=1)
    head = ("timestamp,quat_w,quat_x,quat_y,quat_z,force_x,force_y,force_z,"
            "torque_x,torque_y,torque_z")  # fmt: skip
    t = 1_700_000_000 + 0.01 * np.arange(len(q))
    body = [f"{a:.3f}," + ",".join(f"{v:.7g}" for v in (*b, *c))
            for a, b, c in zip(t, q, wrench, strict=True)]  # fmt: skip
    return Made([write(to / "wrist.csv", [head, *body])], tool_truth(made))


def bno055_gravity(to: Path, rng: Rng) -> Made:
    """An IMU on the sensor that reports its gravity vector, which points up."""
    made, wrench, rot = _wrist(rng, 14, 30)
    up = rot.inv().apply([0.0, 0.0, 9.81]) + rng.normal(0, 0.01, (len(wrench), 3))
    head = "millis;Fx;Fy;Fz;Tx;Ty;Tz;grav_x;grav_y;grav_z"
    body = rows(np.arange(len(up)) * 10.0, *wrench.T, *up.T, sep=";", form="%.6g")
    return Made([write(to / "bno.csv", [head, *body])], tool_truth(made))


def direction_cosines(to: Path, rng: Rng) -> Made:
    """`dcm_00 … dcm_22`, world to body."""
    made, wrench, rot = _wrist(rng)
    head = ["t", *(f"dcm_{i}{j}" for i in range(3) for j in range(3)),
            "fx", "fy", "fz", "tx", "ty", "tz"]  # fmt: skip
    body = rows(np.arange(len(wrench)) / 100, *rot.inv().as_matrix().reshape(-1, 9).T, *wrench.T)
    return Made([write(to / "dcm.csv", [",".join(head), *body])], tool_truth(made))


def two_arms(to: Path, rng: Rng) -> Made:
    """Both wrists of a robot in one table, each with an attitude of its own."""
    head, data = ["t"], [np.arange(300) / 100]
    values: dict[str, float] = {}
    within: dict[str, float] = {}
    for side in ("left", "right"):
        made, wrench, rot = _wrist(rng)
        head += [f"{side}_wrist_{a}" for a in ("fx", "fy", "fz", "tx", "ty", "tz")]
        head += [f"{side}_wrist_q{a}" for a in "xyzw"]
        data += [*wrench.T, *rot.as_quat().T]
        truth = tool_truth(made, side)
        values |= dict(truth.values)
        within |= dict(truth.within)
    table = write(to / "arms.csv", [",".join(head), *rows(*data)])
    return Made([table], Truth(values, within))


def balance_board(to: Path, rng: Rng) -> Made:
    """A balance board's four corners in counts."""
    head = "time,TL,TR,BL,BR"
    body = rows(np.arange(200) / 50, *rng.integers(9_000, 9_400, (4, 200)))
    return Made([write(to / "board.csv", [head, *body])], says="where the cells sit")


def nao_short_names(to: Path, rng: Rng) -> Made:
    """NAO's cells without blanks or marks."""
    names = [f"{s}{p}" for s in "LR" for p in ("FrontLeft", "FrontRight", "RearLeft", "RearRight")]
    body = rows(np.arange(200) / 100, *rng.normal(0.65, 0.01, (8, 200)))
    return Made([write(to / "fsr.csv", [",".join(["t", *names]), *body])],
                says="where the cells sit")  # fmt: skip


def quadruped_grf(to: Path, rng: Rng) -> Made:
    """Vertical ground reaction forces of four feet."""
    names = [f"grf_{leg}_z" for leg in ("FL", "FR", "RL", "RR")]
    body = rows(np.arange(300) / 500, *rng.normal(31, 0.5, (4, 300)))
    return Made([write(to / "grf.csv", [",".join(["time_s", *names]), *body])], says="weigh")


def humanoid_topics(to: Path, rng: Rng) -> Made:
    """PlotJuggler: both ankles, torques first, slashes."""
    names, data = ["__time"], [1.7e9 + np.arange(300) / 100]
    for side in ("left", "right"):
        names += [f"/{side}_ankle_ft/wrench/{k}/{a}" for k in ("torque", "force") for a in "xyz"]
        data += [*rng.normal(0, 0.5, (3, 300)), *rng.normal(0, 1, (2, 300)),
                 rng.normal(440, 2, 300)]  # fmt: skip
    lines = [",".join([f"{row[0]:.6f}", *(f"{v:.6g}" for v in row[1:])])
             for row in zip(*data, strict=True)]  # fmt: skip
    return Made([write(to / "talos.csv", [",".join(names), *lines])], says="weigh")


def split_belt(to: Path, rng: Rng) -> Made:
    """An instrumented treadmill: two belts with force and CoP."""
    head = ("Time (s)\tLeft belt Fz (N)\tLeft belt COPx (m)\tLeft belt COPy (m)"
            "\tRight belt Fz (N)\tRight belt COPx (m)\tRight belt COPy (m)")  # fmt: skip
    data = [np.arange(400) / 100]
    for _ in "lr":
        data += [rng.normal(340, 4, 400), *rng.normal(0.02, 0.003, (2, 400))]
    return Made([write(to / "belt.tsv", [head, *rows(*data, sep="\t", form="%.5f")])], says="weigh")


EIGHTH = (
    chinese_sheet, russian_sheet, italian_sheet, influx_annotated, readings_in_pounds,
    printed_tuples, json_per_cell, days_of_excel, hours_minutes_seconds, turned_sensor,
    steps_in_another_file, mean_in_the_last_row, printed_lists_per_side, vicon_segment,
    plain_names, bno055_gravity, direction_cosines, two_arms, balance_board, nao_short_names,
    quadruped_grf, humanoid_topics, split_belt,
)  # fmt: skip
