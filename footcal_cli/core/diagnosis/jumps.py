"""A channel at rest that jumps: what a tugged cable or a guide that jams leaves between steps.

A cell in the air reads nothing but its offset, and offsets wander slowly. From one swing to the
next they move by little, and by as much at any time; a jump of many times that much is no drift.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core import chances
from footcal_cli.core.inference.linear import left_by
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.parameters import FloatArray, IntArray

SWINGS = (1, 2, 4)
"""Swings that are averaged on both sides of a jump."""
_RCOND = 1e-9
_ROUNDS = 3
_SHOWN = 1e-4
"""Share of a step's squares beside what is fitted, from which it is not one of these columns."""
_FEWEST = 8
"""Differences asked for: of fewer nobody knows what is usual."""
_FEWEST_FREE = 4
"""Loads less all coefficients, of which the scatter about a line with a step is known."""
_ROUNDED = 1e-6
_BROKEN = 2.5
"""A swing ends where rows are further apart than this many samples."""
_NORMAL = 1.4826  # sd of a normal variable over its median |x|
_STEP = np.sqrt(12.0)  # of a converter over the sd of its rounding
_OFTEN = 0.9
"""A coarse reading stands, and now and then is a step off: its noise shows in the
largest tenth of all differences, not in half of them."""
_MEDIAN_EFFICIENCY = 0.37  # of a median-based variance against the mean square


@dataclass(frozen=True)
class Jump:
    """The largest jump of what rests.

    Parameters
    ----------
    p
        By chance, of all that were looked at (Bonferroni).
    after_s, before_s
        Between which stamps of the problem it happened; not numbers where nothing rests.
    usual, unit
        Sd by which that channel differs from one swing to the next, and its output's unit.
    size
        In units of what is usual.
    left
        Sum of squares of means of blocks about a line with this step.
    share
        Of the squares of that output's means without the step, what it explains.
    matters
        Whether a calibration that stands in its middle is off by what matters (RMS of all blocks).
    """

    p: float = 1.0
    after_s: float = np.nan
    before_s: float = np.nan
    usual: float = 0.0
    unit: str = ""
    size: float = 0.0
    left: float = np.inf
    share: float = 0.0
    matters: bool = True

    def is_small_beside(self, other: Jump, share: float) -> bool:
        """Whether it is at most a share of the other one.

        A mount that settles after a tug leaves small jumps beside and after the step named for it.
        """
        mine, whole = self.size, other.size
        if self.unit == other.unit and other.usual > 0.0:
            # what a named jump hid in its own channel's usual steps is gone
            mine, whole = mine * self.usual, whole * other.usual
        return mine <= share * whole


def jump_beside(problem: Problem, fitted: FloatArray) -> Jump:
    """The largest jump of what the best calibration of some row columns, shape (m, k), leaves."""
    return largest_jump(problem, left_by(fitted, problem.residual, _RCOND))


def once_beside(problem: Problem, fitted: FloatArray) -> Jump:
    """`jump_beside` where channels rest in between, `step_beside` where loads are put on them."""
    return jump_beside(problem, fitted) if problem.drifts else step_beside(problem, fitted)


def step_beside(problem: Problem, fitted: FloatArray) -> Jump:
    """The largest step from one load to the next in what some row columns, shape (m, k), leave.

    The mean residual of each load against the columns' means with a step of one output added:
    ``F = (RSS − RSS_step) / (RSS_step / ν) ~ F(1, ν)``, Bonferroni over all steps. A reading that
    drifts gives a step as well, and others beside it. Outputs of a sensor held in one attitude
    after the other, and of a robot in one stance after the other, are each in units of what the
    step leaves there, by the loads less what the columns fit of that output alone (ν): an output
    whose scatter they take up shows no step. Where neighbours are alike (correlation r from one
    load to the next) the loads are worth ``(1 − r) / (1 + r)`` of their number, as for any mean.
    """
    several = len(problem.outputs) > 1 or problem.settings is not None
    apart = is_one_stream(problem) or problem.pieces
    if problem.traces is None or (several and not apart):
        return Jump()
    blocks, seen = problem.blocks, _in_every_block(problem)
    outputs = seen.size
    if not outputs:
        return Jump()
    mean = means_of_blocks(problem, np.column_stack([problem.residual, fitted]))
    mean = mean.reshape(blocks, len(problem.outputs), -1)[:, seen].reshape(blocks * outputs, -1)
    unit, whole = np.ones(outputs), np.repeat(np.arange(blocks - 1, 0, -1), outputs)
    for _ in range(_ROUNDS if outputs > 1 else 1):
        of_row = np.tile(unit, blocks)
        scaled = mean / of_row[:, None]
        onto, size, _ = np.linalg.svd(scaled[:, 1:], full_matrices=False)
        onto = onto[:, size > _RCOND * size.max(initial=0.0)]
        free = blocks - 1.0 - taken_from_each(onto, outputs)
        sure = free > _FEWEST_FREE - _ROUNDED
        if not sure.any():
            return Jump()
        rest = scaled[:, 0] - onto @ (onto.T @ scaled[:, 0])
        known = _from_each_on(onto, outputs)
        energy = whole - np.sum(known**2, axis=1)
        along = _from_each_on(rest[:, None], outputs)[:, 0]
        seen_step = (energy > _SHOWN * whole) & np.tile(sure, blocks - 1)
        taken = np.where(seen_step, along**2 / np.maximum(energy, _RCOND), 0.0)
        best = int(np.argmax(taken))
        at, output = divmod(best, outputs)
        step = np.zeros((blocks, outputs))
        step[at + 1 :, output] = 1.0
        step_left = step.ravel() - onto @ known[best]
        most = along[best] / max(float(energy[best]), _RCOND)
        left = rest - most * step_left
        squares = np.sum(left.reshape(blocks, outputs) ** 2, axis=0)
        rms = np.sqrt(squares[sure] / free[sure])
        unit[~sure] *= float(np.sqrt(squares[sure].sum() / free[sure].sum()))
        unit[sure] *= np.maximum(rms, _RCOND * rms.max())
    mine = left.reshape(blocks, outputs)[:, output]
    own = max(float(mine @ mine), 1e-300)
    usual, alike = np.sqrt(own / free[output]), max(0.0, float(mine[1:] @ mine[:-1]) / own)
    longer = (1.0 + alike) / (1.0 - alike)
    f, nu = taken[best] / usual**2 / longer, free[output] / longer
    time_s = problem.traces.time_s
    before, after = (time_s[problem.block == b] for b in (at, at + 1))
    noise = float(np.mean(problem.noise[problem.output == seen[output]]))
    later = 1.0 - (at + 1) / blocks
    moved = abs(float(most)) * float(of_row[output]) * noise * np.sqrt(later * (1.0 - later))
    return Jump(
        p=min(1.0, taken.size * float(chances.f_sf(f, 1, nu))),
        after_s=float(before.min()),  # under which of the two loads, or in between
        before_s=float(after.max()),
        usual=usual * float(of_row[output]) * noise,
        unit=problem.units[seen[output]],
        size=abs(float(most)) / usual,
        left=float(np.sum((left * of_row) ** 2)),
        share=float(taken[best] / max(taken[best] + own, 1e-300)),
        matters=bool(moved >= problem.tolerance[seen[output]]),
    )


def _in_every_block(problem: Problem) -> IntArray:
    """Outputs of which every block has rows: a foot is in the air in some stances only."""
    outputs = len(problem.outputs)
    at = problem.block * outputs + problem.output
    rows = np.bincount(at, minlength=problem.blocks * outputs).reshape(-1, outputs)
    return np.flatnonzero((rows > 0).all(axis=0))


def is_one_stream(problem: Problem) -> bool:
    """Whether every block is a setting of its own: attitudes held one after the other."""
    settings = problem.settings
    return settings is not None and int(settings.number.max(initial=0)) + 1 == problem.blocks


def _from_each_on(columns: FloatArray, outputs: int) -> FloatArray:
    """Sums over all later blocks, (B · outputs, k) to ((B − 1) · outputs, k)."""
    by_block = columns.reshape(-1, outputs, columns.shape[1])
    later = np.cumsum(by_block[::-1], axis=0)[::-1][1:]
    return np.asarray(later.reshape(-1, columns.shape[1]))


def taken_from_each(basis: FloatArray, outputs: int) -> FloatArray:
    """Numbers that an orthonormal basis (B · outputs, k) fits to each output, (outputs,)."""
    return np.asarray(np.sum(basis**2, axis=1).reshape(-1, outputs).sum(axis=0))


def means_of_blocks(problem: Problem, columns: FloatArray) -> FloatArray:
    """Means of row columns, shape (m, k), over each block and output, shape (B · outputs, k)."""
    outputs = len(problem.outputs)
    at = problem.block * outputs + problem.output
    rows = np.maximum(np.bincount(at, minlength=problem.blocks * outputs), 1)
    sums = np.zeros((rows.size, columns.shape[1]))
    np.add.at(sums, at, columns)
    return np.asarray(sums / rows[:, None])


def largest_jump(problem: Problem, residual: FloatArray) -> Jump:
    """The largest jump of any channel at rest, and of their mean.

    Differences of neighbouring means over 1, 2 and 4 swings, over the usual difference: of this
    channel, of all channels or of the converter's steps, whichever is largest.

    Parameters
    ----------
    problem
        Rows; channels that share an output are looked at where their foot is in the air.
    residual
        What is left, shape (m,).
    """
    swings = list(_swings(problem, residual))
    rounded = max((swing.rounded for swing in swings), default=0.0)
    found, tests = Jump(), 0.0
    for count in SWINGS:
        seen = [s for s in swings if len(s.mean) >= 2 * count + _FEWEST]
        steps = [_differences(s.mean, count) for s in seen]
        if not steps:
            continue
        usual = [_NORMAL * np.median(np.abs(step), axis=0) for step in steps]
        cells = _of_all(np.concatenate([step[:, :-1].ravel() for step in steps]), rounded)
        means = _of_all(np.concatenate([step[:, -1] for step in steps]), 0.5 * rounded)
        # neighbouring differences share swings
        known = sum(step[:, :-1].size for step in steps) / (1.0 + 0.5 * count)
        for swing, step, own in zip(seen, steps, usual, strict=True):
            common = np.append(np.full(own.size - 1, cells), means)
            size = np.abs(step) / np.maximum(np.maximum(own, common), 1e-12)
            at, channel = (int(i) for i in np.unravel_index(np.argmax(size), size.shape))
            p = 2.0 * float(chances.t_sf(size.max(), _MEDIAN_EFFICIENCY * known))
            if p < found.p:
                last, first = (float(t) for t in swing.time_s[at + count - 1 : at + count + 1])
                usual_of_it = float(swing.usual[channel])
                found = Jump(p, last, first, usual_of_it, swing.unit, float(size.max()))
            tests += step.size / count
    return replace(found, p=min(1.0, tests * found.p)) if tests else found


def _of_all(differences: FloatArray, rounded: float) -> float:
    """Usual size of differences of all channels, whose rounding has the given sd."""
    size = np.abs(differences)
    usual = _NORMAL * float(np.median(size))
    if usual < _STEP * rounded:
        usual = max(usual, float(np.quantile(size, _OFTEN) / chances.norm_ppf(0.5 + 0.5 * _OFTEN)))
    return max(usual, rounded)


def at_rest(problem: Problem, name: str) -> tuple[FloatArray, FloatArray, str]:
    """When each swing of a channel is, what its residual is on average, (s,) each, and its unit.

    Empty for a channel that never rests.
    """
    assert problem.traces is not None, "a walk"
    number = problem.traces.names.index(name)
    of_channel = problem.traces.channel == number
    rows = np.flatnonzero(of_channel & np.isin(problem.output, list(_pooled(problem))))
    time_s = problem.traces.time_s[rows]
    if not rows.size:
        return time_s, time_s, ""
    swing = _numbers(problem, time_s)
    count = np.bincount(swing)
    values = problem.residual[rows] * problem.noise[rows]
    unit = problem.units[int(problem.output[rows[0]])]
    return np.bincount(swing, time_s) / count, np.bincount(swing, values) / count, unit


def held(problem: Problem, name: str) -> tuple[FloatArray, FloatArray, str]:
    """When each hold is, what calibration leaves of one output in it, (b,) each, and its unit."""
    assert problem.traces is not None, "a series"
    o = problem.outputs.index(name) if name in problem.outputs else 0
    left = left_by(problem.fitted, problem.residual, _RCOND) * problem.noise
    mean = means_of_blocks(problem, np.column_stack([problem.traces.time_s, left]))
    time_s, mean_left = mean[o :: len(problem.outputs)].T
    return time_s, mean_left, problem.units[o]


def _pooled(problem: Problem) -> Mapping[int, IntArray]:
    """Outputs that several channels share, as those of feet in the air do, and these channels."""
    assert problem.traces is not None, "a walk"
    channels = {
        o: np.unique(problem.traces.channel[problem.output == o])
        for o in range(len(problem.outputs))
    }
    return {o: own for o, own in channels.items() if own.size > 1}


def _numbers(problem: Problem, time_s: FloatArray) -> IntArray:
    """Number of the swing of each row of a channel at rest, shape (n,)."""
    gap = np.diff(time_s, prepend=time_s[:1]) * problem.rate_hz
    return np.cumsum(np.abs(gap) > _BROKEN)


@dataclass(frozen=True)
class _Swings:
    """Means over each swing of one foot: of every channel, and of all together, (swings, c + 1).

    With them the stamps at their middles, what the converter's steps make, and the assumed noise
    in whose units both are.
    """

    mean: FloatArray
    time_s: FloatArray
    rounded: float
    noise: float
    unit: str

    @property
    def usual(self) -> FloatArray:
        """Sd of what differs from one swing to the next, in the output's unit, shape (c + 1,)."""
        step = np.median(np.abs(np.diff(self.mean, axis=0)), axis=0)
        return np.asarray(self.noise * np.maximum(_NORMAL * step, self.rounded))


def _swings(problem: Problem, residual: FloatArray) -> Iterator[_Swings]:
    """Channels that rest at the same times are one foot's.

    The first and the last swing, in which a gait begins and ends, are no step like the others.
    """
    if problem.traces is None or problem.rate_hz <= 0 or problem.settings is not None:
        return
    channel, time_s = problem.traces.channel, problem.traces.time_s
    for o, own in _pooled(problem).items():
        feet: dict[bytes, list[FloatArray]] = {}
        for c in own:
            rows = np.flatnonzero((channel == c) & (problem.output == o))
            feet.setdefault(time_s[rows].tobytes(), []).append(residual[rows])
        least = 0.0 if problem.least is None else float(problem.least[o])
        for stamps, values in feet.items():
            time = np.frombuffer(stamps)
            number = _numbers(problem, time)
            rows = np.bincount(number)
            cells = np.stack([np.bincount(number, v) / rows for v in values], axis=1)[1:-1]
            middle = (np.bincount(number, time) / rows)[1:-1]
            yield _Swings(
                np.column_stack([cells, cells.mean(axis=1)]), middle, least,
                float(problem.noise[problem.output == o][0]), problem.units[o],
            )  # fmt: skip


def _differences(values: FloatArray, count: int) -> FloatArray:
    """Mean of the next so many rows less that of the last so many, shape (n + 1 − 2·count, c)."""
    total = np.cumsum(np.vstack([0.0 * values[:1], values]), axis=0)
    mean = (total[count:] - total[:-count]) / count
    return np.asarray(mean[count:] - mean[:-count])
