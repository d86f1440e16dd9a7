"""Ten more logs, written after the mends of the thirty-third and run once on them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tests.strangers.legged import _hung
from tests.strangers.rigs import (
    G,
    Made,
    Rng,
    Truth,
    cell,
    rows,
    settling,
    steps,
    tool_truth,
    truth_of,
    wrist,
    write,
)
from tests.strangers.thirty_first_robots import _HELD, _SIX, _posed, _renamed
from tests.strangers.thirty_first_stands import _counts, _march, _owner, _scales, _stances

_POUND = 4.4482216


def sum_beside_cells(to: Path, rng: Rng) -> Made:
    """Four cells and their sum, the pressed one by a number from 0 on, grams."""
    cells = [cell(rng, "hx_small") for _ in range(4)]
    lines = ["time_ms,active,weight_g,lc0,lc1,lc2,lc3,sum"]
    t = 0
    for on in range(4):
        for g in (0, 100, 200, 500, 1000):
            for _ in range(5):
                read = [float(c.read(np.array(g / 1000 * G * (i == on)), rng))
                        for i, c in enumerate(cells)]  # fmt: skip
                lines.append(",".join(f"{v:.0f}" for v in (t, on, g, *read, sum(read))))
                t += 50
    truth = truth_of({str(i): c for i, c in enumerate(cells)}, 10)
    return Made([write(to / "quad.csv", lines)], truth)


def pounds_in_quadrants(to: Path, rng: Rng) -> Made:
    """A file for each quadrant and weight in pounds: `Q1_2.5lb.csv`, four readings in each."""
    cells, paths = {f"Q{i}": cell(rng) for i in range(1, 5)}, []
    for name in cells:
        for lb in (0, 2.5, 5, 10):
            load = steps((lb * _POUND,), 15)
            read = [c.read(load * (n == name), rng) for n, c in cells.items()]
            lines = ["ms,Q1,Q2,Q3,Q4", *rows(12.5 * np.arange(15), *read)]
            paths.append(write(to / f"{name}_{lb:g}lb.csv", lines))
    return Made(paths, truth_of({n[1]: c for n, c in cells.items()}, 50))


def newtons_and_a_total(to: Path, rng: Rng) -> Made:
    """Feet in newtons with a total for each, the CoM in centimetres, no feet's places."""
    stand = _stances(rng)
    gain = 1 + 0.02 * rng.normal(0, 1, 8)
    read = (stand.cells + rng.normal(0, 0.02, stand.cells.shape)) / gain
    total = read.reshape(-1, 2, 4).sum(axis=2)
    head = ["t"]
    for s in ("L", "R"):
        head += [*(f"{s}_{p}_N" for p in ("FL", "FR", "RL", "RR")), f"{s}_total_N"]
    columns = [np.hstack([read[:, 4 * f : 4 * f + 4], total[:, f : f + 1]]) for f in (0, 1)]
    head += [f"CoM_{a}_cm" for a in "xyz"]
    body = [*np.hstack(columns).T, *(1e2 * stand.com).T]
    lines = [",".join(head), *rows(stand.time, *body, form="%.7g")]
    names = [f"{s}_{p}" for s in ("left", "right") for p in ("fl", "fr", "rl", "rr")]
    return Made([write(to / "balance.csv", lines)], _scales(names, gain), "cells sit",
                fill=_owner(per_count=""))  # fmt: skip


def minutes_and_temperature(to: Path, rng: Rng) -> Made:
    """One cell over an hour: minutes, degrees, a load in kilograms, a reading in mV/V."""
    one = cell(rng, "volt")
    kg = steps((0, 5, 10, 20, 10, 0), 40)
    warm = 21 + 0.5 * np.sin(np.arange(kg.size) / 50)
    lines = ["t/min\tT/°C\tm/kg\tU/(mV/V)",
             *rows(np.arange(kg.size) / 4, warm, kg, one.read(kg * G, rng, whole=False), sep="\t",
                   form="%.6g")]  # fmt: skip
    return Made([write(to / "kriechen.dat", lines)], truth_of(one, 200))


def matlab_table(to: Path, rng: Rng) -> Made:
    """`writetable` of matrices: `cells_left_1 …`, `com_1 … 3`, `foot_left_1 … 3`."""
    walk = _march(rng)
    read, scale = _counts(walk.cells, rng)
    head = ["t", *(f"cells_{s}_{i}" for s in ("left", "right") for i in range(1, 5))]
    head += [f"{n}_{i}" for n in ("com", "acc_com", "foot_left", "foot_right") for i in (1, 2, 3)]
    body = [*walk.com.T, *walk.acc.T, *walk.feet.reshape(-1, 6).T]
    lines = [",".join(head), *rows(walk.time, *read.T, *body, form="%.9g")]
    names = [f"{s}_{i}" for s in ("left", "right") for i in range(1, 5)]
    return Made([write(to / "walk.csv", lines)], _scales(names, scale), "cells sit",
                fill=_owner())  # fmt: skip


def portuguese_feet(to: Path, rng: Rng) -> Made:
    """`Pé esquerdo célula 1 …`, the centre of mass as `centro de massa x (mm)`."""
    stand = _stances(rng)
    read, scale = _counts(stand.cells, rng)
    head = ["Tempo (s)", *(f"Pé {s} célula {i}" for s in ("esquerdo", "direito")
                           for i in range(1, 5))]  # fmt: skip
    head += [f"centro de massa {a} (mm)" for a in "xyz"]
    lines = [";".join(head), *(x.replace(".", ",") for x in
             rows(stand.time, *read.T, *(1e3 * stand.com).T, sep=";", form="%.9g"))]  # fmt: skip
    names = [f"pe_{s}_celula_{i}" for s in ("esquerdo", "direito") for i in range(1, 5)]
    return Made([write(to / "em pé.csv", lines, "cp1252")], _scales(names, scale), "cells sit",
                fill=_owner())  # fmt: skip


def azimuth_first(to: Path, rng: Rng) -> Made:
    """A tool in a dozen attitudes: azimuth, pitch and roll of a compass in degrees."""
    made, wrenches, body = wrist(rng, hold=30)
    yaw, pitch, roll = body.as_euler("ZYX", degrees=True).T
    head = "Time;Azimuth;Pitch;Roll;F_x;F_y;F_z;T_x;T_y;T_z"
    lines = [head, *rows(0.02 * np.arange(len(yaw)), yaw, pitch, roll, *wrenches.T, sep=";",
                         form="%.5f")]  # fmt: skip
    return Made([write(to / "session.csv", lines)], tool_truth(made))


def hip_folders(to: Path, rng: Rng) -> Made:
    """A folder for each leg with the same file name, an IMU in another folder."""
    names = ("leg_lf", "leg_lm", "leg_lr", "leg_rf", "leg_rm", "leg_rr")
    wrenches, t, body, truth = _hung(rng, names)
    paths = []
    for name, wrench in wrenches.items():
        (to / name).mkdir()
        lines = ["time,fx,fy,fz,mx,my,mz", *rows(t, *wrench.T, form="%.6g")]
        paths.append(write(to / name / "wrench.csv", lines))
    (to / "imu").mkdir()
    lines = ["time,qx,qy,qz,qw", *rows(t, *body.as_quat().T, form="%.7g")]
    called = dict(zip(names, ("fl", "ml", "rl", "fr", "mr", "rr"), strict=True))
    return Made([*paths, write(to / "imu" / "attitude.csv", lines)], _renamed(truth, called))


def person_steps_between_plates(to: Path, rng: Rng) -> Made:
    """Two plates in Fz alone, kilograms-force, an empty start, the mass above in German."""
    share = settling([0.35, 0.55, 0.7, 0.4, 0.6, 0.5], 5, 50)
    mass, gain = 64.0, (1.03, 0.97)
    fz = np.array([share, 1 - share]) * mass / np.array(gain)[:, None]
    fz += rng.normal(0, 0.1, fz.shape)
    lines = ["Proband: P12; Körpergewicht: 64 kg", "Zeit [s];Platte 1 Fz [kgf];Platte 2 Fz [kgf]"]
    lines += [x.replace(".", ",") for x in
              rows(np.arange(share.size) / 50, *fz, sep=";", form="%.6g")]  # fmt: skip
    values = {f"{i}_plate.scale": g for i, g in zip("12", gain, strict=True)}
    return Made([write(to / "platten.csv", lines, "cp1252")],
                Truth(values, dict.fromkeys(values, 0.1)))  # fmt: skip


def poses_with_contacts(to: Path, rng: Rng) -> Made:
    """Hung and stood in one file, a column that says which: `phase` of hang and stand."""
    names = ("L1", "L2", "L3", "R3", "R2", "R1")
    hang, stand, hung, stood, truth = _posed(rng, names)
    lines = [",".join(["t", "phase", "pose", "roll_deg", "pitch_deg", "yaw_deg",
                       *(f"{n}_{a}" for n in names for a in _SIX)])]  # fmt: skip
    at = 0.0
    for called, wrench, body, hold in (("hang", hang, hung, 30), ("stand", stand, stood, _HELD)):
        angles = body.as_euler("xyz", degrees=True)
        for i in range(len(angles)):
            felt = np.hstack([wrench[n][i] for n in names])
            said = ",".join(f"{v:.6g}" for v in (*angles[i], *felt))
            lines.append(f"{at:.2f},{called},{i // hold + 1},{said}")
            at += 0.02
    return Made([write(to / "session.csv", lines)], truth, "hanging calibration")


THIRTY_FOURTH = (
    sum_beside_cells, pounds_in_quadrants, newtons_and_a_total, minutes_and_temperature,
    matlab_table, portuguese_feet, azimuth_first, hip_folders, person_steps_between_plates,
    poses_with_contacts,
)  # fmt: skip
