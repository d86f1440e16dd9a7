"""Weights and presses as instruments, databases and notebooks keep them, each with its truth.

Written before it was run; `docs/bring_your_log.md` has its first count.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from tests.strangers.rigs import Cell, G, Made, Rng, cell, rows, settling, steps, truth_of, write

_KG = (0, 0.5, 1, 2, 5)
_NS = 1_710_237_600_000_000_000


def _stairs(rng: Rng, hold: int = 8) -> tuple[Cell, np.ndarray, np.ndarray]:
    """A converter's cell, its loads in kg and its readings."""
    one, kg = cell(rng), steps(_KG, hold)
    return one, kg, one.read(kg * G, rng)


def _press(rng: Rng) -> tuple[Cell, np.ndarray, np.ndarray, np.ndarray]:
    """A bridge under a press with a reference in newtons: t, reference, mV/V."""
    one, load = Cell(980.0, -5.0, 2e-5), settling([0, 200, 400, 800, 400, 0], 3, 20)
    read = one.read(load, rng, whole=False)
    return one, np.arange(load.size) / 20, load + rng.normal(0, 0.2, load.size), read


def catman_german(to: Path, rng: Rng) -> Made:
    """Catman: a preamble in German, names and units below one another, commas, tabs."""
    one, t, ref, read = _press(rng)
    lines = ["HBM_CATMAN_DATENDATEI_40", "Messrate\t20 Hz", "Kanäle\t3", "",
             "Zeit 1\tU10M_Referenz\tFußzelle", "s\tN\tmV/V",
             *(x.replace(".", ",") for x in rows(t, ref, read, sep="\t", form="%.6f"))]  # fmt: skip
    return Made([write(to / "Messung_1.asc", lines, "latin-1", "\r\n")], truth_of(one, 800))


def quantumx_csv(to: Path, rng: Rng) -> Made:
    """MX840B: names with device and channel, units in brackets, semicolons and commas."""
    one, t, ref, read = _press(rng)
    head = "Time  1 - default sample rate [s];MX840B_CH 1 Ref [N];MX840B_CH 2 Cell [mV/V]"
    body = [x.replace(".", ",") for x in rows(t, ref, read, sep=";", form="%.6f")]
    return Made([write(to / "qx.csv", [head, *body])], truth_of(one, 800))


def tdms_as_text(to: Path, rng: Rng) -> Made:
    """A TDMS file pasted from its viewer: group and channel in the names, properties above."""
    one, t, ref, read = _press(rng)
    lines = ["name\tpress_01", "author\tlab", "wf_increment\t0.05", "",
             "/'press'/'time'\t/'press'/'ref_N'\t/'press'/'cell_mV_V'",
             *rows(t, ref, read, sep="\t", form="%.6f")]  # fmt: skip
    return Made([write(to / "press.tdms.txt", lines)], truth_of(one, 800))


def catman_japanese(to: Path, rng: Rng) -> Made:
    """A press in Japanese, Shift-JIS: time, load in newtons, output."""
    one, t, ref, read = _press(rng)
    lines = ["時間[s],荷重[N],出力[mV/V]", *rows(t, ref, read, form="%.6f")]
    return Made([write(to / "press_jp.csv", lines, "shift_jis", "\r\n")], truth_of(one, 800))


def french_press(to: Path, rng: Rng) -> Made:
    """A press in French: ``Temps``, ``Effort``, ``Signal``."""
    one, t, ref, read = _press(rng)
    body = [x.replace(".", ",") for x in rows(t, ref, read, sep=";", form="%.6f")]
    head = "Temps (s);Effort appliqué (N);Signal capteur (mV/V)"
    return Made([write(to / "essai.csv", [head, *body], "latin-1")], truth_of(one, 800))


def serial_monitor_stamps(to: Path, rng: Rng) -> Made:
    """Arduino's monitor with stamps, a file for each weight."""
    one, paths = cell(rng), []
    for kg in _KG:
        lines = [f"12:33:{i // 10:02d}.{i % 10}23 -> {c:.0f}"
                 for i, c in enumerate(one.read(np.full(30, kg * G), rng))]  # fmt: skip
        paths.append(write(to / f"{kg:g}kg.txt", lines))
    return Made(paths, truth_of(one, 50))


def serial_with_tare(to: Path, rng: Rng) -> Made:
    """An HX711 sketch: its words, a tare, then weights that a person typed between readings."""
    one, lines = cell(rng), ["Initializing the scale", "Tare done.", "offset: 0"]
    for i, kg in enumerate(_KG):
        lines.append(f"12:3{i}:00.001 -> # load {kg:g} kg")
        lines += [f"12:3{i}:{j:02d}.125 -> raw: {c:.0f}"
                  for j, c in enumerate(one.read(np.full(12, kg * G), rng))]  # fmt: skip
    return Made([write(to / "tare.txt", lines)], truth_of(one, 50))


def influx_lines(to: Path, rng: Rng) -> Made:
    """InfluxDB's line protocol: tags, fields, nanoseconds."""
    one, kg, read = _stairs(rng)
    lines = [f"loadcell,host=pi,chan=a raw={c:.0f}i,load_kg={k:g} {_NS + i * 100_000_000}"
             for i, (k, c) in enumerate(zip(kg, read, strict=True))]  # fmt: skip
    return Made([write(to / "cell.lp", lines)], truth_of(one, 50))


def influx_annotated(to: Path, rng: Rng) -> Made:
    """InfluxDB's annotated CSV: a row for each field, datatypes above."""
    one, kg, read = _stairs(rng)
    lines = ["#datatype,string,long,dateTime:RFC3339,double,string,string",
             "#group,false,false,false,false,true,true", "#default,_result,,,,,",
             ",result,table,_time,_value,_field,_measurement"]  # fmt: skip
    for table, (name, values) in enumerate((("load_kg", kg), ("raw", read))):
        lines += [f",,{table},2024-03-12T10:{i // 60:02d}:{i % 60:02d}Z,{v:.10g},{name},cell"
                  for i, v in enumerate(values)]  # fmt: skip
    return Made([write(to / "query.csv", lines)], truth_of(one, 50))


def prometheus_dump(to: Path, rng: Rng) -> Made:
    """Prometheus' text: name, labels, value, milliseconds; the load is a gauge of its own."""
    one, kg, read = _stairs(rng)
    lines = ["# HELP cell_raw counts", "# TYPE cell_raw gauge"]
    for i, (k, c) in enumerate(zip(kg, read, strict=True)):
        at = _NS // 10**6 + 100 * i
        lines += [f'load_kg{{rig="a"}} {k:g} {at}', f'cell_raw{{rig="a"}} {c:.0f} {at}']
    return Made([write(to / "metrics.prom", lines)], truth_of(one, 50))


def mqtt_topics(to: Path, rng: Rng) -> Made:
    """`mosquitto_sub -v -F`: a stamp, a topic and JSON."""
    one, kg, read = _stairs(rng)
    lines = [f'2024-03-12T10:{i // 60:02d}:{i % 60:02d}+0100 lab/rig/cell '
             f'{{"load_kg":{k:g},"raw":{c:.0f}}}'
             for i, (k, c) in enumerate(zip(kg, read, strict=True))]  # fmt: skip
    return Made([write(to / "mqtt.log", lines)], truth_of(one, 50))


def json_nested_lines(to: Path, rng: Rng) -> Made:
    """JSON lines with objects inside objects."""
    one, kg, read = _stairs(rng)
    lines = [json.dumps({"ts": 1e-3 * i * 100, "ref": {"mass": {"value": k, "unit": "kg"}},
                         "cell": {"raw": int(c)}})
             for i, (k, c) in enumerate(zip(kg, read, strict=True))]  # fmt: skip
    return Made([write(to / "cell.jsonl", lines)], truth_of(one, 50))


def candump_of_a_cell(to: Path, rng: Rng) -> Made:
    """`candump -L`: four bytes, little end first; a file for each weight."""
    one, paths = cell(rng), []
    for kg in _KG:
        lines = []
        for i, c in enumerate(one.read(np.full(20, kg * G), rng)):
            data = int(c).to_bytes(4, "little", signed=True).hex().upper()
            lines.append(f"(17102376{i // 10:02d}.{i % 10}00000) can0 181#{data}")
        paths.append(write(to / f"candump_{kg:g}kg.log", lines))
    return Made(paths, says="candump")


def markdown_notebook(to: Path, rng: Rng) -> Made:
    """A notebook in Markdown: prose, a table with units, repeats in columns."""
    one = cell(rng)
    lines = ["# 12 March", "", "Hung plates on the foot, three readings each.", "",
             "| Mass / kg | Reading 1 | Reading 2 | Reading 3 |",
             "|---:|---:|---:|---:|"]  # fmt: skip
    for kg in _KG:
        a = one.read(np.full(3, kg * G), rng)
        lines.append(f"| {kg:g} | {a[0]:.0f} | {a[1]:.0f} | {a[2]:.0f} |")
    return Made([write(to / "notes.md", [*lines, "", "Drift looks small."])], truth_of(one, 50))


def summary_mean_sd(to: Path, rng: Rng) -> Made:
    """One row for each load: mean, standard deviation, number of samples."""
    one, lines = cell(rng), ["Load (N),Mean (counts),SD (counts),n"]
    for f in (0, 10, 20, 50, 100, 50, 20, 10, 0):
        read = one.read(np.full(200, float(f)), rng)
        lines.append(f"{f},{read.mean():.2f},{read.std(ddof=1):.2f},{read.size}")
    return Made([write(to / "summary.csv", lines)], truth_of(one, 100))


def summary_of_two_cells(to: Path, rng: Rng) -> Made:
    """Means and deviations of two cells in one row for each load, ``±`` spelled out."""
    cells = {"heel": cell(rng), "toe": cell(rng)}
    lines = ["weight_kg\theel_mean\theel_std\ttoe_mean\ttoe_std"]
    for kg in (*_KG, *_KG[::-1]):
        parts = [one.read(np.full(100, kg * G), rng) for one in cells.values()]
        lines.append("\t".join([f"{kg:g}", *(f"{v:.2f}" for p in parts
                                            for v in (p.mean(), p.std()))]))  # fmt: skip
    return Made([write(to / "both.tsv", lines)], truth_of(cells, 50))


def plus_minus_cells(to: Path, rng: Rng) -> Made:
    """Readings as ``8223570 ± 12``."""
    one, lines = cell(rng), ["mass [kg];reading"]
    for kg in (*_KG, *_KG[::-1]):
        read = one.read(np.full(50, kg * G), rng)
        lines.append(f"{kg:g};{read.mean():.0f} ± {read.std():.0f}")
    return Made([write(to / "pm.csv", lines)], truth_of(one, 50))


def blocks_below_units(to: Path, rng: Rng) -> Made:
    """Two cells in blocks of columns, each with its own header, a row of units below."""
    cells, kg = {"left": cell(rng), "right": cell(rng)}, steps(_KG, 6)
    lines = ["left,,,right,,", "time,load,reading,time,load,reading", "s,kg,counts,s,kg,counts"]
    t = 0.1 * np.arange(kg.size)
    read = [one.read(kg * G, rng) for one in cells.values()]
    lines += rows(t, kg, read[0], t, kg, read[1])
    return Made([write(to / "wide.csv", lines)], truth_of(cells, 50))


def rate_in_a_sentence(to: Path, rng: Rng) -> Made:
    """No stamps; a comment says ``sampled at 80 Hz``. Reference and cell under a press."""
    one, _, ref, read = _press(rng)
    lines = ["# press run, both channels sampled at 80 Hz", "ref_N,cell_mV_V",
             *rows(ref, read, form="%.6f")]  # fmt: skip
    return Made([write(to / "press.csv", lines)], truth_of(one, 800))


def kitchen_video(to: Path, rng: Rng) -> Made:
    """A scale filmed: minutes and seconds, what the scale showed, what the cell gave."""
    one = cell(rng)
    lines = ["video time,scale shows (g),adc"]
    for i, kg in enumerate((*_KG, *_KG[::-1])):
        lines.append(f"{i // 4:02d}:{15 * (i % 4):02d},{1e3 * kg:g} g,"
                     f"{one.read(np.array(kg * G), rng):.0f}")  # fmt: skip
    return Made([write(to / "video.csv", lines)], truth_of(one, 50))


def excel_thousands(to: Path, rng: Rng) -> Made:
    """Excel in German: thousands parted by dots, decimals by commas."""
    one, kg, read = _stairs(rng)
    lines = ["Gewicht [g];Rohwert"]
    for k, c in zip(kg, read, strict=True):
        lines.append(f"{1e3 * k:,.1f};{c:,.0f}".translate(str.maketrans(",.", ".,")))
    return Made([write(to / "Mappe1.csv", lines, "utf-8-sig", "\r\n")], truth_of(one, 50))


def swiss_thousands(to: Path, rng: Rng) -> Made:
    """Thousands parted by apostrophes."""
    one, kg, read = _stairs(rng)
    lines = ["Masse (kg);ADC", *(f"{k:g};{c:,.0f}".replace(",", "'")
                                for k, c in zip(kg, read, strict=True))]  # fmt: skip
    return Made([write(to / "zelle.csv", lines)], truth_of(one, 50))


def readings_of_lbf_force(to: Path, rng: Rng) -> Made:
    """A force gauge in lbf beside an amplifier in volts, Mark-10's export."""
    one, t, ref, _ = _press(rng)
    one = Cell(180.0, -5.0, 1e-4)
    read = one.read(ref, rng, whole=False)
    lines = ["MESUR gauge", "Units: lbF", "", "Reading No.,Time [s],Load [lbF],Ext [V]",
             *(f"{i},{x}" for i, x in enumerate(rows(t, ref / 4.4482216152605, read, form="%.6f"),
                                               1))]  # fmt: skip
    return Made([write(to / "mark10.csv", lines)], truth_of(one, 800))


def names_below_units(to: Path, rng: Rng) -> Made:
    """Blocks of columns under their cells, a row of units, and the names below that."""
    cells, kg = {"left": cell(rng), "right": cell(rng)}, steps(_KG, 4)
    left, right = (one.read(kg * G, rng) for one in cells.values())
    lines = ["left,,right,", "kg,counts,kg,counts", "Load,Reading,Load,Reading"]
    return Made([write(to / "blocks.csv", [*lines, *rows(kg, left, kg, right)])],
                truth_of(cells, 50))  # fmt: skip


def listed_loads_held_briefly(to: Path, rng: Rng) -> Made:
    """Loads held for 2.5 s and put on by hand; a remark lists them."""
    one, load = cell(rng), settling([G * kg for kg in (0, 1, 2, 5, 2, 0)], 2.5, 80, 1.0)
    read = one.read(load, rng) + np.round(np.cumsum(rng.normal(0, 3, load.size)))
    return Made([write(to / "hand.csv", ["# loads: 0, 1, 2, 5, 2, 0 kg", "t,raw",
                                         *rows(np.arange(load.size) / 80, read)])],
                truth_of(one, 50))  # fmt: skip


TWENTY_THIRD_BENCH = (
    catman_german, quantumx_csv, tdms_as_text, catman_japanese, french_press,
    serial_monitor_stamps, serial_with_tare, influx_lines, influx_annotated, prometheus_dump,
    mqtt_topics, json_nested_lines, candump_of_a_cell, markdown_notebook, summary_mean_sd,
    summary_of_two_cells, plus_minus_cells, blocks_below_units, rate_in_a_sentence,
    kitchen_video, excel_thousands, swiss_thousands, readings_of_lbf_force, names_below_units,
    listed_loads_held_briefly,
)  # fmt: skip
