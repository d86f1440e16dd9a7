"""One removed chain gives the signature of each unit as a chain for each unit does."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

import numpy as np
import pytest

from footcal_cli.core.chain import link
from footcal_cli.core.effects import TABLE
from footcal_cli.core.effects.contract import Effect, Scope, Trait, can_carry
from footcal_cli.core.effects.own import OwnRow, own_effect
from footcal_cli.core.inference.case import Case, rows_of
from footcal_cli.core.inference.places import carriers
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.inference.responses import Responses
from footcal_cli.core.inference.shapes import forms_by_unit
from footcal_cli.core.inference.signatures import derivative
from tests.contract.worlds import WORLDS

TRIED = [
    (name, effect)
    for name, world in WORLDS.items()
    for effect in TABLE.values()
    if name in effect.experiments
    and effect.scope is not Scope.ROBOT
    and Trait.UNGRADED not in effect.traits
    and effect.name not in world.experiment.calibration
    and can_carry(world.channels, effect)
]


def mixed(name: str, effect: Effect) -> bool:
    """Whether one unit's columns depend on others, or what is known changes."""
    turned = name == "pose" and effect.scope is Scope.CHANNEL  # by a mounting, removed after it
    beside = effect.name == "crosstalk" and name != "weights"  # which loads a cell at a time
    return turned or beside or Trait.BELIEF in effect.traits or effect.name == "slip"


@cache
def recorded(name: str) -> tuple[Case, Problem]:
    world = WORLDS[name]
    logs = world.record(None, 1, False)
    warm = tuple(
        log.with_known(temperature_degc=22.0 + np.sin(np.arange(float(len(log))) / 9.0))
        for log in logs
    )
    case = world.case(warm, 1)
    return case, rows_of(case)


@pytest.mark.parametrize(
    ("name", "effect"), TRIED, ids=[f"{effect.name}-{name}" for name, effect in TRIED]
)
def test_signatures_of_all_units_are_those_of_each_alone(name: str, effect: Effect) -> None:
    case, rows = recorded(name)
    forms = [form for form in forms_by_unit(case, effect, carriers(case, effect)) if form]
    if not forms:
        assert effect.name == "hysteresis", "legs that hang two ways open no loop"
        return
    form = forms[len(forms) // 2]
    units = list(form)
    size = effect.sizes[-1]
    found = Responses(case, rows, case.memory()).of_units(effect, size, form)
    assert (found is None) == mixed(name, effect)
    if found is None:
        return
    for unit in {units[0], units[-1]}:
        alone = derivative(case, rows, effect, size, {unit: (unit,)}, form[unit])
        # differences of residuals of up to 10⁴ over steps of 10⁻² lose ten digits
        np.testing.assert_allclose(found[unit], alone, atol=1e-8 * np.abs(alone).max() + 1e-9)


def test_no_unit_is_apart_where_what_is_removed_after_it_mixes_them() -> None:
    case, rows = recorded("walk")
    crosstalk, curve = TABLE["crosstalk"], TABLE["nonlinearity"]
    extra = link(crosstalk, case.logs[0].channels)
    shapes = dict.fromkeys(extra.names(), 0.0)
    sizes = {n: 0.01 for n in extra.names() if n.endswith(crosstalk.size.name)}
    chain = case.chain.with_link(extra)

    def of_units(sizes: Mapping[str, float]) -> object:
        mixed = case.extended(chain, {**case.values, **shapes, **sizes})
        forms: dict[str, dict[str, float]] = {unit: {} for unit in case.logs[0].channels}
        return Responses(mixed, rows, mixed.memory()).of_units(curve, curve.size, forms)

    assert of_units(sizes) is None
    assert of_units({}) is not None  # of size zero it mixes nothing


def test_an_own_effect_of_what_its_foot_carries_is_not_apart() -> None:
    case, rows = recorded("walk")
    units = case.logs[0].channels
    for adds, apart in (("k * load * temperature", True), ("k * foot_load", False)):
        own = own_effect(OwnRow("mine", adds, "mend it", "-", 0.02))
        forms: dict[str, dict[str, float]] = {unit: {} for unit in units}
        found = Responses(case, rows, case.memory()).of_units(own, own.size, forms)
        assert (found is not None) == apart
