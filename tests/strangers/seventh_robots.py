"""Logs as laboratories keep them, III: feet that stand and walk, plates, insoles."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tests.strangers.rigs import Cell, G, Made, Rng, Truth, filled, rows, settling, write

STAND_IN = 0.1
"""Shares of the cells that stand in for a plate are known to 0.05 each, two of that are allowed."""
FOUR = ("FL", "FR", "RL", "RR")


def bioware_two_plates(to: Path, rng: Rng) -> Made:
    """Kistler's BioWare with two plates: the same names twice, a row that numbers them."""
    n = 500
    one = ("Fx", "Fy", "Fz", "|Ft|", "Ax", "Ay")
    head = ["Bioware V5.4", "File: standing.dat", "Sampling rate (Hz): 100", "",
            "abs time (s)\t" + "\t".join(one * 2), "s" + "\tN\tN\tN\tN\tm\tm" * 2]  # fmt: skip
    data = [np.arange(n) / 100]
    for side in (0.52, 0.48):
        fz = 700 * side + rng.normal(0, 2, n)
        data += [*rng.normal(0, 1, (2, n)), fz, np.abs(fz), *rng.normal(0.02, 0.003, (2, n))]
    return Made([write(to / "bioware.txt", [*head, *rows(*data, sep="\t")])], says="weigh")


def pedar(to: Path, rng: Rng) -> Made:
    """novel's pedar: force, pressures and centre of pressure of both insoles."""
    n = 400
    head = ["file name: walk01.sol", "sensor type: W1213", "total time [secs]: 4.0",
            "time[secs]" + "".join(
                f"\t{s} foot force[N]\t{s} max pressure[kPa]\t{s} cop x[mm]\t{s} cop y[mm]"
                for s in ("left", "right")
            )]  # fmt: skip
    data = [np.arange(n) / 100]
    for _ in "lr":
        data += [rng.normal(360, 4, n), rng.normal(120, 3, n), rng.normal(35, 1, n),
                 rng.normal(120, 2, n)]  # fmt: skip
    return Made([write(to / "walk01.fgt", [*head, *rows(*data, sep="\t", form="%.3f")])],
                says="weigh")  # fmt: skip


def merged_header(to: Path, rng: Rng) -> Made:
    """A sheet whose first row names the foot once above four columns."""
    n = 250
    head = [",Left,,,,Right,,,", "t [s]," + ",".join(FOUR * 2)]
    body = rows(np.arange(n) / 50, *rng.integers(8_300_000, 8_310_000, (8, n)))
    return Made([write(to / "feet.csv", [*head, *body])], says="where the cells sit")


def three_cells_a_foot(to: Path, rng: Rng) -> Made:
    """A biped with three cells a foot by number, milliseconds, an event column."""
    n = 300
    head = "ms,L1,L2,L3,R1,R2,R3,event"
    body = [x + ("," if i else ",start") for i, x in enumerate(
        rows(20.0 * np.arange(n), *rng.integers(400_000, 410_000, (6, n))))]  # fmt: skip
    return Made([write(to / "biped.csv", [head, *body])], says="where the cells sit")


def corner_scales(to: Path, rng: Rng) -> Made:
    """Four scales under a quadruped, kg, the legs' names in English words."""
    n = 200
    head = "Time;Front left (kg);Front right (kg);Hind left (kg);Hind right (kg)"
    lines = rows(np.arange(n) / 10, *rng.normal(7.2, 0.02, (4, n)), sep=";", form="%.3f")
    return Made([write(to / "scales.csv", [head, *(x.replace(".", ",") for x in lines)])],
                says="weigh")  # fmt: skip


def insole_forces_filled(to: Path, rng: Rng) -> Made:
    """Two insoles in kgf with CoP in cm; a person adds the mass and gets the scales."""
    share = settling([0.3, 0.5, 0.7, 0.4, 0.6], 5, 50)
    n, mass, gain = share.size, 62.0, (0.93, 1.07)
    data = [np.arange(n) / 50]
    for part, g, y in ((share, gain[0], 9.0), (1 - share, gain[1], -9.0)):
        data += [part * mass / g + rng.normal(0, 0.1, n), rng.normal(2, 0.1, n),
                 rng.normal(y, 0.1, n)]  # fmt: skip
    head = "time_s,L_force_kgf,L_CoP_x_cm,L_CoP_y_cm,R_force_kgf,R_CoP_x_cm,R_CoP_y_cm"
    cells = {f"{side}_p{i}.scale": g for side, g in zip(("left", "right"), gain, strict=True)
             for i in (1, 2, 3)}  # fmt: skip
    return Made([write(to / "insoles.csv", [head, *rows(*data)])],
                Truth(cells, dict.fromkeys(cells, STAND_IN)), says="weigh",
                fill=filled(mass_kg=f"{mass}"))  # fmt: skip


def ankles_of_a_humanoid(to: Path, rng: Rng) -> Made:
    """Both ankles' wrenches, names with the side in the middle, moments first."""
    n = 300
    axes = ("mx", "my", "mz", "fx", "fy", "fz")
    names = ["t", *(f"ft_left_ankle_{a}" for a in axes), *(f"ft_right_ankle_{a}" for a in axes)]
    data = [np.arange(n) / 200]
    for _ in "lr":
        data += [*rng.normal(0, 0.5, (3, n)), *rng.normal(0, 1, (2, n)), rng.normal(310, 2, n)]
    return Made([write(to / "ankles.csv", [",".join(names), *rows(*data)])], says="weigh")


def walk_with_body(to: Path, rng: Rng) -> Made:
    """A walk: cells of both feet and the body's motion in one table, capitals and brackets."""
    n = 300
    names = ["Time [s]", *(f"{s} {p} [cnt]" for s in ("Left", "Right") for p in FOUR),
             *(f"CoM {a} [m]" for a in "XYZ"), *(f"CoM acc {a} [m/s^2]" for a in "XYZ"),
             *(f"{s} foot {a} [m]" for s in ("Left", "Right") for a in "XYZ")]  # fmt: skip
    data = [np.arange(n) / 100, *rng.integers(8_000_000, 8_400_000, (8, n)),
            *rng.normal(0, 0.01, (2, n)), rng.normal(0.3, 0.001, n), *rng.normal(0, 0.2, (3, n)),
            *rng.normal(0, 0.01, (6, n))]  # fmt: skip
    return Made([write(to / "walk.csv", [",".join(names), *rows(*data)])],
                says="where the cells sit")  # fmt: skip


def quadruped_counts_two_boards(to: Path, rng: Rng) -> Made:
    """A cell in each foot, the front and the hind board in a file each, stamps in µs."""
    n, paths = 300, []
    for board, legs in (("front", ("FL", "FR")), ("hind", ("HL", "HR"))):
        head = "us," + ",".join(f"{leg}_raw" for leg in legs)
        body = rows(4000.0 * np.arange(n), *rng.integers(90_000, 92_000, (2, n)))
        paths.append(write(to / f"board_{board}.csv", [head, *body]))
    return Made(paths, says="weigh")


def plates_by_number_filled(to: Path, rng: Rng) -> Made:
    """Two balance boards by number, newtons and metres; scales after the mass is added."""
    share = settling([0.35, 0.55, 0.7, 0.4, 0.6, 0.5], 5, 50)
    n, mass, gain = share.size, 48.0, (1.05, 0.97)
    data, names = [50 + np.arange(n) / 50], ["timestamp (s)"]
    for i, (part, g) in enumerate(zip((share, 1 - share), gain, strict=True), 1):
        names += [f"Plate {i} Fz (N)", f"Plate {i} CoPx (m)", f"Plate {i} CoPy (m)"]
        data += [part * mass * G / g + rng.normal(0, 1, n), *rng.normal(0.01, 0.002, (2, n))]
    cells = {f"plate_{k}_p{i}.scale": g for k, g in enumerate(gain, 1) for i in (1, 2, 3)}
    return Made([write(to / "boards.csv", [",".join(names), *rows(*data, form="%.6f")])],
                Truth(cells, dict.fromkeys(cells, STAND_IN)), says="weigh",
                fill=filled(mass_kg=f"{mass}"))  # fmt: skip


def press_against_reference(to: Path, rng: Rng) -> Made:
    """A foot's single cell in a press against a reference, compression negative on both."""
    from tests.strangers.rigs import truth_of

    one = Cell(0.011, -2.0, 3.0)
    t = np.arange(1500) / 50
    load = -(150 - 120 * np.cos(2 * np.pi * t / 12))
    lines = ["Time (s),Reference force (N),Foot cell (counts)",
             *rows(t, load + rng.normal(0, 0.2, t.size), one.read(load, rng))]  # fmt: skip
    return Made([write(to / "press.csv", lines)], truth_of(one, 270))


SEVENTH_ROBOTS = (
    bioware_two_plates, pedar, merged_header, three_cells_a_foot, corner_scales,
    insole_forces_filled, ankles_of_a_humanoid, walk_with_body, quadruped_counts_two_boards,
    plates_by_number_filled, press_against_reference,
)  # fmt: skip
