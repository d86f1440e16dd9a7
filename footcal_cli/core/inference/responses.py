"""Signatures of all units of an effect at once: balances are linear in readings, row by row.

Room: core, inference; asked by its signatures. With ``e(x)`` the errors of a balance for readings x
(n, c) of a log whose chain is removed, ``∂e/∂x_c`` of each row does not depend on x. So what an
effect of one unit (cell, foot, leg) adds is ``Σ_c ∂e/∂x_c · Δx_c`` over the unit's own columns, and
one Δx, in which every unit moved, holds those of all units.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from footcal_cli.core.chain import Chain, Link, Seen
from footcal_cli.core.effects.contract import (
    Effect,
    EffectParameter,
    Scope,
    Stage,
    Trait,
    columns_of,
    units_of,
)
from footcal_cli.core.inference.case import Case, Rows
from footcal_cli.core.parameters import FloatArray, IntArray

STEP = 0.02
"""Finite-difference step of a size, in its prior sd."""
_ROUNDING = 1e-12
"""Units of noise per unit of a reading."""


def ends_of(size: EffectParameter) -> tuple[float, float]:
    """Where a size is evaluated around neutral: on one side alone at the edge of its range."""
    step = STEP * size.prior_sd
    low = -step if size.neutral - step >= size.lower else 0.0
    high = step if size.neutral + step <= size.upper else 0.0
    return low, high


@dataclass(frozen=True)
class _Gains:
    """``∂e/∂x_c`` of one log in units of noise.

    Parameters
    ----------
    known
        What the balance reads beside the readings.
    columns
        Of each channel: entries of the log that follow it, their judged rows, and how much.
    """

    known: Mapping[str, FloatArray]
    columns: tuple[tuple[IntArray, IntArray, FloatArray], ...]


@dataclass(frozen=True)
class Responses:
    """What changes of readings add to the rows of a case.

    Parameters
    ----------
    seen
        From `Case.memory`.
    """

    case: Case
    rows: Rows
    seen: Sequence[Seen]
    _gains: dict[int, _Gains] = field(default_factory=dict, init=False, repr=False, compare=False)

    def of_units(
        self,
        effect: Effect,
        size: EffectParameter,
        units: Sequence[str],
        shape: Mapping[str, float],
    ) -> dict[str, FloatArray] | None:
        """What size one of an effect of each unit alone adds to the residual, shape (m,) each.

        Returns
        -------
        None where it takes one chain for each unit: columns are mixed, or the effect changes what
        is known.
        """
        chain = self.case.chain.with_link(Link(effect, {u: (u,) for u in units}))
        if not _apart(chain, effect, self.case.values):
            return None
        values = {**self.case.values, **{f"{u}.{k}": v for u in units for k, v in shape.items()}}
        low, high = ends_of(size)
        ends = [
            {**values, **{f"{u}.{size.name}": size.neutral + by for u in units}}
            for by in (low, high)
        ]
        found = {u: np.zeros(self.rows.row.size) for u in units}
        for i, log in enumerate(self.case.logs):
            truths = [self.case.truth(i, chain, at, self.seen[i]) for at in ends]
            gains = self._gains_of(i)
            if not all(_same(gains.known, truth.known) for truth in truths):
                return None
            change = (truths[0].readings - truths[1].readings) / (high - low)
            here = np.arange(self.rows.row.size)[self.rows.places[i][0]]
            mine = zip(units_of(effect.scope, log.channels),
                       columns_of(effect.scope, log.channels), strict=True)  # fmt: skip
            for unit, columns in mine:
                for c in np.arange(len(log.channels))[columns]:
                    at, row, gain = gains.columns[c]
                    found[unit][here[at]] += gain * change[row, c]
        return found

    def _gains_of(self, number: int) -> _Gains:
        if number not in self._gains:
            case, at = self.case, self.rows.places[number][1]
            truth = case.truth(number, case.chain, case.values, self.seen[number])
            noise = self.rows.noise[self.rows.places[number][0]]

            def errors(readings: FloatArray) -> FloatArray:
                error = case.experiment.balance(truth.with_readings(readings)).error
                return np.asarray(error.ravel()[at] / noise)

            still, columns = errors(truth.readings), []
            outputs = case.experiment.balance(truth).error.shape[1]
            for c in range(truth.readings.shape[1]):
                moved = truth.readings.copy()
                moved[:, c] += 1.0
                gain = errors(moved) - still
                follows = np.flatnonzero(np.isfinite(gain) & (np.abs(gain) > _ROUNDING))
                columns.append((follows, at[follows] // outputs, gain[follows]))
            self._gains[number] = _Gains(truth.known, tuple(columns))
        return self._gains[number]


def _same(one: Mapping[str, FloatArray], other: Mapping[str, FloatArray]) -> bool:
    """Whether the same is known."""
    return one.keys() == other.keys() and all(
        array is other[name] or np.array_equal(array, other[name], equal_nan=True)
        for name, array in one.items()
    )


_WITHIN: Mapping[Scope, frozenset[Scope]] = {
    Scope.CHANNEL: frozenset({Scope.CHANNEL}),
    Scope.FOOT: frozenset({Scope.CHANNEL, Scope.FOOT}),
    Scope.LEG: frozenset({Scope.CHANNEL, Scope.LEG}),
}
"""Whose effects keep what is said of a unit of each scope within its columns."""


def _apart(chain: Chain, effect: Effect, values: Mapping[str, float]) -> bool:
    """Whether a unit's columns follow its own sizes alone, once the chain is removed.

    Asked of the effect and of those that are removed after it.
    """
    if effect.scope not in _WITHIN or Trait.MIXTURE in effect.traits:
        return False
    for item in chain.links:
        other = item.effect
        if other.name == effect.name:
            return True
        beliefs = other.stage is Stage.BODY or Trait.BELIEF in other.traits
        mixes = other.scope not in _WITHIN[effect.scope] or Trait.MIXTURE in other.traits
        if mixes and not beliefs and item.acts(values):
            return False
    return True
