"""Visits to a hole that lie elsewhere than the others, or than any calibration lets them.

A hole that is written as its neighbour shares that one's label, so that a displacement of the label
fits neither. Visits that lie apart get a label of their own, and the effect ``wrong_hole`` is
judged on that like on any other.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.inference.case import Case, rows_of
from footcal_cli.core.inference.linear import left_by
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.inference.signatures import calibration_columns
from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray

_FAR = 6.0  # sd of what a row leaves, from which its weight in the fit falls
_APART = 8.0  # sd of where visits seem to be, from which one lies elsewhere
_LEAST_M = 1e-3
_HEAVIER = 6.0  # sd of the loads, in N and as shares of what is written, from which one is another
_THERE = 4.0  # sd of moments within which a weight lies where its label says
_LEAST_SHARE = 2e-3
_FEWEST = 5  # placements of one load that have a middle of their own
_MOST = 0.3  # of the visits; more of them are no labels
_HOLES = 2  # that bear other weights than written, both ways apart
_STEPS = 8
_MIDDLE = 0.6745
_RCOND = 1e-9


@dataclass(frozen=True)
class Elsewhere:
    """Visits whose weight lay elsewhere than the label says.

    Parameters
    ----------
    foot
        Whose plate.
    written_m, seems_m
        The label, and where the weight seems to have been, shape (2,) each.
    nearest_m
        The hole in use that is nearest to that, None where none is within half the way.
    visits, of
        How many visits, of how many with that label.
    """

    foot: str
    written_m: FloatArray
    seems_m: FloatArray
    nearest_m: FloatArray | None
    visits: int
    of: int


@dataclass(frozen=True)
class Misloaded:
    """One placement that weighs otherwise than its label says, and lies where it says.

    Parameters
    ----------
    foot, hole
        Whose plate, and the number of the hole.
    written_n, off_n
        The label's load, and how much more the cells carry.
    times
        That in sd of all placements.
    """

    foot: str
    hole: int
    written_n: float
    off_n: float
    times: float


def misloaded(case: Case) -> tuple[Misloaded, ...]:
    """Placements whose weight was another one: the load differs, the moment about the hole not.

    None where several holes lack or have too much: that is a curve of the cells near them.
    """
    rows, left, load, _ = _left_by_most(case)
    laid = load > 0.0
    mine = np.flatnonzero(laid & (rows.output == rows.outputs.index("fz")))
    off = left[mine] - _of_label(left[mine], load[mine])
    times = np.minimum(_times(off), _times(off / load[mine]))
    far = (times > _HEAVIER) & (np.abs(off) > _LEAST_SHARE * load[mine])
    if far.mean() > _MOST:
        return ()
    found = []
    for at, more, sd in zip(mine[far], off[far], times[far], strict=True):
        if np.all(_moments_of(rows, left, laid, int(at)) < _THERE):
            log = case.logs[int(rows.log[at])]
            hole = int(log.known["hole"][rows.row[at]])
            foot = log.channels[0].rpartition("_")[0]
            found.append(Misloaded(foot, hole, float(load[at]), float(more), float(sd)))
    for sign in (1.0, -1.0):
        if len({(one.foot, one.hole) for one in found if sign * one.off_n > 0}) > _HOLES:
            return ()
    return tuple(found)


def _of_label(left: FloatArray, load: FloatArray) -> FloatArray:
    """The middle of what all placements of one load leave: a curve, or a label that is off."""
    middle = np.zeros(left.size)
    for label in np.unique(load.round(6)):
        mine = load.round(6) == label
        if np.count_nonzero(mine) >= _FEWEST:
            middle[mine] = np.median(left[mine])
    return middle


def _times(values: FloatArray) -> FloatArray:
    """|x| from the middle, in robust sd."""
    middle = np.median(values)
    return np.asarray(np.abs(values - middle) / max(float(_scatter(values)), 1e-300))


def _moments_of(rows: Problem, left: FloatArray, laid: BoolArray, at: int) -> FloatArray:
    """|moments| of the placement of a row, in robust sd of all placements."""
    same = (rows.log == rows.log[at]) & (rows.row == rows.row[at])
    found = []
    for o in np.unique(rows.output[same & (rows.output != rows.output[at])]):
        of = laid & (rows.output == o)
        found.append(float(_times(left[of])[same[of]][0]))
    return np.array(found)


def relabelled(case: Case) -> tuple[Case, tuple[Elsewhere, ...]]:
    """Placements whose displaced visits have hole numbers of their own, and what they are."""
    shift, load, log, visit = _displacements(case)
    sd = _scatter(shift)
    size = np.sqrt(np.sum(shift**2, axis=1))
    # noise of moments scatters a light weight far and is alike in N m; a pin's play is so in m
    moment = shift * load[:, None]
    apart = (np.abs(shift) > _APART * sd) & (np.abs(moment) > _APART * _scatter(moment))
    far = np.any(apart, axis=1) & (size > _LEAST_M)
    if not far.any() or far.mean() > _MOST:
        return case, ()
    logs, found = list(case.logs), []
    number = max(int(one.known["hole"].max()) for one in logs)
    for i, one in enumerate(logs):
        hole = one.known["hole"].copy()
        there = np.flatnonzero(far & (log == i))
        label = np.array([int(hole[one.block == b][0]) for b in visit[there]], dtype=np.int64)
        for name in np.unique(label):
            together = there[label == name]
            while together.size:
                close = np.all(
                    np.abs(shift[together] - shift[together[0]])
                    <= np.maximum(_APART * sd, _LEAST_M), axis=1
                )  # fmt: skip
                mine, together = together[close], together[~close]
                number += 1
                found.append(_elsewhere(case, i, int(name), visit[mine], shift[mine]))
                hole[np.isin(one.block, visit[mine])] = number
        logs[i] = one.with_known(hole=hole)
    return replace(case, logs=tuple(logs)), tuple(found)


def _scatter(values: FloatArray) -> FloatArray:
    """Robust sd of each column, shape (2,)."""
    return np.asarray(np.median(np.abs(values - np.median(values, axis=0)), axis=0) / _MIDDLE)


def _elsewhere(
    case: Case, number: int, label: int, visits: IntArray, shift: FloatArray
) -> Elsewhere:
    log = case.logs[number]
    there = log.known["hole"] == label
    written = log.known["hole_m"][there][0]
    seems = written + shift.mean(axis=0)
    holes = np.unique(log.known["hole_m"].round(6), axis=0)
    apart = np.linalg.norm(holes - seems, axis=1)
    best = holes[int(np.argmin(apart))]
    near = apart.min() < 0.5 * float(np.linalg.norm(seems - written))
    return Elsewhere(
        log.channels[0].rsplit("_", 1)[0], written, seems, best if near else None,
        int(visits.size), int(np.unique(log.block[there]).size),
    )  # fmt: skip


def _left_by_most(case: Case) -> tuple[Problem, FloatArray, FloatArray, IntArray]:
    """What a calibration leaves in which rows far off weigh little (Huber's weights), N and Nm.

    Returns
    -------
    Rows, what is left of each, and its load and block, shape (m,) each.
    """
    rows = rows_of(case)
    columns, turn = calibration_columns(case, rows)
    target = rows.residual
    if case.known is not None:
        # as many further rows as there are calibration columns
        values, vectors = np.linalg.eigh(turn.T @ case.known @ turn)
        known = np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T
    else:
        known = columns[:0]
    weight = np.ones(target.size)
    for _ in range(_STEPS):
        basis = np.vstack([columns * weight[:, None], known])
        whole = np.concatenate([target * weight, np.zeros(len(known))])
        left = left_by(basis, whole, _RCOND)[: target.size] / weight
        for o in range(len(rows.outputs)):
            mine = rows.output == o
            sd = float(np.median(np.abs(left[mine]))) / _MIDDLE
            weight[mine] = np.minimum(1.0, _FAR * sd / np.maximum(np.abs(left[mine]), 1e-300))
    left = left * rows.noise
    load, block = np.empty(target.size), np.empty(target.size, dtype=np.int64)
    for i, log in enumerate(case.logs):
        here = rows.log == i
        load[here] = log.known["load_n"][rows.row[here]]
        block[here] = log.block[rows.row[here]]
    return rows, left, load, block


def _displacements(case: Case) -> tuple[FloatArray, FloatArray, IntArray, IntArray]:
    """Where the weight of each visit seems to lie from its label, m, (n, 2); its load, log, block.

    ``δ = (Δm_y-lever, Δm_x-lever) / load`` of what most rows leave.
    """
    rows, left, load, block = _left_by_most(case)
    kinds, at = np.unique(np.stack([rows.log, block], axis=1), axis=0, return_inverse=True)
    at = np.asarray(at).ravel()
    shift, heavy = np.zeros((len(kinds), 2)), np.zeros((len(kinds), 2))
    for axis, name in enumerate(("moment_x", "moment_y")):
        mine = rows.output == rows.outputs.index(name)
        lever = np.bincount(at[mine], left[mine] * load[mine], minlength=len(kinds))
        squared = np.bincount(at[mine], load[mine] ** 2, minlength=len(kinds))
        shift[:, axis] = lever / np.maximum(squared, 1e-300)
        heavy[:, axis] = np.sqrt(squared)
    return shift, heavy.max(axis=1), kinds[:, 0], kinds[:, 1]
