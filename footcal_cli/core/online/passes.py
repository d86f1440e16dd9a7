"""A pass of the filter over a walk, from any state on: by array code or by compiled loops."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import NamedTuple

import numpy as np

from footcal_cli.core.inference.kalman import correct, information, innovate, predict
from footcal_cli.core.online.compiled import kalman_loops
from footcal_cli.core.online.jumps import WRONG_PRIOR, BiasJump, JumpBank
from footcal_cli.core.online.noise import Guards, WalkNoise
from footcal_cli.core.online.rows import Rows
from footcal_cli.core.online.tuned import Tuned, spread
from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray


@dataclass
class Pass:
    """A pass of the filter: noise, transitions and the state that it has come to.

    Parameters
    ----------
    tuned
        One setting.
    mean, cov
        As after the last update that was run, in units of the prior sd.
    decay, drive
        Diagonals of Φ and Q into each update, shape (u, s).
    """

    tuned: Tuned
    mean: FloatArray
    cov: FloatArray
    decay: FloatArray
    drive: FloatArray

    @classmethod
    def begin(cls, rows: Rows, noise: WalkNoise, jumps: Sequence[BiasJump]) -> Pass:
        """At the prior, before the first update."""
        tuned = spread(rows, noise)
        u, p, s = len(rows), len(rows.names), tuned.states
        cov = np.zeros((s, s))
        cov[:p, :p] = rows.prior_correlation
        cov[p:, p:] = np.diag(tuned.slow[0])
        interval = np.diff(rows.time_s, prepend=rows.time_s[0])
        decay, drive = np.ones((u, s)), np.empty((u, s))
        decay[:, p:] = np.exp(-interval[:, None] / tuned.slow_s[0])
        renewed = tuned.soles.renewed
        decay[:, s - renewed.shape[1] :][renewed] = 0.0
        drive[:, :p] = tuned.walk[0] * interval[:, None]
        drive[:, p:] = tuned.slow[0] * (1.0 - decay[:, p:] ** 2)
        open_biases(drive, rows, jumps)
        return cls(tuned, np.zeros(s), cov, decay, drive)

    def part(self, start: int, stop: int) -> Pass:
        """The same for updates ``start:stop``; its state is its own."""
        cut = slice(start, stop)
        return Pass(
            self.tuned.part(start, stop), self.mean.copy(), self.cov.copy(), self.decay[cut],
            self.drive[cut],
        )  # fmt: skip

    def run(
        self,
        rows: Rows,
        guards: Guards,
        bank: JumpBank | None = None,
        *,
        keep_history: bool = False,
        fast: bool = True,
    ) -> FilterOutput:
        """Filter all its updates from its state on."""
        u, k = rows.error.shape
        p, s = len(rows.names), self.mean.size
        found = FilterOutput.empty(u, k, p, self.tuned.seen.size, s if keep_history else 0)
        loops = kalman_loops() if fast else None
        if loops is None:
            return _by_arrays(self, rows, guards, bank, found)
        return _by_loops(loops, self, rows, guards, bank, found)


class FilterOutput(NamedTuple):
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
    def joined(cls, pieces: Sequence[FilterOutput]) -> FilterOutput:
        """Passes over stretches that follow each other as one, without their history."""
        names = (
            "values", "variances", "momentary", "nis", "gain_nats", "innovation",
            "innovation_var", "used",
        )  # fmt: skip
        whole = {name: np.concatenate([getattr(one, name) for one in pieces]) for name in names}
        no_history = cls.empty(0, 0, 0, 0, 0)
        return no_history._replace(
            **whole, log_likelihood=sum(one.log_likelihood for one in pieces)
        )

    @classmethod
    def empty(cls, u: int, k: int, p: int, seen: int, history: int) -> FilterOutput:
        """Room for u updates; `history` states kept, 0 for none."""
        kept, s = (u, history) if history else (0, 1)
        return cls(
            np.empty((u, p)), np.empty((u, p)), np.empty((u, seen)), np.zeros(u), np.zeros(u),
            np.full((u, k), np.nan), np.full((u, k), np.nan), np.zeros(u, dtype=bool),
            np.empty((kept, s)), np.empty((kept, s, s)), np.empty((kept, s)),
            np.empty((kept, s, s)),
        )  # fmt: skip


def _by_arrays(
    begun: Pass, rows: Rows, guards: Guards, bank: JumpBank | None, found: FilterOutput
) -> FilterOutput:
    """Fill `found` update by update; mean and covariance are left as after the last one."""
    p, tuned, mean, cov, log_likelihood = len(rows.names), begun.tuned, begun.mean, begun.cov, 0.0
    for j in range(len(rows)):
        mean[:], cov[:] = predict(mean, cov, begun.decay[j], begun.drive[j])
        if found.past_mean.size:
            found.ahead_mean[j], found.ahead_cov[j] = mean, cov
        at = np.flatnonzero(rows.valid[j])
        if at.size:
            h = tuned.design(j, rows.h[j], at)
            nu = -(rows.error[j, at] + h @ mean)
            seen = innovate(cov, h, nu, tuned.noise(j, rows.h[j], at)[0], guards.huber)
            found.innovation[j, at], found.innovation_var[j, at] = nu, seen.variance
            found.nis[j] = seen.nis
            log_likelihood += float(seen.log_likelihood)
            # what it teaches about z alone; one that teaches nothing changes nothing
            found.gain_nats[j] = information(cov[:p, :p], seen.weight[:, :p])
            if found.gain_nats[j] > guards.least_gain_nats:
                found.used[j] = True
                mean[:], cov[:] = correct(mean, cov, seen)
                if bank is not None:
                    mean[:], cov[:] = bank.update(j, h, seen, begun.decay[j], mean, cov)
        found.values[j], found.momentary[j] = mean[:p], mean[tuned.seen]
        found.variances[j] = np.diagonal(cov)[:p]
        if found.past_mean.size:
            found.past_mean[j], found.past_cov[j] = mean, cov
    return found._replace(log_likelihood=log_likelihood)


def _by_loops(
    loops: ModuleType,
    begun: Pass,
    rows: Rows,
    guards: Guards,
    bank: JumpBank | None,
    found: FilterOutput,
) -> FilterOutput:
    """As `_by_arrays`, compiled."""
    jumping = PlainBank.of(bank, rows)
    log_likelihood, jumps = loops.filter_walk(
        begun.mean, begun.cov, PassInput.of(rows, begun.tuned), begun.decay, begun.drive,
        guards.huber, guards.least_gain_nats, found, jumping,
    )  # fmt: skip
    for which, onset, proof, size, variance, evidence in jumping.found[:jumps]:
        assert bank is not None, "no other finds jumps"
        bank.believe(int(which), int(onset), int(proof), size, variance, evidence)
    return found._replace(log_likelihood=float(log_likelihood))


class PassInput(NamedTuple):
    """Rows and the noise of B settings as the loops take them; names as in `Rows` and `Tuned`.

    `soles`, `renewed`: columns and updates of `footcal_cli.core.online.soles.Soles`.
    """

    h: FloatArray
    error: FloatArray
    valid: BoolArray
    totals: int
    fixed: FloatArray
    own_start: int
    own: IntArray
    own_scale: FloatArray
    stamps: FloatArray
    seen: IntArray
    walk: FloatArray
    slow: FloatArray
    slow_s: FloatArray
    white: FloatArray
    shared: FloatArray
    soles: FloatArray
    renewed: BoolArray

    @classmethod
    def of(cls, rows: Rows, tuned: Tuned) -> PassInput:
        """Every array in one piece, so that one machine code serves all."""
        arrays = {
            name: np.ascontiguousarray(getattr(tuned, name))
            for name in (
                "fixed",
                "own_scale",
                "stamps",
                "walk",
                "slow",
                "slow_s",
                "white",
                "shared",
            )
        }
        return cls(
            np.ascontiguousarray(rows.h), np.ascontiguousarray(rows.error),
            np.ascontiguousarray(rows.valid), rows.totals, own_start=tuned.own_start,
            own=tuned.own.astype(np.int64), seen=tuned.seen.astype(np.int64),
            soles=np.ascontiguousarray(tuned.soles.columns),
            renewed=np.ascontiguousarray(tuned.soles.renewed), **arrays,
        )  # fmt: skip


class PlainBank(NamedTuple):
    """A `JumpBank` as the loops take it, and room for what they find; empty without one."""

    biases: IntArray
    response: FloatArray
    score: FloatArray
    information: FloatArray
    onset: IntArray
    unlearnt: FloatArray
    threshold: float
    least: FloatArray
    wrong_prior: float
    found: FloatArray

    @classmethod
    def of(cls, bank: JumpBank | None, rows: Rows) -> PlainBank:
        """With `JumpBank.least` in units of the prior sd; one row per jump in `found`."""
        if bank is None:
            none, nobody = np.zeros((1, 1)), np.zeros(0, dtype=np.int64)
            return cls(
                nobody, np.zeros((1, 1, 1)), none, none, np.zeros(1, dtype=np.int64), none, np.inf,
                np.zeros(1), WRONG_PRIOR, np.zeros((0, 6)),
            )  # fmt: skip
        return cls(
            bank.biases, bank.response, bank.score, bank.information, bank.onset, bank.unlearnt,
            bank.threshold, bank.least / rows.prior_sd[bank.biases], WRONG_PRIOR,
            np.zeros((len(rows), 6)),
        )  # fmt: skip


def open_biases(drive: FloatArray, rows: Rows, jumps: Sequence[BiasJump]) -> None:
    """Let each jumped bias move by the size of its jump at its onset, in place."""
    for jump in jumps:
        at = rows.names.index(jump.name)
        update = int(np.clip(np.searchsorted(rows.time_s, jump.onset_s), 1, len(rows) - 1))
        drive[update, at] += (jump.size**2 + jump.sd**2) / rows.prior_sd[at] ** 2
