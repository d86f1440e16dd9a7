"""Worlds that draw what a data sheet or a recipe states: there intervals mean what they say.

The other recordings leave exact what a recipe states to some per cent: cells that are mounted anew,
the robot's mass, gains of transducers. Intervals hold all that, so that errors there are small
against them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from tests.foreign.ankles import AXES, UNITS
from tests.foreign.biped import FEET, GRAVITY_MPS2, draw_biped
from tests.foreign.files import Recorded
from tests.foreign.noise import Array, stream
from tests.foreign.streams import stand, walk

MASS_SD, GAIN_SD, ZERO_SHARE, BELOW_SHARE = 0.01, 0.02, 0.005, 0.0045
"""Of the stated mass; of scales and (by the robot's weight) zeros of cells that are mounted anew;
of what hangs below a transducer, by the robot's weight."""
ANKLE_GAIN_SD = {"walk": 0.03, "stand": 0.01}
"""Of the gains of six-axis transducers, as either command takes them to be."""


def as_sold(seed: int) -> Recorded:
    """A stand whose data sheet states what is true: 2 % of scales and of the weight."""
    recorded, robot = stand(seed), draw_biped(seed)
    own = {"scale_relative_sd": 0.02, "bias_sd_n": 0.02 * robot.weight_n}
    nameplate = recorded.robot["nameplate"] | own
    return replace(recorded, robot={**recorded.robot, "nameplate": nameplate})


def sold_walk(seed: int) -> Recorded:
    """A walk whose data sheet states what is true, and whose mass is off as it is stated."""
    recorded, robot = walk(seed), draw_biped(seed)
    own = {"scale_relative_sd": 0.02, "bias_sd_n": 0.02 * robot.weight_n}
    nameplate = recorded.robot["nameplate"] | own
    return weighed(replace(recorded, robot={**recorded.robot, "nameplate": nameplate}), seed)


def weighed(recorded: Recorded, seed: int) -> Recorded:
    """The robot on a scale that is off by `MASS_SD`, which its recipe states."""
    true = draw_biped(seed).mass_kg
    off = true * (1.0 + MASS_SD * float(stream(seed, "scale of the mass").normal()))
    robot = {**recorded.robot, "mass_kg": off, "mass_sd_kg": MASS_SD * true}
    return replace(recorded, robot=robot)


def anew(record: Callable[..., Recorded]) -> Callable[[int], Recorded]:
    """Cells that were mounted anew after the bench, and a mass that is off, as the recipe states.

    Scale and zero of each cell move by `GAIN_SD` and `ZERO_SHARE` of the robot's weight.
    """

    def recorded(seed: int) -> Recorded:
        robot, rng = draw_biped(seed), stream(seed, "mounted anew")
        gain = 1.0 + GAIN_SD * rng.normal(size=len(robot.channels))
        moved = ZERO_SHARE * robot.weight_n * rng.normal(size=len(robot.channels))

        def shown(_: Array, load_n: Array) -> Array:
            return np.asarray((load_n + moved) / gain)

        plain = weighed(record(seed, distort=shown), seed)
        # warmth too: the zeros of the bench and those of today each lie in the middle of a drift
        since = float(np.hypot(ZERO_SHARE, np.sqrt(2.0) * robot.kind.warming)) * robot.weight_n
        stated = {"mounted_scale_relative_sd": GAIN_SD, "mounted_bias_sd_n": since}
        drift = gain * np.asarray(plain.truth["drift_n"])
        truth = {**plain.truth, "gain": gain, "drift_n": drift + moved}
        nameplate = {**plain.robot["nameplate"], **stated}
        return replace(plain, truth=truth, robot={**plain.robot, "nameplate": nameplate})

    return recorded


def walk_on_ankles(seed: int) -> Recorded:
    """A walk on ankles whose gains are off by as much as `online-replay` takes them to be."""
    return _with_gains(walk(seed), seed, ANKLE_GAIN_SD["walk"])


def stand_on_ankles(seed: int) -> Recorded:
    """A stand on ankles: gains, mass and what hangs below the ankles off as they are stated."""
    recorded = weighed(_with_gains(stand(seed), seed, ANKLE_GAIN_SD["stand"]), seed)
    robot, rng = draw_biped(seed), stream(seed, "below")
    sd = BELOW_SHARE * robot.weight_n
    feet = {
        name: {
            **foot, "weight_below_sd_n": sd,
            "weight_below_n": robot.below_kg * GRAVITY_MPS2 + sd * float(rng.normal()),
        }
        for name, foot in recorded.robot["feet"].items()
    }  # fmt: skip
    return replace(recorded, robot={**recorded.robot, "feet": feet})


def _with_gains(recorded: Recorded, seed: int, sd: float) -> Recorded:
    gains = stream(seed, "gains").normal(0.0, sd, (len(FEET), len(AXES)))
    table = recorded.logs["cells"].copy()
    for foot, own in zip(FEET, gains, strict=True):
        for axis, unit, gain in zip(AXES, UNITS, own, strict=True):
            table[f"{foot}_{axis}_{unit}"] /= 1.0 + gain
    logs, truth = {**recorded.logs, "cells": table}, {**recorded.truth, "gains": gains}
    return replace(recorded, logs=logs, truth=truth)
