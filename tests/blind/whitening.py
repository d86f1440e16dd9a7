"""The covariance of a world's errors as its generator draws them, and errors made white by it.

Cells, axes, the body's own stream and the play of a pin are inputs, each with its own law; an
input's noise reaches the errors by the derivative of the generator's own physics. Blocks of a
generator are independent of each other, so that the covariance is taken block by block. Streams are
averaged over a few rows first: what effects leave in them is slow (half the length changes no
distance by more than 3 %).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from tests.blind.noise import BODY_DECAY
from tests.blind.world import Array, Ints, World
from tests.blind.yardstick import Yardstick

BIN_S = {"walk": 0.04, "stand": 0.12}
"""Streams are averaged over so long."""
MOVED = 1e-3
"""Step of the body's stream for derivatives, m, m/s², Nm."""
_BODY_COLUMNS = (("com_m", 3), ("com_acc_mps2", 3), ("angmom_rate_nm", 2))


@dataclass(frozen=True)
class Inputs:
    """What sensors carry and how it reaches the errors.

    Parameters
    ----------
    load
        N (Nm), without offsets, shape (n, i).
    reach
        Change of the errors per unit of each input, shape (i, n, k).
    channel
        Channel of each input; two cells weighed one after the other, or the same axis of two
        legs, share one, shape (i,).
    owner
        Leg of each input, or foot, shape (i,).
    """

    load: Array
    reach: Array
    channel: Ints
    owner: Ints


def inputs_of(world: World, stick: Yardstick) -> Inputs:
    """Cells or axes of a clean world."""
    reach, load = [], np.array(world.shown)
    for i in range(world.shown.shape[1]):
        shown = world.shown.copy()
        shown[:, i] += 1.0
        reach.append(np.nan_to_num(stick.maker.error(world.with_shown(shown)) - stick.clean_error))
    if world.experiment == "hang":
        load = -np.asarray(stick.maker.error(world.with_shown(np.zeros_like(world.shown))))
    if world.experiment == "pose":
        load = load - np.array(world.facts["legs"]["offset"]).ravel()
    whole = Inputs(load, np.array(reach), np.arange(load.shape[1]), _owners(world))
    turns = world.row.get("cell", world.row.get("leg"))
    return whole if turns is None else _apart(whole, turns)


def _owners(world: World) -> Ints:
    """Foot or leg of each channel."""
    if world.experiment in ("hang", "weights"):
        return np.zeros(world.shown.shape[1], dtype=np.int64)
    names = [channel.replace(".", "_").split("_")[0] for channel in world.channels]
    return np.array([sorted(set(names)).index(name) for name in names])


def _apart(whole: Inputs, turns: Array) -> Inputs:
    """What took turns at the same channels, each as inputs of its own."""
    parts = [(number, turns == number) for number in np.unique(turns)]
    return Inputs(
        np.concatenate([np.where(on[:, None], whole.load, 0.0) for _, on in parts], axis=1),
        np.concatenate([np.where(on[:, None], whole.reach, 0.0) for _, on in parts]),
        np.concatenate([whole.channel for _ in parts]),
        np.concatenate([np.full(whole.channel.size, int(number)) for number, _ in parts]),
    )


@dataclass(frozen=True)
class Block:
    """Rows whose noise is independent of all others.

    Parameters
    ----------
    entries
        Their valid errors among all entries.
    root
        Lower Cholesky factor of the entries' covariance.
    """

    entries: slice
    root: Array


@dataclass(frozen=True)
class Whitening:
    """Averages of valid errors (entries), and the law of their noise."""

    world: World
    stick: Yardstick
    inputs: Inputs

    @cached_property
    def _stretches(self) -> list[slice]:
        """Rows of each independent block."""
        assert self.world.spread is not None
        block = self.world.spread.block
        edges = np.flatnonzero(np.diff(block, prepend=block[0] - 1))
        return [slice(a, b) for a, b in zip(edges, [*edges[1:], block.size], strict=True)]

    @cached_property
    def _starts(self) -> Ints:
        """First row of every average."""
        step = float(np.median(np.diff(self.world.time_s)))
        long = max(round(BIN_S.get(self.world.experiment, 0.0) / step), 1) if step > 0 else 1
        return np.concatenate([np.arange(s.start, s.stop, long) for s in self._stretches])

    def averaged(self, rows: Array) -> Array:
        """Means of rows (n, ...) over each stretch that is averaged."""
        count = np.diff(self._starts, append=len(rows))
        total = np.add.reduceat(rows, self._starts, axis=0)
        return np.asarray(total / count.reshape(-1, *[1] * (rows.ndim - 1)))

    @cached_property
    def _kept(self) -> NDArray[np.bool_]:
        """Averages of valid errors only, shape (b, k)."""
        return np.asarray(np.logical_and.reduceat(self.stick.valid, self._starts, axis=0))

    def entries(self, change: Array) -> Array:
        """Valid averages of a change of the errors (n, k), flattened."""
        return self.averaged(np.nan_to_num(change))[self._kept]

    @cached_property
    def time_s(self) -> Array:
        """Stamp of each entry."""
        return self.averaged(self.world.time_s)[np.nonzero(self._kept)[0]]

    def blocks(self) -> Iterator[Block]:
        """Every block with the root of its covariance."""
        reach = [self.averaged(item) for item in self._reaches()]
        place, output = np.nonzero(self._kept)
        for rows in self._stretches:
            first, last = np.searchsorted(self._starts, [rows.start, rows.stop])
            part = slice(*np.searchsorted(place, [first, last]))
            at, out = place[part], output[part]
            if not at.size:
                continue
            total = np.zeros((at.size, at.size))
            starts = self._starts[first:last]
            for item, law in zip(reach, self._laws(rows), strict=True):
                gain = item[at, out]
                if law is not None and gain.any():
                    between = _averaged_twice(law, starts - rows.start)[at - first][:, at - first]
                    total += np.outer(gain, gain) * between
            total[np.diag_indices(at.size)] *= 1.0 + 1e-9
            yield Block(part, np.asarray(np.linalg.cholesky(total)))

    def _reaches(self) -> list[Array]:
        """Change of the errors per unit of each noisy input, each of shape (n, k)."""
        found = list(self.inputs.reach)
        for name, columns in _BODY_COLUMNS if self.world.body_sd else ():
            for column in range(columns):
                stream = self.world.body[name].copy()
                stream[:, column] += MOVED
                moved = self.stick.maker.error(self.world.with_body(**{name: stream}))
                found.append(np.nan_to_num(moved - self.stick.clean_error) / MOVED)
        if self.world.play_m:
            for axis in (1, 2):
                found.append(self.world.row["load_n"][:, None] * (np.arange(3) == axis))
        return found

    def _laws(self, rows: slice) -> Iterator[Array | None]:
        """Covariance of each noisy input over the rows of a block; None where it has none."""
        world, spread = self.world, self.world.spread
        assert spread is not None
        size = rows.stop - rows.start
        known: dict[int, Array] = {}
        for i, channel in enumerate(self.inputs.channel):
            if not self.inputs.reach[i, rows].any():
                yield None
                continue
            if channel not in known:
                step = world.quantum_n * spread.sd[channel] / spread.sd[0]
                rounding = step**2 / 12.0 * np.eye(size)
                known[channel] = spread.covariance(rows, int(channel)) + rounding
            yield known[channel]
        if world.body_sd:
            law = self._body_law(rows)
            for name, columns in _BODY_COLUMNS:
                for _ in range(columns):
                    yield world.body_sd[name] ** 2 * law
        if world.play_m:
            for _ in range(2):
                yield world.play_m**2 * np.eye(size)

    def _body_law(self, rows: slice) -> Array:
        """Correlation of the body's stream, interpolated to the rows of a block."""
        now, then = self.world.time_s[rows], self.world.body_time_s
        first, last = np.searchsorted(then, [now[0], now[-1]])
        then = then[max(first - 1, 0) : last + 1]
        weight = np.stack([np.interp(now, then, unit) for unit in np.eye(then.size)], axis=1)
        apart = np.abs(np.subtract.outer(np.arange(then.size), np.arange(then.size)))
        return np.asarray(weight @ BODY_DECAY**apart @ weight.T)


def _averaged_twice(law: Array, starts: Ints) -> Array:
    """Covariance of averages that begin at `starts`."""
    if starts.size == len(law):
        return law
    count = np.diff(starts, append=len(law))
    total = np.add.reduceat(np.add.reduceat(law, starts, axis=0), starts, axis=1)
    return np.asarray(total / np.outer(count, count))


def whitened(block: Block, columns: Array) -> Array:
    """Columns over the entries of a block, white, shape (e, p)."""
    return np.asarray(solve_triangular(block.root, columns, lower=True, check_finite=False))
