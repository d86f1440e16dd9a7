"""The estimator that remembers: a Kalman filter over gains, biases and what troubles the reference.

State: z in units of its prior sd (random walks), and one first-order autoregressive error per
total row, because the error of a demanded force or moment is correlated in time. Innovations are
limited (Huber), an update that teaches nothing is left out, a jump of a bias is found by the
generalised likelihood ratio of Willsky and Jones (IEEE TAC 21, 1976).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from footcal_cli.core.online.jumps import Jump, JumpBank
from footcal_cli.core.online.noise import Guards as Guards
from footcal_cli.core.online.noise import Noise as Noise
from footcal_cli.core.online.rows import Rows
from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray

_LOG_2PI = float(np.log(2.0 * np.pi))
_LEAST_SHARE = 0.1
"""A correlated error of a cell below this share of its white noise is not worth a state."""


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


@dataclass(frozen=True)
class _Tuned:
    """Noise of B settings spread over states and rows."""

    walk: FloatArray  # variance rate of z per second, (B, p)
    slow: FloatArray  # stationary variance of the correlated errors, (B, e)
    slow_s: FloatArray  # their correlation times, (B, e)
    columns: FloatArray  # how each of them adds to the rows, (u, k, e)
    white: FloatArray  # row variances, (B, k)
    shared: FloatArray  # variances of what several rows share, (B, 2): cells, stamps
    sharing: FloatArray  # its covariance per variance, (2, u, k, k)
    own: IntArray  # which states are the channels' slow noise that the totals see, (c,) or (0,)

    def noise(self, update: int, at: IntArray) -> FloatArray:
        """Covariance of the rows' white noise, shape (B, rows, rows)."""
        i = np.arange(at.size)
        total = np.tensordot(self.shared, self.sharing[:, update][:, at[:, None], at], axes=1)
        total[:, i, i] += self.white[:, at]
        return np.asarray(total)


def _spread(rows: Rows, noise: Noise, walk_factor: FloatArray | None) -> _Tuned:
    """Give every state and row its noise."""
    table = noise.stacked()
    named = {f.name: table[:, i] for i, f in enumerate(fields(Noise))}
    settings, totals = len(table), rows.totals
    sd = np.empty((settings, len(rows.names)))
    for i, name in enumerate(rows.names):
        kind = name.rsplit(".", 1)[-1]
        if kind in ("gain", "scale"):
            sd[:, i] = named["gain_walk"] / rows.prior_sd[i]
        elif kind == "bias" or kind.startswith("offset_f"):
            sd[:, i] = named["bias_walk_n"] / rows.prior_sd[i]
        else:
            sd[:, i] = named["state_walk"]
    if walk_factor is not None:
        sd = sd * walk_factor
    force = np.array([name.startswith("f") for name in rows.outputs[:totals]])
    slow = np.where(force, named["force_slow_n"][:, None], named["moment_slow_nm"][:, None])
    white = np.empty((settings, len(rows.outputs)))
    white[:, :totals] = np.where(force, named["force_n"][:, None], named["moment_nm"][:, None])
    white[:, totals:] = named["swing_n"][:, None] * rows.swing_sd_factor
    slow, white[:, :totals] = (part * rows.total_sd_factor for part in (slow, white[:, :totals]))
    slow_s = np.where(force, named["force_slow_s"][:, None], named["moment_slow_s"][:, None])
    u, k = rows.error.shape
    unit = np.broadcast_to(np.eye(k), (u, k, k))
    own = (
        unit[:, :, totals:]
        if rows.own is None
        else rows.h[:, :, rows.own] / rows.prior_sd[rows.own]
    )
    columns, seen = [unit[:, :, :totals]], np.zeros(0, dtype=np.int64)
    for name, adds in (("swing_slow_n", own), ("swing_fixed_n", unit[:, :, totals:])):
        time_s = named[name.removesuffix("n") + "s"]
        if np.any(named[name] > _LEAST_SHARE * named["swing_n"]):
            if name == "swing_slow_n" and rows.own is not None:
                seen = len(rows.names) + slow.shape[1] + np.arange(k - totals)
            kept = named[name][:, None] * rows.swing_sd_factor
            slow = np.concatenate([slow, kept], axis=1)
            slow_s = np.concatenate([slow_s, np.tile(time_s[:, None], kept.shape[1])], axis=1)
            columns.append(adds)
    sharing = np.zeros((2, u, k, k))
    if rows.own is not None:
        white[:, totals:] = 0.0
        sharing[0] = own @ own.transpose(0, 2, 1)
    if rows.per_stamp_s is not None:
        stamps = rows.per_stamp_s
        sharing[1, :, :totals, :totals] = stamps[:, :, None] * stamps[:, None, :]
    shared = np.stack([named["swing_n"], named["jitter_s"]], axis=1)
    return _Tuned(
        sd**2, slow**2, slow_s, np.concatenate(columns, axis=2), white**2, shared**2, sharing, seen
    )


def run_filter(
    rows: Rows,
    noise: Noise,
    guards: Guards | None = None,
    *,
    walk_factor: FloatArray | None = None,
    known_jumps: Sequence[Jump] = (),
    keep_history: bool = False,
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
    """
    guards = guards or Guards()
    tuned = _spread(rows, noise, walk_factor)
    u, k = rows.error.shape
    p, t = len(rows.names), tuned.slow.shape[1]
    s = p + t
    mean = np.zeros(s)
    cov = np.zeros((s, s))
    cov[:p, :p] = rows.prior_correlation
    cov[p:, p:] = np.diag(tuned.slow[0])
    h_all = np.zeros((u, k, s))
    h_all[:, :, :p] = rows.h
    h_all[:, :, p:] = tuned.columns
    interval = np.diff(rows.time_s, prepend=rows.time_s[0])
    decay = np.ones((u, s))
    decay[:, p:] = np.exp(-interval[:, None] / tuned.slow_s[0])
    drive = np.empty((u, s))
    drive[:, :p] = tuned.walk[0] * interval[:, None]
    drive[:, p:] = tuned.slow[0] * (1.0 - decay[:, p:] ** 2)

    values, sd, momentary = np.empty((u, p)), np.empty((u, p)), np.empty((u, tuned.own.size))
    nis, gain_nats = np.zeros(u), np.zeros(u)
    innovation, innovation_sd = np.full((u, k), np.nan), np.full((u, k), np.nan)
    used = np.zeros(u, dtype=bool)
    log_likelihood = 0.0
    _open_biases(drive, rows, known_jumps)
    bank = None
    if not known_jumps:
        bank = JumpBank.start(
            rows, s, guards.jump_threshold, guards.least_jump_n, guards.jump_memory_s
        )
    past = _Past.start(u, s) if keep_history else None
    diagonal = np.arange(s)
    for j in range(u):
        mean *= decay[j]
        cov *= decay[j][:, None] * decay[j]
        cov[diagonal, diagonal] += drive[j]
        if past is not None:
            past.mean_ahead[j], past.covariance_ahead[j] = mean, cov
        at = np.flatnonzero(rows.valid[j])
        if at.size:
            h = h_all[j, at]
            nu = -(rows.error[j, at] + h @ mean)
            ph = cov @ h.T
            total = h @ ph + tuned.noise(j, at)[0]
            variance = np.diag(total).copy()
            # Huber: a row further off than it should be gets the noise that would explain it
            extra = np.maximum(nu**2 / guards.huber**2 - variance, 0.0)
            total += np.diag(extra)
            inverse = np.linalg.inv(total)
            whitened = inverse @ nu
            nis[j] = nu @ whitened
            innovation[j, at], innovation_sd[j, at] = nu, np.sqrt(variance)
            log_det = np.linalg.slogdet(total)[1]
            log_likelihood -= 0.5 * (nis[j] + log_det + at.size * _LOG_2PI)
            gain = ph @ inverse
            now = cov[:p, :p]
            # information about z alone: how far the update would shrink its covariance
            gain_nats[j] = 0.5 * (
                np.linalg.slogdet(now)[1] - np.linalg.slogdet(now - gain[:p] @ ph[:p].T)[1]
            )
            if gain_nats[j] > guards.least_gain_nats:
                used[j] = True
                mean = mean + gain @ nu
                cov = cov - gain @ ph.T
                cov = 0.5 * (cov + cov.T)
                if bank is not None:
                    mean, cov = bank.update(j, h, gain, inverse, nu, decay[j], mean, cov)
        values[j], momentary[j] = mean[:p], mean[tuned.own]
        sd[j] = cov[diagonal[:p], diagonal[:p]]
        if past is not None:
            past.mean[j], past.covariance[j] = mean, cov
    history = None if past is None else past.history(decay, rows.prior_sd, tuned.own)
    return Track(
        time_s=rows.time_s,
        names=rows.names,
        units=rows.units,
        values=values * rows.prior_sd,
        sd=np.sqrt(np.clip(sd, 0.0, None)) * rows.prior_sd,
        momentary=momentary if tuned.own.size else None,
        covariance=cov[:p, :p] * np.outer(rows.prior_sd, rows.prior_sd),
        nis=nis,
        dof=rows.valid.sum(axis=1).astype(float),
        innovation=innovation,
        innovation_sd=innovation_sd,
        gain_nats=gain_nats,
        used=used,
        log_likelihood=float(log_likelihood),
        jumps=() if bank is None else tuple(bank.found),
        history=history,
    )


def _open_biases(drive: FloatArray, rows: Rows, jumps: Sequence[Jump]) -> None:
    """Let each jumped bias move by the size of its jump at its onset, in place."""
    for jump in jumps:
        at = rows.names.index(jump.name)
        update = int(np.clip(np.searchsorted(rows.time_s, jump.onset_s), 1, len(rows) - 1))
        drive[update, at] += (jump.size**2 + jump.sd**2) / rows.prior_sd[at] ** 2


@dataclass
class _Past:
    """Buffers that the filter fills for the smoother."""

    mean: FloatArray
    covariance: FloatArray
    mean_ahead: FloatArray
    covariance_ahead: FloatArray

    @classmethod
    def start(cls, u: int, s: int) -> _Past:
        return cls(np.empty((u, s)), np.empty((u, s, s)), np.empty((u, s)), np.empty((u, s, s)))

    def history(self, decay: FloatArray, scale: FloatArray, own: IntArray) -> History:
        return History(
            self.mean, self.covariance, self.mean_ahead, self.covariance_ahead, decay, scale, own
        )


def run_settings(
    rows: Rows,
    noise: Noise,
    guards: Guards | None = None,
    *,
    known_jumps: Sequence[Jump] = (),
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

    Returns
    -------
    log_likelihood, shape (settings,), z in `units`, shape (u, settings, p), and the channels'
    momentary errors as in `Track`, shape (u, settings, c)
    """
    huber = (guards or Guards()).huber
    tuned = _spread(rows, noise, None)
    b = len(tuned.walk)
    u, k = rows.error.shape
    p, t = len(rows.names), tuned.slow.shape[1]
    s = p + t
    mean = np.zeros((b, s))
    cov = np.zeros((b, s, s))
    cov[:, :p, :p] = rows.prior_correlation
    cov[:, p + np.arange(t), p + np.arange(t)] = tuned.slow
    interval = np.diff(rows.time_s, prepend=rows.time_s[0])
    values, momentary = np.empty((u, b, p)), np.empty((u, b, tuned.own.size))
    log_likelihood = np.zeros(b)
    diagonal = np.arange(s)
    decay = np.ones((b, s))
    drive = np.empty((b, s))
    opened = np.zeros((u, p))
    _open_biases(opened, rows, known_jumps)
    h_full = np.zeros((k, s))
    for j in range(u):
        decay[:, p:] = np.exp(-interval[j] / tuned.slow_s)
        drive[:, :p] = tuned.walk * interval[j]
        drive[:, :p] += opened[j]
        drive[:, p:] = tuned.slow * (1.0 - decay[:, p:] ** 2)
        mean = mean * decay
        cov = cov * (decay[:, :, None] * decay[:, None, :])
        cov[:, diagonal, diagonal] += drive
        at = np.flatnonzero(rows.valid[j])
        if at.size:
            h_full[:, :p], h_full[:, p:] = rows.h[j], tuned.columns[j]
            h = h_full[at]
            nu = -(rows.error[j, at] + mean @ h.T)
            ph = cov @ h.T
            total = h @ ph + tuned.noise(j, at)
            i = np.arange(at.size)
            total[:, i, i] = np.maximum(total[:, i, i], nu**2 / huber**2)
            inverse = np.linalg.inv(total)
            whitened = np.einsum("bij,bj->bi", inverse, nu)
            log_likelihood -= 0.5 * (
                np.sum(nu * whitened, axis=1) + np.linalg.slogdet(total)[1] + at.size * _LOG_2PI
            )
            gain = ph @ inverse
            mean = mean + np.einsum("bsi,bi->bs", gain, nu)
            cov = cov - gain @ ph.transpose(0, 2, 1)
            cov = 0.5 * (cov + cov.transpose(0, 2, 1))
        values[j], momentary[j] = mean[:, :p], mean[:, tuned.own]
    return log_likelihood, values * rows.prior_sd, momentary if tuned.own.size else None
