"""Benches of people nobody met: exports with merged heads, arrows, colours, sums, presses.

Written before it was run, with `thirty_first_stands` and `thirty_first_robots`;
`docs/bring_your_log.md` has their first count.
"""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np

from tests.strangers.rigs import G, Made, Rng, cell, rows, settling, steps, truth_of, write

_BEGIN = datetime(2026, 5, 18, 14, 3, 7, tzinfo=UTC)


def _epoch_ms(seconds: float) -> int:
    return round(1e3 * (_BEGIN.timestamp() + seconds))


def _iso(seconds: float) -> str:
    stamp = (_BEGIN + timedelta(seconds=seconds)).strftime("%Y-%m-%dT%H:%M:%S.%f")
    return stamp[:-3] + "+02:00"


def italian_amplifier(to: Path, rng: Rng) -> Made:
    """Three bridges in mV/V, a row of units, which one the sample mass lies on in a column."""
    cells = {str(i): cell(rng, "volt") for i in (1, 2, 3)}
    lines = ["Tempo;Cella 1;Cella 2;Cella 3;Massa campione;Cella caricata",
             "s;mV/V;mV/V;mV/V;kg;-"]  # fmt: skip
    t = 0.0
    for name in cells:
        for kg in (0.0, 1.0, 2.5, 5.0, 2.5):
            for _ in range(6):
                read = [c.read(np.array(kg * G * (n == name)), rng, whole=False)
                        for n, c in cells.items()]  # fmt: skip
                said = ";".join([f"{t:.1f}", *(f"{v:.5f}" for v in read), f"{kg:.1f}", name])
                lines.append(said.replace(".", ","))
                t += 0.5
    return Made([write(to / "acquisizione.csv", lines, "cp1252")], truth_of(cells, 50))


def french_sums(to: Path, rng: Rng) -> Made:
    """Masses put on top of each other and taken off again, with the sign of what was done."""
    one, total, lines = cell(rng, "hx_small"), 0.0, ["Étape;Masse ajoutée (g);Lecture"]
    for step, g in enumerate((0, 500, 500, 1000, 1000, -1000, -1000, -500, -500)):
        total += g / 1000
        for _ in range(5):
            read = one.read(np.array(total * G), rng)
            lines.append(f"{step};{g};{read:.0f}")
    return Made([write(to / "étalonnage.csv", lines)], truth_of(one, 30), "added at each step")


def spanish_files(to: Path, rng: Rng) -> Made:
    """A file for each foot's cell, weight and direction: date, side, kilograms, up or down."""
    cells, paths, t = {"izq": cell(rng), "der": cell(rng)}, [], 0.0
    for name, one in cells.items():
        for way, loads in (("subida", (0, 0.5, 1, 2.5)), ("bajada", (2.5, 1, 0.5, 0))):
            for kg in loads:
                lines = ["marca_ms,lectura"]
                for _ in range(20):
                    lines.append(f"{_epoch_ms(t)},{one.read(np.array(kg * G), rng):.0f}")
                    t += 0.1
                paths.append(write(to / f"2026-05-18_celda_{name}_{kg}kg_{way}.csv", lines))
    return Made(paths, truth_of(cells, 25))


def tare_and_weights(to: Path, rng: Rng) -> Made:
    """A scale that was tared once at the start; events stand where something was done."""
    one, lines, zero, t = cell(rng), ["timestamp,raw_counts,event"], 0.0, 0.0
    for event, kg in (
        ("", 0.3), ("TARE", 0.3), ("1000 g", 1.3), ("remove", 0.3), ("2000 g", 2.3),
        ("remove", 0.3), ("500 g", 0.8), ("remove", 0.3),
    ):  # fmt: skip
        if event == "TARE":
            zero = float(one.read(np.array(kg * G), rng))
        for i in range(25):
            read = one.read(np.array(kg * G), rng) - zero
            lines.append(f"{_iso(t)},{read:.0f},{event if i == 0 else ''}")
            t += 0.1
    tared = {"": type(one)(one.scale, 0.0, one.noise)}
    return Made([write(to / "scale_log.csv", lines)], truth_of(tared, 25))


def merged_feet(to: Path, rng: Rng) -> Made:
    """Excel: feet over four cells each, the loaded one written once per block of rows."""
    where = ("FL", "FR", "RL", "RR")
    cells = {f"{s} {p}": cell(rng) for s in ("Left", "Right") for p in where}
    lines = ["Load on,Mass,Left foot,,,,Right foot,,,", ",kg," + ",".join(where * 2)]
    for name in cells:
        first = name
        for kg in (0, 0.5, 1, 2):
            for _ in range(3):
                read = [c.read(np.array(kg * G * (n == name)), rng) for n, c in cells.items()]
                lines.append(",".join([first, f"{kg}", *(f"{v:.0f}" for v in read)]))
                first = ""
    return Made([write(to / "Feet calibration.csv", lines, "utf-8-sig", "\r\n")], truth_of(cells))


def zwick_press(to: Path, rng: Rng) -> Made:
    """A testing machine that never stands still: its force, and the sensor in mV/V."""
    one = cell(rng, "volt")
    t = np.arange(1200) / 50
    load = 200 * (1 - np.cos(2 * np.pi * t / 12)) / 2 + 30 * np.sin(2 * np.pi * t / 3.1) ** 2
    lines = ["Prüfprogramm: Druckversuch", "Prüfer: M. Huber", "Vorkraft: 5 N", "",
             "Prüfzeit\tStandardkraft\tTraversenweg\tAufnehmer", "s\tN\tmm\tmV/V"]  # fmt: skip
    measured = load + rng.normal(0, 0.1, t.size)
    body = rows(t, measured, 0.002 * load, one.read(load, rng, whole=False), sep="\t", form="%.6g")
    lines += [x.replace(".", ",") for x in body]
    return Made([write(to / "Probe_4.TRA", lines, "latin-1", "\r\n")], truth_of(one, 200))


def esp_idf_colours(to: Path, rng: Rng) -> Made:
    """The monitor of a microcontroller: colours of a terminal around each line."""
    cells, t = {str(i): cell(rng) for i in (0, 1, 2, 3)}, 312
    lines = ["\x1b[0;32mI (301) main_task: Calling app_main()\x1b[0m"]
    for name, one in cells.items():
        for g in (0, 200, 500, 1000):
            for _ in range(8):
                read = one.read(np.array(g / 1000 * G), rng)
                lines.append(f"\x1b[0;32mI ({t}) HX711: ch={name} raw={read:.0f} ref_g={g}\x1b[0m")
                t += 100
    return Made([write(to / "monitor.log", lines)], truth_of(cells))


def japanese_microvolts(to: Path, rng: Rng) -> Made:
    """Shift-JIS, kilogram-force, µV/V, a line of what the amplifier was set to above."""
    one, kgf = cell(rng, "volt"), steps((0, 2, 4, 6, 8, 10, 5, 0), 10)
    read = 1e3 * one.read(kgf * G, rng, whole=False)
    lines = ["機種,動ひずみ測定器", "サンプリング周波数,10 Hz", "",
             "No.,荷重[kgf],出力[μV/V]",
             *rows(np.arange(1.0, kgf.size + 1), kgf, read, form="%.7g")]  # fmt: skip
    micro = {"": type(one)(one.scale / 1e3, one.bias, one.noise)}
    return Made([write(to / "校正.csv", lines, "shift_jis")], truth_of(micro, 100))


def arrows_of_a_notebook(to: Path, rng: Rng) -> Made:
    """A line for each cell: `FL: 0 g -> 8123456, 200 g -> 8130000, …`."""
    cells = {n: cell(rng) for n in ("fl", "fr", "rl", "rr")}
    lines = ["18 May, bench 2, after lunch. weights from the school set", ""]
    for name, one in cells.items():
        pairs = [f"{g} g -> {one.read(np.array(g / 1000 * G), rng):.0f}"
                 for g in (0, 200, 500, 1000, 2000, 0)]  # fmt: skip
        lines.append(f"{name.upper()}: {', '.join(pairs)}")
    return Made([write(to / "notes.txt", lines)], truth_of(cells), "several weights")


def hand_on_one(to: Path, rng: Rng) -> Made:
    """A stream of one cell, the weights said in a line above in pounds and ounces of force."""
    one, rate = cell(rng, "hx_small"), 80.0
    load = settling([0, 4.4482, 13.3447, 22.2411, 4.4482, 0], 4, rate)
    lines = ["% HX711 @ 80 SPS, gain 128", "% weights: 0, 1, 3, 5, 1, 0 lbf", "% raw",
             *(f"{v:.0f}" for v in one.read(load, rng))]  # fmt: skip
    return Made([write(to / "capture.txt", lines)], truth_of(one, 25))


THIRTY_FIRST_BENCH = (
    italian_amplifier, french_sums, spanish_files, tare_and_weights, merged_feet, zwick_press,
    esp_idf_colours, japanese_microvolts, arrows_of_a_notebook, hand_on_one,
)  # fmt: skip
