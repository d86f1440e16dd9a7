"""The chain of effects: truth to log (`Chain.apply`) and log to truth (`Chain.remove`)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from footcal_cli.core.effects import TABLE
from footcal_cli.core.effects.contract import Effect, State, Theta, is_neutral
from footcal_cli.core.effects.contract import units_of as units_of
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray, IntArray, Parameter, ParameterSet


@dataclass(frozen=True)
class Link:
    """An effect in a chain, and who carries it.

    Parameters
    ----------
    owners
        Name of each parameter's owner -> the units (channels, feet, legs) that share its value.
        Units that no owner names are neutral.
    """

    effect: Effect
    owners: Mapping[str, tuple[str, ...]]

    def names(self) -> tuple[str, ...]:
        """Full parameter names, owner by owner."""
        return tuple(f"{o}.{p.name}" for o in self.owners for p in self.effect.parameters)

    @cached_property
    def _sizes(self) -> tuple[tuple[str, float], ...]:
        """Full name and neutral value of every size."""
        return tuple((f"{o}.{p.name}", p.neutral) for o in self.owners for p in self.effect.sizes)

    def acting(self, values: Mapping[str, float]) -> tuple[str, ...]:
        """Full names of the sizes that are not neutral; without any the link may be skipped."""
        return tuple(n for n, neutral in self._sizes if values.get(n, neutral) != neutral)

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


class Seen:
    """Columns of one log that an effect has been removed from, for finite differences.

    These move one channel at a time, so that seven of eight columns are what they were.
    """

    def __init__(self) -> None:
        self._last: dict[str, tuple[Log, Theta, FloatArray]] = {}

    def removed(self, effect: Effect, log: Log, theta: Theta) -> Log:
        """`Effect.remove` of the columns that differ from the last ones; exact."""
        last = self._last.get(effect.name)
        if last is None or not _at_the_same_rows(last[0], log):
            out = effect.remove(log, theta, None)[0].readings
        else:
            before, with_theta, out = last
            other = np.any(log.readings != before.readings, axis=0)
            for name, values in theta.items():
                other |= values != with_theta[name]
            if other.any():
                out = out.copy()
                out[:, other] = _removed_from(effect, log, theta, np.flatnonzero(other))
        self._last[effect.name] = (log, theta, out)
        return log.with_readings(out)


def _at_the_same_rows(one: Log, other: Log) -> bool:
    return one.time_s is other.time_s and one.block is other.block


def _removed_from(effect: Effect, log: Log, theta: Theta, columns: IntArray) -> FloatArray:
    part = replace(
        log,
        channels=tuple(log.channels[c] for c in columns),
        readings=np.ascontiguousarray(log.readings[:, columns]),
        known={},
    )
    mine = {name: values[columns] for name, values in theta.items()}
    return effect.remove(part, mine, None)[0].readings


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

    def remembers(self, log: Log, values: Mapping[str, float]) -> bool:
        """Whether what it makes of a row of the log depends on the rows before it."""
        states = self.remove(log.rows(0, 2), values)[1]
        return any(state is not None for state in states.values())

    def truth(self, log: Log, values: Mapping[str, float], seen: Seen | None) -> Log:
        """As `remove` for a whole log, with what calls before it have left in `seen`."""
        return self._run(log, values, None, forward=False, seen=seen)[0]

    def _run(
        self,
        log: Log,
        values: Mapping[str, float],
        state: Mapping[int, State] | None,
        *,
        forward: bool,
        seen: Seen | None = None,
    ) -> tuple[Log, dict[int, State]]:
        states: dict[int, State] = dict(state or {})
        order = range(len(self.links)) if forward else reversed(range(len(self.links)))
        for i in order:
            item = self.links[i]
            if not item.acting(values):
                continue
            theta = item.theta(values, units_of(item.effect.scope, log.channels))
            if is_neutral(item.effect, theta):
                continue
            if seen is not None and item.effect.by_column:
                log = seen.removed(item.effect, log, theta)
                continue
            transform = item.effect.apply if forward else item.effect.remove
            log, states[i] = transform(log, theta, states.get(i))
        return log, states
