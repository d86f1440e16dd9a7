"""Rivals in six-axis transducers: hanging, and standing in poses."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from tests.blind.whitening import Inputs
from tests.blind.world import Array, Ints, World

KNEES = (0.2, 0.5, 0.8)
STEPS_AT = (0.3, 0.4, 0.5, 0.6, 0.7)
POSTS = 8

Rival = tuple[str, list[Array]]


def leg_rivals(clean: World, inputs: Inputs) -> Iterator[Rival]:
    """All rivals of effects in the legs, each in one leg."""
    for leg in np.unique(inputs.owner):
        mine = np.flatnonzero(inputs.owner == leg)
        rows = np.any(inputs.reach[mine] != 0.0, axis=(0, 2))
        yield from _axiswise(clean, inputs, mine, rows)
        yield from _couplings(inputs, mine)
        yield from _cables(clean, inputs, mine, int(leg))
    if clean.experiment == "pose":
        down = np.column_stack([clean.row["down_b"], np.zeros_like(clean.row["down_b"])])
        yield "robot_weight", [down]
        yield "leg_weight", [down]


def _axiswise(clean: World, inputs: Inputs, mine: Ints, rows: NDArray[np.bool_]) -> Iterator[Rival]:
    """In one axis of a leg."""
    time_s = clean.time_s - clean.time_s[rows].min()
    last = time_s[rows].max()
    for axis, i in enumerate(mine):
        load = inputs.load[:, i]
        span = float(np.percentile(np.abs(load[rows]), 99)) or 1.0
        added = [
            ("scale_matrix", load),
            ("nonlinearity", load**2),
            ("offset_drift", time_s),
            *(("offset_change", (time_s >= share * last) * 1.0) for share in STEPS_AT),
            *(("hinge", np.maximum(load - knee * span, 0.0)) for knee in KNEES),
            *(("dead_zone", np.clip(load, -k * span, k * span)) for k in KNEES),
            *(("saturation", np.clip(load, -k * span, k * span) - load) for k in KNEES),
        ]
        if clean.experiment == "hang":
            warm = clean.row["temperature_degc"] - 25.0
            added += [("temperature_bias", warm), ("temperature_scale", warm * load)]
        else:
            added.append(("nonlinearity_cubic", load**3))
            if axis < 3:
                force = np.linalg.norm(inputs.load[:, mine[:3]], axis=1)
                added += [("case_strain", load), ("case_strain", force)]
        yield from ((name, [column[:, None] * inputs.reach[i]]) for name, column in added)


def _couplings(inputs: Inputs, mine: Ints) -> Iterator[Rival]:
    """Force heard by force, torque by torque; and a transducer turned in its mount."""
    for first in (0, 3):
        for to in range(first, first + 3):
            for of in range(first, first + 3):
                if to != of:
                    heard = inputs.load[:, mine[of], None] * inputs.reach[mine[to]]
                    yield "cross_coupling", [heard]
    for axis in np.eye(3):
        turned = np.zeros(inputs.reach.shape[1:])
        for half in (mine[:3], mine[3:]):
            turn = np.cross(np.broadcast_to(axis, (len(turned), 3)), inputs.load[:, half])
            turned += np.einsum("nc,cnk->nk", turn, inputs.reach[half])
        yield "mount_rotation", [turned]


def _cables(clean: World, inputs: Inputs, mine: Ints, leg: int) -> Iterator[Rival]:
    """A pull that turns with the shaft, and a spring to a post."""
    phase = clean.row["phase_rad"]
    phase = phase if phase.ndim == 1 else phase[:, leg]
    for i in mine[:3]:
        yield "cable_drag", [f(phase)[:, None] * inputs.reach[i] for f in (np.sin, np.cos)]
    for post in 2 * np.pi * np.arange(POSTS) / POSTS:
        reach = np.stack([np.cos(phase) - 2 * np.cos(post), np.sin(phase) - 2 * np.sin(post)], -1)
        length = np.linalg.norm(reach, axis=1, keepdims=True)
        pull = -(length - 0.8) * reach / length
        felt = pull[:, :1] * inputs.reach[mine[0]] + pull[:, 1:] * inputs.reach[mine[2]]
        yield "cable_drag", [felt]
