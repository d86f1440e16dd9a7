"""One gain or coupling of a hip transducer, found in few poses, and not where there is none."""

from __future__ import annotations

from dataclasses import replace

import pytest

from footcal_cli.core.pose.leg_map import leg_map
from footcal_cli.core.pose.problem import PoseOptions
from footcal_cli.core.pose.reading_error import ReadingError, likeliest_reading_error
from footcal_cli.sheets.pose.findings import findings, suspect_legs
from tests.core.pose_cases import Case, case
from tests.core.six_axis_data import TABLE_2

POSES = 14
LEG, SHOWN = 2, 2
OPTIONS = PoseOptions(translation_sd_m=0.005, com_sd_m=0.05)


def _off(found: Case, of: int, size: float) -> Case:
    """A share of one reading of a leg's load shows in its fz."""
    wrench = found.data.wrench_t.copy()
    wrench[:, LEG, SHOWN] += size * (wrench[:, LEG, of] - TABLE_2[LEG, of])
    return replace(found, data=replace(found.data, wrench_t=wrench))


def _likeliest(found: Case) -> ReadingError:
    best = likeliest_reading_error(found.data, found.legs, found.noise_sd, found.fit(OPTIONS))
    assert best is not None
    return best


@pytest.mark.parametrize(("of", "size"), [(2, 0.04), (0, -0.08)])
def test_the_reading_that_is_off_is_said_with_its_size(of: int, size: float) -> None:
    found = _off(case(3, poses=POSES, hung=False), of, size)
    best = _likeliest(found)
    assert (best.leg, best.shown, best.of) == (LEG, SHOWN, of)
    assert best.p < 1e-6
    assert best.size == pytest.approx(size, abs=4.0 * best.sd)
    fit = found.fit(OPTIONS)
    mapped = leg_map(found.data, fit, found.noise_sd)
    legs = fit.geometry.legs
    assert not suspect_legs(mapped, legs)  # 36 slopes are too many for so few poses
    assert suspect_legs(mapped, legs, best) == [legs[LEG]]
    (said,) = (f for f in findings(fit, mapped, best) if f.code == "leg_predicts_residual")
    assert said.sentence.startswith("fz reads" if of == SHOWN else "fz shows −")
    assert ("% too much" in said.sentence) is (of == SHOWN)


def test_sound_transducers_are_suspected_as_seldom_as_the_level_says() -> None:
    found = [_likeliest(case(seed, poses=POSES, hung=False)) for seed in range(40)]
    assert sum(one.p < 0.05 for one in found) <= 6  # 2 expected, P(> 6) = 0.2 %
    assert min(one.p for one in found) > 1e-4


def test_poses_that_leave_nothing_to_judge_by_accuse_nobody() -> None:
    few = case(3, poses=7, hung=False)
    fit = few.fit(OPTIONS)
    assert likeliest_reading_error(few.data, few.legs, few.noise_sd, fit) is None
