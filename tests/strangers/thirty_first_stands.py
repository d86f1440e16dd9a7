"""Robots and people nobody met that stand and walk, as their tools log them."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np

from tests.strangers.rigs import (
    Array,
    G,
    Made,
    Rng,
    Truth,
    filled,
    rows,
    settling,
    write,
)

_PLACES = np.array([[0.06, 0.035], [0.06, -0.035], [-0.06, 0.035], [-0.06, -0.035]])
_MASS = 5.2
_CELLS = ("fl", "fr", "rl", "rr")


@dataclass(frozen=True)
class _March:
    """A robot that marches: stamps, CoM and its acceleration (n, 3), feet (n, 2, 3), cells (n, 8).

    `load` (n, 2) and `cop` (n, 2, 2), in each foot's frame.
    """

    time: Array
    com: Array
    acc: Array
    feet: Array
    load: Array
    cop: Array
    cells: Array


def _march(rng: Rng, *, steps: int = 40, forward: float = 0.03, rate: float = 100.0) -> _March:
    """A point mass at constant height above feet that swing one after the other.

    The CoM sways as sums of sinusoids; ``zmp = com − z/g · acc``, which both feet share: all on
    one foot while the other swings.
    """
    period, z = 1.2, 0.3
    t = np.arange(0, steps * period / 2, 1 / rate)
    omega = 2 * np.pi / period
    speed = forward / (period / 2)
    far = rng.uniform(0.004, 0.008, 3)
    slow = 2 * np.pi * np.array([0.11, 0.23, 0.37])
    x = speed * t + (far[:, None] * np.sin(slow[:, None] * t)).sum(0)
    ax = -(far[:, None] * slow[:, None] ** 2 * np.sin(slow[:, None] * t)).sum(0)
    wide = 0.05
    gain = 1 + z / G * omega**2
    y = 1.25 * wide / gain * np.sin(omega * t)
    ay = -(omega**2) * y
    com = np.column_stack([x, y, np.full(t.size, z)])
    acc = np.column_stack([ax, ay, np.zeros(t.size)])
    zmp = com[:, :2] - z / G * acc[:, :2]
    left = np.clip((zmp[:, 1] + wide) / (2 * wide), 0, 1)
    feet = np.zeros((t.size, 2, 3))
    feet[:, 0, 1], feet[:, 1, 1] = wide, -wide
    for f, share in enumerate((left, 1 - left)):
        up = share <= 0
        edges = np.flatnonzero(np.diff(np.concatenate([[0], up.astype(int), [0]])))
        at, last = 0.0, 0
        for a, b in zip(edges[::2], edges[1::2], strict=True):
            feet[last:a, f, 0] = at
            middle = float(x[min(b + int(0.25 * rate), t.size - 1)])
            s = np.linspace(0, 1, b - a)
            feet[a:b, f, 0] = at + (middle - at) * (3 * s**2 - 2 * s**3)
            feet[a:b, f, 2] = 0.03 * np.sin(np.pi * s)
            at, last = middle, b
        feet[last:, f, 0] = at
    load = _MASS * G * np.column_stack([left, 1 - left])
    cop = zmp[:, None, :] - feet[:, :, :2]
    cop[:, :, 1] = np.where(load > 0, np.clip(cop[:, :, 1], -0.03, 0.03), 0)
    # in double support both feet bear at their middle line: y is shared by the loads alone
    both = (left > 0) & (left < 1)
    cop[both, :, 1] = 0.0
    shape = np.linalg.pinv(np.column_stack([np.ones(4), _PLACES]).T)
    moments = np.concatenate([np.ones((t.size, 2, 1)), cop], axis=2)
    each = load[:, :, None] * np.einsum("ck,nfk->nfc", shape, moments)
    return _March(t, com, acc, feet, load, cop, each.reshape(-1, 8))


def _stances(rng: Rng, mass: float = _MASS, stances: int = 18) -> _March:
    """Two feet on the ground, poses glided between: the weight on either, the CoP anywhere."""
    rate, hold, glide = 50.0, 140, 30
    share, cop = [np.full(hold, 0.5)], [np.zeros((hold, 2, 2))]
    twist = [np.zeros((hold, 2))]
    for _ in range(stances):
        s = np.concatenate([np.linspace(0, 1, glide), np.ones(hold)])
        share.append(share[-1][-1] + (rng.uniform(0.15, 0.85) - share[-1][-1]) * s)
        at = rng.uniform(-0.6, 0.6, (2, 2)) * _PLACES[0]
        cop.append(cop[-1][-1] + (at - cop[-1][-1]) * s[:, None, None])
        turned = rng.uniform(-0.06, 0.06, 2)
        twist.append(twist[-1][-1] + (turned - twist[-1][-1]) * s[:, None])
    r, q = np.concatenate(share), np.concatenate(cop)
    load = mass * G * np.column_stack([r, 1 - r])
    feet = np.zeros((r.size, 2, 3))
    feet[:, 0, 1], feet[:, 1, 1] = 0.06, -0.06
    whole = np.einsum("nf,nfk->nk", load, feet[:, :, :2] + q) / (mass * G)
    com = np.column_stack([whole, np.full(r.size, 0.31)])
    shape = np.linalg.pinv(np.column_stack([np.ones(4), _PLACES]).T)
    moments = np.concatenate([np.ones((r.size, 2, 1)), q], axis=2)
    uneven = np.concatenate(twist)[:, :, None] * [1.0, -1.0, -1.0, 1.0]
    each = load[:, :, None] * (np.einsum("ck,nfk->nfc", shape, moments) + uneven)
    t = np.arange(r.size) / rate
    return _March(t, com, np.zeros_like(com), feet, load, q, each.reshape(-1, 8))


def _counts(cells: Array, rng: Rng, per_count: float = 1e-4) -> tuple[Array, Array]:
    """Counts of eight cells, and their scales."""
    scale: Array = per_count * (1 + 0.02 * rng.normal(0, 1, (cells.shape[1],)))
    zero = rng.normal(0, 0.1, cells.shape[1])
    return np.round((cells + rng.normal(0, 0.02, cells.shape) - zero) / scale), scale


def _scales(names: list[str], scale: Array, within: float = 0.04) -> Truth:
    ends = {f"{n}.scale": float(s) for n, s in zip(names, scale, strict=True)}
    return Truth(ends, {n: within * abs(v) for n, v in ends.items()})


def _owner(*, mass: float = _MASS, per_count: str = "1e-4") -> Callable[[str], str]:
    """What the owner fills in: the mass, the data sheet's scale and where the cells sit."""

    def fill(text: str) -> str:
        if "# mass_kg =" in text:
            text = filled(mass_kg=str(mass))(text)
        if per_count:
            text = text.replace("# [robot.nameplate]", "[robot.nameplate]")
            text = re.sub(r"# scale_n_per_count = .*", f"scale_n_per_count = {per_count}", text)
        text = re.sub(r"# (\[robot\.feet\.\w+\.cells\])", r"\1", text)
        at = iter([*_PLACES, *_PLACES])
        return re.sub(
            r"# (\S+) = \{ x_m = , y_m =  \}",
            lambda m: "{0} = {{ x_m = {1[0]}, y_m = {1[1]} }}".format(m[1], next(at)), text,
        )  # fmt: skip

    return fill


_EIGHT = [f"{s}_{p}" for s in ("left", "right") for p in _CELLS]


def plotjuggler_stand(to: Path, rng: Rng) -> Made:
    """PlotJuggler: `/left_foot/load_cells/data[0]`, `/com/point/x`, `__time` in s since 1970."""
    stand = _stances(rng)
    read, scale = _counts(stand.cells, rng)
    head = ["__time", *(f"/{s}_foot/load_cells/data[{i}]" for s in ("left", "right")
                        for i in range(4)), *(f"/com/point/{a}" for a in "xyz")]  # fmt: skip
    head += [f"/{s}_foot/pose/position/{a}" for s in ("left", "right") for a in "xyz"]
    body = [*stand.com.T, *stand.feet.reshape(-1, 6).T]
    lines = [",".join(head), *rows(1.7794e9 + stand.time, *read.T, *body, form="%.14g")]
    names = [f"{s}_load_cells_data_{i}" for s in ("left", "right") for i in range(4)]
    return Made([write(to / "stand.csv", lines)], _scales(names, scale), "cells sit",
                fill=_owner())  # fmt: skip


def two_balance_boards(to: Path, rng: Rng) -> Made:
    """Two boards of a console, four corners each in kilograms; a person of 71.3 kg."""
    stand = _stances(rng, 71.3)
    gain = 1 + 0.02 * rng.normal(size=8)
    read = (stand.cells + rng.normal(0, 0.5, stand.cells.shape)) / gain / G
    head = [f"{s}_{p}" for s in ("L", "R") for p in ("TL", "TR", "BL", "BR")]
    lines = ["# WiiBoard logger; corners in kg, subject 12", ",".join(["time", *head]),
             *rows(stand.time, *read.T, form="%.6g")]  # fmt: skip
    names = [f"{s}_{p}" for s in ("left", "right") for p in ("tl", "tr", "bl", "br")]
    return Made([write(to / "boards.csv", lines)], _scales(names, gain), "cells sit",
                fill=_owner(mass=71.3, per_count=""))  # fmt: skip


def merged_french_stand(to: Path, rng: Rng) -> Made:
    """Excel in French: feet and the centre of mass over their columns, millimetres."""
    stand = _stances(rng)
    read, scale = _counts(stand.cells, rng)
    lines = ["Temps;Pied gauche;;;;Pied droit;;;;Centre de masse (mm);;",
             "s;AvG;AvD;ArG;ArD;AvG;AvD;ArG;ArD;X;Y;Z"]  # fmt: skip
    lines += [x.replace(".", ",") for x in
              rows(stand.time, *read.T, *(1e3 * stand.com).T, sep=";", form="%.8g")]  # fmt: skip
    return Made([write(to / "debout.csv", lines, "cp1252")], _scales(_EIGHT, scale), "cells sit",
                fill=_owner())  # fmt: skip


def motive_and_cells(to: Path, rng: Rng) -> Made:
    """OptiTrack's rigid bodies, y up, and the cells' log with stamps of its own board."""
    stand = _stances(rng)
    read, scale = _counts(stand.cells, rng)
    cells = [",".join(["t_ms", *(f"{s}{p}" for s in "LR" for p in ("FL", "FR", "RL", "RR"))]),
             *rows(1e3 * stand.time, *read.T)]  # fmt: skip
    bodies = ("CoM", "LeftFoot", "RightFoot")
    lines = ["Format Version,1.23,Take Name,stand 3,Capture Frame Rate,50.0,Length Units,Meters",
             "", ",," + ",".join(["Rigid Body"] * 21), ",," + ",".join(n for n in bodies for _ in
                                                                      range(7)),
             ",," + ",".join(f'"{i}"' for i in range(1, 4) for _ in range(7)),
             ",," + ",".join((["Rotation"] * 4 + ["Position"] * 3) * 3),
             "Frame,Time (Seconds)," + ",".join(list("XYZWXYZ") * 3)]  # fmt: skip
    one = [np.zeros(stand.time.size)] * 3 + [np.ones(stand.time.size)]
    columns: list[Array] = []
    for at in (stand.com, stand.feet[:, 0], stand.feet[:, 1]):
        at = at + rng.normal(0, 1e-4, at.shape)
        columns += [*one, at[:, 1], at[:, 2], at[:, 0]]  # y up: X is left, Z ahead
    lines += rows(np.arange(stand.time.size), stand.time, *columns, form="%.7g")
    paths = [write(to / "cells.csv", cells), write(to / "Take 2026-05-18.csv", lines)]
    return Made(paths, _scales(_EIGHT, scale), "cells sit", fill=_owner())


def scope_walk(to: Path, rng: Rng) -> Made:
    """Signals of Simulink: `CoM:1`, `ddCoM:1`, `F_left:1 … 4`, `p_left_foot:1`."""
    walk = _march(rng)
    read, scale = _counts(walk.cells, rng)
    head = ["time", *(f"F_{s}:{i}" for s in ("left", "right") for i in range(1, 5))]
    head += [f"{n}:{i}" for n in ("CoM", "ddCoM", "p_left_foot", "p_right_foot") for i in (1, 2, 3)]
    body = [*walk.com.T, *walk.acc.T, *walk.feet.reshape(-1, 6).T]
    lines = [",".join(head), *rows(walk.time, *read.T, *body, form="%.9g")]
    names = [f"{s}_{i}" for s in ("left", "right") for i in range(1, 5)]
    return Made([write(to / "scope.csv", lines)], _scales(names, scale), "cells sit",
                fill=_owner())  # fmt: skip


def nested_json_walk(to: Path, rng: Rng) -> Made:
    """A line of JSON per sample: feet with their cells and place, the CoM with acceleration."""
    walk = _march(rng)
    read, scale = _counts(walk.cells, rng)
    lines = []
    for i, t in enumerate(walk.time):
        feet = {
            s: {"cells": read[i, 4 * f : 4 * f + 4].tolist(),
                "pos": [round(v, 6) for v in walk.feet[i, f].tolist()]}
            for f, s in enumerate(("left", "right"))
        }  # fmt: skip
        com = {"pos": [round(v, 6) for v in walk.com[i].tolist()],
               "acc": [round(v, 5) for v in walk.acc[i].tolist()]}  # fmt: skip
        lines.append(json.dumps({"t": round(float(t), 4), "feet": feet, "com": com}))
    names = [f"{s}_cells_{i}" for s in ("left", "right") for i in range(4)]
    return Made([write(to / "walk.jsonl", lines)], _scales(names, scale), "cells sit",
                fill=_owner())  # fmt: skip


def ankle_walk_by_the_clock(to: Path, rng: Rng) -> Made:
    """Ankles with six axes in kgf and kgf·cm, stamps `HH:MM:SS.mmm`."""
    walk = _march(rng)
    offset = rng.normal(0, 1, (2, 6)) * ([2.0] * 3 + [0.05] * 3)
    head, columns, n = ["clock"], [], walk.time.size
    for f, s in enumerate(("l", "r")):
        push = _MASS * walk.acc[:, :2] * (walk.load[:, f : f + 1] / (_MASS * G))
        force = np.column_stack([push, walk.load[:, f]])
        arm = np.column_stack([walk.cop[:, f], np.zeros(n)])
        felt = np.hstack([force, np.cross(arm, force)]) + offset[f]
        felt += rng.normal(0, 1, felt.shape) * ([0.1] * 3 + [0.004] * 3)
        head += [f"{s}_ankle_{a}[kgf]" for a in ("Fx", "Fy", "Fz")]
        head += [f"{s}_ankle_{a}[kgf.cm]" for a in ("Mx", "My", "Mz")]
        columns += [*(felt[:, :3] / G).T, *(felt[:, 3:] / G * 100).T]
    head += [f"{n}_{a}[m]" for n in ("com", "l_foot", "r_foot") for a in "xyz"]
    head += [f"com_acc_{a}[m/s^2]" for a in "xyz"]
    columns += [*walk.com.T, *walk.feet.reshape(-1, 6).T, *walk.acc.T]
    lines = ["\t".join(head)]
    begin = datetime(2026, 5, 18, 9, 59, 41)
    for t, row in zip(walk.time, np.column_stack(columns), strict=True):
        stamp = (begin + timedelta(seconds=float(t))).strftime("%H:%M:%S.%f")[:-3]
        lines.append("\t".join([stamp, *(f"{v:.7g}" for v in row)]))
    axes = ("fx", "fy", "fz", "tx", "ty", "tz")
    ends = {f"{s}.offset_{a}": float(offset[f, i])
            for f, s in enumerate(("left", "right")) for i, a in enumerate(axes)}  # fmt: skip
    within = {name: 0.05 if ".offset_t" in name else 0.5 for name in ends}
    return Made([write(to / "walk.tsv", lines)], Truth(ends, within), "weighs",
                fill=filled(mass_kg=str(_MASS)))  # fmt: skip


def parquet_of_two_levels(to: Path, rng: Rng) -> Made:
    """pandas' columns of two levels in Parquet: `('left_foot', 'fl')`, `('com_acc', 'x')`."""
    import pandas as pd

    walk = _march(rng)
    read, scale = _counts(walk.cells, rng)
    names = [(f"{s}_foot", p) for s in ("left", "right") for p in _CELLS]
    names += [(n, a) for n in ("com", "com_acc", "left_foot_pos", "right_foot_pos") for a in "xyz"]
    body = [walk.com, walk.acc, walk.feet.reshape(-1, 6)]
    table = pd.DataFrame(np.hstack([read, *body]), columns=pd.MultiIndex.from_tuples(names),
                         index=pd.Index(walk.time, name="t"))  # fmt: skip
    path = to / "walk.parquet"
    table.to_parquet(path)
    return Made([path], _scales(_EIGHT, scale), "cells sit", fill=_owner())


def person_on_two_plates(to: Path, rng: Rng) -> Made:
    """Lab chart: `Plate 1 Fz (kN)`, COP in cm, the person's mass above in pounds."""
    share = settling([0.3, 0.55, 0.7, 0.4, 0.62, 0.5], 5, 50)
    mass, gain = 158.0 * 0.45359237, (1.03, 0.975)
    n = share.size
    fz = np.array([share, 1 - share]) * mass * G / np.array(gain)[:, None]
    fz += rng.normal(0, 1, fz.shape)
    cop = [2 * np.sin(np.arange(n) / 90 + p) + 10 for p in range(4)]
    lines = ["Subject: S07", "Body mass: 158 lb", "Sampling rate: 50 Hz", "",
             "Plate 1 Fz (kN)\tPlate 1 COPx (cm)\tPlate 1 COPy (cm)\tPlate 2 Fz (kN)\t"
             "Plate 2 COPx (cm)\tPlate 2 COPy (cm)",
             *rows(fz[0] / 1e3, cop[0], cop[1], fz[1] / 1e3, cop[2], cop[3], sep="\t",
                   form="%.6g")]  # fmt: skip
    values = {f"plate_{i}_p1.scale": g for i, g in zip("12", gain, strict=True)}
    return Made([write(to / "S07.txt", lines)], Truth(values, dict.fromkeys(values, 0.1)))


THIRTY_FIRST_STANDS = (
    plotjuggler_stand, two_balance_boards, merged_french_stand, motive_and_cells, scope_walk,
    nested_json_walk, ankle_walk_by_the_clock, parquet_of_two_levels, person_on_two_plates,
)  # fmt: skip
