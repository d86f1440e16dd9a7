"""Benches as loggers, locales and indicators print them, each with its truth.

Written before it was run; `docs/bring_your_log.md` has its first count.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from tests.strangers.rigs import Cell, G, Made, Rng, cell, rows, settling, steps, truth_of, write

_KG = (0, 0.5, 1, 2, 5)
_LB = 0.45359237


def _press(rng: Rng) -> tuple[Cell, np.ndarray, np.ndarray, np.ndarray]:
    """A bridge under a press with a reference in newtons: t, reference, mV/V."""
    one, load = Cell(980.0, -5.0, 2e-5), settling([0, 200, 400, 800, 400, 0], 3, 20)
    read = one.read(load, rng, whole=False)
    return one, np.arange(load.size) / 20, load + rng.normal(0, 0.2, load.size), read


def _stairs(rng: Rng, hold: int = 6) -> tuple[Cell, np.ndarray, np.ndarray]:
    """A converter's cell, its loads in kg and its readings."""
    one, kg = cell(rng), steps(_KG, hold)
    return one, kg, one.read(kg * G, rng)


def _comma(lines: list[str]) -> list[str]:
    return [x.replace(".", ",") for x in lines]


def dasylab_header(to: Path, rng: Rng) -> Made:
    """DASYLab: worksheet, date, block length and delta above the rows, `;` at their end."""
    one, t, ref, read = _press(rng)
    head = ["DASYLab - V 12.00.00", "Worksheet name: KRAFT",
            "Recording date     : 12.03.2024, 10:02:11", "Block length       : 1",
            "Delta              : 0.05 sec.", "Number of channels : 2", "",
            "Measurement time[hh:mm:ss];Kraft_Ref [N];Bruecke [mV/V];"]  # fmt: skip
    body = [f"10:{2 + int(s // 60):02d}:{s % 60:06.3f};{f:.3f};{c:.6f};".replace(".", ",")
            for s, f, c in zip(t + 11, ref, read, strict=True)]  # fmt: skip
    return Made([write(to / "KRAFT.asc", [*head, *body], "latin-1", "\r\n")], truth_of(one, 800))


def catman_channel_comments(to: Path, rng: Rng) -> Made:
    """catman ASCII: a block of `KEY= value` for each channel, then names, then units."""
    one, _, ref, read = _press(rng)
    head = [
        "HBM_CATMAN_DATAFILE_40",
        "OPERATOR: js",
        "NO OF CHANNELS: 3",
        "ASSOCIATED TIME CHANNEL: 1",
    ]
    for name, unit in (("Time", "s"), ("U9C", "N"), ("MX840_CH2", "mV/V")):
        head += [f"CHANNELNAME= {name}", f"UNIT= {unit}", "DATE= 12.03.2024", "SAMPLE RATE= 20 Hz",
                 "COMMENT= ", "LENGTH= 400"]  # fmt: skip
    body = rows(np.arange(read.size) / 20, ref, read, sep="\t", form="%.6f")
    lines = [*head, "Time\tU9C\tMX840_CH2", "s\tN\tmV/V", *body]
    return Made([write(to / "press.asc", lines, "latin-1")], truth_of(one, 800))


def daq_block_above(to: Path, rng: Rng) -> Made:
    """NI: channels, ranges and statistics of each column stand above the rows."""
    one, kg, _ = _stairs(rng)
    one = Cell(21.3, -7.5, 1e-3)
    read = one.read(kg * G, rng, whole=False)
    lines = ["Device,Dev1,,", "Physical channel,,Dev1/ai0,Dev1/ai1", "Minimum,,-10,-10",
             "Maximum,,10,10", f"Mean,,{kg.mean():.4f},{read.mean():.5f}",
             f"Std,,{kg.std():.4f},{read.std():.5f}", "Sample,Time (s),Weight (kg),Cell (V)",
             *rows(np.arange(kg.size), np.arange(kg.size) / 2, kg, read, form="%.6g")]  # fmt: skip
    return Made([write(to / "daq.csv", lines)], truth_of(one, 50))


def matlab_mangled_names(to: Path, rng: Rng) -> Made:
    """`writetable` of names that MATLAB made valid: `Load_kg_`, `Reading_mV_V_`."""
    kg = steps((0, 5, 10, 20, 40), 5)
    one = Cell(510.0, -4.0, 2e-5)
    read = one.read(kg * G, rng, whole=False)
    return Made([write(to / "T.csv", ["Nr_,Load_kg_,Reading_mV_V_",
                                      *rows(np.arange(kg.size) + 1, kg, read)])],
                truth_of(one, 400))  # fmt: skip


def pandas_two_levels(to: Path, rng: Rng) -> Made:
    """`to_csv` of columns with two levels: cell over quantity, a line with the index's name."""
    cells = {"left": cell(rng), "right": cell(rng)}
    kg = steps(_KG, 4)
    data = [np.arange(kg.size, dtype=float)]
    for one in cells.values():
        data += [kg, one.read(kg * G, rng)]
    lines = [",left,left,right,right", ",load_kg,counts,load_kg,counts", "row,,,,", *rows(*data)]
    return Made([write(to / "both.csv", lines)], truth_of(cells, 50))


def thin_spaces(to: Path, rng: Rng) -> Made:
    """French: thousands parted by U+202F, decimals by commas."""
    one, kg, read = _stairs(rng)
    body = [f"{k:.1f};{c:,.0f}".replace(".", ";").replace(",", "\u202f").replace(";", ",", 1)
            for k, c in zip(kg, read, strict=True)]  # fmt: skip
    return Made([write(to / "étalonnage.csv", ["Masse (kg);Valeur brute", *body])],
                truth_of(one, 50))  # fmt: skip


def starred_outlier(to: Path, rng: Rng) -> Made:
    """One reading has a star, and below the table stands what the star means."""
    one, kg, read = _stairs(rng, 3)
    body = [f"{k:g}\t{c:.0f}" for k, c in zip(kg, read, strict=True)]
    body[7] = f"{kg[7]:g}\t{read[7] + 60000:.0f}*"
    lines = ["mass/kg\tADC", *body, "", "* bumped the table"]
    return Made([write(to / "notes.tsv", lines)], truth_of(one, 50))


def si_suffixes(to: Path, rng: Rng) -> Made:
    """A meter that shows millions of counts as `8.3477M` and thousands as `834.7k`."""
    one = Cell(4.6e-5, -3.0, 60.0)
    kg = steps((0, 0.5, 1, 2, 5, 10), 3)
    lines = ["Weight (kg),Display"]
    for k, c in zip(kg, one.read(kg * G, rng), strict=True):
        lines.append(f"{k:g},{c / 1e6:.4f}M" if c > 999_999 else f"{k:g},{c / 1e3:.2f}k")
    return Made([write(to / "meter.csv", lines)], truth_of(one, 100))


def telegraf_tags_in_a_cell(to: Path, rng: Rng) -> Made:
    """name, tags, time and fields as Influx prints a query; two cells in turn by their tags."""
    cells, lines = {"fl": cell(rng), "fr": cell(rng)}, ["name,tags,time,load_kg,raw"]
    i = 0
    for kg in steps(_KG, 5):
        for name, one in cells.items():
            i += 1
            read = one.read(np.array([kg * G]), rng)[0]
            lines.append(f'loadcell,"cell={name},host=rpi4",{1710237600_000_000_000 + i * 10**8},'
                         f"{kg:g},{read:.0f}")  # fmt: skip
    return Made([write(to / "influx.csv", lines)], truth_of(cells, 50))


def nines_where_nothing(to: Path, rng: Rng) -> Made:
    """9999.99 and `-` where the logger had no value."""
    kg = steps((0, 5, 10, 20, 40), 6)
    one = Cell(510.0, -4.0, 2e-5)
    cells = [f"{v:.6f}" for v in one.read(kg * G, rng, whole=False)]
    cells[4] = cells[17] = "9999.99"
    cells[11] = "-"
    lines = ["Time,Load (kg),Bridge (mV/V)",
             *(f"{i},{k:g},{c}"
               for i, (k, c) in enumerate(zip(kg, cells, strict=True)))]  # fmt: skip
    return Made([write(to / "logger.csv", lines)], truth_of(one, 400))


def raw_and_tared(to: Path, rng: Rng) -> Made:
    """Raw counts, counts less the empty ones, and grams by somebody's factor."""
    one, kg, read = _stairs(rng)
    net = read - read[:6].mean()
    lines = ["load_g,raw,raw_minus_tare,calc_g",
             *rows(1e3 * kg, read, net.round(),
                   (net * one.scale / G * 1e3 * 1.03).round(1))]  # fmt: skip
    return Made([write(to / "sheet.csv", lines)], truth_of(one, 50))


def arduino_sentence_celsius(to: Path, rng: Rng) -> Made:
    """Arduino: `Load: 500 g | Raw: -123456 | Temp: 23.4 C`, the monitor's arrows before it."""
    one, kg, read = _stairs(rng, 8)
    warm = 22.0 + 0.002 * rng.normal(0, 1, kg.size).cumsum()
    lines = ["Setup done. Tare OK"]
    lines += [f"10:02:{i % 60:02d}.{137 + i} -> Load: {1e3 * k:.0f} g | Raw: {c:.0f} | "
              f"Temp: {w:.2f} °C"
              for i, (k, c, w) in enumerate(zip(kg, read, warm, strict=True))]  # fmt: skip
    return Made([write(to / "putty.log", lines)], truth_of(one, 50))


def opensignals_text(to: Path, rng: Rng) -> Made:
    """biosignalsplux: a line of JSON in the head, a counter, a digital line, one channel."""
    load = settling([0, 20, 50, 100, 0], 4, 100)
    one = Cell(0.0122, -402.0, 3.0)
    head = {"00:07:80:46:E0:5A": {"sensor": ["LOADCELL"], "device": "biosignalsplux", "column":
            ["nSeq", "DI", "CH1"], "time": "10:2:11.330", "sampling rate": 100,
            "resolution": [4, 1, 16], "channels": [1], "date": "2024-3-12"}}  # fmt: skip
    body = [f"{i % 16}\t0\t{c:.0f}\t" for i, c in enumerate(one.read(load, rng))]
    lines = ["# OpenSignals Text File Format. Version 1", f"# {json.dumps(head)}", "# EndOfHeader"]
    return Made([write(to / "opensignals.txt", [*lines, *body])], says="loads")


def keysight_second_volt(to: Path, rng: Rng) -> Made:
    """A scope's export: `x-axis,1,2`, `second,Volt,Volt`; neither channel is a load."""
    t = np.arange(600) / 20
    body = [f"{s:+.5E},{a:+.4E},{b:+.4E}" for s, a, b in zip(
        t, np.sin(t) + rng.normal(0, 0.01, 600), 0.2 * np.sin(t) + rng.normal(0, 0.01, 600),
        strict=True)]  # fmt: skip
    return Made([write(to / "scope_0.csv", ["x-axis,1,2", "second,Volt,Volt", *body])], says="load")


def grams_called_kilograms(to: Path, rng: Rng) -> Made:
    """A column called kg whose numbers are grams: the remark above lists what was put on."""
    _, kg, read = _stairs(rng)
    lines = ["# weights put on: 0, 500 g, 1 kg, 2 kg, 5 kg", "load_kg,counts",
             *rows(1e3 * kg, read)]  # fmt: skip
    return Made([write(to / "bench.csv", lines)], says="unit of the load")


def newtons_called_kilonewtons(to: Path, rng: Rng) -> Made:
    """A press called kN in the header, newtons in its numbers, as the remark above says."""
    _, t, ref, read = _press(rng)
    lines = ["# range of the press: 1000 N", "t [s],Force [kN],Bridge [mV/V]",
             *rows(t, ref, read, form="%.6f")]  # fmt: skip
    return Made([write(to / "press.csv", lines)], says="unit of the load")


def rinstrum_lines(to: Path, rng: Rng) -> Made:
    """An indicator's print-outs under weights that were written by hand before each line."""
    one = Cell(1.021 * G, -0.4 * G, 0.002)
    lines = []
    for kg in _KG:
        lines.append(f"--- {kg:g} kg ---")
        for c in one.read(np.full(4, kg * G), rng, whole=False):
            lines.append(f"00{len(lines):04d} 12/03/2024 10:{len(lines):02d}:11  G {c:8.4f} kg")
    newton = Cell(one.scale / G, one.bias, 0.02)
    return Made([write(to / "indicator.txt", lines)], truth_of(newton, 50))


def danish_clock(to: Path, rng: Rng) -> Made:
    """Danish: `kl. 10.02`, `Belastning [kg]`, `Aflæsning`."""
    one, kg, read = _stairs(rng)
    body = [f"kl. 10.{2 + i:02d};{k:g};{c:.0f}".replace(".5;", ",5;")
            for i, (k, c) in enumerate(zip(kg, read, strict=True))]  # fmt: skip
    return Made([write(to / "måling.csv", ["Tid;Belastning [kg];Aflæsning", *body], "latin-1")],
                truth_of(one, 50))  # fmt: skip


def ukrainian_utf16(to: Path, rng: Rng) -> Made:
    """Excel's Unicode text in Ukrainian: grams and the converter."""
    one, kg, read = _stairs(rng)
    return Made([write(to / "калібрування.txt", ["Вага, г\tАЦП", *rows(1e3 * kg, read, sep="\t")],
                       "utf-16", "\r\n")], truth_of(one, 50))  # fmt: skip


def interface_certificate(to: Path, rng: Rng) -> Made:
    """A certificate: test load in lbf, three runs, their average and its deviation from a line."""
    lbf = np.array([0.0, 20, 40, 60, 80, 100, 40, 0])
    one = Cell(110.0, -0.4, 3e-5)
    lines = [
        "Interface Advanced Force Measurement,,,,,",
        "Serial,445871,Capacity,100 lbf,,",
        "Test Load (lbf),Run 1 (mV/V),Run 2 (mV/V),Run 3 (mV/V),Average (mV/V),Dev (%FS)",
    ]
    for f in lbf:
        runs = one.read(np.full(3, f * _LB * G), rng, whole=False)
        lines.append(f"{f:g},{','.join(f'{v:.5f}' for v in runs)},{runs.mean():.5f},"
                     f"{rng.normal(0, 0.01):.3f}")  # fmt: skip
    return Made([write(to / "cert.csv", lines)], truth_of(one, 445))


def two_time_columns_and_noon(to: Path, rng: Rng) -> Made:
    """A PC's 12-hour clock over noon and a board's milliseconds that start again."""
    one, kg, read = _stairs(rng, 24)
    lines = ["PC time,board_ms,load [kg],adc"]
    for i, (k, c) in enumerate(zip(kg, read, strict=True)):
        s = 59 * 60 + 30 + i
        hour = 12 if s >= 3600 else 11
        ms = 1000 * i + 417 if i < 70 else 1000 * (i - 70) + 12
        lines.append(f"{hour}:{s // 60 % 60:02d}:{s % 60:02d} {'PM' if hour == 12 else 'AM'},"
                     f"{ms},{k:g},{c:.0f}")  # fmt: skip
    return Made([write(to / "noon.csv", lines)], truth_of(one, 50))


def swept_in_one_line_each(to: Path, rng: Rng) -> Made:
    """JSON lines: a load as `{"value": 500, "unit": "g"}`, the channel nested below it."""
    one, kg, read = _stairs(rng)
    lines = [json.dumps({"ts": f"2024-03-12T10:00:{i:02d}Z",
                         "load": {"value": 1e3 * k, "unit": "g"}, "adc": {"ch0": {"raw": int(c)}}})
             for i, (k, c) in enumerate(zip(kg, read, strict=True))]  # fmt: skip
    return Made([write(to / "run.jsonl", lines)], truth_of(one, 50))


def labview_seconds_1904(to: Path, rng: Rng) -> Made:
    """LabVIEW's spreadsheet text: seconds since 1904, no names, load in newtons and mV/V."""
    one, t, ref, read = _press(rng)
    body = _comma(rows(3_793_082_531.0 + t, ref, read, sep="\t", form="%.6f"))
    head = ["Tid\tF ref (N)\tBrygga (mV/V)"]
    return Made([write(to / "logg.txt", [*head, *body], "latin-1")], truth_of(one, 800))


def means_and_counts_by_load(to: Path, rng: Rng) -> Made:
    """SPSS: `N`, `Mean`, `Std. Deviation`, `Std. Error` for each load, a total at the end."""
    one, lines = cell(rng), ["Load_N\tN\tMean\tStd. Deviation\tStd. Error Mean"]
    every = []
    for f in (0, 10, 20, 50):
        read = one.read(np.full(25, float(f)), rng)
        every += list(read)
        lines.append(f"{f}\t25\t{read.mean():.2f}\t{read.std(ddof=1):.3f}\t"
                     f"{read.std(ddof=1) / 5:.4f}")  # fmt: skip
    lines.append(f"Total\t100\t{np.mean(every):.2f}\t{np.std(every):.3f}\t{np.std(every) / 10:.4f}")
    return Made([write(to / "spss.txt", lines)], truth_of(one, 50))


TWENTY_EIGHTH_BENCH = (
    dasylab_header, catman_channel_comments, daq_block_above, matlab_mangled_names,
    pandas_two_levels, thin_spaces, starred_outlier, si_suffixes, telegraf_tags_in_a_cell,
    nines_where_nothing, raw_and_tared, arduino_sentence_celsius, opensignals_text,
    keysight_second_volt, grams_called_kilograms, newtons_called_kilonewtons, rinstrum_lines,
    danish_clock, ukrainian_utf16, interface_certificate, two_time_columns_and_noon,
    swept_in_one_line_each, labview_seconds_1904, means_and_counts_by_load,
)  # fmt: skip
