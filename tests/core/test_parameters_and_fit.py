"""The maximum a posteriori fit against closed forms, and its honesty about what it cannot see."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

from footcal_cli.core.inference.fit import fit_map, numeric_jacobian
from footcal_cli.core.parameters import FloatArray, Parameter, ParameterSet, Status


def line_problem(seed: int, sd: float = 0.1) -> tuple[FloatArray, FloatArray, FloatArray]:
    rng = np.random.default_rng(seed)
    x = np.linspace(-1.0, 2.0, 60)
    design = np.column_stack([x, np.ones_like(x)])
    truth = np.array([3.0, -0.5])
    return design, design @ truth + sd * rng.standard_normal(x.size), truth


def line_residual(design: FloatArray, y: FloatArray, theta: FloatArray) -> FloatArray:
    return np.asarray((design @ theta - y) / 0.1)


def flat(*names: str) -> ParameterSet:
    return ParameterSet(tuple(Parameter(name, "N", 0.0) for name in names))


def test_without_prior_it_is_least_squares_with_its_textbook_covariance() -> None:
    design, y, _ = line_problem(1)
    fit = fit_map(lambda t: (design @ t - y) / 0.1, flat("a.slope", "a.bias"))
    expected, *_ = np.linalg.lstsq(design, y, rcond=None)
    np.testing.assert_allclose(fit.estimates.values, expected, rtol=1e-9)
    np.testing.assert_allclose(
        fit.estimates.covariance, 0.01 * np.linalg.inv(design.T @ design), rtol=1e-6
    )
    assert fit.estimates.status == (Status.ESTIMATED, Status.ESTIMATED)
    assert fit.rank == 2


def test_a_prior_pulls_by_the_ratio_of_information() -> None:
    y = np.full(4, 2.0)
    parameters = ParameterSet((Parameter("a.x", "N", 0.0, sd=0.5),))
    fit = fit_map(lambda t: (t[0] - y) / 1.0, parameters)
    # four observations of sd 1 and a prior of sd 0.5 weigh the same: the mean lies half-way
    assert fit.estimates["a.x"] == pytest.approx(1.0, rel=1e-9)
    assert fit.estimates.sd_of("a.x") == pytest.approx(np.sqrt(1 / 8), rel=1e-9)


def test_errors_over_sd_have_unit_spread() -> None:
    z = []
    for seed in range(200):
        design, y, truth = line_problem(seed)
        fit = fit_map(partial(line_residual, design, y), flat("a.slope", "a.bias"))
        z.append((fit.estimates.values - truth) / fit.estimates.sd)
    rms = float(np.sqrt(np.mean(np.square(z))))
    assert 0.9 < rms < 1.1  # 400 standard normals: sd of their rms is 0.035


def test_the_noise_found_is_that_of_the_data() -> None:
    design, y, _ = line_problem(3, sd=0.2)
    fit = fit_map(lambda t: design @ t - y, flat("a.slope", "a.bias"))
    assert fit.noise_factor == pytest.approx(0.2, rel=0.25)


def test_what_the_data_cannot_see_keeps_its_prior_and_says_so() -> None:
    y = np.array([1.0, 1.2, 0.9])
    parameters = ParameterSet(
        (Parameter("a.x", "N", 0.0, sd=1.0), Parameter("b.x", "N", 0.3, sd=0.1))
    )
    fit = fit_map(lambda t: (t[0] - y) / 0.1, parameters)
    assert fit.estimates.status == (Status.ESTIMATED, Status.PRIOR_KEPT)
    assert fit.estimates["b.x"] == pytest.approx(0.3)
    assert fit.estimates.sd_of("b.x") == pytest.approx(0.1)
    assert fit.rank == 1


def test_two_parameters_of_which_only_the_sum_is_seen_are_not_called_estimated() -> None:
    y = np.array([1.0, 1.1, 0.9])
    fit = fit_map(lambda t: (t[0] + t[1] - y) / 0.1, flat("a.x", "b.x"))
    assert fit.estimates.status == (Status.PRIOR_KEPT, Status.PRIOR_KEPT)
    assert fit.rank == 1


def test_a_bound_is_kept_and_named() -> None:
    y = np.full(3, -1.0)
    parameters = ParameterSet((Parameter("a.x", "N", 0.5, lower=0.0, upper=1.0),))
    fit = fit_map(lambda t: (t[0] - y) / 0.1, parameters)
    assert fit.estimates["a.x"] == pytest.approx(0.0, abs=1e-6)
    assert fit.estimates.status == (Status.AT_BOUND,)


def test_a_fixed_parameter_does_not_move() -> None:
    y = np.full(3, 5.0)
    parameters = ParameterSet((Parameter("a.x", "N", 1.0), Parameter("b.x", "N", 2.0, free=False)))
    fit = fit_map(lambda t: (t[0] + t[1] - y) / 0.1, parameters)
    assert fit.estimates["b.x"] == 2.0
    assert fit.estimates["a.x"] == pytest.approx(3.0)
    assert fit.estimates.status[1] is Status.FIXED


def test_an_analytic_jacobian_gives_the_same_fit() -> None:
    design, y, _ = line_problem(5)

    def curved(t: FloatArray) -> FloatArray:
        return (np.exp(design @ (0.1 * t)) - np.exp(0.1 * y)) / 0.01

    def slope(t: FloatArray) -> FloatArray:
        return np.asarray(0.1 * design * np.exp(design @ (0.1 * t))[:, None] / 0.01)

    parameters = flat("a.slope", "a.bias")
    theta = np.array([2.0, 0.3])
    np.testing.assert_allclose(
        slope(theta), numeric_jacobian(curved, theta, np.full(2, 1e-5)), rtol=1e-6, atol=1e-6
    )
    numeric = fit_map(curved, parameters)
    analytic = fit_map(curved, parameters, jacobian=slope)
    np.testing.assert_allclose(numeric.estimates.values, analytic.estimates.values, rtol=1e-6)
    np.testing.assert_allclose(numeric.estimates.sd, analytic.estimates.sd, rtol=1e-5)


def test_names_are_unique_and_starts_are_inside_their_bounds() -> None:
    with pytest.raises(ValueError, match=r"named twice: a\.x"):
        flat("a.x", "a.x")
    with pytest.raises(ValueError, match="outside"):
        Parameter("a.x", "N", 2.0, lower=0.0, upper=1.0)


@pytest.mark.parametrize("linear", [False, True])
def test_an_earlier_fit_as_joint_prior_counts_like_its_rows(linear: bool) -> None:
    """The normal equations of both recordings at once are the closed form."""
    rng = np.random.default_rng(11)
    first, second = rng.normal(size=(12, 3)), rng.normal(size=(9, 3))
    first[:, 1] = first[:, 0] + 1e-3 * rng.normal(size=12)  # priors that say most together
    y1, y2 = rng.normal(size=12), rng.normal(size=9)
    both, target = np.vstack([first, second]), np.concatenate([y1, y2])
    information = both.T @ both
    expected = np.linalg.solve(information, both.T @ target)

    names = ("a.scale", "b.scale", "c.scale")
    covariance = np.linalg.inv(first.T @ first)
    sd = np.sqrt(np.diag(covariance))
    before = covariance @ (first.T @ y1)
    priors = zip(names, before.tolist(), sd.tolist(), strict=True)
    parameters = ParameterSet(
        tuple(Parameter(name, "-", value, spread) for name, value, spread in priors),
        covariance / np.outer(sd, sd),
    )
    fit = fit_map(lambda t: second @ t - y2, parameters, jacobian=lambda _: second, linear=linear)
    np.testing.assert_allclose(fit.estimates.values / sd, expected / sd, atol=1e-5)
    np.testing.assert_allclose(fit.estimates.covariance, np.linalg.inv(information), rtol=1e-5)
