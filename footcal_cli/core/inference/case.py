"""What is asked of a real experiment, and which rows of its residual answer, in which blocks."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial

import numpy as np

from footcal_cli.core.chain import Chain, Seen
from footcal_cli.core.experiments import contract
from footcal_cli.core.experiments.contract import Experiment
from footcal_cli.core.inference.lines import Series
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.inference.tracking import Direction
from footcal_cli.core.inference.written import Written
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray, IntArray, ParameterSet
from footcal_cli.core.signals import begins, median_sd, starts_of

MOST_BLOCKS = 60
"""Blocks are merged beyond this number: more would not sharpen a p-value."""
_JUMP = 1.6
_SHORTEST_SERIES = 20


@dataclass(frozen=True)
class Case:
    """What is diagnosed.

    Parameters
    ----------
    experiment
        Its balance is the residual.
    logs
        Recordings; `Log.block` numbers the blocks within each.
    chain, values
        The model so far: calibration, and effects already accepted.
    calibration
        Parameters of the chain that the user calibrates anyway, with priors.
    tolerance_n, tolerance_nm
        Smallest RMS error that matters, of forces and of moments.
    drifts
        The calibration drifts along the recording: it is free in every block.
    alike
        Blocks are alike in content, so that they may be permuted.
    stride
        Every how many rows of a log the residual is judged (the chain sees all rows).
    groups
        Output -> name under which outputs are pooled (all swinging cells).
    one_recording
        Blocks were cut from one recording: conclusions hold for it only.
    directions
        Ways in which a drifting calibration wanders; it is free in every block where empty.
    demand_noisy
        What the experiment demands is measured too (a moving body) and shares the error.
    pieces
        Rows of a block are pieces of one observation, a stance.
    shared_blocks
        Blocks of the same number in different logs are one block (legs that hang together).
    setting_key
        Key of `Log.known` that numbers settings-up (hangings) whose offsets and gains differ.
    least_noise
        Channel -> noise that its converter's step alone makes, in the channel's physical unit.
    reading_noise_n
        Of a smoothed reading, as its raw readings show it, N.
    raw
        Channels as they were recorded where they should show nothing but noise, if the logs are
        filtered.
    tolerance_stated
        Whether the user said what matters: a usual imperfection is then no larger.
    finding_n, finding_nm
        RMS error of a force, and of a moment, from which what has no name is a finding; to name a
        cause needs less.
    known
        Precision with which the calibration was known before these logs, in the order of
        `calibration`, shape (p, p); None where these logs alone say what it is.
    written
        What the files call holes and weights.
    """

    experiment: Experiment
    logs: tuple[Log, ...]
    chain: Chain
    values: Mapping[str, float]
    calibration: ParameterSet
    tolerance_n: float
    tolerance_nm: float
    drifts: bool = False
    alike: bool = True
    stride: int = 1
    groups: Mapping[str, str] | None = None
    one_recording: bool = False
    directions: tuple[Direction, ...] = ()
    demand_noisy: bool = False
    pieces: bool = False
    shared_blocks: bool = False
    setting_key: str = ""
    least_noise: Mapping[str, float] = field(default_factory=dict)
    reading_noise_n: float = 0.0
    raw: Series | None = None
    tolerance_stated: bool = False
    finding_n: float = 0.0
    finding_nm: float = 0.0
    known: FloatArray | None = None
    written: Written = field(default_factory=Written)

    @cached_property
    def judged(self) -> tuple[Log, ...]:
        """The rows of each log that are judged."""
        return tuple(every(log, self.stride) for log in self.logs)

    def memory(self) -> tuple[Seen, ...]:
        """Room for what derivatives of each log compute on the way, for `residual`."""
        return tuple(Seen() for _ in self.logs)

    def recorded(
        self, number: int, chain: Chain, values: Mapping[str, float]
    ) -> tuple[Log, Callable[[Log], Log] | None]:
        """A log to remove a chain from, and what takes its judged rows then; None: it has those."""
        if self.stride > 1 and not chain.remembers(values):
            return self.judged[number], None
        return self.logs[number], partial(_judged, self, number)

    def truth(self, number: int, chain: Chain, values: Mapping[str, float], seen: Seen) -> Log:
        """The judged rows of a log from which a chain is removed."""
        log, judged = self.recorded(number, chain, values)
        truth = chain.truth(log, values, seen)
        return truth if judged is None else judged(truth)

    def extended(self, chain: Chain, values: Mapping[str, float]) -> Case:
        """The same recordings with another model."""
        return replace(self, chain=chain, values=dict(values))


def residual(
    case: Case,
    rows: Problem,
    values: Mapping[str, float],
    chain: Chain | None = None,
    only: Sequence[int] | None = None,
    seen: Sequence[Seen] | None = None,
) -> FloatArray:
    """The one residual's rows that count, in units of noise, shape (m,).

    Parameters
    ----------
    only
        Logs it is wanted of; it is zero on the others.
    seen
        From `Case.memory`, where many near-equal values are tried one after the other.
    """
    used = chain or case.chain
    out = np.zeros(rows.residual.size)
    for i in range(len(case.logs)) if only is None else only:
        of_log = None if seen is None else seen[i]
        log, judged = case.recorded(i, used, values)
        balance = contract.residual(case.experiment, used, log, values, of_log, judged)
        here, at = rows.places[i]
        out[here] = balance.error.ravel()[at]
    scaled = out / rows.noise
    # an extreme trial value may leave the balance undefined; it then says nothing
    finite = np.isfinite(scaled)
    return scaled if finite.all() else np.where(finite, scaled, 0.0)


def _judged(case: Case, number: int, truth: Log) -> Log:
    """The judged rows of a log from which a chain is removed; what it left is kept."""
    log, judged, stride = case.logs[number], case.judged[number], case.stride
    same = truth.time_s is log.time_s and truth.block is log.block
    if stride == 1 or not same or truth.known.keys() != log.known.keys():
        return every(truth, stride)
    if truth.known is log.known:
        return judged.with_readings(truth.readings[::stride])
    changed = {
        name: array[::stride].copy() for name, array in truth.known.items()
        if array is not log.known[name]
    }  # fmt: skip
    return judged.with_known(**changed).with_readings(truth.readings[::stride].copy())


def every(log: Log, stride: int) -> Log:
    """Every so many rows of a log."""
    if stride == 1:
        return log
    return replace(
        log,
        time_s=log.time_s[::stride].copy(),
        readings=log.readings[::stride].copy(),
        known={name: array[::stride].copy() for name, array in log.known.items()},
        block=log.block[::stride].copy(),
    )


def rows_of(case: Case) -> Problem:
    """Choose and order the rows of a case from its baseline; nothing explains them yet."""
    balances = [
        contract.residual(case.experiment, case.chain, log, case.values) for log in case.logs
    ]
    groups = case.groups or {}
    pooled = list(dict.fromkeys(groups.get(o, o) for b in balances for o in b.outputs))
    units = {groups.get(o, o): u for b in balances for o, u in zip(b.outputs, b.units, strict=True)}
    parts: list[tuple[IntArray, ...]] = []
    stamps: list[FloatArray] = []
    sequence = 0
    for i, (log, balance) in enumerate(zip(case.logs, balances, strict=True)):
        chosen = np.zeros(len(log), dtype=bool)
        chosen[:: case.stride] = True
        for k, name in enumerate(balance.outputs):
            rows = np.flatnonzero(chosen & balance.valid[:, k] & (log.block >= 0))
            if not rows.size:
                continue
            time = log.time_s[rows]
            step = float(np.median(np.diff(log.time_s))) * case.stride if len(log) > 1 else 1.0
            apart = np.diff(time, prepend=time[0] - 10 * step) > _JUMP * step
            cut = apart | (np.diff(log.block[rows], prepend=-1) != 0)
            numbers = sequence + np.cumsum(cut)
            sequence = int(numbers[-1]) + 1
            size = rows.size
            parts.append(
                (
                    np.full(size, i), rows, np.full(size, k), log.block[rows],
                    np.full(size, pooled.index(groups.get(name, name))), numbers,
                )
            )  # fmt: skip
            stamps.append(time)
    where = [np.concatenate(p).astype(np.int64) for p in zip(*parts, strict=True)]
    time = np.concatenate(stamps)
    pairs = np.stack([where[0] * (not case.shared_blocks), where[3]], axis=1)
    _, block = np.unique(pairs, axis=0, return_inverse=True)
    order = np.lexsort((np.arange(block.size), where[4], block))
    where = [w[order] for w in where]
    error, places = np.empty(order.size), []
    for i, balance in enumerate(balances):
        here = np.flatnonzero(where[0] == i)
        error[here] = balance.error[where[1][here], where[2][here]]
        at = (where[1][here] // case.stride) * balance.error.shape[1] + where[2][here]
        places.append((slice(None) if here.size == order.size else here, at))
    noise, least = np.ones(order.size), np.zeros(len(pooled))
    for o, name in enumerate(pooled):
        mine = where[4] == o
        steps = [s for c, s in case.least_noise.items() if groups.get(c, c) == name]
        floor = float(np.median(steps)) if steps else 0.0
        sd = max(_robust_sd(error[mine]), floor)
        noise[mine], least[o] = sd, floor / sd
    matters = [case.tolerance_nm if units[p] == "Nm" else case.tolerance_n for p in pooled]
    none = np.empty((order.size, 0))
    return Problem(
        residual=error / noise, calibration=none, columns=none, signatures=(),
        log=where[0], row=where[1], column=where[2], time_s=time[order], places=tuple(places),
        block=_merged(np.asarray(block)[order]), output=where[4], sequence=_renumbered(where[5]),
        outputs=tuple(pooled), units=tuple(units[p] for p in pooled), noise=noise, least=least,
        tolerance=np.array(matters), rate_hz=_rate_hz(where[5], time[order]),
        alike=case.alike, drifts=case.drifts, pieces=case.pieces, raw=case.raw,
    )  # fmt: skip


def _robust_sd(values: FloatArray) -> float:
    """Scale of an output, from the middle of its errors; its size where they are too few."""
    if values.size == 0:
        return 1.0
    spread = median_sd(values - np.median(values))
    return max(spread, 1e-3 * float(np.sqrt(np.mean(values**2))), 1e-12)


def _renumbered(sequence: IntArray) -> IntArray:
    """Sequences numbered in the order in which they stand."""
    return np.asarray(np.cumsum(begins(sequence)) - 1)


def _merged(block: IntArray) -> IntArray:
    """Neighbouring blocks merged until there are at most `MOST_BLOCKS`."""
    count = int(block.max()) + 1 if block.size else 0
    if count <= MOST_BLOCKS:
        return block
    return np.asarray((block * MOST_BLOCKS) // count)


def _rate_hz(sequence: IntArray, time_s: FloatArray) -> float:
    """Rate of the rows where sequences are long enough to be series, else 0."""
    starts = starts_of(sequence)
    lengths = np.diff(np.append(starts, sequence.size))
    if not lengths.size or np.median(np.repeat(lengths, lengths)) < _SHORTEST_SERIES:
        return 0.0
    steps = np.diff(time_s)[np.diff(sequence) == 0]
    steps = steps[steps > 0]
    return 1.0 / float(np.median(steps)) if steps.size else 0.0


def channels_of(logs: Sequence[Log]) -> tuple[str, ...]:
    """All channels in order of appearance."""
    return tuple(dict.fromkeys(c for log in logs for c in log.channels))
