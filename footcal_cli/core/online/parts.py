"""A walk of any length in parts, so that memory does not grow with it.

The filter hands its state on from part to part: its track is that of the whole walk, to rounding.
Delay, noise and the states that are believed in are learnt in one part; the smoother of each part
starts from the filter's state and sees `AHEAD_S` beyond the part's end. Where the delay is to be
found, the rows of each part are linearised about the delay at its start, so that clocks may drift
apart by more than the model of one part could hold.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.contact import gait_cycles
from footcal_cli.core.online.belief import Belief
from footcal_cli.core.online.comparison import (
    InParts,
    ReplayedWalk,
    ReplaySettings,
    judged_walk,
    with_statistics,
)
from footcal_cli.core.online.evidence import SETTLING_S, Consistency, Repeats, repeats
from footcal_cli.core.online.filter import Track, WalkNoise, track_of
from footcal_cli.core.online.judged import Judged, References
from footcal_cli.core.online.jumps import BiasJump, JumpBank
from footcal_cli.core.online.live import run_live
from footcal_cli.core.online.memory import (
    Memory,
    gait_phase,
    run_memory,
    sized_jumps,
    walk_rows,
    within_band,
)
from footcal_cli.core.online.passes import Pass, open_biases
from footcal_cli.core.online.reference_states import REFERENCE_STATES, advanced
from footcal_cli.core.online.rows import Rows
from footcal_cli.core.online.smoother import run_smoother
from footcal_cli.core.online.streams import Merged
from footcal_cli.core.online.tuning import Tuning
from footcal_cli.core.parameters import Estimates, FloatArray

PART_S = 300.0
"""Length of a part."""
BEFORE_S, AHEAD_S = 10.0, 60.0
"""What a part sees before its start and beyond its end: filters and contact have settled, and the
smoother knows what comes."""
ENOUGH_CYCLES = 20
"""Gait cycles from which a part teaches delay and noise."""
_MOST_UPDATES = 40_000
"""Updates kept for tables and figures; of longer walks every second, fourth …"""
_NO_TIME_S = 1e-9
"""Leaves out the update that a part takes over from the one before."""
_MOVED_S = 2e-4
"""A delay that has moved by less stays as it is."""


@dataclass(frozen=True)
class WalkPart:
    """A part of a walk with what lies around it.

    Parameters
    ----------
    merged
        The part, and samples before and after it.
    start, stop
        Its own samples; `start` is a multiple of the samples per update.
    truth_n
        True cell forces at all samples, low-passed as the cells are, shape (n, c); None where there
        is no truth.
    """

    merged: Merged
    start: int
    stop: int
    truth_n: FloatArray | None = None

    @property
    def own(self) -> Merged:
        """The part alone."""
        return self.merged.part(self.start, self.stop)

    @property
    def cycles(self) -> int:
        """Gait cycles that begin in it."""
        return int(gait_cycles(self.own.log.known["contact"]).max(initial=-1)) + 1


@dataclass
class _Seam:
    """What one part hands to the next.

    Parameters
    ----------
    live, past
        Mean and covariance of the filter, and of the pass that the smoother goes back over: it
        knows the jumps beforehand.
    track, smoothed
        Their last update.
    delay_s
        About which the rows were linearised.
    cycle
        Gait cycle of the last sample.
    """

    live: tuple[FloatArray, FloatArray]
    past: tuple[FloatArray, FloatArray]
    bank: JumpBank | None
    track: Track
    smoothed: Track
    delay_s: float
    cycle: int


@dataclass(frozen=True)
class _Learnt:
    """What one part teaches for all of them.

    Parameters
    ----------
    delay_s, noise, tuning, band_hz
        As in `footcal_cli.core.online.memory.Memory`.
    names, prior_sd
        States that are believed in.
    live
        Track of a live run over that part, else None.
    """

    delay_s: float
    noise: WalkNoise
    tuning: Tuning | None
    names: tuple[str, ...]
    prior_sd: FloatArray
    band_hz: float
    live: Track | None

    @classmethod
    def of(cls, memory: Memory, *, live: bool) -> _Learnt:
        """From a run over the part."""
        rows, track = memory.rows, memory.track if live else None
        return cls(
            memory.delay_s, memory.noise, memory.tuning, rows.names, rows.prior_sd, memory.band_hz,
            track,
        )  # fmt: skip


class WalkInParts:
    """A walk that is taken in part by part.

    Parameters
    ----------
    belief, settings, baseline
        As `footcal_cli.core.online.comparison.compare`; the papers' methods do not run.
    teacher
        The part from which delay, noise and states are learnt; the first one where `settings` are
        causal.
    """

    def __init__(
        self,
        belief: Belief,
        settings: ReplaySettings,
        teacher: WalkPart,
        baseline: Estimates | None = None,
    ) -> None:
        self.belief, self.settings, self.baseline = belief, settings, baseline
        run = run_live if settings.causal else run_memory
        memory = run(teacher.own.log, belief, settings.memory)
        self._learnt = _Learnt.of(memory, live=settings.causal)
        self.taught_from_s = float(teacher.own.log.time_s[0])
        self._seam: _Seam | None = None
        self._repeats: Repeats | None = None
        self._thinned: Track | None = None
        self._every, self._updates, self._used = 1, 0, 0
        self._judged: dict[tuple[str, str], Judged] = {}
        self._rejected: dict[str, int] = {}
        self._consistency: list[Consistency] = []
        self._jumps: list[BiasJump] = []
        self._last: ReplayedWalk | None = None
        self.parts = 0

    @property
    def noise(self) -> WalkNoise:
        """That was learnt."""
        return self._learnt.noise

    def take(self, part: WalkPart) -> ReplayedWalk:
        """Run the next part; its samples replayed and judged, without statistics over cycles."""
        self._last = None  # it may go: another one comes
        seam, options = self._seam, self.settings.memory
        delay_s = self._delay_at(seam)
        log = advanced(part.merged.log, delay_s)
        states = tuple(name for name in REFERENCE_STATES if name in self._learnt.names)
        hindsight = not self.settings.causal
        rows = walk_rows(log, self.belief, replace(options, states=states, hindsight=hindsight))
        unneeded = ~np.isin(rows.names, self._learnt.names)
        rows = rows.without(unneeded) if unneeded.any() else rows
        rows = within_band(rows, self._learnt.band_hz)
        first = part.start // options.samples_per_update
        stop = first + (part.stop - part.start) // options.samples_per_update
        phase = gait_phase(log, rows)[first:stop]
        passes = _Passes.over(rows, first, stop, self, seam)
        track, smoothed, jumps = passes.track, passes.smoothed, passes.jumps
        if seam is None and self.settings.causal:
            track = self._learnt.live or track
            jumps = track.jumps
            self._learnt = replace(self._learnt, live=None)
        skip_s = SETTLING_S if seam is None else -1.0
        again = repeats(track, phase, rows.totals, skip_s=skip_s)
        self._repeats = again if self._repeats is None else self._repeats + again
        known_to = len(rows.names) if np.isfinite(self._learnt.band_hz) else None
        factor = self._repeats.factor(known_to)
        known = track if seam is None and self.settings.causal else track.inflated(factor)
        smoothed = smoothed.inflated(factor)
        self._jumps += jumps
        self._keep(known, delay_s, rows.names)
        cycle = gait_cycles(log.known["contact"])
        if seam is not None:
            cycle = cycle + (seam.cycle - cycle[part.start - 1])
        own = slice(part.start, part.stop)
        shown, back = known, smoothed
        if seam is not None:
            # until the first update of the part, the last one of the part before holds
            shown, back = seam.track.followed_by(known), seam.smoothed.followed_by(smoothed)
            first -= 1
        memory = Memory(
            _from_sample(rows.part(first, stop), part.start), shown, back, jumps,
            self._learnt.tuning, self._learnt.noise, factor, delay_s,
            known.at_end("robot.delay")[1], log.rows(part.start, part.stop), self._learnt.band_hz,
        )  # fmt: skip
        settled = np.ones(part.stop - part.start, dtype=bool)
        if seam is None:
            settled = memory.log.time_s - memory.log.time_s[0] > SETTLING_S
        truth_n = None if part.truth_n is None else part.truth_n[own]
        found = judged_walk(
            memory, part.own, self.belief, self.settings,
            References(truth_n, self.baseline), cycle[own], settled,
            skip_s=2.0 if seam is None else _NO_TIME_S,
        )  # fmt: skip
        self._seam = _Seam(
            passes.live, passes.past, passes.bank, known.chosen(slice(-1, None)),
            smoothed.chosen(slice(-1, None)), delay_s, int(cycle[part.stop - 1]),
        )  # fmt: skip
        self._add(found, track)
        return found

    def finish(self, rng: np.random.Generator) -> ReplayedWalk:
        """The whole walk: sums over all parts; samples and figures of CoP and force of the last."""
        last = self._last
        track = self._thinned
        if last is None or track is None:
            raise ValueError("no part was taken")
        if "robot.delay" in track.names:
            values = track.values.copy()
            values[:, track.names.index("robot.delay")] -= last.memory.delay_s
            track = replace(track, values=values)
        track = replace(track, jumps=tuple(self._jumps))
        whole = replace(
            last,
            memory=replace(last.memory, track=track, jumps=tuple(self._jumps)),
            judged=tuple(self._judged.values()),
            rejected=self._rejected,
            taught=(self._used, self._updates),
            consistency=Consistency.joined(self._consistency),
            in_parts=InParts(self.parts, PART_S, AHEAD_S, self.taught_from_s, self._every),
        )
        return with_statistics(whole, rng)

    def _delay_at(self, seam: _Seam | None) -> float:
        """Delay about which the next rows are linearised; the states at the seam move with it."""
        if seam is None:
            return self._learnt.delay_s
        names = seam.track.names
        if not self.settings.memory.align or "robot.delay" not in names:
            return seam.delay_s
        at = names.index("robot.delay")
        step = float(seam.track.values[-1, at])
        if abs(step) < _MOVED_S:
            return seam.delay_s
        unit = self._learnt.prior_sd[self._learnt.names.index("robot.delay")]
        for mean, _ in (seam.live, seam.past):
            mean[at] -= step / unit
        for track in (seam.track, seam.smoothed):
            track.values[:, at] -= step
        return seam.delay_s + step

    def _keep(self, track: Track, delay_s: float, names: tuple[str, ...]) -> None:
        """Keep every so many-th update, and the last one."""
        if "robot.delay" in names:
            values = track.values.copy()
            values[:, names.index("robot.delay")] += delay_s
            track = replace(track, values=values)
        size = track.time_s.size
        number = np.arange(self._updates, self._updates + size)
        chosen = track.chosen((number % self._every == 0) | (number == number[-1]))
        kept = self._thinned
        self._thinned = chosen if kept is None else kept.followed_by(chosen)
        while self._thinned.time_s.size > _MOST_UPDATES:
            at = np.arange(self._thinned.time_s.size)
            self._thinned = self._thinned.chosen((at % 2 == 0) | (at == at[-1]))
            self._every *= 2
        self._updates += size

    def _add(self, found: ReplayedWalk, track: Track) -> None:
        """Take the part's sums in."""
        for one in found.judged:
            key = (one.method, one.reference)
            before = self._judged.get(key)
            self._judged[key] = one if before is None else before.followed_by(one)
        for reason, count in found.rejected.items():
            self._rejected[reason] = self._rejected.get(reason, 0) + count
        self._consistency.append(found.consistency)
        self._used += int(track.used.sum())
        self._last = found
        self.parts += 1


@dataclass(frozen=True)
class _Passes:
    """The filter and the smoother over one part, and where they have come to."""

    track: Track
    smoothed: Track
    jumps: tuple[BiasJump, ...]
    live: tuple[FloatArray, FloatArray]
    past: tuple[FloatArray, FloatArray]
    bank: JumpBank | None

    @classmethod
    def over(
        cls, rows: Rows, first: int, stop: int, walk: WalkInParts, seam: _Seam | None
    ) -> _Passes:
        """Run both over updates ``first:stop`` of the rows."""
        guards, noise = walk.settings.memory.guards, walk.noise
        own, ahead = rows.part(first, stop), rows.part(first, len(rows))
        whole = Pass.begin(rows, noise, ())
        filtered = whole.part(first, stop)
        if seam is None:
            bank = JumpBank.start(own, filtered.mean.size, guards)
        else:
            filtered.mean, filtered.cov = seam.live
            bank = None if seam.bank is None else seam.bank.moved_on(own)
        track = track_of(own, filtered, filtered.run(own, guards, bank), bank)
        # jumps that come soon, and those near the end that only later updates prove
        coming = whole.part(stop, len(rows))
        coming.mean, coming.cov = filtered.mean.copy(), filtered.cov.copy()
        later = rows.part(stop, len(rows))
        next_bank = None if bank is None else bank.moved_on(later)
        coming.run(later, guards, next_bank)
        known = [*track.jumps, *([] if next_bank is None else next_bank.found)]
        begun = whole.part(first, len(rows))
        if seam is not None:
            begun.mean, begun.cov = (state.copy() for state in seam.past)
        # one from before the start was opened in the part before
        open_biases(begun.drive, ahead, [j for j in known if j.onset_s >= ahead.time_s[0]])
        going = begun.part(0, stop - first)
        going.run(own, guards)
        smoothed = run_smoother(ahead, noise, guards, begun=begun)
        return cls(
            track,
            smoothed.chosen(slice(0, stop - first)),
            sized_jumps(track.jumps, smoothed),
            (filtered.mean, filtered.cov),
            (going.mean, going.cov),
            bank,
        )


def _from_sample(rows: Rows, start: int) -> Rows:
    """The rows, samples counted from `start` on."""
    return replace(rows, last_sample=rows.last_sample - start)
