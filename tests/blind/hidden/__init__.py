"""What is hidden: every effect of the bench, in footcal's words where footcal has one.

`Injection.right` are the names that answer correctly. A foreign implementation may be described
truthfully by more than one word (a tanh is a saturation and a curve); an effect without right names
is not in the library and must not be named at all.
"""

from __future__ import annotations

from collections.abc import Mapping

from tests.blind.hidden import body, cells, legs, outside, wiring
from tests.blind.hidden.contract import Injection

CATALOGUE: Mapping[str, Injection] = {
    item.key: item for room in (cells, wiring, outside, body, legs) for item in room.INJECTIONS
}
"""All hidden effects by key."""


def hidden_in(experiment: str, *, unseen: bool) -> tuple[Injection, ...]:
    """Effects with a size in an experiment: those of the library, or those outside it."""
    return tuple(
        item
        for item in CATALOGUE.values()
        if experiment in item.experiments and (not item.right) == unseen and not item.switch
    )


def switches_in(experiment: str, *, untestable: bool) -> tuple[Injection, ...]:
    """Effects of one size in an experiment: wiring, or what no such data can show."""
    return tuple(
        item
        for item in CATALOGUE.values()
        if item.switch and item.untestable == untestable and experiment in item.experiments
    )


__all__ = ["CATALOGUE", "Injection", "hidden_in", "switches_in"]
