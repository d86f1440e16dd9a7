"""Logs as laboratories keep them, VI: benches of single cells.

Written before it was run; `docs/bring_your_log.md` has its first count.
"""

from __future__ import annotations

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
    steps,
    truth_of,
    write,
)


def lvm_with_comment(to: Path, rng: Rng) -> Made:
    """LabVIEW's measurement file with a Comment column at the end, newtons against volts."""
    one = Cell(21.0, -0.8, 5e-4)
    load = settling([0, 20, 60, 100, 60, 0], 3, 20)
    head = ["LabVIEW Measurement\t", "Writer_Version\t2", "Reader_Version\t2", "Separator\tTab",
            "Decimal_Separator\t,", "Multi_Headings\tNo", "X_Columns\tOne", "Time_Pref\tRelative",
            "Operator\tMeier", "Date\t2024/03/12", "Time\t10:12:33,125", "***End_of_Header***\t",
            "\t", "Channels\t2\t\t", "Samples\t1\t1\t", "Date\t2024/03/12\t2024/03/12\t",
            "Y_Unit_Label\tN\tV\t", "X_Dimension\tTime\tTime\t", "X0\t0\t0\t",
            "Delta_X\t0,05\t0,05\t", "***End_of_Header***\t\t\t",
            "X_Value\tReferenz\tDMS\tComment"]  # fmt: skip
    body = [x.replace(".", ",") + "\t" for x in
            rows(np.arange(load.size) / 20, load + rng.normal(0, 0.02, load.size),
                 one.read(load, rng, whole=False), sep="\t", form="%.6f")]  # fmt: skip
    return Made([write(to / "Messung_001.lvm", [*head, *body], "latin-1", "\r\n")],
                truth_of(one, 100))  # fmt: skip


def diadem_export(to: Path, rng: Rng) -> Made:
    """DIAdem's ASCII: names, units and lengths of channels in rows above."""
    one, load = Cell(105.0, 3.0, 4e-4), steps((0, 50, 100, 200, 100, 0), 12)
    head = ["Zeit;Kraft_Referenz;Spannung", "s;N;mV/V",
            f"{load.size};{load.size};{load.size}"]  # fmt: skip
    body = [x.replace(".", ",") for x in
            rows(np.arange(load.size) / 10, load, one.read(load, rng, whole=False), sep=";",
                 form="%.5f")]  # fmt: skip
    return Made([write(to / "DIAdem.csv", [*head, *body], "cp1252", "\r\n")], truth_of(one, 200))


def excel_two_tables_side_by_side(to: Path, rng: Rng) -> Made:
    """Two cells' tables beside each other with an empty column between them."""
    left, right = cell(rng), cell(rng)
    kg = steps((0, 0.5, 1, 2), 4)
    a, b = left.read(kg * G, rng), right.read(kg * G, rng)
    head = ["Zelle 1;;;Zelle 2;", "Masse [kg];Rohwert;;Masse [kg];Rohwert"]
    body = [f"{k:g};{x:.0f};;{k:g};{y:.0f}".replace(".", ",")
            for k, x, y in zip(kg, a, b, strict=True)]  # fmt: skip
    return Made([write(to / "zellen.csv", [*head, *body])],
                truth_of({"cell_1": left, "cell_2": right}))  # fmt: skip


def matlab_writetable(to: Path, rng: Rng) -> Made:
    """`writetable` of a table with a string column and NaN where the sensor was off."""
    one, kg = cell(rng), steps((0, 1, 2, 5), 6)
    body = ["Trial,Mass_kg,ADC,Note"]
    for i, (k, c) in enumerate(zip(kg, one.read(kg * G, rng), strict=True)):
        body.append(f"{i + 1},{k:g},{'NaN' if i % 9 == 4 else format(c, '.0f')},'ok'")
    return Made([write(to / "calTable.csv", body)], truth_of(one))


def minus_9999(to: Path, rng: Rng) -> Made:
    """A logger that writes -9999 where it had no reading."""
    one, newton = cell(rng), steps((0, 5, 10, 20), 12)
    body = ["TIMESTAMP,RECORD,Load_N,Cell_Raw"]
    for i, (f, c) in enumerate(zip(newton, one.read(newton, rng), strict=True)):
        value = "-9999" if i % 11 == 7 else f"{c:.0f}"
        body.append(f'"2024-03-12 10:{i // 60:02d}:{i % 60:02d}",{i},{f:g},{value}')
    return Made([write(to / "CR1000.dat", body)], truth_of(one))


def na_of_excel(to: Path, rng: Rng) -> Made:
    """`#N/A` and `#DIV/0!` where formulas failed; a computed column beside."""
    one, grams = Cell(4.6e-4, -45.0, 12.0), steps((0, 100, 500, 1000, 2000), 4)
    body = ["Weight (g),Reading,Reading/Weight,Remarks"]
    for i, (g, c) in enumerate(zip(grams, one.read(grams * 1e-3 * G, rng), strict=True)):
        ratio = "#DIV/0!" if g == 0 else f"{c / g:.3f}"
        body.append(f"{g:g},{'#N/A' if i == 9 else format(c, '.0f')},{ratio},")
    return Made([write(to / "Book1.csv", body)], truth_of(one))


def restarted_with_comments(to: Path, rng: Rng) -> Made:
    """A microcontroller that restarts: header again, time from zero again, chatter between."""
    one, lines = cell(rng), []
    for run_no, loads in enumerate(((0, 500, 1000), (2000, 1000, 0))):
        lines += ["ets Jul 29 2019 12:21:46", "rst:0x1 (POWERON_RESET),boot:0x13", "HX711 ready",
                  "ms,weight_g,raw"]  # fmt: skip
        for i, g in enumerate(steps(loads, 10)):
            c = float(one.read(np.asarray(g * 1e-3 * G), rng))
            lines.append(f"{1000 + 100 * i + run_no},{g:g},{c:.0f}")
    return Made([write(to / "COM5.log", lines)], truth_of(one))


def up_and_down_files(to: Path, rng: Rng) -> Made:
    """Weights up and down, a file for each: `up_1kg.csv`, `down_1kg.csv`; no time."""
    one, paths = cell(rng), []
    for way, loads in (("up", (0, 1, 2, 5)), ("down", (5, 2, 1, 0))):
        for k in loads:
            read = one.read(np.full(25, k * G), rng)
            paths.append(write(to / f"{way}_{k}kg.csv", ["raw", *(f"{c:.0f}" for c in read)]))
    return Made(paths, truth_of(one))


def thousands_french(to: Path, rng: Rng) -> Made:
    """French: narrow blanks between thousands, decimal commas, `Masse (g)`; trailing semicolons."""
    one, grams = cell(rng), steps((0, 500, 1000, 2500), 5)
    body = ["N° essai;Masse (g);Lecture brute;"]
    for i, (g, c) in enumerate(zip(grams, one.read(grams * 1e-3 * G, rng), strict=True)):
        mass = f"{g:,.1f}".replace(",", "\u202f").replace(".", ",")
        count = f"{c:,.0f}".replace(",", "\u202f")
        body.append(f"{i + 1};{mass};{count};")
    return Made([write(to / "étalonnage.csv", body)], truth_of(one))


def japanese_bench_with_time(to: Path, rng: Rng) -> Made:
    """A Japanese logger: lines of settings above, units in a row of their own, volts."""
    one, newton = Cell(21.0, -1.0, 5e-4), steps((0, 10, 20, 50), 15)
    head = ["タイトル,荷重試験", "測定日,2024/3/12", "サンプリング周期,100ms", "",
            "時間,荷重,電圧", "s,N,V"]  # fmt: skip
    body = rows(np.arange(newton.size) / 10, newton, one.read(newton, rng, whole=False),
                form="%.5f")  # fmt: skip
    return Made([write(to / "データ.csv", [*head, *body], "shift_jis", "\r\n")], truth_of(one, 50))


def dewesoft_decimal(to: Path, rng: Rng) -> Made:
    """Dewesoft: data rows under `Data1` names with unit in brackets, semicolon, comma."""
    one, load = Cell(250.0, 12.0, 3e-4), settling([0, 100, 200, 400, 0], 3, 20)
    head = ["Start time;12.03.2024 10:12:33,125", "Sample rate;20", "Number of channels;2", "",
            "Time (s);Ref_Kraft (N);DMS_1 (mV/V)"]  # fmt: skip
    body = [x.replace(".", ",") for x in
            rows(np.arange(load.size) / 20, load + rng.normal(0, 0.05, load.size),
                 one.read(load, rng, whole=False), sep=";", form="%.6f")]  # fmt: skip
    return Made([write(to / "Dewesoft_0001.csv", [*head, *body])], truth_of(one, 400))


def loads_in_their_own_table(to: Path, rng: Rng) -> Made:
    """A stream with times, and a sheet that says from when to when which mass lay on."""
    one, kg = cell(rng), (0.0, 1.0, 2.0, 5.0)
    t = np.arange(len(kg) * 100) / 10
    body = ["time_s,raw", *rows(t, one.read(np.repeat(kg, 100) * G, rng))]
    plan = ["start_s,end_s,mass_kg",
            *(f"{10 * i + 1:g},{10 * i + 9:g},{k:g}" for i, k in enumerate(kg))]  # fmt: skip
    return Made([write(to / "stream.csv", body), write(to / "plan.csv", plan)], truth_of(one))


def crane_scale_ctc(to: Path, rng: Rng) -> Made:
    """Four cells, each loaded alone, in a file of its own: load and counts, German names."""
    cells = {k: cell(rng) for k in ("vl", "vr", "hl", "hr")}
    paths = []
    for name, one in cells.items():
        kg = np.repeat((0, 1, 2, 4, 2, 1, 0), 3).astype(float)
        body = ["Nr.;Gewicht in kg;Messwert", *rows(np.arange(kg.size), kg, one.read(kg * G, rng),
                                                    sep=";")]  # fmt: skip
        paths.append(write(to / f"Zelle_{name.upper()}.csv", body))
    return Made(paths, truth_of({k.upper(): one for k, one in cells.items()}))


def one_file_per_hole(to: Path, rng: Rng) -> Made:
    """A weight over holes of a foot plate, a file for each hole, the hole in the name."""
    corners = {"fl": (70, 40), "fr": (70, -40), "rl": (-50, 40), "rr": (-50, -40)}
    paths = []
    for x in (-40, 0, 40):
        for y in (-30, 0, 30):
            a, b = (x + 50) / 120, (y + 40) / 80
            share = np.array([a * b, a * (1 - b), (1 - a) * b, (1 - a) * (1 - b)]) * 20.0
            read = share / -3.4e-5 + 8.3e6 + rng.normal(0, 40, (20, 4))
            body = [",".join(corners), *rows(*np.round(read).T)]
            paths.append(write(to / f"hole_x{x}_y{y}.csv", body))
    return Made(paths, says="where the cells sit")


TENTH_BENCH = (
    lvm_with_comment, diadem_export, excel_two_tables_side_by_side, matlab_writetable, minus_9999,
    na_of_excel, restarted_with_comments, up_and_down_files, thousands_french,
    japanese_bench_with_time, dewesoft_decimal, loads_in_their_own_table, crane_scale_ctc,
    one_file_per_hole,
)  # fmt: skip
