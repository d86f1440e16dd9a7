"""Effects of a user's own: what a formula of recorded signals adds to a reading."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from footcal_cli.core.effects.contract import (
    Effect,
    EffectParameter,
    Scope,
    Stage,
    State,
    Theta,
    Trait,
    columns_of,
    is_six_axis,
)
from footcal_cli.core.effects.formula import Formula, FormulaError, formula_of
from footcal_cli.core.log import EXPERIMENT_NAMES, Log
from footcal_cli.core.parameters import FloatArray, IntArray

_ON_HIPS = frozenset({"hang", "pose"})
_STEPS, _CLOSE = 200, 1e-14
_LEAST_N = 1e-3
_REFERENCE_DEGC = 25.0


@dataclass(frozen=True)
class SignalKind:
    """A signal that a formula may use.

    Parameters
    ----------
    experiments
        Where it is known.
    needs
        Known quantities that it is made of on load cells.
    """

    meaning: str
    unit: str
    experiments: tuple[str, ...]
    needs: tuple[str, ...] = ()


_ON_PLATES = ("placements", "stand", "walk")
_SHEAR = ("walk", "hang", "pose")
_MOVING = ("mass_kg", "com_acc_mps2")

SIGNALS: Mapping[str, SignalKind] = {
    "load": SignalKind("what this cell or axis carries", "N (N·m)", EXPERIMENT_NAMES),
    "foot_load": SignalKind(
        "load of all cells of its foot; fz of its transducer", "N", (*_ON_PLATES, *sorted(_ON_HIPS))
    ),
    "shear_x": SignalKind("horizontal force on its foot, x", "N", _SHEAR, _MOVING),
    "shear_y": SignalKind("horizontal force on its foot, y", "N", _SHEAR, _MOVING),
    "shear": SignalKind("horizontal force on its foot", "N", _SHEAR, _MOVING),
    "cop_x": SignalKind("CoP of its foot, x", "m", _ON_PLATES, ("cell_pos_m",)),
    "cop_y": SignalKind("CoP of its foot, y", "m", _ON_PLATES, ("cell_pos_m",)),
    "temperature": SignalKind(
        "temperature − 25 °C",
        "K",
        ("weights", "placements", "stand", "walk", "hang"),
        ("temperature_degc",),
    ),
    "time": SignalKind("time since the start of the log", "s", EXPERIMENT_NAMES),
    "phase": SignalKind("shaft angle of its leg", "rad", ("hang", "pose"), ("phase_rad",)),
}
"""Name in a formula -> what it is."""


@dataclass(frozen=True)
class FormulaShape:
    """A number that only shapes an effect, tried at some values."""

    name: str
    unit: str
    values: tuple[float, ...]


@dataclass(frozen=True)
class OwnRow:
    """An effect as its user writes it: ``y = x + adds``.

    Parameters
    ----------
    name, adds, remedy
        Its name, the formula and what to do about it.
    size, unit, usual, bounds
        The number of the formula that says how large it is, its unit, the size met in practice and
        the physically allowed range, which holds zero.
    per
        Who has a size of its own.
    experiments
        Whose logs show it; all that know its signals where empty.
    shapes
        Further numbers of the formula.
    """

    name: str
    adds: str
    remedy: str
    unit: str
    usual: float
    size: str = "k"
    bounds: tuple[float, float] = (-np.inf, np.inf)
    per: Scope = Scope.CHANNEL
    experiments: tuple[str, ...] = ()
    shapes: tuple[FormulaShape, ...] = ()
    source: str = "the user"


def own_effect(row: OwnRow) -> Effect:
    """The effect of a row.

    Raises
    ------
    FormulaError
        The formula is none, uses what its experiments do not know, or adds something at size zero.
    """
    symbols = (row.size, *(shape.name for shape in row.shapes))
    taken = sorted(set(symbols) & set(SIGNALS))
    if taken or len(set(symbols)) < len(symbols):
        raise FormulaError(f"'{(taken or symbols)[0]}' is the name of something else")
    formula = formula_of(row.adds, frozenset({*symbols, *SIGNALS}))
    unused = [name for name in symbols if name not in formula.names]
    if unused:
        raise FormulaError(f"'{row.adds}' does not use '{unused[0]}'")
    signals = formula.names - set(symbols)
    experiments = row.experiments or tuple(
        e for e in EXPERIMENT_NAMES if all(e in SIGNALS[s].experiments for s in signals)
    )
    for signal in sorted(signals):
        lacking = [e for e in experiments if e not in SIGNALS[signal].experiments]
        if lacking or not experiments:
            where = " ".join(lacking) or "any experiment together with the others"
            raise FormulaError(f"'{signal}' is not known in {where}")
    _refuse_at_zero(formula, row, signals)
    on_hips = set(experiments) <= _ON_HIPS
    needs = () if on_hips else tuple(n for s in sorted(signals) for n in SIGNALS[s].needs)
    if on_hips and signals & {"phase", "temperature"}:
        needs = tuple(n for s in ("phase", "temperature") if s in signals for n in SIGNALS[s].needs)
    names = {row.size: row.name, **{s.name: f"{row.name}_{s.name}" for s in row.shapes}}
    added = _Added(formula, names, row.per)
    return Effect(
        name=row.name,
        stage=Stage.SIX_AXIS if on_hips else Stage.CELL,
        scope=row.per,
        parameters=(
            EffectParameter(row.name, row.unit, 0.0, *row.bounds, row.usual),
            *(
                EffectParameter(
                    names[s.name], s.unit, s.values[len(s.values) // 2], min(s.values) / 10.0,
                    10.0 * max(s.values), max(s.values), True, s.values,
                )
                for s in row.shapes
            ),
        ),
        apply=added.apply,
        remove=added.remove,
        experiments=experiments,
        formula=f"y = x + {row.adds}",
        source=row.source,
        remedy=row.remedy,
        needs=tuple(dict.fromkeys(needs)),
        traits=(Trait.MEMORY,) if "time" in signals else (),
        by_column=signals <= {"load"} and row.per is Scope.CHANNEL,
    )  # fmt: skip


def _refuse_at_zero(formula: Formula, row: OwnRow, signals: frozenset[str]) -> None:
    rng = np.random.default_rng(0)
    values = {name: rng.uniform(-2.0, 2.0, 50) for name in sorted(signals)}
    values |= {s.name: np.full(50, s.values[0]) for s in row.shapes}
    if np.any(formula({**values, row.size: np.zeros(50)}) != 0.0):
        raise FormulaError(f"'{row.adds}' adds something where {row.size} is zero")


@dataclass(frozen=True)
class _Added:
    """``y = x + f(x, signals)`` and back; `names` are the parameters of the formula's numbers."""

    formula: Formula
    names: Mapping[str, str]
    scope: Scope

    def apply(self, log: Log, theta: Theta, state: State) -> tuple[Log, State]:
        numbers, start = self._numbers(log, theta), _start(log, state)
        added = self._added(log, log.readings, numbers, start)
        return log.with_readings(log.readings + added), self._kept(start)

    def remove(self, log: Log, theta: Theta, state: State) -> tuple[Log, State]:
        """By the fixed point ``x ← y − f(x)``, which contracts where the effect is small."""
        numbers, start = self._numbers(log, theta), _start(log, state)
        shown, found = log.readings, log.readings
        for _ in range(_STEPS):
            after = shown - self._added(log, found, numbers, start)
            moved = np.abs(after - found).max(initial=0.0)
            found = after
            if not moved > _CLOSE * (1.0 + np.abs(shown).max(initial=0.0)):
                break
        return log.with_readings(found), self._kept(start)

    def _kept(self, start: float) -> State:
        """What the next chunk needs: when the log began, if the formula asks for the time."""
        return start if "time" in self.formula.names else None

    def _numbers(self, log: Log, theta: Theta) -> dict[str, FloatArray]:
        """Size and shapes of each channel, shape (c,)."""
        spread = {name: np.zeros(len(log.channels)) for name in self.names}
        for unit, columns in enumerate(columns_of(self.scope, log.channels)):
            for name, parameter in self.names.items():
                spread[name][columns] = np.asarray(theta[parameter])[unit]
        return spread

    def _added(
        self, log: Log, readings: FloatArray, numbers: Mapping[str, FloatArray], start: float
    ) -> FloatArray:
        values = dict(numbers)
        for name in self.formula.names - set(self.names):
            values[name] = _OF[name](log, readings, start)
        return np.broadcast_to(self.formula(values), readings.shape)


def _start(log: Log, state: State) -> float:
    """The first stamp of a log, whichever piece of it this is."""
    return float(log.time_s[0]) if state is None else float(state)


def _per_foot(log: Log, of: Callable[[IntArray], FloatArray]) -> FloatArray:
    """A signal of the channels of each foot or leg, given to all of them, shape (n, c)."""
    scope = Scope.LEG if is_six_axis(log.channels) else Scope.FOOT
    found = np.zeros(log.readings.shape)
    for columns in columns_of(scope, log.channels):
        found[:, columns] = of(columns)[:, None]
    return found


def _foot_load(log: Log, readings: FloatArray, _: float) -> FloatArray:
    if is_six_axis(log.channels):
        return _per_foot(log, lambda columns: readings[:, columns[2]])
    return _per_foot(log, lambda columns: readings[:, columns].sum(axis=1))


def _shear(axis: int) -> Callable[[Log, FloatArray, float], FloatArray]:
    """Of a transducer its own; of cells the foot's share of what accelerates the body."""

    def of(log: Log, readings: FloatArray, start: float) -> FloatArray:
        if is_six_axis(log.channels):
            return _per_foot(log, lambda columns: readings[:, columns[axis]])
        total = np.maximum(readings.sum(axis=1), _LEAST_N)[:, None]
        force = log.known["mass_kg"] * log.known["com_acc_mps2"][:, axis]
        return np.asarray(force[:, None] * _foot_load(log, readings, start) / total)

    return of


def _cop(axis: int) -> Callable[[Log, FloatArray, float], FloatArray]:
    def of(log: Log, readings: FloatArray, _: float) -> FloatArray:
        def mean(columns: IntArray) -> FloatArray:
            force = readings[:, columns]
            place = log.known["cell_pos_m"][:, columns, axis]
            total = force.sum(axis=1)
            sure = np.where(np.abs(total) > _LEAST_N, total, np.inf)
            return np.asarray((place * force).sum(axis=1) / sure)

        return _per_foot(log, mean)

    return of


def _phase(log: Log, readings: FloatArray, _: float) -> FloatArray:
    found = np.zeros(readings.shape)
    for leg, columns in enumerate(columns_of(Scope.LEG, log.channels)):
        found[:, columns] = log.known["phase_rad"].reshape(len(log), -1)[:, leg, None]
    return found


_OF: Mapping[str, Callable[[Log, FloatArray, float], FloatArray]] = {
    "load": lambda log, readings, start: readings,
    "foot_load": _foot_load,
    "shear_x": _shear(0),
    "shear_y": _shear(1),
    "shear": lambda log, readings, start: np.hypot(
        _shear(0)(log, readings, start), _shear(1)(log, readings, start)
    ),
    "cop_x": _cop(0),
    "cop_y": _cop(1),
    "temperature": lambda log, readings, start: np.broadcast_to(
        log.known["temperature_degc"][:, None] - _REFERENCE_DEGC, readings.shape
    ),
    "time": lambda log, readings, start: np.broadcast_to(
        (log.time_s - start)[:, None], readings.shape
    ),
    "phase": _phase,
}
