"""Stands of robots as their tools log them: no acceleration, a plate below, a sheet of places.

Written before it was run; `docs/bring_your_log.md` has its first count. The robots stand on cells
or on ankles in poses that shift their weight and lift a foot now and then.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tests.strangers.rigs import Array, G, Made, Rng, Truth, filled, rows, write

_SIDES = ("left", "right")
_RATE, _HOLD, _MOVE, _STANCES = 50.0, 3.0, 0.6, 16
_CELLS = np.array([[0.05, 0.03], [0.05, -0.03], [-0.05, 0.03], [-0.05, -0.03]])
_MASS = 4.6


@dataclass(frozen=True)
class Stand:
    """A robot that stands: stamps in s, CoM (n, 3) in m, vertical force (n, 2) and cells (n, 8)."""

    time: Array
    com: Array
    load: Array
    cells: Array
    feet: Array


def _stand(rng: Rng, *, lifts: bool = True) -> Stand:
    """Stances that the body glides between: the CoM stands above the CoP, ``f = W A⁺ [1, x, y]``.

    A foot's load is shared by its four cells so that they give its force and CoP, and differ by
    a twist (a floor is never even).
    """
    glide, hold = int(_MOVE * _RATE), int(_HOLD * _RATE)
    share, cop = [np.full(hold, 0.5)], [np.zeros((hold, 2, 2))]
    twist, up = [np.zeros((hold, 2))], [np.zeros((hold, 2))]
    for k in range(_STANCES):
        one = lifts and k % 4 == 3
        wanted = float(k // 4 % 2) if one else rng.uniform(0.25, 0.75)
        at = rng.uniform(-0.5, 0.5, (2, 2)) * [0.05, 0.03]
        turned = rng.uniform(-0.05, 0.05, 2)
        s = np.concatenate([np.linspace(0, 1, glide), np.ones(hold)])
        share.append(share[-1][-1] + (wanted - share[-1][-1]) * s)
        cop.append(cop[-1][-1] + (at - cop[-1][-1]) * s[:, None, None])
        twist.append(twist[-1][-1] + (turned - twist[-1][-1]) * s[:, None])
        aloft = np.array([one and wanted == 0.0, one and wanted == 1.0])
        up.append(0.02 * aloft * (s == 1.0)[:, None])
    r, q = np.concatenate(share), np.concatenate(cop)
    load = _MASS * G * np.column_stack([r, 1 - r])
    feet = np.zeros((r.size, 2, 3))
    feet[:, 0, 1], feet[:, 1, 1] = 0.05, -0.05
    feet[:, :, 2] = np.concatenate(up)
    whole = np.einsum("nf,nfk->nk", load, feet[:, :, :2] + q) / (_MASS * G)
    com = np.column_stack([whole, np.full(r.size, 0.26)])
    shape = np.linalg.pinv(np.column_stack([np.ones(4), _CELLS]).T)
    uneven = np.concatenate(twist)[:, :, None] * [1.0, -1.0, -1.0, 1.0]
    moments = np.concatenate([np.ones((r.size, 2, 1)), q], axis=2)
    each = load[:, :, None] * (np.einsum("ck,nfk->nfc", shape, moments) + uneven)
    return Stand(np.arange(r.size) / _RATE, com, load, each.reshape(-1, 8), feet)


def _counts(stand: Stand, rng: Rng) -> tuple[Array, Array]:
    """Counts of the cells, and their scales."""
    scale = 1e-4 * (1 + 0.02 * rng.normal(size=8))
    force = stand.cells + rng.normal(0, 0.02, stand.cells.shape)
    return np.round((force - rng.normal(0, 0.1, 8)) / scale), scale


def _truth(names: list[str], scale: Array) -> Truth:
    """Scales to 5 %: two sd of a nameplate of 2 % that a stand narrows, and the mass."""
    ends = {f"{n}.scale": float(s) for n, s in zip(names, scale, strict=True)}
    return Truth(ends, dict.fromkeys(ends, 5e-6))


def _told(*, mass: bool = True, places: bool = True) -> Callable[[str], str]:
    """What the owner fills in: the mass, the data sheet's scale and where the cells sit."""

    def fill(text: str) -> str:
        if mass:
            text = filled(mass_kg=str(_MASS))(text)
        text = text.replace("# [robot.nameplate]", "[robot.nameplate]")
        text = re.sub(r"# scale_n_per_count = .*", "scale_n_per_count = 1e-4", text)
        if places:
            text = re.sub(r"# (\[robot\.feet\.\w+\.cells\])", r"\1", text)
            at = iter([*_CELLS, *_CELLS])
            text = re.sub(
                r"# (\S+) = \{ x_m = , y_m =  \}",
                lambda m: "{0} = {{ x_m = {1[0]}, y_m = {1[1]} }}".format(m[1], next(at)), text,
            )  # fmt: skip
        return text

    return fill


_WHERE = ("fl", "fr", "rl", "rr")
_NAMES = [f"{side}_{place}" for side in _SIDES for place in _WHERE]


def on_a_plate(to: Path, rng: Rng) -> Made:
    """`L1 … R4` on a force plate: its force is the robot's weight."""
    stand = _stand(rng, lifts=False)
    read, scale = _counts(stand, rng)
    names = [f"{s}{i}" for s in "LR" for i in range(1, 5)]
    plate = _MASS * G + rng.normal(0, 0.05, len(read))
    lines = [",".join(["t", *names, "plate_Fz"]), *rows(stand.time, *read.T, plate, form="%.9g")]
    found = [f"{s}_{i}" for s in _SIDES for i in range(1, 5)]
    return Made([write(to / "plate.csv", lines)], _truth(found, scale), "cells sit",
                fill=_told(mass=False))  # fmt: skip


def sheet_of_places(to: Path, rng: Rng) -> Made:
    """Cells with inner and outer heels, and where they sit in a sheet of millimetres."""
    stand = _stand(rng)
    read, scale = _counts(stand, rng)
    called = [f"{s}_{p}_{q}" for s in "LR" for p in ("toe", "heel") for q in ("in", "out")]
    sheet = ["cell,x_mm,y_mm"]
    sheet += [f"{n},{x:.1f},{y:.1f}" for n, (x, y) in zip(called, 1e3 * np.tile(_CELLS, (2, 1)),
                                                          strict=True)]  # fmt: skip
    lines = [",".join(["millis", *called]), *rows(1e3 * stand.time, *read.T, form="%.9g")]
    zones = [f"{s}_{p}_{q}" for s in _SIDES for p in ("toe", "heel") for q in ("medial", "lateral")]
    files = [write(to / "stand.csv", lines), write(to / "places.csv", sheet)]
    return Made(files, _truth(zones, scale), "weighs", fill=_told(places=False))


def chinese_feet(to: Path, rng: Rng) -> Made:
    """Chinese names of feet, places and the CoM; nothing says its acceleration."""
    stand = _stand(rng)
    read, scale = _counts(stand, rng)
    cells = [f"{s}_{p}" for s in ("左脚", "右脚") for p in ("前左", "前右", "后左", "后右")]
    at = [f"{n}{a}(m)" for n in ("质心", "左脚位置", "右脚位置") for a in "XYZ"]
    body = [*stand.com.T, *stand.feet.reshape(-1, 6).T]
    lines = [",".join(["时间(s)", *cells, *at])]
    lines += rows(stand.time, *read.T, *body, form="%.9g")
    return Made([write(to / "站立.csv", lines, "gbk")], _truth(_NAMES, scale), "cells sit",
                fill=_told())  # fmt: skip


def file_for_each_foot(to: Path, rng: Rng) -> Made:
    """A file for each foot on stamps of its own, and one for the body."""
    stand = _stand(rng)
    read, scale = _counts(stand, rng)
    files = []
    for f, side in enumerate(_SIDES):
        at = (stand.time + 1000.0) * 1e6 + 400 * f
        lines = ["timestamp_us,FL,FR,RL,RR", *rows(at, *read[:, 4 * f : 4 * f + 4].T, form="%.12g")]
        files.append(write(to / f"{side}_foot.csv", lines))
    head = ["com", *(f"{side}_foot" for side in _SIDES)]
    lines = [",".join(["timestamp_us", *(f"{n}_{a}" for n in head for a in "xyz")])]
    body = [*stand.com.T, *stand.feet.reshape(-1, 6).T]
    lines += rows((stand.time + 1000.0) * 1e6, *body, form="%.12g")
    files.append(write(to / "body.csv", lines))
    return Made(files, _truth(_NAMES, scale), "cells sit", fill=_told())


def labels_between(to: Path, rng: Rng) -> Made:
    """A serial monitor: `123 L: … R: …`, no header."""
    stand = _stand(rng)
    read, scale = _counts(stand, rng)
    lines = [
        f"{1e3 * t:.0f} L: {' '.join(f'{v:.0f}' for v in r[:4])} "
        f"R: {' '.join(f'{v:.0f}' for v in r[4:])}" for t, r in zip(stand.time, read, strict=True)
    ]  # fmt: skip
    found = [f"{s}_column_{i + 5 * f + 3}" for f, s in enumerate(_SIDES) for i in range(4)]
    return Made([write(to / "serial.log", lines)], _truth(found, scale), "cells sit", fill=_told())


def ankles_with_couples(to: Path, rng: Rng) -> Made:
    """Forces and couples of ankles, a CoM that was asked for and one that was reached, feet."""
    stand = _stand(rng)
    n, offset = stand.time.size, rng.normal(0, 1, (2, 6)) * ([3.0] * 3 + [0.1] * 3)
    head, columns = ["t"], [stand.time]
    whole = stand.feet[:, :, :2]
    cells = stand.cells.reshape(n, 2, 4)
    for f, side in enumerate(("Left", "Right")):
        about = np.column_stack([cells[:, f] @ _CELLS[:, 1], -(cells[:, f] @ _CELLS[:, 0])])
        force = np.column_stack([np.zeros((n, 2)), stand.load[:, f]])
        felt = np.hstack([force, about, np.zeros((n, 1))]) + offset[f]
        felt += rng.normal(0, 1, felt.shape) * ([0.1] * 3 + [0.004] * 3)
        head += [f"{side}FootForceSensor_{a}" for a in ("cx", "cy", "cz", "fx", "fy", "fz")]
        columns += [*felt[:, 3:].T, *felt[:, :3].T]
        head += [f"{side}FootPose_{a}" for a in ("tx", "ty", "tz")]
        columns += [*whole[:, f].T, stand.feet[:, f, 2]]
    head += [f"com_target_{a}" for a in "xyz"] + [f"com_real_{a}" for a in "xyz"]
    columns += [*(stand.com + 0.02).T, *stand.com.T]
    lines = [";".join(head), *rows(*columns, sep=";", form="%.7g")]
    ends = {
        f"{s}.offset_{a}": float(offset[f, i])
        for f, s in enumerate(_SIDES) for i, a in enumerate(("fx", "fy", "fz", "tx", "ty", "tz"))
    }  # fmt: skip
    within = {name: 0.05 if ".offset_t" in name else 0.5 for name in ends}
    return Made([write(to / "log.csv", lines)], Truth(ends, within), "weighs",
                fill=filled(mass_kg=str(_MASS)))  # fmt: skip


THIRTIETH = (
    on_a_plate, sheet_of_places, chinese_feet, file_for_each_foot, labels_between,
    ankles_with_couples,
)  # fmt: skip
