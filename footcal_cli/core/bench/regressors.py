"""The design of a channel's regression, the search for shapes, and the way back to the load."""

from __future__ import annotations

from itertools import product

import numpy as np

from footcal_cli.core.bench.record import BenchRecord
from footcal_cli.core.bench.terms import Term
from footcal_cli.core.inference.fit import numeric_jacobian
from footcal_cli.core.inference.separable import LOG_STEP, Separable
from footcal_cli.core.parameters import FloatArray, Parameter, ParameterSet

SHAPE_LOG_SD = 1.5
"""Prior sd of the logarithm of a shape: a factor of 4.5 either way from the middle of its grid."""
_MOST_ITERATIONS = 60
_INVERSE_TOLERANCE = 1e-11
_BEYOND_GRID = 0.2
"""How far, in logarithm, a shape may leave its grid: creep faster than the rows is a mere scale."""
_MOST_KEPT = 4_000_000
"""Numbers that a search may remember: 32 MB."""
_APART = 1.1
"""Two time constants nearer than this in logarithm are one."""


def shape_names(channel: str, terms: tuple[Term, ...]) -> tuple[str, ...]:
    """Full names of the searched shapes, term by term."""
    return tuple(
        f"{channel}{term.owner}.{shape}" for term in terms if term.free for shape in term.shapes
    )


Kept = dict[tuple[int, bytes], FloatArray | None]
"""φ (n,) by the number of its term and the bytes of its shapes' logarithms; None: not yet known."""


def columns(
    load_n: FloatArray,
    record: BenchRecord,
    terms: tuple[Term, ...],
    log_shapes: FloatArray,
    kept: Kept | None = None,
) -> FloatArray:
    """φ of every term at the given loads, shape (n, t).

    Parameters
    ----------
    kept
        Which φ at these loads to remember from call to call.
    """
    found = np.empty((load_n.size, len(terms)))
    values, at, kept = np.exp(log_shapes), 0, kept or {}
    for i, term in enumerate(terms):
        own = slice(at, at + len(term.shapes) * term.free)
        at = own.stop
        key = i, log_shapes[own].tobytes()
        column = kept.get(key)
        if column is None:
            fixed = np.array([grid[0] for grid in term.grids])
            column = term.phi(load_n, record, values[own] if term.free else fixed)
            if key in kept:
                kept[key] = column
        found[:, i] = column
    return found


def worth_keeping(terms: tuple[Term, ...], rows: int) -> Kept:
    """The points of each term's own grid, which a search over all grids comes back to."""
    kept: Kept = {}
    for i, term in enumerate(terms):
        grids = [np.log(grid) for grid in term.grids] if term.free else []
        kept |= {(i, np.array(point).tobytes()): None for point in product(*grids)}
    return kept if rows * len(kept) <= _MOST_KEPT else {}


def shape_columns(
    load_n: FloatArray,
    record: BenchRecord,
    terms: tuple[Term, ...],
    sizes: FloatArray,
    log_shapes: FloatArray,
) -> FloatArray:
    """``Σ size · ∂φ/∂ln shape`` of every searched shape, shape (n, k)."""
    return numeric_jacobian(
        lambda s: columns(load_n, record, terms, s) @ sizes,
        log_shapes,
        np.full(log_shapes.size, LOG_STEP),
    )


def design_of(
    record: BenchRecord,
    drive: FloatArray,
    terms: tuple[Term, ...],
    log_shapes: FloatArray,
    kept: Kept | None = None,
) -> FloatArray:
    """Rows ``[x − x̄, 1, φ]`` of the known loads, shape (m, 2 + t).

    Parameters
    ----------
    drive
        Loads without gaps, shape (n,).
    terms, log_shapes
        What is beyond scale and bias.
    kept
        As in `columns`.
    """
    known = record.known
    centred = record.load_n[known] - record.load_n[known].mean()
    bends = columns(drive, record, terms, log_shapes, kept)[known]
    return np.column_stack([centred, np.ones_like(centred), bends])


def model_of(record: BenchRecord, drive: FloatArray, terms: tuple[Term, ...]) -> Separable:
    """The readings of the known loads as a model of scale, bias, sizes and shapes.

    Each session has an offset and a gain of its own, or each load an offset where errors are
    renewed; a shape has a weak prior about the middle of its grid.

    Parameters
    ----------
    record, drive, terms
        As `design_of`.
    """
    searched = [term for term in terms if term.free]
    names = shape_names("", terms)
    grids = [np.log(grid) for term in searched for grid in term.grids]
    priors = []
    for name, grid in zip(names, grids, strict=True):
        middle = float(0.5 * (grid[0] + grid[-1]))
        half = float(0.5 * (grid[-1] - grid[0])) + _BEYOND_GRID
        priors.append(
            Parameter(name, "-", middle, SHAPE_LOG_SD, lower=middle - half, upper=middle + half)
        )
    known = record.known
    load, reading = record.load_n[known], record.reading[known]
    kept = worth_keeping(terms, drive.size)
    ones = np.ones_like(load)
    return Separable(
        design=lambda log_shapes: design_of(record, drive, terms, log_shapes, kept),
        target=reading - reading.mean(),
        time_s=record.time_s[known],
        block=record.loadings() if record.renewed else record.session[known],
        shapes=ParameterSet(tuple(priors)),
        starts=[np.array(point) for point in product(*grids)],
        ascending=[i for i, name in enumerate(names) if name.startswith(".creep")],
        apart=_APART,
        shared=ones[:, None] if record.renewed else np.column_stack([ones, load]),
        kept=record.renewed,
    )


def invert(
    target: FloatArray,
    record: BenchRecord,
    terms: tuple[Term, ...],
    sizes: FloatArray,
    log_shapes: FloatArray,
    limits: tuple[float, float],
) -> tuple[FloatArray, FloatArray]:
    """Solve ``x + Σ size φ(x) = target`` for the loads x, in order of time.

    Newton's step with the derivative of all rows moved together: exact for a curve, and for the
    memory terms, whose size is a share of the load, it converges by itself.

    Parameters
    ----------
    target
        ``scale·S + bias``, shape (n,).
    record
        Clock, sessions and temperatures.
    limits
        Loads between which the answer is looked for: a polynomial bends back beyond its data.

    Returns
    -------
    load_n, slope
        x and dy/dx, shape (n,) each.
    """
    slope = np.ones_like(target)
    if not terms:
        return target, slope
    load = np.clip(target, *limits)
    span = max(float(np.ptp(target)), 1e-12)

    def forward(x: FloatArray) -> FloatArray:
        return x + columns(x, record, terms, log_shapes) @ sizes

    for _ in range(_MOST_ITERATIONS):
        step = 1e-4 * span
        slope = np.clip((forward(load + step) - forward(load - step)) / (2.0 * step), 0.2, 5.0)
        change = (forward(load) - target) / slope
        before, load = load, np.clip(load - change, *limits)
        if np.abs(load - before).max() <= _INVERSE_TOLERANCE * span:
            break
    return load, slope
