r"""How transducers at feet are turned in the frames of the feet, by the motion of the body.

Room: sniff; asked by six_axis.

Of the 24 rotations along axes those are left in which the forces of all feet together point up;
which way they point forward is that in which what they change by horizontally follows the
acceleration of the centre of mass, :math:`\sum_k Q_k R f_k = m (\ddot c - g)`.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.spatial import (
    axis_rotations,
    rotation_exp,
    rotation_of_quaternion,
    rpy_of_rotation,
)
from footcal_cli.sniff.guesses import ColumnGuess, numbers_of
from footcal_cli.sniff.plan import Entry

_UP = 0.9
"""Share of the mean force that is vertical in a foot's true mounting."""
_LEAST, _CLEARLY = 0.1, 0.05
"""Correlation of horizontal forces with the acceleration, and how far the next one is behind."""
_ROWS = 50


def foot_mount(
    feet: Mapping[str, Mapping[str, ColumnGuess]], body: Mapping[str, Entry]
) -> FloatArray | None:
    """Rotation (3, 3) from each transducer to its foot's frame; None where the log does not say.

    Parameters
    ----------
    feet
        Axes of the transducer at each foot.
    body
        Entries of the body's motion: accelerations of the CoM, quaternions or yaws of the feet.
    """
    acceleration = _table(body, [f"com_acc_{a}_mps2" for a in "xyz"])
    turned = {k: _turned(body, k) for k in feet}
    rotation = {k: one for k, one in turned.items() if one is not None}
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
    wanted = acceleration[good, :2] - acceleration[good, :2].mean(axis=0)
    found: list[tuple[float, FloatArray]] = []
    for mount in axis_rotations():
        parts = [np.einsum("nij,jk,nk->ni", rotation[k][good], mount, force[k][good]) for k in feet]
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


def mounted(feet: Mapping[str, Mapping[str, ColumnGuess]], body: Mapping[str, Entry]) -> str:
    """The line of ``[robot.feet…]`` for a mounting that is not straight; empty without one."""
    mount = foot_mount(feet, body)
    if mount is None or np.allclose(mount, np.eye(3)):
        return ""
    angles = ", ".join(f"{round(float(a), 6) + 0.0:.10g}" for a in rpy_of_rotation(mount))
    return (
        f"transducer_rotation_rpy_rad = [{angles}]    # likely: so the forces point up and follow "
        "the CoM's acceleration"
    )


def _turned(body: Mapping[str, Entry], foot: str) -> FloatArray | None:
    """Rotations (n, 3, 3) from a foot to the world, by its quaternion or by its yaw alone."""
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
