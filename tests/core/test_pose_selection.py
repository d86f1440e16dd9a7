"""Candidate models: Table I, and the true model chosen."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from footcal_cli.core.pose.model import Structure
from footcal_cli.core.pose.problem import PoseOptions, feature_noise
from footcal_cli.core.pose.selection import bic_paper, compare_structures, in_noise
from tests.core.pose_cases import HIGH, case
from tests.core.six_axis_data import HIP_POS_M, Robot, draw_robot


@pytest.mark.parametrize(
    ("error", "freedom", "printed"),
    [(12, 36, 1580), (17, 21, 1674), (62, 18, 2352), (105, 3, 2546)],
)
def test_table_1_follows_from_its_own_cross_validation_errors(
    error: float, freedom: int, printed: int
) -> None:
    """Errors are printed without decimals: half a unit of 12 is 23 of BIC."""
    low, high = (bic_paper(error + d, freedom, 543) for d in (-0.5, 0.5))
    assert low <= printed <= high
    assert bic_paper(error, freedom, 543) == pytest.approx(printed, abs=5)


def built(structure: Structure, rng: np.random.Generator) -> Robot:
    """A robot with exactly the errors of one candidate, at the sizes of Table I."""
    turn = 0.1 * structure.rotates
    shift = 0.02 * structure.each_translates
    robot = draw_robot(rng, turn, shift)
    if structure is Structure.BODY_ROTATIONS:
        moved = (robot.turn_b @ HIP_POS_M[..., None])[..., 0] - HIP_POS_M
        return Robot(robot.turn_b, moved, robot.chassis_com_b_m)
    return robot


@pytest.mark.parametrize(
    ("truths", "rounds"),
    [
        ((Structure.SINGLE, Structure.FULL), 1),
        pytest.param(tuple(Structure), 4, marks=pytest.mark.slow),
    ],
)
def test_the_true_model_is_chosen_at_the_papers_noise(
    truths: tuple[Structure, ...], rounds: int
) -> None:
    """The paper's error of about 12 per pose is the noise; each structure in turn is the truth."""
    right = dict.fromkeys(truths, 0)
    for structure in truths:
        for seed in range(rounds):
            robot = built(structure, np.random.default_rng([40, seed]))
            one = case(seed, HIGH, robot=robot, friction_n=3.0)
            found = compare_structures(one.data, one.legs, one.noise_sd)
            right[structure] += found[0].structure is structure
            assert 9.0 < min(c.cv_error for c in found) < 14.0
    assert sum(right.values()) >= 0.9 * rounds * len(right)
    assert right[Structure.SINGLE] == rounds, "no structure where there is none"


@pytest.mark.slow
@pytest.mark.parametrize("structure", list(Structure))
def test_the_true_model_is_chosen_where_the_noise_level_is_unknown(structure: Structure) -> None:
    """Every candidate estimates a level of its own; they are compared in one."""
    robot = built(structure, np.random.default_rng([41, list(Structure).index(structure)]))
    one = case(7, HIGH, robot=robot, friction_n=3.0, poses=300)
    unknown = PoseOptions(noise_known=False)
    found = compare_structures(one.data, one.legs, 0.1 * one.noise_sd, unknown)
    assert found[0].structure is structure


def test_full_explains_its_own_noise_and_single_does_not() -> None:
    one = case(1)
    found = {c.structure: c for c in compare_structures(one.data, one.legs, one.noise_sd)}
    assert found[Structure.FULL].cv_chi2 == pytest.approx(6.0, rel=0.15)
    assert found[Structure.SINGLE].cv_chi2 > 100.0
    assert found[Structure.FULL].bic < found[Structure.HIP_ROTATIONS].bic


def test_hips_that_ran_away_are_judged_like_others() -> None:
    """A transducer turned by a right angle drives hips that may only shift beyond 10¹³ m."""
    one = case(3, poses=20, hung=False)
    fit = one.fit(PoseOptions(structure=Structure.TRANSLATIONS))
    noise = feature_noise(one.noise_sd, 0.0)
    for away_m in (0.0, 1e13, 1e16):
        shift = fit.mounting.shift_b_m + away_m
        matrix = replace(fit, mounting=replace(fit.mounting, shift_b_m=shift)).matrix
        spread = (matrix * noise) @ matrix.T
        found = in_noise(4.0 * spread, spread)  # as if every pose were off by twice its noise
        assert 0.0 < found < 24.0 + 1e-6
        if not away_m:
            assert found == pytest.approx(24.0)
