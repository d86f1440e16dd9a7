"""Visits with a wrong label, and residuals that are not small, on a plate with four cells."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from footcal_cli.core.chain import Chain, link
from footcal_cli.core.diagnosis.bridge import problem_from
from footcal_cli.core.diagnosis.floor import MOST, times_floor
from footcal_cli.core.diagnosis.labels import misloaded, relabelled
from footcal_cli.core.diagnosis.signals import describe
from footcal_cli.core.effects import find_effect
from footcal_cli.core.experiments.placements import EXPERIMENT
from footcal_cli.core.inference.case import Case, rows_of
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray, Parameter, ParameterSet

CELLS = np.array([[0.06, 0.03], [0.06, -0.03], [-0.04, 0.03], [-0.04, -0.03]])
CHANNELS = ("left_fl", "left_fr", "left_rl", "left_rr")
HOLES = np.array([[x, y] for x in (-0.02, 0.01, 0.04) for y in (-0.02, 0.0, 0.02)])
NOISE_N, GAIN_SD, BIAS_SD_N = 0.02, 0.01, 0.1


def _case(
    moved: tuple[int, ...] = (),
    gain: float = 1.0,
    *,
    light: bool = False,
    lighter_n: Mapping[int, float] | None = None,
    seed: int = 3,
) -> Case:
    """27 visits of two weights each; those `moved` lay in the first hole, whatever they say.

    With `light` every fourth visit is of a hundredth of that weight; `lighter_n` are rows of which
    the weight was so much lighter than written.
    """
    rng = np.random.default_rng(seed)
    visit = np.repeat(np.arange(27), 2)
    label = np.tile(np.arange(len(HOLES)), 3)
    real = label.copy()
    real[list(moved)] = 0
    load = np.tile([10.0, 30.0], 27) * np.where(light & (visit % 4 == 0), 0.01, 1.0)
    grid = np.column_stack([np.ones(4), CELLS])
    lay = load.copy()
    for row, less in (lighter_n or {}).items():
        lay[row] -= less
    wanted = np.column_stack([np.ones(54), HOLES[real[visit]]]) * lay[:, None]
    shares = wanted @ np.linalg.pinv(grid.T).T
    counts = gain * (shares + NOISE_N * rng.normal(size=shares.shape))
    log = Log(
        "placements", CHANNELS, np.arange(54.0), counts,
        {
            "load_n": load, "hole_m": HOLES[label[visit]], "hole": label[visit].astype(np.float64),
            "cell_pos_m": np.tile(CELLS, (54, 1, 1)),
        },
        visit,
    )  # fmt: skip
    values: dict[str, float] = {}
    free = []
    for channel in CHANNELS:
        values |= {f"{channel}.scale": 1.0, f"{channel}.bias": 0.0}
        free.append(Parameter(f"{channel}.scale", "N/count", 1.0, scale=0.02))
        free.append(Parameter(f"{channel}.bias", "N", 0.0, scale=0.3))
    chain = Chain(()).with_link(link(find_effect("scale_bias"), CHANNELS))
    known: FloatArray = np.diag(np.tile([GAIN_SD**-2.0, BIAS_SD_N**-2.0], 4))
    return Case(
        EXPERIMENT, (log,), chain, values, ParameterSet(tuple(free)), 0.06, 0.03,
        groups={f"left.{o}": o for o in ("fz", "moment_x", "moment_y")}, known=known,
    )  # fmt: skip


def test_one_visit_with_a_wrong_label_is_found_and_said_where_it_lay() -> None:
    case, found = relabelled(_case(moved=(13,)))
    assert len(found) == 1
    assert (found[0].visits, found[0].of, found[0].foot) == (1, 3, "left")
    np.testing.assert_allclose(found[0].written_m, HOLES[13 % 9])
    np.testing.assert_allclose(found[0].seems_m, HOLES[0], atol=1e-3)
    assert found[0].nearest_m is not None
    np.testing.assert_allclose(found[0].nearest_m, HOLES[0])
    own = case.logs[0].known["hole"]
    assert set(own[case.logs[0].block == 13]) == {9}
    assert np.all(own[case.logs[0].block != 13] < 9)


def test_labels_that_are_right_stay_as_they_are() -> None:
    case, found = relabelled(_case())
    assert not found
    np.testing.assert_array_equal(case.logs[0].known["hole"], _case().logs[0].known["hole"])


def test_a_light_weight_seems_to_lie_anywhere_and_is_no_wrong_label() -> None:
    """The noise of a moment over a small load is a large length."""
    assert not relabelled(_case(light=True))[1]
    _, found = relabelled(_case(moved=(13,), light=True))
    assert [(f.visits, f.of) for f in found] == [(1, 3)]
    np.testing.assert_allclose(found[0].seems_m, HOLES[0], atol=1e-3)


def test_a_weight_that_lay_there_in_place_of_the_written_one_is_found() -> None:
    (one,) = misloaded(_case(lighter_n={21: 0.8}))
    assert (one.foot, one.hole, one.written_n) == ("left", 1, 30.0)
    # the mean of the two weights of this visit, and what cells scatter
    assert abs(one.off_n + 0.8) < 5.0 * 2.0 * NOISE_N


def test_weights_that_are_right_or_lay_elsewhere_are_no_others() -> None:
    assert [misloaded(_case(seed=seed)) for seed in range(40)] == [()] * 40
    assert misloaded(_case(moved=(13,))) == ()
    assert misloaded(_case(light=True)) == ()


def test_a_gain_that_no_calibration_may_have_moved_by_is_far_above_the_floor() -> None:
    def times(gain: float) -> float:
        case = _case(gain=gain)
        rows = rows_of(case)
        problem = problem_from(case, rows, (), describe)
        return times_floor(case, problem)

    assert times(1.0) < 2.0
    assert times(1.5) > MOST


def test_several_holes_that_lack_weight_are_a_curve_and_no_labels() -> None:
    """Cells near a corner that read too little do so at every hole there."""
    assert misloaded(_case(lighter_n={3: 0.8, 13: 0.9, 25: 0.8, 29: 0.8})) == ()
