"""Who may carry an effect. Room: core/inference; signatures and the diagnosis import it."""

from __future__ import annotations

from collections.abc import Sequence

from footcal_cli.core.chain import Chain
from footcal_cli.core.effects.contract import Effect, Scope, Trait, units_of
from footcal_cli.core.inference.case import Case

Owners = tuple[tuple[str, tuple[str, ...]], ...]
EffectPlace = tuple[str, Owners, tuple[str, ...]]
"""Where in words, owners as in a link, and the units that share the size."""


def carriers(case: Case, effect: Effect) -> tuple[str, ...]:
    """The cells, feet, legs or the robot that an effect acts on, each once."""
    return tuple(
        dict.fromkeys(u for log in case.logs for u in units_of(effect.scope, log.channels))
    )


def places(effect: Effect, units: Sequence[str]) -> list[EffectPlace]:
    """Who may carry an effect: everyone alike, one foot's cells, a single one.

    Returns
    -------
    where, owners, members of each.
    """
    if effect.scope is Scope.ROBOT:
        alone = (("robot", ("robot",)),)
        return [("robot", alone, ("robot",))]
    noun = {Scope.CHANNEL: "cells", Scope.FOOT: "feet", Scope.LEG: "legs"}[effect.scope]
    every = tuple(units)
    found: list[EffectPlace] = []
    # what scales all cells alike is a mass: a gain that changed is one cell's
    if len(every) > 1 and Trait.GAIN not in effect.traits:
        found.append((f"all {noun}", (("all", every),), every))
        feet = dict.fromkeys(u.split("_", 1)[0] for u in every)
        if effect.scope is Scope.CHANNEL and 1 < len(feet) < len(every):
            for foot in feet:
                mine = tuple(u for u in every if u.split("_", 1)[0] == foot)
                found.append((f"{foot} foot", ((foot, mine),), mine))
    found += [(u, ((u, (u,)),), (u,)) for u in every]
    return found


def owners_of(chain: Chain, effect: Effect) -> set[str]:
    """Who has a value of an effect already, from a calibration: a group may have more of it."""
    return {o for item in chain.links if item.effect.name == effect.name for o in item.owners}


def own_place(case: Case, effect: Effect) -> tuple[str, Owners] | None:
    """Every cell with a value of its own, where there are several cells; named like the others."""
    units = carriers(case, effect)
    if effect.scope is not Scope.CHANNEL or len(units) < 2 or owners_of(case.chain, effect):
        return None
    return "each cell of its own", tuple((u, (u,)) for u in units)
