"""The live estimator as an object: samples go in one by one, calibrations come out.

It is `footcal_cli.core.online.live.run_live` cut open. Rows, filter, jumps and learning are the
same functions; only what one update needs is computed again. An update is given as soon as the
samples are there that its rows look ahead to: two, and those that the body's stream comes late by.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.log import Log
from footcal_cli.core.online.belief import Belief
from footcal_cli.core.online.filter import run_filter, track_of
from footcal_cli.core.online.jumps import BiasJump, JumpBank
from footcal_cli.core.online.live import (
    FIRST_LEARNING_S,
    Learnt,
    ahead_of,
    learn,
    of_live,
    repeated_by_then,
    rows_by_then,
)
from footcal_cli.core.online.memory import MemoryOptions
from footcal_cli.core.online.passes import Pass
from footcal_cli.core.online.rows import Rows
from footcal_cli.core.parameters import FloatArray


@dataclass(frozen=True)
class LiveUpdate:
    """What is known of the calibration after a block of samples.

    Parameters
    ----------
    time_s
        Stamp of the block's last sample.
    names
        Of the unknowns: gains and biases of the channels, then what troubles the reference.
    values, sd
        Shape (p,), as in `footcal_cli.core.online.filter.Track`.
    delay_s
        By which the body's stream had been moved; the state ``robot.delay`` adds to it.
    jumps
        Jumps of a bias found so far.
    """

    time_s: float
    names: tuple[str, ...]
    values: FloatArray
    sd: FloatArray
    delay_s: float
    jumps: tuple[BiasJump, ...]


@dataclass
class _Running:
    """The filter between two learnings: its state, its jump hypotheses, and what was learnt."""

    mean: FloatArray
    cov: FloatArray
    bank: JumpBank | None
    factor: float
    jumps: tuple[BiasJump, ...] = ()


class LiveEstimator:
    """Calibrates along a walk as its samples arrive.

    Parameters
    ----------
    options
        As `footcal_cli.core.online.memory.run_memory`; defaults where None.

    Examples
    --------
    >>> estimator = LiveEstimator(belief)                               # doctest: +SKIP
    >>> for sample in samples:                                          # doctest: +SKIP
    ...     for update in estimator.push(sample):
    ...         print(update.time_s, update.values[:8])
    """

    def __init__(self, belief: Belief, options: MemoryOptions | None = None) -> None:
        self._belief = belief
        self._options = of_live(options)
        self._learnt = Learnt(0.0, self._options.noise, None, ())
        self._past: list[Log] = []
        self._recent: Log | None = None
        self._recent_start = 0
        self._count = 0
        self._first_s = 0.0
        self._done = 0
        self._next_learning_s = FIRST_LEARNING_S
        self._running: _Running | None = None

    def push(self, samples: Log) -> list[LiveUpdate]:
        """Take in one sample or more, and give the updates that they complete.

        Parameters
        ----------
        samples
            Rows of a walk in their order: raw counts filtered causally, contact detected
            without the future.
        """
        self._past.append(samples)
        self._recent = samples if self._recent is None else _joined([self._recent, samples])
        self._count += len(samples)
        return self._advance(finishing=False)

    def finish(self) -> list[LiveUpdate]:
        """The last updates, whose rows would look ahead to samples that do not come any more."""
        return self._advance(finishing=True)

    def _advance(self, *, finishing: bool) -> list[LiveUpdate]:
        size = self._options.samples_per_update
        updates: list[LiveUpdate] = []
        while (self._done + 1) * size <= self._count:
            blocks = max(self._done + 1, 2)
            if not finishing and blocks * size + self._ahead() > self._count:
                break
            if self._learns():
                continue
            if self._running is None:
                self._running = self._begun()
            updates.append(self._step(self._running))
        return updates

    def _ahead(self) -> int:
        return ahead_of(self._latest, self._learnt.delay_s)

    @property
    def _latest(self) -> Log:
        assert self._recent is not None, "there are samples"
        return self._recent

    def _log(self, stop: int) -> Log:
        """All samples before one."""
        self._past = [_joined(self._past)]
        return self._past[0].rows(0, min(stop, self._count))

    def _learns(self) -> bool:
        """Learn from the past where it is time to; the filter then begins again."""
        size, at = self._options.samples_per_update, self._done
        latest = self._latest
        stamp = float(latest.time_s[(at + 1) * size - 1 - self._recent_start])
        if at == 0 or stamp < self._first_s + self._next_learning_s:
            return False
        log = self._log(at * size + self._ahead())
        rows = rows_by_then(log, at, self._learnt, self._belief, self._options)
        track = run_filter(rows, self._learnt.noise, self._options.guards)
        seen = log.rows(0, at * size)
        self._learnt = learn(seen, rows, track, self._learnt, self._belief, self._options)
        self._next_learning_s *= 2.0
        self._running = None
        return True

    def _begun(self) -> _Running:
        """The filter at the update that comes next, after all of the past."""
        at, options = self._done, self._options
        blocks = max(at, 2)
        log = self._log(blocks * options.samples_per_update + self._ahead())
        rows = rows_by_then(log, blocks, self._learnt, self._belief, options)
        past = rows.part(0, at) if at else rows
        begun = Pass.begin(past, self._learnt.noise, ())
        bank = JumpBank.start(past, begun.mean.size, options.guards)
        if not at:
            return _Running(begun.mean, begun.cov, bank, 1.0)
        found = begun.run(past, options.guards, bank)
        track = track_of(past, begun, found, bank)
        factor = repeated_by_then(log, past, track, options)
        return _Running(begun.mean, begun.cov, bank, factor, track.jumps)

    def _step(self, running: _Running) -> LiveUpdate:
        """One update of the filter."""
        options, at = self._options, self._done
        rows = self._rows_at(at)
        now = len(rows) - 1
        passed = Pass.begin(rows, self._learnt.noise, ()).part(now, now + 1)
        passed.mean, passed.cov = running.mean, running.cov
        if at == 0:
            self._first_s = float(rows.time_s[now])
        last, bank = rows.part(now, now + 1), running.bank
        if bank is not None:
            bank = replace(bank, rows=last) if at == 0 else bank.moved_on(last)
            running.bank = bank
        found = passed.run(last, options.guards, bank)
        running.jumps += () if bank is None else tuple(bank.found)
        self._done += 1
        self._forget()
        sd = np.sqrt(np.clip(found.variances[0], 0.0, None) * running.factor)
        return LiveUpdate(
            float(rows.time_s[now]), rows.names, found.values[0] * rows.prior_sd,
            sd * rows.prior_sd, self._learnt.delay_s, running.jumps,
        )  # fmt: skip

    def _rows_at(self, at: int) -> Rows:
        """Rows of an update and of the one before it, if any, from the samples about them."""
        size = self._options.samples_per_update
        first = max(at - 1 - self._back(), 0)
        stop = min((at + 1) * size + self._ahead(), self._count)
        window = self._latest.rows(first * size - self._recent_start, stop - self._recent_start)
        rows = rows_by_then(window, at + 1 - first, self._learnt, self._belief, self._options)
        return rows.part(max(at - 1 - first, 0), at + 1 - first)

    def _back(self) -> int:
        """Updates before the last one whose samples a row looks back to."""
        return -(-ahead_of(self._latest, -self._learnt.delay_s) // self._options.samples_per_update)

    def _forget(self) -> None:
        """Drop recent samples that no row looks back to; the past is kept for learning."""
        size = self._options.samples_per_update
        # a delay learnt later may look back farther: a second is spared
        spare = ahead_of(self._latest, _SPARE_S) + (2 + self._back()) * size
        start = max((self._done * size - spare) // size * size, 0)
        if start - self._recent_start > spare:
            self._recent = self._latest.rows(start - self._recent_start, len(self._latest))
            self._recent_start = start


_SPARE_S = 1.0


def _joined(logs: Sequence[Log]) -> Log:
    """Logs that follow each other as one."""
    if len(logs) == 1:
        return logs[0]
    first = logs[0]
    return replace(
        first,
        time_s=np.concatenate([log.time_s for log in logs]),
        readings=np.concatenate([log.readings for log in logs]),
        known={name: np.concatenate([log.known[name] for log in logs]) for name in first.known},
        block=np.concatenate([log.block for log in logs]),
    )
