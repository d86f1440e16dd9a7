"""Twelve more logs, written after the mends of the twenty-sixth and run once as they are.

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


def robot_vise_report(to: Path, rng: Rng) -> Made:
    """A torn-off table of a report: fixed widths, a title, a line below that sums it up."""
    one, kg = cell(rng), steps(_KG, 2)
    read = one.read(kg * G, rng)
    lines = ["Table 3: calibration of foot FL", "", f"{'mass [kg]':>12}{'ADC':>14}"]
    lines += [f"{k:12.3f}{c:14.0f}" for k, c in zip(kg, read, strict=True)]
    lines += ["", f"{'mean':>12}{read.mean():14.0f}"]
    return Made([write(to / "table3.txt", lines)], truth_of(one, 50))


def set_and_measured(to: Path, rng: Rng) -> Made:
    """French: `consigne` and `mesurée`, five per cent apart, and the bridge."""
    one, target = Cell(980.0, -5.0, 2e-5), steps((0, 200, 400, 600, 800), 4)
    actual = 0.95 * target + rng.normal(0, 1, target.size)
    body = rows(target, actual, one.read(actual, rng, whole=False), sep=";", form="%.6f")
    lines = ["Force consigne (N);Force mesurée (N);Pont (mV/V)",
             *(x.replace(".", ",") for x in body)]  # fmt: skip
    return Made([write(to / "essai.csv", lines, "latin-1")], truth_of(one, 800))


def kilos_of_water(to: Path, rng: Rng) -> Made:
    """Bottles hung one after another; the load column says how many of 1.02 kg."""
    one = cell(rng)
    lines = ["bottles (1.02 kg each),raw"]
    for n in (0, 1, 2, 3, 5):
        lines += [f"{n},{c:.0f}" for c in one.read(np.full(4, n * 1.02 * G), rng)]
    return Made([write(to / "bottles.csv", lines)], says="unit of the load")


def comment_column_of_loads(to: Path, rng: Rng) -> Made:
    """A stream whose last column is empty but where somebody wrote `5lb on`, `all off`."""
    one, lines = cell(rng), ["ms,raw,comment"]
    load = settling([0, 5, 10, 0], 6, 10, 1.0) * 0.45359237 * G
    words = {0: "all off", 70: "5 lb on", 140: "10 lb on", 210: "all off"}
    for i, c in enumerate(one.read(load, rng)):
        lines.append(f"{100 * i},{c:.0f},{words.get(i, '')}")
    return Made([write(to / "notes.csv", lines)], truth_of(one, 50))


def file_for_each_hold_by_minutes(to: Path, rng: Rng) -> Made:
    """A file for each hold, a sheet with its number and rotation vectors in degrees."""
    made, wrench, rot = wrist(rng, 12, 20)
    paths, sheet = [], ["No.;rotvec_x [deg];rotvec_y [deg];rotvec_z [deg]"]
    for i in range(12):
        body = rows(*wrench[20 * i : 20 * (i + 1)].T, form="%.5f")
        paths.append(write(to / f"run{i + 1}.txt", [" ".join(_FT), *(b.replace(",", " ")
                                                                    for b in body)]))  # fmt: skip
        turn = np.degrees(rot[20 * i].as_rotvec())
        sheet.append(f"{i + 1};" + ";".join(f"{v:.4f}" for v in turn))
    return Made([*paths, write(to / "sheet.csv", sheet)], tool_truth(made))


def plate_force_down_points(to: Path, rng: Rng) -> Made:
    """Force on the plate, z down: marks, Fz, Mx and My with units in a row of their own."""
    lines = ["mark_x,mark_y,Fz,Mx,My", "cm,cm,N,N.cm,N.cm"]
    for x in (-15, 0, 15):
        for y in (-20, 0, 20):
            for _ in range(3):
                fz = -rng.normal(350, 5)
                u, v = 1.01 * x + 0.2 + rng.normal(0, 0.02), 1.02 * y - 0.3 + rng.normal(0, 0.02)
                lines.append(f"{x},{y},{fz:.2f},{fz * v:.2f},{-fz * u:.2f}")
    return Made([write(to / "down.csv", lines)], cop_within_m=1.5e-3)


def treadmill_in_kilograms(to: Path, rng: Rng) -> Made:
    """Two insoles in kgf with centres in mm, sides as suffixes; the mass is added."""
    mass, gain = 59.0, (1.05, 0.94)
    share = settling([0.4, 0.6, 0.3, 0.55, 0.5], 5, 50)
    parts = np.column_stack([share, 1 - share])
    f = parts * mass / np.array(gain) + rng.normal(0, 0.1, parts.shape)
    cop = rng.normal(0, 4, (share.size, 4))
    names = "t[s],Force_L[kgf],CoPx_L[mm],CoPy_L[mm],Force_R[kgf],CoPx_R[mm],CoPy_R[mm]"
    body = rows(np.arange(share.size) / 50, f[:, 0], *cop[:, :2].T, f[:, 1], *cop[:, 2:].T)
    cells = {f"{n}_p{i}.scale": g for n, g in zip(("left", "right"), gain, strict=True)
             for i in (1, 2, 3)}  # fmt: skip
    return Made([write(to / "insoles.csv", [names, *body])],
                Truth(cells, dict.fromkeys(cells, 0.1)), says="weigh",
                fill=filled(mass_kg=f"{mass}"))  # fmt: skip


def ros_json_of_two_arms(to: Path, rng: Rng) -> Made:
    """One JSON object a line, a wrench and a matrix in nested lists."""
    made, wrench, rot = wrist(rng)
    lines = [json.dumps({"t": round(0.02 * i, 3), "ft": w.round(5).tolist(),
                         "R": r.round(6).tolist()})
             for i, (w, r) in enumerate(zip(wrench, rot.as_matrix(), strict=True))]  # fmt: skip
    return Made([write(to / "arm.jsonl", lines)], tool_truth(made))


def counts_with_their_sign_apart(to: Path, rng: Rng) -> Made:
    """A display's print: sign, blanks, number, unit; the weight in grams before it."""
    one = Cell(-0.0098, 3.0, 1.0)
    lines = ["Set [g];Print"]
    for g in (0, 200, 500, 1000, 2000):
        for c in one.read(np.full(3, g * 1e-3 * G), rng):
            lines.append(f"{g};{'-' if c < 0 else '+'}{abs(c):8.0f} d")
    return Made([write(to / "print.csv", lines)], truth_of(one, 20))


def two_cells_in_turn(to: Path, rng: Rng) -> Made:
    """Rows of two cells in turn, the load of a row that was not noted left empty."""
    cells, lines = {"left": cell(rng), "right": cell(rng)}, ["cell,load_kg,counts"]
    for kg in _KG:
        for name, one in cells.items():
            lines += [f"{name},{f'{kg:g}' if i == 0 else ''},{c:.0f}"
                      for i, c in enumerate(one.read(np.full(3, kg * G), rng))]  # fmt: skip
    return Made([write(to / "both.csv", lines)], truth_of(cells, 50))


def quaternion_drifts_in_length(to: Path, rng: Rng) -> Made:
    """A quaternion of an estimator whose length drifts by a tenth."""
    made, wrench, rot = wrist(rng)
    quat = rot.as_quat() * np.linspace(0.95, 1.05, 300)[:, None]
    lines = [",".join(["t", *_FT, "qx", "qy", "qz", "qw"]),
             *rows(np.arange(300) / 50, *wrench.T, *quat.T, form="%.6f")]  # fmt: skip
    return Made([write(to / "drift.csv", lines)], tool_truth(made))


def spanish_press(to: Path, rng: Rng) -> Made:
    """A press in Spanish, thousands by points, decimals by commas, a total below."""
    one, load = Cell(980.0, -5.0, 2e-5), steps((0, 500, 1000, 1500, 1000, 0), 3)
    read = one.read(load, rng, whole=False)
    swap = str.maketrans(",.", ".,")
    lines = ["Carga (N);Señal (mV/V)", *(f"{f:,.1f};{c:.6f}".translate(swap)
                                        for f, c in zip(load, read, strict=True))]  # fmt: skip
    lines.append(f"Total;{read.sum():.6f}".translate(swap))
    return Made([write(to / "prensa.csv", lines, "latin-1")], truth_of(one, 1500))


TWENTY_SEVENTH = (
    robot_vise_report, set_and_measured, kilos_of_water, comment_column_of_loads,
    file_for_each_hold_by_minutes, plate_force_down_points, treadmill_in_kilograms,
    ros_json_of_two_arms, counts_with_their_sign_apart, two_cells_in_turn,
    quaternion_drifts_in_length, spanish_press,
)  # fmt: skip
