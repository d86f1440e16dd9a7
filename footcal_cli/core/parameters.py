"""Parameters: what a calibration may move, and what is known of it before and after.

A parameter is named ``<channel, leg or robot>.<parameter>`` (``left_fl.bias``), carries its unit,
and holds either what is believed beforehand (`Parameter`) or what a fit made of it (`Estimates`).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]
ComplexArray = NDArray[np.complexfloating]


class Status(StrEnum):
    """What a fit did with a parameter."""

    ESTIMATED = "estimated"
    PRIOR_KEPT = "prior kept: not observable"
    FIXED = "fixed"
    AT_BOUND = "at bound"


@dataclass(frozen=True, slots=True)
class Parameter:
    """One number of the model before a fit.

    Parameters
    ----------
    name
        ``<owner>.<parameter>``.
    unit
        Unit of `value`, `sd` and the bounds.
    value
        Prior mean and start of the fit.
    sd
        Prior standard deviation; ``inf`` where nothing is known.
    lower, upper
        Physically allowed range.
    free
        False: the fit keeps `value`.
    scale
        A typical size of a change, for conditioning; the prior sd is used where it is finite.
    """

    name: str
    unit: str
    value: float
    sd: float = np.inf
    lower: float = -np.inf
    upper: float = np.inf
    free: bool = True
    scale: float = 1.0

    def __post_init__(self) -> None:
        if not self.lower <= self.value <= self.upper:
            raise ValueError(
                f"{self.name}: value {self.value} {self.unit} lies outside "
                f"[{self.lower}, {self.upper}]"
            )
        if not self.sd > 0 or not self.scale > 0:
            raise ValueError(f"{self.name}: sd and scale must be positive")

    @property
    def step(self) -> float:
        """The natural size of a change: the prior sd where known, else `scale`."""
        return self.sd if np.isfinite(self.sd) else self.scale


@dataclass(frozen=True)
class ParameterSet:
    """An ordered set of parameters with unique names, and their joint prior.

    Parameters
    ----------
    parameters
        Each with its own prior.
    correlation
        Of the priors, shape (n, n); None where they are independent.
    """

    parameters: tuple[Parameter, ...]
    correlation: FloatArray | None = field(default=None, compare=False)
    _index: Mapping[str, int] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        index = {parameter.name: i for i, parameter in enumerate(self.parameters)}
        if len(index) != len(self.parameters):
            names = [parameter.name for parameter in self.parameters]
            twice = sorted({name for name in names if names.count(name) > 1})
            raise ValueError(f"parameter named twice: {', '.join(twice)}")
        if self.correlation is not None and self.correlation.shape != (len(index),) * 2:
            raise ValueError(f"{len(index)} parameters, correlation {self.correlation.shape}")
        object.__setattr__(self, "_index", index)

    def __iter__(self) -> Iterator[Parameter]:
        return iter(self.parameters)

    def __len__(self) -> int:
        return len(self.parameters)

    def __getitem__(self, name: str) -> Parameter:
        return self.parameters[self._index[name]]

    def __contains__(self, name: object) -> bool:
        return name in self._index

    @property
    def names(self) -> tuple[str, ...]:
        """Names in order."""
        return tuple(self._index)

    @property
    def values(self) -> FloatArray:
        """Prior means, shape (n,)."""
        return np.array([parameter.value for parameter in self.parameters])

    @property
    def free(self) -> BoolArray:
        """Which parameters a fit may move, shape (n,)."""
        return np.array([parameter.free for parameter in self.parameters], dtype=bool)

    def __add__(self, other: Iterable[Parameter]) -> ParameterSet:
        more = tuple(other)
        if self.correlation is None:
            return ParameterSet((*self.parameters, *more))
        size = len(self)
        correlation = np.eye(size + len(more))
        correlation[:size, :size] = self.correlation
        return ParameterSet((*self.parameters, *more), correlation)


LEARNT_RATIO = 0.5


def learnt_status(sd: FloatArray, prior_sd: FloatArray) -> tuple[Status, ...]:
    """Estimated is what the data taught: where they at least halved the prior sd, shape (p,)."""
    return tuple(
        Status.ESTIMATED if learnt else Status.PRIOR_KEPT for learnt in sd < LEARNT_RATIO * prior_sd
    )


@dataclass(frozen=True)
class Estimates:
    """Parameters after a fit, with their joint covariance.

    Parameters
    ----------
    names, units, status
        One entry per parameter.
    values
        Estimates, shape (n,), each in its unit.
    covariance
        Shape (n, n), in products of the units; zero rows for fixed parameters.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    values: FloatArray
    covariance: FloatArray
    status: tuple[Status, ...]

    @property
    def sd(self) -> FloatArray:
        """Standard deviations, shape (n,)."""
        return np.sqrt(np.clip(np.diag(self.covariance), 0.0, None))

    def __getitem__(self, name: str) -> float:
        return float(self.values[self.names.index(name)])

    def sd_of(self, name: str) -> float:
        """Standard deviation of one parameter."""
        return float(self.sd[self.names.index(name)])

    def summary(self) -> str:
        """One line per parameter: name, value ± sd, unit, status."""
        width = max((len(name) for name in self.names), default=0)
        return "\n".join(
            f"{name:<{width}}  {value:.6g} ± {sd:.2g} {unit}  ({status.value})"
            for name, value, sd, unit, status in zip(
                self.names, self.values, self.sd, self.units, self.status, strict=True
            )
        )
