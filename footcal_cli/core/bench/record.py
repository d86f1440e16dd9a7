"""One channel's bench record: known loads, readings, and the order in which they happened."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from footcal_cli.core.log import Log
from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray
from footcal_cli.core.signals import parts_of

_ROWS_OF_A_RECORDING = 20
"""More rows than this per load and session, closer than a second, are samples of a recording."""
_SAME_LOAD = 0.01
"""Loads closer than this share of the span are one load for cross-validation."""
_MOST_LOADS = 12
"""A reference that varies continuously is cut into this many ranges of load."""

_PAUSE = 3.0
"""Usual steps in time from which on rows are missing."""


@dataclass(frozen=True)
class BenchRecord:
    """Rows of one channel, sorted by session and time.

    Parameters
    ----------
    load_n
        True load, shape (n,); NaN where it is not known (a weight being changed): such rows only
        carry the memory of what the cell went through.
    reading
        Raw reading in counts, shape (n,).
    time_s
        Stamps, shape (n,); row numbers where there is no clock.
    session
        Shape (n,).
    temperature_degc
        Shape (n,), or None.
    timed
        Whether `time_s` is a clock: without one, neither creep nor noise that persists in time can
        be looked for.
    renewed
        Whether each load that is put on has an error of its own (`with_law_of_noise`).
    changed_s
        Stamps at which loads were changed while nothing was recorded, shape (c,); None: at once.
    """

    channel: str
    load_n: FloatArray
    reading: FloatArray
    time_s: FloatArray
    session: IntArray
    temperature_degc: FloatArray | None = None
    timed: bool = True
    renewed: bool = False
    changed_s: FloatArray | None = None

    def __len__(self) -> int:
        return self.load_n.size

    @property
    def known(self) -> BoolArray:
        """Rows with a known load and a reading, shape (n,)."""
        return np.isfinite(self.load_n) & np.isfinite(self.reading)

    @property
    def full_scale_n(self) -> float:
        """Largest known absolute load."""
        return float(np.nanmax(np.abs(self.load_n)))

    @property
    def recorded(self) -> bool:
        """Whether rows are samples of a running recording rather than one reading per load."""
        if not self.timed:
            return False
        gaps = np.diff(self.time_s)
        gaps = gaps[gaps > 0]
        changes = int(np.sum(np.abs(np.diff(self.load_n)) > 0))
        dense = len(self) / (1 + changes) > _ROWS_OF_A_RECORDING
        # a reference that is read at every sample changes at most of them
        dense |= len(self) > 3 * _ROWS_OF_A_RECORDING and changes > len(self) / 2
        return bool(dense and gaps.size and np.median(gaps) < 1.0)

    @property
    def longest_s(self) -> float:
        """How long the longest session lasts; 0 where stamps stand still."""
        return max(float(np.ptp(self.time_s[part])) for part in self.sessions())

    def select(self, rows: BoolArray | slice) -> BenchRecord:
        """A selection of the rows; a slice is a view, not a copy."""
        warmth = None if self.temperature_degc is None else self.temperature_degc[rows]
        return replace(
            self,
            load_n=self.load_n[rows],
            reading=self.reading[rows],
            time_s=self.time_s[rows],
            session=self.session[rows],
            temperature_degc=warmth,
        )

    def without(self, rows: BoolArray) -> BenchRecord:
        """The same history with the loads of some rows withheld."""
        return replace(self, load_n=np.where(rows, np.nan, self.load_n))

    def sessions(self) -> Iterator[slice]:
        """Slices of uninterrupted sessions."""
        edges = np.flatnonzero(np.diff(self.session)) + 1
        for start, stop in zip([0, *edges], [*edges, len(self)], strict=True):
            yield slice(int(start), int(stop))

    @cached_property
    def apart_s(self) -> FloatArray:
        """Stamps of each session wholly before those of the one before, shape (n,).

        Stamps that step back are what starts a recording afresh.
        """
        parts = list(self.sessions())
        apart = 1.0 + max(float(np.ptp(self.time_s[part])) for part in parts)
        since = [self.time_s[p] - self.time_s[p].min() - k * apart for k, p in enumerate(parts)]
        return np.concatenate(since)

    @cached_property
    def changed_at(self) -> IntArray | None:
        """Rows before which a load was changed while nothing was recorded, shape (c,), if any."""
        return None if self.changed_s is None else np.searchsorted(self.time_s, self.changed_s)

    @cached_property
    def as_log(self) -> Log:
        """Stamps and temperatures of the loads that an effect acts on, which are put in later.

        A load that was changed while nothing was recorded stood there until then (`changed_s`).
        Its memory goes on into a session that comes at the pace of the readings, and starts afresh
        in others, and in all where no clock says how long they lie apart.
        """
        warmth, block = self.temperature_degc, self.session
        time_s, at = self.time_s if self.timed else self.apart_s, self.changed_at
        if at is not None and self.changed_s is not None:
            time_s, block = np.insert(time_s, at, self.changed_s), np.insert(block, at, block[at])
            warmth = None if warmth is None else np.insert(warmth, at, warmth[at])
        return Log(
            experiment="weights",
            channels=(self.channel,),
            time_s=time_s,
            readings=np.zeros((time_s.size, 1)),
            known={} if warmth is None else {"temperature_degc": warmth},
            block=block,
        )

    def loadings(self) -> IntArray:
        """Number of the load that was put on last, of each row with a known load, shape (m,)."""
        session, load = self.session[self.known], self.load_n[self.known]
        new = (np.diff(session) != 0) | (np.diff(load) != 0.0)
        return np.concatenate([[0], np.cumsum(new)]).astype(np.int64)

    def pauses(self) -> FloatArray:
        """Last stamp under one load and first under the next where rows are missing, (c, 2)."""
        gap = np.diff(self.time_s)
        usual = np.median(gap[gap > 0]) if np.any(gap > 0) else np.inf
        between = np.flatnonzero((np.diff(self.load_n) != 0) & (gap > _PAUSE * usual))
        return np.stack([self.time_s[between], self.time_s[between + 1]], axis=1)

    def groups(self) -> IntArray:
        """The units of evidence: sessions where there are three or more, else loads, shape (n,)."""
        if np.unique(self.session).size >= 3:
            return np.unique(self.session, return_inverse=True)[1].astype(np.int64)
        return load_levels(self.load_n)

    def drive(self) -> FloatArray:
        """Loads with gaps filled in from the readings by a straight line, shape (n,)."""
        known = self.known
        if known.all():
            return self.load_n
        line = np.polynomial.Polynomial.fit(self.reading[known], self.load_n[known], 1)
        reading = np.where(np.isfinite(self.reading), self.reading, np.nanmedian(self.reading))
        return np.where(known, self.load_n, line(reading))


def load_levels(load_n: FloatArray) -> IntArray:
    """Index of the distinct load of each row, shape (n,); −1 where the load is unknown.

    Parameters
    ----------
    load_n
        Shape (n,).
    """
    known = np.isfinite(load_n)
    parts = list(parts_of(load_n.size))
    values = np.unique(np.concatenate([np.unique(load_n[p][known[p]]) for p in parts] or [load_n]))
    level = np.full(load_n.size, -1, dtype=np.int64)
    if not values.size:
        return level
    span = float(values[-1] - values[0])
    starts = values[np.diff(values, prepend=-np.inf) > _SAME_LOAD * span]
    if starts.size > 2 * _MOST_LOADS or (starts.size == 1 and span > 0.0):
        starts = values[0] + span * np.arange(_MOST_LOADS) / _MOST_LOADS
    for part in parts:
        own = np.searchsorted(starts, load_n[part], side="right") - 1
        level[part] = np.where(known[part], own, -1)
    return level


def record_of(log: Log, channel: str | None = None) -> BenchRecord:
    """The bench record of one channel of a weights log.

    Parameters
    ----------
    log
        Experiment ``weights``; `Log.block` is the session.
    channel
        Which column; the only one where absent.
    """
    at = 0 if channel is None else log.channels.index(channel)
    load = log.known["load_n"]
    load = load if load.ndim == 1 else load[:, at]
    timed = bool(np.isfinite(log.time_s).all() and np.ptp(log.time_s) > 0)
    if timed:
        order = np.lexsort((log.time_s, log.block))
    elif "direction" in log.known:
        order = order_by_direction(load, log.known["direction"], log.block)
    else:
        order = np.argsort(log.block, kind="stable")
    warmth = log.known.get("temperature_degc")
    return BenchRecord(
        channel=log.channels[at],
        load_n=load[order],
        reading=log.readings[order, at],
        time_s=log.time_s[order] if timed else np.arange(len(log), dtype=float),
        session=log.block[order],
        temperature_degc=None if warmth is None else warmth.reshape(-1)[order],
        timed=timed,
    )


def order_by_direction(load_n: FloatArray, direction: FloatArray, block: IntArray) -> IntArray:
    """Order of a staircase that was logged without time: up by load, then down, per session.

    Parameters
    ----------
    load_n
        Shape (n,).
    direction
        +1 loading, −1 unloading, 0 unknown (taken as loading), shape (n,).
    block
        Session of each row, shape (n,).
    """
    down = direction < 0
    return np.lexsort((np.where(down, -load_n, load_n), down, block)).astype(np.int64)


def condense(record: BenchRecord, interval_s: float) -> BenchRecord:
    """Means over intervals of time, so that a dense recording becomes a few hundred rows.

    An interval never mixes two sessions, two loads, or known with unknown loads.
    """
    keep = np.isfinite(record.reading)
    record = record if keep.all() else record.select(keep)
    bins = np.floor((record.time_s - record.time_s.min()) / interval_s).astype(np.int64)
    level = load_levels(record.load_n)
    new = np.ones(len(record), dtype=bool)
    new[1:] = record.session[1:] != record.session[:-1]
    new[1:] |= (bins[1:] != bins[:-1]) | (level[1:] != level[:-1])
    del bins, level
    index = np.cumsum(new) - 1
    size = np.bincount(index).astype(float)

    def mean(values: FloatArray) -> FloatArray:
        return np.asarray(np.bincount(index, weights=values) / size, dtype=np.float64)

    warmth = record.temperature_degc
    load, first = mean(record.load_n), record.load_n[new]
    return replace(
        record,
        load_n=np.where(np.isclose(load, first, rtol=1e-12), first, load),
        reading=mean(record.reading),
        time_s=mean(record.time_s),
        session=record.session[new],
        temperature_degc=None if warmth is None else mean(warmth),
    )
