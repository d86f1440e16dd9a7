"""Logs as tools write them, III: weights on cells, by serial monitors, recorders and tables.

All of the sixth corpus was written from memory of the tools, before the code that guesses was
read; `docs/bring_your_log.md` has its count on the first run.
"""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from tests.strangers.rigs import (
    Cell,
    G,
    Made,
    Rng,
    Truth,
    cell,
    rows,
    settling,
    steps,
    truth_of,
    write,
)

FOUR = ("fl", "fr", "rl", "rr")


def bogde_example(to: Path, rng: Rng) -> Made:
    """The example of the HX711 library in the serial monitor, a log for each weight."""
    one, paths = Cell(1.06, -0.2, 0.003), []
    for grams in (0, 200, 500, 1000, 2000):
        kg = one.read(np.full(30, grams * 1e-3 * G), rng, whole=False) / G
        lines = ["12:34:50.112 -> HX711 Demo", "12:34:50.140 -> Readings:"]
        for i, v in enumerate(kg):
            stamp = f"12:34:{51 + i // 10:02d}.{100 * (i % 10):03d}"
            lines.append(f"{stamp} -> one reading:\t{v:.4f} kg"
                         f"\t| average:\t{kg.mean():.4f}")  # fmt: skip
        paths.append(write(to / f"{grams}g.txt", lines, end="\r\n"))
    return Made(paths, Truth({".scale": 1.06, ".bias": -0.2}, {".scale": 0.01, ".bias": 0.1}))


def phidget_bridge(to: Path, rng: Rng) -> Made:
    """Phidget's control panel: ratios in mV/V of four channels, one of them loaded."""
    one, kg = Cell(58.0, -3.0, 2e-4), steps((0, 1, 2, 5, 10), 20)
    idle = rng.normal([[0.011], [-0.02], [0.3]], 2e-5, (3, kg.size))
    t = np.arange(kg.size) * 0.256
    head = "Time (s),VoltageRatio 0 (mV/V),VoltageRatio 1 (mV/V),VoltageRatio 2 (mV/V)"
    head += ",VoltageRatio 3 (mV/V),Known mass (kg)"
    body = rows(t, idle[0], one.read(kg * G, rng, whole=False), idle[1], idle[2], kg)
    return Made([write(to / "bridge.csv", [head, *body])], truth_of({"1": one}, 98))


def scale_and_counts(to: Path, rng: Rng) -> Made:
    """A kitchen scale with a serial line (A&D) beside the converter, in one capture."""
    one, kg = cell(rng), steps((0, 0.5, 1.0, 2.0, 3.0), 8)
    lines = []
    for i, (k, c) in enumerate(zip(kg, one.read(kg * G, rng), strict=True)):
        lines.append(f"2024-03-11 10:{i // 60:02d}:{i % 60:02d};ST,+{1000 * k:08.1f}  g;{c:.0f}")
    return Made([write(to / "capture.txt", lines)], truth_of(one))


def delsys_trigno(to: Path, rng: Rng) -> Made:
    """Delsys: each sensor with its own column of times, the load cell's rate lower; per weight."""
    one, paths = Cell(21.0, -4.0, 1e-3), []
    for kg in (0.0, 2.5, 5.0, 10.0):
        n, slow = 400, 100
        volts = one.read(np.full(slow, kg * G), rng, whole=False)
        head = "X [s],Trigno sensor 1: EMG 1 [Volts],X [s],Load Cell Adapter 2: Analog 2 [V]"
        lines = [f"Label: Trigno sensor 1: EMG 1 Sampling frequency: 2000.0 Number of points: {n}",
                 f"Label: Load Cell Adapter 2: Analog 2 Sampling frequency: 500.0 points: {slow}",
                 "", head]  # fmt: skip
        for i in range(n):
            own = f"{i / 500:.6f},{volts[i]:.6f}" if i < slow else ","
            lines.append(f"{i / 2000:.6f},{rng.normal(0, 1e-5):.9f},{own}")
        paths.append(write(to / f"trial_{kg}kg.csv", lines))
    return Made(paths, truth_of(one, 98))


def tdms_export(to: Path, rng: Rng) -> Made:
    """A TDMS file saved as text: properties above, group and channel with a slash, tabs."""
    cells = {f"ai{i}": Cell(20.0 + i, -2.0, 5e-4) for i in range(2)}
    newton = steps((0, 20, 50, 100, 50, 0), 12)
    head = ["Root Name\tTitle\tAuthor\tDate/Time", "loadcells\t\tlab\t03/11/2024 10:11:12", "",
            "Group\tChannels\tDescription", "Untitled\t4\t", "",
            "Untitled/Time*\tUntitled/cDAQ1Mod1/ai0 [V]\tUntitled/cDAQ1Mod1/ai1 [V]"
            "\tUntitled/Applied load [N]"]  # fmt: skip
    body = rows(np.arange(newton.size) / 10,
                *(c.read(newton, rng, whole=False) for c in cells.values()), newton,
                sep="\t", form="%.6f")  # fmt: skip
    # a name may keep the group and the module in front of the channel
    named = {f"_ai_{i}": one for i, one in enumerate(cells.values())}
    return Made([write(to / "weights_tdms.txt", [*head, *body])], truth_of(named, 100))


def swedish_excel(to: Path, rng: Rng) -> Made:
    """Excel in Sweden: `sep=;` first, a mark of the byte order, blanks between thousands."""
    one, kg = Cell(4.6e-4, -45.0, 12.0), steps((0, 0.25, 0.5, 1.0, 2.0), 6)
    lines = ["sep=;", "Tid;Vikt (kg);Avläsning"]
    for i, (k, c) in enumerate(zip(kg, one.read(kg * G, rng), strict=True)):
        count = f"{c:,.0f}".replace(",", "\u00a0")
        lines.append(f"00:01:{i:02d},345;{k:.2f};{count}".replace(".", ","))
    return Made([write(to / "vågen.csv", lines, encoding="utf-8-sig", end="\r\n")], truth_of(one))


def pandas_grouped(to: Path, rng: Rng) -> Made:
    """A table of pandas' groupby: two rows of names, the means beside the standard deviations."""
    one, kg = cell(rng), np.array([0.0, 0.5, 1.0, 2.0, 5.0])
    lines = [",raw,raw,raw", ",mean,std,count", "mass_kg,,,"]
    for k in kg:
        c = one.read(np.full(50, k * G), rng)
        lines.append(f"{k},{c.mean():.3f},{c.std():.3f},50")
    return Made([write(to / "summary.csv", lines)], truth_of(one))


def pandas_melted(to: Path, rng: Rng) -> Made:
    """`DataFrame.melt`: a column with the name of the cell and one with its value."""
    cells, kg = {f"cell_{x}": cell(rng) for x in "abc"}, steps((0, 1, 2, 4), 5)
    lines = ["Unnamed: 0,load_kg,variable,value"]
    for name, one in cells.items():
        for k, c in zip(kg, one.read(kg * G, rng), strict=True):
            lines.append(f"{len(lines) - 1},{k},{name},{c:.0f}")
    return Made([write(to / "melted.csv", lines)], truth_of(cells))


def influx_lines(to: Path, rng: Rng) -> Made:
    """InfluxDB's line protocol: tags and fields with equal signs, stamps in ns."""
    cells, grams, lines = {"fl": cell(rng), "fr": cell(rng)}, steps((0, 200, 500, 1000), 6), []
    for i, g in enumerate(grams):
        for name, one in cells.items():
            c = one.read(np.asarray(g * 1e-3 * G), rng)
            lines.append(f"loadcell,cell={name} raw={c:.0f}i,load_g={g:.0f} "
                         f"{1_710_151_872_000_000_000 + i * 100_000_000}")  # fmt: skip
    return Made([write(to / "influx.txt", lines)], truth_of(cells, 10))


def putty_log(to: Path, rng: Rng) -> Made:
    """PuTTY's log of a terminal: its banner, an echo of what was typed, the readings between."""
    one = cell(rng)
    lines = ["=~=~=~=~=~=~=~=~=~=~=~= PuTTY log 2024.03.11 10:11:12 =~=~=~=~=~=~=~=~=~=~=~=",
             "boot ok", "tare..."]  # fmt: skip
    for grams in (0, 100, 200, 500, 1000):
        lines.append(f"> w={grams}g")
        lines += [f"raw: {c:.0f}" for c in one.read(np.full(10, grams * 1e-3 * G), rng)]
    return Made([write(to / "putty.log", lines, end="\r\n")], truth_of(one, 10))


def markdown_table(to: Path, rng: Rng) -> Made:
    """A table in a README: bars between the cells, a row of dashes, grams."""
    cells, grams = {name: cell(rng, "adc12") for name in FOUR}, steps((0, 500, 1000, 2000), 2)
    reading = [one.read(grams * 1e-3 * G, rng) for one in cells.values()]
    lines = ["# Calibration of the left foot", "", "| load [g] | FL | FR | RL | RR |",
             "|---------:|---:|---:|---:|---:|"]  # fmt: skip
    lines += ["| " + " | ".join(f"{v:.0f}" for v in row) + " |"
              for row in zip(grams, *reading, strict=True)]  # fmt: skip
    return Made([write(to / "README.md", lines)], truth_of(cells))


def workbook(to: Path, rng: Rng) -> Made:
    """Excel's own file."""
    path = to / "weights.xlsx"
    sheet = ('<?xml version="1.0"?><worksheet xmlns="http://schemas.openxmlformats.org/'
             'spreadsheetml/2006/main"><sheetData><row r="1"><c r="A1"><v>1</v></c></row>'
             "</sheetData></worksheet>")  # fmt: skip
    with zipfile.ZipFile(path, "w") as packed:
        packed.writestr("xl/worksheets/sheet1.xml", sheet)
        packed.writestr("[Content_Types].xml", "<Types/>")
    return Made([path], says="CSV")


def tdms_itself(to: Path, rng: Rng) -> Made:
    """National Instruments' own binary file."""
    path = to / "log.tdms"
    path.write_bytes(b"TDSm\x0e\x00\x00\x00\x69\x12\x00\x00" + rng.bytes(400))
    return Made([path], says="CSV")


def numpy_archive(to: Path, rng: Rng) -> Made:
    """`numpy.savez` of loads and counts."""
    one, kg = cell(rng), steps((0, 1, 2, 4), 5)
    np.savez(to / "weights.npz", load_kg=kg, counts=one.read(kg * G, rng))
    return Made([to / "weights.npz"], truth_of(one))


def header_again(to: Path, rng: Rng) -> Made:
    """A logger that was restarted: appended to the same file, its header each time."""
    one, lines = cell(rng), []
    for kg in (0, 1, 2, 5):
        lines.append("millis,weight_kg,hx711")
        for i, c in enumerate(one.read(np.full(12, kg * G), rng)):
            lines.append(f"{1500 + 100 * i},{kg},{c:.0f}")
    return Made([write(to / "LOG0001.CSV", lines, end="\r\n")], truth_of(one))


def power_lost(to: Path, rng: Rng) -> Made:
    """An SD card pulled out: the last line breaks off, zero bytes behind it."""
    one, kg = cell(rng), steps((0, 1, 2, 5), 12)
    lines = ["ms,load_kg,adc", *rows(100.0 * np.arange(kg.size), kg, one.read(kg * G, rng))]
    path = write(to / "DATALOG.TXT", lines)
    path.write_bytes(path.read_bytes()[:-9] + b"\x00" * 64)
    return Made([path], truth_of(one))


def distracted(to: Path, rng: Rng) -> Made:
    """An ESP32 that logs all it has: battery, radio, temperature, free memory, and the cell."""
    one, grams = cell(rng), steps((0, 500, 1000, 2000, 3000), 10)
    n = grams.size
    head = "uptime_ms,vbat,rssi_dbm,heap_free,temp_c,raw,target_g,ok"
    body = rows(250.0 * np.arange(n), 4.1 - 2e-3 * np.arange(n), np.round(rng.normal(-60, 3, n)),
                np.round(rng.normal(2e5, 500, n)), 24 + 0.02 * np.arange(n),
                one.read(grams * 1e-3 * G, rng), grams, np.ones(n))  # fmt: skip
    return Made([write(to / "esp32.csv", [head, *body])], truth_of(one))


def labelled_plotter(to: Path, rng: Rng) -> Made:
    """Lines for Arduino's serial plotter: `name:value`, tabs between."""
    cells, newton = {"A": cell(rng, "adc10"), "B": cell(rng, "adc10")}, steps((0, 10, 20, 50), 8)
    reading = [one.read(newton, rng) for one in cells.values()]
    lines = [f"load_N:{n:.1f}\tA:{a:.0f}\tB:{b:.0f}"
             for n, a, b in zip(newton, *reading, strict=True)]  # fmt: skip
    named = {name.lower(): one for name, one in cells.items()}  # as groups of a pattern are called
    return Made([write(to / "plotter.txt", lines)], truth_of(named, 50))


def board_of_four(to: Path, rng: Rng) -> Made:
    """A balance board: four corners in kg that share a weight laid on its middle."""
    kg = steps((0, 5, 10, 20, 40), 10)
    share = np.array([0.26, 0.25, 0.24, 0.25])
    corner = kg[:, None] * share + rng.normal(0, 0.01, (kg.size, 4))
    lines = ["time_s,weight_kg,TopLeft_kg,TopRight_kg,BottomLeft_kg,BottomRight_kg",
             *rows(np.arange(kg.size) / 10, kg, *corner.T, form="%.3f")]  # fmt: skip
    return Made([write(to / "board.csv", lines)], says="share")


def foot_on_a_grid(to: Path, rng: Rng) -> Made:
    """A foot of four cells, a mass on marked points of it, in Spanish."""
    at = np.array([[70, 40], [70, -40], [-50, 40], [-50, -40]]) * 1e-3
    cells: Mapping[str, Cell] = {f"celda{i + 1}": cell(rng, "adc12") for i in range(4)}
    lines = ["posicion,x_mm,y_mm,peso_kg," + ",".join(cells)]
    point = 0
    for x in (-40, 0, 40, 60):
        for y in (-30, 0, 30):
            point += 1
            for kg in (2.0, 5.0):
                # two lines of cells: shares along x times shares along y
                u = (x * 1e-3 - at[2, 0]) / (at[0, 0] - at[2, 0])
                v = (y * 1e-3 - at[1, 1]) / (at[0, 1] - at[1, 1])
                share = np.array([u * v, u * (1 - v), (1 - u) * v, (1 - u) * (1 - v)])
                read = [one.read(np.asarray(kg * G * s), rng)
                        for one, s in zip(cells.values(), share, strict=True)]  # fmt: skip
                lines.append(f"P{point},{x},{y},{kg}," + ",".join(f"{r:.0f}" for r in read))
    return Made([write(to / "pie_izquierdo.csv", lines)], says="where the cells sit")


def json_with_meta(to: Path, rng: Rng) -> Made:
    """One JSON document: a head that says what it is, the samples in a list below it."""
    import json

    one, kg = cell(rng), steps((0, 1, 2, 5), 6)
    samples = [{"t": 0.1 * i, "load": {"value": float(k), "unit": "kg"}, "adc": int(c)}
               for i, (k, c) in enumerate(zip(kg, one.read(kg * G, rng), strict=True))]  # fmt: skip
    text = json.dumps({"meta": {"sensor": "TAL220", "rate_hz": 10}, "samples": samples})
    return Made([write(to / "session.json", [text])], truth_of(one))


def matlab_struct_array(to: Path, rng: Rng) -> Made:
    """A struct array, an element per weight: the mass as a number, the counts as a vector."""
    from scipy.io import savemat

    one, kgs = cell(rng), (0.0, 1.0, 2.0, 5.0)
    cal = np.zeros(len(kgs), dtype=[("mass_kg", object), ("raw", object)])
    for i, kg in enumerate(kgs):
        cal[i] = (kg, one.read(np.full(40, kg * G), rng))
    savemat(to / "cal.mat", {"cal": cal})
    return Made([to / "cal.mat"], truth_of(one))


def falling_loads_in_newton(to: Path, rng: Rng) -> Made:
    """A testing machine that stops at set forces, pulling: the reference is negative."""
    one = Cell(21.0, -0.5, 1e-3)
    newton = -settling([0, 20, 50, 100, 50, 0], 4, 20)
    lines = ["Time;Kraft;Spannung", "s;N;V",
             *rows(np.arange(newton.size) / 20, newton + rng.normal(0, 0.02, newton.size),
                   one.read(newton, rng, whole=False), sep=";", form="%.4f")]  # fmt: skip
    return Made([write(to / "zug.csv", [x.replace(".", ",") for x in lines])], truth_of(one, 100))


SIXTH_BENCH = (
    bogde_example, phidget_bridge, scale_and_counts, delsys_trigno, tdms_export, swedish_excel,
    pandas_grouped, pandas_melted, influx_lines, putty_log, markdown_table, workbook, tdms_itself,
    numpy_archive, header_again, power_lost, distracted, labelled_plotter, board_of_four,
    foot_on_a_grid, json_with_meta, matlab_struct_array, falling_loads_in_newton,
)  # fmt: skip
