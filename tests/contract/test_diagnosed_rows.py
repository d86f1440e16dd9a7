"""What the report says of an effect hidden at twice what matters, where it could say too much."""

from __future__ import annotations

import pytest

from footcal_cli.core.diagnosis.answer import EffectStatus
from footcal_cli.core.diagnosis.bridge import problem_from
from footcal_cli.core.diagnosis.investigation import Investigation
from footcal_cli.core.diagnosis.path import beginning
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.signals import describe
from footcal_cli.core.effects import TABLE
from footcal_cli.core.inference.case import rows_of
from tests.contract.hiding import diagnosed, sized
from tests.contract.worlds import WORLDS

SEED = 1


def answered(experiment: str, name: str) -> tuple[Investigation, float]:
    """The diagnosis of a hidden effect of the table, and its size."""
    world = WORLDS[experiment]
    hidden, _ = sized(experiment, TABLE[name], SEED)
    case = world.case(world.record(hidden, SEED, True), SEED)
    return diagnosed(experiment, case, SEED), hidden.size


@pytest.mark.slow
@pytest.mark.parametrize(
    ("experiment", "name"), [("weights", "creep_slow"), ("placements", "load_bypass")]
)
def test_a_size_is_stated_for_every_shape_that_no_refit_moves(experiment: str, name: str) -> None:
    """A time constant beyond the pauses, the load between two weights at which a stop touches."""
    found, true = answered(experiment, name)
    (item,) = (f for f in found.found if f.cause.signature.effect == name)
    size = item.cause.size
    assert size.low < true < size.high
    assert found.model is not None
    fitted = {n.rsplit(".", 1)[1] for n in found.model.names}
    assert not fitted & {p.name for p in TABLE[name].shapes}
    # the interval at the one shape that was taken would miss it
    (own,) = item.intervals
    assert not own.low < true < own.high


@pytest.mark.slow
def test_what_one_cell_may_hold_is_not_called_absent_of_all() -> None:
    """Seven sessions of one cell show what all cells together would hide, not which drift it is."""
    world = WORLDS["weights"]
    hidden, _ = sized("weights", TABLE["bias_drift"], SEED)
    true = hidden.size
    case = world.case(world.record(hidden, SEED, True), SEED)
    table = [row for name, row in TABLE.items() if name not in world.untested]
    problem = problem_from(case, rows_of(case), table, describe)
    first = beginning(problem, Rules(), SEED).rounds[0]  # as in the diagnosis, which goes on
    (row,) = (r for r in first.effects if r.signature.effect == "bias_drift")
    assert row.status is EffectStatus.UNDECIDED
    assert row.size.low < true < row.size.high
    assert row.size.low > row.smallest
