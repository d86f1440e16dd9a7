"""A size is stated for every form of its effect that the data leave open."""

from __future__ import annotations

from pathlib import Path

import pytest

from footcal_cli.core.diagnosis.stated import in_any_form
from footcal_cli.core.inference.evidence import Interval
from tests.blind.bench import ask
from tests.blind.diagnosing import diagnosed
from tests.blind.plan import Cell
from tests.blind.scoring import Verdict
from tests.blind.trials import make_trial

SEED = 6366052763537303
"""Of a robot whose third cell hears the others."""


def test_other_forms_widen_an_interval_in_proportion() -> None:
    own = Interval(-2.0, -3.0, -1.0)
    assert in_any_form(own, []) == own
    assert in_any_form(own, [-4.0]) == Interval(-2.0, -6.0, -1.0)
    assert in_any_form(own, [-1.0]) == Interval(-2.0, -3.0, -0.5)


@pytest.mark.parametrize("rho", [pytest.param(0.5, marks=pytest.mark.slow), 1.0])
def test_what_a_cell_hears_of_a_plane_is_stated_in_the_forms_that_data_leave_open(
    tmp_path: Path, rho: float
) -> None:
    """On a stiff plate the mean of three cells is two thirds of the opposite one, and a gain."""
    truth = make_trial(
        Cell("single", "placements", ("crosstalk/table",), rho), SEED, tmp_path / "t"
    )
    ask(tmp_path / "t", "placements")
    said = Verdict.read(diagnosed(tmp_path / "t", tmp_path / "run"))
    assert said.sizes is not None
    size, low, high = said.sizes["crosstalk"]
    true = float(truth["effects"][0]["size"])
    assert low < true < high
    # within a tenth at ρ 1, where the noise is as large as the effect
    assert min(abs(abs(size) - abs(form * true)) for form in (1.0, 2.0 / 3.0)) < (
        0.1 / rho * abs(true)
    )
    # twice as large, it is told from the other form; the two thirds hold to a tenth, as the cells
    # are 2 mm off a rectangle
    assert (min(abs(low), abs(high)) < 2.0 / 3.0 * abs(true) * 1.1) == (rho < 1.0)


@pytest.mark.slow
def test_which_neighbour_a_cell_hears_is_told_in_a_walk(tmp_path: Path) -> None:
    """By the linear proxy the mean of all others does as well; refitted in full, it leaves a rest.

    The ledger's size is that of the neighbour, of which the mean of three holds another share.
    """
    truth = make_trial(Cell("single", "walk", ("crosstalk/neighbour",), 1.0), 8, tmp_path / "t")
    ask(tmp_path / "t", "walk")
    said = Verdict.read(diagnosed(tmp_path / "t", tmp_path / "run"))
    assert said.verdict == "named"
    assert said.sizes is not None
    assert set(said.sizes) == {"crosstalk"}
    size, low, high = said.sizes["crosstalk"]
    true = float(truth["effects"][0]["size"])
    # one draw: a 95 % interval misses one in twenty, 1.5 times it one in three hundred
    assert abs(size - true) < 1.5 * (high - low) / 2.0
