"""All that a diagnosis needs of the rows: one small Gram matrix per block, in units of the noise.

The calibration may differ from block to block, wander, or be free in every block.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import linalg

from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.inference.products import (
    MOST_AT_ONCE,
    Dense,
    Products,
    block_products,
    partial_out,
    with_known,
)
from footcal_cli.core.inference.tracking import (
    PART_S,
    Tracking,
    Walk,
    block_starts,
    innovations,
    tracked_parts,
)
from footcal_cli.core.inference.wandering import variance_beside, wandering_columns
from footcal_cli.core.inference.whitening import PIECE, Noise, RowWhitener
from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray

_FREE = 1e8
_FREE_RIDGE = 1e-6
_SMALLEST = 1e-300
_ROUNDING = 1e-12


@dataclass(frozen=True)
class Grams:
    """Inner products of all columns, block by block, in units of the noise.

    Columns are [calibration | accepted | wandering | signatures | features | residual]; wandering
    ones are the columns by which a block's own calibration may differ.

    Parameters
    ----------
    inner
        ``X_bᵀ V_b⁻¹ X_b``.
    within
        The same for a calibration that is free in every block (infinite variance between blocks).
    rows
        ``X_bᵀ X_b`` after whitening the rows only.
    plain
        ``X_bᵀ X_b`` without any whitening: squared errors as the user counts them; whitened
        innovations where the calibration is tracked.
    by_output
        The same per output for what is fitted and the residual, of each output.
    energy
        Sum of squares of every column on each output, without whitening, less what a drifting
        calibration takes, shape (outputs, n).
    visible
        Share of every column's RMS that a drifting calibration leaves, shape (n,).
    calibration, wandering, candidates, features
        Column numbers of each part; the residual is the last column. `calibration` is what all
        blocks share: accepted effects too, and nothing but them where the calibration drifts.
    """

    inner: Products
    within: Products
    rows: Products
    plain: Products
    by_output: tuple[Products, ...]
    energy: FloatArray
    visible: FloatArray
    calibration: IntArray
    wandering: IntArray
    candidates: IntArray
    features: IntArray

    @property
    def blocks(self) -> int:
        """Number of blocks."""
        return self.inner.blocks

    def of_blocks(self, kept: BoolArray) -> Grams:
        """Of some of the blocks, shape (B,); what is known of outputs stays that of all."""
        # where nothing wanders several are the same
        fewer = {id(p): p.of_blocks(kept) for p in (self.inner, self.within, self.rows, self.plain)}
        return replace(
            self,
            inner=fewer[id(self.inner)],
            within=fewer[id(self.within)],
            rows=fewer[id(self.rows)],
            plain=fewer[id(self.plain)],
        )


def calibration_grams(
    problem: Problem, noise: Noise | None = None, *, counted: bool = True
) -> Grams:
    """Of the calibration and the residual alone; `noise` and `counted` as in `whitened_grams`."""
    nothing = np.empty((problem.residual.size, 0))
    return whitened_grams(problem.without_candidates, nothing, noise, counted=counted)[0]


def whitened_grams(
    problem: Problem, features: FloatArray, noise: Noise | None = None, *, counted: bool = True
) -> tuple[Grams, RowWhitener]:
    """Whiten rows, then account for a calibration that wanders from block to block.

    ``V_b = I + Z_b D Z_bᵀ`` with Z the columns of the calibration and the offsets of the outputs; D
    diagonal, its variances estimated by expectation maximisation from the data.

    Parameters
    ----------
    features
        Further columns, shape (m, f): anything the residual may depend on.
    noise
        Estimated from the problem's own residual where None.
    counted
        Whether errors are counted without whitening too. A fit asks for `inner` alone: `plain`,
        `by_output` and `energy` are then empty.
    """
    noise = noise or problem.law
    whitener = noise.whitener
    kept = whitener.kept
    tracked = problem.tracking is not None
    wandering = wandering_columns(problem, whitener)
    parts = (problem.calibration, problem.shared, wandering, problem.columns, features)
    raw = np.hstack([*parts, problem.residual[:, None]])
    edges = np.cumsum([0, *(part.shape[1] for part in parts)])
    numbers = [np.arange(a, b) for a, b in itertools.pairwise(edges)]
    white = whitener(raw)
    if noise.settled is not None:
        white = noise.settled(white)
    norm = np.einsum("ij,ij->j", white, white)
    if not counted:
        raw = raw[:, :0]
    if tracked:
        rows = _tracked(problem, white, raw, kept, numbers[0], noise.walk)
    else:
        if problem.drifts:
            raw, white = _free_in_every_block(raw, white, problem.block, kept, numbers[2])
        elif problem.pieces and problem.known is None:
            fitted = np.concatenate([numbers[0], numbers[1][: problem.usual_columns.stop]])
            raw, white = _without_known_to_one(raw, white, problem.block, kept, fitted)
        rows = block_products(white, problem.block[kept], problem.blocks)
    # how far the prediction of a tracked calibration is off depends on the slow noise that it
    # starts from; the innovations are what a model answers for
    plain = rows if tracked and counted else block_products(raw, problem.block, problem.blocks)
    by_output: tuple[Products, ...] = ()
    if counted:
        short = raw.take([*numbers[0], *numbers[1], raw.shape[1] - 1], axis=1)
        of = [problem.output == o for o in range(len(problem.outputs))]
        by_output = tuple(block_products(short[m], problem.block[m], problem.blocks) for m in of)
    energy = _energies(raw, problem.output, len(problem.outputs))
    tied = _of_usual_size(problem, numbers[1])
    if problem.drifts:
        if problem.held is not None:
            tied = np.concatenate([numbers[1][: problem.held.shape[1]], tied])
        if tied.size:
            # in equal shares, as what is known beforehand of a calibration
            same, rows = plain is rows, with_known(rows, np.eye(tied.size) / problem.blocks, tied)
            plain = rows if same else plain
        inner = within = rows
        base = numbers[1]
    else:
        base = np.concatenate([numbers[0], numbers[1]])
        within = partial_out(rows, numbers[2], np.full(numbers[2].size, _FREE))
        suspects = numbers[3] if problem.pieces else numbers[3][:0]
        variance = variance_beside(
            rows, base, numbers[2], suspects, bench=len(problem.outputs) == 1
        )  # fmt: skip
        inner = partial_out(rows, numbers[2], variance)
        if tied.size:
            inner, within = (
                with_known(p, np.eye(tied.size) / problem.blocks, tied) for p in (inner, within)
            )
        if problem.known is not None:
            # what is known beforehand, in equal shares, so that a fold less is a little less of it
            known = problem.known / problem.blocks
            inner, within = (with_known(p, known, numbers[0]) for p in (inner, within))
            if counted:
                plain = with_known(plain, known, numbers[0])
    shown = np.maximum(inner.squares(np.arange(norm.size)).sum(axis=0), 0.0)  # but for rounding
    return (
        Grams(
            inner=inner, within=within, rows=rows, plain=plain, by_output=by_output, energy=energy,
            visible=np.sqrt(np.divide(shown, norm, out=np.zeros_like(norm), where=norm > 0)),
            calibration=base, wandering=numbers[2], candidates=numbers[3], features=numbers[4],
        ),
        whitener,
    )  # fmt: skip


def _tracked(
    problem: Problem,
    white: FloatArray,
    raw: FloatArray,
    kept: IntArray,
    calibration: IntArray,
    walk: Walk | None,
) -> Products:
    """Products of the whitened innovations of each block; `raw` is left with what is unpredicted.

    A `raw` without columns stays so.
    """
    tracking = problem.tracking
    assert tracking is not None
    assert walk is not None
    stretches = [kept[stretch.rows] for stretch in walk.stretches]
    own = _raw_stretches(problem, tracking, stretches) if raw.shape[1] else None
    # while the filter still learns where the calibration stands, what it cannot predict says so
    # and nothing else: the first block of each recording is no evidence
    learning = {int(problem.block[tracking.recording == r].min()) for r in
                np.unique(tracking.recording)}  # fmt: skip
    few = white.shape[1] <= MOST_AT_ONCE
    grams = np.zeros((problem.blocks if few else 0, white.shape[1], white.shape[1]))
    for i, (predicted, tracked) in enumerate(innovations(white, calibration, walk)):
        block = int(problem.block[stretches[i][0]])
        if block not in learning and few:
            grams[block] += tracked.products()
        elif block not in learning:
            # of many columns no second copy: each stretch is read once
            white[walk.stretches[i].rows] = tracked.whitened()
        else:
            white[walk.stretches[i].rows] = 0.0
        if own is not None:
            raw[own[i]] -= raw[np.ix_(own[i], calibration)] @ predicted
    if own is not None:
        unpredicted = np.ones(len(raw), dtype=bool)
        unpredicted[np.concatenate(own)] = False
        raw[unpredicted | np.isin(problem.block, list(learning))] = 0.0
    return Dense(grams) if few else block_products(white, problem.block[kept], problem.blocks)


def _raw_stretches(
    problem: Problem, tracking: Tracking, stretches: Sequence[IntArray]
) -> list[IntArray]:
    """Rows that belong to each stretch of kept rows, the starts of sequences among them.

    The few rows of a part of which none was kept, at the end of a block, go with the stretch next
    to it; those of a block without a stretch belong to none.
    """
    starts = block_starts(tracking, problem.block)

    def key(rows: IntArray) -> tuple[int, int]:
        block = int(problem.block[rows[0]])
        return block, int((np.median(tracking.time_s[rows]) - starts[block]) // PART_S)

    number = {key(rows): i for i, rows in reversed(list(enumerate(stretches)))}
    own: list[list[IntArray]] = [[] for _ in stretches]
    for rows in tracked_parts(tracking, problem.block):
        at = key(rows)
        if at not in number:
            beside = [other for other in number if other[0] == at[0]]
            if not beside:
                continue
            at = min(beside, key=lambda other: abs(other[1] - at[1]))
        own[number[at]].append(rows)
    return [np.concatenate([stretch[:0], *rows]) for rows, stretch in
            zip(own, stretches, strict=True)]  # fmt: skip


def _of_usual_size(problem: Problem, shared: IntArray) -> IntArray:
    """Columns of usual imperfections whose size is bounded, each known to one of them.

    Free, a gain of a per mille and a screw of a millimetre trade against each other by metres in
    the only stance that tells them apart, and a CoM against the places of both transducers.
    """
    if not problem.usual_of:
        return shared[:0]
    bounded = [s.effect not in problem.usual_of_any_size for s in problem.usual_of]
    return np.asarray(shared[problem.usual_columns][np.array(bounded, dtype=bool)])


def _free_in_every_block(
    raw: FloatArray, white: FloatArray, block: IntArray, kept: IntArray, free: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Columns minus the part that a block's own calibration absorbs, unwhitened and whitened.

    None unwhitened where errors are not counted.
    """
    raw, white = raw.copy(), white.copy()
    for b in range(int(block.max()) + 1):
        mine = block[kept] == b
        basis = white[np.ix_(mine, free)]
        gram = basis.T @ basis
        gram[np.diag_indices_from(gram)] += _FREE_RIDGE
        coefficients = np.linalg.solve(gram, basis.T @ white[mine])
        white[mine] -= basis @ coefficients
        if raw.shape[1]:
            rows = block == b
            raw[rows] -= raw[np.ix_(rows, free)] @ coefficients
    return raw, white


def _without_known_to_one(
    raw: FloatArray, white: FloatArray, block: IntArray, kept: IntArray, columns: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Rows less what a block alone shows of the calibration, unwhitened and whitened.

    The only stance on one foot distinguishes the offsets; from all others it is predicted with a
    variance of ``ρ = vᵀ K_b v / vᵀ (K − K_b) v`` times the noise, K the information on the
    calibration. Where ρ is more than the number of rows, the error of that one prediction would
    outweigh all of them, whatever the model: its direction ``C_b v`` is taken out of the block.
    """
    raw, white = raw.copy(), white.copy()
    mine = [np.flatnonzero(block[kept] == b) for b in range(int(block.max()) + 1)]
    own = [white[np.ix_(rows, columns)] for rows in mine]
    information = [part.T @ part for part in own]
    total = np.sum(information, axis=0)
    scale = np.sqrt(np.clip(np.diag(total), _SMALLEST, None))
    for b, part in enumerate(own):
        rest = (total - information[b]) / np.outer(scale, scale)
        rest[np.diag_indices_from(rest)] += _ROUNDING
        ratio, ways = linalg.eigh(information[b] / np.outer(scale, scale), rest)
        alone = ways[:, ratio > len(white)] / scale[:, None]
        if not alone.size:
            continue
        way, _ = np.linalg.qr(part @ alone)
        white[mine[b]] -= way @ (way.T @ white[mine[b]])
        if raw.shape[1]:
            rows = np.flatnonzero(block == b)
            way, _ = np.linalg.qr(raw[np.ix_(rows, columns)] @ alone)
            raw[rows] -= way @ (way.T @ raw[rows])
    return raw, white


def _energies(columns: FloatArray, output: IntArray, outputs: int) -> FloatArray:
    """Squared norm of each column on each output, shape (outputs, n)."""
    energy = np.zeros((outputs, columns.shape[1]))
    member = np.eye(outputs)[output]
    # in pieces: the squares of a long log are as many again as its columns
    for start in range(0, len(columns), PIECE):
        piece = slice(start, start + PIECE)
        energy += member[piece].T @ columns[piece] ** 2
    return energy
