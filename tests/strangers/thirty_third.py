"""Ten more logs, written after the mends of the thirty-second and run once on them."""

from __future__ import annotations

from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from tests.strangers.legged import _hung
from tests.strangers.rigs import (
    G,
    Made,
    Rng,
    Truth,
    cell,
    filled,
    rows,
    settling,
    tool_truth,
    truth_of,
    wrist,
    write,
)
from tests.strangers.thirty_first_robots import _HIPS, _SIX, _posed, _renamed
from tests.strangers.thirty_first_stands import _MASS, _counts, _march, _owner, _scales, _stances

_LARGEST = 8388607


def end_of_the_converter(to: Path, rng: Rng) -> Made:
    """Four cells one by one; the converter ends before the largest weight on one of them."""
    cells = {n: cell(rng) for n in ("fl", "fr", "rl", "rr")}
    lines = ["cell_loaded,mass_g,fl,fr,rl,rr"]
    for name in cells:
        for g in (0, 500, 1000, 2000, 4000):
            for _ in range(4):
                read = [float(c.read(np.array(g / 1000 * G * (n == name)), rng))
                        for n, c in cells.items()]  # fmt: skip
                read[1] = read[1] if read[1] < 7_900_000 else float(_LARGEST)
                said = ",".join(f"{min(v, _LARGEST):.0f}" for v in read)
                lines.append(f"{name.upper()},{g},{said}")
    truth = truth_of({n.upper(): c for n, c in cells.items() if n != "fr"}, 40)
    return Made([write(to / "bench.csv", lines)], truth)


def centimetres_and_degrees(to: Path, rng: Rng) -> Made:
    """A march in centimetres, accelerations in cm/s², the feet's yaw in degrees."""
    walk = _march(rng)
    read, scale = _counts(walk.cells, rng)
    head = ["t_ms", *(f"{s}{p}" for s in ("LF_", "RF_") for p in ("fl", "fr", "rl", "rr"))]
    head += [f"com_{a}_cm" for a in "xyz"]
    head += [
        f"{s}_foot_{a}" for s in ("left", "right") for a in ("x_cm", "y_cm", "z_cm", "yaw_deg")
    ]
    n = walk.time.size
    places = [np.column_stack([1e2 * walk.feet[:, f], rng.normal(0, 0.3, n)]) for f in (0, 1)]
    lines = [",".join(head), *rows(1e3 * walk.time, *read.T, *(1e2 * walk.com).T,
                                   *np.hstack(places).T, form="%.9g")]  # fmt: skip
    names = [f"{s}_{p}" for s in ("left", "right") for p in ("fl", "fr", "rl", "rr")]
    return Made([write(to / "march.csv", lines)], _scales(names, scale), "cells sit",
                fill=_owner())  # fmt: skip


def gravity_not_acceleration(to: Path, rng: Rng) -> Made:
    """A driver that reports which way down is in m/s², called acceleration."""
    made, wrenches, body = wrist(rng)
    down = 9.81 * body.inv().apply([0.0, 0.0, -1.0]) + rng.normal(0, 0.03, (len(wrenches), 3))
    head = "stamp;force_x;force_y;force_z;moment_x;moment_y;moment_z;accel_x;accel_y;accel_z"
    lines = [head, *rows(0.01 * np.arange(len(down)), *wrenches.T, *down.T, sep=";", form="%.5g")]
    return Made([write(to / "arm.csv", lines)], tool_truth(made))


def polish_bench(to: Path, rng: Rng) -> Made:
    """Polish: a cell, a mass in kilograms, readings; numbers with commas."""
    cells, lines = {"lewy": cell(rng), "prawy": cell(rng)}, ["Lp.;Czujnik;Masa [kg];Odczyt"]
    at = 0
    for name, one in cells.items():
        for kg in (0, 0.5, 1, 2, 5, 1, 0):
            at += 1
            read = one.read(np.array(kg * G), rng)
            lines.append(f"{at};{name};{kg};{read:.0f}".replace(".", ","))
    return Made([write(to / "wzorcowanie.csv", lines, "cp1250")], truth_of(cells, 50))


def russian_stand(to: Path, rng: Rng) -> Made:
    """Russian: four cells of each foot, the mass in a line above."""
    stand = _stances(rng)
    read, scale = _counts(stand.cells, rng)
    head = ["Время, с", *(f"{s} стопа {i}" for s in ("левая", "правая") for i in range(1, 5))]
    lines = ["Масса робота: 5,2 кг", ";".join(head)]
    lines += [x.replace(".", ",") for x in rows(stand.time, *read.T, sep=";", form="%.9g")]
    found = [f"{s}_{i}" for s in ("left", "right") for i in range(1, 5)]
    return Made([write(to / "стойка.csv", lines, "cp1251")], _scales(found, scale), "cells sit",
                fill=_owner())  # fmt: skip


def insoles_with_weight(to: Path, rng: Rng) -> Made:
    """Two insoles: total force and CoP, the person's weight above in kilograms."""
    share = settling([0.35, 0.55, 0.7, 0.4, 0.6, 0.5], 5, 50)
    mass, gain = 72.0, (1.04, 0.96)
    n = share.size
    fz = np.array([share, 1 - share]) * mass * G / np.array(gain)[:, None]
    fz += rng.normal(0, 1, fz.shape)
    cop = [20 * np.sin(np.arange(n) / 80 + p) + 5 for p in range(4)]
    lines = ["Patient weight: 72 kg", "Time [s]\tLeft Total Force [N]\tLeft CoP X [mm]\t"
             "Left CoP Y [mm]\tRight Total Force [N]\tRight CoP X [mm]\tRight CoP Y [mm]",
             *rows(np.arange(n) / 50, fz[0], cop[0], cop[1], fz[1], cop[2], cop[3], sep="\t",
                   form="%.6g")]  # fmt: skip
    values = {f"{s}_p1.scale": g for s, g in zip(("left", "right"), gain, strict=True)}
    return Made([write(to / "insoles.txt", lines)], Truth(values, dict.fromkeys(values, 0.1)))


def notes_of_who_lay_where(to: Path, rng: Rng) -> Made:
    """A log with ISO stamps, and notes: `14:03:10 - FL - 500 g`."""
    names = ("FL", "FR", "RL", "RR")
    cells, begin, t = {n: cell(rng) for n in names}, datetime(2026, 5, 18, 14, 3, 0), 0.0
    lines, noted = ["timestamp," + ",".join(names)], []
    for name in names:
        for g in (0, 500, 1000, 2000, 0):
            noted.append(f"{begin + timedelta(seconds=t):%H:%M:%S} - {name} - {g} g")
            for i in range(40):
                load = g / 1000 * G * (i > 4)
                read = [c.read(np.array(load * (n == name)), rng) for n, c in cells.items()]
                stamp = (begin + timedelta(seconds=t)).isoformat(timespec="milliseconds")
                lines.append(f"{stamp}," + ",".join(f"{v:.0f}" for v in read))
                t += 0.1
    return Made([write(to / "cells.csv", lines), write(to / "notes.txt", noted)], truth_of(cells))


def plotjuggler_ankles(to: Path, rng: Rng) -> Made:
    """`/left_ankle_ft/wrench/force/x` of a march, the CoM, poses of the feet with orientation."""
    walk = _march(rng)
    offset = rng.normal(0, 1, (2, 6)) * ([2.0] * 3 + [0.05] * 3)
    head, columns, n = ["__time"], [1.7794e9 + walk.time], walk.time.size
    for f, s in enumerate(("left", "right")):
        push = _MASS * walk.acc[:, :2] * (walk.load[:, f : f + 1] / (_MASS * G))
        force = np.column_stack([push, walk.load[:, f]])
        felt = np.hstack([force, np.cross(np.column_stack([walk.cop[:, f], np.zeros(n)]), force)])
        felt += offset[f] + rng.normal(0, 1, felt.shape) * ([0.1] * 3 + [0.004] * 3)
        head += [f"/{s}_ankle_ft/wrench/{k}/{a}" for k in ("force", "torque") for a in "xyz"]
        head += [f"/{s}_foot_pose/pose/position/{a}" for a in "xyz"]
        head += [f"/{s}_foot_pose/pose/orientation/{a}" for a in "xyzw"]
        level = np.tile([0.0, 0.0, 0.0, 1.0], (n, 1))
        columns += [*felt.T, *walk.feet[:, f].T, *level.T]
    head += [f"/com/{k}/{a}" for k in ("position", "velocity", "acceleration") for a in "xyz"]
    speed = np.gradient(walk.com, walk.time, axis=0)
    columns += [*walk.com.T, *speed.T, *walk.acc.T]
    lines = [",".join(head), *rows(*columns, form="%.14g")]
    ends = {f"{s}.offset_{a[0]}{a[1]}": float(offset[f, i])
            for f, s in enumerate(("left", "right")) for i, a in enumerate(_SIX)}  # fmt: skip
    within = {name: 0.05 if ".offset_t" in name else 0.5 for name in ends}
    return Made([write(to / "walk.csv", lines)], Truth(ends, within), "weighs",
                fill=filled(mass_kg=str(_MASS)))  # fmt: skip


def hung_by_scalar_first(to: Path, rng: Rng) -> Made:
    """A hexapod in Excel: `Leg A … F`, quaternions `q0 … q3`, a blank row between holds."""
    names = ("A", "B", "C", "D", "E", "F")
    wrenches, _, body, truth = _hung(rng, names, holds=12, hold=20)
    q = np.roll(body.as_quat(), 1, axis=1)
    head = ["hold", "q0", "q1", "q2", "q3", *(f"Leg {n} {a}" for n in names for a in
                                             ("Fx", "Fy", "Fz", "Mx", "My", "Mz"))]  # fmt: skip
    lines = [",".join(head)]
    for k in range(12):
        own = slice(20 * k, 20 * k + 20)
        felt = np.hstack([w[own] for w in wrenches.values()])
        lines += [*rows(np.full(20, k + 1), *q[own].T, *felt.T, form="%.6g")]
        lines.append("," * (len(head) - 1))
    return Made([write(to / "hang.csv", lines, end="\r\n")],
                _renamed(truth, {n: f"Leg_{n}" for n in names}))  # fmt: skip


def one_row_a_pose(to: Path, rng: Rng) -> Made:
    """Hung in time, and a table of a row for each pose: `Nr`, angles, hips 1 … 6."""
    names = tuple(f"B{i}" for i in range(1, 7))
    hang, stand, hung, stood, truth = _posed(rng, names, poses=40)
    head = ["Nr", "Roll", "Pitch", "Yaw", *(f"{n}_{a}" for n in names for a in _SIX)]
    each = np.arange(0, len(stood), len(stood) // 40)
    angles = stood[each].as_euler("xyz", degrees=True)
    lines = [",".join(head), *rows(np.arange(1, 41), *angles.T, *np.hstack(
        [stand[k][each] for k in names]).T, form="%.7g")]  # fmt: skip
    poses = write(to / "poses.csv", lines)
    head = ["t", "Roll", "Pitch", "Yaw", *(f"{n}_{a}" for n in names for a in _SIX)]
    data = np.hstack([hang[k] for k in names])
    angles = Rotation.from_quat(hung.as_quat()).as_euler("xyz", degrees=True)
    lines = [",".join(head), *rows(np.arange(len(data)) / 50, *angles.T, *data.T, form="%.7g")]
    assert len(_HIPS) == len(names)
    called = _renamed(truth, {n: f"b_{n[1]}" for n in names})
    return Made([write(to / "hang.csv", lines), poses], called)


THIRTY_THIRD = (
    end_of_the_converter, centimetres_and_degrees, gravity_not_acceleration, polish_bench,
    russian_stand, insoles_with_weight, notes_of_who_lay_where, plotjuggler_ankles,
    hung_by_scalar_first, one_row_a_pose,
)  # fmt: skip
