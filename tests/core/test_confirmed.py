"""A certain name is borne out by blocks that had no say in it."""

from __future__ import annotations

import numpy as np
import pytest

from footcal_cli.core.diagnosis.gain import Gain
from footcal_cli.core.inference.evidence import Interval


def gain(better: int, blocks: int, low: float) -> Gain:
    after = np.where(np.arange(blocks) < better, 0.5, 1.0)
    per_block = np.column_stack([np.ones(blocks), after])
    return Gain("fz", "N", 1.0, 0.9, Interval(0.1, low, 0.4), per_block)


@pytest.mark.parametrize(
    ("better", "blocks", "low", "held", "confirmed"),
    [
        (5, 10, -0.26, 10, False),  # a cell 19 mm off in a clean stand
        (5, 14, -0.03, 14, False),  # a floor slope where cells hear each other
        (41, 60, -0.11, 60, True),  # a hole that is elsewhere
        (2, 9, -1.0, 3, True),  # creep in one of three cells, three days each
        (8, 22, 0.6, 22, True),
    ],
)
def test_a_name_is_borne_out_by_most_blocks_or_surely(
    better: int, blocks: int, low: float, held: int, confirmed: bool
) -> None:
    assert gain(better, blocks, low).is_confirmed(held) == confirmed
