"""Transducers on the legs' side of their shafts: how they are turned, and what they turn about.

Room: sniff; asked by six_axis. At the angle φ of its leg a transducer feels
``f = w Rᵀ exp(−φ a) g + b``: gravity `g` in the body, turned back about the axis `a` of the body.
Of the axes of the body, both ways round, the one that explains the forces best is taken.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.spatial import rotation_exp
from footcal_cli.sniff.attitudes import Attitude, readings_of
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, numbers_of
from footcal_cli.sniff.mounts import HungBody, Mounts, hung_on, one_weight_each
from footcal_cli.sniff.shafts import shafts

_AXES = ("+y", "-y", "+x", "-x", "+z", "-z")
"""Of the body; most legs swing about y."""
_A_PAIR = 2
"""Two may be arms, each with an attitude of its own."""
_CLEARLY = 0.5
"""Share of what the next best axis leaves."""


def hung_in_own_frames(
    file: FileGuess, six: Mapping[str, Mapping[str, ColumnGuess]],
    forces: Mapping[str, FloatArray], mounts: Mounts,
) -> Mounts | None:  # fmt: skip
    """Mounts of transducers that carry one weight each, in no attitude of the body as it is.

    None where one feels more than a weight that is turned, as legs do that stand.
    """
    if not one_weight_each(forces):
        return None
    turned = turned_with_legs(file, six, forces)
    return turned or (replace(mounts, hang=True) if len(forces) > _A_PAIR else None)


def turned_with_legs(
    file: FileGuess, six: Mapping[str, Mapping[str, ColumnGuess]], forces: Mapping[str, FloatArray]
) -> Mounts | None:
    """Attitude of the body, mounting at an angle of 0 and axis of each; None where one has none.

    Parameters
    ----------
    file
        The log.
    six, forces
        Columns and forces (n, 3) of each transducer.
    """
    candidates = readings_of(file)
    one, each = shafts(file, {name: dict(axes) for name, axes in six.items()})
    angles = {name: each.get(name, one) for name in forces}
    if not candidates:
        return None
    found: dict[str, tuple[str, HungBody]] = {}
    for name, force in forces.items():
        entry = angles[name]
        if entry is None or entry.column is None:
            return None
        to_rad = np.pi / 180.0 if entry.unit == "deg" else 1.0
        phase = to_rad * (entry.factor or 1.0) * numbers_of(entry.column)
        tried = {axis: hung_on(_back(candidates[0].gravity, phase, axis), {name: force})
                 for axis in _AXES}  # fmt: skip
        axis, second = sorted(_AXES, key=lambda a: tried[a].left)[:2]
        if not tried[axis].explained or tried[axis].left > _CLEARLY * tried[second].left:
            return None
        found[name] = axis, tried[axis]
    attitude = Attitude(
        candidates[0].entries, (), all(hung.reacts for _, hung in found.values()), True,
        candidates[0].world_up,
    )  # fmt: skip
    mounts = Mounts(attitude, {n: hung.rotation[n] for n, (_, hung) in found.items()}, True)
    return replace(mounts, turns_about={name: axis for name, (axis, _) in found.items()})


def _back(gravity_b: FloatArray, phase_rad: FloatArray, axis: str) -> FloatArray:
    """Gravity in a frame that has turned by so much about an axis of the body, shape (n, 3)."""
    along = (1.0 if axis[0] == "+" else -1.0) * np.eye(3)["xyz".index(axis[1])]
    turned = rotation_exp(-phase_rad[:, None] * along)
    return np.asarray(np.einsum("nij,nj->ni", turned, gravity_b))
