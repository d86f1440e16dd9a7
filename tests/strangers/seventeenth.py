"""Logs as people keep them, XIII: the classes of the sixteenth in another guise, and new ones.

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
    Truth,
    cell,
    rows,
    settling,
    steps,
    tool,
    tool_truth,
    truth_of,
    wrist,
    write,
)

LB = 4.4482216152605


def stamped_and_weighed(to: Path, rng: Rng) -> Made:
    """What was stamped on the weights, and what a balance said of them."""
    one = cell(rng)
    stamped = steps((0, 200, 500, 1000), 4)
    weighed = stamped * steps((1, 0.985, 1.011, 1.006), 4)
    body = rows(stamped, weighed, one.read(weighed * 1e-3 * G, rng), form="%.8g")
    return Made([write(to / "set.csv", ["stamped (g),weighed (g),HX711", *body])],
                truth_of(one, 10))  # fmt: skip


def what_was_on(to: Path, rng: Rng) -> Made:
    """A sheet that says in words what was on the plate."""
    one, lines = cell(rng), ["what was on,reading"]
    for said, kg in (("nothing", 0), ("1.25 kg", 1.25), ("1.25 kg + 2.5 kg", 3.75),
                     ("2 x 2.5 kg", 5), ("nothing", 0)):  # fmt: skip
        lines += [f"{said},{c:.0f}" for c in one.read(np.full(4, kg * G), rng)]
    return Made([write(to / "plates.csv", lines)], truth_of(one, 50))


def ranges_of_an_amplifier(to: Path, rng: Rng) -> Made:
    """One cell at two ranges of its amplifier, named in words."""
    cells, lines = {}, ["range;load_N;mV"]
    for name, scale in (("low", 0.5), ("high", 0.05)):
        one = Cell(scale, -3.0, 0.02)
        cells[name] = one
        newton = steps((0, 5, 10, 20), 4)
        lines += [f"{name};{x}" for x in rows(newton, one.read(newton, rng, whole=False), sep=";")]
    return Made([write(to / "amp.csv", lines)], truth_of(cells, 20))


def battery_runs_down(to: Path, rng: Rng) -> Made:
    """A bridge on a battery that ran down meanwhile: the reading is of load times supply."""
    kg = np.tile(steps((0, 1, 2, 4), 3), 3)
    supply = np.linspace(5.0, 3.6, kg.size)
    read = kg * G * supply * 0.11 + rng.normal(0, 0.002, kg.size)
    body = rows(kg, supply, read, form="%.6g")
    return Made([write(to / "battery.csv", ["kg,battery_V,bridge_mV", *body])], says="times")


def opc_history(to: Path, rng: Rng) -> Made:
    """A historian: time, tag and value of each change."""
    one, kg = cell(rng), steps((0, 2, 5, 10), 6)
    lines = ["Timestamp,Tag,Value"]
    for i, (k, c) in enumerate(zip(kg, one.read(kg * G, rng), strict=True)):
        stamp = f"2024-03-12T10:{i // 60:02d}:{i % 60:02d}.000Z"
        lines += [f"{stamp},Bench.RefMass_kg,{k:g}", f"{stamp},Bench.Cell1.Counts,{c:.0f}"]
    return Made([write(to / "history.csv", lines)], truth_of(one, 100))


def ruby_hashes(to: Path, rng: Rng) -> Made:
    """`{:load_kg=>0.5, :raw=>8223570}` on each line."""
    one, kg = cell(rng), steps((0, 0.5, 1, 2), 5)
    lines = [f"{{:load_kg=>{k}, :raw=>{c:.0f}}}"
             for k, c in zip(kg.tolist(), one.read(kg * G, rng), strict=True)]  # fmt: skip
    return Made([write(to / "out.txt", lines)], truth_of(one))


def node_console(to: Path, rng: Rng) -> Made:
    """`{ load: '0.5 kg', raw: 8223570 }`, as Node prints objects."""
    one, kg = cell(rng), steps((0, 0.5, 1, 2), 5)
    lines = [f"{{ load: '{k:g} kg', raw: {c:.0f} }}"
             for k, c in zip(kg, one.read(kg * G, rng), strict=True)]  # fmt: skip
    return Made([write(to / "node.log", lines)], truth_of(one))


def toml_samples(to: Path, rng: Rng) -> Made:
    """Tables of a TOML file, one for each sample."""
    one, kg, lines = cell(rng), steps((0, 1, 2, 5), 3), ['title = "bench"']
    for k, c in zip(kg.tolist(), one.read(kg * G, rng), strict=True):
        lines += ["", "[[sample]]", f"load_kg = {k}", f"raw = {c:.0f}"]
    return Made([write(to / "samples.toml", lines)], truth_of(one, 50))


def fenced(to: Path, rng: Rng) -> Made:
    """A table that was pasted between the fences of a forum."""
    one, grams = cell(rng), steps((0, 100, 200, 500), 4)
    body = rows(grams, one.read(grams * 1e-3 * G, rng))
    lines = ["Here are my values:", "```", "grams,raw", *body, "```", "Thanks!"]
    return Made([write(to / "post.txt", lines)], truth_of(one, 5))


def thai_sheet(to: Path, rng: Rng) -> Made:
    """A sheet in Thai."""
    one, kg = cell(rng), steps((0, 0.5, 1, 2), 4)
    body = rows(kg, one.read(kg * G, rng))
    return Made([write(to / "cal.csv", ["น้ำหนัก (กก.),ค่าที่อ่านได้", *body])], truth_of(one))


def ten_samples_a_row(to: Path, rng: Rng) -> Made:
    """A load and ten readings behind it in each row, no names."""
    one = cell(rng)
    lines = []
    for newton in (0, 5, 10, 20, 10, 5, 0):
        read = one.read(np.full(10, float(newton)), rng)
        lines.append("\t".join([str(newton), *(f"{c:.0f}" for c in read)]))
    return Made(
        [write(to / "array.txt", lines)],
        says="unit",
        fill=lambda text: text.replace('unit = "?"', 'unit = "N"'),
        truth=truth_of(one),
    )


def reference_and_nominal_files(to: Path, rng: Rng) -> Made:
    """Files named after what was asked for; a reference cell in them knows better."""
    one, paths = cell(rng), []
    for nominal in (0, 10, 20, 50):
        force = nominal * 0.96 + rng.normal(0, 0.05, 40)
        body = rows(0.1 * np.arange(40), force, one.read(force, rng), form="%.8g")
        paths.append(write(to / f"press_{nominal}N.csv", ["t,reference_N,counts", *body]))
    return Made(paths, truth_of(one, 50))


def ramp_of_a_fast_logger(to: Path, rng: Rng) -> Made:
    """Dates as stamps, a load that was stepped every two seconds and typed beside each sample."""
    one, newton = cell(rng, "volt"), steps((0, 10, 20, 40, 20, 0), 40)
    lines = ["date;load [N];out [V]"]
    lines += [f"12.03.2024 10:00:{i / 20:06.3f};{f:g};{v:.5f}"
              for i, (f, v) in enumerate(zip(newton, one.read(newton, rng, whole=False),
                                             strict=True))]  # fmt: skip
    return Made([write(to / "ramp.csv", lines)], truth_of(one, 40))


def braces_of_val3(to: Path, rng: Rng) -> Made:
    """A transformation in braces, the six axes behind it."""
    made, wrench, rot = wrist(rng)
    lines = []
    for a, w in zip(rot.as_euler("XYZ", degrees=True), wrench, strict=True):
        pose = ",".join(f"{v:.4f}" for v in (300.0, 0.0, 400.0, *a))
        lines.append(f"trsf={{{pose}}} ft={{{','.join(f'{v:.5f}' for v in w)}}}")
    return Made([write(to / "val3.log", lines)], tool_truth(made))


def sides_of_files(to: Path, rng: Rng) -> Made:
    """A file for each side that was below."""
    made, paths = tool(rng), []
    for name, down in (("nose_down", (1, 0, 0)), ("tail_down", (-1, 0, 0)),
                       ("left_down", (0, 1, 0)), ("right_down", (0, -1, 0)),
                       ("feet_down", (0, 0, -1)), ("feet_up", (0, 0, 1))):  # fmt: skip
        wrench = made.read(np.tile(np.array(down, float), (40, 1)), rng)
        body = rows(*wrench.T, form="%.5f")
        paths.append(write(to / f"{name}.csv", ["fx,fy,fz,tx,ty,tz", *body]))
    return Made(paths, tool_truth(made))


def linear_acceleration(to: Path, rng: Rng) -> Made:
    """A phone's linear acceleration, gravity taken out: no attitude, whatever it looks like."""
    _, wrench, _ = wrist(rng)
    t = 0.02 * np.arange(len(wrench))
    acc = rng.normal(0, 0.05, (len(t), 3))
    head = "Time (s),Linear Acceleration x (m/s^2),Linear Acceleration y (m/s^2)," \
        "Linear Acceleration z (m/s^2),Fx,Fy,Fz,Tx,Ty,Tz"  # fmt: skip
    return Made([write(to / "both.csv", [head, *rows(t, *acc.T, *wrench.T, form="%.5f")])],
                says="attitude")  # fmt: skip


def two_arms_json(to: Path, rng: Rng) -> Made:
    """Two arms in JSON, their wrenches and quaternions as lists."""
    left, wl, ql = wrist(rng)
    right, wr, qr = wrist(rng)
    lines = [
        json.dumps({"stamp": round(0.01 * i, 3),
                    "left": {"wrench": a.round(5).tolist(), "quat": p.round(6).tolist()},
                    "right": {"wrench": b.round(5).tolist(), "quat": q.round(6).tolist()}})
        for i, (a, p, b, q) in enumerate(zip(wl, ql.as_quat(), wr, qr.as_quat(), strict=True))
    ]  # fmt: skip
    one, two = tool_truth(left, "left"), tool_truth(right, "right")
    return Made([write(to / "arms.jsonl", lines)],
                Truth({**one.values, **two.values}, {**one.within, **two.within}))  # fmt: skip


def portuguese_zones(to: Path, rng: Rng) -> Made:
    """Zones of two insoles in Portuguese, in newtons."""
    side = settling([0.4, 0.6, 0.45, 0.7, 0.5], 5, 50)
    fore = settling([0.5, 0.3, 0.65, 0.4, 0.55], 5, 50)
    parts = [s * f * 70 * G for s in (side, 1 - side) for f in (fore, 1 - fore)]
    names = [f"{s}_{z} (N)" for s in ("esq", "dir") for z in ("antepe", "calcanhar")]
    body = rows(np.arange(side.size) / 50, *parts, sep=";", form="%.2f")
    return Made([write(to / "palmilhas.csv", [";".join(["tempo (s)", *names]), *body])],
                says="weigh")  # fmt: skip


def words_of_a_register(to: Path, rng: Rng) -> Made:
    """Low word first, its codes signed by the logger, four cells one after the other."""
    one, kg = Cell(1.3e-4, -40.0, 8.0), steps((0, 2, 5, 10, 20), 4)
    read = one.read(kg * G, rng).astype(int)
    low = ((read & 0xFFFF) ^ 0x8000) - 0x8000
    body = rows(kg, low, read >> 16)
    return Made([write(to / "plc.csv", ["Weight kg,DB1.W0,DB1.W2", *body])], truth_of(one, 200))


def hang_by_letters(to: Path, rng: Rng) -> Made:
    """An arm's H, P, R about z, the turned y and the turned x, in degrees."""
    made, wrench, rot = wrist(rng)
    body = rows(*rot.as_euler("ZYX", degrees=True).T, *wrench.T, form="%.5f")
    return Made([write(to / "gimbal.csv", ["H,P,R,Fx,Fy,Fz,Mx,My,Mz", *body])], tool_truth(made))


SEVENTEENTH = (
    stamped_and_weighed, what_was_on, ranges_of_an_amplifier, battery_runs_down, opc_history,
    ruby_hashes, node_console, toml_samples, fenced, thai_sheet, ten_samples_a_row,
    reference_and_nominal_files, ramp_of_a_fast_logger, braces_of_val3, sides_of_files,
    linear_acceleration, two_arms_json, portuguese_zones, words_of_a_register, hang_by_letters,
)  # fmt: skip
