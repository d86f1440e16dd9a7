"""Fourteen new labs: facts in notes, benches with their own names, protocols, vectors, sheets."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from tests.strangers.rigs import (
    Array,
    Cell,
    G,
    Made,
    Rng,
    Truth,
    cell,
    rows,
    tool,
    tool_truth,
    truth_of,
    wrist,
    write,
)
from tests.strangers.thirty_fifth import leg_truth, legs, swings
from tests.strangers.thirty_first_robots import _HELD, _HIPS, _posed, _renamed
from tests.strangers.thirty_first_stands import _MASS, _PLACES, _March, _march, _scales, _stances
from tests.strangers.thirty_sixth import UP

INCH, FOOT, POUND = 0.0254, 0.3048, 4.4482216


def comma(lines: list[str]) -> list[str]:
    """Decimal commas."""
    return [x.replace(".", ",") for x in lines]


def read_out(scale: Array, zero: Array, load: Array, rng: Rng, noise: float = 0.02) -> Array:
    """Counts of cells (n, k) under loads (n, k): ``F = scale · S + zero``."""
    return np.asarray(np.round((load - zero + rng.normal(0, noise, load.shape)) / scale))


def eight(rng: Rng, per_count: float = 1e-4) -> tuple[Array, Array]:
    """Scales and zeros of eight cells."""
    return per_count * (1 + 0.02 * rng.normal(0, 1, 8)), rng.normal(0, 0.5, 8)


def bench_truth(names: list[str], scale: Array) -> Truth:
    """Scales of a walk's cells to 2 %."""
    values = {f"{n}.scale": float(s) for n, s in zip(names, scale, strict=True)}
    return Truth(values, {n: 0.02 * abs(v) for n, v in values.items()})


def ankles(rng: Rng) -> tuple[_March, Array, Array]:
    """A walk on six-axis ankles: the walk, wrenches (n, 2, 6), offsets (2, 6)."""
    walk = _march(rng)
    offset = rng.normal(0, 1, (2, 6)) * ([2.0] * 3 + [0.05] * 3)
    felt = []
    for f in range(2):
        push = _MASS * walk.acc[:, :2] * (walk.load[:, f : f + 1] / (_MASS * G))
        force = np.column_stack([push, walk.load[:, f]])
        arm = np.column_stack([walk.cop[:, f], np.zeros(len(force))])
        own = np.hstack([force, np.cross(arm, force)]) + offset[f]
        felt.append(own + rng.normal(0, 1, own.shape) * ([0.1] * 3 + [0.004] * 3))
    return walk, np.stack(felt, axis=1), offset


def ankle_truth(offset: Array) -> Truth:
    """Offsets of both ankles."""
    axes = ("fx", "fy", "fz", "tx", "ty", "tz")
    ends = {f"{s}.offset_{a}": float(offset[f, i])
            for f, s in enumerate(("left", "right")) for i, a in enumerate(axes)}  # fmt: skip
    return Truth(ends, {name: 0.05 if ".offset_t" in name else 0.5 for name in ends})


def danish_feet(to: Path, rng: Rng) -> Made:
    """A file for each foot with its four cells A … D, the body in another, a sheet of places."""
    walk = _march(rng)
    scale, zero = eight(rng)
    read = read_out(scale, zero, walk.cells, rng)
    paths = []
    for f, word in enumerate(("venstre", "hoejre")):
        body = rows(1e3 * walk.time, *read[:, 4 * f : 4 * f + 4].T, sep=";")
        paths.append(write(to / f"gang_{word}.csv", ["tid_ms;A;B;C;D", *body]))
    head = [f"{n}_{a} [cm]" for n in ("tyngdepunkt", "venstre_fod", "hoejre_fod") for a in "xyz"]
    head += [f"tyngdepunkt_acc_{a} [cm/s2]" for a in "xyz"]
    data = [*walk.com.T, *walk.feet.reshape(-1, 6).T, *walk.acc.T]
    body = comma(rows(1e3 * walk.time, *(100 * np.array(data)), sep=";", form="%.7g"))
    paths.append(write(to / "gang_krop.csv", [";".join(["tid_ms", *head]), *body]))
    bench = ["fod;celle;masse_g;tal"]
    for f, word in enumerate(("venstre", "hoejre")):
        for c, name in enumerate("ABCD"):
            for g in (0, 200, 500, 1000, 2000, 1000, 0):
                i = 4 * f + c
                s = (g / 1000 * G - zero[i] + rng.normal(0, 0.01)) / scale[i]
                bench.append(f"{word};{name};{g};{s:.0f}")
    paths.append(write(to / "vejning.csv", bench))
    sheet = ["celle;x_mm;y_mm", *(f"{n};{1e3 * x:g};{1e3 * y:g}"
                                  for n, (x, y) in zip("ABCD", _PLACES, strict=True))]  # fmt: skip
    paths.append(write(to / "placering.csv", sheet))
    notes = write(to / "noter.md", ["# Gangforsøg 12. maj", "", "Robottens masse er 5,2 kg.",
                                    "Placeringer gælder for begge fødder."])  # fmt: skip
    names = [f"{s}_{c}" for s in ("left", "right") for c in "abcd"]
    return Made([*paths, notes], bench_truth(names, scale))


def daq_channels_of_feet(to: Path, rng: Rng) -> Made:
    """Channels `X11 … X24` of a DAQ in the walk, feet and numbers on the bench; feet and inches."""
    walk = _march(rng)
    scale, zero = eight(rng, 2e-4)
    read = read_out(scale, zero, walk.cells, rng)
    head = ["t", *(f"X{f}{c}" for f in (1, 2) for c in (1, 2, 3, 4))]
    head += [f"com_{a}_in" for a in "xyz"] + [f"acom_{a} (ft/s^2)" for a in "xyz"]
    head += [f"{s}foot_{a}_in" for s in "LR" for a in "xyz"]
    body = [*(walk.com / INCH).T, *(walk.acc / FOOT).T, *(walk.feet.reshape(-1, 6) / INCH).T]
    lines = [",".join(head), *rows(walk.time, *read.T, *body, form="%.8g")]
    bench = ["channel,lbs,counts"]
    for i in range(8):
        for lb in (0, 1, 2, 5, 2, 0):
            s = (lb * POUND - zero[i] + rng.normal(0, 0.01)) / scale[i]
            bench.append(f"{('left', 'right')[i // 4]}_{i % 4 + 1},{lb},{s:.0f}")
    notes = write(to / "notes.md", [
        "Biped, 5.2 kg with battery.", "", "X11..X14 are the left foot's cells 1..4, X21..X24 the "
        "right foot's.", "", "| cell | x [mm] | y [mm] |", "|---|---|---|",
        *(f"| {i + 1} | {1e3 * x:g} | {1e3 * y:g} |" for i, (x, y) in enumerate(_PLACES)),
    ])  # fmt: skip
    names = [f"{s}_{i}" for s in ("left", "right") for i in range(1, 5)]
    paths = [write(to / "walk3.csv", lines), write(to / "bench.csv", bench), notes]
    return Made(paths, bench_truth(names, scale))


def brazilian_ankles(to: Path, rng: Rng) -> Made:
    """A file for each ankle by sample number, `pcom[0]` and `acom[0]`, units and rate in notes."""
    walk, felt, offset = ankles(rng)
    number = np.arange(len(felt))
    paths = []
    for f, s in enumerate("ed"):
        names = "amostra,F[0],F[1],F[2],M[0],M[1],M[2]"
        own = felt[:, f] * ([1.0] * 3 + [1000.0] * 3)
        paths.append(write(to / f"tornozelo_{s}.csv", [names, *rows(number, *own.T, form="%.7g")]))
    head = [f"{n}[{i}]" for n in ("pcom", "acom", "pe_e", "pe_d") for i in range(3)]
    data = [walk.com, walk.acc, walk.feet[:, 0], walk.feet[:, 1]]
    body = rows(number, *np.hstack(data).T, form="%.7g")
    paths.append(write(to / "corpo.csv", [",".join(["amostra", *head]), *body]))
    notes = write(to / "notas.md", [
        "- robô bípede, massa: 5,2 kg", "- taxa de amostragem 100 Hz",
        "- F em N, M em N.mm; pcom, pe_e (pé esquerdo) e pe_d (pé direito) em m, acom em m/s²",
    ])  # fmt: skip
    return Made([*paths, notes], ankle_truth(offset))


def french_soles(to: Path, rng: Rng) -> Made:
    """Corners of soles in dekanewtons, the whole walk in one sheet with a block of facts on top."""
    walk = _march(rng)
    gain = 1 + 0.02 * rng.normal(0, 1, 8)
    read = (walk.cells + rng.normal(0, 0.02, walk.cells.shape)) / gain / 10
    corners = [f"{s}_{p}" for s in "GD" for p in ("AvInt", "AvExt", "ArInt", "ArExt")]
    # the inner cells of the left foot lie right, those of the right foot left
    order = [1, 0, 3, 2, 4, 5, 6, 7]
    head = ["Temps (s)", *(f"{c} (daN)" for c in corners)]
    head += [f"{n} {a} (cm)" for n in ("CdM", "PiedG", "PiedD") for a in "XYZ"]
    head += [f"acc CdM {a} (g)" for a in "XYZ"]
    body = [*read[:, order].T, *(100 * walk.com).T, *(100 * walk.feet.reshape(-1, 6)).T]
    lines = ["Essai;marche_07", "Masse du robot;5,2 kg", "Fréquence;100 Hz", "", ";".join(head)]
    lines += comma(rows(walk.time, *body, *(walk.acc / G).T, sep=";", form="%.8g"))
    sheet = ["capteur;x (mm);y (mm)"]
    for c, i in zip(corners, order, strict=True):
        x, y = _PLACES[i % 4]
        sheet.append(f"{c};{1e3 * x:g};{1e3 * y:g}".replace(".", ","))
    paths = [write(to / "marche_07.csv", lines, "cp1252"), write(to / "capteurs.csv", sheet)]
    words = {"AvInt": "avint", "AvExt": "avext", "ArInt": "arint", "ArExt": "arext"}
    names = [f"{'left' if c[0] == 'G' else 'right'}_{words[c[2:]]}" for c in corners]
    return Made(paths, _scales(names, gain[order]))


def row_for_each_stance(to: Path, rng: Rng) -> Made:
    """Means of 24 stances in a sheet of their own, the first in the air; a bench in N."""
    stand = _stances(rng, stances=26)
    at = np.arange(100, len(stand.time), 170)
    scale, zero = eight(rng)
    loads = np.vstack([np.zeros(8), stand.cells[at]])
    read = read_out(scale, zero, loads, rng, 0.004)
    com = np.vstack([stand.com[:1], stand.com[at]])
    feet = np.vstack([stand.feet[:1], stand.feet[at]]).reshape(-1, 6)
    head = ["stance", "remark", *(f"{s}{p}" for s in "LR" for p in ("FL", "FR", "RL", "RR"))]
    head += [f"CoM{a}_mm" for a in "xyz"] + [f"{s}foot{a}_mm" for s in "LR" for a in "xyz"]
    body = rows(*read.T, *(1e3 * com).T, *(1e3 * feet).T, form="%.8g")
    said = ["robot lifted", *[""] * len(at)]
    lines = [
        ",".join(head),
        *(f"{i},{s},{b}" for i, (s, b) in enumerate(zip(said, body, strict=True))),
    ]
    bench = ["cell,load_N,raw"]
    for i, name in enumerate(head[2:10]):
        for n in (0, 5, 10, 20, 40, 20, 5, 0):
            bench.append(f"{name},{n},{(n - zero[i] + rng.normal(0, 0.01)) / scale[i]:.0f}")
    notes = write(to / "notes.md", [
        "Robot weighs 5.2 kg.", "", "Cells in the foot frame, mm (x forward, y left), both feet:",
        *(f"- {p}: {1e3 * x:g}, {1e3 * y:g}"
          for p, (x, y) in zip(("FL", "FR", "RL", "RR"), _PLACES, strict=True)),
    ])  # fmt: skip
    names = [f"{s}_{p}" for s in ("left", "right") for p in ("fl", "fr", "rl", "rr")]
    paths = [write(to / "stances.csv", lines), write(to / "bench.csv", bench), notes]
    return Made(paths, bench_truth(names, scale))


def italian_counts_and_holes(to: Path, rng: Rng) -> Made:
    """Bench cells `PI PE TI TE`, placements `PI_conteggi …` of one weight over holes in cm."""
    places = dict(zip(("PI", "PE", "TI", "TE"), _PLACES, strict=True))
    cells = {n: Cell(1e-3 * float(rng.uniform(0.95, 1.05)), float(rng.normal(0, 1)), 3.0)
             for n in places}  # fmt: skip
    bench = ["cella\tpeso [g]\tlettura"]
    for n, one in cells.items():
        for g in (0, 500, 1000, 2000, 3000, 2000, 500, 0):
            bench.append(f"{n}\t{g}\t{one.read(np.array(g / 1000 * G), rng):.0f}")
    shape = np.linalg.pinv(np.column_stack([np.ones(4), _PLACES]).T)
    holes = {f"{r}{c}": (x, y) for r, x in zip("ABCDE", np.linspace(-5, 5, 5), strict=True)
             for c, y in zip((1, 2, 3), (-2.5, 0, 2.5), strict=True)}  # fmt: skip
    lines = ["giro\tforo\t" + "\t".join(f"{n}_conteggi" for n in places)]
    for lap in (1, 2):
        for hole in ("vuoto", *holes):
            x, y = holes.get(hole, (0.0, 0.0))
            load = 2.5 * G * (hole != "vuoto") * shape @ [1, x / 100, y / 100]
            read = [f"{c.read(np.array(n), rng):.0f}"
                    for c, n in zip(cells.values(), load, strict=True)]  # fmt: skip
            lines.append("\t".join([f"{lap}", hole, *read]))
    sheet = ["foro\tx_cm\ty_cm", *(f"{h}\t{x:g}\t{y:g}" for h, (x, y) in holes.items())]
    notes = write(to / "note.md", [
        "Piede destro sul banco, peso campione di 2,5 kg appoggiato sui fori.", "",
        "| cella | x (cm) | y (cm) |", "| --- | --- | --- |",
        *(f"| {n} | {100 * x:g} | {100 * y:g} |" for n, (x, y) in places.items()),
    ])  # fmt: skip
    paths = [write(to / "taratura_celle.txt", bench), write(to / "fori.txt", sheet),
             write(to / "appoggi.txt", lines), notes]  # fmt: skip
    values = {f"{n.lower()}_conteggi.scale": c.scale for n, c in cells.items()}
    return Made(paths, Truth(values, dict.fromkeys(values, 1e-5)))


def japanese_plates(to: Path, rng: Rng) -> Made:
    """A person on two plates, full six components each, force on the ground, mass in a comment."""
    from tests.strangers.rigs import on_two_plates

    gain = (1.03, 0.97)
    fz = on_two_plates(61.5, gain, rng)
    n = fz.shape[1]
    x, y = rng.normal(0, 0.004, (2, 2, n))
    columns, names = [np.arange(n) / 50], ["時間[s]"]
    for p in (0, 1):
        side = rng.normal(0, 1, (2, n))
        columns += [*side, fz[p], y[p] * fz[p], -x[p] * fz[p], 0.02 * side[0]]
        names += [
            f"P{p + 1}_{a}" for a in ("Fx[N]", "Fy[N]", "Fz[N]", "Mx[Nm]", "My[Nm]", "Mz[Nm]")
        ]
    lines = ["# 被験者: S03, 体重: 61.5 kg", "# フォースプレート 2枚", ",".join(names),
             *rows(*columns, form="%.5f")]  # fmt: skip
    values = {f"p_{i + 1}_plate.scale": g for i, g in enumerate(gain)}
    return Made([write(to / "静止立位.csv", lines, "cp932")],
                Truth(values, dict.fromkeys(values, 0.1)))  # fmt: skip


def german_protocol(to: Path, rng: Rng) -> Made:
    """`AI0 … AI3` of a logger; a protocol whose cell is a text, its channel in the notes."""
    words = ("vorne links", "vorne rechts", "hinten links", "hinten rechts")
    cells = {w: cell(rng, "volt") for w in words}
    log, protocol, t = ["Zeit (ms);AI0;AI1;AI2;AI3"], ["Start (s);Ende (s);Zelle;Gewicht (g)"], 0.0
    for word in words:
        for g in (0, 500, 1000, 2000, 0):
            protocol.append(f"{t + 1.5:.1f};{t + 7.5:.1f};{word};{g}")
            for i in range(90):
                load = {w: g / 1000 * G * (w == word and i >= 10) for w in words}
                read = [c.read(np.array(load[w]), rng, whole=False) for w, c in cells.items()]
                log.append(f"{1e3 * t + 100 * i:.0f};" + ";".join(f"{v:.5f}" for v in read))
            t += 9.0
    notes = write(to / "LIESMICH.md", ["# Kalibrierung", "", "Spannungen in V.",
                  *(f"AI{i}: Zelle {w}" for i, w in enumerate(words))])  # fmt: skip
    paths = [write(to / "messung.csv", [log[0], *comma(log[1:])]),
             write(to / "protokoll.csv", [protocol[0], *comma(protocol[1:])]), notes]  # fmt: skip
    return Made(paths, truth_of(dict(cells.items())))


def events_of_a_capture(to: Path, rng: Rng) -> Made:
    """Events of a motion capture: `Context,Name,Start (s),End (s)`, weights in their names."""
    names = ("FL", "FR", "RL", "RR")
    cells = {n: cell(rng, "adc12") for n in names}
    log, events, t = (
        ["time," + ",".join(f"LC_{n}" for n in names)],
        ["Context,Name,Start (s),End (s)"],
        0.0,
    )
    for n in names:
        for kg in (0, 1, 2, 5, 10):
            events.append(f"{n},{kg} kg,{t + 1:.2f},{t + 4:.2f}")
            for i in range(125):
                on = kg * G * (10 < i < 112)
                read = [c.read(np.array(on * (m == n)), rng) for m, c in cells.items()]
                log.append(f"{t + 0.04 * i:.2f}," + ",".join(f"{v:.0f}" for v in read))
            t += 5.0
    paths = [write(to / "static_cal.csv", log), write(to / "static_cal_events.csv", events)]
    return Made(paths, truth_of(dict(cells.items()), 100))


def cells_in_millivolts(to: Path, rng: Rng) -> Made:
    """A file for each cell, pounds and mV/V with their scatter; the empty rows come first."""
    paths, cells = [], {}
    for name in ("heel_in", "heel_out", "toe_in", "toe_out"):
        one = Cell(40.0 * float(rng.uniform(0.95, 1.05)), float(rng.normal(0, 1)), 5e-4)
        cells[name] = one
        lines = ["Load [lbf],Mean [mV/V],SD [mV/V],N", "0,0,0,0"] if name == "toe_out" else [
            "Load [lbf],Mean [mV/V],SD [mV/V],N"]  # fmt: skip
        for lb in (0, 0, 5, 10, 20, 40, 20, 10, 5, 0):
            mean = one.read(np.array(lb * POUND), rng, whole=False)
            lines.append(f"{lb},{mean:.5f},{rng.uniform(3e-4, 6e-4):.5f},200")
        lines = [x for x in lines if x != "0,0,0,0"]
        paths.append(write(to / f"{name}.csv", lines))
    return Made(paths, truth_of(cells, 200))


def mexican_wrist(to: Path, rng: Rng) -> Made:
    """A sheet of holds with a mean and an SD column for each axis, ways in words, N cm."""
    made = tool(rng)
    ways = {"X arriba": [-1, 0, 0], "X abajo": [1, 0, 0], "Y arriba": [0, -1, 0],
            "Y abajo": [0, 1, 0], "Z arriba": [0, 0, -1], "Z abajo": [0, 0, 1]}  # fmt: skip
    axes = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")
    units = ["N"] * 3 + ["N·cm"] * 3
    head = ["Toma", "Orientación"]
    head += [f"{a} {k} ({u})" for a, u in zip(axes, units, strict=True) for k in ("media", "DE")]
    lines, number = [";".join(head)], 0
    for _ in range(2):
        for way, down in ways.items():
            number += 1
            mean = made.read(np.array([down], float), rng)[0] * ([1.0] * 3 + [100.0] * 3)
            pairs = np.column_stack([mean, rng.uniform(0.05, 0.2, 6)]).ravel()
            lines.append(";".join([f"{number}", way, *(f"{v:.4f}" for v in pairs)]))
    notes = write(to / "notas.md", ["La orientación dice qué eje del sensor apunta hacia arriba."])
    return Made([write(to / "muneca.csv", [lines[0], *comma(lines[1:])]), notes], tool_truth(made))


def finnish_hexapod(to: Path, rng: Rng) -> Made:
    """A folder for each attitude, in it a file for each leg: kgf, kgf·cm, hip angles in degrees."""
    turned = {"EV": 30.0, "KV": 90.0, "TV": 150.0, "EO": -30.0, "KO": -90.0, "TO": -150.0}
    made = legs(rng, {n: Rotation.from_euler("z", a, degrees=True) for n, a in turned.items()})
    paths = []
    for up, down in UP.items():
        folder = to / f"{up[1].upper()}_{'ylos' if up[0] == '+' else 'alas'}"
        folder.mkdir()
        for name, leg in made.items():
            angle = swings(140)
            read = leg.read(angle, np.array(down), rng) / ([G] * 3 + [G / 100] * 3)
            head = ["aika [s];lonkka [°];Fx [kgf];Fy [kgf];Fz [kgf];Mx [kgf·cm];My [kgf·cm];"
                    "Mz [kgf·cm]"]  # fmt: skip
            body = comma(
                rows(0.1 * np.arange(140), np.degrees(angle), *read.T, sep=";", form="%.5f")
            )
            paths.append(write(folder / f"jalka_{name}.csv", head + body))
    said = "Robotti riippuu; kansion nimi kertoo rungon akselin, joka osoittaa ylös tai alas."
    notes = write(to / "lue.md", [said])
    return Made([*paths, notes], leg_truth(made))


def hexapod_with_its_feet(to: Path, rng: Rng) -> Made:
    """Hung and stood with joints and places of the feet beside the wrenches, angles in degrees."""
    names = ("LF", "LM", "LR", "RR", "RM", "RF")
    called = dict(zip(names, ("fl", "ml", "rl", "rr", "mr", "fr"), strict=True))
    hang, stand, hung, stood, truth = _posed(rng, names)
    paths = []
    for file, wrench, body, hold in (
        ("hang_run1", hang, hung, 30),
        ("poses_run1", stand, stood, _HELD),
    ):
        n = len(body)
        head = ["t_s", "pose_no", "roll[deg]", "pitch[deg]", "yaw[deg]"]
        data = [
            np.arange(n) / 50,
            np.arange(n) // hold + 1.0,
            *body.as_euler("xyz", degrees=True).T,
        ]
        for i, leg in enumerate(names):
            head += [f"{leg}_coxa", f"{leg}_femur", f"{leg}_tibia"]
            data += [np.repeat(rng.normal(0, 0.2, n // hold), hold) for _ in range(3)]
            head += [f"{leg}_foot_{a}" for a in "xyz"]
            data += [v + rng.normal(0, 1e-3, n) for v in 1.4 * _HIPS[i] - [0, 0, 0.2]]
            head += [f"{leg}_F{a}" for a in "xyz"] + [f"{leg}_M{a}" for a in "xyz"]
            data += [*wrench[leg].T]
        paths.append(write(to / f"{file}.csv", [",".join(head), *rows(*data, form="%.7g")]))
    sheet = ["leg,x_m,y_m,z_m", *(f"{n},{x:g},{y:g},{z:g}"
                                  for n, (x, y, z) in zip(names, _HIPS, strict=True))]  # fmt: skip
    return Made([*paths, write(to / "hips.csv", sheet)], _renamed(truth, called))


def arm_of_vectors(to: Path, rng: Rng) -> Made:
    """An arm's log: `pose[0..5]` in mm and a rotation vector, `ft[0..5]`; units above the table."""
    made, wrench, rot = wrist(rng, 14, 40)
    vector = rot.as_rotvec()
    place = np.repeat(rng.uniform(-400, 400, (14, 3)), 40, axis=0)
    head = [
        "timestamp",
        *(f"actual_TCP_pose[{i}]" for i in range(6)),
        *(f"ft_raw[{i}]" for i in range(6)),
    ]
    head += [f"actual_q[{i}]" for i in range(6)]
    joints = np.repeat(rng.uniform(-2, 2, (14, 6)), 40, axis=0)
    body = rows(0.008 * np.arange(560), *place.T, *vector.T, *wrench.T, *joints.T, form="%.6f")
    lines = ["# recorder v2, position mm, rotation vector rad, ft in N / Nm", ",".join(head), *body]
    return Made([write(to / "record_0007.csv", lines)], tool_truth(made))


THIRTY_SEVENTH = (
    danish_feet, daq_channels_of_feet, brazilian_ankles, french_soles, row_for_each_stance,
    italian_counts_and_holes, japanese_plates, german_protocol, events_of_a_capture,
    cells_in_millivolts, mexican_wrist, finnish_hexapod, hexapod_with_its_feet, arm_of_vectors,
)  # fmt: skip
