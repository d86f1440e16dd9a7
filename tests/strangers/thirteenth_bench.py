"""Logs as laboratories keep them, IX: schools, homes, web tools, printed tables.

Written before it was run; `docs/bring_your_log.md` has its first count.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tests.strangers.rigs import Cell, G, Made, Rng, cell, rows, settling, steps, truth_of, write

LB, OZ = 4.4482216152605, 0.27801385095378


def campbell_toa5(to: Path, rng: Rng) -> Made:
    """A Campbell logger: station, names, units and kinds of statistics above, quoted stamps."""
    one, newton = Cell(2.1e3, -35.0, 2e-5), steps((0, 500, 1000, 2000), 6)
    lines = ['"TOA5","CR1000_Bench","CR1000","12345","CR1000.Std.32","CPU:cal.CR1","4412","Cal"',
             '"TIMESTAMP","RECORD","Ref_Load","Cell_mVperV"', '"TS","RN","N","mV/V"',
             '"","","Smp","Avg"']  # fmt: skip
    for i, (f, v) in enumerate(zip(newton, one.read(newton, rng, whole=False), strict=True)):
        lines.append(f'"2024-03-12 10:{i:02d}:00",{i},{f:g},{v:.6f}')
    return Made([write(to / "CR1000_Cal.dat", lines, end="\r\n")], truth_of(one, 2000))


def thingspeak_feeds(to: Path, rng: Rng) -> Made:
    """ThingSpeak: `created_at, entry_id, field1`, a download for each weight."""
    one, paths = cell(rng), []
    for grams in (0, 500, 1000, 2000):
        lines = ["created_at,entry_id,field1"]
        for i, c in enumerate(one.read(np.full(20, grams * 1e-3 * G), rng)):
            lines.append(f"2024-03-12 10:{grams // 50:02d}:{i:02d} UTC,{100 + i},{c:.0f}")
        paths.append(write(to / f"feeds_{grams}g.csv", lines))
    return Made(paths, truth_of(one))


def home_assistant(to: Path, rng: Rng) -> Made:
    """Home Assistant's history: an entity, its state as a text, some of them `unavailable`."""
    one, paths = cell(rng), []
    for kg in (0, 1, 2, 5):
        lines = ["entity_id,state,last_changed"]
        for i, c in enumerate(one.read(np.full(20, kg * G), rng)):
            state = "unavailable" if i == 7 else f"{c:.0f}"
            lines.append(f"sensor.hx711_raw,{state},2024-03-12T1{kg}:00:{i:02d}.123Z")
        paths.append(write(to / f"history_{kg}kg.csv", lines))
    return Made(paths, truth_of(one, 50))


def grafana_panel(to: Path, rng: Rng) -> Made:
    """A panel of Grafana: quoted names of series, stamps in ms, the weight as a second series."""
    one, kg = cell(rng), steps((0, 1, 2, 3), 8)
    lines = ['"Time","hx711.raw","Weight on the scale (kg)"']
    for i, (k, c) in enumerate(zip(kg, one.read(kg * G, rng), strict=True)):
        lines.append(f'"2024-03-12 10:00:{i:02d}.{i * 37 % 1000:03d}",{c:.0f},{k:g}')
    return Made([write(to / "panel.csv", lines)], truth_of(one, 30))


def vernier_logger_pro(to: Path, rng: Rng) -> Made:
    """Logger Pro: columns after their run (`Latest: Force (N)`), a balance pulled by hand."""
    one, load = Cell(21.0, -6.0, 5e-4), settling([0, 5, 10, 15, 5, 0], 3, 20)
    t = np.arange(load.size) / 20
    lines = ["Latest: Time (s),Latest: Force (N),Latest: Potential (V)",
             *rows(t, load + rng.normal(0, 0.01, load.size), one.read(load, rng, whole=False),
                   form="%.5g")]  # fmt: skip
    return Made([write(to / "balance.csv", lines)], truth_of(one, 30))


def pasco_capstone(to: Path, rng: Rng) -> Made:
    """PASCO Capstone: names with their unit and run, semicolons."""
    one, load = Cell(-21.0, 6.0, 5e-4), settling([0, 5, 10, 15, 5, 0], 3, 20)
    lines = ["Time (s) Run #2;Force (N) Run #2;Voltage (V) Run #2",
             *rows(np.arange(load.size) / 20, load + rng.normal(0, 0.01, load.size),
                   one.read(load, rng, whole=False), sep=";", form="%.5g")]  # fmt: skip
    return Made([write(to / "capstone.csv", [x.replace(".", ",") for x in lines[:1]] + [
        x.replace(".", ",") for x in lines[1:]])], truth_of(one, 30))  # fmt: skip


def picoscope_text(to: Path, rng: Rng) -> Made:
    """PicoScope: units in brackets below the names, an empty line, a file for each weight."""
    one, paths = Cell(0.41, -6.0, 1e-2), []
    for kg in (0, 1, 2, 5):
        v = one.read(np.full(40, kg * G), rng, whole=False)
        lines = ["Time,Channel A", "(ms),(mV)", "", *rows(np.arange(40) * 0.5 - 10, v, form="%.8f")]
        paths.append(write(to / f"bridge-{kg}kg.csv", lines))
    return Made(paths, truth_of(one, 50))


def saleae_folders(to: Path, rng: Rng) -> Made:
    """Logic 2: `Time [s],Channel 0`, always `analog.csv`, in a folder for each weight."""
    one, paths = Cell(18.0, -9.0, 1e-3), []
    for kg in (0, 1, 2, 4):
        folder = to / f"export {kg} kg"
        folder.mkdir()
        v = one.read(np.full(30, kg * G), rng, whole=False)
        lines = ["Time [s],Channel 0", *rows(np.arange(30) / 1000, v, form="%.9f")]
        paths.append(write(folder / "analog.csv", lines))
    return Made(paths, truth_of(one, 40))


def twincat_scope(to: Path, rng: Rng) -> Made:
    """TwinCAT Scope: a time before each signal, names and symbols in rows above."""
    one, load = cell(rng, "adc12"), settling([0, 5, 10, 20, 10, 0], 3, 20)
    t = 50.0 * np.arange(load.size)
    head = ["Name\tnReading\tName\tfLoadN", "SymbolName\tMAIN.nReading\tSymbolName\tMAIN.fLoadN",
            "Unit\t\tUnit\tN", "SampleTime[ms]\t50\tSampleTime[ms]\t50", ""]  # fmt: skip
    body = rows(t, one.read(load, rng), t, load + rng.normal(0, 0.02, load.size), sep="\t",
                form="%.6g")  # fmt: skip
    return Made([write(to / "scope.txt", [*head, *body])], truth_of(one, 40))


def tindeq_progressor(to: Path, rng: Rng) -> Made:
    """A climber's scale: `time,weight` in seconds and kilograms, a file for each plate hung on."""
    one, paths = Cell(1.05 * G, -3.0, 0.005), []  # newtons for each kilogram that it shows
    for kg in (0, 10, 20, 40):
        read = one.read(np.full(40, kg * G), rng, whole=False)
        lines = ["time,weight", *rows(np.arange(40) / 80, read, form="%.4f")]
        paths.append(write(to / f"plate_{kg}kg.csv", lines))
    return Made(paths, truth_of(one, 400))


def numpy_printed(to: Path, rng: Rng) -> Made:
    """An array as numpy prints it: brackets at both ends, exponents."""
    one, newton = cell(rng, "adc12"), steps((0, 5, 10, 20), 5)
    body = [f" [{f:.4e} {c:.4e}]" for f, c in zip(newton, one.read(newton, rng), strict=True)]
    body[0], body[-1] = "[" + body[0].strip(), body[-1] + "]"
    return Made([write(to / "load_n_vs_adc.txt", ["# load [N], adc", *body])], truth_of(one))


def matlab_with_a_factor(to: Path, rng: Rng) -> Made:
    """A matrix as MATLAB shows it: `1.0e+03 *` above, that all numbers are to be multiplied by."""
    one, newton = Cell(0.02, -6.0, 0.5), steps((0, 500, 1000, 2000), 4)
    newton = newton / 50
    table = zip(newton / 1e3, one.read(newton, rng) / 1e3, strict=True)
    lines = ["cal =", "", "   1.0e+03 *", "", *(f"{f:10.4f}{c:10.4f}" for f, c in table), ""]
    return Made([write(to / "load_n_counts.txt", lines)], says="1.0e+03")


def r_printed(to: Path, rng: Rng) -> Made:
    """A data frame as R prints it: numbered rows under no name."""
    one, kg = cell(rng), steps((0, 0.5, 1, 2), 4)
    lines = ["> cal", "   mass_kg     raw"]
    lines += [
        f"{i:<3d}{k:8.1f} {c:7.0f}"
        for i, (k, c) in enumerate(zip(kg, one.read(kg * G, rng), strict=True), 1)
    ]
    return Made([write(to / "console.txt", lines)], truth_of(one))


def sqlite_columns(to: Path, rng: Rng) -> Made:
    """`sqlite3 -column -header`: dashes below the names."""
    one, kg = cell(rng), steps((0, 0.5, 1, 2), 4)
    lines = ["load_kg     raw       ", "----------  ----------"]
    lines += [f"{k:<10g}  {c:<10.0f}" for k, c in zip(kg, one.read(kg * G, rng), strict=True)]
    return Made([write(to / "query.txt", lines)], truth_of(one))


def mysql_box(to: Path, rng: Rng) -> Made:
    """MySQL's client: a box of plus signs and bars, the count of rows below."""
    one, grams = cell(rng), steps((0, 200, 500, 1000), 4)
    rule = "+---------------------+--------+---------+"
    lines = ["mysql> SELECT * FROM cal;", rule, "| at                  | load_g | raw     |", rule]
    for i, (g, c) in enumerate(zip(grams, one.read(grams * 1e-3 * G, rng), strict=True)):
        lines.append(f"| 2024-03-12 10:00:{i:02d} | {g:6.0f} | {c:7.0f} |")
    return Made([write(to / "mysql.txt", [*lines, rule, "16 rows in set (0.00 sec)"])],
                truth_of(one))  # fmt: skip


def rst_simple(to: Path, rng: Rng) -> Made:
    """A table of a documentation: rules of equal signs."""
    one, newton = cell(rng, "adc12"), steps((0, 5, 10, 20), 4)
    rule = "=========  ======="
    lines = ["Calibration", "-----------", "", rule, "Load [N]   Counts", rule]
    lines += [f"{f:<9.1f}  {c:.0f}" for f, c in zip(newton, one.read(newton, rng), strict=True)]
    return Made([write(to / "calibration.rst", [*lines, rule])], truth_of(one))


def org_mode(to: Path, rng: Rng) -> Made:
    """Emacs' org: bars at both ends, `|---+---|` between names and rows."""
    cells, kg = {"front": cell(rng), "back": cell(rng)}, steps((0, 0.5, 1, 2), 4)
    read = [one.read(kg * G, rng) for one in cells.values()]
    lines = ["* Bench of Tuesday", "| kg | front | back |", "|----+-------+------|"]
    lines += [f"| {k:g} | {a:.0f} | {b:.0f} |" for k, a, b in zip(kg, *read, strict=True)]
    return Made([write(to / "notes.org", lines)], truth_of(cells))


def html_of_a_scale(to: Path, rng: Rng) -> Made:
    """A web page with a table, saved as it is."""
    one, kg = cell(rng), steps((0, 1, 2, 5), 4)
    lines = ["<html><body><h1>Calibration</h1>", '<table border="1">',
             "<tr><th>Load (kg)</th><th>Raw</th></tr>"]  # fmt: skip
    lines += [f"<tr><td>{k:g}</td><td>{c:.0f}</td></tr>"
              for k, c in zip(kg, one.read(kg * G, rng), strict=True)]  # fmt: skip
    return Made([write(to / "scale.html", [*lines, "</table></body></html>"])], truth_of(one, 50))


def ini_sections(to: Path, rng: Rng) -> Made:
    """A section for each sample, as Delphi and LabVIEW write settings."""
    one, kg, lines = cell(rng), steps((0, 1, 2, 5), 4), ["[Instrument]", "Model=DAD141"]
    for i, (k, c) in enumerate(zip(kg, one.read(kg * G, rng), strict=True), 1):
        lines += ["", f"[Sample{i}]", f"Load_kg={k:g}", f"Raw={c:.0f}"]
    return Made([write(to / "cal.ini", lines, end="\r\n")], truth_of(one, 50))


def forum_commas(to: Path, rng: Rng) -> Made:
    """A sketch that prints words and numbers between commas: `reading,8223570,weight,500g`."""
    one, grams = cell(rng), steps((0, 100, 200, 500, 1000), 4)
    lines = ["HX711 calibration sketch", "remove all weight from scale"]
    lines += [
        f"reading,{c:.0f},weight,{g:.0f}g"
        for g, c in zip(grams, one.read(grams * 1e-3 * G, rng), strict=True)
    ]
    return Made([write(to / "monitor.txt", lines)], truth_of(one, 10))


def pounds_and_ounces(to: Path, rng: Rng) -> Made:
    """Loads as a kitchen scale shows them: `2 lb 4 oz`."""
    one, put = cell(rng), [(0, 0), (0, 8), (1, 0), (2, 4), (4, 12)]
    lines = ["load,raw"]
    for lb, oz in put:
        read = one.read(np.full(4, lb * LB + oz * OZ), rng)
        lines += [f"{lb} lb {oz} oz,{c:.0f}" for c in read]
    return Made([write(to / "kitchen.csv", lines)], truth_of(one, 20),
                says="one number in one unit")  # fmt: skip


def percent_of_full_scale(to: Path, rng: Rng) -> Made:
    """Loads in percent of the capacity, which stands above; nobody wrote newtons."""
    one, percent = Cell(980.0, -5.0, 2e-5), steps((0, 20, 40, 60, 80, 100), 3)
    read = one.read(percent / 100 * 200 * G, rng, whole=False)
    lines = ["Capacity: 200 kg", "Load (%),Output (mV/V)", *rows(percent, read, form="%.6g")]
    return Made([write(to / "certificate.csv", lines)], says="unit")


def tonnes(to: Path, rng: Rng) -> Made:
    """A truck scale: tonnes against mV/V."""
    one, t = Cell(1.2e5, -900.0, 2e-5), steps((0, 2, 5, 10), 4)
    read = one.read(t * 1e3 * G, rng, whole=False)
    lines = ["Load (t);Output (mV/V)", *rows(t, read, sep=";", form="%.6g")]
    return Made([write(to / "truck.csv", lines)], truth_of(one, 1e5))


def microstrain(to: Path, rng: Rng) -> Made:
    """A strain gauge on a shank: µm/m against kilonewtons."""
    one, kn = Cell(9.5, -120.0, 0.3), steps((0, 1, 2, 4, 6), 4)
    read = one.read(kn * 1e3, rng, whole=False)
    lines = ["Force [kN],Strain [µm/m]", *rows(kn, read, form="%.6g")]
    return Made([write(to / "shank.csv", lines, "latin-1")], truth_of(one, 6e3))


def unsigned_24_bits(to: Path, rng: Rng) -> Made:
    """A converter's two's complement read as if it had no sign: below zero comes 16,7 million."""
    one, kg = Cell(-3.4e-5, 0.15, 30.0), steps((0, 0.5, 1, 2), 6)
    read = np.mod(one.read(kg * G, rng), 2**24)
    assert np.ptp(read) > 2**23
    return Made([write(to / "raw.csv", ["mass_kg,raw24", *rows(kg, read)])], truth_of(one))


def glitches_of_a_wire(to: Path, rng: Rng) -> Made:
    """A loose wire: single readings of zero or of all ones among good ones."""
    one, kg = cell(rng), steps((0, 0.5, 1, 2), 30)
    read = one.read(kg * G, rng)
    bad = rng.permutation(read.size)[:5]
    read[bad] = [0, 0, 16777215, 0, 16777215]
    return Made([write(to / "loose.csv", ["mass_kg,raw", *rows(kg, read)])], truth_of(one, 20))


THIRTEENTH_BENCH = (
    campbell_toa5, thingspeak_feeds, home_assistant, grafana_panel, vernier_logger_pro,
    pasco_capstone, picoscope_text, saleae_folders, twincat_scope, tindeq_progressor,
    numpy_printed, matlab_with_a_factor, r_printed, sqlite_columns, mysql_box, rst_simple,
    org_mode, html_of_a_scale, ini_sections, forum_commas, pounds_and_ounces,
    percent_of_full_scale, tonnes, microstrain, unsigned_24_bits, glitches_of_a_wire,
)  # fmt: skip
