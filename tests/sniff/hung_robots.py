"""Logs of robots that hang in a frame and stand in poses, as several laboratories write them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from footcal_cli.core.parameters import FloatArray

WEIGHT_N, ROWS = 9.0, 80
COM_M = np.array([0.01, 0.03, -0.12])
OFFSET = np.array([0.5, -0.4, 0.8, 0.02, -0.01, 0.03])
AXES = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")
DOWN = {"xu": [-1, 0, 0], "xd": [1, 0, 0], "zu": [0, 0, -1], "zd": [0, 0, 1]}
"""Orientations by the axis that points up or down -> direction of gravity in the body."""


def swing(lag: float = 0.0) -> FloatArray:
    """Angle of a leg that swings once, degrees, shape (n,)."""
    return np.asarray(70.0 * np.sin(np.linspace(0.0, 2 * np.pi, ROWS) - lag))


def wrench_of(
    turn: Rotation, down: Sequence[float], angle_deg: FloatArray, rng: np.random.Generator,
    sign: float = 1.0,
) -> FloatArray:  # fmt: skip
    """What a transducer turned in its body reads of the leg that swings on it, shape (n, 6)."""
    force = WEIGHT_N * np.asarray(down, dtype=float)
    com = Rotation.from_euler("y", angle_deg[:, None], degrees=True).apply(COM_M)
    torque = np.cross(com, force)
    read = np.hstack([np.tile(turn.inv().apply(force), (len(com), 1)), turn.inv().apply(torque)])
    noise = rng.normal(0.0, [0.03] * 3 + [0.003] * 3, read.shape)
    return np.asarray(sign * read + OFFSET + noise)


def yawed(degrees: float) -> Rotation:
    """A transducer whose x points outward at so many degrees from the body's x."""
    return Rotation.from_euler("z", degrees, degrees=True)


def legs_in_one_file(
    folder: Path, names: Mapping[str, str], legs: Mapping[str, Rotation], phase: str
) -> list[Path]:
    """A file per orientation, called `names` of it, six axes and an angle of every leg in it."""
    rng, paths = np.random.default_rng(5), []
    for key, name in names.items():
        head = ["t", *(phase.format(leg=leg) for leg in legs)]
        head += [f"{leg}_{axis}" for leg in legs for axis in AXES]
        angles = [swing(0.1 * i) for i in range(len(legs))]
        wrenches = [
            wrench_of(turn, DOWN[key], angle, rng)
            for turn, angle in zip(legs.values(), angles, strict=True)
        ]
        table = np.column_stack([0.1 * np.arange(ROWS), *angles, *wrenches])
        path = folder / name
        np.savetxt(path, table, "%.4f", ",", header=",".join(head), comments="")
        paths.append(path)
    return paths


def legs_in_files(folder: Path, legs: Mapping[str, Rotation], *, joints: bool) -> list[Path]:
    """A file without a header for each leg and orientation, and one of all joints beside it."""
    rng, paths = np.random.default_rng(6), []
    clock = 0.05 * np.arange(ROWS)
    for key, down in DOWN.items():
        for leg, turn in legs.items():
            read = wrench_of(turn, down, swing(), rng, sign=-1.0)
            path = folder / f"run_{key}.{leg}.wrench"
            np.savetxt(path, np.column_stack([clock, read]), "%.5f")
            paths.append(path)
        if joints:
            held = [rng.normal(v, 1e-3, ROWS) for v in (0.0, 0.6)]
            own = [
                column for _ in legs
                for column in (held[0], np.radians(swing()) + rng.normal(0, 1e-3, ROWS), held[1])
            ]  # fmt: skip
            path = folder / f"run_{key}.q"
            np.savetxt(path, np.column_stack([clock, *own]), "%.5f")
            paths.append(path)
    return paths


def stood(
    legs: Mapping[str, Rotation], poses: int, rng: np.random.Generator
) -> tuple[Rotation, dict[str, FloatArray]]:
    """Attitudes of a robot that stands in poses, and the wrench of each leg, shape (poses, 6)."""
    tilt = rng.uniform(-12.0, 12.0, (poses, 3))
    body = Rotation.from_euler("ZYX", tilt, degrees=True)
    down = body.inv().apply([0.0, 0.0, -1.0])
    share = rng.dirichlet(np.full(len(legs), 12.0), poses)
    found = {}
    for (leg, turn), part in zip(legs.items(), share.T, strict=True):
        force = -60.0 * part[:, None] * down + rng.normal(0.0, 0.3, (poses, 3))
        torque = 0.1 * rng.normal(0.0, 1.0, (poses, 3)) * part[:, None]
        found[leg] = np.hstack([turn.inv().apply(force), torque]) + OFFSET
    return body, found
