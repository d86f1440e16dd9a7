"""A walk too long to be held: its streams read, merged and checked in parts."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import numpy as np

from footcal_cli.core.body_stream import check_overlap
from footcal_cli.core.online.belief import Belief
from footcal_cli.core.online.judged import in_band
from footcal_cli.core.online.merging import merge_cells
from footcal_cli.core.online.parts import AHEAD_S, BEFORE_S, ENOUGH_CYCLES, PART_S, WalkPart
from footcal_cli.core.online.streams import BodyStream, Merged, MergeRule, SensorStream
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.quality import Finding
from footcal_cli.core.signals import Clock, gaps_of, interpolate_stream
from footcal_cli.intake.cell_effects import cells_in_feet, without_cell_effects
from footcal_cli.intake.recordings import (
    Recording,
    note_carried,
    prior_belief,
    require_feet_of_cells,
)
from footcal_cli.intake.streams import body_stream_of, has_momentum, sensor_stream_of
from footcal_cli.intake.walk_length import pieces_of
from footcal_cli.intake.wiring import wiring_of
from footcal_cli.intake.zeros import use_zeros
from footcal_cli.session.inspection import over_pieces
from footcal_cli.tables.columns import TableType, body_table, cells_table, truth_table
from footcal_cli.tables.longfiles import give_back, rows_about
from footcal_cli.tables.table import Table, read_pieces

if TYPE_CHECKING:
    from footcal_cli.session.session import Session

_LONGEST_GAP = 5.0
"""Sampling periods of the truth across which it is interpolated."""
_AROUND_ROWS, _AROUND_S = 8, 5.0
"""Of the body stream, kept on both sides of a part."""
_MOST_KEPT = 2**16
"""Rows kept for checks of the whole walk; of longer ones every second, fourth …"""

AnyStream = TypeVar("AnyStream", SensorStream, BodyStream)
Read = Callable[[TableType, str], Iterable[Table]]


@dataclass
class _Stamps:
    """Stamps of a stream that is read piece by piece: what is dropped, where it begins and ends."""

    first_s: float = np.inf
    last_s: float = -np.inf
    duplicates: int = 0
    backward: int = 0
    gaps: int = 0
    longest_gap_s: float = 0.0
    missing: int = 0

    def increasing(self, stream: AnyStream) -> AnyStream:
        """The rows of the next piece whose stamps increase, as `clock_of` keeps them."""
        time_s = stream.time_s
        finite = np.where(np.isfinite(time_s), time_s, -np.inf)
        before = np.maximum.accumulate(np.concatenate([[self.last_s], finite]))[:-1]
        keep = time_s > before
        again = int(np.sum(time_s == before))
        self.duplicates += again
        self.backward += int(time_s.size - keep.sum() - again)
        kept = stream if keep.all() else _chosen(stream, keep)
        if kept.time_s.size:
            self.first_s = min(self.first_s, float(kept.time_s[0]))
            self.last_s = float(kept.time_s[-1])
        return kept

    def count_gaps(self, time_s: FloatArray, start: int, stop: int) -> None:
        """Take in the gaps after rows ``start:stop``."""
        interval = np.diff(time_s)
        at = gaps_of(time_s)
        long = interval[at[(at >= start) & (at < stop)]]
        period = float(np.median(interval))
        self.gaps += long.size
        self.longest_gap_s = max(self.longest_gap_s, float(long.max(initial=0.0)))
        self.missing += int(np.sum(np.round(long / period) - 1))

    def clock(self, like: Clock) -> Clock:
        """Of the whole stream."""
        return replace(
            like, duplicates=self.duplicates, backward=self.backward, gaps=self.gaps,
            longest_gap_s=self.longest_gap_s, missing=self.missing,
        )  # fmt: skip


def _chosen(stream: AnyStream, at: Any) -> AnyStream:
    """Some rows of a stream."""
    changes: dict[str, Any] = {
        f.name: getattr(stream, f.name)[at]
        for f in fields(stream)
        if isinstance(getattr(stream, f.name), np.ndarray)
    }
    return replace(stream, **changes)


def _joined(streams: list[AnyStream]) -> AnyStream:
    """Pieces of a stream that follow each other as one."""
    if len(streams) == 1:
        return streams[0]
    changes: dict[str, Any] = {
        f.name: np.concatenate([getattr(one, f.name) for one in streams])
        for f in fields(streams[0])
        if isinstance(getattr(streams[0], f.name), np.ndarray)
    }
    return replace(streams[0], **changes)


@dataclass
class _Kept:
    """Every so many-th row of a stream, for checks of the whole."""

    rows: FloatArray | None = None
    every: int = 1
    seen: int = 0

    def add(self, values: FloatArray) -> None:
        """Take in the next rows."""
        chosen = values[(-self.seen) % self.every :: self.every]
        self.rows = chosen if self.rows is None else np.concatenate([self.rows, chosen])
        while len(self.rows) > _MOST_KEPT:
            self.rows, self.every = self.rows[::2], 2 * self.every
        self.seen += len(values)


@dataclass
class LongWalk:
    """The streams of one walk, read once from beginning to end.

    Parameters
    ----------
    session, rule
        As `footcal_cli.intake.recordings.read_recordings`.
    update_hz
        Rate of the filter's updates: parts begin with one.
    read
        Where pieces of logs come from; the session's own, which keeps what it reads.
    truth
        File of the true cell forces, None where there is none.
    """

    session: Session[Any]
    rule: MergeRule
    update_hz: float
    read: Read
    truth: Path | None = None
    belief: Belief | None = None
    _places: tuple[FloatArray, ...] = ()
    _state: Any = None
    _widened: tuple[FloatArray, FloatArray] | None = None
    _cells: _Stamps = field(default_factory=_Stamps)
    _body: _Stamps = field(default_factory=_Stamps)
    _start_n: _Kept = field(default_factory=_Kept)
    _names: dict[str, str] = field(default_factory=dict)
    _said: list[list[Finding]] = field(default_factory=list)
    _no_momentum: bool = False

    @classmethod
    def of(
        cls, session: Session[Any], rule: MergeRule, update_hz: float, truth: Path | None
    ) -> LongWalk:
        """The walk that the command runs; what is read is kept in the session."""
        return cls(session, rule, update_hz, session.pieces, truth)

    def again(self) -> LongWalk:
        """The same walk read for itself, from its beginning."""

        def read(table: TableType, role: str) -> Iterator[Table]:
            path = self.session.only_log(table, role)
            assert path is not None, "is_long_walk has found it"
            return pieces_of(self.session, path, table)

        return LongWalk(self.session, self.rule, self.update_hz, read)

    def teacher(self, *, causal: bool) -> tuple[WalkPart, Belief]:
        """The first part with gait cycles enough to learn from, else the one with most of them.

        A live run can learn from its beginning alone.
        """
        streams = self.again()
        best: WalkPart | None = None
        for part in streams.parts():
            if best is None or part.cycles > best.cycles:
                best = part
            if causal or best.cycles >= ENOUGH_CYCLES:
                break
        assert best is not None, "a stream has a part"
        assert streams.belief is not None, "a part was read"
        return best, streams.belief

    @property
    def samples(self) -> float | None:
        """About how many the sensors' log has."""
        path = self.session.only_log(cells_table(self.session.recipe.robot.cell_names), "cells")
        return None if path is None else rows_about(path)

    @property
    def feet(self) -> tuple[str, ...]:
        """Names of the feet."""
        return tuple(self.session.recipe.robot.feet)

    def parts(self) -> Iterator[WalkPart]:
        """The walk part by part, each with what lies around it."""
        robot = self.session.recipe.robot
        require_feet_of_cells(robot, self.session.recipe.path)
        body, cells = _Ahead(self._bodies()), _Ahead(self._sensors())
        truth = None if self.truth is None else _Ahead(self._truths(self.truth))
        time_s = cells.first().time_s
        rate_hz = 1.0 / float(np.median(np.diff(time_s)))
        every = max(round(rate_hz / self.update_hz), 1)
        updates = (round(length * rate_hz / every) for length in (BEFORE_S, PART_S, AHEAD_S))
        lead, own, tail = (max(count, 1) * every for count in updates)
        start = 0
        while True:
            whole = cells.rows_until(start + own + 2 * tail)
            rest = len(whole.time_s) - start
            last = cells.ended and rest <= own + tail
            stop = start + (rest if last else own)
            window = whole if last else _chosen(whole, slice(0, stop + tail))
            assert self.belief is not None
            assert robot.mass_kg is not None
            motion = body.between(
                float(window.time_s[0]) - _AROUND_S, float(window.time_s[-1]) + _AROUND_S
            )
            merged = merge_cells(
                window, motion, self.belief, self._places, robot.mass_kg, robot.gravity_mps2,
                rule=self.rule,
            )  # fmt: skip
            self._cells.count_gaps(window.time_s, start, stop)
            own_body = (motion.time_s >= window.time_s[start]) & (
                motion.time_s <= window.time_s[stop - 1]
            )
            at = np.flatnonzero(own_body)
            if at.size:
                self._body.count_gaps(motion.time_s, int(at[0]), int(at[-1]) + 1)
            true_n = None if truth is None else self._true(truth, merged)
            part = WalkPart(merged, start, stop, true_n)
            if part.cycles >= ENOUGH_CYCLES:  # standing tells no cell from another
                self._said.append(wiring_of(part.own, self.belief, "walk"))
            made = [part]
            del window, whole, motion, merged, true_n, part
            # nothing of a part is held here while the next one is read
            yield made.pop()
            give_back()
            if last:
                return
            cells.drop(max(stop - lead, 0))
            start = min(stop, lead)

    def _sensors(self) -> Iterator[SensorStream]:
        """Pieces of the sensors' stream, effects of the calibration undone, stamps increasing."""
        session, robot = self.session, self.session.recipe.robot
        for table in self.read(cells_table(robot.cell_names), "cells"):
            stream = sensor_stream_of(table, robot.cell_names, (), robot.adc.lost_reading)
            if self.belief is None:
                zeros = use_zeros(session, robot.cell_names)
                self.belief = prior_belief(session.parameters, robot, robot.cell_names, zeros)
                self._places = cells_in_feet(robot)
                self._names["cells"] = table.path.name
            start = self.belief
            if session.parameters is not None:
                warmth = table.number("temperature_degc") if "temperature_degc" in table else None
                undone = without_cell_effects(
                    stream, session.parameters, robot, warmth, self._state
                )
                stream, self._places, self._state = undone.stream, undone.cells_m, undone.state
                if self._widened is None:
                    self._widened = undone.gain_sd, undone.bias_sd_n
                    self.belief = self.belief.widened(*self._widened)
                    self._said.append(list(undone.findings))
            self._start_n.add(start.scale_n_per_count * stream.readings + start.bias_n)
            yield self._cells.increasing(stream)

    def _bodies(self) -> Iterator[BodyStream]:
        """Pieces of the body's stream, stamps increasing."""
        for table in self.read(body_table(self.feet), "body"):
            self._names["body"] = table.path.name
            self._no_momentum = not has_momentum(table)
            yield self._body.increasing(body_stream_of(table, self.feet))

    def _truths(self, path: Path) -> Iterator[SensorStream]:
        """Pieces of the true cell forces."""
        robot = self.session.recipe.robot
        kind = truth_table(robot.cell_names)
        for table in read_pieces(path, kind, {}, gravity_mps2=robot.gravity_mps2):
            self.session.inputs[path.name] = table.digest
            values = table.numbers([f"{cell}_n" for cell in robot.cell_names])
            yield SensorStream(table.number("time_s"), values, robot.cell_names)

    def _true(self, truth: _Ahead[SensorStream], merged: Merged) -> FloatArray:
        """True cell forces at the samples, in the band of the cells, NaN where unknown, (n, c)."""
        time_s = merged.log.time_s
        known = truth.between(float(time_s[0]), float(time_s[-1]))
        longest = _LONGEST_GAP * float(np.median(np.diff(known.time_s)))
        values, good = interpolate_stream(known.time_s, known.readings, time_s, max_gap_s=longest)
        values = np.where(good[:, None], values, np.nan)
        return in_band(values, merged.rate_hz, causal=self.rule.causal)

    def recording(self, last: Merged) -> Recording:
        """What the whole walk was read as, once all parts are; findings go to the session."""
        session = self.session
        start_n, name = self._start_n.rows, self._names["cells"]
        assert start_n is not None, "no part was read"
        note_carried(session, start_n, name, walking=True)
        beside = self._names["body"]
        cells, body = (np.array([one.first_s, one.last_s]) for one in (self._cells, self._body))
        other = beside if beside != name else "its body stream"
        session.note(check_overlap(cells, body, name, other))
        session.note(over_pieces(self._said))
        merged = replace(
            last,
            sensor_clock=self._cells.clock(last.sensor_clock),
            body_clock=self._body.clock(last.body_clock),
        )
        return Recording(merged, self.belief, self.feet, name, False, self._no_momentum)


class _Ahead(Generic[AnyStream]):
    """Pieces of a stream, read as far as they are wanted and dropped once they are not."""

    def __init__(self, pieces: Iterator[AnyStream]) -> None:
        self._pieces: Iterator[AnyStream] = pieces
        self._held: list[AnyStream] = []
        self.ended = False

    def first(self) -> AnyStream:
        """The first piece that has rows enough to tell a rate."""
        return self.rows_until(4)

    def rows_until(self, rows: int) -> AnyStream:
        """What is held, at least so many rows unless the stream ends before."""
        while not self.ended and sum(len(one.time_s) for one in self._held) <= rows:
            self._more()
        self._held = [_joined(self._held)]
        return self._held[0]

    def between(self, start_s: float, stop_s: float) -> AnyStream:
        """Rows of a time and some around it; earlier ones are dropped."""
        while not self.ended and not (self._held and self._held[-1].time_s[-1:] > stop_s):
            self._more()
        held = _joined(self._held)
        first = max(int(np.searchsorted(held.time_s, start_s)) - _AROUND_ROWS, 0)
        first = min(first, max(len(held.time_s) - 2 * _AROUND_ROWS, 0))
        held = _chosen(held, slice(first, None))
        self._held = [held]
        last = int(np.searchsorted(held.time_s, stop_s)) + _AROUND_ROWS
        return _chosen(held, slice(0, max(last, 2 * _AROUND_ROWS)))

    def drop(self, rows: int) -> None:
        """Forget the first rows."""
        self._held = [_chosen(_joined(self._held), slice(rows, None))]

    def _more(self) -> None:
        piece = next(self._pieces, None)
        if piece is None:
            self.ended = True
        else:
            self._held.append(piece)
