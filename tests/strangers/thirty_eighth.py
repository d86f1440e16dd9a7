"""Ten more labs, written after the mends of the thirty-seventh and run once on them."""

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
    tool,
    tool_truth,
    truth_of,
    wrist,
    write,
)
from tests.strangers.thirty_fifth import leg_truth, legs, swings
from tests.strangers.thirty_first_stands import _PLACES, _march, _scales, _stances
from tests.strangers.thirty_seventh import (
    POUND,
    ankle_truth,
    ankles,
    bench_truth,
    comma,
    eight,
)


def polish_soles(to: Path, rng: Rng) -> Made:
    """Cells `L1 … P4` in kgf, the mass centre `SM` in mm, all in one table; places in a list."""
    walk = _march(rng)
    gain = 1 + 0.02 * rng.normal(0, 1, 8)
    read = (walk.cells + rng.normal(0, 0.02, walk.cells.shape)) / gain / G
    head = ["czas [s]", *(f"{s}{i} [kgf]" for s in "LP" for i in range(1, 5))]
    head += [f"{n}_{a} [mm]" for n in ("SM", "stopaL", "stopaP") for a in "xyz"]
    head += [f"aSM_{a} [mm/s^2]" for a in "xyz"]
    data = [*read.T, *(1e3 * walk.com).T, *(1e3 * walk.feet.reshape(-1, 6)).T, *(1e3 * walk.acc).T]
    body = comma(rows(walk.time, *data, sep=";", form="%.8g"))
    notes = write(to / "notatki.md", [
        "# Chód 14", "", "Masa robota: 5,2 kg.", "", "Położenie czujników w stopie (x do przodu, "
        "y w lewo), mm:", "",
        *(f"* {i + 1}: {1e3 * x:g}; {1e3 * y:g}" for i, (x, y) in enumerate(_PLACES)),
    ])  # fmt: skip
    names = [f"{s}_{i}" for s in ("left", "right") for i in range(1, 5)]
    return Made([write(to / "chod_14.csv", [";".join(head), *body]), notes], _scales(names, gain))


def boards_and_tracker(to: Path, rng: Rng) -> Made:
    """A board under each foot in mV/V with µs, a tracker's file, a bench of boards and channels."""
    walk = _march(rng)
    scale, zero = eight(rng, 25.0)
    read = (walk.cells - zero + rng.normal(0, 0.02, walk.cells.shape)) / scale
    paths = []
    for f, board in enumerate(("lf_board", "rf_board")):
        body = rows(1e6 * walk.time, *read[:, 4 * f : 4 * f + 4].T, form="%.9g")
        paths.append(write(to / f"{board}.csv", ["t_us,ch0,ch1,ch2,ch3", *body]))
    head = ["time", *(f"com.{a}" for a in "xyz"), *(f"com_acc.{a}" for a in "xyz")]
    head += [f"{s}_foot.{a}" for s in ("left", "right") for a in "xyz"]
    data = [*walk.com.T, *walk.acc.T, *walk.feet.reshape(-1, 6).T]
    paths.append(write(to / "tracker.csv", [",".join(head), *rows(walk.time, *data, form="%.8g")]))
    bench = ["board,channel,mass_kg,mV/V"]
    for i in range(8):
        for kg in (0, 0.5, 1, 2, 4, 2, 0):
            s = (kg * G - zero[i] + rng.normal(0, 0.01)) / scale[i]
            bench.append(f"{('lf_board', 'rf_board')[i // 4]},ch{i % 4},{kg},{s:.6f}")
    paths.append(write(to / "bench_2026-03-02.csv", bench))
    sheet = ["channel,x_cm,y_cm", *(f"ch{i},{100 * x:g},{100 * y:g}"
                                    for i, (x, y) in enumerate(_PLACES))]  # fmt: skip
    paths.append(write(to / "geometry.csv", sheet))
    notes = write(
        to / "README.md", ["Total mass with battery 5.2 kg.", "Same layout in both feet."]
    )
    names = [f"{s}_ch{i}" for s in ("left", "right") for i in range(4)]
    return Made([*paths, notes], bench_truth(names, scale))


def german_stances(to: Path, rng: Rng) -> Made:
    """A row for each stance with its name, a row of units, the first two in the air; newtons."""
    stand = _stances(rng, stances=24)
    at = np.arange(100, len(stand.time), 170)
    gain, zero = 1 + 0.02 * rng.normal(0, 1, 8), rng.normal(0, 0.6, 8)
    loads = np.vstack([np.zeros((2, 8)), stand.cells[at]])
    read = (loads - zero + rng.normal(0, 0.003, loads.shape)) / gain
    com = np.vstack([stand.com[[0, 0]], stand.com[at]])
    feet = np.vstack([stand.feet[[0, 0]], stand.feet[at]]).reshape(-1, 6)
    corners = [f"{s} {p}" for s in ("links", "rechts") for p in ("VL", "VR", "HL", "HR")]
    head = ["Stand", *corners, *(f"SP {a}" for a in "xyz")]
    head += [f"Fuß {s} {a}" for s in ("links", "rechts") for a in "xyz"]
    units = ["", *["N"] * 8, *["cm"] * 9]
    body = comma(rows(*read.T, *(100 * com).T, *(100 * feet).T, sep=";", form="%.8g"))
    said = ["hängt", "hängt", *(f"Stand {i + 1}" for i in range(len(at)))]
    lines = [
        ";".join(head),
        ";".join(units),
        *(f"{s};{b}" for s, b in zip(said, body, strict=True)),
    ]
    notes = write(to / "notizen.md", [
        "Der Roboter wiegt 5,2 kg.", "", "| Zelle | x in mm | y in mm |", "|---|---|---|",
        *(f"| {p} | {1e3 * x:g} | {1e3 * y:g} |"
          for p, (x, y) in zip(("VL", "VR", "HL", "HR"), _PLACES, strict=True)),
    ])  # fmt: skip
    names = [f"{s}_{p}" for s in ("left", "right") for p in ("vl", "vr", "hl", "hr")]
    return Made([write(to / "staende.csv", lines), notes], _scales(names, gain, 0.05))


def holes_of_both_feet(to: Path, rng: Rng) -> Made:
    """A file of holes for each foot with coordinates in its rows; a bench of columns by cell."""
    words = ("toe_in", "toe_out", "heel_in", "heel_out")
    cells = {f"{s}_{w}": Cell(8e-4 * float(rng.uniform(0.95, 1.05)), float(rng.normal(0, 1)), 4.0)
             for s in ("left", "right") for w in words}  # fmt: skip
    shape = np.linalg.pinv(np.column_stack([np.ones(4), _PLACES]).T)
    paths = []
    for side in ("left", "right"):
        lines = ["hole,x [mm],y [mm]," + ",".join(words)]
        for name, x, y in [
            ("-", 0, 0),
            *(
                (f"h{i}{j}", x, y)
                for i, x in enumerate((-50, 0, 50))
                for j, y in enumerate((-30, 0, 30))
            ),
            ("-", 0, 0),
        ]:
            load = 3 * G * (name != "-") * shape @ [1, x / 1e3, y / 1e3]
            read = [f"{cells[f'{side}_{w}'].read(np.array(n), rng):.0f}"
                    for w, n in zip(words, load, strict=True)]  # fmt: skip
            place = [f"{x}", f"{y}"] if name != "-" else ["", ""]
            lines.append(",".join([name, *place, *read]))
        paths.append(write(to / f"{side}_foot_holes.csv", lines))
    bench = ["foot,cell,kg,reading"]
    for name, one in cells.items():
        side, _, word = name.partition("_")
        for kg in (0, 0.5, 1, 2, 3, 1, 0):
            bench.append(f"{side},{word},{kg},{one.read(np.array(kg * G), rng):.0f}")
    paths.append(write(to / "cells_bench.csv", bench))
    notes = write(to / "notes.md", [
        "We put a weight of 3 kg on each hole; '-' is the empty foot.", "",
        "Cells (mm): toe_in (60, 35), toe_out (60, -35), heel_in (-60, 35), heel_out (-60, -35)",
    ])  # fmt: skip
    values = {f"{n}.scale": c.scale for n, c in cells.items()}
    return Made([*paths, notes], Truth(values, dict.fromkeys(values, 8e-6)))


def ohio_bench(to: Path, rng: Rng) -> Made:
    """One protocol of four cells one after the other, `Cell under test`, all of them in mV/V."""
    names = ("LC-A", "LC-B", "LC-C", "LC-D")
    cells = {n: Cell(60.0 * float(rng.uniform(0.95, 1.05)), float(rng.normal(0, 1)), 3e-4)
             for n in names}  # fmt: skip
    lines = ["Step,Cell under test,Weight (lb),LC-A (mV/V),LC-B (mV/V),LC-C (mV/V),LC-D (mV/V)"]
    step = 0
    for on in names:
        for lb in ("none", "none", "5", "10", "25", "50", "25", "10", "5", "none"):
            step += 1
            put = 0.0 if lb == "none" else float(lb) * POUND
            read = [c.read(np.array(put * (n == on)), rng, whole=False) for n, c in cells.items()]
            lines.append(f"{step},{on},{lb}," + ",".join(f"{v:.5f}" for v in read))
    notes = write(to / "notes.md", ["Dead weights by the shop, 'none' = nothing on the cell."])
    return Made([write(to / "bench.csv", lines), notes], truth_of(cells, 220))


def channel_by_number(to: Path, rng: Rng) -> Made:
    """Numbers of channels in a column, grams, a zero before each cell; feet in the file's names."""
    paths, truth = [], {}
    for side in ("L", "R"):
        lines = ["kanal\tvekt_g\tverdi"]
        for k in range(4):
            one = cell(rng)
            truth[f"{side}_{k}"] = one
            for g in (0, 0, 250, 500, 1000, 2000, 1000, 500, 250, 0):
                lines.append(f"{k}\t{g}\t{one.read(np.array(g / 1000 * G), rng):.0f}")
        paths.append(write(to / f"fot_{side}.txt", lines))
    notes = write(to / "les_meg.md", ["L er venstre fot, R er høyre. Lodd fra kjøkkenvekt."])
    values = {f"{'left' if n[0] == 'L' else 'right'}_{n[2]}": c for n, c in truth.items()}
    return Made([*paths, notes], truth_of(values))


def turkish_wrist(to: Path, rng: Rng) -> Made:
    """Means and scatter of each axis below a row of units, ways in Turkish."""
    made = tool(rng)
    ways = {"X yukarı": [-1, 0, 0], "X aşağı": [1, 0, 0], "Y yukarı": [0, -1, 0],
            "Y aşağı": [0, 1, 0], "Z yukarı": [0, 0, -1], "Z aşağı": [0, 0, 1]}  # fmt: skip
    axes = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")
    head = ["No", "Yön", *(f"{a} {k}" for a in axes for k in ("ort.", "std."))]
    units = ["", "", *["kgf"] * 6, *["kgf·cm"] * 6]
    lines, no = ["\t".join(head), "\t".join(units)], 0
    for _ in range(3):
        for way, down in ways.items():
            no += 1
            mean = made.read(np.array([down], float), rng)[0] / ([G] * 3 + [G / 100] * 3)
            pairs = np.column_stack([mean, rng.uniform(0.002, 0.01, 6)]).ravel()
            lines.append("\t".join([f"{no}", way, *(f"{v:.5f}" for v in pairs)]))
    return Made([write(to / "bilek.txt", lines)], tool_truth(made))


def legs_nose_up(to: Path, rng: Rng) -> Made:
    """`leg1_nose_up.csv`: a file for each leg and way, N and N·mm, the coxa's angle in degrees."""
    turned = {f"leg{i}": 60.0 * i for i in range(1, 5)}
    made = legs(rng, {n: Rotation.from_euler("z", a, degrees=True) for n, a in turned.items()})
    ways = {"nose_up": [-1.0, 0, 0], "nose_down": [1.0, 0, 0], "belly_down": [0, 0, -1.0],
            "belly_up": [0, 0, 1.0]}  # fmt: skip
    paths = []
    for name, leg in made.items():
        for way, down in ways.items():
            angle = swings(140)
            read = leg.read(angle, np.array(down), rng) * ([1.0] * 3 + [1000.0] * 3)
            body = rows(0.05 * np.arange(140), np.degrees(angle), *read.T, form="%.4f")
            head = "t [s],coxa [deg],Fx [N],Fy [N],Fz [N],Tx [Nmm],Ty [Nmm],Tz [Nmm]"
            paths.append(write(to / f"{name}_{way}.csv", [head, *body]))
    return Made(paths, leg_truth(made))


def forces_and_tracker(to: Path, rng: Rng) -> Made:
    """Forces of a wrist in kgf (said in the notes), the tracker's quaternion in another file."""
    made, wrench, rot = wrist(rng, 15, 50)
    t = 0.01 * np.arange(750)
    read = wrench / ([G] * 3 + [G / 100] * 3)
    force = write(to / "ft_log.txt", ["time\tfx\tfy\tfz\ttx\tty\ttz",
                                      *rows(t, *read.T, sep="\t", form="%.6f")])  # fmt: skip
    head = "time,rot_i,rot_j,rot_k,rot_real"
    pose = write(to / "tracker.csv", [head, *rows(t + 0.003, *rot.as_quat().T, form="%.7f")])
    notes = write(to / "notes.md", ["# wrist", "", "- forces in kgf, torques in kgf.cm",
                                    "- tracker mounted on the flange"])  # fmt: skip
    return Made([force, pose, notes], tool_truth(made))


def ankles_in_brackets(to: Path, rng: Rng) -> Made:
    """`FTL_0 … FTR_5`, `cm(1)`, `ddcm(1)`, `xl(1)`, `xr(1)`: units and the mass in the notes."""
    walk, felt, offset = ankles(rng)
    read = felt * ([1.0] * 3 + [100.0] * 3)
    head = ["ms", *(f"FT{s}_{i}" for s in "LR" for i in range(6))]
    head += [f"{n}({i})" for n in ("cm", "ddcm", "xl", "xr") for i in (1, 2, 3)]
    data = [*read.reshape(-1, 12).T, *walk.com.T, *walk.acc.T, *walk.feet.reshape(-1, 6).T]
    notes = write(to / "notes.md", [
        "FTL, FTR: left and right ankle, forces in N, torques in N.cm.",
        "cm is the centre of mass, ddcm its acceleration, xl and xr the soles (m).",
        "Robot: 5.2 kg",
    ])  # fmt: skip
    log = write(
        to / "walk.dat", [" ".join(head), *rows(1e3 * walk.time, *data, sep=" ", form="%.8g")]
    )
    return Made([log, notes], ankle_truth(offset))


THIRTY_EIGHTH = (
    polish_soles, boards_and_tracker, german_stances, holes_of_both_feet, ohio_bench,
    channel_by_number, turkish_wrist, legs_nose_up, forces_and_tracker, ankles_in_brackets,
)  # fmt: skip
