"""Axes of feet's transducers that read with the sign turned or are exchanged, and clean ones."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from footcal_cli.core.chain import Chain
from footcal_cli.core.effects.calibration import AXES
from footcal_cli.core.log import Log
from footcal_cli.core.pose.feet_balance import balance_of_feet, check_axes_of_feet
from footcal_cli.core.quality import Finding
from footcal_cli.core.simulation.biped_logs import MotionAt, StandPlan, standing_motion
from footcal_cli.core.simulation.gait import WalkPlan, walking
from tests.core.ankle_simulation import Ankles, humanoid, six_axis_feet_log

HUMANOID = humanoid()
ORDINARY = Ankles(rate_hz=25.0, com_noise_m=1e-3)
FEET = ("left", "right")


def recorded(kind: str, seed: int) -> Log:
    """With an offset, a gain and a coupling of every axis, as data sheets allow."""
    motion: MotionAt
    if kind == "stand":
        plan = StandPlan(stances=8, one_foot=4, stance_s=2.0, sway_m=0.01)
        motion, lasts = standing_motion(HUMANOID, plan, seed), plan.duration_s
    else:
        gait = WalkPlan(duration_s=16.0, speed_mps=0.25, stand_s=1.0, turn_radps=0.1, bob_m=0.01)
        motion, lasts = (lambda t: walking(HUMANOID, gait, t)), gait.duration_s
    done = six_axis_feet_log(kind, HUMANOID, motion, lasts, Chain(()), {}, seed=seed,
                             ankles=ORDINARY)  # fmt: skip
    rng = np.random.default_rng([seed, 8])
    log, mixed = done.log, []
    squeeze = 6.0 * np.sin(2 * np.pi * 0.2 * log.time_s)  # the feet hold against each other
    for k in range(2):
        wrench = log.readings[:, 6 * k : 6 * k + 6].copy()
        both = np.all(log.known["contact"] == 1.0, axis=1)
        wrench[:, 1] += (1 - 2 * k) * squeeze * both
        wrench[:, 3] -= (1 - 2 * k) * squeeze * both * 0.1
        matrix = np.eye(6) + 0.008 * rng.standard_normal((6, 6)) * np.outer(
            [1, 1, 1, 0.1, 0.1, 0.1], [1, 1, 1, 10, 10, 10]
        )
        mixed.append(wrench @ matrix.T + rng.normal(0, [5, 5, 5, 0.3, 0.3, 0.3]))
    return replace(log, readings=np.hstack(mixed))


def found_in(log: Log) -> list[Finding]:
    feet = balance_of_feet(log)
    assert feet is not None
    return check_axes_of_feet(feet)


@pytest.mark.parametrize("kind", ["stand", "walk"])
@pytest.mark.parametrize("seed", range(4))
def test_clean_transducers_raise_no_alarm(kind: str, seed: int) -> None:
    assert found_in(recorded(kind, seed)) == []


@pytest.mark.parametrize("kind", ["stand", "walk"])
@pytest.mark.parametrize("seed", range(4))
def test_a_mirrored_or_exchanged_axis_is_in_what_is_named(kind: str, seed: int) -> None:
    """Which foot and axis is drawn; two that look alike are named together."""
    rng = np.random.default_rng([seed, 9])
    log, foot = recorded(kind, seed), int(rng.integers(2))
    readings = log.readings.copy()
    if rng.random() < 0.5:
        axis = int(rng.choice([1, 2, 3, 4]))  # fx and tz are next to nothing here
        readings[:, 6 * foot + axis] *= -1.0
        named, code = f"{AXES[axis]} of {FEET[foot]}", "axis_turned"
    else:
        pair = [(0, 2), (1, 2), (3, 4)][int(rng.integers(3))]
        at = [6 * foot + a for a in pair]
        readings[:, at] = readings[:, at[::-1]]
        named, code = f"{AXES[pair[0]]} and {AXES[pair[1]]} of {FEET[foot]}", "axes_exchanged"
    (found,) = found_in(replace(log, readings=readings))
    assert found.severity == "alarm"
    assert found.code == code
    assert named in found.sentence
