"""A size is stated for every form of its effect that the data leave open."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from footcal_cli.core.diagnosis.stated import in_any_form
from footcal_cli.core.evidence import Interval
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


def test_what_a_cell_hears_of_a_plane_is_stated_for_three_neighbours_and_for_one(
    tmp_path: Path,
) -> None:
    """On a stiff plate the mean of three cells is two thirds of the opposite one, and a gain."""
    truth = make_trial(
        Cell("single", "placements", ("crosstalk/table",), 1.0), SEED, tmp_path / "t"
    )
    ask(tmp_path / "t", "placements")
    said = Verdict.read(diagnosed(tmp_path / "t", tmp_path / "run"))
    assert said.sizes is not None
    size, low, high = said.sizes["crosstalk"]
    true = float(truth["effects"][0]["size"])
    # some 2 mm from a rectangle, the two thirds hold to a tenth
    sizes = np.abs([true, 2.0 / 3.0 * true])
    assert min(abs(low), abs(high)) < sizes.min() * 1.1
    assert low < true < high
    assert abs(abs(size) - sizes).min() < 0.1 * abs(true)
