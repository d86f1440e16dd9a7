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
from footcal_cli.core.spatial import axis_rotations, rotation_of_quaternion, rpy_of_rotation
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
        Entries of the body's motion: accelerations of the CoM, quaternions of the feet.
    """
    acceleration = _table(body, [f"com_acc_{a}_mps2" for a in "xyz"])
    turns = {k: _table(body, [f"{k}_foot_q{a}" for a in "xyzw"]) for k in feet}
    if acceleration is None or any(q is None for q in turns.values()):
        return None
    force = {
        k: np.column_stack([numbers_of(axes[a]) for a in ("fx", "fy", "fz")])
        for k, axes in feet.items()
    }
    rotation = {k: rotation_of_quaternion(q) for k, q in turns.items() if q is not None}
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


def _table(body: Mapping[str, Entry], names: list[str]) -> FloatArray | None:
    columns = [body[name].column if name in body else None for name in names]
    values = [c.values for c in columns if c is not None and c.values is not None]
    return np.column_stack(values) if len(values) == len(names) else None
