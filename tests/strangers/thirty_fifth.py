"""Six axes beside sheets: of files, of stretches at rest, of times; legs with their own angles."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from tests.strangers.rigs import (
    Array,
    Made,
    Rng,
    Tool,
    Truth,
    rows,
    tool,
    tool_truth,
    wrist,
    write,
)

DOWN = {"X haut": [-1.0, 0, 0], "X bas": [1.0, 0, 0], "Z haut": [0, 0, -1.0], "Z bas": [0, 0, 1.0]}
"""Orientations of a body that hangs, and gravity in it."""


@dataclass(frozen=True)
class Leg:
    """A leg that swings about y of its transducer, and how that is turned in the body."""

    hung: Tool
    mount: Rotation

    def read(self, angle_rad: Array, body_gravity: Array, rng: Rng) -> Array:
        """Wrenches at shaft angles (n,) under one direction of gravity in the body."""
        force = self.hung.weight_n * self.mount.inv().apply(body_gravity)
        com = Rotation.from_euler("y", angle_rad[:, None]).apply(self.hung.com_m)
        noise = rng.normal(0, [0.03] * 3 + [0.002] * 3, (len(angle_rad), 6))
        pulls = np.hstack([np.tile(force, (len(com), 1)), np.cross(com, force)])
        return np.asarray(pulls + self.hung.offset + noise)


def legs(rng: Rng, mounts: dict[str, Rotation]) -> dict[str, Leg]:
    """Legs that hang a hand's breadth below their shafts."""
    made = {}
    for name, mount in mounts.items():
        hung = tool(rng)
        com = np.array([0.01, 0.03, -0.09]) + rng.normal(0, 0.004, 3)
        made[name] = Leg(Tool(hung.weight_n, com, 0.3 * hung.offset), mount)
    return made


def leg_truth(made: dict[str, Leg]) -> Truth:
    """Weights and offsets of force to 0.1 N."""
    values = {f"{name}.weight": leg.hung.weight_n for name, leg in made.items()}
    values |= {
        f"{name}.offset_f{a}": float(leg.hung.offset[i])
        for name, leg in made.items() for i, a in enumerate("xyz")
    }  # fmt: skip
    return Truth(values, dict.fromkeys(values, 0.1))


def swings(count: int, half_width: float = 1.3, turns: int = 2) -> Array:
    """Shaft angles of a slow swing in rad, shape (n,)."""
    return np.asarray(half_width * np.sin(np.linspace(0, 2 * np.pi * turns, count)))


def quaternions_by_number(to: Path, rng: Rng) -> Made:
    """A file for each pose of a wrist, clocks that start anew; x, y, z, w in a table by number."""
    made, wrench, rot = wrist(rng, 18, 40)
    paths = []
    for i, own in enumerate(np.split(wrench, 18)):
        body = rows(0.01 * np.arange(40), *own.T, sep="\t", form="%.5f")
        paths.append(
            write(to / f"stilling{i + 1:02d}.txt", ["tid_s\tFx\tFy\tFz\tTx\tTy\tTz", *body])
        )
    quat = rot.as_quat()[::40]
    body = rows(np.arange(1, 19), *quat.T, sep="\t", form="%.6g")
    sheet = write(to / "flens.tsv", ["stilling\tx\ty\tz\tw", *body])
    return Made([sheet, *paths], tool_truth(made))


def index_of_legs(to: Path, rng: Rng) -> Made:
    """A file for each leg and orientation; an index says which by their names, and what is down."""
    turned = {"A": 30.0, "B": 90.0, "C": -90.0}
    made = legs(rng, {n: Rotation.from_euler("z", a, degrees=True) for n, a in turned.items()})
    index, paths = ["fichier;patte;position;gx;gy;gz"], list[Path]()
    for said, down in DOWN.items():
        for name, leg in made.items():
            angle = swings(160)
            read = leg.read(angle, np.array(down), rng) * ([1.0] * 3 + [1000.0] * 3)
            body = rows(25.0 * np.arange(160), np.degrees(angle), *read.T, sep="\t", form="%.4f")
            path = to / f"mesure_{len(paths) + 1:03d}.txt"
            paths.append(write(path, ["temps\tangle\tFX\tFY\tFZ\tMX\tMY\tMZ", *body]))
            index.append(";".join([path.name, name, said, *(f"{g:.4f}" for g in down)]))
    return Made([*paths, write(to / "index.csv", index)], leg_truth(made))


def _stream(rng: Rng) -> tuple[Tool, Array, Array, Array]:
    """A wrist that goes from rest to rest: tool, stamps, wrenches, angles about x, y, z in deg."""
    made = tool(rng)
    at = rng.uniform([-170, -70, -170], [170, 70, 170], (16, 3))
    share = np.concatenate([np.r_[np.zeros(90), np.linspace(0, 1, 60)] + k for k in range(16)])
    share = np.minimum(share, 15.0)
    angles: Array = np.column_stack([np.interp(share, np.arange(16), at[:, i]) for i in range(3)])
    rot = Rotation.from_euler("xyz", angles, degrees=True)
    wrench = made.read(-rot.as_matrix()[:, 2, :], rng)
    return made, 20.0 * np.arange(len(share), dtype=np.float64), wrench, angles


def stretches_of_a_stream(to: Path, rng: Rng) -> Made:
    """A stream with its moves, torques in N cm, and a list of seconds from and to."""
    made, ms, wrench, angles = _stream(rng)
    wrench = wrench * ([1.0] * 3 + [100.0] * 3)
    names = "ms,F_X,F_Y,F_Z,T_X,T_Y,T_Z,rot_a,rot_b,rot_c"
    stream = write(to / "crudo.csv", [names, *rows(ms, *wrench.T, *angles.T, form="%.4f")])
    starts = 3.0 * np.arange(16)
    body = rows(np.arange(1, 17), starts, starts + 1.7)
    sheet = write(to / "reposo.csv", ["n,desde_s,hasta_s", *body])
    return Made([sheet, stream], tool_truth(made))


def attitudes_of_stretches(to: Path, rng: Rng) -> Made:
    """A stream without an attitude; the list of its stretches at rest has one for each."""
    made, ms, wrench, angles = _stream(rng)
    stream = write(to / "raw.csv", ["ms,Fx,Fy,Fz,Tx,Ty,Tz", *rows(ms, *wrench.T, form="%.4f")])
    starts = 3.0 * np.arange(16)
    body = rows(starts, starts + 1.7, *angles[40::150].T, form="%.4f")
    sheet = write(to / "rest.csv", ["from_s,to_s,roll_deg,pitch_deg,yaw_deg", *body])
    return Made([stream, sheet], tool_truth(made))


def times_on_a_log_sheet(to: Path, rng: Rng) -> Made:
    """Means of a wrist in a table; when each was taken, and how warm it was, in a sheet."""
    made, wrench, rot = wrist(rng, 24, 1)
    number = np.arange(1, 25)
    names = "no,qw,qx,qy,qz,fx,fy,fz,tx,ty,tz"
    body = rows(number, *np.roll(rot.as_quat(), 1, axis=1).T, *wrench.T, form="%.5f")
    means = write(to / "means.csv", [names, *body])
    sheet = [
        f"{n},2026-03-11T09:{10 + n // 3}:{20 * (n % 3):02d}Z,{480 + n},{23 - 0.02 * n:.2f}"
        for n in number
    ]
    noted = write(to / "sheet.csv", ["no,utc,samples,temp_C", *sheet])
    return Made([noted, means], tool_truth(made))


def angles_by_number(to: Path, rng: Rng) -> Made:
    """Four legs in a file for each orientation; shaft angles by the number of the leg alone."""
    side = {"1": -90.0, "2": -90.0, "3": 90.0, "4": 90.0}
    made = legs(rng, {f"P{n}": Rotation.from_euler("x", a, degrees=True) for n, a in side.items()})
    names = ["tiempo_s", *(f"fase{n}_grados" for n in side)]
    names += [
        f"P{n}_{a}" for n in side for a in ("Fx_N", "Fy_N", "Fz_N", "Mx_Nm", "My_Nm", "Mz_Nm")
    ]
    # body to world: z up, x up, z down, x down
    turns = {"a": (0.0, 0.0), "b": (0.0, -90.0), "c": (180.0, 0.0), "d": (0.0, 90.0)}
    lines, paths = ["archivo,alabeo_grados,cabeceo_grados,guinada_grados"], list[Path]()
    for word, (roll, pitch) in turns.items():
        body = Rotation.from_euler("xyz", [roll, pitch, 0.0], degrees=True)
        down = body.inv().apply([0.0, 0.0, -1.0])
        angle = swings(160)
        read = [leg.read(angle, down, rng) for leg in made.values()]
        table = rows(0.05 * np.arange(160), *[np.degrees(angle)] * 4, *np.hstack(read).T,
                     form="%.5f")  # fmt: skip
        paths.append(write(to / f"colgado_{word}.csv", [",".join(names), *table]))
        lines.append(f"{paths[-1].name},{roll:g},{pitch:g},0")
    truth = leg_truth({f"p_{n}": made[f"P{n}"] for n in side})
    return Made([*paths, write(to / "orientaciones.csv", lines)], truth)


THIRTY_FIFTH = (
    quaternions_by_number, index_of_legs, stretches_of_a_stream, attitudes_of_stretches,
    times_on_a_log_sheet, angles_by_number,
)  # fmt: skip
