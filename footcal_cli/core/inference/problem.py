"""A case linearised: what is left in each row, what calibration explains, what effects do.

`footcal_cli.core.inference.case.Case` says what is asked: recordings, a model, what matters. A
`Problem` is that question in arrays, row by row; it knows no chain and no effect but by name.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from footcal_cli.core.inference.linear import least_squares, scaled_inverse
from footcal_cli.core.inference.lines import Series, Traces
from footcal_cli.core.inference.settings import Settings
from footcal_cli.core.inference.tracking import Tracking
from footcal_cli.core.inference.whitening import Noise, Within, law_of_noise, within_blocks
from footcal_cli.core.parameters import FloatArray, IntArray
from footcal_cli.core.signals import starts_of

_RCOND = 1e-10
_OF_NONE: IntArray = np.empty(0, dtype=np.int64)


@dataclass(frozen=True)
class Signature:
    """One column of the library: an effect of unit size, in one place, with one shape.

    Parameters
    ----------
    effect, parameter
        Names in the table of effects.
    where
        Who carries it (``left_rr``, ``all cells``, ``left``, ``robot``).
    shape
        Values of the shape parameters.
    lower, upper
        Physically allowed sizes.
    owners
        Owner -> units that share the size, as in a `footcal_cli.core.chain.Link`.
    """

    effect: str
    parameter: str
    where: str
    unit: str
    shape: tuple[tuple[str, float], ...] = ()
    lower: float = -np.inf
    upper: float = np.inf
    owners: tuple[tuple[str, tuple[str, ...]], ...] = ()

    @property
    def cause(self) -> tuple[str, str, str]:
        """Effect, parameter and place: what a size is given for; shapes are searched over."""
        return self.effect, self.parameter, self.where


@dataclass(frozen=True)
class Excluded:
    """An effect that this data cannot test, and why."""

    effect: str
    where: str
    reason: str


@dataclass(frozen=True, eq=False)
class Problem:
    """Everything the engine needs; ``residual = calibration @ dθ + columns @ β + noise``.

    Rows of one sequence (one output, one gap-free stretch of one block) stand together in the
    order of time.

    Parameters
    ----------
    residual
        Measured − demanded at the fitted calibration, in units of the assumed noise, shape (m,).
    calibration
        Derivative of the residual by what the user calibrates anyway, shape (m, p).
    columns, signatures
        What each candidate of size one adds to the residual, shape (m, k), and what it is.
    block, output, sequence
        Of each row, shape (m,): 0 … B−1; index into `outputs`; number of the sequence.
    noise
        Assumed noise sd of each row in the output's unit, shape (m,).
    tolerance
        Smallest RMS error of each output that matters, in its unit, shape (outputs,).
    log, row, column
        Where each row comes from, shape (m,): which log, which row of it, and which column of its
        balance; empty where rows come from no recording, as `time_s` and `places` are.
    time_s
        Stamp of each row, shape (m,).
    places
        Per log: which rows come from it, and where in its judged errors, flattened, they stand.
    regressors
        Recorded signals that anything unknown might depend on, each (m,).
    rate_hz
        Sampling rate within a sequence; 0 where rows are no time series.
    covariates
        Block-level drivers (mean temperature, order of recording), each (B,).
    excluded
        Effects that were left out, with the reason.
    calibration_turn
        Change of each parameter per unit of each calibration column, shape (parameters, p).
    accepted
        Columns of effects already in the model, fitted with the calibration but common to all
        blocks, shape (m, a).
    tracking
        How the calibration wanders, where it drifts and is tracked; without it a drifting
        calibration is free in every block.
    alike
        Blocks are alike in content: candidates that act between blocks are tested by permuting.
    drifts
        The calibration drifts: it is free in every block, and what shows only between blocks is
        not testable.
    pieces
        Rows of a sequence are pieces of one observation (a stance), which does not repeat.
    settings
        What does not repeat from one setting-up to the next, each of which has several blocks.
    least
        Noise that converters' steps alone make, per output in units of the noise, (outputs,).
    traces
        Of which channel each row is and when it was taken, where rows are series.
    raw
        Channels as they were recorded where they should show nothing but noise, if the rows are
        filtered or thinned out.
    known
        Precision with which the coefficients of `calibration` were known before, about none,
        shape (p, p); None where these rows alone say what they are.
    held
        Columns in which all blocks alike differ from a known calibration, in units of the sd with
        which it was known, shape (m, h).
    usual, usual_of
        Columns of the experiment's usual imperfections, fitted with the calibration but common to
        all blocks, in usual sizes, shape (m, u), and what they are.
    usual_of_any_size
        Effects among these whose size nothing bounds.
    """

    residual: FloatArray
    calibration: FloatArray
    columns: FloatArray
    signatures: tuple[Signature, ...]
    block: IntArray
    output: IntArray
    sequence: IntArray
    outputs: tuple[str, ...]
    units: tuple[str, ...]
    noise: FloatArray
    tolerance: FloatArray
    log: IntArray = field(default_factory=lambda: _OF_NONE)
    row: IntArray = field(default_factory=lambda: _OF_NONE)
    column: IntArray = field(default_factory=lambda: _OF_NONE)
    time_s: FloatArray = field(default_factory=lambda: np.empty(0))
    places: tuple[tuple[slice | IntArray, IntArray], ...] = ()
    regressors: Mapping[str, FloatArray] = field(default_factory=dict)
    rate_hz: float = 0.0
    covariates: Mapping[str, FloatArray] = field(default_factory=dict)
    excluded: tuple[Excluded, ...] = ()
    calibration_turn: FloatArray | None = None
    accepted: FloatArray | None = None
    tracking: Tracking | None = None
    alike: bool = True
    drifts: bool = False
    pieces: bool = False
    settings: Settings | None = None
    least: FloatArray | None = None
    traces: Traces | None = None
    raw: Series | None = None
    known: FloatArray | None = None
    held: FloatArray | None = None
    usual: FloatArray | None = None
    usual_of: tuple[Signature, ...] = ()
    usual_of_any_size: frozenset[str] = frozenset()

    def __post_init__(self) -> None:
        rows = self.residual.shape[0]
        shapes = {
            "calibration": (self.calibration.shape, (rows, self.calibration.shape[-1])),
            "columns": (self.columns.shape, (rows, len(self.signatures))),
            "block": (self.block.shape, (rows,)),
            "output": (self.output.shape, (rows,)),
            "sequence": (self.sequence.shape, (rows,)),
            "noise": (self.noise.shape, (rows,)),
            "tolerance": (self.tolerance.shape, (len(self.outputs),)),
        }
        for name, (found, expected) in shapes.items():
            if found != expected:
                raise ValueError(f"{name} has shape {found}, expected {expected}")
        starts = starts_of(self.sequence)
        if np.unique(self.sequence[starts]).size != starts.size:
            raise ValueError("rows of one sequence must stand together")

    @cached_property
    def law(self) -> Noise:
        """What its noise is like, from the residual."""
        return law_of_noise(self)

    @cached_property
    def within(self) -> Within:
        """What is fitted to its residual before noise is looked at, no effect among it."""
        return within_blocks(self)

    @property
    def bare(self) -> Problem:
        """The same rows and what they are like, nothing that explains them."""
        none = self.columns[:, :0]
        return replace(
            self, calibration=none, columns=none, signatures=(), regressors={}, covariates={},
            excluded=(), calibration_turn=None, accepted=None, tracking=None, settings=None,
            traces=None, known=None, held=None, usual=None, usual_of=(),
            usual_of_any_size=frozenset(),
        )  # fmt: skip

    def asking(self, *, noise_anew: bool = False, **changes: Any) -> Problem:
        """The same rows with other candidates or accepted effects, and what is said of these.

        What is `within` depends on none of them; once known it stays, and so does the noise of
        series whose calibration is tracked, beside whichever candidate it was estimated; with
        `noise_anew` it is estimated beside the one that now explains most.
        """
        other = replace(self, **changes)
        stays = self.tracking is not None and self.rate_hz > 0 and not noise_anew
        of_law = ["law"] if stays else []
        vars(other).update({k: vars(self)[k] for k in ("within", *of_law) if k in vars(self)})
        return other

    @property
    def without_candidates(self) -> Problem:
        """The same rows and calibration, no effect in question."""
        return self.asking(columns=self.columns[:, :0], signatures=())

    def holding(self, columns: FloatArray) -> Problem:
        """The same problem with further columns accepted, shape (m, a)."""
        before = [] if self.accepted is None else [self.accepted]
        return self.asking(accepted=np.hstack([*before, columns]))

    def scaled(self, rows: FloatArray) -> Problem:
        """Residual and all that is fitted, row by row over a number, shape (m,)."""
        share = rows[:, None]
        return replace(
            self,
            residual=self.residual / rows,
            calibration=self.calibration / share,
            accepted=None if self.accepted is None else self.accepted / share,
            held=None if self.held is None else self.held / share,
            usual=None if self.usual is None else self.usual / share,
        )

    def without_usual(self, effects: Collection[str]) -> Problem:
        """The same problem where some imperfections are causes."""
        kept = [i for i, s in enumerate(self.usual_of) if s.effect not in effects]
        if self.usual is None or len(kept) == len(self.usual_of):
            return self
        named = tuple(self.usual_of[i] for i in kept)
        return replace(self, usual=self.usual[:, kept], usual_of=named)

    @property
    def averaged(self) -> Problem:
        """One row per sequence: its mean."""
        starts = starts_of(self.sequence)
        count = np.diff(np.append(starts, self.sequence.size))

        def mean(values: FloatArray) -> FloatArray:
            shape = (-1, *[1] * (values.ndim - 1))
            return np.asarray(np.add.reduceat(values, starts, axis=0) / count.reshape(shape))

        return replace(
            self,
            residual=mean(self.residual), calibration=mean(self.calibration),
            columns=mean(self.columns), noise=self.noise[starts], block=self.block[starts],
            output=self.output[starts], sequence=np.arange(starts.size),
            regressors={name: mean(values) for name, values in self.regressors.items()},
            log=_OF_NONE, row=_OF_NONE, column=_OF_NONE, time_s=np.empty(0), places=(),
            pieces=False,
            accepted=None if self.accepted is None else mean(self.accepted),
            held=None if self.held is None else mean(self.held),
            usual=None if self.usual is None else mean(self.usual),
        )  # fmt: skip

    @property
    def blocks(self) -> int:
        """Number of blocks."""
        return int(self.block.max()) + 1 if self.block.size else 0

    @property
    def turned(self) -> bool:
        """Whether its blocks are turns of legs that hang, of which few know of each leg."""
        return self.settings is not None and self.settings.part is not None

    def without(self, *effects: str) -> Problem:
        """The same problem with some effects taken out of the library."""
        kept = [i for i, s in enumerate(self.signatures) if s.effect not in effects]
        if len(kept) == len(self.signatures):
            return self
        return self.asking(
            columns=self.columns.take(kept, axis=1),
            signatures=tuple(self.signatures[i] for i in kept),
        )

    @property
    def fitted(self) -> FloatArray:
        """Everything that is fitted: calibration, then what all blocks share, shape (m, p + a)."""
        return np.hstack([self.calibration, self.shared])

    @property
    def shared(self) -> FloatArray:
        """What all blocks share beside what wanders: what is held, imperfections, effects."""
        parts = [part for part in (self.held, self.usual, self.accepted) if part is not None]
        return np.hstack([self.calibration[:, :0], *parts])

    @property
    def usual_columns(self) -> slice:
        """Imperfections among the columns of `shared`, between what is held and effects."""
        first = 0 if self.held is None else self.held.shape[1]
        return slice(first, first + (0 if self.usual is None else self.usual.shape[1]))

    def left(self) -> FloatArray:
        """What calibration and accepted effects cannot absorb of each candidate, shape (m, k)."""
        if not self.drifts:
            return self.left_of(self.columns)
        left = self.columns.copy()
        extra = self.shared
        for b in range(self.blocks):
            rows = self.block == b
            basis = self.calibration[rows]
            left[rows] -= basis @ least_squares(basis, left[rows], _RCOND)
            extra[rows] -= basis @ least_squares(basis, extra[rows], _RCOND)
        return (
            np.asarray(left - extra @ least_squares(extra, left, _RCOND))
            if extra.shape[1]
            else left
        )

    def left_of(self, target: FloatArray) -> FloatArray:
        """What a calibration that all blocks share leaves of columns, shape (m, k) or (m,)."""
        fitted = self.fitted
        if self.known is None:
            return np.asarray(target - fitted @ least_squares(fitted, target, _RCOND))
        products = fitted.T @ fitted
        own = np.arange(len(self.known))
        products[np.ix_(own, own)] += self.known
        known = scaled_inverse(products, _RCOND) @ (fitted.T @ target)
        return np.asarray(target - fitted @ known)

    def visible(self, left: FloatArray) -> FloatArray:
        """Share of each candidate's RMS that calibration cannot absorb, shape (k,).

        ``√(g · g̃)`` over ``|g|``: where something was known of the calibration, what an absorbing
        one is off by counts as what is left in the rows does.
        """
        whole = np.sqrt(np.sum(self.columns**2, axis=0))
        part = np.sqrt(np.maximum(np.sum(self.columns * left, axis=0), 0.0))
        return np.asarray(np.divide(part, whole, out=np.zeros_like(part), where=whole > 0))

    def smallest_sizes(self, left: FloatArray) -> FloatArray:
        """Smallest size of each candidate that matters, shape (k,).

        The size whose visible part changes some output by its tolerance (RMS); infinite for a
        candidate without any influence.
        """
        physical = left * self.noise[:, None]
        smallest = np.full(len(self.signatures), np.inf)
        for i in range(len(self.outputs)):
            rows = self.output == i
            if not rows.any():
                continue
            # an output may pool cells: one cell's error counts on the rows of that cell; what only
            # the refitted calibration brings into an output is in all rows
            touched = np.count_nonzero(self.columns[rows], axis=0)
            counted = np.where(touched > 0, touched, rows.sum())
            rms = np.sqrt(np.sum(physical[rows] ** 2, axis=0) / counted)
            size = np.divide(
                self.tolerance[i], rms, out=np.full_like(rms, np.inf), where=rms > 1e-300
            )
            smallest = np.minimum(smallest, size)
        return smallest
