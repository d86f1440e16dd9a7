"""The chain of effects: truth to log (`Chain.apply`) and log to truth (`Chain.remove`)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar, cast

import numpy as np

from footcal_cli.core.effects import TABLE
from footcal_cli.core.effects.contract import Effect, State, Theta, Trait
from footcal_cli.core.effects.contract import units_of as units_of
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray, IntArray, Parameter, ParameterSet

T = TypeVar("T")


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
    def _sizes(self) -> dict[str, tuple[tuple[str, float], ...]]:
        """Full name and neutral value of every size of each unit that has an owner."""
        return {
            unit: tuple((f"{owner}.{p.name}", p.neutral) for p in self.effect.sizes)
            for owner, members in self.owners.items()
            for unit in members
        }

    def acts(self, values: Mapping[str, float], units: Iterable[str] | None = None) -> bool:
        """Whether a size of any unit, or of some, differs from neutral; else it may be skipped."""
        sizes, get = self._sizes, values.get
        for unit in sizes if units is None else units:
            for name, neutral in sizes.get(unit, ()):
                if get(name, neutral) != neutral:
                    return True
        return False

    @cached_property
    def _keys(self) -> dict[str, tuple[str, ...]]:
        """Full name of every parameter of each unit that has an owner."""
        return {
            unit: tuple(f"{owner}.{p.name}" for p in self.effect.parameters)
            for owner, members in self.owners.items()
            for unit in members
        }

    def theta(self, values: Mapping[str, float], units: Sequence[str]) -> Theta:
        """Spread flat values over the units; parameters without a value stay neutral."""
        none = ("",) * len(self.effect.parameters)
        every, get = [self._keys.get(unit, none) for unit in units], values.get
        return {
            p.name: np.array([get(keys[i], p.neutral) for keys in every], dtype=float)
            for i, p in enumerate(self.effect.parameters)
        }


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
    """What effects were removed from one log, for finite differences.

    These move one parameter of one channel at a time: an effect whose log and values are what they
    were is not removed again, and of one that treats columns alone only those that moved.
    """

    def __init__(self) -> None:
        self._first: dict[tuple[str, int], _Removed] = {}
        self._last: dict[tuple[str, int], _Removed] = {}
        self._made: tuple[Log, object] | None = None
        self._anew = False

    def begin(self) -> None:
        """A chain is to be removed from the log."""
        self._anew = False

    def removed(self, effect: Effect, log: Log, theta: Theta) -> Log:
        """`Effect.remove`, as far as it was not done before; exact."""
        key = effect.name, len(log)
        last = self._last.get(key)
        for known in (last, self._first.get(key)):
            if known is not None and known.log is log and known.same(theta):
                return known.out
        self._anew = True
        if effect.by_column and last is not None and _at_the_same_rows(last.log, log):
            out = _columns_removed(effect, last, log, theta)
        else:
            out = effect.remove(log, theta, None)[0]
        self._last[key] = _Removed(log, theta, out)
        self._first.setdefault(key, self._last[key])
        return out

    def made_of(self, truth: Log, made: Callable[[Log], T]) -> T:
        """What is made of a log that a chain left, kept where nothing was removed anew."""
        if self._anew:
            return made(truth)
        if self._made is None or self._made[0] is not truth:
            self._made = truth, made(truth)
        return cast(T, self._made[1])


@dataclass(frozen=True)
class _Removed:
    """A log, the values of an effect that was removed from it, and what that gave."""

    log: Log
    theta: Theta
    out: Log

    def same(self, theta: Theta) -> bool:
        """Whether all parameters have the values that they had."""
        return all(v.tobytes() == self.theta[name].tobytes() for name, v in theta.items())


def _at_the_same_rows(one: Log, other: Log) -> bool:
    return one.time_s is other.time_s and one.block is other.block


def _columns_removed(effect: Effect, last: _Removed, log: Log, theta: Theta) -> Log:
    """`Effect.remove` of the columns that differ from the last ones."""
    readings, before = last.out.readings, last.log.readings
    other = np.zeros(len(log.channels), dtype=bool)
    if log.readings is not before:
        other |= np.any(log.readings != before, axis=0)
    for name, values in theta.items():
        other |= values != last.theta[name]
    if other.any():
        readings = readings.copy()
        readings[:, other] = _removed_from(effect, log, theta, np.flatnonzero(other))
    return log.with_readings(readings)


def _removed_from(effect: Effect, log: Log, theta: Theta, columns: IntArray) -> FloatArray:
    mine = {name: values[columns] for name, values in theta.items()}
    return effect.remove(log.of_channels(columns), mine, None)[0].readings


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

    def remembers(self, values: Mapping[str, float]) -> bool:
        """Whether removing it from a row asks for the rows before it."""
        return any(Trait.MEMORY in i.effect.traits and i.acts(values) for i in self.links)

    def truth(self, log: Log, values: Mapping[str, float], seen: Seen | None) -> Log:
        """As `remove` for a whole log, with what calls before it have left in `seen`."""
        if seen is not None:
            seen.begin()
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
            units = units_of(item.effect.scope, log.channels)
            if not item.acts(values, units):
                continue
            theta = item.theta(values, units)
            if seen is not None:
                log = seen.removed(item.effect, log, theta)
                continue
            transform = item.effect.apply if forward else item.effect.remove
            log, states[i] = transform(log, theta, states.get(i))
        return log, states
