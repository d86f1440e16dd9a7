"""Logs as tools write them, I: bench software, spreadsheets and serial monitors.

Each shape was written down before it was run for the first time.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tests.strangers.rigs import (
    G,
    Made,
    Rng,
    cell,
    filled,
    rows,
    settling,
    steps,
    truth_of,
    write,
)

KG = (0.0, 0.5, 1.0, 1.5, 2.0)


def matlab_timetable(to: Path, rng: Rng) -> Made:
    """MATLAB's writetimetable: durations with their unit in every cell."""
    one = cell(rng, "volt")
    load = settling([0, 5, 10, 20, 0], 5, 20)
    volts = one.read(load, rng, whole=False)
    lines = ["Time,Force_N,Bridge_V"]
    lines += [
        f"{i / 20:g} sec,{f:.4f},{v:.6f}" for i, (f, v) in enumerate(zip(load, volts, strict=True))
    ]
    return Made([write(to / "tt.csv", lines)], truth_of(one))


def labview_lvm(to: Path, rng: Rng) -> Made:
    """LabVIEW measurement file: two blocks of header, a comment column that is empty."""
    one = cell(rng, "volt")
    load = settling([0, 5, 10, 20, 0], 4, 50)
    volts = one.read(load, rng, whole=False)
    head = [
        "LabVIEW Measurement\t", "Writer_Version\t2", "Reader_Version\t2", "Separator\tTab",
        "Decimal_Separator\t.", "Multi_Headings\tNo", "X_Columns\tOne", "Time_Pref\tRelative",
        "Operator\tlab", "Date\t2024/03/11", "Time\t10:11:12.3456789", "***End_of_Header***\t",
        "\t", "Channels\t2\t\t", f"Samples\t{load.size}\t{load.size}\t",
        "Date\t2024/03/11\t2024/03/11\t", "Time\t10:11:12.34\t10:11:12.34\t",
        "Y_Unit_Label\tVolts\tNewtons\t", "X_Dimension\tTime\tTime\t",
        "X0\t0.0000000000000000E+0\t0.0000000000000000E+0\t", "Delta_X\t0.020000\t0.020000\t",
        "***End_of_Header***\t\t\t", "X_Value\tBridge_0\tReference\tComment",
    ]  # fmt: skip
    body = [
        f"{i / 50:.6f}\t{v:.6f}\t{f:.6f}\t"
        for i, (v, f) in enumerate(zip(volts, load, strict=True))
    ]
    return Made([write(to / "test_001.lvm", [*head, *body], end="\r\n")], truth_of(one))


def catman_two_headers(to: Path, rng: Rng) -> Made:
    """HBM catman, German: a block of remarks, names with units in brackets, decimal commas."""
    one = cell(rng, "volt")
    load = settling([0, 5, 10, 20, 0], 4, 50)
    volts = one.read(load, rng, whole=False)
    head = [
        "HBM_CATMAN_DATAFILE_40", "Messung: Kalibrierung Fuß vorne links", "Anzahl Kanäle: 3",
        f"Kanallänge: {load.size}", "T0 = 11.03.2024 10:11:12", "", "",
        "Zeit  1 - Standardmessrate [s]\tFL_Brücke [mV/V]\tReferenz_U9C [N]\t",
    ]  # fmt: skip
    body = [f"{i / 50:.4f}\t{v:.6f}\t{f:.4f}\t".replace(".", ",") for i, (v, f) in
            enumerate(zip(volts, load, strict=True))]  # fmt: skip
    return Made([write(to / "Kalib_FL.asc", [*head, *body], "cp1252", "\r\n")], truth_of(one))


def french_excel(to: Path, rng: Rng) -> Made:
    """French Excel: semicolons, decimal commas, accents of Windows, effort in daN."""
    one = cell(rng)
    dan = steps((0, 0.5, 1.0, 2.0), 4)
    lines = ["N°;Effort appliqué (daN);Lecture brute;Température (°C);Remarque"]
    lines += [
        f"{i + 1};{d:.2f};{c:.0f};21,5;".replace(".", ",")
        for i, (d, c) in enumerate(zip(dan, one.read(dan * 10, rng), strict=True))
    ]
    return Made([write(to / "étalonnage.csv", lines, "cp1252", "\r\n")], truth_of(one))


def german_unicode_text(to: Path, rng: Rng) -> Made:
    """Excel's "Unicode text": UTF-16, tabs, a title, units in a row of their own, means below."""
    one, kg = cell(rng), steps(KG, 3)
    counts = one.read(kg * G, rng)
    lines = ["Wägezelle FL, Prüfer: K. Müller\t\t", "\t\t", "Nr.\tMasse\tAnzeige", "\tkg\tDigits"]
    lines += [f"{i + 1}\t{k:.1f}\t{c:.0f}".replace(".", ",") for i, (k, c) in
              enumerate(zip(kg, counts, strict=True))]  # fmt: skip
    lines += [f"Mittelwert\t{kg.mean():.2f}\t{counts.mean():.1f}".replace(".", ",")]
    content = "\ufeff" + "\r\n".join(lines) + "\r\n"
    path = to / "Kalibrierung.txt"
    path.write_bytes(content.encode("utf-16-le"))
    return Made([path], truth_of(one))


def tare_in_the_middle(to: Path, rng: Rng) -> Made:
    """A sketch that was told to tare half-way: the readings start again from zero."""
    one = cell(rng, "hx_small")
    g1, g2 = steps((0, 200, 500), 8), steps((0, 500, 1000), 8)
    lines = ["weight_g,reading"]
    lines += [f"{k:.0f},{c:.0f}" for k, c in zip(g1, one.read(g1 * G / 1e3, rng), strict=True)]
    lines += [
        f"{k:.0f},{c - 65000:.0f}" for k, c in zip(g2, one.read(g2 * G / 1e3, rng), strict=True)
    ]
    return Made([write(to / "scale.csv", lines)], says="offline-fit")


def two_rows_of_names(to: Path, rng: Rng) -> Made:
    """A sheet with merged cells: the sensor above, load and reading below it."""
    cells, gf = {"FL": cell(rng), "FR": cell(rng)}, steps((0, 500, 1000, 2000), 4)
    read = {n: c.read(gf * G / 1e3, rng) for n, c in cells.items()}
    lines = ["FL,,FR,", "Load (gf),Raw,Load (gf),Raw"]
    lines += [f"{k:.0f},{a:.0f},{k:.0f},{b:.0f}" for k, a, b in
              zip(gf, read["FL"], read["FR"], strict=True)]  # fmt: skip
    truth = truth_of({n.lower(): c for n, c in cells.items()})
    return Made([write(to / "merged.csv", lines)], truth)


def units_below_the_rows(to: Path, rng: Rng) -> Made:
    """A logger that writes the units when it closes the file."""
    one, kg = cell(rng), steps(KG, 4)
    lines = ["mass,output", *rows(kg, one.read(kg * G, rng)), "kg,counts"]
    return Made([write(to / "closed.csv", lines)], truth_of(one))


def comments_change_the_load(to: Path, rng: Rng) -> Made:
    """A CSV of four cells; the weight on each is typed as a comment between the rows."""
    cells = {n: cell(rng) for n in ("fl", "fr", "rl", "rr")}
    lines = ["# foot 2, one weight on all four in turn", "ms,fl,fr,rl,rr"]
    now = 0
    for kg in (0, 0.5, 1, 2):
        lines.append(f"# load {kg} kg")
        for _ in range(6):
            read = [c.read(np.array([kg * G]), rng)[0] for c in cells.values()]
            lines.append(",".join([str(now), *(f"{r:.0f}" for r in read)]))
            now += 100
    return Made([write(to / "foot2.csv", lines)], truth_of(cells))


def runs_beside_each_other(to: Path, rng: Rng) -> Made:
    """One cell, its three runs in columns."""
    one, kg = cell(rng), np.array(KG)
    reads = [one.read(kg * G, rng) for _ in range(3)]
    lines = ["Load [kg],Run 1,Run 2,Run 3", *rows(kg, *reads)]
    return Made([write(to / "three_runs.csv", lines)], truth_of(one))


def micros_wrapped(to: Path, rng: Rng) -> Made:
    """Teensy: micros() in 32 bits starts again from zero during the recording."""
    one = cell(rng)
    load = settling([0, 5, 10, 20, 0], 5, 80)
    us = (4_280_000_000 + np.arange(load.size) * 12_500) % 2**32
    lines = ["micros,raw", *rows(us.astype(float), one.read(load, rng), form="%.0f")]
    return Made([write(to / "teensy.csv", lines)], truth_of(one), says="loads",
                fill=filled(loads='"0, 5, 10, 20, 0 N"'))  # fmt: skip


def dewesoft_own_times(to: Path, rng: Rng) -> Made:
    """Every channel with its own time column, the columns called alike."""
    one = cell(rng, "volt")
    load = settling([0, 5, 10, 20, 0], 4, 50)
    volts = one.read(load, rng, whole=False)
    t = np.arange(load.size) / 50
    lines = ["Time (s),Value (V),Time (s),Value (N)", *rows(t, volts, t, load, form="%.6f")]
    return Made([write(to / "dewesoft.csv", lines)], truth_of(one))


def press_lbf(to: Path, rng: Rng) -> Made:
    """An Instron: quoted names and units, decimal points, thousands quoted."""
    one = cell(rng, "volt")
    lbf = settling([0, 1, 2, 4, 0], 4, 20)
    volts = one.read(lbf * 4.4482216152605, rng, whole=False)
    lines = ['"Specimen label","FL-07"', '"Rate 1","0.5","in/min"', "",
             "Time,Extension,Load,Strain gage input", "(s),(in),(lbf),(V)"]  # fmt: skip
    lines += [f'"{i / 20:.3f}","{0.01 * f:.5f}","{f:.5f}","{v:.6f}"' for i, (f, v) in
              enumerate(zip(lbf, volts, strict=True))]  # fmt: skip
    return Made([write(to / "instron.csv", lines)], truth_of(one))


def grams_of_a_scale(to: Path, rng: Rng) -> Made:
    """A scale that was calibrated once says grams; the weights put on stand beside."""
    grams = steps((0, 100, 200, 500, 1000), 5)
    shown = grams * 0.97 + 1.5 + rng.normal(0, 0.3, grams.size)
    lines = ["put on (g);display (g)"]
    lines += [f"{k:.0f};{s:.1f}" for k, s in zip(grams, shown, strict=True)]
    # F = scale · reading + bias, both in N: the load is (reading − 1.5 g) / 0.97
    truth = truth_of(type(cell(rng))(1 / 0.97, -1.5e-3 * G / 0.97, 0.003), 10)
    return Made([write(to / "kitchen.csv", lines)], truth)


FOURTH = (
    matlab_timetable, labview_lvm, catman_two_headers, french_excel, german_unicode_text,
    tare_in_the_middle, two_rows_of_names, units_below_the_rows, comments_change_the_load,
    runs_beside_each_other, micros_wrapped, dewesoft_own_times, press_lbf, grams_of_a_scale,
)  # fmt: skip
