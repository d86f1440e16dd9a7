"""A certain name has a size that is surely something."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from footcal_cli.core.diagnosis.answer import Cause
from footcal_cli.core.diagnosis.sized import is_sized
from footcal_cli.core.effects.contract import Effect
from footcal_cli.core.effects.six_axis import AXIS_FLIP, CROSS_COUPLING, OFFSET_CHANGE
from footcal_cli.core.inference.evidence import Interval
from footcal_cli.core.inference.problem import Signature
from footcal_cli.core.inference.refit import Refit

BLOCKS = 24


def cause(effect: str, parameter: str, size: Interval) -> Cause:
    signature = Signature(effect, parameter, "leg", "N")
    return Cause(signature, size, 1e-6, Interval(0.1, 0.05, 0.15), 20, 0.0, (), ())


def drifting_together(names: tuple[str, ...]) -> Refit:
    """Sizes of which each is unsure, and all together are not: blocks move along one direction."""
    rng = np.random.default_rng(4)
    along = rng.normal(size=(BLOCKS, 1)) * np.ones(len(names))
    apart = (along + 0.02 * rng.normal(size=along.shape)) / BLOCKS
    values = {name: (0.4 if i % 2 else -0.4) for i, name in enumerate(names)}
    return cast(
        Refit,
        SimpleNamespace(names=names, values=values, scatter=SimpleNamespace(apart=apart)),
    )


@pytest.mark.parametrize(
    ("effect", "parameters", "holds"),
    [
        (OFFSET_CHANGE, ("offset_change_fy", "offset_change_fz"), False),
        (CROSS_COUPLING, ("coupling_fx_fy", "coupling_fy_fx"), True),
    ],
)
def test_sizes_that_are_sure_together_alone_name_nothing_that_changes_with_time(
    effect: Effect, parameters: tuple[str, ...], *, holds: bool
) -> None:
    names = tuple(f"leg.{p}" for p in parameters)
    intervals = {name: Interval(0.4, -0.1, 0.9) for name in names}
    named = cause(effect.name, parameters[0], intervals[names[0]])
    model = drifting_together(names)
    assert is_sized(effect, named, intervals, model, BLOCKS, 0.01) is holds


def test_one_size_counts_where_it_is_as_sure_as_a_name_is_to_be() -> None:
    """At 99 % with 24 blocks: 1.36 times the half width of the 95 % interval."""
    name = "leg.offset_change_fy"
    model = drifting_together((name,))
    for half, holds in ((0.9, False), (0.7, True)):
        size = Interval(1.0, 1.0 - half, 1.0 + half)
        named = cause("offset_change", "offset_change_fy", size)
        assert is_sized(OFFSET_CHANGE, named, {name: size}, model, BLOCKS, 0.01) is holds
        two = {name: size, "leg.offset_change_fz": Interval(1.0, 0.5, 1.5)}
        wide = replace(named, size=Interval(1.0, -5.0, 7.0))
        assert is_sized(OFFSET_CHANGE, wide, two, model, BLOCKS, 0.01)


def test_a_switch_is_on_or_off_whatever_its_interval() -> None:
    size = Interval(1.0, -10.0, 12.0)
    named = cause("axis_flip", "flip_fx", size)
    model = drifting_together(("leg.flip_fx",))
    assert is_sized(AXIS_FLIP, named, {"leg.flip_fx": size}, model, BLOCKS, 0.01)
