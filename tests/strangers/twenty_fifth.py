"""The classes of the twenty-fourth in another guise: written after its mends, run once as they are.

`docs/bring_your_log.md` has the count of that run.
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
    tool_truth,
    truth_of,
    wrist,
    write,
)

_KG = (0, 0.5, 1, 2, 5)
_FT = ["Fx", "Fy", "Fz", "Tx", "Ty", "Tz"]


def target_in_english(to: Path, rng: Rng) -> Made:
    """A press that was set to kilonewtons and reached four per cent less."""
    one, target = Cell(9800.0, -50.0, 2e-5), steps((0, 2, 4, 6, 8, 4, 0), 4)
    actual = 0.96e3 * target + rng.normal(0, 10, target.size)
    read = one.read(actual, rng, whole=False)
    lines = ["Target Load [kN],Measured Load [kN],Output [mV/V]",
             *rows(target, actual / 1e3, read, form="%.6f")]  # fmt: skip
    return Made([write(to / "press.csv", lines)], truth_of(one, 8000))


def means_in_german(to: Path, rng: Rng) -> Made:
    """A sheet in German with a line of means below each weight."""
    one, lines = cell(rng), ["Gewicht [g];Anzeige"]
    for kg in _KG:
        read = one.read(np.full(5, kg * G), rng)
        grams = f"{1e3 * kg:,.0f}".replace(",", ".")
        lines += [f"{grams};{c:,.0f}".replace(",", ".") for c in read]
        lines.append(f"{grams} Mittelwert;{read.mean():,.0f}".replace(",", "."))
    return Made([write(to / "auswertung.csv", lines, "latin-1", "\r\n")], truth_of(one, 50))


def sums_without_a_word(to: Path, rng: Rng) -> Made:
    """A last line that sums up both columns and says nothing."""
    one, kg = cell(rng, "adc12"), steps(_KG, 4)
    read = one.read(kg * G, rng)
    lines = ["load_kg;adc", *rows(kg, read, sep=";"), f"{kg.sum():g};{read.sum():.0f}"]
    return Made([write(to / "sheet.csv", lines)], truth_of(one, 50))


def merged_with_units(to: Path, rng: Rng) -> Made:
    """Merged cells whose load has its unit behind it."""
    one, lines = cell(rng), ["Weight,No.,ADC"]
    for kg in (*_KG, *_KG[::-1][1:]):
        lines += [f"{f'{kg:g} kg' if i == 0 else ''},{i + 1},{c:.0f}"
                  for i, c in enumerate(one.read(np.full(3, kg * G), rng))]  # fmt: skip
    return Made([write(to / "merged.csv", lines)], truth_of(one, 50))


def stacks_in_french(to: Path, rng: Rng) -> Made:
    """Weights that were stacked, in French."""
    one, lines = cell(rng), ["masses;lecture"]
    for words, kg in (("à vide", 0), ("500g", 0.5), ("2x500g", 1), ("2x500g+1kg", 2),
                      ("1kg + 2x2kg", 5), ("à vide", 0)):  # fmt: skip
        lines += [f"{words};{c:.0f}" for c in one.read(np.full(3, kg * G), rng)]
    return Made([write(to / "masses.csv", lines)], truth_of(one, 50))


def folders_of_cells(to: Path, rng: Rng) -> Made:
    """A folder for each cell, a file for each weight in it."""
    cells, paths = {"toe": cell(rng), "heel": cell(rng)}, []
    for name, one in cells.items():
        (to / name).mkdir()
        for kg in (0, 1, 2, 5):
            body = [f"{c:.0f}" for c in one.read(np.full(20, kg * G), rng)]
            paths.append(write(to / name / f"{kg}kg.txt", body))
    return Made(paths, truth_of(cells, 50))


def plates_by_number(to: Path, rng: Rng) -> Made:
    """Two plates by number, force on the plate (down), moments in N·mm; the mass is added."""
    mass, gain = 64.0, (1.03, 0.96)
    share = settling([0.35, 0.55, 0.7, 0.4, 0.6, 0.5], 5, 50)
    names, data = ["time_s"], [np.arange(share.size) / 50]
    for i, part in ((1, share), (2, 1 - share)):
        fz = part * mass * G / gain[i - 1] + rng.normal(0, 1, share.size)
        x, y = rng.normal(0, 4, (2, share.size))
        names += [f"Fz{i} (N)", f"Mx{i} (N.mm)", f"My{i} (N.mm)"]
        data += [-fz, -y * fz, x * fz]
    cells = {f"plate_{n}_p{i}.scale": g for n, g in zip((1, 2), gain, strict=True)
             for i in (1, 2, 3)}  # fmt: skip
    return Made([write(to / "stand.csv", [",".join(names), *rows(*data, form="%.5g")])],
                Truth(cells, dict.fromkeys(cells, 0.1)), says="weigh",
                fill=filled(mass_kg=f"{mass}"))  # fmt: skip


def marks_in_centimetres(to: Path, rng: Rng) -> Made:
    """A plate of three columns, a file for each mark, centimetres in the names."""
    paths = []
    for x in (-12, 0, 12):
        for y in (-20, 0, 20):
            u, v = 1.02e-2 * x + 2e-3, 0.99e-2 * y - 3e-3
            fz = rng.normal(300, 1, 40)
            data = [fz, fz * v + rng.normal(0, 0.03, 40), -fz * u + rng.normal(0, 0.03, 40)]
            lines = ["Fz [N];Mx [Nm];My [Nm]", *rows(*data, sep=";", form="%.5f")]
            paths.append(write(to / f"P x{x}cm y{y}cm.csv", lines))
    return Made(paths, cop_within_m=1.5e-3)


def sheet_of_file_names(to: Path, rng: Rng) -> Made:
    """A sheet that says for each file how the tool was turned, scalar first."""
    made, wrench, rot = wrist(rng, 11, 25)
    paths, sheet = [], ["file,qw,qx,qy,qz"]
    for i, name in enumerate("abcdefghijk"):
        body = rows(*wrench[25 * i : 25 * (i + 1)].T, form="%.5f")
        paths.append(write(to / f"pose_{name}.csv", [",".join(_FT), *body]))
        quat = rot.as_quat()[25 * i][[3, 0, 1, 2]]
        sheet.append(f"pose_{name}.csv," + ",".join(f"{v:.6f}" for v in quat))
    return Made([*paths, write(to / "index.csv", sheet)], tool_truth(made))


def metrics_of_two_cells(to: Path, rng: Rng) -> Made:
    """Prometheus: a metric with the cell as its label, a load of each cell."""
    cells, lines = {"left": cell(rng), "right": cell(rng)}, ["# TYPE cell_raw gauge"]
    kg = steps((0, 1, 2, 5, 2, 0), 8)
    loads = {"left": kg, "right": 0.5 * kg[::-1]}
    read = {name: one.read(loads[name] * G, rng) for name, one in cells.items()}
    for i in range(kg.size):
        at = 1_710_237_600_000 + 200 * i
        for name in cells:
            lines += [f'load_kg{{cell="{name}"}} {loads[name][i]:g} {at}',
                      f'cell_raw{{cell="{name}"}} {read[name][i]:.0f} {at}']  # fmt: skip
    return Made([write(to / "metrics.prom", lines)], truth_of(cells, 50))


def topics_of_a_bench(to: Path, rng: Rng) -> Made:
    """MQTT with ISO stamps: a reference in kg and the cell take turns."""
    one = cell(rng)
    load = settling([0, 10, 20, 50, 20, 0], 5, 10, 1.5)
    lines = []
    for i, (f, c) in enumerate(zip(load, one.read(load, rng), strict=True)):
        said = {"lab/ref": {"kg": round(f / G, 5)}, "lab/cell": {"raw": int(c)}}
        for ms, (topic, payload) in zip((0, 20), said.items(), strict=True):
            at = 100 * i + ms
            stamp = f"2024-03-12T10:{at // 60000:02d}:{at % 60000 / 1000:06.3f}"
            lines.append(f"{stamp} {topic} {json.dumps(payload)}")
    return Made([write(to / "mqtt.txt", lines)], truth_of(one, 50))


def matrix_by_mat2str(to: Path, rng: Rng) -> Made:
    """A rotation matrix as MATLAB's mat2str writes it, `[1 0 0;0 1 0;0 0 1]`."""
    made, wrench, rot = wrist(rng)
    lines = [",".join(["t", *_FT, "R"])]
    for i, (body, r) in enumerate(zip(rows(*wrench.T, form="%.5f"), rot.as_matrix(), strict=True)):
        said = ";".join(" ".join(f"{v:.6f}" for v in row) for row in r)
        lines.append(f'{0.02 * i:.2f},{body},"[{said}]"')
    return Made([write(to / "log.csv", lines)], tool_truth(made))


def position_before_all(to: Path, rng: Rng) -> Made:
    """pandas again: a position, a quaternion, a force and a torque, all of x, y, z."""
    made, wrench, rot = wrist(rng)
    place = np.repeat(rng.uniform(-0.4, 0.4, (12, 3)), 25, axis=0)
    lines = ["x,y,z,x.1,y.1,z.1,w,x.2,y.2,z.2,x.3,y.3,z.3",
             *rows(*place.T, *rot.as_quat().T, *wrench.T, form="%.6f")]  # fmt: skip
    return Made([write(to / "merged.csv", lines)], tool_truth(made))


TWENTY_FIFTH = (
    target_in_english, means_in_german, sums_without_a_word, merged_with_units, stacks_in_french,
    folders_of_cells, plates_by_number, marks_in_centimetres, sheet_of_file_names,
    metrics_of_two_cells, topics_of_a_bench, matrix_by_mat2str, position_before_all,
)  # fmt: skip
