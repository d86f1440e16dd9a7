"""Logs as people keep them, XII, of cells: firmwares, notebooks, plants, schools, more languages.

Written before it was run; `docs/bring_your_log.md` has its first count.
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
    cell,
    rows,
    settling,
    sheet_under,
    steps,
    truth_of,
    write,
)

LB = 4.4482216152605


def wincc_archive(to: Path, rng: Rng) -> Made:
    """A plant's archive: one line per variable and second, quality, days of Excel in the end."""
    one, kg = cell(rng), steps((0, 5, 10, 20), 8)
    lines = ['"VarName";"TimeString";"VarValue";"Validity";"Time_ms"']
    for i, (k, c) in enumerate(zip(kg, one.read(kg * G, rng), strict=True)):
        stamp = f'"12.03.2024 10:{22 + i // 60}:{i % 60:02d}"'
        ms = f"{45363432303.125 + i * 11.574:.3f}".replace(".", ",")
        lines.append(f'"Pruefgewicht_kg";{stamp};{k:.1f};1;{ms}'.replace(".0;1", ",0;1"))
        lines.append(f'"Waage_Rohwert";{stamp};{c:.0f};1;{ms}')
    lines.append('"$RT_OFF$";"12.03.2024 10:40:00";0;2;45363444300,000')
    return Made([write(to / "Archiv0.csv", lines, "latin-1")], truth_of(one, 200))


def windaq(to: Path, rng: Rng) -> Made:
    """A recorder's export: names and units in two rows, a press that never rests."""
    t = np.arange(0, 60, 0.02)
    lbf = 12 + 8 * np.sin(2 * np.pi * 0.07 * t) + 2 * np.sin(2 * np.pi * 0.031 * t + 1)
    one = Cell(14.2, 3.1, 2e-3)
    body = rows(t, lbf + rng.normal(0, 0.01, t.size), one.read(lbf * LB, rng, whole=False),
                form="%.6f")  # fmt: skip
    head = ["Relative Time,Reference,Bridge", "sec,lbf,mV"]
    return Made([write(to / "ramp.csv", [*head, *body])], truth_of(one, 90))


def graphical_analysis(to: Path, rng: Rng) -> Made:
    """A school's app: the name of the run before each column, a sensor of force pulled by hand."""
    t = np.arange(0, 40, 0.05)
    newton = 10 + 7 * np.sin(2 * np.pi * 0.09 * t) + 2 * np.sin(2 * np.pi * 0.043 * t)
    one = Cell(9.7, -4.0, 2e-3)
    head = "Run 1: Time (s),Run 1: Force (N),Run 1: Potential (V)"
    body = rows(t, newton + rng.normal(0, 0.02, t.size), one.read(newton, rng, whole=False),
                form="%.5f")  # fmt: skip
    return Made([write(to / "lab3.csv", [head, *body])], truth_of(one))


def serial_known_mass(to: Path, rng: Rng) -> Made:
    """A sketch that asks for the mass: `17:45:53.262 -> Known mass is: 100.00 g`."""
    one, lines, second = cell(rng), [], 0.0

    def say(text: str) -> None:
        nonlocal second
        second += 0.1
        lines.append(f"17:{45 + int(second // 60)}:{second % 60:06.3f} -> {text}")

    say("Starting...")
    say("Remove any load applied to the load cell.")
    for grams in (0, 100, 200, 500, 1000):
        say(f"Known mass is: {grams:.2f} g")
        for c in one.read(np.full(12, grams * 1e-3 * G), rng):
            say(f"raw: {c:.0f}")
    return Made([write(to / "monitor.txt", lines)], truth_of(one, 10))


def points_of_a_firmware(to: Path, rng: Rng) -> Made:
    """A plate's firmware asks cell after cell: `[CAL] LC1 point 3: mass=5.000 kg raw=8223570`."""
    cells, lines = {}, ["[SYS] Force plate v2.1 ready", "[CAL] step B: span and linearity"]
    for number in range(1, 5):
        one = cell(rng)
        cells[str(number)] = one
        lines.append(f"[CAL] LC{number}: tare done")
        for i, kg in enumerate((0, 5, 10, 15, 20, 10)):
            raw = one.read(np.array([kg * G]), rng)[0]
            lines.append(f"[CAL] LC{number} point {i}: mass={kg:.3f} kg raw={raw:.0f} (n=500)")
    return Made([write(to / "console.log", lines)], truth_of(cells, 200))


def json_of_a_lab(to: Path, rng: Rng) -> Made:
    """A schema of a laboratory: channels, each with a list of weights and what they gave."""
    cells, channels = {}, []
    for number in (0, 1):
        one = cell(rng, "hx_small")
        cells[str(number)] = one
        said = [{"weight_g": g, "reading": float(one.read(np.array([g * 1e-3 * G]), rng)[0])}
                for g in (0, 100, 200, 500, 1000, 500, 0)]  # fmt: skip
        channels.append({"channel": number, "weight_measurement": said})
    text = json.dumps({"device_name": "LoadCells", "calibration_date": "2024-03-12",
                       "input": {"channels": channels}}, indent=2)  # fmt: skip
    return Made([write(to / "load_cells.json", text.splitlines())], truth_of(cells, 10))


def repl_lists(to: Path, rng: Rng) -> Made:
    """What was left in the window of a microcontroller's Python."""
    one = cell(rng)
    lines = ["MicroPython v1.22.1 on 2024-01-05; Raspberry Pi Pico with RP2040", ">>> import hx"]
    for grams in (0, 200, 500, 1000):
        read = ", ".join(f"{c:.0f}" for c in one.read(np.full(6, grams * 1e-3 * G), rng))
        lines += [f">>> # {grams} g", ">>> [hx.read() for _ in range(6)]", f"[{read}]"]
    return Made([write(to / "repl.txt", lines)], truth_of(one, 10))


def dict_of_lists(to: Path, rng: Rng) -> Made:
    """A dictionary of two lists, printed on one line."""
    one, grams = cell(rng), steps((0, 250, 500, 1000), 3)
    read = [int(c) for c in one.read(grams * 1e-3 * G, rng)]
    text = str({"weight_g": [int(g) for g in grams], "raw": read})
    return Made([write(to / "cal.txt", [text])], truth_of(one, 10))


def nominal_and_actual(to: Path, rng: Rng) -> Made:
    """What stands on the weights, and what they weigh."""
    one = cell(rng)
    nominal = steps((0, 1, 2, 5), 4)
    actual = nominal * 1000 * steps((1, 1.012, 0.981, 1.017), 4)
    body = rows(nominal, actual, one.read(actual * 1e-3 * G, rng), form="%.8g")
    return Made([write(to / "weights.csv", ["nominal_kg,actual_g,raw", *body])],
                truth_of(one, 50))  # fmt: skip


def notebook_of_sums(to: Path, rng: Rng) -> Made:
    """Typed by hand: plates that were added to each other, in words."""
    one = cell(rng)
    lines = ["Tues 12 March, blue cell, bench by the window", ""]
    for said, lb in (("empty", 0), ("1 lb", 1), ("2.5 lb", 2.5), ("1 lb + 2.5 lb", 3.5),
                     ("5 lb", 5), ("5 lb + 2.5 lb", 7.5), ("empty", 0)):  # fmt: skip
        lines.append(f"{said}: {one.read(np.array([lb * LB]), rng)[0]:.0f}")
    return Made([write(to / "notes.txt", lines)], truth_of(one, 30))


def water_in_litres(to: Path, rng: Rng) -> Made:
    """Loads of water in litres: nobody says how warm, nor what the bottle weighs."""
    one, litres = cell(rng), steps((0, 0.5, 1, 1.5, 2), 3)
    body = rows(litres, one.read(litres * G, rng))
    return Made([write(to / "bottles.csv", ["Water (L),raw", *body])], says="unit")


def modbus_two_registers(to: Path, rng: Rng) -> Made:
    """A transmitter's reading in two registers of sixteen bits, the high one first."""
    one, kg = Cell(2.1e-4, -60.0, 9.0), steps((0, 5, 10, 20, 40), 4)
    read = one.read(kg * G, rng).astype(int)
    body = rows(kg, read >> 16, read & 0xFFFF)
    return Made([write(to / "modbus.csv", ["load_kg,reg_30001_hi,reg_30002_lo", *body])],
                truth_of(one, 400))  # fmt: skip


def pandas_describe(to: Path, rng: Rng) -> Made:
    """Printed statistics of each load: count, mean, std, min, quartiles, max."""
    one = cell(rng)
    lines = ["          count        mean    std        min        25%        50%        75%"
             "        max", "weight_g"]  # fmt: skip
    for grams in (0, 100, 200, 500, 1000):
        read = one.read(np.full(80, grams * 1e-3 * G), rng)
        stats = (80.0, read.mean(), read.std(), read.min(), *np.percentile(read, (25, 50, 75)),
                 read.max())  # fmt: skip
        lines.append(f"{grams:<10d}" + " ".join(f"{v:.1f}".rjust(10) for v in stats))
    return Made([write(to / "describe.txt", lines)], truth_of(one, 10))


def arabic_digits(to: Path, rng: Rng) -> Made:
    """A sheet in Arabic with Arabic digits."""
    one, kg = cell(rng), steps((0, 1, 2, 5), 4)
    digits = str.maketrans("0123456789.", "٠١٢٣٤٥٦٧٨٩٫")
    body = [x.translate(digits) for x in rows(kg, one.read(kg * G, rng), sep=";")]
    return Made([write(to / "cal.csv", ["الوزن (كغ);القراءة", *body])], truth_of(one, 50))


def greek_sheet(to: Path, rng: Rng) -> Made:
    """A sheet in Greek, its code page."""
    return sheet_under(to, rng, "Βάρος (kg);Ένδειξη", "cp1253")


def hungarian_sheet(to: Path, rng: Rng) -> Made:
    """A sheet in Hungarian, its code page."""
    return sheet_under(to, rng, "Tömeg (kg);Kijelzett érték", "cp1250")


def vietnamese_sheet(to: Path, rng: Rng) -> Made:
    """A sheet in Vietnamese."""
    return sheet_under(to, rng, "Khối lượng (kg);Giá trị đọc")


def mosquitto_verbose(to: Path, rng: Rng) -> Made:
    """Topics and payloads, one below the other: `scale/raw 8223570`."""
    one, grams = cell(rng), steps((0, 200, 500, 1000), 4)
    lines = []
    for g, c in zip(grams, one.read(grams * 1e-3 * G, rng), strict=True):
        lines += [f"bench/scale/weight_g {g:.0f}", f"bench/scale/raw {c:.0f}"]
    return Made([write(to / "sub.txt", lines)], truth_of(one, 10))


def cards(to: Path, rng: Rng) -> Made:
    """A card for each weight, blank lines between."""
    one, lines = cell(rng), []
    for i, grams in enumerate((0, 500, 1000, 2000, 1000, 0)):
        raw = one.read(np.array([grams * 1e-3 * G]), rng)[0]
        lines += [f"Test no.: {i + 1}", f"Weight: {grams} g", f"Reading: {raw:.0f}", ""]
    return Made([write(to / "cards.txt", lines)], truth_of(one))


def igor_waves(to: Path, rng: Rng) -> Made:
    """Igor's text waves between BEGIN and END."""
    one, newton = Cell(21.5, -3.0, 1e-3), steps((0, 5, 10, 20), 5)
    body = ["\t" + x for x in rows(newton, one.read(newton, rng, whole=False), sep="\t")]
    lines = ["IGOR", "WAVES/D/O load_N, bridge_V", "BEGIN", *body, "END",
             'X SetScale/P x 0,1,"", load_N']  # fmt: skip
    return Made([write(to / "cal.itx", lines)], truth_of(one))


def origin_rows(to: Path, rng: Rng) -> Made:
    """Origin's rows above the numbers: long name, units, comments."""
    one, newton = Cell(0.51, -6.0, 1e-2), steps((0, 10, 20, 50), 4)
    head = ["Applied load\tBridge output", "N\tmV", "dead weights\tcell 3, after warm-up"]
    body = rows(newton, one.read(newton, rng, whole=False), sep="\t", form="%.6g")
    return Made([write(to / "Book1.dat", [*head, *body])], truth_of(one, 50))


def chamber(to: Path, rng: Rng) -> Made:
    """Three loads at each of four temperatures of a chamber that the cell does not feel."""
    one = cell(rng)
    kg, temp = np.tile(steps((0, 2, 5), 4), 4), steps((10, 20, 30, 40), 12)
    body = rows(temp + rng.normal(0, 0.1, temp.size), kg, one.read(kg * G, rng), form="%.9g")
    return Made([write(to / "chamber.csv", ["T_chamber,mass_kg,adc", *body])], truth_of(one, 50))


def phone_terminal(to: Path, rng: Rng) -> Made:
    """A phone's terminal: stamps, what came in, and what was typed between."""
    one, lines, n = cell(rng), ["10:20:01.000 Connecting to HC-05 ...", "10:20:02.113 Connected"], 0
    for said, grams in (("0g", 0), ("250g", 250), ("500g", 500), ("1000g", 1000), ("0g", 0)):
        lines.append(f"10:{21 + n // 60}:{n % 60:02d}.050 {said}")
        for c in one.read(np.full(15, grams * 1e-3 * G), rng):
            n += 1
            lines.append(f"10:{21 + n // 60}:{n % 60:02d}.{rng.integers(100, 999)} {c:.0f}")
    return Made([write(to / "serial_20240312_102001.txt", lines)], truth_of(one, 10))


def rows_marked_bad(to: Path, rng: Rng) -> Made:
    """A column that says which rows count."""
    one, kg = cell(rng), steps((0, 1, 2, 5), 5)
    read = one.read(kg * G, rng)
    good = np.ones(kg.size, dtype=bool)
    good[[3, 4, 11, 17]] = False
    read = np.where(good, read, read + 30000)
    lines = ["load_kg,reading,valid"]
    lines += [f"{k:g},{c:.0f},{'yes' if g else 'no'}"
              for k, c, g in zip(kg, read, good, strict=True)]  # fmt: skip
    return Made([write(to / "bench.csv", lines)], truth_of(one, 50))


def torque_by_lever(to: Path, rng: Rng) -> Made:
    """A torque sensor: weights at two lengths of a lever. The weight alone is no load."""
    kg, cm = np.tile(steps((0, 0.5, 1, 2), 3), 2), steps((10, 25), 12)
    read = 120 + 5200 * kg * G * cm / 100 + rng.normal(0, 3, kg.size)
    body = rows(kg, cm, np.round(read))
    return Made([write(to / "lever.csv", ["mass_kg,arm_cm,raw", *body])], says="torque")


def two_gains(to: Path, rng: Rng) -> Made:
    """One cell behind an amplifier that was set to 128 and to 64."""
    cells, lines = {}, ["gain,load_g,raw"]
    for gain in (128, 64):
        one = Cell(-4.4e-5 * 128 / gain, 3.0, 30.0)
        cells[str(gain)] = one
        grams = steps((0, 200, 500, 1000), 4)
        lines += rows(np.full(grams.size, gain), grams, one.read(grams * 1e-3 * G, rng))
    return Made([write(to / "gains.csv", lines)], truth_of(cells, 10))


def excitation_beside(to: Path, rng: Rng) -> Made:
    """The bridge's supply was logged, too."""
    one, newton = Cell(4.1, -2.0, 2e-3), steps((0, 10, 20, 40), 6)
    supply = rng.normal(5.0, 0.0004, newton.size)
    body = rows(newton, one.read(newton, rng, whole=False), supply, form="%.6g")
    return Made([write(to / "bridge.csv", ["Load [N],Vout [mV],Vexc [V]", *body])],
                truth_of({"vout": one}, 40))  # fmt: skip


def corner_settling(to: Path, rng: Rng) -> Made:
    """A scale's raw stream with the load typed at its start alone: `load=2kg` once per hold."""
    kg = (0, 2, 4, 1, 0)
    one = cell(rng)
    load = settling([k * G for k in kg], 5, 10)
    read, lines = one.read(load, rng), ["ms,raw,note"]
    for i, c in enumerate(read):
        note = f"load={kg[i // 58]}kg" if i % 58 == 0 else ""
        lines.append(f"{100 * i},{c:.0f},{note}")
    return Made([write(to / "stream.csv", lines)], truth_of(one, 40))


SIXTEENTH_BENCH = (
    wincc_archive, windaq, graphical_analysis, serial_known_mass, points_of_a_firmware,
    json_of_a_lab, repl_lists, dict_of_lists, nominal_and_actual, notebook_of_sums,
    water_in_litres, modbus_two_registers, pandas_describe, arabic_digits, greek_sheet,
    hungarian_sheet, vietnamese_sheet, mosquitto_verbose, cards, igor_waves, origin_rows, chamber,
    phone_terminal, rows_marked_bad, torque_by_lever, two_gains, excitation_beside,
    corner_settling,
)  # fmt: skip
