"""The estimator that remembers: a Kalman filter over gains, biases and what troubles the reference.

State: z in units of its prior sd (random walks), and one first-order autoregressive error per
total row, because the error of a demanded force or moment is correlated in time. Innovations are
limited (Huber), an update that teaches nothing is left out, a jump of a bias is found by the
generalised likelihood ratio of Willsky and Jones (IEEE TAC 21, 1976).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from footcal_cli.core.inference.kalman import correct, innovate, predict
from footcal_cli.core.online.compiled import kalman_loops
from footcal_cli.core.online.jumps import BiasJump, JumpBank
from footcal_cli.core.online.noise import Guards as Guards
from footcal_cli.core.online.noise import WalkNoise as WalkNoise
from footcal_cli.core.online.passes import FilterOutput, Pass, PassInput, open_biases
from footcal_cli.core.online.rows import Rows
from footcal_cli.core.online.tuned import spread
from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray

_PER_UPDATE = (
    "time_s", "values", "sd", "momentary", "nis", "dof", "innovation", "innovation_sd",
    "gain_nats", "used",
)  # fmt: skip


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
    jumps: tuple[BiasJump, ...]

    def at_end(self, name: str) -> tuple[float, float]:
        """Value and sd of a state after the last update; zeros where it is none of the states."""
        if name not in self.names:
            return 0.0, 0.0
        at = self.names.index(name)
        return float(self.values[-1, at]), float(self.sd[-1, at])

    def inflated(self, factor: float) -> Track:
        """The same states, all covariances multiplied by a factor; innovations are unchanged."""
        return replace(self, sd=self.sd * np.sqrt(factor), covariance=self.covariance * factor)

    def chosen(self, at: slice | IntArray | BoolArray) -> Track:
        """Some updates, in their order; what is said of the whole walk stays."""
        return replace(self, **{name: values[at] for name, values in self._series().items()})

    def followed_by(self, later: Track) -> Track:
        """The track and one that goes on from it, joined."""
        more = later._series()
        joined: dict[str, Any] = {
            name: np.concatenate([own, more[name]]) for name, own in self._series().items()
        }
        return replace(
            later, **joined, log_likelihood=self.log_likelihood + later.log_likelihood,
            jumps=(*self.jumps, *later.jumps),
        )  # fmt: skip

    def _series(self) -> dict[str, Any]:
        """What it holds per update."""
        own = {name: getattr(self, name) for name in _PER_UPDATE}
        return {name: values for name, values in own.items() if values is not None}


def run_filter(
    rows: Rows,
    noise: WalkNoise,
    guards: Guards | None = None,
    *,
    known_jumps: Sequence[BiasJump] = (),
    fast: bool = True,
) -> Track:
    """Filter a walk with one setting of the noise.

    Parameters
    ----------
    rows
        From `cell_rows` or `six_axis_rows`.
    guards
        Limits; the defaults where None.
    known_jumps
        Onsets at which a bias is opened, found in an earlier pass; no others are looked for.
    fast
        Use compiled loops where they are at hand; the array code gives the same to rounding.
    """
    guards = guards or Guards()
    begun = Pass.begin(rows, noise, known_jumps)
    bank = None if known_jumps else JumpBank.start(rows, begun.mean.size, guards)
    return track_of(rows, begun, begun.run(rows, guards, bank, fast=fast), bank)


def track_of(rows: Rows, passed: Pass, found: FilterOutput, bank: JumpBank | None) -> Track:
    """What a pass found, in the units of the rows."""
    p = len(rows.names)
    return Track(
        time_s=rows.time_s,
        names=rows.names,
        units=rows.units,
        values=found.values * rows.prior_sd,
        sd=np.sqrt(np.clip(found.variances, 0.0, None)) * rows.prior_sd,
        momentary=found.momentary if passed.tuned.seen.size else None,
        covariance=passed.cov[:p, :p] * np.outer(rows.prior_sd, rows.prior_sd),
        nis=found.nis,
        dof=rows.valid.sum(axis=1).astype(float),
        innovation=found.innovation,
        innovation_sd=np.sqrt(found.innovation_var),
        gain_nats=found.gain_nats,
        used=found.used,
        log_likelihood=float(found.log_likelihood),
        jumps=() if bank is None else tuple(bank.found),
    )


def run_settings(
    rows: Rows,
    noise: WalkNoise,
    guards: Guards | None = None,
    *,
    known_jumps: Sequence[BiasJump] = (),
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
    open_biases(opened, rows, known_jumps)
    kept = u if states else 0
    values, momentary = np.empty((kept, b, p)), np.empty((kept, b, tuned.seen.size))
    mean, cov = np.zeros(s), np.zeros((s, s))
    cov[:p, :p] = rows.prior_correlation
    loops = kalman_loops() if fast else None
    if loops is not None:
        log_likelihood = loops.filter_settings(
            mean, cov, PassInput.of(rows, tuned), interval, opened, huber, states, values, momentary
        )
        return log_likelihood, values * rows.prior_sd, momentary if tuned.seen.size else None
    log_likelihood = np.zeros(b)
    means, covs = np.zeros((b, s)), np.tile(cov, (b, 1, 1))
    slow_states = np.arange(p, s)
    covs[:, slow_states, slow_states] = tuned.slow
    decay, drive = np.ones((b, s)), np.empty((b, s))
    for j in range(u):
        decay[:, p:] = np.exp(-interval[j] / tuned.slow_s)
        decay[:, s - tuned.soles.renewed.shape[1] :] *= ~tuned.soles.renewed[j]
        drive[:, :p] = tuned.walk * interval[j] + opened[j]
        drive[:, p:] = tuned.slow * (1.0 - decay[:, p:] ** 2)
        means, covs = predict(means, covs, decay, drive)
        at = np.flatnonzero(rows.valid[j])
        if at.size:
            h = tuned.design(j, rows.h[j], at)
            nu = -(rows.error[j, at] + means @ h.T)
            seen = innovate(covs, h, nu, tuned.noise(j, rows.h[j], at), huber)
            log_likelihood += seen.log_likelihood
            means, covs = correct(means, covs, seen)
        if states:
            values[j], momentary[j] = means[:, :p], means[:, tuned.seen]
    return log_likelihood, values * rows.prior_sd, momentary if tuned.seen.size else None
