"""Two thirds of the corpus: shapes that the guessing was built on."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tests.strangers.rigs import (
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

KG = (0.0, 0.5, 1.0, 1.5, 2.0)


def canonical_weights(to: Path, rng: Rng) -> Made:
    one, kg = cell(rng), steps(KG, 4)
    lines = [
        "channel,load_kg,counts",
        *(f"fl,{k:g},{c:.0f}" for k, c in zip(kg, one.read(kg * G, rng), strict=True)),
    ]
    return Made([write(to / "weights.csv", lines)], truth_of(one))


def semicolons_commas_units(to: Path, rng: Rng) -> Made:
    one, kg = cell(rng), steps(KG, 3)
    body = [
        f"{i * 100};{k};{c:.0f}".replace(".", ",")
        for i, (k, c) in enumerate(zip(kg, one.read(kg * G, rng), strict=True))
    ]
    return Made(
        [write(to / "messung.csv", ["Zeit;Last;Messwert", "ms;kg;-", *body], end="\r\n")],
        truth_of(one),
    )


def latin1_semicolons(to: Path, rng: Rng) -> Made:
    one, g = cell(rng, "hx_small"), steps((0, 200, 500, 1000), 3)
    body = [
        f"{k:.1f};{c:.0f};ruhig für 5 s".replace(".", ",")
        for k, c in zip(g, one.read(g * G / 1e3, rng), strict=True)
    ]
    return Made(
        [write(to / "wägung.csv", ["Gewicht (g);Zählwert;Bemerkung", *body], "latin-1")],
        truth_of(one),
    )


def excel_bom(to: Path, rng: Rng) -> Made:
    one, lb = cell(rng), steps((0, 1, 2, 5), 3)
    body = rows(lb, one.read(lb * 0.45359237 * G, rng))
    return Made(
        [write(to / "Book1.csv", ["\ufeffWeight (lb),Raw ADC", *body], end="\r\n")], truth_of(one)
    )


def tabs_after_comments(to: Path, rng: Rng) -> Made:
    one, n = cell(rng), steps((0, 5, 10, 15), 3)
    head = ["# load cell 3, bridge supply 5 V", "# operator: K.", "load_N\tcounts"]
    return Made(
        [write(to / "cell3.tsv", [*head, *rows(n, one.read(n, rng), sep="\t")])], truth_of(one)
    )


def commented_header(to: Path, rng: Rng) -> Made:
    one, n = cell(rng), steps((0, 5, 10, 15), 3)
    return Made(
        [
            write(
                to / "savetxt.txt",
                ["# load_N counts", *rows(n, one.read(n, rng), sep=" ", form="%.18e")],
            )
        ],
        truth_of(one),
    )


def serial_with_typed_weights(to: Path, rng: Rng) -> Made:
    one = cell(rng, "hx_small")
    lines = ["HX711 scale demo"]
    for g in (0, 250, 500, 1000):
        lines.append(f"weight {g} g")
        lines += [f"Reading: {c:.0f}" for c in one.read(np.full(8, g * G / 1e3), rng)]
    return Made([write(to / "serial.txt", lines)], truth_of(one, 10))


def monitor_stamps(to: Path, rng: Rng) -> Made:
    one = cell(rng, "hx_small")
    load = settling([0, 2, 5, 10], 6, 10)
    lines = [
        f"12:{i // 600:02d}:{i // 10 % 60:02d}.{i % 10}00 -> {c:.0f}"
        for i, c in enumerate(one.read(load, rng))
    ]
    return Made([write(to / "monitor.log", lines)], says="loads")


def weights_beside_readings(to: Path, rng: Rng) -> Made:
    one, g = cell(rng, "hx_small"), steps((0, 200, 500, 1000), 4)
    lines = [f"{c:.0f}\t{k:.0f}g" for k, c in zip(g, one.read(g * G / 1e3, rng), strict=True)]
    return Made([write(to / "putty.log", lines)], truth_of(one, 10))


def bare_readings(to: Path, rng: Rng) -> Made:
    load = settling([0, 5, 10, 20], 5, 10)
    return Made([write(to / "raw.txt", rows(cell(rng).read(load, rng), form="%d"))], says="loads")


def stream_with_load(to: Path, rng: Rng) -> Made:
    one, load = cell(rng), settling([0, 5, 10, 20, 10, 0], 6, 20)
    t = np.arange(load.size) / 20
    held = np.where(np.gradient(load) == 0, load, np.nan)
    lines = [
        "t_s,load_N,adc",
        *(
            f"{a:.2f},{'' if np.isnan(b) else f'{b:g}'},{c:.0f}"
            for a, b, c in zip(t, held, one.read(load, rng), strict=True)
        ),
    ]
    return Made([write(to / "run.csv", lines)], truth_of(one))


def one_file_per_weight(to: Path, rng: Rng) -> Made:
    one = cell(rng)
    made = []
    for g in (0, 500, 1000, 2000):
        made.append(
            write(
                to / f"fl_{g}g.txt",
                ["counts", *rows(one.read(np.full(30, g * G / 1e3), rng), form="%d")],
            )
        )
    return Made(made, truth_of(one))


def one_file_per_channel(to: Path, rng: Rng) -> Made:
    cells = {name: cell(rng) for name in ("fl", "fr", "rl", "rr")}
    kg = steps(KG, 3)
    made = [
        write(to / f"weights_{n}.csv", ["load_kg,counts", *rows(kg, c.read(kg * G, rng))])
        for n, c in cells.items()
    ]
    return Made(made, truth_of(cells))


def long_german(to: Path, rng: Rng) -> Made:
    cells = {name: cell(rng) for name in ("VL", "VR", "HL", "HR")}
    kg = steps(KG, 2)
    lines = [
        f"{n};{k};{c:.0f}".replace(".", ",")
        for n, one in cells.items()
        for k, c in zip(kg, one.read(kg * G, rng), strict=True)
    ]
    return Made([write(to / "alle.csv", ["Zelle;Gewicht [kg];Digits", *lines])], truth_of(cells))


def wide_bench(to: Path, rng: Rng) -> Made:
    cells = {f"left_{p}": cell(rng) for p in ("fl", "fr", "rl", "rr")}
    kg = steps(KG, 1)
    body = rows(kg, *(c.read(kg * G, rng) for c in cells.values()))
    return Made(
        [write(to / "bench.csv", ["mass_kg,LFsrFL,LFsrFR,LFsrRL,LFsrRR", *body])], truth_of(cells)
    )


def loads_on_all_cells(to: Path, rng: Rng) -> Made:
    cells = {f"cell_{i + 1}": cell(rng) for i in range(3)}
    loads = rng.uniform(0, 20, (25, 3))
    body = rows(*(c.read(loads[:, i], rng) for i, c in enumerate(cells.values())), *loads.T)
    head = "s1_counts,s2_counts,s3_counts,load1_N,load2_N,load3_N"
    return Made([write(to / "matrix.csv", [head, *body])], truth_of(cells))


def volts(to: Path, rng: Rng) -> Made:
    one, n = cell(rng, "volt"), steps((0, 10, 20, 40), 4)
    return Made(
        [write(to / "daq.csv", ["Load [N],Voltage_0 [V]", *rows(n, one.read(n, rng, False))])],
        truth_of(one, 40),
    )


def millivolts_per_volt(to: Path, rng: Rng) -> Made:
    one, n = cell(rng, "volt"), steps((0, 10, 20, 40), 4)
    return Made(
        [
            write(
                to / "bridge.csv",
                ["Load (N);Signal (mV/V)", *rows(n, one.read(n, rng, False), sep=";")],
            )
        ],
        truth_of(one, 40),
    )


def calibrated_force(to: Path, rng: Rng) -> Made:
    one, kg = cell(rng, "newton"), steps(KG, 4)
    return Made(
        [
            write(
                to / "check.csv",
                ["known_mass_kg,measured_force_N", *rows(kg, one.read(kg * G, rng, False))],
            )
        ],
        truth_of(one),
    )


def iso_stamps(to: Path, rng: Rng) -> Made:
    one, g = cell(rng, "hx_small"), steps((0, 100, 200, 500, 1000), 3)
    lines = [
        f"2024-03-05 10:{i:02d}:00.500,{k:g},{c:.0f}"
        for i, (k, c) in enumerate(zip(g, one.read(g * G / 1e3, rng), strict=True))
    ]
    return Made(
        [write(to / "loadcell_data.csv", ["Timestamp,Known weight (grams),Raw reading", *lines])],
        truth_of(one, 10),
    )


def eight_columns_no_time(to: Path, rng: Rng) -> Made:
    body = rows(*(cell(rng).read(np.full(300, 6.0), rng) for _ in range(8)), form="%d")
    return Made([write(to / "feet.txt", body)], says="where the cells sit")


def nao_memory(to: Path, rng: Rng) -> Made:
    names = [
        f"Device/SubDeviceList/{f}Foot/FSR/{p}/Sensor/Value"
        for f in "LR"
        for p in ("FrontLeft", "FrontRight", "RearLeft", "RearRight")
    ]
    t = np.arange(400) * 0.01
    body = rows(t, *(np.abs(rng.normal(0.65, 0.01, 400)) for _ in names), form="%.6f")
    return Made(
        [write(to / "almemory.csv", [",".join(["time", *names]), *body])],
        says="where the cells sit",
    )


def quadruped_feet(to: Path, rng: Rng) -> Made:
    t = 1.7e9 + np.arange(500) * 0.002
    body = rows(t, *(rng.normal(30, 0.5, 500) for _ in range(4)), form="%.6f")
    return Made(
        [
            write(
                to / "feet.csv",
                ["timestamp,LF_FOOT_force,RF_FOOT_force,LH_FOOT_force,RH_FOOT_force", *body],
            )
        ],
        says="what the robot or person weighs",
    )


def two_clocks(to: Path, rng: Rng) -> Made:
    one, load = cell(rng), settling([0, 5, 10, 20, 5, 0], 5, 50)
    t = np.arange(load.size) / 50
    fine = t[::2] + 0.003
    a = write(to / "cell.csv", ["time_s,counts", *rows(t, one.read(load, rng))])
    b = write(
        to / "press.csv",
        [
            "Zeit [s];Kraft [N]",
            *(
                x.replace(".", ",")
                for x in rows(
                    fine, np.interp(fine, t, load) + rng.normal(0, 0.01, fine.size), sep=";"
                )
            ),
        ],
    )
    return Made([a, b], truth_of(one))


def press_and_fsr(to: Path, rng: Rng) -> Made:
    one = cell(rng, "adc12")
    t = np.arange(1500) / 50
    load = 12 + 9 * np.sin(2 * np.pi * 0.11 * t) + 2 * np.sin(2 * np.pi * 0.037 * t + 1)
    return Made(
        [
            write(
                to / "press_fsr.csv",
                [
                    "Time (s),Force (N),FSR1",
                    *rows(t, load + rng.normal(0, 0.05, t.size), one.read(load, rng)),
                ],
            )
        ],
        truth_of(one),
    )


def cop_grid(to: Path, rng: Rng) -> Made:
    x, y = (g.ravel() for g in np.meshgrid(np.linspace(-100, 100, 4), np.linspace(-60, 60, 4)))
    lines = ["point,ref_x_mm,ref_y_mm,cop_x_mm,cop_y_mm"]
    for i, (a, b) in enumerate(zip(x, y, strict=True)):
        for _ in range(3):
            u, v = np.array([1.02 * a + 1.5, 0.99 * b - 2]) + rng.normal(0, 0.2, 2)
            lines.append(f"P{i},{a:g},{b:g},{u:.3f},{v:.3f}")
    return Made([write(to / "plate.csv", lines)], cop_within_m=0.4e-3)


SEEN = (
    canonical_weights, semicolons_commas_units, latin1_semicolons, excel_bom, tabs_after_comments,
    commented_header, serial_with_typed_weights, monitor_stamps, weights_beside_readings,
    bare_readings, stream_with_load, one_file_per_weight, one_file_per_channel, long_german,
    wide_bench, loads_on_all_cells, volts, millivolts_per_volt, calibrated_force, iso_stamps,
    eight_columns_no_time, nao_memory, quadruped_feet, two_clocks, press_and_fsr, cop_grid,
)  # fmt: skip
