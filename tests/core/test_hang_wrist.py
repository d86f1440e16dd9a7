"""A tool on a robot's wrist, held in many measured attitudes over a base that is not level."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from footcal_cli.core.hang.intake import hang_log
from footcal_cli.core.hang.joint import HangFit, HangOptions, fit_hang
from footcal_cli.core.hang.words import weak_directions
from footcal_cli.core.inference.fit import Fit
from footcal_cli.core.parameters import FloatArray

OFFSETS = tuple(f"wrist.offset_{axis}" for axis in ("fx", "fy", "fz", "tx", "ty", "tz"))
OFFSET = np.array([3.0, -5.0, 8.0, 0.1, -0.2, 0.05])
NOISE = np.array([0.05] * 3 + [0.003] * 3)
WEIGHT_N, COM_M, HOLDS, ROWS = 22.0, np.array([0.01, -0.004, 0.07]), 12, 30


def held(
    seed: int,
    lean: tuple[float, float] = (0.0, 0.0),
    drift_n: float = 0.0,
    attitude: bool = True,
) -> HangFit:
    """Twelve random attitudes; gravity leans toward x and y of the base, fz drifts over them."""
    rng = np.random.default_rng([seed, 77])
    down = np.array([*lean, -1.0])
    down /= np.linalg.norm(down)
    mount = Rotation.from_rotvec([0.01, -0.02, 0.015])
    gravity, level, wrench = [], [], []
    for turn in Rotation.random(HOLDS, random_state=rng):
        felt = WEIGHT_N * mount.inv().apply(turn.inv().apply(down))
        gravity.append(np.tile(turn.inv().apply([0.0, 0.0, -1.0]), (ROWS, 1)))
        level.append(np.tile(turn.as_matrix()[:2].T, (ROWS, 1, 1)))
        wrench.append(np.tile(np.concatenate([felt, np.cross(COM_M, felt)]), (ROWS, 1)))
    time_s = np.linspace(0.0, HOLDS * ROWS * 0.1, HOLDS * ROWS)
    readings = np.concatenate(wrench) + OFFSET + NOISE * rng.standard_normal((time_s.size, 6))
    readings[:, 2] += drift_n * (time_s / time_s[-1] - 0.5)
    log = hang_log(
        "wrist", time_s, np.zeros(time_s.size), readings, np.concatenate(gravity),
        leg_weight_n=20.0, level_t=np.concatenate(level) if attitude else None,
    )  # fmt: skip
    return fit_hang([log], HangOptions(tilt="mount"))


def errors(fit: HangFit) -> FloatArray:
    """Errors of offsets and weight over their sds, shape (7,)."""
    truth = dict(zip(OFFSETS, OFFSET, strict=True))
    truth["wrist.weight"] = WEIGHT_N
    names = fit.estimates.names
    return np.array(
        [(fit.estimates[n] - v) / fit.estimates.sd[names.index(n)] for n, v in truth.items()]
    )


def test_the_tilt_of_the_base_is_recovered_with_everything_else() -> None:
    """Errors over sds of 30 draws: an RMS of one, with 30 · 7 of them known to 5 %."""
    fits = [held(seed, (0.02, -0.015)) for seed in range(30)]
    size = np.array([errors(fit) for fit in fits])
    assert 0.85 < np.sqrt(np.mean(size**2)) < 1.15
    for name, lean in (("wrist.base_tilt_x", 0.02), ("wrist.base_tilt_y", -0.015)):
        found = np.array([fit.estimates[name] for fit in fits])
        sd = fits[0].estimates.sd[fits[0].estimates.names.index(name)]
        assert 0.7 < np.sqrt(np.mean((found - lean) ** 2)) / sd < 1.3
        assert sd < 2e-4


def test_without_the_base_the_same_logs_are_off_by_more_than_noise() -> None:
    with_it, without = held(1, (0.02, -0.015)), held(1, (0.02, -0.015), attitude=False)
    assert with_it.level_sd[0] == 0.0
    assert without.level_sd[0] > 0.1
    at = with_it.estimates.names.index("wrist.offset_fx")
    assert without.estimates.sd[at] > 10.0 * with_it.estimates.sd[at]


@pytest.mark.parametrize("drift_n", [1.0, 3.0])
def test_one_axis_that_drifts_widens_the_intervals_as_far_as_it_moves(drift_n: float) -> None:
    """Levels of one of three axes move by d/√12 (sd): over the three axes d/6, in each offset."""
    fit = held(2, drift_n=drift_n)
    assert fit.level_sd[0] == pytest.approx(drift_n / 6.0, rel=0.5)
    assert np.all(np.abs(errors(fit)[:3]) < 3.0)


def test_what_is_not_seen_is_found_in_a_log_of_any_length() -> None:
    """Two columns that only their sum shows, in more rows than a square matrix of them fits."""
    rng = np.random.default_rng(5)
    jacobian = rng.normal(0.0, 10.0, (70_000, 3))
    jacobian[:, 2] = jacobian[:, 1]
    estimates = SimpleNamespace(names=("leg.weight", "leg.offset_fx", "leg.offset_fy"))
    fit = cast("Fit", SimpleNamespace(estimates=estimates, jacobian=jacobian))
    assert weak_directions(fit) == ("0.7 offset_fx − 0.7 offset_fy",)
    few = cast("Fit", SimpleNamespace(estimates=estimates, jacobian=jacobian[:1]))
    assert len(weak_directions(few)) == 2
