"""The chain of effects: truth to log (`Chain.apply`) and log to truth (`Chain.remove`)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from footcal_cli.core.effects import TABLE
from footcal_cli.core.effects.contract import Effect, State, Theta, is_neutral
from footcal_cli.core.effects.contract import units_of as units_of
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import Parameter, ParameterSet


@dataclass(frozen=True)
class Link:
    """An effect in a chain, and who carries it.

    Parameters
    ----------
    effect
        The row of the table.
    owners
        Name of each parameter's owner -> the units (channels, feet, legs) that share its value.
        Units that no owner names are neutral.
    """

    effect: Effect
    owners: Mapping[str, tuple[str, ...]]

    def names(self) -> tuple[str, ...]:
        """Full parameter names, owner by owner."""
        return tuple(f"{o}.{p.name}" for o in self.owners for p in self.effect.parameters)

    def theta(self, values: Mapping[str, float], units: Sequence[str]) -> Theta:
        """Spread flat values over the units; parameters without a value stay neutral."""
        theta = {p.name: np.full(len(units), p.neutral) for p in self.effect.parameters}
        for owner, members in self.owners.items():
            at = [units.index(member) for member in members if member in units]
            for parameter in self.effect.parameters:
                theta[parameter.name][at] = values.get(
                    f"{owner}.{parameter.name}", parameter.neutral
                )
        return theta


def link(effect: Effect, channels: Sequence[str], only: Sequence[str] | None = None) -> Link:
    """A link in which every unit (or only the named ones) owns its parameters."""
    units = units_of(effect.scope, channels)
    chosen = units if only is None else tuple(only)
    missing = sorted(set(chosen) - set(units))
    if missing:
        raise KeyError(f"{effect.name}: no {effect.scope.value} named {', '.join(missing)}")
    return Link(effect, {unit: (unit,) for unit in chosen})


def chain_of(links: Iterable[Link]) -> Chain:
    """A chain of links in any order: by stage, then by place in the table, then as given."""
    place = {name: i for i, name in enumerate(TABLE)}
    ordered = sorted(
        links, key=lambda item: (item.effect.stage, place.get(item.effect.name, len(place)))
    )
    return Chain(tuple(ordered))


@dataclass(frozen=True)
class Chain:
    """Links in the order in which the truth passes through them."""

    links: tuple[Link, ...]

    def __post_init__(self) -> None:
        stages = [item.effect.stage for item in self.links]
        if stages != sorted(stages):
            raise ValueError("links out of order: a chain runs from bench to transport")

    def with_link(self, extra: Link) -> Chain:
        """A chain extended by one link, at the effect's place in the table."""
        return chain_of((*self.links, extra))

    def parameters(self) -> ParameterSet:
        """All parameters at neutral with the table's bounds and prior sd; shapes are not free."""
        return ParameterSet(
            tuple(
                Parameter(
                    f"{owner}.{p.name}",
                    p.unit,
                    p.neutral,
                    p.prior_sd,
                    p.lower,
                    p.upper,
                    free=not p.shape,
                )
                for item in self.links
                for owner in item.owners
                for p in item.effect.parameters
            )
        )

    def apply(
        self, log: Log, values: Mapping[str, float], state: Mapping[int, State] | None = None
    ) -> tuple[Log, dict[int, State]]:
        """Truth to log; pass the returned state on with the next chunk."""
        return self._run(log, values, state, forward=True)

    def remove(
        self, log: Log, values: Mapping[str, float], state: Mapping[int, State] | None = None
    ) -> tuple[Log, dict[int, State]]:
        """Log to truth; pass the returned state on with the next chunk."""
        return self._run(log, values, state, forward=False)

    def _run(
        self,
        log: Log,
        values: Mapping[str, float],
        state: Mapping[int, State] | None,
        *,
        forward: bool,
    ) -> tuple[Log, dict[int, State]]:
        states: dict[int, State] = dict(state or {})
        order = range(len(self.links)) if forward else reversed(range(len(self.links)))
        for i in order:
            item = self.links[i]
            theta = item.theta(values, units_of(item.effect.scope, log.channels))
            if is_neutral(item.effect, theta):
                continue
            transform = item.effect.apply if forward else item.effect.remove
            log, states[i] = transform(log, theta, states.get(i))
        return log, states
