"""Two causes of the bench in one log: each is named only beside the other."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.blind.bench import ask
from tests.blind.diagnosing import diagnosed
from tests.blind.plan import PAIR_RHO, Cell
from tests.blind.scoring import Verdict
from tests.blind.trials import make_trial


@pytest.mark.slow
@pytest.mark.parametrize(
    ("experiment", "hidden", "seed"),
    [
        # without crosstalk in the model a cubic curve surely fits better than the parabola
        ("placements", ("nonlinearity/table", "crosstalk/table"), 16089541409524481091),
        # the hole removes a fifth of what the weight does, which is no fault of the weight's form
        ("placements", ("wrong_weight/label", "wrong_hole/label"), 7896312518274663600),
        # found one after the other; no pair of the linear screening leads to them
        pytest.param(
            "walk", ("hysteresis/table", "crosstalk/table"), 8453150018772525432,
            marks=pytest.mark.slow,
        ),
    ],
)  # fmt: skip
def test_both_are_named(
    tmp_path: Path, experiment: str, hidden: tuple[str, str], seed: int
) -> None:
    folder = tmp_path / "log"
    truth = make_trial(Cell("pair", experiment, hidden, PAIR_RHO), seed, folder)
    ask(folder, experiment)
    said = Verdict.read(diagnosed(folder, tmp_path / "run"))
    assert said.verdict == "named"
    assert said.names == {name for effect in truth["effects"] for name in effect["right"]}
