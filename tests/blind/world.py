"""A hidden experiment: what the sensors truly carry, what they show, and what the log believes.

Nothing here knows footcal. Truth and belief start equal; an injected effect changes either what
the channels show (`shown`) or what the log believes (`row`, `body`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from tests.blind.noise import Spread

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Rng = np.random.Generator

GRAVITY_MPS2 = 9.80665
SCALE_STEP, BIAS_STEP_N = 0.01, 0.1
"""How far a calibration is moved to see what it does."""


@dataclass(frozen=True)
class World:
    """One drawn experiment on n rows and c channels.

    Parameters
    ----------
    experiment
        ``weights placements stand walk hang pose``.
    channels
        Cells (``left_fl``) or axes (``fl.fx``).
    time_s, block
        Stamps and unit of evidence, shape (n,).
    shown, noise
        What channels show without noise, and their noise, N (Nm), shape (n, c).
    row
        What the log says beside each reading, first axis n.
    body, body_noise
        What the robot's own stream says on `body_time_s`, and its noise, first axis m.
    scale, zero
        Counts of a cell: ``counts = zero + force / scale``, shape (c,).
    quantum_n
        Step of the converter, N.
    drift
        Wandering of scales and biases, N, shape (n, c); not counted as noise where sizes are set.
    drift_per_root_s
        Random walk of each channel's scale (share) and bias (N) per √s, from which `drift` comes.
    robot
        The recipe's ``[robot]`` table.
    facts
        What was drawn, for the ledger.
    spread
        The law that `noise` was drawn by.
    body_sd
        Sd of `body_noise` by stream, autoregressive on `body_time_s`.
    play_m
        Sd of a weight's place in a hole.
    """

    experiment: str
    channels: tuple[str, ...]
    time_s: Array
    block: Ints
    shown: Array
    noise: Array
    row: Mapping[str, Array]
    robot: Mapping[str, Any]
    scale: Array
    zero: Array
    quantum_n: float = 0.0
    drift: Array | None = None
    drift_per_root_s: tuple[float, float] = (0.0, 0.0)
    body_time_s: Array = field(default_factory=lambda: np.zeros(0))
    body: Mapping[str, Array] = field(default_factory=dict)
    body_noise: Mapping[str, Array] = field(default_factory=dict)
    facts: Mapping[str, Any] = field(default_factory=dict)
    spread: Spread | None = None
    body_sd: Mapping[str, float] = field(default_factory=dict)
    play_m: float = 0.0

    @property
    def fresh(self) -> NDArray[np.bool_]:
        """First row of every block: memories start rested, shape (n,)."""
        return np.asarray(np.diff(self.block, prepend=self.block[:1] - 1) != 0)

    @property
    def span_n(self) -> float:
        """The load that shapes of effects are shares of, N."""
        return float(self.facts.get("span_n", np.percentile(np.abs(self.shown), 99))) or 1.0

    def noisy(self) -> World:
        """The same experiment as the logger saw it, before conversion to counts."""
        body = {k: v + self.body_noise.get(k, 0.0) for k, v in self.body.items()}
        return replace(self, shown=self.shown + self.noise, body=body)

    def with_shown(self, shown: Array) -> World:
        """The same experiment with channels that show something else."""
        return replace(self, shown=shown)

    def with_row(self, **changed: Array) -> World:
        """The same experiment with another belief beside the readings."""
        return replace(self, row={**self.row, **changed})

    def with_body(self, **changed: Array) -> World:
        """The same experiment with another belief about the body."""
        return replace(self, body={**self.body, **changed})

    def counts(self) -> Array:
        """Raw counts as the converter writes them, shape (n, c)."""
        force = self.shown + self.noise + (0.0 if self.drift is None else self.drift)
        if self.quantum_n > 0:
            force = np.round(force / self.quantum_n) * self.quantum_n
        return np.asarray(np.round(self.zero + force / self.scale))


@dataclass(frozen=True)
class Maker:
    """How one kind of experiment is drawn, judged and written.

    Parameters
    ----------
    draw
        ``(rng, options) -> World``; options: ``drift`` (walks), ``blocks``.
    error
        Measured − demanded by the generator's own physics, shape (n, k); NaN where nothing is
        demanded.
    calibrations
        The world with each calibration parameter moved a little, one by one.
    write
        Logs and recipe into a folder; returns the names of the logs to diagnose.
    """

    draw: Callable[[Rng, Mapping[str, Any]], World]
    error: Callable[[World], Array]
    calibrations: Callable[[World], Iterator[World]]
    write: Callable[[World, Path, Rng], None]


def affine_calibrations(world: World) -> Iterator[World]:
    """Scale, then bias of every channel moved a little."""
    for i in range(len(world.channels)):
        for factor, shift in ((1.0 + SCALE_STEP, 0.0), (1.0, BIAS_STEP_N)):
            shown = world.shown.copy()
            shown[:, i] = factor * shown[:, i] + shift
            yield world.with_shown(shown)


def draw_cells(rng: Rng, channels: int) -> tuple[Array, Array]:
    """Scales (N/count) of one sign and zeros (counts) of 24-bit cells, as bridges have them."""
    sign = -1.0 if rng.random() < 0.5 else 1.0
    scale = sign * rng.uniform(2e-6, 9e-6) * rng.uniform(0.85, 1.15, channels)
    zero = np.round(rng.uniform(-4e5, 4e5, channels) + 8.3e6 * (sign < 0))
    return scale, zero
