"""An axis that stands still while the tool on a wrist moves all others."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from footcal_cli.core.effects.calibration import AXES
from footcal_cli.core.hang.dead_axis import dead_axes
from footcal_cli.core.hang.runs import HangRun
from footcal_cli.core.parameters import FloatArray

NOISE = np.array([0.05] * 3 + [0.004] * 3)


def held(
    seed: int, gain: FloatArray, arm_m: tuple[float, float, float] = (0.02, -0.03, 0.07)
) -> list[HangRun]:
    """A tool of 17 N in 24 attitudes, each axis with its gain."""
    rng = np.random.default_rng(seed)
    way = Rotation.random(24, random_state=seed).inv().apply([0.0, 0.0, -1.0])
    wrench = 17.0 * np.hstack([way, np.cross(arm_m, way)])
    wrench = gain * wrench + [1.0, -2.0, 0.5, 0.05, 0.01, -0.03]
    nothing = np.zeros(5)
    return [
        HangRun(
            d, w + NOISE * rng.standard_normal((5, 6)), nothing, np.arange(5.0), nothing, 17.0,
            nothing, nothing,
        )
        for d, w in zip(way, wrench, strict=True)
    ]  # fmt: skip


@pytest.mark.parametrize("axis", range(6), ids=AXES)
def test_the_dead_axis_is_named_and_no_other(axis: int) -> None:
    gain = np.ones(6)
    gain[axis] = 0.02
    (found,) = dead_axes({"tool": held(axis, gain)}, "tool")
    assert (found.code, found.severity) == ("dead_axis", "alarm")
    assert found.where == f"tool.{AXES[axis]}"


@pytest.mark.parametrize("seed", range(6))
def test_axes_with_gains_far_off_are_not_dead(seed: int) -> None:
    gain = 1.0 + np.random.default_rng(seed).uniform(-0.3, 0.3, 6)
    assert not dead_axes({"tool": held(seed, gain)}, "tool")


def test_an_axis_that_the_tool_hardly_moves_is_not_dead() -> None:
    """A tool below the sensor's axis has no moment about it."""
    assert not dead_axes({"tool": held(3, np.ones(6), (0.0, 0.0, 0.1))}, "tool")


def test_few_attitudes_say_nothing() -> None:
    gain = np.array([1.0, 1.0, 0.0, 1.0, 1.0, 1.0])
    assert not dead_axes({"tool": held(4, gain)[:6]}, "tool")
