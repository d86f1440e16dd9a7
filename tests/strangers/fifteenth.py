"""Logs as people keep them, XI: more languages, clocks, printed numbers, arms and plates.

Written before it was run; `docs/bring_your_log.md` has its first count.
"""

from __future__ import annotations

import gzip
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
    tool_truth,
    truth_of,
    wrist,
    write,
)

LB = 4.4482216152605


def spanish(to: Path, rng: Rng) -> Made:
    """A sheet in Spanish."""
    return sheet_under(to, rng, "Peso (kg);Lectura", "latin-1")


def portuguese(to: Path, rng: Rng) -> Made:
    """A sheet in Portuguese."""
    return sheet_under(to, rng, "Massa (kg);Leitura")


def turkish(to: Path, rng: Rng) -> Made:
    """A sheet in Turkish, its code page."""
    return sheet_under(to, rng, "Ağırlık (kg);Okuma", "cp1254")


def dutch(to: Path, rng: Rng) -> Made:
    """A sheet in Dutch."""
    return sheet_under(to, rng, "Gewicht (kg);Meting")


def korean(to: Path, rng: Rng) -> Made:
    """A sheet in Korean, its code page."""
    return sheet_under(to, rng, "하중 (kg);판독값", "cp949")


def czech(to: Path, rng: Rng) -> Made:
    """A sheet in Czech, its code page."""
    return sheet_under(to, rng, "Hmotnost (kg);Údaj", "cp1250")


def finnish(to: Path, rng: Rng) -> Made:
    """A sheet in Finnish."""
    return sheet_under(to, rng, "Paino (kg);Lukema")


def sep_line(to: Path, rng: Rng) -> Made:
    """Excel's first line `sep=;`."""
    made = sheet_under(to, rng, "Load (kg);Raw")
    text = made.paths[0].read_text()
    made.paths[0].write_text("sep=;\n" + text)
    return made


def swiss_apostrophes(to: Path, rng: Rng) -> Made:
    """Swiss thousands: 8'223'570."""
    one, grams = cell(rng), steps((0, 500, 1000, 2000), 4)
    read = one.read(grams * 1e-3 * G, rng)
    body = [f"{g:.0f};{c:,.0f}".replace(",", "'") for g, c in zip(grams, read, strict=True)]
    return Made([write(to / "eichung.csv", ["Last g;Zähler", *body])], truth_of(one))


def din_slashes(to: Path, rng: Rng) -> Made:
    """Quantities as DIN 1313 has them: `F / N`, `U / mV`."""
    one, newton = Cell(0.41, -6.0, 1e-2), steps((0, 5, 10, 20), 4)
    body = rows(newton, one.read(newton, rng, whole=False), sep="\t", form="%.6g")
    return Made([write(to / "kennlinie.txt", ["F / N\tU / mV", *body])], truth_of(one))


def twelve_bits_signed(to: Path, rng: Rng) -> Made:
    """Twelve bits in two's complement over most of the range, read without their sign."""
    one, newton = Cell(0.012, 18.0, 0.6), steps((0, 5, 10, 20, 30, 40), 4)
    read = np.mod(one.read(newton, rng), 4096)
    return Made([write(to / "adc.csv", ["force_N,adc", *rows(newton, read)])], truth_of(one, 40))


def twenty_bits_signed(to: Path, rng: Rng) -> Made:
    """A CS5530's twenty bits without their sign."""
    one, kg = Cell(2.1e-4, 20.0, 4.0), steps((0, 1, 2, 4, 8), 5)
    read = np.mod(one.read(kg * G, rng), 2**20)
    return Made([write(to / "cs5530.csv", ["kg,code", *rows(kg, read)])], truth_of(one, 80))


def pounds_then_ounces(to: Path, rng: Rng) -> Made:
    """Two columns with a title above them both."""
    one = cell(rng)
    lb, oz = steps((0, 0, 1, 2, 5), 4), steps((0, 8, 4, 12, 0), 4)
    body = rows(lb, oz, one.read(lb * LB + oz * LB / 16, rng))
    head = ["Kitchen scale test,,", "Pounds,Ounces,HX711 reading"]
    return Made([write(to / "kitchen.csv", [*head, *body])], truth_of(one, 20))


def same_load_twice(to: Path, rng: Rng) -> Made:
    """Kilograms and the same in newtons, both called load."""
    one, kg = cell(rng), steps((0, 0.1, 0.2, 0.5), 4)
    body = rows(kg, kg * 1000, kg * G, one.read(kg * G, rng), form="%.9g")
    head = "load_kg,load_g,load_N,raw"
    return Made([write(to / "bench.csv", [head, *body])], truth_of(one, 5))


def bars_of_a_sketch(to: Path, rng: Rng) -> Made:
    """`Weight: 500 g | Raw: 8223570 | Temp: 23.1 C`."""
    one, grams = cell(rng), steps((0, 200, 500, 1000), 4)
    lines = [
        f"Weight: {g:.0f} g | Raw: {c:.0f} | Temp: {23 + i * 0.1:.1f} C"
        for i, (g, c) in enumerate(zip(grams, one.read(grams * 1e-3 * G, rng), strict=True))
    ]
    return Made([write(to / "monitor.txt", lines)], truth_of(one, 10))


def rosout(to: Path, rng: Rng) -> Made:
    """A node's own words: `[INFO] [1710237600.123] [hx711]: load 0.5 kg raw 8223570`."""
    one, kg = cell(rng), steps((0, 0.5, 1, 2), 5)
    lines = [f"[INFO] [{1710237600.125 + i:.9f}] [hx711_node]: load {k:g} kg raw {c:.0f}"
             for i, (k, c) in enumerate(zip(kg, one.read(kg * G, rng), strict=True))]  # fmt: skip
    return Made([write(to / "launch.log", lines)], truth_of(one))


def am_and_pm(to: Path, rng: Rng) -> Made:
    """American stamps with AM and PM."""
    one, kg = cell(rng), steps((0, 1, 2, 5), 4)
    lines = ["Timestamp,Load (lb),Raw"]
    for i, (k, c) in enumerate(zip(kg, one.read(kg * LB, rng), strict=True)):
        lines.append(f"3/12/2024 {11 + i // 8 if i < 8 else 12}:{i:02d}:30 "
                     f"{'AM' if i < 8 else 'PM'},{k:g},{c:.0f}")  # fmt: skip
    return Made([write(to / "log.csv", lines)], truth_of(one, 20))


def colon_milliseconds(to: Path, rng: Rng) -> Made:
    """Stamps `10:00:00:250`, the milliseconds behind a colon."""
    one, kg = cell(rng), steps((0, 1, 2, 5), 4)
    lines = ["Time,Mass kg,Counts"]
    lines += [f"10:00:{i:02d}:250,{k:g},{c:.0f}"
              for i, (k, c) in enumerate(zip(kg, one.read(kg * G, rng), strict=True))]  # fmt: skip
    return Made([write(to / "viewer.csv", lines)], truth_of(one, 50))


def fractions_of_pounds(to: Path, rng: Rng) -> Made:
    """Loads as `1/2 lb` and `1 1/4 lb`: no number that is one."""
    one, lines = cell(rng), ["load,raw"]
    for said, lb in (("0 lb", 0), ("1/2 lb", 0.5), ("1 lb", 1), ("1 1/4 lb", 1.25), ("2 lb", 2)):
        lines += [f"{said},{c:.0f}" for c in one.read(np.full(4, lb * LB), rng)]
    return Made([write(to / "garage.csv", lines)], says="number")


def asciidoc(to: Path, rng: Rng) -> Made:
    """A table of Asciidoc between `|===`."""
    one, kg = cell(rng), steps((0, 0.5, 1, 2), 4)
    body = [f"|{k:g} |{c:.0f}" for k, c in zip(kg, one.read(kg * G, rng), strict=True)]
    lines = ["= Bench", "", "|===", "|Load (kg) |Raw", "", *body, "|==="]
    return Made([write(to / "bench.adoc", lines)], truth_of(one))


def ordered_dicts(to: Path, rng: Rng) -> Made:
    """`OrderedDict([('load_kg', 1.0), ('raw', 8223570)])`."""
    one, kg = cell(rng), steps((0, 0.5, 1, 2), 4)
    lines = [f"OrderedDict([('load_kg', {k}), ('raw', {c:.0f})])"
             for k, c in zip(kg.tolist(), one.read(kg * G, rng), strict=True)]  # fmt: skip
    return Made([write(to / "print.txt", lines)], truth_of(one))


def kiloponds(to: Path, rng: Rng) -> Made:
    """An old machine in kiloponds."""
    one, kp = cell(rng), steps((0, 1, 2, 5), 4)
    return Made([write(to / "prufung.csv", ["Last [kp],ADC", *rows(kp, one.read(kp * G, rng))])],
                truth_of(one, 50))  # fmt: skip


def compression_negative(to: Path, rng: Rng) -> Made:
    """A testing machine calls compression negative."""
    one, kn = Cell(-1.2e3, 10.0, 1e-4), steps((0, -0.5, -1, -2, -1, 0), 4)
    read = one.read(kn * 1e3, rng, whole=False)
    return Made([write(to / "utm.csv", ["Force (kN),Bridge (mV/V)", *rows(kn, read)])],
                truth_of(one, 2000))  # fmt: skip


def gzipped(to: Path, rng: Rng) -> Made:
    """A table that logrotate packed."""
    made = sheet_under(to, rng, "Load (kg);Raw")
    path = to / "cal.csv.gz"
    path.write_bytes(gzip.compress(made.paths[0].read_bytes()))
    return Made([path], made.truth)


def minus_one_where_lost(to: Path, rng: Rng) -> Made:
    """A driver that gives -1 for a reading that timed out."""
    one, kg = Cell(4.6e-4, -3000.0, 12.0), steps((0, 0.5, 1, 2), 20)
    read = one.read(kg * G, rng)
    read[[3, 25, 44, 61]] = -1
    return Made([write(to / "timeouts.csv", ["kg,raw", *rows(kg, read)])], truth_of(one))


def bricks(to: Path, rng: Rng) -> Made:
    """Loads counted in bricks: nobody weighed one."""
    one, n = cell(rng), steps((0, 1, 2, 3, 4), 3)
    body = rows(n, one.read(n * 2.1 * G, rng))
    return Made([write(to / "yard.csv", ["load (bricks),raw", *body])], says="unit")


def denso_rc8(to: Path, rng: Rng) -> Made:
    """DENSO: RX, RY, RZ in degrees about fixed axes, and the figure of the arm."""
    made, wrench, rot = wrist(rng)
    place = np.tile([[300.0], [0.0], [400.0]], len(wrench))
    body = rows(*place, *rot.as_euler("xyz", degrees=True).T, np.full(len(wrench), 5), *wrench.T,
                form="%.5f")  # fmt: skip
    return Made([write(to / "rc8.csv", ["X,Y,Z,RX,RY,RZ,FIG,Fx,Fy,Fz,Mx,My,Mz", *body])],
                tool_truth(made))  # fmt: skip


def comau_aer(to: Path, rng: Rng) -> Made:
    """COMAU: A, E, R in degrees about z, the new y and the new z."""
    made, wrench, rot = wrist(rng)
    body = rows(*rot.as_euler("ZYZ", degrees=True).T, *wrench.T, form="%.5f")
    return Made([write(to / "pdl.csv", ["A,E,R,Fx,Fy,Fz,Mx,My,Mz", *body])], tool_truth(made))


def quaternion_in_one_cell(to: Path, rng: Rng) -> Made:
    """A list in a cell: `"[0.1, 0.2, 0.3, 0.9]"`."""
    made, wrench, rot = wrist(rng)
    lines = ["t,quat_xyzw,fx,fy,fz,tx,ty,tz"]
    for i, (q, w) in enumerate(zip(rot.as_quat(), wrench, strict=True)):
        said = ", ".join(f"{x:.6f}" for x in q)
        lines.append(f'{i * 0.01:.2f},"[{said}]",' + ",".join(f"{x:.5f}" for x in w))
    return Made([write(to / "recorder.csv", lines)], tool_truth(made))


def techman(to: Path, rng: Rng) -> Made:
    """Techman's listen node: names with brackets, degrees."""
    made, wrench, rot = wrist(rng)
    head = [f"Coord_Robot_Flange[{i}]" for i in range(6)] + [f"F3D_{a}" for a in (
        "Fx", "Fy", "Fz", "Tx", "Ty", "Tz")]  # fmt: skip
    place = np.tile([[300.0], [0.0], [400.0]], len(wrench))
    body = rows(*place, *rot.as_euler("xyz", degrees=True).T, *wrench.T, form="%.5f")
    return Made([write(to / "tmflow.csv", [",".join(head), *body])], tool_truth(made))


def tool_named_ways(to: Path, rng: Rng) -> Made:
    """Three files, how the tool pointed in their names, and no six sides."""
    made, _, _ = wrist(rng)
    paths = []
    for name, gravity in (("down", (0, 0, 1)), ("up", (0, 0, -1)), ("sideways", (1, 0, 0))):
        wrench = made.read(np.tile(np.array(gravity, float), (30, 1)), rng)
        lines = ["fx,fy,fz,tx,ty,tz", *rows(*wrench.T, form="%.5f")]
        paths.append(write(to / f"tool_{name}.csv", lines))
    return Made(paths, says="attitude")


def _two_feet(gain: tuple[float, float], rng: Rng) -> np.ndarray:
    share = settling([0.35, 0.55, 0.7, 0.4, 0.6, 0.5], 5, 50)
    parts = np.array([share, 1 - share]) * 75 * G
    return np.asarray(parts / np.array(gain)[:, None] + rng.normal(0, 1, parts.shape))


def pasco_two_plates(to: Path, rng: Rng) -> Made:
    """Capstone: two plates, `Normal Force, Plate 1 (N)`."""
    fz = _two_feet((1.03, 0.97), rng)
    head = "Time (s),Normal Force, Plate 1 (N),Normal Force, Plate 2 (N)".replace("e, P", "e P")
    body = rows(np.arange(fz.shape[1]) / 50, *fz, form="%.3f")
    return Made([write(to / "two plates.csv", [head, *body])], says="weigh")


def smart_insole_kpa(to: Path, rng: Rng) -> Made:
    """An insole in kilopascals: no area is known."""
    n = 400
    p = rng.normal(60, 3, (6, n))
    names = [f"{s}_{z}_kPa" for s in ("L", "R") for z in ("heel", "arch", "toe")]
    body = rows(np.arange(n) / 100, *p, form="%.2f")
    return Made([write(to / "walk.csv", [",".join(["t", *names]), *body])], says="weigh")


def go1_foot_force(to: Path, rng: Rng) -> Made:
    """`footForce[0]` … `footForce[3]` in raw units, the order in the manual alone."""
    n = 400
    raw = np.round(rng.normal(150, 3, (4, n)))
    head = ["tick", *(f"footForce[{i}]" for i in range(4))]
    body = rows(2 * np.arange(n), *raw)
    return Made([write(to / "lowstate.csv", [",".join(head), *body])], says="weigh")


def h1_ankles(to: Path, rng: Rng) -> Made:
    """A humanoid without transducers: joint torques alone."""
    n = 200
    tau = rng.normal(0, 5, (4, n))
    head = "time,left_hip_tau,left_knee_tau,right_hip_tau,right_knee_tau"
    body = rows(np.arange(n) / 500, *tau, form="%.4f")
    return Made([write(to / "joints.csv", [head, *body])], says="columns fit no experiment")


FIFTEENTH = (
    spanish, portuguese, turkish, dutch, korean, czech, finnish, sep_line, swiss_apostrophes,
    din_slashes, twelve_bits_signed, twenty_bits_signed, pounds_then_ounces, same_load_twice,
    bars_of_a_sketch, rosout, am_and_pm, colon_milliseconds, fractions_of_pounds, asciidoc,
    ordered_dicts, kiloponds, compression_negative, gzipped, minus_one_where_lost, bricks,
    denso_rc8, comau_aer, quaternion_in_one_cell, techman, tool_named_ways, pasco_two_plates,
    smart_insole_kpa, go1_foot_force, h1_ankles,
)  # fmt: skip
