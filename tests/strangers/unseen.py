"""A third of the corpus: shapes that were written down apart and run at the end only."""

from __future__ import annotations

import gzip
import json
from pathlib import Path

import numpy as np

from tests.strangers.rigs import (
    G,
    Made,
    Rng,
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

KG = (0.0, 0.5, 1.0, 1.5, 2.0)


def vicon_devices(to: Path, rng: Rng) -> Made:
    wrench = tool(rng).read(np.tile([0.0, 0.0, -1.0], (200, 1)), rng)
    frame = np.repeat(np.arange(1, 21), 10)
    sub = np.tile(np.arange(10), 20)
    head = [
        "Devices", "1000", ",,AMTI - Force,,,AMTI - Moment,,", "Frame,Sub Frame,Fx,Fy,Fz,Mx,My,Mz",
        ",,N,N,N,N.mm,N.mm,N.mm",
    ]  # fmt: skip
    return Made([write(to / "trial01.csv", [*head, *rows(frame, sub, *wrench.T)])], says="attitude")


def bioware(to: Path, rng: Rng) -> Made:
    wrench = tool(rng).read(np.tile([0.0, 0.0, -1.0], (300, 1)), rng)
    head = ["BioWare Export", "Subject:\tS01", "Rate (Hz):\t1000", ""]
    head += ["abs time (s)\tFx\tFy\tFz\tMx\tMy\tMz", "s\tN\tN\tN\tN.m\tN.m\tN.m"]
    body = rows(np.arange(300) / 1000, *wrench.T, sep="\t")
    return Made([write(to / "jump.txt", [*head, *body])], says="attitude")


def matlab_ascii(to: Path, rng: Rng) -> Made:
    one, load = cell(rng, "volt"), steps((0, 10, 20, 30, 10, 0), 50)
    t = np.arange(load.size) / 10
    body = rows(t, load, one.read(load, rng, False), sep="  ", form="% .7e")
    return Made(
        [write(to / "save_ascii.txt", [f"  {line}" for line in body])], says="the unit of the load"
    )


def json_lines(to: Path, rng: Rng) -> Made:
    one, kg = cell(rng), steps(KG, 3)
    lines = [
        json.dumps({"load_kg": float(k), "counts": int(c)})
        for k, c in zip(kg, one.read(kg * G, rng), strict=True)
    ]
    return Made([write(to / "log.jsonl", lines)], truth_of(one))


def labview(to: Path, rng: Rng) -> Made:
    one, load = cell(rng, "volt"), steps((0, 5, 10, 20, 40, 20, 0), 60)
    head = [
        "LabVIEW Measurement\t", "Writer_Version\t2", "Separator\tTab", "Date\t2024/03/05",
        "***End_of_Header***\t", "\t", "Channels\t2\t\t", "***End_of_Header***\t\t\t",
        "X_Value\tLoad (N)\tVoltage_0\tComment",
    ]  # fmt: skip
    body = rows(np.arange(load.size) / 20, load, one.read(load, rng, False), sep="\t")
    return Made([write(to / "run.lvm", [*head, *body])], truth_of(one, 40))


def testing_machine(to: Path, rng: Rng) -> Made:
    one = cell(rng, "adc12")
    t = np.arange(1200) / 50
    load = 15 - 14 * np.cos(2 * np.pi * t / 12)
    body = [
        ";".join(f"{v:.4f}".replace(".", ",") for v in row)
        for row in zip(t, load + rng.normal(0, 0.03, t.size), one.read(load, rng), strict=True)
    ]
    head = ['"Zeit";"Kraft";"Sensor"', '"s";"N";"-"']
    return Made([write(to / "zwick.csv", [*head, *body], "latin-1", "\r\n")], truth_of(one, 30))


def plotjuggler(to: Path, rng: Rng) -> Made:
    from scipy.spatial.transform import Rotation

    made = tool(rng)
    rot, _ = attitudes(rng, 12, 25)
    t = 1_710_000_000 + np.arange(len(rot)) * 0.01
    names = [f"/wrist_ft/wrench/{k}/{a}" for k in ("force", "torque") for a in "xyz"]
    names += [f"/tool0/pose/orientation/{a}" for a in "xyzw"]
    wrench = made.read(-rot[:, 2, :], rng)
    body = rows(t, *wrench.T, *Rotation.from_matrix(rot).as_quat().T, form="%.14g")
    return Made([write(to / "pj.csv", [",".join(["__time", *names]), *body])], tool_truth(made))


def rtde(to: Path, rng: Rng) -> Made:
    wrench = tool(rng).read(np.tile([0.0, 0.0, -1.0], (250, 1)), rng)
    names = ["timestamp", *(f"actual_TCP_force_{i}" for i in range(6))]
    body = rows(40.0 + np.arange(250) * 0.008, *wrench.T, sep=" ")
    return Made([write(to / "robot_data.csv", [" ".join(names), *body])], says="attitude")


def phidget(to: Path, rng: Rng) -> Made:
    one, kg = cell(rng, "volt"), steps(KG, 4)
    body = rows(np.arange(kg.size) * 256.0, kg, one.read(kg * G, rng, False))
    head = "Time(ms),Mass (kg),VoltageRatio (mV/V)"
    return Made([write(to / "phidget.csv", [head, *body])], truth_of(one))


def excel_unicode(to: Path, rng: Rng) -> Made:
    one, g = cell(rng, "hx_small"), steps((0, 100, 300, 700), 3)
    body = rows(g, one.read(g * G / 1e3, rng), sep="\t")
    path = write(to / "unicode.txt", ["Gewicht in g\tRohwert", *body], "utf-16", "\r\n")
    return Made([path], truth_of(one, 7))


def french(to: Path, rng: Rng) -> Made:
    cells = {"avant": cell(rng), "arrière": cell(rng)}
    kg = steps(KG, 2)
    body = [
        f"{name};{1e3 * k:.1f};{c:.0f}".replace(".", ",")
        for name, one in cells.items()
        for k, c in zip(kg, one.read(kg * G, rng), strict=True)
    ]
    path = write(to / "étalonnage.csv", ["Capteur;Masse (g);Lecture brute", *body], "latin-1")
    return Made([path], truth_of(cells))


def german_dates(to: Path, rng: Rng) -> Made:
    one, kg = cell(rng), steps(KG, 3)
    body = [
        f"05.03.2024 10:{i:02d}:01,5;{k:.1f};{c:.0f}".replace(".5;", ",5;")
        for i, (k, c) in enumerate(zip(kg, one.read(kg * G, rng), strict=True))
    ]
    head = "Datum/Uhrzeit;Masse [kg];AD-Wert"
    lines = [
        head,
        *(f"{x.split(';')[0]};{';'.join(x.split(';')[1:]).replace('.', ',')}" for x in body),
    ]
    return Made([write(to / "protokoll.csv", lines)], truth_of(one))


def packed(to: Path, rng: Rng) -> Made:
    one, n = cell(rng), steps((0, 4, 8, 16), 5)
    text = "\n".join(["applied_force_N,raw_counts", *rows(n, one.read(n, rng))]) + "\n"
    path = to / "bench.csv.gz"
    path.write_bytes(gzip.compress(text.encode()))
    return Made([path], truth_of(one))


def stream_per_cell(to: Path, rng: Rng) -> Made:
    t = np.arange(400) / 80
    made = []
    for name in ("left_front", "left_rear", "right_front", "right_rear"):
        counts = cell(rng).read(np.full(400, 8.0), rng)
        made.append(write(to / f"{name}.csv", ["time_s,counts", *rows(t, counts)]))
    return Made(made, says="where the cells sit")


def trailing_separators(to: Path, rng: Rng) -> Made:
    one, kg = cell(rng), steps(KG, 4)
    lines = [f"{line}," for line in rows(np.arange(kg.size), kg, one.read(kg * G, rng))]
    return Made([write(to / "export.csv", ["no,weight_kg,raw,", *lines])], truth_of(one))


def insoles(to: Path, rng: Rng) -> Made:
    t = np.arange(600) / 100
    names = [f"{side} {zone} force [N]" for side in ("left", "right") for zone in ("heel", "toe")]
    body = rows(t, *(rng.normal(180, 3, 600) for _ in names), sep="\t", form="%.4f")
    return Made([write(to / "insoles.txt", ["\t".join(["time [s]", *names]), *body])], says="weigh")


def weight_in_file_name(to: Path, rng: Rng) -> Made:
    one = cell(rng, "hx_small")
    made = []
    for kg in (0, 0.5, 1.5, 2.5):
        load = np.full(40, kg * G)
        lines = rows(np.arange(40) * 100, one.read(load, rng), form="%d")
        made.append(write(to / f"load_{kg:g}kg.csv", ["millis,raw", *lines]))
    return Made(made, truth_of(one, 25))


def press_rig_two_files(to: Path, rng: Rng) -> Made:
    one = cell(rng, "adc12")
    t = np.arange(900) / 30
    load = 10 + 8 * np.sin(2 * np.pi * t / 9) + settling([0, 0], 1, 30).sum() * 0
    other = np.arange(3000) / 100
    force = 10 + 8 * np.sin(2 * np.pi * other / 9) + rng.normal(0, 0.02, other.size)
    a = write(to / "fsr.csv", ["ms,fsr", *rows(1000 * t, one.read(load, rng), form="%d")])
    b = write(to / "reference.csv", ["Time [s],Force [N]", *rows(other, force)])
    return Made([a, b], truth_of(one, 18))


UNSEEN = (
    vicon_devices, bioware, matlab_ascii, json_lines, labview, testing_machine, plotjuggler, rtde,
    phidget, excel_unicode, french, german_dates, packed, stream_per_cell, trailing_separators,
    insoles, weight_in_file_name, press_rig_two_files,
)  # fmt: skip
