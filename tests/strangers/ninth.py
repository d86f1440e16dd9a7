"""Logs as laboratories keep them, V: another short corpus, after the mends of the eighth.

Written before it was run; `docs/bring_your_log.md` has its first count.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from tests.strangers.rigs import (
    Cell,
    G,
    Made,
    Rng,
    Truth,
    cell,
    filled,
    rows,
    settling,
    steps,
    tool,
    tool_truth,
    truth_of,
    wrist,
    write,
)


def polish_sheet(to: Path, rng: Rng) -> Made:
    """Names in Polish (cp1250), decimal commas, a column of remarks."""
    one, kg = cell(rng), steps((0, 0.5, 1, 2), 5)
    body = [f"{i + 1};{k:g};{c:.0f};".replace(".", ",") + ("początek" if i == 0 else "")
            for i, (k, c) in enumerate(zip(kg, one.read(kg * G, rng), strict=True))]  # fmt: skip
    return Made([write(to / "kalibracja.csv", ["Nr;Obciążenie [kg];Odczyt;Uwagi", *body],
                       "cp1250")], truth_of(one))  # fmt: skip


def japanese_sheet(to: Path, rng: Rng) -> Made:
    """Names in Japanese (Shift JIS), newtons."""
    one, newton = cell(rng), steps((0, 5, 10, 20), 5)
    body = rows(np.arange(newton.size), newton, one.read(newton, rng))
    return Made([write(to / "calib.csv", ["番号,荷重(N),出力値", *body], "shift_jis")],
                truth_of(one))  # fmt: skip


def scientific_daq(to: Path, rng: Rng) -> Made:
    """A data logger's scan list: channel numbers with units, times of day with the date apart."""
    one = Cell(21.0, -2.0, 5e-4)
    newton = steps((0, 20, 50, 100), 10)
    head = ["Name:,BenchLink Data Logger", "Comments:,", "Acquisition Date:,3/12/2024", "",
            "Scan,Time,101 <Ref> (N),Alarm 101,102 <Cell> (VDC),Alarm 102"]  # fmt: skip
    lines = [f"{i + 1},3/12/2024 14:02:{i:02d}:{100 * (i % 10):03d},{f:.4f},0,{v:+.6E},0"
             for i, (f, v) in enumerate(zip(newton, one.read(newton, rng, whole=False),
                                            strict=True))]  # fmt: skip
    return Made([write(to / "data1.csv", [*head, *lines])], truth_of(one, 100))


def two_header_rows_of_cells(to: Path, rng: Rng) -> Made:
    """A sheet with the foot over its cells and the load of each row in front."""
    cells = {f"{f} {c}": cell(rng) for f in ("Left", "Right") for c in ("toe", "heel")}
    kg = steps((0, 1, 2, 4), 4)
    head = [",Left,,Right,", "Load (kg),toe,heel,toe,heel"]
    body = rows(kg, *(one.read(kg * G, rng) for one in cells.values()))
    named = {name.lower().replace(" ", "_"): one for name, one in cells.items()}
    return Made([write(to / "feet.csv", [*head, *body])], truth_of(named))


def mqtt_payloads(to: Path, rng: Rng) -> Made:
    """`mosquitto_sub -v`: the topic, then a number, loads on a topic of their own."""
    one, lines = cell(rng), []
    for g in (0, 500, 1000, 2000):
        lines.append(f"bench/load_g {g}")
        lines += [f"bench/cell1/raw {c:.0f}" for c in one.read(np.full(12, g * 1e-3 * G), rng)]
    return Made([write(to / "mqtt.txt", lines)], truth_of(one))


def json_arrays(to: Path, rng: Rng) -> Made:
    """A JSON document of columns, not rows."""
    one, kg = cell(rng), steps((0, 1, 2, 5), 5)
    text = json.dumps({"mass_kg": kg.tolist(), "raw": one.read(kg * G, rng).tolist()})
    return Made([write(to / "cal.json", [text])], truth_of(one))


def log_levels(to: Path, rng: Rng) -> Made:
    """An ESP32's log: a level and a time in brackets, a tag, the reading, the load set before."""
    one, lines, ms = cell(rng), [], 1200
    for g in (0, 250, 500, 1000):
        lines.append(f"I ({ms}) cal: weight set to {g} g")
        for c in one.read(np.full(10, g * 1e-3 * G), rng):
            ms += 100
            lines.append(f"I ({ms}) hx711: raw={c:.0f}")
    return Made([write(to / "monitor.log", lines)], truth_of(one, 10))


def plus_minus(to: Path, rng: Rng) -> Made:
    """A table typed from a notebook: means with their scatter (`8 223 570 ± 40`)."""
    one, kg = cell(rng), (0.0, 0.5, 1.0, 2.0, 5.0)
    lines = ["Load (kg);Reading"]
    for k in kg:
        c = one.read(np.full(40, k * G), rng)
        lines.append(f"{k:g};{c.mean():.1f} ± {c.std():.1f}")
    return Made([write(to / "notebook.csv", lines)], truth_of(one))


def three_trials_beside(to: Path, rng: Rng) -> Made:
    """Three trials beside each other, loads in tonnes-force's little brother: daN."""
    one, dan = Cell(21.0, -0.5, 1e-3), np.array([0, 1, 2, 5, 10.0])
    reading = [one.read(dan * 10.0, rng, whole=False) for _ in range(3)]
    head = "Charge (daN),Essai 1 (V),Essai 2 (V),Essai 3 (V)"
    return Made([write(to / "essais.csv", [head, *rows(dan, *reading, form="%.5f")])],
                truth_of(one, 100))  # fmt: skip


def creep_press(to: Path, rng: Rng) -> Made:
    """A press that sweeps up and down once in pounds-force, volts, minutes."""
    one = Cell(60.0, -5.0, 8e-4)
    t = np.arange(1600) / 40
    load = 300 * np.sin(np.pi * t / 40) ** 2
    reference = (load + rng.normal(0, 0.1, t.size)) / 4.4482216
    body = rows(t / 60, reference, one.read(load, rng, whole=False),
                form="%.6f")  # fmt: skip
    return Made([write(to / "sweep.csv", ["Elapsed (min),Load (lbf),Output (V)", *body])],
                truth_of(one, 300))  # fmt: skip


def urscript_pose(to: Path, rng: Rng) -> Made:
    """UR: poses and forces printed as they are (`p[…]`, `[…]`), one line each sample."""
    made, wrench, rot = wrist(rng)
    lines = []
    for w, r in zip(wrench, rot.as_rotvec(), strict=True):
        pose = ", ".join(f"{v:.6f}" for v in (0.4, 0.1, 0.5, *r))
        lines.append(f"p[{pose}]; [{', '.join(f'{v:.5f}' for v in w)}]")
    return Made([write(to / "ur_log.txt", lines)], tool_truth(made))


def apollo_tilt(to: Path, rng: Rng) -> Made:
    """Two inclinometer angles beside the wrench: no yaw, degrees, German."""
    made, wrench, rot = wrist(rng)
    _, pitch, roll = rot.as_euler("ZYX", degrees=True).T
    head = (
        "Zeit [s];Kraft X [N];Kraft Y [N];Kraft Z [N];Moment X [Nm];Moment Y [Nm];Moment Z [Nm];"
        "Rollwinkel [°];Nickwinkel [°]"
    )
    body = rows(np.arange(len(wrench)) / 50, *wrench.T, roll, pitch, sep=";", form="%.6f")
    return Made([write(to / "tilt.csv", [head, *(x.replace(".", ",") for x in body)], "cp1252")],
                tool_truth(made))  # fmt: skip


def homogeneous_rows(to: Path, rng: Rng) -> Made:
    """A pose as twelve numbers, three rows of four, names T00 … T23."""
    made, wrench, rot = wrist(rng)
    pose = np.concatenate([rot.as_matrix(), np.full((len(wrench), 3, 1), 0.4)], axis=2)
    head = ["t", *(f"T{i}{j}" for i in range(3) for j in range(4)), *(f"F{a}" for a in "xyz"),
            *(f"M{a}" for a in "xyz")]  # fmt: skip
    body = rows(np.arange(len(wrench)) / 100, *pose.reshape(-1, 12).T, *wrench.T)
    return Made([write(to / "pose.csv", [",".join(head), *body])], tool_truth(made))


def sides_as_numbers(to: Path, rng: Rng) -> Made:
    """Orientations by the components of down, a row each: dx dy dz."""
    made = tool(rng)
    lines = ["gx,gy,gz,Fx,Fy,Fz,Tx,Ty,Tz"]
    for down in np.vstack([np.eye(3), -np.eye(3)]):
        for w in made.read(np.tile(down, (20, 1)), rng):
            lines.append(",".join(f"{v:.5g}" for v in (*down, *w)))
    return Made([write(to / "sides.csv", lines)], tool_truth(made))


def millinewtons(to: Path, rng: Rng) -> Made:
    """A nano sensor: mN and N·mm, micrometres beside, a quaternion by words."""
    made, wrench, rot = wrist(rng)
    head = ("t (ms)\tFx (mN)\tFy (mN)\tFz (mN)\tTx (Nmm)\tTy (Nmm)\tTz (Nmm)"
            "\tquaternion w\tquaternion x\tquaternion y\tquaternion z")  # fmt: skip
    q = np.roll(rot.as_quat(), 1, axis=1)
    body = rows(np.arange(len(q)) * 4.0, *(1e3 * wrench).T, *q.T, sep="\t", form="%.7g")
    return Made([write(to / "nano.tsv", [head, *body])], tool_truth(made))


def crutch_and_foot(to: Path, rng: Rng) -> Made:
    """A foot's four cells in kg with their sum, in time."""
    n = 200
    cells = rng.normal(9, 0.05, (4, n))
    head = "time_s,foot_fl_kg,foot_fr_kg,foot_rl_kg,foot_rr_kg,sum_kg"
    body = rows(np.arange(n) / 50, *cells, cells.sum(axis=0))
    return Made([write(to / "foot.csv", [head, *body])], says="where the cells sit")


def hexapod_tips(to: Path, rng: Rng) -> Made:
    """Six foot tips by Roman habit: L1 L2 L3 R1 R2 R3, newtons."""
    names = [f"{s}{i}_tip_force" for s in "LR" for i in (1, 2, 3)]
    body = rows(np.arange(300) / 100, *rng.normal(13, 0.2, (6, 300)))
    return Made([write(to / "tips.csv", [",".join(["t", *names]), *body])], says="weigh")


def bathroom_scales(to: Path, rng: Rng) -> Made:
    """Two scales, one under each foot, read by eye: a row per stance, pounds."""
    left = np.array([80, 60, 110, 95, 70.0])
    right = 165 - left
    head = "stance,left scale (lb),right scale (lb)"
    body = rows(np.arange(1, 6), left, right, form="%g")
    return Made([write(to / "stances.csv", [head, *body])], says="weigh")


def plates_four_filled(to: Path, rng: Rng) -> Made:
    """Two plates: Fz, COPx, COPy with their number in front, centimetres; the mass is added."""
    share = settling([0.35, 0.55, 0.7, 0.4, 0.6, 0.5], 5, 50)
    n, mass, gain = share.size, 71.0, (1.04, 0.95)
    data, names = [np.arange(n) / 50], ["Time"]
    for i, (part, g) in enumerate(zip((share, 1 - share), gain, strict=True), 1):
        names += [f"{i}.Fz [N]", f"{i}.COPx [cm]", f"{i}.COPy [cm]"]
        data += [part * mass * G / g + rng.normal(0, 1, n), *rng.normal(1, 0.2, (2, n))]
    cells = {f"plate_{k}_p{i}.scale": g for k, g in enumerate(gain, 1) for i in (1, 2, 3)}
    return Made([write(to / "plates.csv", [",".join(names), *rows(*data, form="%.5f")])],
                Truth(cells, dict.fromkeys(cells, 0.1)), says="weigh",
                fill=filled(mass_kg=f"{mass}"))  # fmt: skip


NINTH = (
    polish_sheet, japanese_sheet, scientific_daq, two_header_rows_of_cells, mqtt_payloads,
    json_arrays, log_levels, plus_minus, three_trials_beside, creep_press, urscript_pose,
    apollo_tilt, homogeneous_rows, sides_as_numbers, millinewtons, crutch_and_foot, hexapod_tips,
    bathroom_scales, plates_four_filled,
)  # fmt: skip
