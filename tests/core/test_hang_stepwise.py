"""The paper's stepwise method and the naive one against truth and against the joint fit."""

from __future__ import annotations

import numpy as np
import pytest

from footcal_cli.core.hang.joint import fit_hang
from footcal_cli.core.study.stepwise import fit_stepwise, smooth_com
from footcal_cli.errors import FitError
from tests.core.six_axis_data import COM_M, FOUR_WAYS, TABLE_2, WEIGHT_N, hang


def test_without_tilt_and_noise_the_stepwise_method_is_right() -> None:
    logs = hang(np.random.default_rng(1), tilt_rad=0.0, force_sd=0.0, torque_sd=0.0).logs
    for naive in (False, True):
        fit = fit_stepwise(logs, naive=naive)
        assert fit.weight_n == pytest.approx(WEIGHT_N[0], abs=1e-6)
        np.testing.assert_allclose(fit.offset, TABLE_2[0], atol=2e-3)
        np.testing.assert_allclose(fit.com_m, COM_M, atol=2e-3)


def test_smoother_agrees_with_the_batch_solution() -> None:
    """The smoothed states minimise the sum of squares of steps, observations and start."""
    rng = np.random.default_rng(2)
    force, torque = rng.normal(size=(2, 6, 3))
    means, covariances = smooth_com(force, torque)
    rows = 6
    design = np.zeros((6 * rows, 3 * rows))
    target = np.zeros(6 * rows)
    for i in range(rows):
        at = slice(3 * i, 3 * i + 3)
        x, y, z = force[i]
        design[at, at] = np.array([[0, z, -y], [-z, 0, x], [y, -x, 0]]) / 0.1
        target[at] = torque[i] / 0.1
        step = slice(3 * rows + 3 * i, 3 * rows + 3 * i + 3)
        design[step, at] = np.eye(3) / (0.1 if i else np.sqrt(1.01))
        if i:
            design[step, 3 * i - 3 : 3 * i] = -np.eye(3) / 0.1
    covariance = np.linalg.inv(design.T @ design)
    np.testing.assert_allclose(means.ravel(), covariance @ design.T @ target, atol=1e-10)
    for i in range(rows):
        at = slice(3 * i, 3 * i + 3)
        np.testing.assert_allclose(covariances[i], covariance[at, at], atol=1e-10)


@pytest.mark.slow
def test_stepwise_weight_is_low_by_the_cosine_of_the_tilt_and_joint_is_not() -> None:
    tilt = np.deg2rad(2.0)
    error = np.array(
        [
            [fit.weight_n - WEIGHT_N[seed % 6] for fit in (fit_hang(h).values, fit_stepwise(h))]
            for seed in range(8)
            for h in [
                hang(
                    np.random.default_rng([3, seed]),
                    seed % 6,
                    rows=2500,
                    rate_hz=50.0,
                    tilt_rad=tilt,
                    exact_tilt=True,
                    force_sd=0.05,
                    torque_sd=0.005,
                ).logs
            ]
        ]
    )
    joint, stepwise = np.sqrt(np.mean(error**2, axis=0))
    assert joint <= stepwise / 5.0
    assert error[:, 1].mean() == pytest.approx(6.2 * (np.cos(tilt) - 1.0), rel=0.25)


def test_naive_offsets_carry_the_tilt() -> None:
    errors = []
    for seed in range(5):
        logs = hang(np.random.default_rng([4, seed]), rows=500).logs
        errors.append(
            [
                np.abs(fit.offset[:3] - TABLE_2[0][:3]).max()
                for fit in (
                    fit_hang(logs).values,
                    fit_stepwise(logs),
                    fit_stepwise(logs, naive=True),
                )
            ]
        )
    joint, stepwise, naive = np.mean(errors, axis=0)
    assert joint < stepwise < naive
    assert naive > 0.05


def test_logs_with_other_phases_are_matched_by_the_shaft_angle() -> None:
    hanging = hang(np.random.default_rng(5), force_sd=0.01, torque_sd=0.001)
    shifted = [log.rows(100 * i, len(log)) for i, log in enumerate(hanging.logs)]
    fit = fit_stepwise(shifted)
    np.testing.assert_allclose(fit.com_m[[0, 2]], COM_M[[0, 2]], atol=3e-3)


def test_needs_two_pairs() -> None:
    logs = hang(np.random.default_rng(6), directions=FOUR_WAYS[:3], rows=50).logs
    with pytest.raises(FitError, match="two pairs"):
        fit_stepwise(logs)


def test_named_parameters_speak_the_same_language_as_the_joint_fit() -> None:
    logs = hang(np.random.default_rng(7), rows=300).logs
    joint = fit_hang(logs).estimates
    assert set(fit_stepwise(logs).parameters()) <= set(joint.names)
