"""Weights and presses with what instruments and people add to them, each with its truth.

Written before it was run; `docs/bring_your_log.md` has its first count.
"""

from __future__ import annotations

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


def lvm_segments(to: Path, rng: Rng) -> Made:
    """LabVIEW's measurement file, a segment with a header of its own each time it was started."""
    one, load = Cell(980.0, -5.0, 2e-5), [0, 200, 400, 800]
    lines = ["LabVIEW Measurement", "Writer_Version\t2", "Reader_Version\t2", "Separator\tTab",
             "Decimal_Separator\t.", "Multi_Headings\tYes", "X_Columns\tOne",
             "Time_Pref\tRelative", "Date\t2024/03/12", "Time\t10:00:00.5",
             "***End_of_Header***", "\t"]  # fmt: skip
    for f in load:
        ref = np.full(30, float(f)) + rng.normal(0, 0.2, 30)
        lines += ["Channels\t2", "Samples\t30\t30", "Date\t2024/03/12\t2024/03/12",
                  "Time\t10:00:01\t10:00:01", "Y_Unit_Label\tN\tmV/V", "X_Dimension\tTime\tTime",
                  "X0\t0.0\t0.0", "Delta_X\t0.05\t0.05", "***End_of_Header***",
                  "X_Value\tReference\tCell\tComment"]  # fmt: skip
        lines += [f"{x}\t" for x in rows(np.arange(30) / 20, ref,
                                         one.read(np.full(30, float(f)), rng, whole=False),
                                         sep="\t", form="%.6f")]  # fmt: skip
        lines.append("")
    return Made([write(to / "press.lvm", lines)], truth_of(one, 800))


def ni_waveforms(to: Path, rng: Rng) -> Made:
    """LabVIEW's "export waveforms": t0 and delta t above, a clock before each signal."""
    one, t, ref, read = _press(rng)
    stamp = [f"12.03.2024 10:00:{x:09.6f}" for x in t]
    lines = ["waveform\t[0]\t\t[1]\t", "t0\t12.03.2024 10:00:00.000000\t\t"
             "12.03.2024 10:00:00.000000\t", "delta t\t0.050000\t\t0.050000\t", "",
             "time\tReference (N)\ttime\tBridge (mV/V)"]  # fmt: skip
    lines += [f"{s}\t{r:.4f}\t{s}\t{c:.6f}" for s, r, c in zip(stamp, ref, read, strict=True)]
    return Made([write(to / "waveforms.txt", lines)], truth_of(one, 800))


def diadem_extremes(to: Path, rng: Rng) -> Made:
    """DIAdem's CSV: properties of each channel in rows above, smallest and largest among them."""
    one, t, ref, read = _press(rng)
    columns = (t, ref, read)
    lines = ["Name;Time;Reference;Cell", "Unit;s;N;mV/V", "Datatype;DT_DOUBLE;DT_DOUBLE;DT_DOUBLE",
             f"Length;{t.size};{t.size};{t.size}",
             "Minimum;" + ";".join(f"{c.min():.6f}" for c in columns),
             "Maximum;" + ";".join(f"{c.max():.6f}" for c in columns)]  # fmt: skip
    lines += [f";{x}" for x in rows(*columns, sep=";", form="%.6f")]
    return Made([write(to / "diadem.csv", [x.replace(".", ",") for x in lines])],
                truth_of(one, 800))  # fmt: skip


def tare_between(to: Path, rng: Rng) -> Made:
    """A sketch that prints raw counts; its tare, half-way, moves nothing that it prints."""
    one, lines = cell(rng), ["HX711 ready"]
    for k, kg in enumerate((0, 0.5, 1, 0, 2, 5)):
        if k == 3:
            lines += ["10:02:00.004 -> Taring, please wait...", "10:02:02.120 -> Tare done"]
        lines.append(f"10:0{k}:10.001 -> weight: {kg:g} kg")
        lines += [f"10:0{k}:{11 + j}.125 -> HX711 raw = {c:.0f}"
                  for j, c in enumerate(one.read(np.full(15, kg * G), rng))]  # fmt: skip
    return Made([write(to / "monitor.txt", lines)], truth_of(one, 50))


def runs_of_other_columns(to: Path, rng: Rng) -> Made:
    """Two runs in a file, each below its name; the second has its columns the other way round."""
    one, lines = cell(rng), ["Run 1", "load_kg,raw"]
    kg = steps(_KG, 3)
    lines += rows(kg, one.read(kg * G, rng))
    lines += ["", "Run 2", "raw,load_kg", *rows(one.read(kg * G, rng), kg)]
    return Made([write(to / "runs.csv", lines)], truth_of(one, 50))


def subtotals(to: Path, rng: Rng) -> Made:
    """Excel's subtotals: a line of averages below each load, one of all below the last."""
    one, lines, every = cell(rng), ["Load (g),Reading"], []
    for kg in _KG:
        read = one.read(np.full(4, kg * G), rng)
        every.append(read)
        lines += [f'"{1e3 * kg:,.0f}","{c:,.0f}"' for c in read]
        lines.append(f'"{1e3 * kg:,.0f} Average","{read.mean():,.0f}"')
    lines.append(f'Grand Average,"{np.mean(every):,.0f}"')
    return Made([write(to / "book.csv", lines, end="\r\n")], truth_of(one, 50))


def totals_below(to: Path, rng: Rng) -> Made:
    """A sheet that sums its columns in the last line."""
    one, kg = cell(rng), steps(_KG, 3)
    read = one.read(kg * G, rng)
    lines = ["Date,Load [kg],Counts", *(f"2024-03-12,{x}" for x in rows(kg, read))]
    lines.append(f"Total,{kg.sum():g},{read.sum():.0f}")
    return Made([write(to / "sums.csv", lines)], truth_of(one, 50))


def swedish(to: Path, rng: Rng) -> Made:
    """A sheet in Swedish, decimal commas, narrow blanks between thousands."""
    one, kg = cell(rng), steps(_KG, 4)
    read = one.read(kg * G, rng)
    lines = ["Belastning (kg);Avläst värde", *(f"{k:.1f};{c:,.0f}".replace(".", ";").replace(
        ",", "\u00a0").replace(";", ",", 1) for k, c in zip(kg, read, strict=True))]  # fmt: skip
    return Made([write(to / "mätning.csv", lines)], truth_of(one, 50))


def three_words_for_nothing(to: Path, rng: Rng) -> Made:
    """``---`` where the meter was off, ``OVL`` above its range, ``#N/A`` from a formula."""
    one, kg = cell(rng), steps((*_KG, 10), 6)
    read = [f"{c:.0f}" for c in one.read(kg * G, rng)]
    read[2], read[9], read[16] = "---", "#N/A", "---"
    read[-6:] = ["OVL"] * 6
    lines = ["Mass [kg];Display", *(f"{k:g};{c}" for k, c in zip(kg, read, strict=True))]
    return Made([write(to / "meter.csv", lines)], truth_of(one, 50))


def hex_through_zero(to: Path, rng: Rng) -> Made:
    """Counts as 32 bits in hexadecimal, two's complement; unloaded they are below zero."""
    one, kg = Cell(4.2e-4, 4.2e-4 * 30_000, 12.0), steps(_KG, 5)
    read = one.read(kg * G, rng).astype(np.int64) & 0xFFFFFFFF
    lines = ["load_kg,raw", *(f"{k:g},0x{c:08X}" for k, c in zip(kg, read, strict=True))]
    return Made([write(to / "hex.csv", lines)], truth_of(one, 50))


def plates_times(to: Path, rng: Rng) -> Made:
    """Loads as they were stacked: ``2x5kg``, ``5kg+2x1kg``, ``-``."""
    one = cell(rng)
    lines = ["stack,adc"]
    for word, kg in (("-", 0), ("1kg", 1), ("2x1kg", 2), ("5kg", 5), ("5kg+2x1kg", 7),
                     ("2x5kg", 10), ("5kg", 5), ("-", 0)):  # fmt: skip
        lines += [f"{word},{c:.0f}" for c in one.read(np.full(3, kg * G), rng)]
    return Made([write(to / "stack.csv", lines)], truth_of(one, 100))


def pounds_in_file_names(to: Path, rng: Rng) -> Made:
    """A file per weight and cell: ``toe_2.5lb_a.csv``, as Windows numbers copies of it."""
    cells, paths = {"toe": cell(rng), "heel": cell(rng)}, []
    for name, one in cells.items():
        for lb in (0, 2.5, 5, 10):
            body = [f"{i},{c:.0f}" for i, c in enumerate(one.read(np.full(20, lb * _LB * G), rng))]
            text = f"{lb:g}".replace(".", "p")
            paths.append(write(to / f"{name}_{text}lb (1).csv", ["n,adc", *body]))
    return Made(paths, truth_of(cells, 50))


def pulled_and_pushed(to: Path, rng: Rng) -> Made:
    """A cell that is pulled and pushed: tension positive, both sides through zero."""
    one, load = Cell(-410.0, 8.0, 2e-5), steps((0, 100, 200, 0, -100, -200, 0), 5)
    lines = ["Force (N) + tension / - compression,Output (mV/V)",
             *rows(load, one.read(load, rng, whole=False), form="%.6f")]  # fmt: skip
    return Made([write(to / "both_ways.csv", lines)], truth_of(one, 200))


def writematrix(to: Path, rng: Rng) -> Made:
    """MATLAB's writematrix: three columns without names, the load in no unit."""
    one, load = cell(rng, "volt"), steps((0, 10, 20, 30, 10, 0), 40)
    body = rows(np.arange(load.size) / 10, load, one.read(load, rng, False), form="%.15g")
    return Made([write(to / "calib.csv", body)], says="unit of the load")


def two_columns_called_force(to: Path, rng: Rng) -> Made:
    """The same name over the reference and the cell; the row of units tells them apart."""
    one, t, ref, read = _press(rng)
    lines = ["Time,Force,Force", "(s),(N),(mV/V)", *rows(t, ref, read, form="%.6f")]
    return Made([write(to / "dup.csv", lines)], truth_of(one, 800))


def wavematrix(to: Path, rng: Rng) -> Made:
    """Instron's WaveMatrix: cycles counted twice, kilonewtons, a second transducer in mV/V."""
    one, t, ref, read = _press(rng)
    cycle = np.floor(t / 4)
    names = ("Total Time (s)", "Cycle Elapsed Time (s)", "Total Cycles", "Elapsed Cycles", "Step",
             "Total Cycle Count(Linear Waveform)", "Position(Linear:Position) (mm)",
             "Load(Linear:Load) (kN)", "Strain 1(mV/V) (mV/V)")  # fmt: skip
    body = rows(t, t % 4, cycle, cycle % 2, cycle // 3 + 1, cycle, ref / 5e3, ref / 1e3, read,
                form="%.7g")  # fmt: skip
    return Made([write(to / "Test1.steps.tracking.csv", [",".join(f'"{x}"' for x in names),
                                                         *body])], truth_of(one, 800))  # fmt: skip


def autoranging(to: Path, rng: Rng) -> Made:
    """A meter that changes its range: ``352.1 µV`` and ``4.213 mV`` in one column."""
    one = Cell(12_000.0, -3.0, 3e-7)
    lines = ["Load [N];Reading"]
    for f in (0, 5, 10, 20, 50, 100, 50, 10, 0):
        for c in one.read(np.full(3, float(f)), rng, whole=False):
            text = f"{c * 1e6:.1f} µV" if abs(c) < 1e-3 else f"{c * 1e3:.4f} mV"
            lines.append(f"{f};{text}")
    return Made([write(to / "dmm.csv", lines)],
                truth_of(Cell(one.scale * 1e-3, one.bias, 0), 100))  # fmt: skip


def keithley_buffer(to: Path, rng: Rng) -> Made:
    """A 2700's reading as it comes over the bus, a file for each weight."""
    one, paths = Cell(21.0, -7.0, 1e-3), []
    for kg in _KG:
        lines = [f"{c:+.8E}VDC,{0.1 * i:+.3f}SECS,{i:+06d}RDNG#"
                 for i, c in enumerate(one.read(np.full(25, kg * G), rng, False))]  # fmt: skip
        paths.append(write(to / f"{kg:g}kg.txt", lines))
    return Made(paths, truth_of(one, 50))


def alarms_beside(to: Path, rng: Rng) -> Made:
    """BenchLink's scans: a column of alarms behind each channel, the date in front."""
    one, t, ref, read = _press(rng)
    lines = ["Name:,press", "Owner:,lab", "", "Scan,Time,101 <Ref> (N),Alarm 101,102 <Cell> (VDC),"
             "Alarm 102"]  # fmt: skip
    lines += [f"{i + 1},12/03/2024 10:00:{t[i]:06.3f},{ref[i]:.4f},0,{read[i]:.6f},0"
              for i in range(t.size)]  # fmt: skip
    return Made([write(to / "scan.csv", lines, "utf-16")], truth_of(one, 800))


def underscored(to: Path, rng: Rng) -> Made:
    """Counts as programmers write them: 8_223_570."""
    one, kg = cell(rng), steps(_KG, 3)
    lines = ["kg,raw", *(f"{k:g},{int(c):_d}" for k, c in zip(kg, one.read(kg * G, rng),
                                                             strict=True))]  # fmt: skip
    return Made([write(to / "raw.csv", lines)], truth_of(one, 50))


def broken_header_cells(to: Path, rng: Rng) -> Made:
    """Line breaks inside the quoted names, as Excel has them."""
    one, kg = cell(rng), steps(_KG, 4)
    text = '"Load\n[kg]","Reading\nADC\n(counts)","Note"\n'
    text += "\n".join(f"{x}," for x in rows(kg, one.read(kg * G, rng))) + "\n"
    path = to / "sheet.csv"
    path.write_text(text, encoding="utf-8")
    return Made([path], truth_of(one, 50))


def merged_loads(to: Path, rng: Rng) -> Made:
    """Merged cells: the load stands in the first row of its readings only."""
    one, lines = cell(rng), ["Load [kg],Trial,Counts"]
    for kg in (*_KG, *_KG[::-1][1:]):
        lines += [f"{f'{kg:g}' if i == 0 else ''},{i + 1},{c:.0f}"
                  for i, c in enumerate(one.read(np.full(4, kg * G), rng))]  # fmt: skip
    return Made([write(to / "merged.csv", lines)], truth_of(one, 50))


def said_afterwards(to: Path, rng: Rng) -> Made:
    """What lay on the cell is noted below its readings, not above."""
    one, lines = cell(rng), []
    for kg in _KG:
        lines += [f"{c:.0f}" for c in one.read(np.full(10, kg * G), rng)]
        lines.append(f"# ^ that was {kg:g} kg")
    return Made([write(to / "after.txt", lines)], says="above its readings")


def target_and_actual(to: Path, rng: Rng) -> Made:
    """``Soll`` and ``Ist``: what the press was set to and what it reached, three per cent below."""
    one, target = Cell(980.0, -5.0, 2e-5), steps((0, 200, 400, 600, 800), 4)
    actual = 0.97 * target + rng.normal(0, 1, target.size)
    read = one.read(actual, rng, whole=False)
    body = rows(target, actual, read, sep=";", form="%.6f")
    lines = ["Sollkraft [N];Istkraft [N];Signal [mV/V]", *(x.replace(".", ",") for x in body)]
    return Made([write(to / "stufen.csv", lines, "latin-1")], truth_of(one, 800))


def shunt_first(to: Path, rng: Rng) -> Made:
    """A shunt resistor was checked before the weights; its row is in the table."""
    one = cell(rng)
    lines = ["Load,Counts", f"shunt 100k,{one.read(np.array(33.0), rng):.0f}"]
    for kg in (*_KG, *_KG[::-1]):
        lines.append(f"{kg:g} kg,{one.read(np.array(kg * G), rng):.0f}")
    return Made([write(to / "checked.csv", lines)], truth_of(one, 50))


def preloads(to: Path, rng: Rng) -> Made:
    """ISO 376: three preloads, two series up, one down, each in a column; kilonewtons."""
    one = Cell(500_000.0, 120.0, 1e-6)
    lines = ["Force step (kN),Preload 1 (mV/V),X1 (mV/V),X2 (mV/V),X3 up (mV/V),X3 down (mV/V)"]
    for kn in (0, 100, 200, 300, 400, 500):
        read = one.read(np.full(5, kn * 1e3), rng, whole=False)
        first = f"{read[0]:.6f}" if kn in (0, 500) else ""
        lines.append(f"{kn},{first}," + ",".join(f"{v:.6f}" for v in read[1:]))
    cells = dict.fromkeys(("x_1", "x_2", "x_3_up", "x_3_down"), one)
    return Made([write(to / "iso376.csv", lines)], truth_of(cells, 500_000))


def across_midnight(to: Path, rng: Rng) -> Made:
    """Times of day without a date, and midnight between the second weight and the third."""
    one, lines, at = cell(rng), ["time,load_kg,raw"], 86400 - 21.0
    for kg in _KG:
        for c in one.read(np.full(10, kg * G), rng):
            s = at % 86400
            lines.append(
                f"{int(s // 3600):02d}:{int(s // 60 % 60):02d}:{s % 60:06.3f},{kg:g},{c:.0f}"
            )
            at += 1
    return Made([write(to / "night.csv", lines)], truth_of(one, 50))


TWENTY_FOURTH_BENCH = (
    lvm_segments, ni_waveforms, diadem_extremes, tare_between, runs_of_other_columns, subtotals,
    totals_below, swedish, three_words_for_nothing, hex_through_zero, plates_times,
    pounds_in_file_names, pulled_and_pushed, writematrix, two_columns_called_force, wavematrix,
    autoranging, keithley_buffer, alarms_beside, underscored, broken_header_cells, merged_loads,
    said_afterwards, target_and_actual, shunt_first, preloads, across_midnight,
)  # fmt: skip
