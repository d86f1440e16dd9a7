"""Errors of a bench in a foreign world against the Cramér–Rao bound of its true noise."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from footcal_cli.core import calibrate
from tests.foreign import draw_biped, weights
from tests.foreign.noise import Array


def bound(robot_sd_n: float, weights_off: float, load_n: Array) -> Array:
    """``sqrt diag (Aᵀ Σ⁻¹ A)⁻¹`` of relative scale and zero (N), with Σ as the world draws it.

    Readings are means of seconds with a white and a slow part; a weight's own error is the same
    whenever it is put on.
    """
    n = load_n.size
    apart = np.abs(np.subtract.outer(np.arange(n), np.arange(n)))
    noise = robot_sd_n**2 * (0.3**2 * np.eye(n) + 0.4**2 * np.exp(-apart / 6.0))
    same = np.equal.outer(load_n, load_n)
    noise = noise + (weights_off * np.outer(load_n, load_n) ** 0.5) ** 2 * same
    a = np.column_stack([load_n, np.ones(n)])
    return np.asarray(np.sqrt(np.diag(np.linalg.inv(a.T @ np.linalg.solve(noise, a)))))


def ratios(seeds: range) -> tuple[Array, Array]:
    """Errors of scale and zero over their bound and over their stated sd, (channels, 2)."""
    over_bound, over_sd = [], []
    for seed in seeds:
        robot, frame = draw_biped(seed), weights(seed).logs["weights"]
        for i, channel in enumerate(robot.channels):
            one = frame[frame["channel"] == channel]
            load = one["load_n"].to_numpy()
            found = calibrate.weights(
                channel, load, one["counts"].to_numpy(), time_s=one["time_s"].to_numpy(),
                session=one["repeat"].to_numpy(),
            ).estimates  # fmt: skip
            scale, zero = robot.scale[i], robot.zero[i]
            rows = np.array([[1.0 / scale, 0.0], [zero, 1.0]])
            error = rows @ (found.values[:2] - [scale, -scale * zero])
            sd = np.sqrt(np.diag(rows @ found.covariance[:2, :2] @ rows.T))
            over_bound.append(error / bound(robot.sd_n, robot.kind.weights_off, load))
            over_sd.append(error / sd)
    return np.array(over_bound), np.array(over_sd)


@pytest.mark.slow
def test_weights_come_near_the_bound() -> None:
    over_bound, over_sd = ratios(range(500, 520))
    for k, name in enumerate(("scale", "zero")):
        share = np.sqrt(np.mean(over_bound[:, k] ** 2))
        stated = np.sqrt(np.mean(over_sd[:, k] ** 2))
        sys.stdout.write(
            f"weights, {name}: {share:.2f} of the bound, {stated:.2f} of the stated sd, "
            f"n = {len(over_bound)}\n"
        )
        assert share < 1.25
