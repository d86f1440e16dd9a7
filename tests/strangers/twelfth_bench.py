"""Logs as laboratories keep them, VIII: benches, as languages and instruments print their tables.

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


def r_write_csv(to: Path, rng: Rng) -> Made:
    """R's `write.csv`: everything quoted, row names under an empty name, `NA`."""
    cells, kg = {"toe": cell(rng), "heel": cell(rng)}, steps((0, 1, 2, 5), 6)
    read = [one.read(kg * G, rng) for one in cells.values()]
    lines = ['"","mass_kg","toe","heel"']
    for i, (k, a, b) in enumerate(zip(kg, *read, strict=True), 1):
        lines.append(f'"{i}",{k:g},{"NA" if i == 9 else f"{a:.0f}"},{b:.0f}')
    return Made([write(to / "calib.csv", lines)], truth_of(cells, 50))


def julia_shown(to: Path, rng: Rng) -> Made:
    """A data frame as Julia shows it: a rule of box characters, row numbers, types."""
    one, newton = cell(rng), steps((0, 10, 20, 50), 6)
    lines = ["24×2 DataFrame", " Row │ load_N   counts  ", "     │ Float64  Int64   ",
             "─────┼──────────────────"]  # fmt: skip
    lines += [
        f" {i:3d} │ {f:7.1f}  {c:.0f}"
        for i, (f, c) in enumerate(zip(newton, one.read(newton, rng), strict=True), 1)
    ]
    return Made([write(to / "repl.txt", lines)], truth_of(one, 50))


def stata_list(to: Path, rng: Rng) -> Made:
    """Stata's `list`: a box of dashes and bars, numbered rows, a rule after each five."""
    one, kg = cell(rng, "adc12"), steps((0, 0.5, 1, 2), 5)
    box, rule = "     +----------------+", "     |----------------|"
    lines = [". list mass_kg raw", "", box, "     | mass_kg    raw |", rule]
    for i, (k, c) in enumerate(zip(kg, one.read(kg * G, rng), strict=True), 1):
        lines.append(f"{i:3d}. | {k:7.1f}  {c:5.0f} |")
        if i % 5 == 0:
            lines.append(rule)
    return Made([write(to / "session.log", [*lines[:-1], box])], truth_of(one))


def psql_answer(to: Path, rng: Rng) -> Made:
    """The answer of a data base: bars between, a rule with crosses, the count of rows below."""
    one, grams = cell(rng), steps((0, 250, 500, 1000), 5)
    lines = [
        "          at            | grams |   raw",
        "------------------------+-------+---------",
    ]
    for i, (g, c) in enumerate(zip(grams, one.read(grams * 1e-3 * G, rng), strict=True)):
        lines.append(f" 2024-03-12 10:02:{i:02d}+01 | {g:5.0f} | {c:.0f}")
    return Made([write(to / "query.txt", [*lines, f"({grams.size} rows)", ""])], truth_of(one))


def fortran_exponents(to: Path, rng: Rng) -> Made:
    """Fortran's list output: `0.5000000D+01`, three blanks between, names in a comment."""
    one, newton = Cell(21.0, -0.7, 5e-4), steps((0, 10, 20, 50), 8)
    lines = ["# FORCE(N)   BRIDGE(V)"]
    for f, v in zip(newton, one.read(newton, rng, whole=False), strict=True):
        lines.append(f"   {f:.7E}   {v:.7E}".replace("E", "D"))
    return Made([write(to / "fort.21", lines)], truth_of(one, 50))


def latex_rows(to: Path, rng: Rng) -> Made:
    r"""A table of a report: `0.5 & 8223570 \\`."""
    one, kg = cell(rng), steps((0, 0.5, 1, 2, 5), 3)
    lines = [r"\begin{tabular}{rr}", r"\hline", r"Load (kg) & Reading \\", r"\hline"]
    lines += [rf"{k:g} & {c:.0f} \\" for k, c in zip(kg, one.read(kg * G, rng), strict=True)]
    return Made([write(to / "table.tex", [*lines, r"\hline", r"\end{tabular}"])],
                truth_of(one, 50))  # fmt: skip


def yaml_records(to: Path, rng: Rng) -> Made:
    """A list of records in YAML."""
    one, kg, lines = cell(rng), steps((0, 1, 2, 5), 4), ["cell: 7", "samples:"]
    for k, c in zip(kg, one.read(kg * G, rng), strict=True):
        lines += [f"  - load_kg: {k:g}", f"    raw: {c:.0f}"]
    return Made([write(to / "samples.yaml", lines)], truth_of(one, 50))


def xml_records(to: Path, rng: Rng) -> Made:
    """Records of a test stand as XML attributes."""
    one, newton = cell(rng, "adc12"), steps((0, 5, 10, 20), 6)
    lines = ['<?xml version="1.0" encoding="utf-8"?>', '<test cell="7">']
    lines += [
        f'  <sample t="{i / 10:.1f}" force_N="{f:g}" adc="{c:.0f}"/>'
        for i, (f, c) in enumerate(zip(newton, one.read(newton, rng), strict=True))
    ]
    return Made([write(to / "stand.xml", [*lines, "</test>"])], truth_of(one))


def sas_dots(to: Path, rng: Rng) -> Made:
    """SAS and Stata: a lone point where a value is missing, tabs."""
    cells, kg = {"c1": cell(rng, "adc12"), "c2": cell(rng, "adc12")}, steps((0, 1, 2, 3), 8)
    read = np.column_stack([one.read(kg * G, rng) for one in cells.values()])
    lines = ["obs\tmass_kg\tc1\tc2"]
    for i, (k, pair) in enumerate(zip(kg, read, strict=True)):
        a, b = ("." if rng.uniform() < 0.1 else f"{v:.0f}" for v in pair)
        lines.append(f"{i + 1}\t{k:g}\t{a}\t{b}")
    return Made(
        [write(to / "bench.txt", lines)],
        truth_of({f"c_{i}": one for i, one in enumerate(cells.values(), 1)}, 30),
    )


def gnuplot_blocks(to: Path, rng: Rng) -> Made:
    """Blocks for gnuplot: two empty lines between, the weight in the comment above each."""
    one, lines = cell(rng), ["# t[s] raw"]
    for k in (0.0, 1.0, 2.0, 5.0):
        lines += [f"# weight = {k:.1f} kg"]
        lines += [f"{i / 10:.1f} {c:.0f}" for i, c in enumerate(one.read(np.full(20, k * G), rng))]
        lines += ["", ""]
    return Made([write(to / "cell.dat", lines)], truth_of(one, 50))


def mts_station(to: Path, rng: Rng) -> Made:
    """MTS: station and time above, units in a row of their own, kN against mV."""
    one, load = Cell(250.0, -12.0, 2e-3), settling([0, 500, 1500, 3000, 1500, 0], 3, 20)
    head = ["MTS793|MPT|ENU|1|2|.|/|:|1|0|0|A", "", "Data Acquisition: Timed\t\t\tTime:\t12.4 Sec",
            "Station Name: bench.cfg", "Running Time\tAxial Count\tAxial Force\tDC Strain Cell",
            "Sec\tsegments\tkN\tmV"]  # fmt: skip
    body = rows(np.arange(load.size) / 20, np.ones(load.size),
                (load + rng.normal(0, 1, load.size)) / 1e3, one.read(load, rng, whole=False),
                sep="\t", form="%.6f")  # fmt: skip
    return Made([write(to / "specimen.dat", [*head, *body], "latin-1", "\r\n")],
                truth_of(one, 3000))  # fmt: skip


def keithley_buffer(to: Path, rng: Rng) -> Made:
    """A multimeter's buffer: the unit beside the reading, a file per weight."""
    one, paths = Cell(5.2e3, -3.1, 2e-7), []
    for kg in (0, 1, 2, 5):
        lines = [
            "Model,DMM6500",
            "Serial,04412",
            "",
            "Index,Reading,Unit,Range Digits,Disp Digits,Math,Date,Time,Fractional Seconds",
        ]
        for i, v in enumerate(one.read(np.full(25, kg * G), rng, whole=False), 1):
            lines.append(f"{i},{v:.8E},Volt DC,0,6.5,F,03/12/2024,10:{kg:02d}:{i // 10:02d},"
                         f"0.{i % 10}00000")  # fmt: skip
        paths.append(write(to / f"defbuffer1 {kg}kg.csv", lines))
    return Made(paths, truth_of(one, 50))


def labjack_channels(to: Path, rng: Rng) -> Made:
    """LJLogM: a time and a scaled channel `y0`, a file per weight in pounds."""
    one, paths = Cell(410.0, -6.0, 1e-5), []
    for lb in (0, 2, 5, 10):
        v = one.read(np.full(20, lb * 4.4482216152605), rng, whole=False)
        lines = ["Time\ty0", *rows(np.arange(20) / 5, v, sep="\t", form="%.7f")]
        paths.append(write(to / f"bridge_{lb}_lbs.dat", lines))
    return Made(paths, truth_of(one, 45))


def rostopic_int32(to: Path, rng: Rng) -> Made:
    """`rostopic echo -p` of a std_msgs/Int32: `%time,field.data`, a file per weight."""
    one, paths = cell(rng), []
    for grams in (0, 500, 1000, 2000):
        t = 1_700_000_000_000_000_000 + 12_500_000 * np.arange(40)
        read = one.read(np.full(40, grams * 1e-3 * G), rng)
        lines = ["%time,field.data", *(f"{a},{c:.0f}" for a, c in zip(t, read, strict=True))]
        paths.append(write(to / f"hx711_{grams}g.csv", lines))
    return Made(paths, truth_of(one))


def arrows_of_a_forum(to: Path, rng: Rng) -> Made:
    """A forum post: `500 g → 8395021`, three readings a weight."""
    one, lines = cell(rng), ["my readings so far:"]
    for g in (0, 100, 200, 500, 1000):
        lines += [f"{g} g → {c:.0f}" for c in one.read(np.full(3, g * 1e-3 * G), rng)]
    return Made([write(to / "post.txt", lines)], truth_of(one, 10))


def added_and_removed(to: Path, rng: Rng) -> Made:
    """A serial log with what was done in between: each weight comes on top of the last."""
    one, lines, on = cell(rng), ["# started, cell empty"], 0.0
    for step in (0.0, 0.5, 0.5, 1.0, -1.0, -0.5):
        on += step
        if step:
            lines.append(f"# {'added' if step > 0 else 'removed'} {abs(step) * 1e3:.0f} g")
        lines += [f"{c:.0f}" for c in one.read(np.full(15, on * G), rng)]
    return Made([write(to / "putty.log", lines)], truth_of(one))


def increments(to: Path, rng: Rng) -> Made:
    """A sheet with what was added and the sum of it."""
    one, added = cell(rng), np.array([0, 0.5, 0.5, 1.0, 2.0, 1.0])
    total = np.cumsum(added)
    body = rows(np.arange(1, 7), added, total, one.read(total * G, rng), sep=";")
    lines = ["Step;Added mass (kg);Total mass (kg);Reading", *body]
    return Made([write(to / "sheet.csv", [x.replace(".", ",") for x in lines])],
                truth_of(one, 50))  # fmt: skip


def increments_alone(to: Path, rng: Rng) -> Made:
    """The same without the sum: what lies on the cell is all that was added so far."""
    one, added = cell(rng), np.array([0, 0.5, 0.5, 1.0, 2.0, 1.0])
    read = one.read(np.cumsum(added) * G, rng)
    lines = ["step,added_kg,raw", *rows(np.arange(1, 7), added, read)]
    return Made([write(to / "sheet.csv", lines)], truth_of(one, 50))


def gross_tare_net(to: Path, rng: Rng) -> Made:
    """An indicator's print: gross, tare and net beside the counts; the cell bears the gross."""
    one, net = cell(rng), steps((0, 1, 2, 5), 5)
    gross = net + 0.35
    lines = ["No.;Gross kg;Tare kg;Net kg;ADC",
             *rows(np.arange(1, net.size + 1), gross, np.full(net.size, 0.35), net,
                   one.read(gross * G, rng), sep=";")]  # fmt: skip
    return Made([write(to / "indicator.csv", lines)], truth_of(one, 50))


def railed_converter(to: Path, rng: Rng) -> Made:
    """A converter at its end: under 10 kg every reading is 8388607."""
    one, kg = Cell(1.2e-5, -41.0, 40.0), steps((0, 1, 2, 5, 10), 8)
    read = np.minimum(one.read(kg * G, rng), 2**23 - 1)
    assert (read == 2**23 - 1).any()
    return Made([write(to / "hx.csv", ["mass_kg,hx711", *rows(kg, read)])], truth_of(one, 50))


TWELFTH_BENCH = (
    r_write_csv, julia_shown, stata_list, psql_answer, fortran_exponents, latex_rows, yaml_records,
    xml_records, sas_dots, gnuplot_blocks, mts_station, keithley_buffer, labjack_channels,
    rostopic_int32, arrows_of_a_forum, added_and_removed, increments, increments_alone,
    gross_tare_net, railed_converter,
)  # fmt: skip
