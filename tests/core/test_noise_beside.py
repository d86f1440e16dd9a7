"""The noise of a series is that of what is left, not of a cause that is large."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from footcal_cli.core.diagnosis.bridge import problem_from
from footcal_cli.core.diagnosis.signals import describe
from footcal_cli.core.effects import TABLE
from footcal_cli.core.inference.case import rows_of
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.inference.whitening import law_of_noise
from footcal_cli.core.parameters import FloatArray
from tests.core.test_diagnosis_bridge import Hidden, walk_case

HEARD = 0.3
HEARS: Hidden = ("crosstalk", {"right_fl": ("right_fl",)}, {"right_fl.crosstalk": HEARD})
ASKED = ("sensor_lag", "crosstalk", "nonlinearity", "accel_bias")


def asked(*hidden: Hidden) -> Problem:
    """A walk of half a minute and a few candidates."""
    case = walk_case(3, *hidden, duration_s=30.0)
    return problem_from(case, rows_of(case), [TABLE[name] for name in ASKED], describe)


def levels(problem: Problem) -> FloatArray:
    """Sd of the innovations of each output."""
    return law_of_noise(problem).whitener.sd


def test_what_a_cell_hears_of_others_is_none_of_the_noise() -> None:
    problem = asked(HEARS)
    places = [(s.effect, s.where, dict(s.shape)) for s in problem.signatures]
    mine = places.index(("crosstalk", "right_fl", {"crosstalk_from": 0.0}))
    bare = problem.without_candidates
    known = levels(replace(bare, residual=bare.residual - HEARD * problem.columns[:, mine]))
    vertical = problem.outputs.index("fz")
    assert levels(bare)[vertical] > 2.0 * known[vertical]
    assert levels(problem) == pytest.approx(known, rel=0.1)


def test_what_explains_little_of_an_output_leaves_the_noise_as_it_is() -> None:
    clean = asked()
    assert np.array_equal(levels(clean), levels(clean.without_candidates))
