"""Columns that know no cause: bumps, lags and products of the recorded signals, per output."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from footcal_cli.core.diagnosis.problem import Problem
from footcal_cli.core.parameters import FloatArray, IntArray

KNOTS = (0.0, 0.05, 0.25, 0.5, 0.75, 0.95, 1.0)
"""Quantiles of a recorded signal at which its local bumps stand; what is rare has its own."""
BUMPS = len(KNOTS)
PHASES = {"gait phase": 16, "shaft phase": 32, "order of recording": 16}
"""Local bumps over a cycle or a recording; a bearing catches several times per turn."""


@dataclass(frozen=True)
class Features:
    """Flexible columns and the group each belongs to.

    Parameters
    ----------
    columns
        Shape (m, f), zero on the rows of other outputs, each of unit RMS there.
    group
        Index into `names`, shape (f,).
    names
        The recorded signal (or ``memory``) each group depends on.
    output
        Output each column acts on, shape (f,).
    """

    columns: FloatArray
    group: IntArray
    names: tuple[str, ...]
    output: IntArray


def features_of(problem: Problem) -> Features:
    """Bumps in every regressor, and lagged differences of it as memory, for each output.

    A function of a recorded signal is a sum of triangular bumps on its quantiles; what remembers
    is a sum of exponentially forgotten copies of the signal.
    """
    parts: list[FloatArray] = []
    group: list[int] = []
    output: list[int] = []
    names = [*problem.regressors, *([MEMORY] if problem.rate_hz > 0 else [])]
    for i, name in enumerate(names):
        basis = (
            _memories(problem)
            if name == MEMORY
            else _bumps(problem.regressors[name], PHASES.get(name, BUMPS))
        )
        for o in range(len(problem.outputs)):
            rows = problem.output == o
            local = np.where(rows[:, None], basis, 0.0)
            rms = np.sqrt(np.sum(local**2, axis=0) / max(int(rows.sum()), 1))
            used = rms > 1e-12
            parts.append(local[:, used] / rms[used])
            group += [i] * int(used.sum())
            output += [o] * int(used.sum())
    columns = np.hstack(parts) if parts else np.empty((problem.residual.size, 0))
    return Features(columns, np.array(group, dtype=np.int64), tuple(names), np.array(output))


MEMORY = "memory"
_FORGETTING_S = (0.1, 0.6, 4.0)


def _bumps(values: FloatArray, bumps: int) -> FloatArray:
    """Triangular bumps that sum to one, on quantile knots; dummies where values are few."""
    distinct = np.unique(np.round(values, 12))
    if distinct.size < 2:
        return np.empty((values.size, 0))
    if distinct.size <= bumps:
        near = np.abs(values[:, None] - distinct[None]) <= 1e-9 + 1e-9 * np.abs(distinct[None])
        return near.astype(float)
    at = KNOTS if bumps == BUMPS else np.linspace(0.0, 1.0, bumps)
    knots = np.unique(np.quantile(values, at))
    if knots.size < 2:
        knots = np.array([values.min(), values.max()])
    return np.stack(
        [np.interp(values, knots, np.eye(knots.size)[i]) for i in range(knots.size)], axis=1
    )


def _memories(problem: Problem) -> FloatArray:
    """Each regressor less its exponentially forgotten past, at several time constants."""
    from scipy.signal import lfilter

    starts = np.flatnonzero(np.diff(problem.sequence, prepend=problem.sequence[:1] - 1))
    stops = np.append(starts[1:], problem.sequence.size)
    sources = _moving(problem.regressors)
    stack = np.stack(list(sources), axis=1) if sources else np.empty((problem.block.size, 0))
    parts = [np.empty((problem.block.size, 0))]
    for time_s in _FORGETTING_S if sources else ():
        keep = np.exp(-1.0 / (time_s * problem.rate_hz))
        past = np.empty_like(stack)
        for start, stop in zip(starts, stops, strict=True):
            first = stack[start : start + 1]
            past[start:stop] = lfilter(
                [1.0 - keep], [1.0, -keep], stack[start:stop], axis=0, zi=keep * first
            )[0]
        parts.append(stack - past)
    return np.hstack(parts)


def _moving(regressors: Mapping[str, FloatArray]) -> list[FloatArray]:
    """Signals whose past may matter: those that are not already rates or products."""
    return [
        v
        for name, v in regressors.items()
        if not any(m in name for m in ("rate", "×", "phase", "order", "hanging", "gravity"))
    ]
