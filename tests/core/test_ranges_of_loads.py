"""Ranges in newtons hold for cells that carry 2 N and for cells that carry 1 kN."""

from __future__ import annotations

import pytest

from footcal_cli.core.effects import TABLE
from footcal_cli.core.effects.contract import EffectParameter, GridOf

SHAPES = [
    pytest.param(shape, id=f"{effect.name} {shape.name}")
    for effect in TABLE.values()
    for shape in effect.shapes
    if shape.grid_of is GridOf.LOAD
]
SIZES = {"bias_jump": 0.1, "label_correction": 0.05}
"""Size -> share of the largest load that it may well be."""


@pytest.mark.parametrize("largest_n", [2.0, 60.0, 1000.0])
@pytest.mark.parametrize("shape", SHAPES)
def test_a_share_of_the_largest_load_is_tried_as_such(
    shape: EffectParameter, largest_n: float
) -> None:
    """None is clipped: a loop that turns within 0.1 N was tried at 0.8 N only."""
    tried = [share * largest_n for share in shape.grid]
    assert all(shape.lower <= value <= shape.upper for value in tried)


@pytest.mark.parametrize("name", SIZES)
def test_what_a_cell_of_a_heavy_robot_may_have_is_possible(name: str) -> None:
    (size,) = (p for effect in TABLE.values() for p in effect.sizes if p.name == name)
    assert size.lower <= -SIZES[name] * 1000.0
    assert SIZES[name] * 1000.0 <= size.upper
