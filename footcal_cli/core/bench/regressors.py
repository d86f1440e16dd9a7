"""The design of a channel's regression, the search for shapes, and the way back to the load."""

from __future__ import annotations

from itertools import pairwise, product

import numpy as np
from scipy.optimize import minimize, minimize_scalar

from footcal_cli.core.bench.record import BenchRecord
from footcal_cli.core.bench.terms import Term
from footcal_cli.core.inference.blocks import whiten_autoregressive
from footcal_cli.core.parameters import FloatArray, IntArray

SHAPE_LOG_SD = 1.5
"""Prior sd of the logarithm of a shape: a factor of 4.5 either way from the middle of its grid."""
_LOG_STEP = 1e-3
_MOST_ITERATIONS = 60
_INVERSE_TOLERANCE = 1e-11
_BEYOND_GRID = 0.2
"""How far, in logarithm, a shape may leave its grid: creep faster than the rows is a mere scale."""
_APART = 1.1
"""Two time constants nearer than this in logarithm are one."""


def shape_names(channel: str, terms: tuple[Term, ...]) -> tuple[str, ...]:
    """Full names of the searched shapes, term by term."""
    return tuple(
        f"{channel}{term.owner}.{shape}" for term in terms if term.free for shape in term.shapes
    )


def columns(
    load_n: FloatArray, record: BenchRecord, terms: tuple[Term, ...], log_shapes: FloatArray
) -> FloatArray:
    """φ of every term at the given loads, shape (n, t)."""
    found = np.empty((load_n.size, len(terms)))
    values, at = np.exp(log_shapes), 0
    for i, term in enumerate(terms):
        if term.free:
            shapes = values[at : at + len(term.shapes)]
            at += len(term.shapes)
        else:
            shapes = np.array([grid[0] for grid in term.grids])
        found[:, i] = term.phi(load_n, record, shapes)
    return found


def shape_columns(
    load_n: FloatArray,
    record: BenchRecord,
    terms: tuple[Term, ...],
    sizes: FloatArray,
    log_shapes: FloatArray,
) -> FloatArray:
    """``Σ size · ∂φ/∂ln shape`` of every searched shape by central differences, shape (n, k)."""
    found = np.empty((load_n.size, log_shapes.size))
    for j in range(log_shapes.size):
        step = np.zeros(log_shapes.size)
        step[j] = _LOG_STEP
        up = columns(load_n, record, terms, log_shapes + step)
        down = columns(load_n, record, terms, log_shapes - step)
        found[:, j] = (up - down) @ sizes / (2.0 * _LOG_STEP)
    return found


def design_of(
    record: BenchRecord, drive: FloatArray, terms: tuple[Term, ...], log_shapes: FloatArray
) -> FloatArray:
    """Rows ``[x − x̄, 1, φ]`` of the known loads, shape (m, 2 + t).

    Parameters
    ----------
    record
        Bench record.
    drive
        Loads without gaps, shape (n,).
    terms, log_shapes
        What is beyond scale and bias.
    """
    known = record.known
    centred = record.load_n[known] - record.load_n[known].mean()
    bends = columns(drive, record, terms, log_shapes)[known]
    return np.column_stack([centred, np.ones_like(centred), bends])


def search_shapes(
    record: BenchRecord,
    drive: FloatArray,
    terms: tuple[Term, ...],
    start: FloatArray | None,
    correlation_s: float,
) -> FloatArray:
    """Logarithms of the shapes that fit best, on the grids first where there is no start.

    Minimises ``(n/2) ln RSS`` of the regression with a free offset per session, plus a weak prior
    about the middle of each grid and a wall between two time constants of creep.

    Returns
    -------
    FloatArray
        Shape (k,).
    """
    grids = [np.log(grid) for term in terms if term.free for grid in term.grids]
    if not grids:
        return np.zeros(0)
    names = [shape for term in terms if term.free for shape in term.shapes]
    middle = np.array([0.5 * (grid[0] + grid[-1]) for grid in grids])
    half = np.array([0.5 * (grid[-1] - grid[0]) for grid in grids]) + _BEYOND_GRID
    known = record.known
    time, session = record.time_s[known], record.session[known]
    mean = record.reading[known].mean()

    def cost(log_shapes: FloatArray) -> float:
        if not _ordered(names, log_shapes) or np.any(np.abs(log_shapes - middle) > half):
            return 1e12
        stacked = design_of(record, drive, terms, log_shapes)
        rows, target = whiten_autoregressive(
            stacked, record.reading[known] - mean, time, session, correlation_s
        )
        rows, target = within(rows, session), within(target[:, None], session)[:, 0]
        scaled = rows / np.maximum(np.linalg.norm(rows, axis=0), 1e-300)
        rest = target - scaled @ np.linalg.lstsq(scaled, target, rcond=None)[0]
        prior = 0.5 * float(np.sum(((log_shapes - middle) / SHAPE_LOG_SD) ** 2))
        return 0.5 * target.size * float(np.log(rest @ rest + 1e-300)) + prior

    if start is None:
        points = (np.array(point) for point in product(*grids))
        start = min(points, key=cost)
    if start.size == 1:
        width = np.log(2.5)
        low, high = float(start[0] - width), float(start[0] + width)
        found = minimize_scalar(
            lambda z: cost(np.array([z])), bounds=(low, high), options={"xatol": 1e-3}
        )
        return np.array([found.x]) if found.fun <= cost(start) else start
    simplex = np.vstack([start, start + 0.4 * np.eye(start.size)])
    refined = minimize(
        cost,
        start,
        method="Nelder-Mead",
        options={
            "maxfev": 60 * start.size,
            "xatol": 2e-3,
            "fatol": 1e-4,
            "initial_simplex": simplex,
        },
    )
    return np.asarray(refined.x, dtype=np.float64)


def _ordered(names: list[str], log_shapes: FloatArray) -> bool:
    """Whether the times of creep ascend and stay apart: a sum of two creeps is symmetric."""
    times = [z for z, name in zip(log_shapes, names, strict=True) if name.startswith("creep")]
    return all(later - earlier > _APART for earlier, later in pairwise(times))


def within(rows: FloatArray, session: IntArray) -> FloatArray:
    """Rows without their session's mean where there are several sessions.

    Parameters
    ----------
    rows, session
        Shape (n, p) and (n,).
    """
    names, index = np.unique(session, return_inverse=True)
    if names.size == 1:
        return rows
    sums = np.zeros((names.size, rows.shape[1]))
    np.add.at(sums, index, rows)
    return np.asarray(rows - (sums / np.bincount(index)[:, None])[index])


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
    terms, sizes, log_shapes
        The model.
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
