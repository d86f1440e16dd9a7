"""Six more labs after the mends of the thirty-eighth, run once on them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from tests.strangers.rigs import (
    Cell,
    G,
    Made,
    Rng,
    Truth,
    cell,
    rows,
    steps,
    tool_truth,
    truth_of,
    wrist,
    write,
)
from tests.strangers.thirty_fifth import leg_truth, legs, swings
from tests.strangers.thirty_first_stands import _PLACES, _march, _stances
from tests.strangers.thirty_seventh import bench_truth, comma, eight, read_out


def file_for_each_cell(to: Path, rng: Rng) -> Made:
    """A recording of each cell of a walk in a folder, the model's motion, one bench for all."""
    walk = _march(rng)
    scale, zero = eight(rng)
    read = read_out(scale, zero, walk.cells, rng)
    names = [f"{s}{i}" for s in "LR" for i in range(1, 5)]
    paths = []
    for i, name in enumerate(names):
        body = rows(walk.time, read[:, i])
        paths.append(write(to / f"cell_{name}.csv", ["t_s,raw", *body]))
    head = ["t_s", *(f"{n}_{a}" for n in ("com", "com_acc", "lfoot", "rfoot") for a in "xyz")]
    data = [*walk.com.T, *walk.acc.T, *walk.feet.reshape(-1, 6).T]
    paths.append(write(to / "model.csv", [",".join(head), *rows(walk.time, *data, form="%.8g")]))
    bench = ["cell,weight_kg,raw"]
    for i, name in enumerate(names):
        for kg in (0, 0.5, 1, 2, 1, 0):
            bench.append(f"{name},{kg},{(kg * G - zero[i] + rng.normal(0, 0.01)) / scale[i]:.0f}")
    paths.append(write(to / "bench.csv", bench))
    places = zip(names, np.vstack([_PLACES, _PLACES]), strict=True)
    sheet = ["cell,x_mm,y_mm", *(f"{n},{1e3 * x:g},{1e3 * y:g}" for n, (x, y) in places)]
    paths.append(write(to / "positions.csv", sheet))
    notes = write(to / "notes.md", ["weight of the robot: 5.2 kg"])
    truth = bench_truth([f"{s}_{i}" for s in ("left", "right") for i in range(1, 5)], scale)
    return Made([*paths, notes], truth)


def spanish_stances_in_files(to: Path, rng: Rng) -> Made:
    """A file for each stance, the robot in the air first, a sheet of CoM and feet; a bench in g."""
    stand = _stances(rng, stances=16)
    scale, zero = eight(rng)
    corners = [f"{s}_{p}" for s in ("izq", "der") for p in ("DI", "DD", "TI", "TD")]
    at = np.arange(40, len(stand.time) - 100, 170)
    paths = []
    for k, first in enumerate([-1, *at]):
        loads = np.zeros((100, 8)) if first < 0 else stand.cells[first : first + 100]
        read = read_out(scale, zero, loads, rng)
        name = "postura_00_colgado" if first < 0 else f"postura_{k:02d}"
        names = "t_ms;" + ";".join(corners)
        body = rows(20.0 * np.arange(100), *read.T, sep=";")
        paths.append(write(to / f"{name}.csv", [names, *body]))
    head = ["postura", *(f"CM_{a}_mm" for a in "xyz"), *(f"pie_{s}_{a}_mm" for s in ("izq", "der")
                                                        for a in "xyz")]  # fmt: skip
    lines = [";".join(head)]
    for k, first in enumerate(at, 1):
        numbers = np.r_[stand.com[first], stand.feet[first].ravel()] * 1e3
        lines.append(";".join([f"{k}", *(f"{v:.2f}" for v in numbers)]))
    paths.append(write(to / "posturas.csv", [lines[0], *comma(lines[1:])]))
    bench = ["pie;celda;masa_g;lectura"]
    for i, name in enumerate(corners):
        for g in (0, 500, 1000, 2000, 1000, 0):
            s = (g / 1000 * G - zero[i] + rng.normal(0, 0.01)) / scale[i]
            bench.append(f"{name.replace('_', ';')};{g};{s:.0f}")
    paths.append(write(to / "banco.csv", bench))
    notes = write(to / "notas.md", [
        "El robot pesa 5,2 kg.", "", "Celdas (mm, x adelante, y izquierda), iguales en ambos pies:",
        *(f"- {p}: {1e3 * x:g}, {1e3 * y:g}"
          for p, (x, y) in zip(("DI", "DD", "TI", "TD"), _PLACES, strict=True)),
    ])  # fmt: skip
    values = bench_truth([c.lower().replace("izq", "left").replace("der", "right")
                          for c in corners], scale)  # fmt: skip
    return Made([*paths, notes], values)


def weights_in_sentences(to: Path, rng: Rng) -> Made:
    """`load` of words with units, taring rows, volts of the cell under test and of a spare one."""
    one = Cell(30.0 * float(rng.uniform(0.95, 1.05)), float(rng.normal(0, 1)), 2e-4)
    spare = cell(rng, "volt")
    lines = ["no.,load,U_cell [V],U_spare [V]"]
    number = 0
    for words, kg in (("tare", 0), ("0.5 kg", 0.5), ("1 kg", 1), ("1 kg + 0.5 kg", 1.5),
                      ("2 kg", 2), ("1 kg", 1), ("tare", 0)):  # fmt: skip
        for _ in range(4):
            number += 1
            read = one.read(np.array(kg * G), rng, whole=False)
            idle = spare.read(np.array(0.0), rng, whole=False)
            lines.append(f"{number},{words},{read:.5f},{idle:.5f}")
    return Made([write(to / "cal.csv", lines)], truth_of(one, 20))


def pose_files_and_kuka(to: Path, rng: Rng) -> Made:
    """A file for each pose in kgf and kgf·cm; a sheet of A, B, C in degrees by their number."""
    made, wrench, rot = wrist(rng, 14, 60)
    read = wrench / ([G] * 3 + [G / 100] * 3)
    paths = []
    for i, own in enumerate(np.split(read, 14)):
        head = "t,Fx[kgf],Fy[kgf],Fz[kgf],Tx[kgf*cm],Ty[kgf*cm],Tz[kgf*cm]"
        body = rows(0.01 * np.arange(60), *own.T, form="%.6f")
        paths.append(write(to / f"p{i + 1}.csv", [head, *body]))
    angles = rot.as_euler("ZYX", degrees=True)[::60]
    sheet = ["punkt;A;B;C", *comma(rows(np.arange(1, 15), *angles.T, sep=";", form="%.4f"))]
    return Made([*paths, write(to / "punkte.csv", sheet)], tool_truth(made))


def four_ways_in_columns(to: Path, rng: Rng) -> Made:
    """One table of four legs hung four ways: `way` in words, joints of each leg, N·cm below."""
    turned = {"FL": 0.0, "FR": 0.0, "HL": 180.0, "HR": 180.0}
    made = legs(rng, {n: Rotation.from_euler("z", a, degrees=True) for n, a in turned.items()})
    ways = {"head up": [-1.0, 0, 0], "head down": [1.0, 0, 0], "feet down": [0, 0, -1.0],
            "feet up": [0, 0, 1.0]}  # fmt: skip
    head = ["way", "time", *(f"{n}_hip" for n in made)]
    head += [f"{n}_{a}" for n in made for a in ("Fx", "Fy", "Fz", "Tx", "Ty", "Tz")]
    units = ["", "s", *["deg"] * 4, *(["N"] * 3 + ["Ncm"] * 3) * 4]
    lines, t0 = [",".join(head), ",".join(units)], 0.0
    for way, down in ways.items():
        angle = swings(130)
        read = [leg.read(angle, np.array(down), rng) * ([1.0] * 3 + [100.0] * 3)
                for leg in made.values()]  # fmt: skip
        body = rows(t0 + 0.1 * np.arange(130), *[np.degrees(angle)] * 4, *np.hstack(read).T,
                    form="%.4f")  # fmt: skip
        lines += [f"{way},{x}" for x in body]
        t0 += 20.0
    called = {"FL": "fl", "FR": "fr", "HL": "hl", "HR": "hr"}
    return Made([write(to / "hung.csv", lines)], leg_truth({called[n]: g for n, g in made.items()}))


def log_with_zero_rows(to: Path, rng: Rng) -> Made:
    """Two cells of a hand-written sheet, loads in lbf, rows of zeros where nobody typed."""
    cells = {n: Cell(5e-4 * float(rng.uniform(0.95, 1.05)), float(rng.normal(0, 1)), 5.0)
             for n in ("front", "back")}  # fmt: skip
    lines = ["cell,load [lbf],ADC"]
    for name, one in cells.items():
        for lb in steps((0, 2, 5, 10, 20, 10, 5, 2, 0), 1):
            lines.append(f"{name},{lb:g},{one.read(np.array(lb * 4.4482216), rng):.0f}")
        lines += [",,", ",,"]
    values = {f"{n}.scale": c.scale for n, c in cells.items()}
    return Made([write(to / "sheet.csv", lines)], Truth(values, {n: abs(0.01 * v) for n, v in
                                                                 values.items()}))  # fmt: skip


THIRTY_NINTH = (
    file_for_each_cell, spanish_stances_in_files, weights_in_sentences, pose_files_and_kuka,
    four_ways_in_columns, log_with_zero_rows,
)  # fmt: skip
