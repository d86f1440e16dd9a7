"""Effects of six-axis legs in simulated hangings and poses: named, sized, worth something."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from footcal_cli.core.chain import Link
from footcal_cli.core.diagnosis.answer import Verdict
from footcal_cli.core.diagnosis.bridge import problem_from
from footcal_cli.core.diagnosis.change_points import at_its_change_point
from footcal_cli.core.diagnosis.floor import MOST, times_floor
from footcal_cli.core.diagnosis.investigation import Investigation
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.signals import describe
from footcal_cli.core.diagnosis.subject import Subject
from footcal_cli.core.effects import TABLE
from footcal_cli.core.inference.case import rows_of
from footcal_cli.core.inference.signatures import calibration_columns
from footcal_cli.core.log import Log
from footcal_cli.intake.cases.pose import pose_blocks
from tests.core.leg_cases import (
    FAMILIES,
    distorting,
    drifting,
    hang_case,
    hung_logs,
    investigated,
    pose_case,
    stepped,
)

NULLS = 200
STOOD = {
    "scale_matrix": ("fl", {"gain_fz": 0.04}),
    "cross_coupling": ("mr", {"coupling_fx_fz": 0.06}),
    "cable_drag": ("fl", {"cable_fz_sin": 0.5}),
    "case_strain": ("mr", {"strain_fx": 0.06}),
    "robot_weight": ("robot", {"robot_weight_correction": 3.0}),
    "leg_weight": ("fl", {"weight_correction": 2.0}),
}
"""At least twice the smallest size that 120 poses show four times in five."""
HUNG = {
    "cable_drag": ("fl", {"cable_fx_cos": 0.06}),
    "scale_matrix": ("mr", {"gain_fz": 0.04}),
    "cross_coupling": ("fl", {"coupling_fx_fz": 0.06}),
}
FAST = {"robot_weight": 40}
"""Effect -> poses that show it too."""


def checked(found: Investigation, effect: str, size: float) -> None:
    """The right name or a rival set that holds it, its size within the interval, a gain."""
    assert found.verdict in (Verdict.NAMED, Verdict.AMBIGUOUS)
    (named,) = found.found
    cause = named.cause
    assert effect in {cause.signature.effect, *(rival.effect for rival in cause.rivals)}
    if cause.signature.effect == effect:
        # legs that no pose can tell apart share the size
        share = len(cause.signature.owners[0][1])
        # one draw: a 95 % interval misses one in twenty, 1.5 times it one in three hundred
        reach = 1.5 * (cause.size.high - cause.size.low) / 2.0
        assert abs(cause.size.value - size / share) < reach
    assert cause.gain.low > 0


def test_levels_of_one_leg_that_drift_are_a_residual_whatever_law_takes_them_up() -> None:
    def times(rate_n_s: float) -> float:
        logs = drifting(hung_logs(5, *distorting("", "", {})), "mr", 2, rate_n_s)
        case = hang_case(logs, tolerance_n=0.05)
        rows = rows_of(case)
        return times_floor(case, problem_from(case, rows, (), describe))

    assert times(0.0) < 2.5
    assert times(2e-3) > MOST


def test_levels_that_move_in_every_sensor_alike_are_noise_of_the_hangings() -> None:
    """Every axis of every leg starts each hanging elsewhere, by many times its noise."""
    rng = np.random.default_rng(7)

    def moved(log: Log) -> Log:
        size = np.where(np.char.find(np.array(log.channels), ".t") >= 0, 0.01, 0.2)
        return log.with_readings(log.readings + size * rng.standard_normal(size.size))

    logs = hung_logs(5, *distorting("", "", {}))
    hung = {leg: [moved(log) for log in of] for leg, of in logs.items()}
    case = hang_case(hung, tolerance_n=0.05)
    assert times_floor(case, problem_from(case, rows_of(case), (), describe)) < MOST


def test_spells_of_one_leg_are_a_residual_however_large_they_make_its_noise() -> None:
    """3 N in a tenth of the rows: the noise of most of them is 0.04 N."""
    logs = hung_logs(5, *distorting("", "", {}))
    rng = np.random.default_rng(6)

    def with_spells(log: Log, size_n: float) -> Log:
        readings = log.readings.copy()
        readings[rng.random(len(log)) < 0.1, 2] += size_n
        return log.with_readings(readings)

    def times(size_n: float) -> float:
        fl = [with_spells(log, size_n) for log in logs["fl"]]
        case = hang_case({**logs, "fl": fl}, tolerance_n=0.05)
        rows = rows_of(case)
        return times_floor(case, problem_from(case, rows, (), describe))

    assert times(0.0) < 2.5
    assert times(3.0) > MOST


def test_an_effect_does_not_free_what_poses_cannot_calibrate() -> None:
    straight = pose_case(21, *distorting("case_strain", *STOOD["case_strain"]))
    rows = rows_of(straight)
    columns, turn = calibration_columns(straight, rows)
    strained = straight.extended(
        straight.chain.with_link(Link(TABLE["case_strain"], {"mr": ("mr",)})),
        {**straight.values, "mr.strain_fx": 0.06},
    )
    free, _ = calibration_columns(strained, rows)
    held, _ = calibration_columns(strained, rows, turn)
    assert free.shape[1] > held.shape[1] == columns.shape[1]


@pytest.mark.parametrize(
    ("effect", "poses"),
    [*FAST.items(), *(pytest.param(e, 120, marks=pytest.mark.slow) for e in STOOD)],
)
def test_what_poses_show_is_found(effect: str, poses: int) -> None:
    owner, sizes = STOOD[effect]
    found = investigated(pose_case(21, *distorting(effect, owner, sizes), poses=poses))
    checked(found, effect, next(iter(sizes.values())))
    for alike in ({"robot_weight", "leg_weight"}, {"scale_matrix", "case_strain"}):
        # a strained case is even in the load, which lifted legs show; a bridged one is a gain
        if effect in alike - {"case_strain"}:
            assert alike <= named(found), "no pose can tell them apart"


@pytest.mark.parametrize(("poses", "blocks"), [(12, 6), (24, 10), (45, 11), (69, 17), (240, 24)])
def test_few_poses_make_blocks_enough_of_two_poses_at_least(poses: int, blocks: int) -> None:
    found = np.bincount(pose_blocks(poses))
    assert found.size == blocks
    assert found.min() >= 2


@pytest.mark.parametrize("poses", [24, pytest.param(45, marks=pytest.mark.slow)])
def test_a_large_cause_is_named_from_few_poses(poses: int) -> None:
    coupled = distorting("cross_coupling", "mr", {"coupling_fx_fz": 0.15})
    checked(investigated(pose_case(21, *coupled, poses=poses)), "cross_coupling", 0.15)


@pytest.mark.slow
def test_a_small_coupling_that_poses_show_for_certain_is_named_and_called_small() -> None:
    """Which cause it is and whether it matters are two questions; a p of 1e-4 answers the first."""
    coupled = distorting("cross_coupling", "mr", {"coupling_fx_fz": 0.02})
    found = investigated(pose_case(21, *coupled, tolerance_n=0.1))
    (cause,) = [step.cause for step in found.found]
    row = next(r for r in found.rounds[0].effects if r.signature.effect == "cross_coupling")
    assert cause.signature.effect == "cross_coupling"
    assert not cause.rivals
    assert cause.p < Rules().alpha_small
    assert abs(cause.size.value - 0.02) < 0.75 * (cause.size.high - cause.size.low)
    assert cause.size.high < row.smallest


def named(found: Investigation) -> set[str]:
    """The named effect and its rivals."""
    cause = found.found[0].cause
    return {cause.signature.effect, *(rival.effect for rival in cause.rivals)}


@pytest.mark.slow
@pytest.mark.parametrize("effect", HUNG)
def test_what_hanging_shows_is_found(effect: str) -> None:
    """Three rounds of four orientations: gains differ from what does not repeat only by rounds.

    A gain of one axis along gravity is one of the other with the opposite sign: the leg's weight
    is fitted.
    """
    owner, sizes = HUNG[effect]
    found = investigated(hang_case(hung_logs(21, *distorting(effect, owner, sizes))))
    size = next(iter(sizes.values()))
    if effect == "scale_matrix" and found.found[0].cause.signature.parameter == "gain_fx":
        size = -size
    checked(found, effect, size)


@pytest.mark.slow
def test_an_offset_that_drifts_from_hanging_to_hanging_is_found() -> None:
    logs = drifting(hung_logs(21, *distorting("", "", {})), "fl", axis=2, rate_n_s=4e-4)
    checked(investigated(hang_case(logs)), "offset_drift", 4e-4)


def test_a_step_is_found_at_its_row_between_the_times_that_are_tried() -> None:
    """A few rows off, what is left of a step would look like another cause."""
    logs = stepped(hung_logs(21, *distorting("", "", {})), "fl", axis=1, share=0.43, step_n=0.5)
    case = hang_case(logs)
    rows, effect = rows_of(case), TABLE["offset_change"]
    problem = problem_from(case, rows, [effect], describe)
    subject = Subject(case, problem, {"offset_change": effect}, describe)
    fl = next(log for log in case.logs if log.channels[0].startswith("fl"))
    since = fl.time_s - fl.time_s[0]
    true = int(0.43 * len(fl))
    tried = [
        s for s in problem.signatures
        if s.parameter == "offset_change_fy" and s.owners[0][0] == "fl"
    ]  # fmt: skip
    nearest = min(tried, key=lambda s: abs(dict(s.shape)["change_time"] - since[true]))
    assert abs(dict(nearest.shape)["change_time"] - since[true]) > 5 * np.median(np.diff(since))
    found = dict(at_its_change_point(subject, nearest, (), None).shape)["change_time"]
    assert abs(found - since[true]) < 1.5 * np.median(np.diff(since))
    # where nothing happened between two times, no row of noise moves the one that was tried
    quiet = next(s for s in tried if dict(s.shape)["change_time"] > 1.5 * since[true])
    assert at_its_change_point(subject, quiet, (), None) is quiet


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "poses"), [("hang", 0), ("pose", 120), ("pose", 24)])
def test_clean_legs_are_left_alone(kind: str, poses: int) -> None:
    """Five kinds of noise in turn: false names at most 1 %, any alarm at most 3 %."""
    names = alarms = 0
    chain, values = distorting("", "", {})
    for seed in range(NULLS):
        family = FAMILIES[seed % len(FAMILIES)]
        case = (
            hang_case(hung_logs(9000 + seed, chain, values, family))
            if kind == "hang"
            else pose_case(9000 + seed, chain, values, family=family, poses=poses)
        )
        found = investigated(case)
        names += bool(found.found)
        alarms += found.verdict not in (Verdict.NONE, Verdict.UNDERPOWERED)
    sys.stdout.write(
        f"\n{kind} {poses or ''}: {names} names, {alarms} alarms on {NULLS} clean logs\n"
    )
    assert names <= 0.01 * NULLS
    assert alarms <= 0.03 * NULLS


def test_errors_in_the_wrenches_are_no_gain() -> None:
    """Plain least squares on noisy wrenches would shrink them, and call it a gain of every leg."""
    found = investigated(pose_case(22, *distorting("", "", {})))
    assert found.verdict is Verdict.NONE
    gain = next(row for row in found.rounds[0].effects if row.signature.effect == "scale_matrix")
    assert gain.size.low < 0 < gain.size.high or abs(gain.size.value) < 0.01
    assert np.isfinite(gain.detectable)
