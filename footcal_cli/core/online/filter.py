"""The estimator that remembers: a Kalman filter over gains, biases and what troubles the reference.

State: z in units of its prior sd (random walks), and one first-order autoregressive error per
total row, because the error of a demanded force or moment is correlated in time. Innovations are
limited (Huber), an update that teaches nothing is left out, a jump of a bias is found by the
generalised likelihood ratio of Willsky and Jones (IEEE TAC 21, 1976).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from types import ModuleType

import numpy as np

from footcal_cli.core.online.compiled import kalman_loops
from footcal_cli.core.online.jumps import Jump, JumpBank
from footcal_cli.core.online.kalman import correct, information, innovate, predict
from footcal_cli.core.online.noise import Guards as Guards
from footcal_cli.core.online.noise import Noise as Noise
from footcal_cli.core.online.rows import Rows
from footcal_cli.core.online.tuned import Tuned, spread
from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray


@dataclass(frozen=True)
class Track:
    """States along a walk.

    Parameters
    ----------
    time_s
        Shape (u,).
    names, units
        Of the unknowns z.
    values, sd
        In `units`, shape (u, p).
    momentary
        What each channel's own slow noise has added, to be given back like its bias, shape (u, c);
        None where the totals do not see it.
    covariance
        Of z in `units` at the end, shape (p, p).
    nis, dof
        Normalised innovation squared and number of rows of each update, shape (u,).
    innovation, innovation_sd
        Of each row, NaN where it did not count, shape (u, k).
    gain_nats
        Information each update brought about z; those below the gate were left out, shape (u,).
    used
        Whether the update changed anything, shape (u,).
    log_likelihood
        Of all innovations.
    jumps
        Bias jumps found.
    history
        What a smoother needs (None if it was not kept).
    """

    time_s: FloatArray
    names: tuple[str, ...]
    units: tuple[str, ...]
    values: FloatArray
    sd: FloatArray
    momentary: FloatArray | None
    covariance: FloatArray
    nis: FloatArray
    dof: FloatArray
    innovation: FloatArray
    innovation_sd: FloatArray
    gain_nats: FloatArray
    used: BoolArray
    log_likelihood: float
    jumps: tuple[Jump, ...]
    history: History | None = None

    def inflated(self, factor: float) -> Track:
        """The same states with all their covariances multiplied; the innovations stay."""
        return replace(self, sd=self.sd * np.sqrt(factor), covariance=self.covariance * factor)


@dataclass(frozen=True)
class History:
    """Filtered moments of the whole state in scaled units, for `smooth`.

    Parameters
    ----------
    mean, covariance
        After each update, shape (u, s) and (u, s, s).
    mean_ahead, covariance_ahead
        Predicted before each update.
    decay
        Diagonal of the transition into each update, shape (u, s).
    scale
        Prior sd of z, shape (p,).
    own
        Which states are the channels' slow noise, shape (c,).
    """

    mean: FloatArray
    covariance: FloatArray
    mean_ahead: FloatArray
    covariance_ahead: FloatArray
    decay: FloatArray
    scale: FloatArray
    own: IntArray


def run_filter(
    rows: Rows,
    noise: Noise,
    guards: Guards | None = None,
    *,
    walk_factor: FloatArray | None = None,
    known_jumps: Sequence[Jump] = (),
    keep_history: bool = False,
    fast: bool = True,
) -> Track:
    """Filter a walk with one setting of the noise.

    Parameters
    ----------
    rows
        From `cell_rows` or `six_axis_rows`.
    noise
        Scalars.
    guards
        Limits; the defaults where None.
    walk_factor
        Multiplies the random walk of each unknown, shape (p,): a cell known to drift more.
    known_jumps
        Onsets at which a bias is opened, found in an earlier pass; no others are looked for.
    keep_history
        Keep what `footcal_cli.core.online.smoother` needs.
    fast
        Use compiled loops where they are at hand; the array code gives the same to rounding.
    """
    guards = guards or Guards()
    tuned = spread(rows, noise, walk_factor)
    u, k = rows.error.shape
    p, s = len(rows.names), tuned.states
    mean, cov = np.zeros(s), np.zeros((s, s))
    cov[:p, :p] = rows.prior_correlation
    cov[p:, p:] = np.diag(tuned.slow[0])
    interval = np.diff(rows.time_s, prepend=rows.time_s[0])
    decay, drive = np.ones((u, s)), np.empty((u, s))
    decay[:, p:] = np.exp(-interval[:, None] / tuned.slow_s[0])
    drive[:, :p] = tuned.walk[0] * interval[:, None]
    drive[:, p:] = tuned.slow[0] * (1.0 - decay[:, p:] ** 2)
    _open_biases(drive, rows, known_jumps)
    bank = None
    if not known_jumps:
        bank = JumpBank.start(
            rows, s, guards.jump_threshold, guards.least_jump_n, guards.jump_memory_s
        )
    found = _Found.empty(u, k, p, tuned.seen.size, s if keep_history else 0)
    loops = kalman_loops() if fast else None
    if loops is None:
        _by_arrays(rows, tuned, guards, mean, cov, decay, drive, bank, found)
    else:
        _by_loops(loops, rows, tuned, guards, mean, cov, decay, drive, bank, found)
    history = None
    if keep_history:
        history = History(
            found.past_mean, found.past_cov, found.ahead_mean, found.ahead_cov, decay,
            rows.prior_sd, tuned.seen,
        )  # fmt: skip
    return Track(
        time_s=rows.time_s,
        names=rows.names,
        units=rows.units,
        values=found.values * rows.prior_sd,
        sd=np.sqrt(np.clip(found.variances, 0.0, None)) * rows.prior_sd,
        momentary=found.momentary if tuned.seen.size else None,
        covariance=cov[:p, :p] * np.outer(rows.prior_sd, rows.prior_sd),
        nis=found.nis,
        dof=rows.valid.sum(axis=1).astype(float),
        innovation=found.innovation,
        innovation_sd=np.sqrt(found.innovation_var),
        gain_nats=found.gain_nats,
        used=found.used,
        log_likelihood=float(found.log_likelihood),
        jumps=() if bank is None else tuple(bank.found),
        history=history,
    )


@dataclass
class _Found:
    """What a filter fills while it runs, in units of the prior sd."""

    values: FloatArray
    variances: FloatArray
    momentary: FloatArray
    nis: FloatArray
    gain_nats: FloatArray
    innovation: FloatArray
    innovation_var: FloatArray
    used: BoolArray
    past_mean: FloatArray
    past_cov: FloatArray
    ahead_mean: FloatArray
    ahead_cov: FloatArray
    log_likelihood: float = 0.0

    @classmethod
    def empty(cls, u: int, k: int, p: int, seen: int, history: int) -> _Found:
        """Room for u updates; `history` states kept, 0 for none."""
        kept, s = (u, history) if history else (0, 1)
        return cls(
            np.empty((u, p)), np.empty((u, p)), np.empty((u, seen)), np.zeros(u), np.zeros(u),
            np.full((u, k), np.nan), np.full((u, k), np.nan), np.zeros(u, dtype=bool),
            np.empty((kept, s)), np.empty((kept, s, s)), np.empty((kept, s)),
            np.empty((kept, s, s)),
        )  # fmt: skip


def _by_arrays(
    rows: Rows, tuned: Tuned, guards: Guards, mean: FloatArray, cov: FloatArray,
    decay: FloatArray, drive: FloatArray, bank: JumpBank | None, found: _Found,
) -> None:  # fmt: skip
    """Fill `found` update by update; `mean` and `cov` are left as after the last one."""
    p = len(rows.names)
    for j in range(len(rows)):
        mean[:], cov[:] = predict(mean, cov, decay[j], drive[j])
        if found.past_mean.size:
            found.ahead_mean[j], found.ahead_cov[j] = mean, cov
        at = np.flatnonzero(rows.valid[j])
        if at.size:
            h = tuned.design(rows.h[j], at)
            nu = -(rows.error[j, at] + h @ mean)
            seen = innovate(cov, h, nu, tuned.noise(j, rows.h[j], at)[0], guards.huber)
            found.innovation[j, at], found.innovation_var[j, at] = nu, seen.variance
            found.nis[j] = seen.nis
            found.log_likelihood += float(seen.log_likelihood)
            # what it teaches about z alone; one that teaches nothing changes nothing
            found.gain_nats[j] = information(cov[:p, :p], seen.weight[:, :p])
            if found.gain_nats[j] > guards.least_gain_nats:
                found.used[j] = True
                mean[:], cov[:] = correct(mean, cov, seen)
                if bank is not None:
                    mean[:], cov[:] = bank.update(j, h, seen, decay[j], mean, cov)
        found.values[j], found.momentary[j] = mean[:p], mean[tuned.seen]
        found.variances[j] = np.diagonal(cov)[:p]
        if found.past_mean.size:
            found.past_mean[j], found.past_cov[j] = mean, cov


def _by_loops(
    loops: ModuleType, rows: Rows, tuned: Tuned, guards: Guards, mean: FloatArray, cov: FloatArray,
    decay: FloatArray, drive: FloatArray, bank: JumpBank | None, found: _Found,
) -> None:  # fmt: skip
    """As `_by_arrays`, compiled."""
    none = np.zeros((1, 1))
    most = np.zeros((len(rows) if bank is not None else 0, 6))
    found.log_likelihood, jumps = loops.filter_walk(
        mean, cov, *_plain(rows, tuned), decay, drive, tuned.white[0], tuned.shared[0],
        guards.huber, guards.least_gain_nats, tuned.seen, found.values, found.variances,
        found.momentary, found.nis, found.gain_nats, found.innovation, found.innovation_var,
        found.used, found.past_mean, found.past_cov, found.ahead_mean, found.ahead_cov,
        np.zeros(0, dtype=np.int64) if bank is None else bank.biases,
        np.zeros((1, 1, 1)) if bank is None else bank.response,
        none if bank is None else bank.score,
        none if bank is None else bank.information,
        np.zeros(1, dtype=np.int64) if bank is None else bank.onset,
        np.inf if bank is None else bank.threshold,
        np.zeros(1) if bank is None else bank.least / rows.prior_sd[bank.biases],
        most,
    )  # fmt: skip
    if bank is not None:
        for which, onset, proof, size, variance, evidence in most[:jumps]:
            bank.believe(int(which), int(onset), int(proof), size, variance, evidence)


def _plain(rows: Rows, tuned: Tuned) -> tuple[object, ...]:
    """The rows as the loops take them."""
    return (
        np.ascontiguousarray(rows.h), np.ascontiguousarray(rows.error),
        np.ascontiguousarray(rows.valid), tuned.fixed, tuned.own_start,
        tuned.own.astype(np.int64), tuned.own_scale, np.ascontiguousarray(tuned.stamps),
        rows.totals,
    )  # fmt: skip


def _open_biases(drive: FloatArray, rows: Rows, jumps: Sequence[Jump]) -> None:
    """Let each jumped bias move by the size of its jump at its onset, in place."""
    for jump in jumps:
        at = rows.names.index(jump.name)
        update = int(np.clip(np.searchsorted(rows.time_s, jump.onset_s), 1, len(rows) - 1))
        drive[update, at] += (jump.size**2 + jump.sd**2) / rows.prior_sd[at] ** 2


def run_settings(
    rows: Rows,
    noise: Noise,
    guards: Guards | None = None,
    *,
    known_jumps: Sequence[Jump] = (),
    states: bool = True,
    fast: bool = True,
) -> tuple[FloatArray, FloatArray, FloatArray | None]:
    """Filter a walk with many settings of the noise in one pass, without jumps and gate.

    Parameters
    ----------
    rows
        As `run_filter`.
    noise
        Arrays of shape (settings,).
    guards
        Only `huber` is used.
    known_jumps
        Onsets at which a bias is opened.
    states
        False: the likelihood alone is wanted, and the states have no updates.
    fast
        As `run_filter`.

    Returns
    -------
    log_likelihood, shape (settings,), z in `units`, shape (u, settings, p), and the channels'
    momentary errors as in `Track`, shape (u, settings, c)
    """
    huber = (guards or Guards()).huber
    tuned = spread(rows, noise)
    b, p, s, u = len(tuned.walk), len(rows.names), tuned.states, len(rows)
    interval = np.diff(rows.time_s, prepend=rows.time_s[0])
    opened = np.zeros((u, p))
    _open_biases(opened, rows, known_jumps)
    kept = u if states else 0
    values, momentary = np.empty((kept, b, p)), np.empty((kept, b, tuned.seen.size))
    mean, cov = np.zeros(s), np.zeros((s, s))
    cov[:p, :p] = rows.prior_correlation
    loops = kalman_loops() if fast else None
    if loops is not None:
        log_likelihood = loops.filter_settings(
            mean, cov, *_plain(rows, tuned), interval, opened, tuned.walk, tuned.slow,
            tuned.slow_s, tuned.white, tuned.shared, huber, tuned.seen, states, values, momentary,
        )  # fmt: skip
        return log_likelihood, values * rows.prior_sd, momentary if tuned.seen.size else None
    log_likelihood = np.zeros(b)
    means, covs = np.zeros((b, s)), np.tile(cov, (b, 1, 1))
    slow_states = np.arange(p, s)
    covs[:, slow_states, slow_states] = tuned.slow
    decay, drive = np.ones((b, s)), np.empty((b, s))
    for j in range(u):
        decay[:, p:] = np.exp(-interval[j] / tuned.slow_s)
        drive[:, :p] = tuned.walk * interval[j] + opened[j]
        drive[:, p:] = tuned.slow * (1.0 - decay[:, p:] ** 2)
        means, covs = predict(means, covs, decay, drive)
        at = np.flatnonzero(rows.valid[j])
        if at.size:
            h = tuned.design(rows.h[j], at)
            nu = -(rows.error[j, at] + means @ h.T)
            seen = innovate(covs, h, nu, tuned.noise(j, rows.h[j], at), huber)
            log_likelihood += seen.log_likelihood
            means, covs = correct(means, covs, seen)
        if states:
            values[j], momentary[j] = means[:, :p], means[:, tuned.seen]
    return log_likelihood, values * rows.prior_sd, momentary if tuned.seen.size else None
