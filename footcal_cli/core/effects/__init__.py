"""The table of effects, one module per stage of the chain.

`TABLE` holds every known effect by name, in the order in which the truth passes through them.
To add one, append its row to the `EFFECTS` of its module.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from types import MappingProxyType

from footcal_cli.core.effects import (
    bench,
    body,
    calibration,
    cells,
    digital,
    foot,
    memory_effects,
    six_axis,
    six_axis_beliefs,
    transport,
)
from footcal_cli.core.effects.contract import Effect, Trait, can_carry

_MODULES = (
    bench.EFFECTS,
    body.EFFECTS,
    six_axis_beliefs.EFFECTS,
    foot.EFFECTS,
    six_axis.EFFECTS,
    cells.EFFECTS,
    memory_effects.EFFECTS,
    calibration.EFFECTS,
    digital.EFFECTS,
    transport.EFFECTS,
)

TABLE: Mapping[str, Effect] = MappingProxyType(
    {effect.name: effect for effects in _MODULES for effect in effects}
)
"""Every known effect by name, in chain order."""


class UnknownEffectError(KeyError):
    """A name that the table does not have."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.nearest = next(iter(get_close_matches(name, TABLE, n=1, cutoff=0.4)), None)
        hint = f"; did you mean {self.nearest}?" if self.nearest else ""
        super().__init__(f"no effect named {name}{hint}")

    def __str__(self) -> str:
        return str(self.args[0])


def find_effect(name: str) -> Effect:
    """The row of an effect.

    Raises
    ------
    UnknownEffectError
        With the nearest known name.
    """
    try:
        return TABLE[name]
    except KeyError:
        raise UnknownEffectError(name) from None


def having(*traits: Trait, experiment: str = "") -> frozenset[str]:
    """Names of the effects that have any of the traits, and that an experiment's balance can see.

    Parameters
    ----------
    experiment
        Its name; all where empty.
    """
    return frozenset(
        effect.name
        for effect in TABLE.values()
        if not set(traits).isdisjoint(effect.traits)
        and (not experiment or experiment in effect.experiments)
    )


def calibration_of(channels: Sequence[str]) -> Effect:
    """What calibrates these sensors: scale and bias of cells, offsets of transducers."""
    return next(
        effect
        for effect in TABLE.values()
        if Trait.CALIBRATION in effect.traits and can_carry(channels, effect)
    )
