"""Signatures of all units of an effect at once: balances are linear in readings, row by row.

Room: core, inference; asked by its signatures. With ``e(x)`` the errors of a balance for readings x
(n, c) of a log whose chain is removed, ``∂e/∂x_c`` of each row does not depend on x. So what an
effect of one unit (cell, foot, leg) adds is ``Σ_c ∂e/∂x_c · Δx_c`` over the unit's own columns, and
one Δx, in which every unit moved, holds those of all units. Whether units are apart is not said of
an effect but seen: the first and the last unit, moved alone, move their own columns alike and no
others.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from footcal_cli.core.chain import Link, Seen
from footcal_cli.core.effects.contract import Effect, EffectParameter, Scope, columns_of, units_of
from footcal_cli.core.inference.case import Case
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray, IntArray

STEP = 0.02
"""Finite-difference step of a size, in its prior sd."""
BESIDE = "+"
"""Before the owner of a trial size, which may stand beside one that is calibrated."""
_ROUNDING = 1e-12
"""Units of noise per unit of a reading."""
_ALIKE = 1e-6
"""Share of the largest change up to which two changes are one."""


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
    truth
        Its judged rows, the chain removed.
    columns
        Of each channel: entries of the log that follow it, their judged rows, and how much.
    """

    truth: Log
    columns: tuple[tuple[IntArray, IntArray, FloatArray], ...]


@dataclass(eq=False)
class Responses:
    """What changes of readings add to the rows of a case; remembers the gains of each log.

    Parameters
    ----------
    seen
        From `Case.memory`.
    """

    case: Case
    rows: Problem
    seen: Sequence[Seen]
    _gains: dict[int, _Gains] = field(default_factory=dict, init=False, repr=False)
    _apart: dict[tuple[str, str, int], bool] = field(default_factory=dict, init=False, repr=False)

    def of_units(
        self,
        effect: Effect,
        size: EffectParameter,
        shapes: Mapping[str, Mapping[str, float]],
    ) -> dict[str, FloatArray] | None:
        """What size one of an effect of each unit alone adds to the residual, shape (m,) each.

        Parameters
        ----------
        shapes
            Of each unit.

        Returns
        -------
        None where it takes one chain for each unit: readings of one depend on the size of another,
        or the effect changes what is known.
        """
        if effect.scope is Scope.ROBOT:
            return None
        units = tuple(shapes)
        chain = self.case.chain.with_link(Link(effect, {BESIDE + u: (u,) for u in units}))
        forms = {f"{BESIDE}{u}.{k}": v for u in units for k, v in shapes[u].items()}
        values = {**self.case.values, **forms}
        low, high = ends_of(size)
        found = {u: np.zeros(self.rows.residual.size) for u in units}
        for i, log in enumerate(self.case.logs):
            key = effect.name, size.name, i
            if not self._apart.get(key, True):
                return None

            def moved(by: float, mine: Sequence[str], i: int = i) -> Log:
                sizes = {f"{BESIDE}{u}.{size.name}": size.neutral + by for u in mine}
                return self.case.truth(i, chain, {**values, **sizes}, self.seen[i])

            every = moved(high, units)
            gains = self._gains_of(i)
            places = zip(
                units_of(effect.scope, log.channels),
                columns_of(effect.scope, log.channels),
                strict=True,
            )
            columns = {unit: own for unit, own in places if unit in shapes}
            there = list(columns)
            if key not in self._apart and np.any(every.readings != gains.truth.readings):
                ends = there[:: len(there) - 1] if len(there) > 1 else ()
                self._apart[key] = all(
                    _alone(gains.truth, moved(high, [u]), every, columns[u]) for u in ends
                )
            if not self._apart.get(key, True) or not _same(gains.truth.known, every.known):
                return None
            change = (moved(low, units).readings - every.readings) / (high - low)
            here = np.arange(self.rows.residual.size)[self.rows.places[i][0]]
            for unit, own in columns.items():
                for c in np.arange(len(log.channels))[own]:
                    at, row, gain = gains.columns[c]
                    found[unit][here[at]] += gain * change[row, c]
        return found

    def _gains_of(self, number: int) -> _Gains:
        if number not in self._gains:
            case, at = self.case, self.rows.places[number][1]
            truth = case.truth(number, case.chain, case.values, self.seen[number])
            noise = self.rows.noise[self.rows.places[number][0]]
            outputs = case.experiment.balance(truth).error.shape[1]

            def errors(readings: FloatArray) -> FloatArray:
                error = case.experiment.balance(truth.with_readings(readings)).error
                return np.asarray(error.ravel()[at] / noise)

            still, columns = errors(truth.readings), []
            for unit in np.eye(truth.readings.shape[1]):
                gain = errors(truth.readings + unit) - still
                follows = np.flatnonzero(np.isfinite(gain) & (np.abs(gain) > _ROUNDING))
                columns.append((follows, at[follows] // outputs, gain[follows]))
            self._gains[number] = _Gains(truth, tuple(columns))
        return self._gains[number]


def _alone(still: Log, alone: Log, every: Log, own: slice | IntArray) -> bool:
    """Whether a unit that moved alone moved its own columns as with all others, and only these."""
    expected = np.zeros_like(still.readings)
    expected[:, own] = (every.readings - still.readings)[:, own]
    change = alone.readings - still.readings
    largest = float(np.nanmax(np.abs(every.readings - still.readings), initial=0.0))
    return bool(np.all(np.abs(np.nan_to_num(change - expected)) <= _ALIKE * largest))


def _same(one: Mapping[str, FloatArray], other: Mapping[str, FloatArray]) -> bool:
    """Whether the same is known."""
    return one.keys() == other.keys() and all(
        array is other[name] or np.array_equal(array, other[name], equal_nan=True)
        for name, array in one.items()
    )
