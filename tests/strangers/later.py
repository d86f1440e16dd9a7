"""Ten more shapes, written after the third corpus was mended and run once before any change."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from tests.strangers.rigs import (
    G,
    Made,
    Rng,
    attitudes,
    cell,
    filled,
    rows,
    settling,
    steps,
    tool,
    tool_truth,
    truth_of,
    write,
)

KG = (0.0, 0.5, 1.0, 1.5, 2.0)


def robotiq_stream(to: Path, rng: Rng) -> Made:
    """A six-axis sensor's own stream: six numbers in brackets."""
    wrench = tool(rng).read(np.tile([0.0, 0.0, -1.0], (300, 1)), rng)
    lines = ["( " + " , ".join(f"{v:.3f}" for v in w) + " )" for w in wrench]
    return Made([write(to / "ft300.txt", lines)], says="attitude")


def force_gauge(to: Path, rng: Rng) -> Made:
    """A hand-held gauge beside a cell, the unit in every cell of the gauge's column."""
    one = cell(rng, "adc12")
    t = np.arange(900) / 30
    load = 14 + 11 * np.sin(2 * np.pi * t / 8)
    lines = ["t [s],gauge,adc"]
    lines += [
        f"{a:.3f},{b:.3f} N,{c:.0f}"
        for a, b, c in zip(t, load + rng.normal(0, 0.02, 900), one.read(load, rng), strict=True)
    ]
    return Made([write(to / "gauge.csv", lines)], truth_of(one, 25))


def esphome(to: Path, rng: Rng) -> Made:
    """A home-automation log; weights are known to the person only."""
    one = cell(rng, "hx_small")
    load = settling([0, 5, 10, 20], 6, 10)
    lines = [
        f"[10:{i // 600:02d}:{i // 10 % 60:02d}.{i % 10}][D][sensor:093]: 'hx711': "
        f"Sending state {c:.1f} with 0 decimals of accuracy"
        for i, c in enumerate(one.read(load, rng))
    ]
    return Made(
        [write(to / "esphome.log", lines)], truth_of(one), says="loads",
        fill=filled(loads='"0, 5, 10, 20 N"'),
    )  # fmt: skip


def titled_sheet(to: Path, rng: Rng) -> Made:
    """A sheet with a title, a person and a mean below the numbers."""
    one, kg = cell(rng), steps(KG, 3)
    counts = one.read(kg * G, rng)
    body = [f"{i + 1};{k:.1f};{c:.0f}" for i, (k, c) in enumerate(zip(kg, counts, strict=True))]
    lines = ["Calibration sheet;;", "Operator: K. Novak;;", ";;", "No.;Mass [kg];Reading", *body]
    lines += [";;", f"Mean;;{counts.mean():.1f}"]
    return Made([write(to / "sheet.csv", lines)], truth_of(one))


def up_and_down(to: Path, rng: Rng) -> Made:
    """Loading and unloading in two columns."""
    one, g = cell(rng), np.array([0, 200, 500, 1000, 2000.0])
    body = rows(g, one.read(g * G / 1e3, rng), one.read(g * G / 1e3, rng), form="%.10g")
    truth = truth_of(one)
    return Made([write(to / "hysteresis.csv", ["weight [g],up,down", *body])], truth)


def json_array(to: Path, rng: Rng) -> Made:
    """One JSON document."""
    one, kg = cell(rng), steps(KG, 3)
    made = [
        {"weight_kg": float(k), "raw": int(c)}
        for k, c in zip(kg, one.read(kg * G, rng), strict=True)
    ]
    return Made([write(to / "data.json", json.dumps(made, indent=1).splitlines())], truth_of(one))


def two_cells_pounds(to: Path, rng: Rng) -> Made:
    """A table in pounds with two cells and a remark with commas in quotes."""
    cells, lb = {"toe": cell(rng), "heel": cell(rng)}, steps((0, 1, 2, 5), 3)
    lines = ["Load (lbs),Toe cell,Heel cell,Remarks"]
    lines += [
        f'{k:g},{a:.0f},{b:.0f},"steady, no wind"'
        for k, a, b in zip(
            lb, *(c.read(lb * 0.45359237 * G, rng) for c in cells.values()), strict=True
        )
    ]
    return Made([write(to / "pounds.csv", lines)], truth_of(cells))


def kuka_abc(to: Path, rng: Rng) -> Made:
    """Angles A (about z), B (about y), C (about x) of an arm, degrees."""
    made = tool(rng)
    rot, _ = attitudes(rng, 14, 20)
    abc = Rotation.from_matrix(rot).as_euler("ZYX", degrees=True)
    wrench = made.read(-rot[:, 2, :], rng)
    t = np.arange(len(rot)) * 12.0
    head = "t_ms;A;B;C;Fx;Fy;Fz;Mx;My;Mz"
    body = rows(t, *abc.T, *wrench.T, sep=";")
    return Made([write(to / "kuka.csv", [head, *body])], tool_truth(made))


def corner_loads(to: Path, rng: Rng) -> Made:
    """A plate with four cells, a weight put on marked points."""
    corners = np.array([[60, 40], [60, -40], [-60, 40], [-60, -40]])
    lines = ["pos_x_mm,pos_y_mm,mass_kg,c1,c2,c3,c4"]
    cells = [cell(rng) for _ in range(4)]
    for x in (-40, 0, 40):
        for y in (-25, 0, 25):
            share = (1 + x * corners[:, 0] / 60**2 / 1.0) * (1 + y * corners[:, 1] / 40**2) / 4
            loads = 5 * G * share
            counts = [one.read(np.array([n]), rng)[0] for one, n in zip(cells, loads, strict=True)]
            lines.append(f"{x},{y},5," + ",".join(f"{c:.0f}" for c in counts))
    return Made([write(to / "corners.csv", lines)], says="where the cells sit")


def elapsed_clock(to: Path, rng: Rng) -> Made:
    """Elapsed time as a clock, the load from the press's own display."""
    one, load = cell(rng), settling([0, 5, 10, 20, 10, 0], 6, 20)
    t = np.arange(load.size) / 20
    lines = ["Elapsed\tForce (N)\tRaw"]
    lines += [
        f"00:{int(a) // 60:02d}:{a % 60:06.3f}\t{b:.2f}\t{c:.0f}"
        for a, b, c in zip(t, load + rng.normal(0, 0.01, t.size), one.read(load, rng), strict=True)
    ]
    return Made([write(to / "press.tsv", lines)], truth_of(one))


LATER = (
    robotiq_stream, force_gauge, esphome, titled_sheet, up_and_down, json_array, two_cells_pounds,
    kuka_abc, corner_loads, elapsed_clock,
)  # fmt: skip
