r"""How transducers at feet are turned in the frames of the feet, by the motion of the body.

Room: sniff; asked by six_axis.

Of the 24 rotations along axes those are left in which the forces of all feet together point up;
which way they point forward is that in which what they change by horizontally follows the
acceleration of the centre of mass, :math:`\sum_k Q_k R f_k = m (\ddot c - g)`. Where the logged
vertical forces are negative, the transducers hang upside down (Rx(pi)) or read what pushes on the
ground: both signs of the forces are tried.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.spatial import (
    axis_rotations,
    nearest_rotations,
    rotation_exp,
    rotation_of_quaternion,
    rpy_of_rotation,
)
from footcal_cli.sniff.guesses import ColumnGuess, numbers_of
from footcal_cli.sniff.motion import up_of
from footcal_cli.sniff.plan import Entry
from footcal_cli.sniff.triples import MATRIX
from footcal_cli.tables.world import TO_Z_UP

_UP = 0.9
"""Share of the mean force that is vertical in a foot's true mounting."""
_LEAST, _CLEARLY = 0.1, 0.05
"""Correlation of horizontal forces with the acceleration, and how far the next one is behind."""
_ROWS = 50


@dataclass(frozen=True)
class Mount:
    """How transducers at feet are turned.

    Parameters
    ----------
    rotation
        From each transducer to its foot's frame, shape (3, 3).
    sign
        −1 where they read what pushes on the ground.
    """

    rotation: FloatArray
    sign: float = 1.0

    @property
    def line(self) -> str:
        """The line of ``[robot.feet…]`` for a mounting that is not straight; else empty."""
        if np.allclose(self.rotation, np.eye(3)):
            return ""
        angles = [round(float(a), 6) + 0.0 for a in rpy_of_rotation(self.rotation)]
        rpy = ", ".join(f"{angle:.10g}" for angle in angles)
        why = "likely: so the forces point up and follow the CoM's acceleration"
        return f"transducer_rotation_rpy_rad = [{rpy}]    # {why}"


def point_down(feet: Mapping[str, Mapping[str, ColumnGuess]]) -> bool:
    """Whether the weight is along z and negative: upside down, or what pushes on the ground."""
    means = [[float(np.nanmean(numbers_of(axes[a]))) for a in ("fx", "fy", "fz")]
             for axes in feet.values()]  # fmt: skip
    x, y, z = np.sum(means, axis=0)
    return bool(z < 0 and max(abs(x), abs(y)) < abs(z))


def foot_mount(
    feet: Mapping[str, Mapping[str, ColumnGuess]], body: Mapping[str, Entry]
) -> Mount | None:
    """How the transducers at all feet are turned; None where the log does not say.

    Parameters
    ----------
    feet
        Axes of the transducer at each foot.
    body
        Entries of the body's motion: accelerations of the CoM, quaternions or yaws of the feet.
    """
    turn = TO_Z_UP[up_of(body)]
    acceleration = _table(body, [f"com_acc_{a}_mps2" for a in "xyz"])
    turned = {k: _turned(body, k) for k in feet}
    rotation = {k: turn @ one for k, one in turned.items() if one is not None}
    if acceleration is None or not feet or len(rotation) < len(feet):
        return None
    force = {
        k: np.column_stack([numbers_of(axes[a]) for a in ("fx", "fy", "fz")])
        for k, axes in feet.items()
    }
    good = np.isfinite(acceleration).all(axis=1)
    for k in feet:
        good &= np.isfinite(force[k]).all(axis=1) & np.isfinite(rotation[k]).all(axis=(1, 2))
    if good.sum() < _ROWS:
        return None
    level_acc = (acceleration[good] @ turn.T)[:, :2]
    wanted = level_acc - level_acc.mean(axis=0)
    found: list[tuple[float, Mount]] = []
    signs = (1.0, -1.0) if point_down(feet) else (1.0,)
    for mount in [Mount(one, sign) for one in axis_rotations() for sign in signs]:
        signed = mount.sign * mount.rotation
        parts = [
            np.einsum("nij,jk,nk->ni", rotation[k][good], signed, force[k][good]) for k in feet
        ]
        whole = np.sum(parts, axis=0)
        mean = whole.mean(axis=0)
        if mean[2] < _UP * np.linalg.norm(mean):
            continue
        level = whole[:, :2] - mean[:2]
        size = np.linalg.norm(level) * np.linalg.norm(wanted)
        found.append((float((level * wanted).sum() / size) if size > 0 else 0.0, mount))
    found.sort(key=lambda one: -one[0])
    if not found or found[0][0] < _LEAST:
        return None
    if len(found) > 1 and found[0][0] - found[1][0] < _CLEARLY:
        return None
    return found[0][1]


def _turned(body: Mapping[str, Entry], foot: str) -> FloatArray | None:
    """Rotations (n, 3, 3) from a foot to the world: a matrix, a quaternion, or its yaw alone."""
    matrix = _table(body, [f"{foot}_foot_r{n}" for n in MATRIX])
    if matrix is not None:
        return nearest_rotations(matrix.reshape(-1, 3, 3))
    quaternion = _table(body, [f"{foot}_foot_q{a}" for a in "xyzw"])
    if quaternion is not None:
        return rotation_of_quaternion(quaternion)
    yaw, entry = _table(body, [f"{foot}_foot_yaw_rad"]), body.get(f"{foot}_foot_yaw_rad")
    if yaw is None or entry is None:
        return None
    factor = np.pi / 180.0 if entry.unit == "deg" else 1.0
    return rotation_exp(factor * yaw * np.array([0.0, 0.0, 1.0]))


def _table(body: Mapping[str, Entry], names: list[str]) -> FloatArray | None:
    columns = [body[name].column if name in body else None for name in names]
    values = [c.values for c in columns if c is not None and c.values is not None]
    return np.column_stack(values) if len(values) == len(names) else None
