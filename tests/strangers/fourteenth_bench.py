"""Logs as laboratories keep them, X: notebooks, wikis, syslogs, certificates, other quantities.

Written before it was run; `docs/bring_your_log.md` has its first count.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tests.strangers.rigs import Cell, G, Made, Rng, cell, rows, settling, steps, truth_of, write

LB = 4.4482216152605


def confluence_wiki(to: Path, rng: Rng) -> Made:
    """A table of a wiki in its own markup: `||` around titles, `|` around cells."""
    one, grams = cell(rng), steps((0, 500, 1000, 2000, 500, 0), 2)
    lines = ["||mass [g]||display||"]
    for g, c in zip(grams, one.read(grams * 1e-3 * G, rng), strict=True):
        lines.append(f"|{g:.0f}|{c:.0f}|")
    return Made([write(to / "wiki.txt", lines)], truth_of(one))


def mediawiki(to: Path, rng: Rng) -> Made:
    """MediaWiki: `{|`, `|-` between rows, `!` before titles, `||` between cells."""
    one, kg = cell(rng), steps((0, 1, 2, 5), 3)
    lines = ['{| class="wikitable"', "! Mass (kg) !! Raw counts"]
    for k, c in zip(kg, one.read(kg * G, rng), strict=True):
        lines += ["|-", f"| {k:g} || {c:.0f}"]
    return Made([write(to / "calibration.wiki", [*lines, "|}"])], truth_of(one, 50))


def org_mode(to: Path, rng: Rng) -> Made:
    """A table of Emacs: bars, a rule of `|---+---|`."""
    one, kg = cell(rng), steps((0, 0.5, 1, 2), 3)
    lines = ["#+TITLE: load cell", "", "| kg  | counts  |", "|-----+---------|"]
    for k, c in zip(kg, one.read(kg * G, rng), strict=True):
        lines.append(f"| {k:g} | {c:.0f} |")
    return Made([write(to / "notes.org", lines)], truth_of(one))


def grid_table(to: Path, rng: Rng) -> Made:
    """reStructuredText: a grid of `+---+`, titles over `+===+`."""
    one, kg = cell(rng), steps((0, 0.5, 1, 2), 2)
    rule = "+-----------+------------+"
    lines = [rule, "| load (kg) | counts     |", rule.replace("-", "=")]
    for k, c in zip(kg, one.read(kg * G, rng), strict=True):
        lines += [f"| {k:<9g} | {c:<10.0f} |", rule]
    return Made([write(to / "table.rst", lines)], truth_of(one))


def pandas_printed(to: Path, rng: Rng) -> Made:
    """What pandas prints: an index without a name before each row."""
    one, kg = cell(rng), steps((0, 1, 2, 5, 2, 1, 0), 2)
    lines = ["    mass_kg     counts"]
    for i, (k, c) in enumerate(zip(kg, one.read(kg * G, rng), strict=True)):
        lines.append(f"{i:<4d}{k:>7.1f}{c:>11.0f}")
    return Made([write(to / "printed.txt", lines)], truth_of(one, 50))


def r_write_table(to: Path, rng: Rng) -> Made:
    """R's `write.table`: row names in quotes, so that the header has one name less."""
    one, kg = cell(rng), steps((0, 1, 2, 5), 3)
    lines = ['"mass_kg" "adc"']
    for i, (k, c) in enumerate(zip(kg, one.read(kg * G, rng), strict=True)):
        lines.append(f'"{i + 1}" {k:g} {c:.0f}')
    return Made([write(to / "cal.txt", lines)], truth_of(one, 50))


def gnuplot_blocks(to: Path, rng: Rng) -> Made:
    """Data sets of gnuplot: two empty lines between them, the load above each."""
    one, lines = cell(rng), ["# t[s] raw"]
    for kg in (0, 1, 2, 5):
        lines += ["", "", f"# {kg} kg"]
        lines += rows(np.arange(12) / 10, one.read(np.full(12, kg * G), rng), sep=" ")
    return Made([write(to / "steps.dat", lines)], truth_of(one, 50))


def keysight_daq970(to: Path, rng: Rng) -> Made:
    """A data logger: scans, channels 101 and 102 with their unit, one of them the reference."""
    one, load = Cell(2.2e3, -4.0, 4e-5), settling([0, 10, 20, 40, 20, 0], 4, 5)
    force = load / 100.0 + rng.normal(0, 2e-4, load.size)
    lines = ["Scan,Time,101 <Ref 100 N/V> (VDC),102 <Bridge> (VDC)"]
    for i, (f, v) in enumerate(zip(force, one.read(load, rng, whole=False), strict=True)):
        lines.append(f"{i + 1},03/12/2024 10:00:{i / 5 % 60:06.3f},{f:+.8E},{v:+.8E}")
    return Made([write(to / "dmm.csv", lines)], says="load")


def tracer_daq(to: Path, rng: Rng) -> Made:
    """TracerDAQ: lines about the device, sample, date, time, events, a weight typed as event."""
    one, lines = cell(rng, "volt"), [
        "File Type,TracerDAQ", "Version,1.1.0", "Sample Rate,10",
        "Number of channels,1", "", "Sample,Date/Time,CHANNEL0 (V),Events",
    ]  # fmt: skip
    at = 0
    for kg in (0, 1, 2, 4):
        for j, v in enumerate(one.read(np.full(15, kg * G), rng, whole=False)):
            event = f"{kg} kg" if j == 0 else ""
            lines.append(f"{at},3/12/2024 10:00:{at / 10:.2f} AM,{v:.6f},{event}")
            at += 1
    return Made([write(to / "strip.csv", lines)], truth_of(one, 40))


def esp_idf_logs(to: Path, rng: Rng) -> Made:
    """An ESP32's log: level, milliseconds, tag, one file for each weight."""
    one, paths = cell(rng), []
    for grams in (0, 250, 500, 1000):
        lines = [
            f"I ({1200 + 100 * i}) HX711: raw={c:.0f}"
            for i, c in enumerate(one.read(np.full(20, grams * 1e-3 * G), rng))
        ]
        paths.append(write(to / f"monitor_{grams}g.log", lines))
    return Made(paths, truth_of(one, 10))


def journalctl(to: Path, rng: Rng) -> Made:
    """A service's journal on a Raspberry Pi: month, day, time, host, process before the number."""
    one, lines = cell(rng), []
    for j, kg in enumerate((0, 1, 2, 5)):
        for i, c in enumerate(one.read(np.full(10, kg * G), rng)):
            lines.append(f"Mar 12 10:{j:02d}:{i:02d} raspberrypi scale[512]: load={kg} raw={c:.0f}")
    return Made([write(to / "journal.txt", lines)], truth_of(one, 50), says="unit",
                fill=lambda text: text.replace('unit = "?"', 'unit = "kg"'))  # fmt: skip


def units_in_every_cell(to: Path, rng: Rng) -> Made:
    """A spreadsheet typed by hand: `500 g`, `8,388,123 cts`."""
    one, grams = cell(rng), steps((0, 500, 1000, 2000), 3)
    lines = ["weight put on,reading"]
    for g, c in zip(grams, one.read(grams * 1e-3 * G, rng), strict=True):
        lines.append(f'{g:.0f} g,"{c:,.0f} cts"')
    return Made([write(to / "typed.csv", lines)], truth_of(one))


def google_form(to: Path, rng: Rng) -> Made:
    """Answers to a form: questions as titles, a stamp, units in the questions."""
    one, grams = cell(rng), steps((0, 200, 500, 1000), 4)
    lines = ["Timestamp,Which weight is on the cell (grams)?,What does the display show?"]
    for i, (g, c) in enumerate(zip(grams, one.read(grams * 1e-3 * G, rng), strict=True)):
        lines.append(f"3/12/2024 10:{i:02d}:11,{g:.0f},{c:.0f}")
    return Made([write(to / "responses.csv", lines)], truth_of(one, 10))


def log4j_commas(to: Path, rng: Rng) -> Made:
    """Stamps with a decimal comma, fields apart by ` - `."""
    one, grams = cell(rng), steps((0, 500, 1000, 2000), 5)
    lines = []
    for i, (g, c) in enumerate(zip(grams, one.read(grams * 1e-3 * G, rng), strict=True)):
        lines.append(
            f"2024-03-12 10:00:{i:02d},{i * 37 % 1000:03d} - INFO - raw: {c:.0f} - load: {g:.0f} g"
        )
    return Made([write(to / "app.log", lines)], truth_of(one))


def microstrain(to: Path, rng: Rng) -> Made:
    """Gauges whose amplifier shows strain: µε against kilograms."""
    one, kg = Cell(0.021, -3.0, 0.2), steps((0, 1, 2, 5, 2, 0), 4)
    lines = ["Mass [kg];Strain [µm/m]"]
    lines += rows(kg, one.read(kg * G, rng, whole=False), sep=";", form="%.3f")
    return Made([write(to / "quantumx.csv", [x.replace(".", ",") for x in lines])],
                truth_of(one, 50))  # fmt: skip


def current_loop(to: Path, rng: Rng) -> Made:
    """A transmitter of 4 to 20 mA against newtons."""
    one, newton = Cell(31.25, -125.0, 2e-3), steps((0, 100, 200, 300, 400, 500), 3)
    lines = ["F_ref_N,I_mA", *rows(newton, one.read(newton, rng, whole=False), form="%.4f")]
    return Made([write(to / "transmitter.csv", lines)], truth_of(one, 500))


def vibrating_wire(to: Path, rng: Rng) -> Made:
    """A cell that answers with a frequency."""
    one, kilonewton = Cell(12.5, -9000.0, 0.02), steps((0, 1, 2, 5, 2, 0), 3)
    lines = ["Load (kN),Frequency (Hz)"]
    lines += rows(kilonewton, one.read(1e3 * kilonewton, rng, whole=False), form="%.3f")
    return Made([write(to / "anchor.csv", lines)], truth_of(one, 5000))


def percent_of_range(to: Path, rng: Rng) -> Made:
    """A PLC's analogue input in percent of its range."""
    one, kg = Cell(4.9, -20.0, 5e-3), steps((0, 2, 5, 10, 20), 3)
    lines = ["Gewicht kg\tAI0 %", *rows(kg, one.read(kg * G, rng, whole=False), sep="\t",
                                       form="%.3f")]  # fmt: skip
    return Made([write(to / "sps.txt", lines)], truth_of(one, 200))


def micro_volts_per_volt(to: Path, rng: Rng) -> Made:
    """A bridge in µV/V."""
    one, newton = Cell(0.05, -1.2, 0.3), steps((0, 20, 50, 100), 4)
    lines = ["Force applied (N),Output (µV/V)"]
    lines += rows(newton, one.read(newton, rng, whole=False), form="%.2f")
    return Made([write(to / "bridge.csv", lines)], truth_of(one, 100))


def letters_for_weights(to: Path, rng: Rng) -> Made:
    """Weights by letters, and a legend above that says what each is."""
    one, lines = cell(rng), ["# A = 0 g, B = 500 g, C = 1000 g, D = 2000 g", "weight,counts"]
    for letter, grams in zip("ABCD", (0, 500, 1000, 2000), strict=True):
        for c in one.read(np.full(4, grams * 1e-3 * G), rng):
            lines.append(f"{letter},{c:.0f}")
    return Made([write(to / "letters.csv", lines)], says="load")


def certificate_kilonewtons(to: Path, rng: Rng) -> Made:
    """A certificate: steps of force in kN, three series of outputs and their mean."""
    one = Cell(5e3, 0.0, 2e-5)
    kilonewton = np.array([0.0, 1, 2, 3, 4, 5])
    series = [one.read(1e3 * kilonewton, rng, whole=False) for _ in range(3)]
    lines = ["Calibration certificate 2024-0312", "Object: load cell C9C;;;;", "",
             "Force in kN;Series 1 in mV/V;Series 2 in mV/V;Series 3 in mV/V;Mean in mV/V",
             *rows(kilonewton, *series, np.mean(series, axis=0), sep=";", form="%.5f")]  # fmt: skip
    return Made([write(to / "certificate.csv", lines)], truth_of(one, 5000))


def openscale(to: Path, rng: Rng) -> Made:
    """OpenScale: ms, its own weight, its unit, a temperature, the raw reading, without names."""
    one, paths = cell(rng), []
    for pounds in (0, 1, 2, 5):
        lines = []
        for i, c in enumerate(one.read(np.full(20, pounds * LB), rng)):
            shown = pounds + rng.normal(0, 0.01)
            lines.append(f"{11370 + 100 * i},{shown:.2f},lbs,{22.5 + 0.01 * i:.2f},{c:.0f},")
        paths.append(write(to / f"openscale_{pounds}lb.txt", lines))
    return Made(paths, truth_of(one, 20))


def readings_as_fractions(to: Path, rng: Rng) -> Made:
    """Twelve bits as `2048/4095`, the load in newtons before it."""
    one, newton = cell(rng, "adc12"), steps((0, 10, 20, 40, 60), 3)
    lines = ["N,ADC"]
    for f, c in zip(newton, one.read(newton, rng), strict=True):
        lines.append(f"{f:g},{c:.0f}/4095")
    return Made([write(to / "fractions.csv", lines)], truth_of(one, 60))


FOURTEENTH_BENCH = (
    confluence_wiki, mediawiki, org_mode, grid_table, pandas_printed, r_write_table,
    gnuplot_blocks, keysight_daq970, tracer_daq, esp_idf_logs, journalctl, units_in_every_cell,
    google_form, log4j_commas, microstrain, current_loop, vibrating_wire, percent_of_range,
    micro_volts_per_volt, letters_for_weights, certificate_kilonewtons, openscale,
    readings_as_fractions,
)  # fmt: skip
