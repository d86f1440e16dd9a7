"""A recording in canonical arrays: the one thing that effects distort and experiments judge."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Literal, TypeVar, cast, get_args

import numpy as np

from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray

T = TypeVar("T")
ExperimentName = Literal["weights", "placements", "stand", "walk", "hang", "pose"]
EXPERIMENT_NAMES: tuple[ExperimentName, ...] = get_args(ExperimentName)


class _Read(Mapping[str, FloatArray]):
    """Known quantities, with a list of those that were asked for; None: not there."""

    def __init__(self, known: Mapping[str, FloatArray]) -> None:
        self.known = known
        self.seen: dict[str, FloatArray | None] = {}

    def __getitem__(self, name: str) -> FloatArray:
        self.seen[name] = self.known.get(name)
        return self.known[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.known)

    def __len__(self) -> int:
        return len(self.known)


def _name_of(made: Callable[[Log], object]) -> str:
    return f"{made.__module__}.{made.__qualname__}"


@dataclass(frozen=True)
class Log:
    """What the sensors showed, and what is known beside it, row by row on one clock.

    Parameters
    ----------
    experiment
        ``weights placements stand walk hang pose``.
    channels
        Names of the columns of `readings`: cells (``left_fl``) or axes (``fl.fx``).
    time_s
        Stamps, shape (n,), increasing within a block.
    readings
        Shape (n, c): raw counts as logged, newtons (newton metres) once the calibration is removed.
    known
        Everything else by name, first axis n: ``load_n`` (n, c), ``com_m`` (n, 3),
        ``temperature_degc`` (n,) ... `footcal_cli.core.experiments` lists what each experiment has.
    block
        Shape (n,): session, gait cycle, placement or pose; the unit of evidence.
    """

    experiment: str
    channels: tuple[str, ...]
    time_s: FloatArray
    readings: FloatArray
    known: Mapping[str, FloatArray]
    block: IntArray
    _of_known: dict[str, tuple[object, Mapping[str, FloatArray | None]]] = field(
        default_factory=dict, init=False, repr=False, compare=False
    )
    _of_time: dict[str, object] = field(default_factory=dict, init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        rows = self.time_s.shape[0]
        if self.readings.shape != (rows, len(self.channels)):
            raise ValueError(
                f"readings have shape {self.readings.shape}, expected {(rows, len(self.channels))}"
            )
        for name, array in {"block": self.block, **self.known}.items():
            if array.shape[:1] != (rows,):
                raise ValueError(f"{name} has {array.shape[:1]} rows, expected {rows}")

    def __len__(self) -> int:
        return int(self.time_s.size)

    def with_readings(self, readings: FloatArray) -> Log:
        """The same recording with other readings."""
        if readings.shape != self.readings.shape:
            return replace(self, readings=readings)
        # thousands of trial models differ in their readings only: nothing else is looked at again
        return self._but(readings=readings)

    def _but(self, **changes: object) -> Log:
        """The same recording with changes that nobody has to look at."""
        other = object.__new__(type(self))
        other.__dict__.update(self.__dict__, **changes)
        return other

    def of_known(self, made: Callable[[Log], T]) -> T:
        """What follows from everything but the readings: made anew where what it read is another.

        Parameters
        ----------
        made
            A function of the module that asks; it must not look at the readings.
        """
        name = _name_of(made)
        found = self._of_known.get(name)
        if found is None or any(self.known.get(key) is not was for key, was in found[1].items()):
            read = _Read(self.known)
            found = made(self._but(known=read)), read.seen
            self._of_known[name] = found
        return cast(T, found[0])

    def of_time(self, made: Callable[[Log], T]) -> T:
        """What follows from the stamps and blocks alone: made once, for any channels."""
        name = _name_of(made)
        if name not in self._of_time:
            self._of_time[name] = made(self)
        return cast(T, self._of_time[name])

    def with_known(self, **changes: FloatArray) -> Log:
        """The same recording with some of the known quantities replaced."""
        other = replace(self, known={**self.known, **changes})
        return other._but(_of_known=self._of_known, _of_time=self._of_time)

    def of_channels(self, columns: IntArray) -> Log:
        """Some channels, without what is known beside them."""
        other = replace(
            self,
            channels=tuple(self.channels[c] for c in columns),
            readings=np.ascontiguousarray(self.readings[:, columns]),
            known={},
        )
        return other._but(_of_time=self._of_time)

    def at(self, rows: BoolArray | IntArray | slice) -> Log:
        """The chosen rows."""
        return replace(
            self,
            time_s=self.time_s[rows],
            readings=self.readings[rows],
            known={name: array[rows] for name, array in self.known.items()},
            block=self.block[rows],
        )

    def rows(self, start: int, stop: int) -> Log:
        """Rows ``start:stop``, for chunk-wise work."""
        return self.at(slice(start, stop))
