"""How a drawing would turn a transducer whose rotation the forces say about.

Room: sniff; called by mounts.
"""

from __future__ import annotations

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.spatial import (
    axis_rotations,
    rotation_exp,
    rotation_log,
    rotation_of_rpy,
    rpy_of_rotation,
)

AXES_NEAR = np.radians(8.0)
"""Transducers are mostly mounted along axes; so near to one the rest is taken for an error."""
_ONE_AXIS_NEAR = np.radians(4.0)
_DRAWN = ((45.0, 4.0), (15.0, 2.0), (5.0, 1.5))
"""Steps of drawings about one axis, and how far a turn may be from one, degrees."""


def nominal(rotation: FloatArray) -> FloatArray:
    """The rotation along axes that is near, else one about a single axis, else in whole degrees.

    What a drawing has is looked for: what is left of it is an error of mounting, or of a gain.
    """
    if np.linalg.norm(rotation_log(rotation.T @ (along := _along_axes(rotation)))) < AXES_NEAR:
        return along
    starts = np.stack(axis_rotations())
    turned = [_about_one(rotation, axis, starts) for axis in np.eye(3)]
    tilt, angle, axis, start = min(turned, key=lambda one: one[0])
    if tilt < _ONE_AXIS_NEAR:
        degrees = np.degrees(angle)
        steps = (
            step for step, near in _DRAWN if abs(degrees - step * round(degrees / step)) < near
        )
        step = next(steps, 1.0)
        drawn = np.radians(step * np.round(degrees / step))
        return np.asarray(rotation_exp(drawn * axis) @ start)
    degrees = np.degrees(rpy_of_rotation(rotation))
    return rotation_of_rpy(np.radians(np.round(degrees)).tolist())


def _along_axes(rotation: FloatArray) -> FloatArray:
    """The nearest rotation that takes axes to axes."""
    nearest = max(axis_rotations(), key=lambda along: float(np.trace(along.T @ rotation)))
    return nearest + 0.0  # a half turn is +π, not −π


def _about_one(
    rotation: FloatArray, axis: FloatArray, starts: FloatArray
) -> tuple[float, float, FloatArray, FloatArray]:
    """What a turn about one axis of the body leaves, rad, its angle, axis, and what it starts at.

    Of ``R ≈ exp(θ [a]×) C``, `C` along axes, the `C` with the least rest, then the smallest `θ`.

    Parameters
    ----------
    rotation, axis, starts
        R (3, 3), a (3,), and every C (24, 3, 3).
    """
    turn = rotation @ starts.swapaxes(1, 2)
    along = turn @ axis
    tilt = np.round(np.arccos(np.clip(along @ axis, -1.0, 1.0)), 9)
    aside = np.eye(3)[int(np.argmin(np.abs(axis)))]
    seen = turn @ aside
    angle = np.arctan2(seen @ np.cross(axis, aside), seen @ aside)
    best = np.lexsort((np.abs(angle), tilt))[0]
    return float(tilt[best]), float(angle[best]), axis, starts[best]
