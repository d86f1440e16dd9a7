"""Offsets that moved between hanging and standing, where nobody says how noisy a pose is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from footcal_cli.core.pose.departures import constant_error
from footcal_cli.core.pose.problem import PoseOptions
from footcal_cli.core.pose.study import MountingStudy, study_mounting
from tests.core.pose_cases import HIGH, LOW, Case, case

UNKNOWN = PoseOptions(noise_known=False)


def moved(one: Case, offset: np.ndarray, *, drifts: bool = False) -> Case:
    """The same poses with other offsets (6, 6) than hanging, reached slowly or at once."""
    when = np.linspace(0.0, 1.0, len(one.data))[:, None, None] if drifts else 1.0
    return replace(one, data=replace(one.data, wrench_t=one.data.wrench_t + when * offset))


@pytest.mark.parametrize("noise", [LOW, HIGH])
def test_offsets_that_stayed_leave_no_constant_error(noise: tuple[float, float]) -> None:
    for seed in range(4):
        one = case(seed, noise, poses=40)
        assert not constant_error(one.data, one.fit(UNKNOWN)).stands_out


@pytest.mark.parametrize("drifts", [False, True])
def test_offsets_that_moved_are_found_by_what_is_alike_in_all_poses(*, drifts: bool) -> None:
    """In part: mountings that turn take up what is across gravity, and some of what is along."""
    rng = np.random.default_rng(4)
    offset = rng.normal(0.0, [0.8] * 3 + [0.05] * 3, (6, 6))
    one = moved(case(1, poses=40), offset, drifts=drifts)
    found = constant_error(one.data, one.fit(UNKNOWN))
    assert found.stands_out
    in_body = np.einsum("kij,kj->i", one.robot.rot_nominal, offset[:, :3])
    assert 0.2 < found.mean[2] / in_body[2] < 1.0


def test_few_poses_say_nothing_of_it() -> None:
    one = moved(case(1, poses=8), np.full((6, 6), 1.0))
    assert constant_error(one.data, one.fit(UNKNOWN)).p == 1.0


def studied(one: Case, weight_n: float) -> MountingStudy:
    """The command's study where a weight was said, and nobody said how noisy a pose is."""
    data = replace(one.data, robot_weight_n=weight_n)
    return study_mounting(
        data, one.legs, one.noise_sd, UNKNOWN,
        structure="full", translation_sd_m=0.005, directions="auto", folds=2,
    )  # fmt: skip


@pytest.mark.parametrize(("seed", "poses"), [(5, 30), pytest.param(6, 60, marks=pytest.mark.slow)])
def test_a_wrong_mass_is_refuted_and_blames_no_leg(seed: int, poses: int) -> None:
    one, factor = case(seed, poses=poses), float(np.random.default_rng(seed).choice([0.96, 1.05]))
    true_n = one.data.robot_weight_n
    study = studied(one, factor * true_n)
    (found,) = study.refuted
    assert abs(found.found - true_n) < 3.0 * found.found_sd
    assert not study.moved
    assert study.mapped.suspect is None
    # the mountings are those of the right mass, to their own sd
    right = studied(one, true_n)
    assert not right.refuted
    assert not right.moved
    apart = study.fit.estimates().values[:36] - right.fit.estimates().values[:36]
    assert np.all(np.abs(apart) < 2.0 * study.fit.estimates().sd[:36] + 1e-12)


@pytest.mark.parametrize("seed", [5, pytest.param(6, marks=pytest.mark.slow)])
def test_an_offset_that_moved_is_no_wrong_mass(seed: int) -> None:
    rng = np.random.default_rng([7, seed])
    offset = np.zeros((6, 6))
    offset[rng.integers(6), 2] = rng.choice([-1.0, 1.0]) * 1.5
    one = moved(case(seed, poses=30), offset)
    study = studied(one, one.data.robot_weight_n)
    assert not study.refuted
    assert study.moved or constant_error(study.data, study.fit).stands_out
