"""A recording in canonical arrays: the one thing that effects distort and experiments judge."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TypeVar, cast

from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray

T = TypeVar("T")


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
    _of_known: dict[str, object] = field(
        default_factory=dict, init=False, repr=False, compare=False
    )

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
        other = object.__new__(type(self))
        other.__dict__.update(self.__dict__, readings=readings)
        return other

    def of_known(self, made: Callable[[Log], T]) -> T:
        """What follows from everything but the readings: made once for all `with_readings`.

        Parameters
        ----------
        made
            A function of the module that asks; it must not look at the readings.
        """
        name = f"{made.__module__}.{made.__qualname__}"
        if name not in self._of_known:
            self._of_known[name] = made(self)
        return cast(T, self._of_known[name])

    def with_known(self, **changes: FloatArray) -> Log:
        """The same recording with some of the known quantities replaced."""
        return replace(self, known={**self.known, **changes})

    def at(self, rows: BoolArray | IntArray) -> Log:
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
        part = slice(start, stop)
        return replace(
            self,
            time_s=self.time_s[part],
            readings=self.readings[part],
            known={name: array[part] for name, array in self.known.items()},
            block=self.block[part],
        )
