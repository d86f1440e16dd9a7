"""What an effect is: a row of data that says how a truth turns into what a log shows."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum, StrEnum
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray, IntArray

Theta = Mapping[str, FloatArray]
"""Values of an effect's parameters by name, shape (u,): one per channel, foot, leg or stream."""
State = Any
"""What an effect with memory carries from one chunk to the next; None at the start and without."""
Transform = Callable[[Log, Theta, State], tuple[Log, State]]
ArrayTransform = Callable[[FloatArray, Log, Theta, State], tuple[FloatArray, State]]


class Stage(IntEnum):
    """Where along the way from truth to log an effect acts; a chain applies them in this order."""

    BENCH = 1
    BODY = 2
    FOOT = 3
    SIX_AXIS = 4
    CELL = 5
    CALIBRATION = 6
    DIGITAL = 7
    TRANSPORT = 8


class Scope(StrEnum):
    """Who owns one value of each parameter."""

    CHANNEL = "channel"
    FOOT = "foot"
    LEG = "leg"
    ROBOT = "robot"


def units_of(scope: Scope, channels: Sequence[str]) -> tuple[str, ...]:
    """Who owns parameters of a scope on these channels: the channels, feet, legs, or the robot.

    A channel ``left_fl`` belongs to the foot ``left``; an axis ``fl.fx`` belongs to the leg ``fl``,
    which is a foot where its transducer is in the foot.
    """
    return _units_of(scope, tuple(channels))


@lru_cache
def _units_of(scope: Scope, channels: tuple[str, ...]) -> tuple[str, ...]:
    """`units_of`, which every step of every fit asks for the same few channels."""
    if scope is Scope.ROBOT:
        return ("robot",)
    if scope is Scope.CHANNEL:
        return channels
    separator = "_" if scope is Scope.FOOT and not is_six_axis(channels) else "."
    return tuple(dict.fromkeys(channel.split(separator, 1)[0] for channel in channels))


def columns_of(scope: Scope, channels: Sequence[str]) -> tuple[IntArray, ...]:
    """Columns of the readings that belong to each unit, in the order of `units_of`."""
    return tuple(
        np.array([i for i, c in enumerate(channels) if scope is Scope.ROBOT or unit in _owners(c)])
        for unit in units_of(scope, channels)
    )


def _owners(channel: str) -> tuple[str, str, str]:
    """Every unit a channel belongs to: itself, its foot, its leg."""
    return channel, channel.split("_", 1)[0], channel.split(".", 1)[0]


def is_six_axis(channels: Sequence[str]) -> bool:
    """Whether the channels are axes of transducers (``fl.fx``) and not cells."""
    return _is_six_axis(tuple(channels))


@lru_cache
def _is_six_axis(channels: tuple[str, ...]) -> bool:
    return bool(channels) and all("." in channel for channel in channels)


class GridOf(StrEnum):
    """What the values of a shape's grid are shares of, or where they come from."""

    ITSELF = ""
    LOAD = "largest load"
    SPAN = "rows of a log, and its pauses"
    RATE = "rate of once in the longest log"
    LABEL = "weights in use"
    HOLE = "holes in use"
    PIECE = "pieces that stacks are made of"


OF_THE_LOGS = (GridOf.LABEL, GridOf.HOLE, GridOf.PIECE)
"""Grids that the logs bring: which weight, which hole; nothing lies between two of them."""


class Trait(StrEnum):
    """What other rooms ask of an effect, so that they need not know it by name."""

    CALIBRATION = "calibrates what a sensor itself shows"
    MOUNTING = "how a transducer is mounted"
    HUNG = "of a hanging leg: its weight, its CoM, how it hangs askew"
    BELIEF = "acts on what is believed, not on readings"
    LINEAR = "a matrix between true and shown wrench"
    AXIS_GAIN = "a gain of each axis"
    ZERO_TOO = "changes what a transducer shows of any load, and with it its zero"
    CURVE = "a curve of a cell's own load"
    SMOOTH = "a curve of one number, without a knee"
    KNEE = "a curve that is straight on both sides of its knee"
    SPECTRUM = "remembers loads; several with other shapes add up to any memory of its kind"
    MIXTURE = "what one cell shows depends on the load of others, in a fixed pattern"
    OF_THE_SUM = "an error of a load as a whole, whoever carries it"
    LOW_PASS = "a low-pass, known in its first order only"
    TIMED = "needs time stamps"
    MEMORY = "removing it from a row asks for the rows before it"
    SWITCH = "on or off: differentiated at the swapped readings, a whole one looks like −1"
    WHOLE = "on or off, and as steep in its size at none: half a one is none"
    UNGRADED = "no size to differentiate by; looked for among the raw data"
    SYMMETRIC = "two shapes that may change places"
    SMALL_CELL = "said of load cells; its shapes are those of cells of some newtons"
    ALL_ALIKE = "scales all forces alike, as a gain that all cells share"
    GAIN = "scales what one cell shows: in a walk, no more than its own calibration may do"
    ZERO = "moves what one sensor shows of no load: in a walk, its own calibration follows it"


DRIFT_TAKES_IT = "a calibration that drifts while walking follows it; "


@dataclass(frozen=True)
class EffectParameter:
    """One number of an effect.

    Parameters
    ----------
    name, unit
        ``hysteresis_width`` in ``N``; the full name in a chain is ``<owner>.<name>``.
    neutral
        The value at which the effect does nothing.
    lower, upper
        Physically allowed range.
    prior_sd
        Size met in practice; the prior of a fit and the yardstick of `diagnose`.
    shape
        True for a parameter that only shapes the effect (a time constant): it has no influence
        while the effect's size is neutral, and is searched on `grid`; its `neutral` is only the
        value taken where none is given.
    grid
        Values worth trying for a shape parameter.
    grid_of
        The grid is in shares of the largest load in the logs, or the logs bring their own.
    far
        Changes of a size that acts far from linearly, at which its signature is taken beside the
        derivative.
    beside
        True for a size that is fitted with the effect's others, and is no candidate by itself.
    """

    name: str
    unit: str
    neutral: float
    lower: float
    upper: float
    prior_sd: float
    shape: bool = False
    grid: tuple[float, ...] = ()
    grid_of: GridOf = GridOf.ITSELF
    far: tuple[float, ...] = ()
    beside: bool = False

    @property
    def tried(self) -> str:
        """Where a shape is tried, in words."""
        if self.grid_of in OF_THE_LOGS:
            return f"all {self.grid_of}"
        of = f" of the {self.grid_of}" if self.grid_of else ""
        return ", ".join(f"{value:g}" for value in self.grid) + of


@dataclass(frozen=True)
class Effect:
    """A named way in which a sensor, a mount, a clock, an IMU or a foot distorts a log.

    Parameters
    ----------
    name
        The field's word for it.
    stage, scope
        Where it acts and who owns its parameters.
    parameters
        Sizes first (one, or one per axis), then shapes.
    apply, remove
        ``(log, theta, state) -> (log, state)``: truth to log and back.
    needs
        Known quantities that drive it (keys of `Log.known`); it is not testable without them.
    experiments
        Experiments whose balance can see it.
    formula, source
        The equation and where it comes from.
    remedy
        In one line, what a user would do about it.
    mimics
        Effects that look alike in some experiment, and what separates them.
    separates
        The experiment that tells it from its mimics.
    tolerance
        Largest error of remove after apply over the largest value, on smooth signals where the
        inverse has to interpolate.
    invertible
        False where no inverse exists (saturation, a stuck channel) and remove is the best guess.
    stated
        ``(log before, log after) -> value per unit``, in the unit of the first size: what is given
        as the effect's size where recordings determine that rather than the parameter; the
        parameter's own value where absent.
    stated_as
        What it is called.
    other_form
        The same effect as a smooth curve, to apply and to remove: where that explains as much, no
        knee is sure.
    traits
        What it is, for whoever treats such effects alike.
    unseen_walking
        Why a walk alone cannot show it, and what would; empty where it can.
    most
        ``shape by short name -> size``: the largest size that is possible in a shape, where that
        is less than the size's own range.
    form_error
        Sd, as a share, by which what is stated is off where the real effect has another form than
        the table's; all data share it.
    by_column
        True where each channel is removed by itself, from its own readings and the stamps alone:
        what a change of another channel leaves as it was need not be removed again.
    of_recording
        True where its size belongs to one recording (a wrong label, a slip, a drift), not to the
        robot: another recording says nothing of it.
    anticipates
        True where removing needs samples that come later (a delay): chunk by chunk, the last
        samples of each chunk are extrapolated.
    """

    name: str
    stage: Stage
    scope: Scope
    parameters: tuple[EffectParameter, ...]
    apply: Transform
    remove: Transform
    experiments: tuple[str, ...]
    formula: str
    source: str
    remedy: str
    needs: tuple[str, ...] = ()
    mimics: tuple[str, ...] = ()
    separates: str = ""
    tolerance: float = 1e-9
    invertible: bool = True
    anticipates: bool = False
    of_recording: bool = False
    by_column: bool = False
    stated: Callable[[Log, Log], FloatArray] | None = None
    stated_as: str = ""
    most: Callable[[Mapping[str, float]], float] | None = None
    form_error: float = 0.0
    other_form: tuple[Transform, Transform] | None = None
    traits: tuple[Trait, ...] = ()
    unseen_walking: str = ""

    @property
    def size(self) -> EffectParameter:
        """The parameter that says how large the effect is (the first one of several)."""
        return self.parameters[0]

    @cached_property
    def sizes(self) -> tuple[EffectParameter, ...]:
        """All parameters that make the effect act, without the shapes."""
        return tuple(parameter for parameter in self.parameters if not parameter.shape)

    def largest(self, size: EffectParameter, shape: Mapping[str, float]) -> float:
        """Upper end of a size in a shape, given by short name."""
        return size.upper if self.most is None else min(size.upper, self.most(shape))

    def least(self, size: EffectParameter, shape: Mapping[str, float]) -> float:
        """Lower end of a size in a shape."""
        return size.lower if self.most is None else max(size.lower, -self.most(shape))

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Names of all parameters, sizes first."""
        return tuple(parameter.name for parameter in self.parameters)

    @property
    def shapes(self) -> tuple[EffectParameter, ...]:
        """The parameters that only shape it."""
        return tuple(parameter for parameter in self.parameters if parameter.shape)


def unchanged(y: FloatArray, _log: Log, _theta: Theta, state: State) -> tuple[FloatArray, State]:
    """The way back of what cannot be undone."""
    return y, state


Amount = Callable[[Log, Theta], FloatArray]
"""What an effect without memory adds, or multiplies by."""


def plus(amount: Amount, sign: float = 1.0) -> ArrayTransform:
    """``x + amount``; with the sign −1 the way back."""

    def moved(x: FloatArray, log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
        return x + sign * amount(log, theta), state

    return moved


def times(factor: Amount) -> ArrayTransform:
    """``x · factor``."""

    def grown(x: FloatArray, log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
        return x * factor(log, theta), state

    return grown


def over(factor: Amount) -> ArrayTransform:
    """``x / factor``."""

    def shrunk(x: FloatArray, log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
        return x / factor(log, theta), state

    return shrunk


def on_readings(transform: ArrayTransform) -> Transform:
    """Lift ``(readings (n, c), log, theta, state)`` to whole logs."""

    def lifted(log: Log, theta: Theta, state: State) -> tuple[Log, State]:
        readings, state = transform(log.readings, log, theta, state)
        return log.with_readings(readings), state

    return lifted


def on_known(name: str, transform: ArrayTransform) -> Transform:
    """Lift a transform of one known quantity to whole logs; logs without it pass unchanged."""

    def lifted(log: Log, theta: Theta, state: State) -> tuple[Log, State]:
        if name not in log.known:
            return log, state
        array, state = transform(log.known[name], log, theta, state)
        return log.with_known(**{name: array}), state

    return lifted


def on_wrenches(transform: ArrayTransform) -> Transform:
    """Lift ``(wrenches (n, legs, 6), log, theta, state)`` to whole logs; cells pass unchanged."""

    def lifted(log: Log, theta: Theta, state: State) -> tuple[Log, State]:
        if not is_six_axis(log.channels):
            return log, state
        wrenches = log.readings.reshape(len(log), -1, 6)
        wrenches, state = transform(wrenches, log, theta, state)
        return log.with_readings(wrenches.reshape(log.readings.shape)), state

    return lifted


def unit_of(unit: str, channels: Sequence[str]) -> str:
    """A unit of cells as it is at axes: of those of a torque newtons are newton metres."""
    axes = is_six_axis(channels) and all(c.rsplit(".", 1)[1].startswith("t") for c in channels)
    return unit.replace("N", "Nm") if axes else unit


def can_carry(channels: Sequence[str], effect: Effect) -> bool:
    """Whether sensors of this kind, six-axis transducers or cells, can have an effect."""
    if is_six_axis(channels):
        of_robot = effect.stage in (Stage.BODY, Stage.TRANSPORT)
        return of_robot or bool({"hang", "pose"} & set(effect.experiments))
    return effect.scope is not Scope.LEG
