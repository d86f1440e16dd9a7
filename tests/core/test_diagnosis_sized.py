"""Whether a further cause is sure: one of its sizes, or all of them together."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from footcal_cli.core.diagnosis.answer import Cause
from footcal_cli.core.diagnosis.sized import is_sure
from footcal_cli.core.effects import TABLE
from footcal_cli.core.inference.evidence import Interval
from footcal_cli.core.inference.problem import Signature
from footcal_cli.core.inference.refit import Refit

BLOCKS = 60


@pytest.mark.parametrize(
    ("effect", "times", "sure"),
    [
        ("wrong_hole", (3.5, 3.5), True),
        ("wrong_hole", (3.5, 0.0), False),
        ("wrong_hole", (4.5, 0.0), True),
        ("offset_drift", (3.5, 3.5), False),  # follows noise that drifts, whose blocks are alike
    ],
)
def test_sizes_that_act_together_are_sure_together(
    effect: str, times: tuple[float, float], sure: bool
) -> None:
    """F(2, 58) of two sizes 3.5 sd from nothing is 12: p = 4e-5; of one and a zero, p = 0.005."""
    rng = np.random.default_rng(1)
    scatter = rng.standard_normal((BLOCKS, 2))
    scatter = np.linalg.qr(scatter - scatter.mean(axis=0))[0]  # independent, of equal size
    names = [p.name for p in TABLE[effect].sizes[:2]]
    mine = Signature(effect, names[0], "robot", "m", owners=(("robot", ("robot",)),))
    nothing = Interval(0.0, 0.0, 0.0)
    cause = Cause(mine, nothing, 0.0, nothing, 0, 0.0, rivals=(), places=())
    sd = np.sqrt((BLOCKS - 1) / BLOCKS)  # jackknife of columns of length one
    values = {f"robot.{name}": t * sd for name, t in zip(names, times, strict=True)}
    fitted = SimpleNamespace(
        names=tuple(values), values=values, scatter=SimpleNamespace(apart=scatter),
        intervals=tuple(Interval(v, v - 2.0 * sd, v + 2.0 * sd) for v in values.values()),
    )  # fmt: skip
    assert is_sure(cause, TABLE[effect], cast(Refit, fitted)) is sure
