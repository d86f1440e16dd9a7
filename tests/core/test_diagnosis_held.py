"""What was known before a walk holds in it: gains that weights told, and how wide a loop may be."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from footcal_cli.core.diagnosis.answer import Cause
from footcal_cli.core.diagnosis.bridge import problem_from
from footcal_cli.core.diagnosis.pairs import in_same_cells
from footcal_cli.core.diagnosis.signals import describe
from footcal_cli.core.effects import TABLE
from footcal_cli.core.inference.case import rows_of
from footcal_cli.core.inference.evidence import Interval
from footcal_cli.core.inference.grams import whitened_grams
from footcal_cli.core.inference.problem import Problem, Signature
from footcal_cli.core.inference.products import MOST_AT_ONCE
from footcal_cli.core.inference.scores import scores
from footcal_cli.core.inference.tracking import (
    GAIN_SD,
    Tracking,
    Walk,
    gain_and_bias,
    stretches_of,
)
from footcal_cli.core.inference.whitening import Noise, RowWhitener
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray
from tests.core.test_diagnosis_bridge import ROBOT, walk_case

BLOCKS, ROWS = 6, 40


def test_what_is_held_has_its_prior_and_all_blocks_share_it() -> None:
    """Sizes are those of generalised least squares with ``V = I + h hᵀ``, h of unit prior sd."""
    rng = np.random.default_rng(0)
    m = BLOCKS * ROWS
    block = np.repeat(np.arange(BLOCKS), ROWS)
    held = rng.normal(size=m)
    one = 0.95 * held + 0.3 * rng.normal(size=m)
    learning = block == 0  # where the tracked bias is learnt, which nothing else touches
    held, one = np.where(learning, 0.0, held), np.where(learning, 0.0, one)
    residual = 0.4 * one + rng.normal(size=m)
    one_of = Signature("a", "a", "robot", "-")
    problem = Problem(
        residual=residual, calibration=learning[:, None].astype(float),
        columns=one[:, None],
        signatures=(one_of,), block=block,
        output=np.zeros(m, dtype=np.int64), sequence=block, outputs=("f",), units=("N",),
        noise=np.ones(m), tolerance=np.ones(1), rate_hz=20.0, drifts=True,
        tracking=Tracking(np.arange(m) / 20.0, np.zeros(m, dtype=np.int64), np.zeros(1, dtype=int)),
        held=held[:, None],
    )  # fmt: skip
    white = RowWhitener(np.zeros((1, 1)), np.ones(1), problem.output, problem.sequence)
    assert problem.tracking is not None
    noise = Noise(white, Walk(np.zeros(1), stretches_of(problem.tracking, block)))
    grams, _ = whitened_grams(problem, np.empty((m, 0)), noise)
    found = scores(grams.inner, grams.calibration, grams.candidates)
    rest = ~learning
    covariance = np.eye(int(rest.sum())) + np.outer(held[rest], held[rest])
    weighted = np.linalg.solve(covariance, one[rest])
    expected = (weighted @ residual[rest]) / (weighted @ one[rest])
    assert found.size[0] == pytest.approx(expected, rel=1e-9)
    free = scores(grams.inner, grams.candidates[:0], grams.candidates).size[0]
    assert abs(expected - free) > 1e-3
    # of many candidates the innovations are kept, not all their products
    many = replace(
        problem, columns=np.tile(problem.columns, MOST_AT_ONCE), signatures=MOST_AT_ONCE * (one_of,)
    )
    kept, _ = whitened_grams(many, np.empty((m, 0)), noise)
    sizes = scores(kept.inner, kept.calibration, kept.candidates).size
    np.testing.assert_allclose(sizes, found.size[0], rtol=1e-9)


def test_cells_differ_from_a_common_gain_by_what_weights_left_open() -> None:
    case = walk_case(7, None, duration_s=30.0)
    held = gain_and_bias(ROBOT.channels, case.values, 0.01)
    of_cell, common = held[0], held[-1]
    scale = f"{ROBOT.channels[0]}.scale"
    assert of_cell.lasting
    assert not common.lasting
    assert of_cell.changes[scale] == pytest.approx(0.01 * case.values[scale])
    assert common.changes[scale] == pytest.approx(GAIN_SD * case.values[scale])
    rows = rows_of(case)
    problem = problem_from(replace(case, directions=held), rows, [], describe)
    free = problem_from(case, rows, [], describe)
    assert problem.held is not None
    assert problem.held.shape[1] == len(ROBOT.channels)
    assert free.held is None
    gain = [i for i, d in enumerate(case.directions) if d.kind == "gain"]
    np.testing.assert_allclose(
        problem.held, 0.01 / GAIN_SD * free.calibration[:, gain], rtol=1e-6, atol=1e-9
    )


def test_a_turned_cell_may_read_more_than_its_load_turned() -> None:
    """Whole effects are looked for around one, whatever range a size of theirs has."""
    case = walk_case(7, None, duration_s=30.0)
    flips = [
        s for s in problem_from(case, rows_of(case), [TABLE["sign_flip"]], describe).signatures
        if s.effect == "sign_flip"
    ]  # fmt: skip
    assert flips
    assert {(s.lower, s.upper) for s in flips} == {(0.7, 1.3)}


@pytest.mark.parametrize("width", [3.12, 30.0])
def test_a_loop_is_as_wide_as_its_cell_allows_not_as_some_newtons(width: float) -> None:
    """``1 − w/2r > 0``: a cell of 60 N may have a loop of 3 N, and one of 600 N of 30 N."""
    effect = TABLE["hysteresis"]
    size = effect.size
    reach = 2.0 * width
    assert size.lower < width < effect.largest(size, {"hysteresis_reach": reach}) < 2.0 * reach
    assert effect.largest(size, {"hysteresis_reach": 0.5 * width}) < width
    time: FloatArray = np.linspace(0.0, 10.0, 201)
    load = 10.0 * width * (1.0 - np.cos(time))[:, None]
    log = Log("walk", ("left_fl",), time, load, {}, np.zeros(201, dtype=np.int64))
    for of_width in (1.0, 10.0):  # the second would let readings fall under a rising load
        theta = {
            "hysteresis_width": np.array([of_width * width]),
            "hysteresis_reach": np.array([reach]),
        }
        shown, _ = effect.apply(log, theta, None)
        back, _ = effect.remove(shown, theta, None)
        np.testing.assert_allclose(back.readings, load, atol=1e-9 * load.max() / 0.05)
        rising = np.diff(load[:, 0]) > 0.0
        assert (np.diff(shown.readings[:, 0])[rising] > 0.0).all()


def test_two_causes_in_the_same_cells_may_be_the_form_of_one() -> None:
    nothing = Interval(0.0, 0.0, 0.0)

    def cause(effect: str, *cells: str) -> Cause:
        owners = tuple((cell, (cell,)) for cell in cells)
        signature = Signature(effect, "", "", "", owners=owners)
        return Cause(signature, nothing, 0.0, nothing, 0, 0.0, (), ())

    loop = cause("hysteresis", "left_fl", "left_fr")
    assert in_same_cells(TABLE, [loop, cause("hinge", "left_fr")])
    assert not in_same_cells(TABLE, [loop, cause("hinge", "right_fr")])
    assert not in_same_cells(TABLE, [loop, cause("delay", "robot")])
    # what a cell hears of others is no form of a loop of its own load
    assert not in_same_cells(TABLE, [loop, cause("crosstalk", "left_fl")])
    # a curve of further cells is no form of the loop that was found before it
    further = cause("nonlinearity", "left_fl", "left_fr", "right_fr")
    assert not in_same_cells(TABLE, [loop, further], at_once=False)
    assert in_same_cells(TABLE, [further, loop], at_once=False)
    assert in_same_cells(TABLE, [loop, further])
