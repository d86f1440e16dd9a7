"""Logs as laboratories keep them, I: weights on cells, in sheets, serial logs and testing machines.

All of the seventh corpus was written before any of it was run; `docs/bring_your_log.md` has its
count on the first run.
"""

from __future__ import annotations

from datetime import UTC, datetime, timedelta, timezone
from pathlib import Path

import numpy as np

from tests.strangers.rigs import Cell, G, Made, Rng, cell, rows, settling, steps, truth_of, write

LB, OZ = 0.45359237, 0.028349523125


def sparkfun_sketch(to: Path, rng: Rng) -> Made:
    """A calibration sketch: instructions first, then a reading and a factor on every line."""
    one = cell(rng, "hx_small")
    lines = ["HX711 calibration sketch", "Remove all weight from scale",
             "After readings begin, place known weight on scale",
             "Press + or a to increase calibration factor", ""]  # fmt: skip
    for pounds in (0, 1, 2, 5):
        lines.append(f"Place {pounds} lb")
        lines += [f"Reading: {c:.0f} raw, calibration_factor: -7050.00"
                  for c in one.read(np.full(9, pounds * LB * G), rng)]  # fmt: skip
    return Made([write(to / "sketch.txt", lines, end="\r\n")], truth_of(one))


def key_value_serial(to: Path, rng: Rng) -> Made:
    """Keys and values on each line, semicolons between, the unit glued to the number."""
    cells, kg = {"ch1": cell(rng), "ch2": cell(rng)}, steps((0, 1, 2, 4), 8)
    reading = [one.read(kg * G, rng) for one in cells.values()]
    lines = [f"t=12{i:03d};load={k:.1f}kg;ch1={a:.0f};ch2={b:.0f}"
             for i, (k, a, b) in enumerate(zip(kg, *reading, strict=True))]  # fmt: skip
    named = dict(zip(("1", "2"), cells.values(), strict=True))
    return Made([write(to / "serial.log", lines)], truth_of(named))


def monitor_two_cells(to: Path, rng: Rng) -> Made:
    """Arduino's monitor with stamps, two cells by tabs, the load typed in between."""
    cells = [cell(rng), cell(rng)]
    lines, n = [], 0
    for kg in (0, 1, 2, 3):
        lines.append(f"14:02:{n // 10:02d}.000 -> load {kg} kg")
        for a, b in zip(*(c.read(np.full(10, kg * G), rng) for c in cells), strict=True):
            n += 1
            lines.append(f"14:02:{n // 10:02d}.{100 * (n % 10):03d} -> {a:.0f}\t{b:.0f}")
    named = dict(zip(("reading", "reading_2"), cells, strict=True))  # nothing names them
    return Made([write(to / "monitor.txt", lines)], truth_of(named))


def catman(to: Path, rng: Rng) -> Made:
    """HBM's catman as text: a head of ten lines, tabs, decimal commas, a reference that moves."""
    one = Cell(420.0, -35.0, 2e-4)
    t = np.arange(1500) / 50
    load = 220 - 180 * np.cos(2 * np.pi * t / 15)
    head = ["HBM_CATMAN_DATAFILE_40", "File created:\t12.03.2024 14:02:11", "Comment:\tSchuh 2",
            "Number of channels:\t3", "Max. channel length:\t1500",
            "Zeit  1 - Standardmessrate [s]\tKraft_Ref [N]\tDMS_Bruecke [mV/V]",
            "Sample rate: 50 Hz\tSensor type: Standard\tSensor type: 350 Ohm Vollbruecke",
            "\tMX840A CH 1\tMX840A CH 2"]  # fmt: skip
    body = rows(t, load + rng.normal(0, 0.3, t.size), one.read(load, rng, whole=False), sep="\t",
                form="%.6f")  # fmt: skip
    lines = [*head, *(x.replace(".", ",") for x in body)]
    return Made([write(to / "messung.asc", lines, "latin-1", "\r\n")], truth_of(one, 400))


def zwick(to: Path, rng: Rng) -> Made:
    """testXpert: quoted names, a row of units, compression negative."""
    one = Cell(-38.0, 4.0, 1e-3)
    load = -settling([0, 50, 100, 200, 100, 0], 4, 20)
    head = ['"Prüfzeit";"Standardkraft";"Standardweg";"Kraftaufnehmer 2"', '"s";"N";"mm";"V"']
    body = rows(np.arange(load.size) / 20, load + rng.normal(0, 0.05, load.size), -load / 900,
                one.read(load, rng, whole=False), sep=";", form="%.5f")  # fmt: skip
    return Made([write(to / "zwick.TRA", [*head, *(x.replace(".", ",") for x in body)], "cp1252")],
                truth_of(one, 200))  # fmt: skip


def instron(to: Path, rng: Rng) -> Made:
    """Bluehill: every field quoted, units in brackets in a row below, kilonewtons."""
    one = Cell(52.0, -3.0, 1e-3)
    load = settling([0, 100, 250, 400, 0], 4, 20)
    lines = ["Specimen 1", "", '"Time","Load","Extension","Strain 1"', '"(s)","(kN)","(mm)","(V)"']
    for i, (f, v) in enumerate(zip(load, one.read(load, rng, whole=False), strict=True)):
        lines.append(f'"{i / 20:.3f}","{f / 1e3:.6f}","{f / 800:.4f}","{v:.5f}"')
    return Made([write(to / "Specimen_RawData_1.csv", lines)], truth_of(one, 400))


def google_sheet(to: Path, rng: Rng) -> Made:
    """A shared sheet: who, when, ounces, what the display said, remarks; a row of tare first."""
    one, oz = cell(rng), (0, 8, 16, 32, 64, 0, 8, 16, 32, 64)
    lines = ["Timestamp,Operator,Weight (oz),ADC reading,Notes"]
    for i, w in enumerate(oz):
        note = "tare" if i == 0 else '"dropped it, again"' if i == 6 else ""
        c = one.read(np.asarray(w * OZ * G), rng)
        lines.append(f"3/12/2024 14:{10 + i}:05,Jo,{w},{c:.0f},{note}")
    return Made([write(to / "Calibration - Sheet1.csv", lines)], truth_of(one))


def french_sheet(to: Path, rng: Rng) -> Made:
    """Excel in France: narrow blanks between thousands, decimal commas, degrees beside."""
    one, grams = Cell(4.6e-4, -45.0, 12.0), steps((0, 250, 500, 1000, 2000), 4)
    lines = ["Essai;Masse (g);Lecture brute;Température (°C)"]
    for i, (g, c) in enumerate(zip(grams, one.read(grams * 1e-3 * G, rng), strict=True)):
        count = f"{c:,.0f}".replace(",", "\u202f")
        mass = f"{g:,.1f}".replace(",", "\u202f").replace(".", ",")
        lines.append(f"{i + 1};{mass};{count};{22.1 + 0.01 * i:.2f}".replace("22.", "22,"))
    return Made([write(to / "étalonnage.csv", lines, "utf-8-sig", "\r\n")], truth_of(one))


def turned_sheet(to: Path, rng: Rng) -> Made:
    """A sheet on its side: a line of loads, a line of readings for each cell."""
    cells, kg = {f"Cell {x}": cell(rng) for x in "ABC"}, steps((0, 0.5, 1, 2, 5), 1)
    lines = ["Load [kg]," + ",".join(f"{k:g}" for k in kg)]
    for name, one in cells.items():
        lines.append(f"{name}," + ",".join(f"{c:.0f}" for c in one.read(kg * G, rng)))
    named = dict(zip("abc", cells.values(), strict=True))
    return Made([write(to / "sheet.csv", lines)], truth_of(named))


def sections_of_cells(to: Path, rng: Rng) -> Made:
    """A block for each cell, its name on a line of its own above a header that repeats."""
    cells, grams = {n: cell(rng) for n in ("FL", "FR", "RL", "RR")}, steps((0, 500, 1000), 3)
    lines: list[str] = []
    for name, one in cells.items():
        lines += [f"Cell {name}", "load_g,counts"]
        lines += rows(grams, one.read(grams * 1e-3 * G, rng))
        lines.append("")
    return Made([write(to / "blocks.csv", lines)], truth_of(cells))


def which_cell_is_loaded(to: Path, rng: Rng) -> Made:
    """Six cells named by the compass, all read; a column says on which one the weight lies."""
    cells = {n: cell(rng) for n in ("N", "NE", "SE", "S", "SW", "NW")}
    lines = ["loaded_cell,mass_kg," + ",".join(cells)]
    for name in cells:
        for kg in (0, 1, 2, 4):
            reading = [one.read(np.asarray(kg * G * (other == name)), rng)
                       for other, one in cells.items()]  # fmt: skip
            lines.append(f"{name},{kg}," + ",".join(f"{c:.0f}" for c in reading))
    return Made([write(to / "compass.csv", lines)], truth_of(cells))


def folder_per_weight(to: Path, rng: Rng) -> Made:
    """The same name in a folder for each weight."""
    one, paths = cell(rng), []
    for grams in (0, 500, 1000, 2000):
        folder = to / f"{grams}g"
        folder.mkdir()
        body = rows(np.arange(25) * 100.0, one.read(np.full(25, grams * 1e-3 * G), rng))
        paths.append(write(folder / "log.csv", ["ms,raw", *body]))
    return Made(paths, truth_of(one))


def ounces_in_names(to: Path, rng: Rng) -> Made:
    """One file per weight in ounces, and one that is called zero."""
    one, paths = cell(rng), []
    for oz in (0, 8, 16, 40):
        name = f"cell2_{oz}oz.csv" if oz else "cell2_zero.csv"
        paths.append(write(to / name, ["reading", *rows(one.read(np.full(25, oz * OZ * G), rng))]))
    return Made(paths, truth_of(one))


def event_column(to: Path, rng: Rng) -> Made:
    """A stream with a column of events, empty but where somebody pressed a key."""
    one, lines = cell(rng), ["t_s,raw,event"]
    for i, kg in enumerate((0, 1, 2, 4)):
        for j, c in enumerate(one.read(np.full(40, kg * G), rng)):
            event = f"load {kg} kg" if j == 0 else ""
            lines.append(f"{(40 * i + j) / 10:.1f},{c:.0f},{event}")
    return Made([write(to / "events.csv", lines)], truth_of(one))


def zoned_index(to: Path, rng: Rng) -> Made:
    """pandas with an index of times in a zone and no name of it."""
    one, load = cell(rng), settling([0, 5, 10, 20, 10, 0], 5, 10)
    start = datetime(2024, 5, 1, 12, tzinfo=timezone(timedelta(hours=2)))
    lines = [",load_N,adc"]
    for i, (f, c) in enumerate(zip(load, one.read(load, rng), strict=True)):
        lines.append(f"{start + timedelta(milliseconds=100 * i)},{f:.3f},{c:.0f}")
    return Made([write(to / "frame.csv", lines)], truth_of(one))


def epoch_ms_and_zulu(to: Path, rng: Rng) -> Made:
    """Milliseconds since 1970 and the same in ISO with a Z, kilograms-force, volts of 12 bits."""
    one, kgf = Cell(110.0, -55.0, 8e-4), steps((0, 5, 10, 20), 15)
    start = datetime(2024, 5, 1, 12, tzinfo=UTC)
    lines = ["epoch_ms,iso,load_kgf,A0_V"]
    for i, (k, v) in enumerate(zip(kgf, one.read(kgf * G, rng, whole=False), strict=True)):
        at = start + timedelta(milliseconds=200 * i)
        iso = at.isoformat(timespec="milliseconds").replace("+00:00", "Z")
        lines.append(f"{at.timestamp() * 1e3:.0f},{iso},{k:g},{v:.5f}")
    return Made([write(to / "adc.csv", lines)], truth_of(one, 200))


def bare_hexadecimal(to: Path, rng: Rng) -> Made:
    """Counts as six hexadecimal digits without a mark, as a debugger prints them."""
    one, kg = Cell(3.4e-5, -110.0, 40.0), steps((0, 1, 2, 4), 8)
    reading = one.read(kg * G, rng)
    lines = ["load_kg,raw_hex", *(f"{k:g},{int(c):06X}" for k, c in zip(kg, reading, strict=True))]
    return Made([write(to / "hex.csv", lines)], truth_of(one))


def dewesoft(to: Path, rng: Rng) -> Made:
    """DewesoftX as text: facts about the file in a block, names with units, a reference cell."""
    one = Cell(21.0, -1.0, 1e-3)
    t = np.arange(1200) / 40
    load = 60 + 45 * np.sin(2 * np.pi * t / 10 - 1.5)
    head = ["Data info", "File name:,press_07.dxd", "Start time:,3/12/2024 2:02:11 PM",
            "Number of channels:,2", "Sample rate:,40", "",
            "Time (s),Ref/S9M (N),AI 2/DUT (V)"]  # fmt: skip
    body = rows(t, load + rng.normal(0, 0.05, t.size), one.read(load, rng, whole=False))
    return Made([write(to / "press_07.csv", [*head, *body])], truth_of(one, 100))


def matlab_struct(to: Path, rng: Rng) -> Made:
    """A struct with fields of different lengths: readings, loads, and facts about the rig."""
    from scipy.io import savemat

    one, kg = cell(rng), steps((0, 1, 2, 4), 10)
    savemat(to / "run3.mat", {"run3": {
        "t": 0.1 * np.arange(kg.size), "mass_kg": kg, "raw": one.read(kg * G, rng),
        "fs": 10.0, "operator": "KL",
    }})  # fmt: skip
    return Made([to / "run3.mat"], truth_of(one))


def candump(to: Path, rng: Rng) -> Made:
    """Frames of a bus as candump writes them: nobody can know what the bytes are."""
    lines = [f"(1710251872.{i:06d}) can0 181#{int(v):08X}" for i, v in
             enumerate(rng.integers(1 << 20, 1 << 24, 200))]  # fmt: skip
    return Made([write(to / "candump.log", lines)], says="decode")


SEVENTH_BENCH = (
    sparkfun_sketch, key_value_serial, monitor_two_cells, catman, zwick, instron, google_sheet,
    french_sheet, turned_sheet, sections_of_cells, which_cell_is_loaded, folder_per_weight,
    ounces_in_names, event_column, zoned_index, epoch_ms_and_zulu, bare_hexadecimal, dewesoft,
    matlab_struct, candump,
)  # fmt: skip
