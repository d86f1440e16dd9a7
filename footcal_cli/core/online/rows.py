"""The linear rows that every online estimator works on.

With the calibration believed so far, a cell shows ``F⁰ = c⁰ S + d⁰``. What may be wrong with it is
a relative gain γ and a bias β: ``F = (1 + γ) F⁰ + β``, hence ``c = c⁰ (1 + γ)`` and
``d = d⁰ (1 + γ) + β``. In these centred units every balance of
`footcal_cli.core.experiments.walk` is linear in the unknowns z (gains, biases, and what is wrong
with the reference): ``error(z) = error(0) + H z``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.centroidal import Reference
from footcal_cli.core.effects.body import heading_rad
from footcal_cli.core.effects.contract import Scope, columns_of
from footcal_cli.core.experiments import walk
from footcal_cli.core.log import Log
from footcal_cli.core.online.belief import Belief
from footcal_cli.core.online.plates import UNITS, per_plate, plate_priors
from footcal_cli.core.online.reference_states import (
    REFERENCE_STATES,
    reference_slopes,
    state_column,
)
from footcal_cli.core.online.soles import Soles
from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray
from footcal_cli.core.spatial import in_heading
from footcal_cli.errors import DataError

_CHUNK_ROWS = 4096


@dataclass(frozen=True)
class Rows:
    """Linear rows, one block per update.

    Parameters
    ----------
    time_s
        Stamp of the last sample of each block, shape (u,).
    names, units
        The unknowns z.
    prior_sd
        Shape (p,); the columns of `h` are in these units.
    prior_correlation
        Shape (p, p).
    outputs
        Names of the rows; the first `totals` are of the whole robot, the others of channels.
    h
        Shape (u, k, p): change of the error per prior sd of each unknown.
    error
        Error with z = 0, shape (u, k).
    valid
        Shape (u, k).
    last_sample
        Row of the log that ends each block, shape (u,).
    swing_sd_factor
        Noise of each channel's row against the first kind's, shape (k − totals,).
    total_sd_factor
        Noise of each total against that of its kind (force, moment), shape (totals,) or 1.
    soles
        Errors of where they stand; None where feet stand where they are said to.
    per_stamp_s
        Change of the totals' error per second that the body's stamps are wrong, (u, totals): where
        the body moves fast, jitter of its stamps is noise. None where stamps are exact.
    own
        The unknown that each channel's noise adds to all rows like, its bias, shape (k − totals,);
        None where a channel's noise is negligible in the totals.
    """

    time_s: FloatArray
    names: tuple[str, ...]
    units: tuple[str, ...]
    prior_sd: FloatArray
    prior_correlation: FloatArray
    outputs: tuple[str, ...]
    totals: int
    h: FloatArray
    error: FloatArray
    valid: BoolArray
    last_sample: IntArray
    swing_sd_factor: FloatArray
    per_stamp_s: FloatArray | None = None
    own: IntArray | None = None
    total_sd_factor: FloatArray | float = 1.0
    soles: Soles | None = None

    def __len__(self) -> int:
        return self.time_s.size

    def refuse_if_empty(self) -> None:
        """Refuse a walk in which no total was ever known.

        Raises
        ------
        DataError
            At no time were all channels, the motion and the feet known.
        """
        if not self.valid[:, : self.totals].any():
            raise DataError(
                "at no time of the walk are all readings, the body's motion and its feet known",
                remedy="run check on both logs: every column must hold numbers, and their stamps "
                "must be of the same clock and in s",
            )

    def without(self, unknowns: BoolArray) -> Rows:
        """The same rows with some unknowns, shape (p,), taken to be zero."""
        kept = ~unknowns
        return replace(
            self,
            names=tuple(n for n, keep in zip(self.names, kept, strict=True) if keep),
            units=tuple(u for u, keep in zip(self.units, kept, strict=True) if keep),
            prior_sd=self.prior_sd[kept],
            prior_correlation=self.prior_correlation[np.ix_(kept, kept)],
            h=self.h[:, :, kept],
        )

    def part(self, start: int, stop: int) -> Rows:
        """Blocks ``start:stop``."""
        return self.chosen(slice(start, stop))

    def chosen(self, cut: slice | IntArray) -> Rows:
        """Some blocks, in their order; the states wander through the gaps."""
        return replace(
            self,
            time_s=self.time_s[cut],
            h=self.h[cut],
            error=self.error[cut],
            valid=self.valid[cut],
            last_sample=self.last_sample[cut],
            per_stamp_s=None if self.per_stamp_s is None else self.per_stamp_s[cut],
            soles=None if self.soles is None else self.soles.chosen(cut),
        )


def cell_rows(
    log: Log,
    belief: Belief,
    *,
    samples_per_update: int = 4,
    states: Sequence[str] = tuple(REFERENCE_STATES),
    plate: bool = True,
    swing: bool = True,
    static: bool = False,
    neighbours: bool = False,
    state_sd: Mapping[str, float] | None = None,
) -> Rows:
    """Rows of a walk with load cells, averaged over blocks of samples.

    Parameters
    ----------
    log
        Walk or stand with raw counts, filtered as wanted; rows that must not count are NaN. What
        the filter carried from stances into swings, where `carried_over` is known, is taken off
        cells in the air.
    samples_per_update
        Samples averaged to one block (20 Hz from 80 Hz).
    states
        Names of `REFERENCE_STATES` to estimate along.
    plate
        Whether weight and mass of what hangs below the cells of each foot are unknown.
    swing
        Whether the channels of swinging feet give rows.
    static
        Han's static assumption in place of [NAO], eqs. (9)–(11).
    neighbours
        Whether gains of cells in the air are regressed on what blocks around read: little but noise
        is read there, and it stands in the error, too (`by_neighbours`).
    state_sd
        Prior sd of states where they differ from the defaults; the key is the name or, for all
        feet, ``plate_weight`` or ``plate_mass``.
    """
    sd = {name: spec[1] for name, spec in REFERENCE_STATES.items()} | dict(state_sd or {})
    feet = walk.feet_of(log) if plate and swing else ()
    c = len(log.channels)
    plates = plate_priors(log, feet, sd)
    names, units, prior_sd, correlation = _unknowns(log.channels, belief, states, plates, sd)
    reference = walk.reference_of(log, static=static)
    slopes = reference_slopes(log, reference, belief, states, sd, static=static)
    below = per_plate(log, tuple(plates))
    near = by_neighbours(log.readings, samples_per_update) if neighbours else log.readings
    blocks = updates_of(log, samples_per_update)
    chunk = max(_CHUNK_ROWS // samples_per_update, 1) * samples_per_update
    parts = []
    for start in range(0, blocks * samples_per_update, chunk):
        stop = min(start + chunk, blocks * samples_per_update)
        part = slice(start, stop)
        error, valid, h = _sample_rows(
            log.rows(start, stop).with_readings(belief.forces(log.readings[part])),
            belief.forces(near[part]),
            Reference(reference.fz_n[part], reference.cop_m[part]),
            {name: slope[part] for name, slope in slopes.items()},
            states,
            below[part],
        )
        if "carried_over" in log.known:
            own = belief.scale_n_per_count * log.known["carried_over"][part]
            error[:, len(walk.CELL_TOTALS) :] -= own
        if not swing:
            valid[:, len(walk.CELL_TOTALS) :] = False
        h[:, :, :-1] *= prior_sd
        parts.append(block_means(error, valid, h, samples_per_update))
    last = np.arange(1, blocks + 1) * samples_per_update - 1
    loaded = log.with_readings(belief.forces(log.readings))
    return Rows(
        time_s=log.time_s[last],
        names=names,
        units=units,
        prior_sd=prior_sd,
        prior_correlation=correlation,
        outputs=(*walk.CELL_TOTALS, *log.channels),
        totals=len(walk.CELL_TOTALS),
        h=np.concatenate([p[0][:, :, :-1] for p in parts]),
        error=np.concatenate([p[1] for p in parts]),
        valid=np.concatenate([p[2] for p in parts]),
        last_sample=last,
        swing_sd_factor=np.ones(c),
        per_stamp_s=np.concatenate([p[0][:, : len(walk.CELL_TOTALS), -1] for p in parts]),
        own=np.arange(c, 2 * c),
        soles=Soles.of(loaded, samples_per_update) if swing else None,
    )


def _unknowns(
    channels: Sequence[str],
    belief: Belief,
    states: Sequence[str],
    plates: Mapping[str, float],
    sd: Mapping[str, float],
) -> tuple[tuple[str, ...], tuple[str, ...], FloatArray, FloatArray]:
    """Names, units, prior sd (p,) and prior correlation (p, p) of the unknowns z."""
    c = len(channels)
    names = (
        *(f"{name}.gain" for name in channels),
        *(f"{name}.bias" for name in channels),
        *states,
        *plates,
    )
    units = ("-",) * c + ("N",) * c + tuple(REFERENCE_STATES[s][0] for s in states)
    units += tuple(UNITS[name.rsplit(".", 1)[-1]] for name in plates)
    prior_sd = np.concatenate(
        [belief.gain_sd, belief.bias_sd_n, [sd[name] for name in states], [*plates.values()]]
    )
    correlation = np.eye(len(names))
    own = prior_sd[: 2 * c]
    correlation[: 2 * c, : 2 * c] = belief.covariance / np.outer(own, own)
    return names, units, prior_sd, correlation


def _sample_rows(
    log: Log,
    unloaded: FloatArray,
    reference: Reference,
    slopes: Mapping[str, FloatArray],
    states: Sequence[str],
    below: FloatArray,
) -> tuple[FloatArray, BoolArray, FloatArray]:
    """Error (n, k), valid (n, k) and ``∂error/∂(z, delay)`` (n, k, p + 1) of a log in newtons.

    `unloaded` are what gains of cells in the air are regressed on, N, (n, c); `below` newtons per
    unit of what hangs below each foot (`per_plate`), (n, plates).
    """
    balance = walk.cell_balance(log, reference)
    n, c = log.readings.shape
    totals = len(walk.CELL_TOTALS)
    h = np.zeros((n, totals + c, 2 * c + len(states) + below.shape[1] + 1))
    h[:, :totals, -1] = state_column("robot.delay", log, slopes, heading_rad(log))
    arms = log.known["cell_pos_m"] - reference.cop_m[:, None]
    per_force = np.stack([np.ones((n, c)), arms[:, :, 1], -arms[:, :, 0]], axis=1)
    h[:, :totals, :c] = per_force * log.readings[:, None]
    h[:, :totals, c : 2 * c] = per_force
    cells = np.arange(c)
    h[:, totals + cells, cells] = unloaded
    h[:, totals + cells, c + cells] = 1.0
    yaw = heading_rad(log)
    for i, name in enumerate(states):
        h[:, :totals, 2 * c + i] = state_column(name, log, slopes, yaw)
    feet = columns_of(Scope.FOOT, log.channels)
    for i, lacking in enumerate(below.T):
        columns, hung = feet[i % len(feet)], 2 * c + len(states) + i
        h[:, totals + columns, hung] = lacking[:, None] / len(columns)
        h[:, :totals, hung] = per_force[:, :, columns].mean(axis=2) * lacking[:, None]
    finite = np.asarray(np.isfinite(h).all(axis=2))
    error, valid = balance.error, balance.valid & finite
    return in_heading(error, valid, np.where(finite[..., None], h, 0.0), ((1, 2),), yaw)


def by_neighbours(readings: FloatArray, size: int) -> FloatArray:
    """Readings as the blocks of `size` samples before and after have them, shape (n, c).

    The regressor of a scale. A block's own reading would not do: its noise stands in the error as
    well, and a scale regressed on it is pulled towards −1 by noise over reading, squared. That of
    its neighbours is another noise (instrumental variables).
    """
    at = np.arange(len(readings))
    before, after = readings[np.maximum(at - size, 0)], readings[np.minimum(at + size, at[-1])]
    before, after = (
        np.where((at < size)[:, None], after, before),
        np.where((at + size > at[-1])[:, None], before, after),
    )
    mean = 0.5 * (before + after)
    return np.where(np.isfinite(mean), mean, readings)


def updates_of(log: Log, samples_per_update: int) -> int:
    """How many updates a log gives; refused where it gives none."""
    updates = len(log) // samples_per_update
    if not updates:
        raise DataError(
            f"{len(log)} samples are too few for one update", remedy="record a longer walk"
        )
    return updates


def block_means(
    error: FloatArray, valid: BoolArray, h: FloatArray, size: int
) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Means over the valid samples of each block; a block counts where at least half do."""
    shape = (-1, size)
    weight = valid.reshape(*shape, valid.shape[1]).astype(float)
    count = weight.sum(axis=1)
    share = weight / np.maximum(count, 1.0)[:, None]
    mean_h = np.einsum("usk,uskp->ukp", share, h.reshape(*shape, *h.shape[1:]))
    mean_error = np.einsum("usk,usk->uk", share, error.reshape(*shape, error.shape[1]))
    return mean_h, mean_error, count >= size / 2
