"""Columns that know no cause: bumps, curves and lags of the recorded signals, per output."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray
from footcal_cli.core.signals import starts_of

KNOTS = (0.0, 0.05, 0.25, 0.5, 0.75, 0.95, 1.0)
"""Quantiles of a recorded signal at which its local bumps stand; what is rare has its own."""
BUMPS = len(KNOTS)
GAIT = "gait phase"
PHASES = {GAIT: 16, "shaft phase": 32, "order of recording": 16}
"""Local bumps over a cycle or a recording; a bearing catches several times per turn."""

SMOOTH = "force along"
"""Signals that start so get curves only: bumps of every force of every leg would drown the rest."""


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
    curved
        Whether a column is one of the few that span slow curves, shape (f,): what bends slowly is
        seen by three columns long before it is by a dozen. Only where rows are single observations.
    """

    columns: FloatArray
    group: IntArray
    names: tuple[str, ...]
    curved: BoolArray


def features_of(problem: Problem) -> Features:
    """Bumps in every regressor, and lagged differences of it as memory, for each output.

    A function of a recorded signal is a sum of triangular bumps on its quantiles; what remembers
    is a sum of exponentially forgotten copies of the signal.
    """
    found: list[tuple[FloatArray, int, bool]] = []
    series = problem.rate_hz > 0
    single = not series and problem.settings is None
    for i, (name, values) in enumerate(problem.regressors.items()):
        if not name.startswith(SMOOTH):
            found.append((_bumps(values, PHASES.get(name, BUMPS)), i, False))
        if single:
            found.append((_curves(values), i, True))
    names = tuple(problem.regressors)
    if series:
        found.append((_memories(problem), len(names), False))
        names = (*names, MEMORY)
    columns, group, curved = [np.empty((problem.residual.size, 0))], [], []
    for basis, number, slow in found:
        for o in range(len(problem.outputs)):
            rows = problem.output == o
            local = np.where(rows[:, None], basis, 0.0)
            rms = np.sqrt(np.sum(local**2, axis=0) / max(int(rows.sum()), 1))
            used = rms > 1e-12
            columns.append(local[:, used] / rms[used])
            group += [number] * int(used.sum())
            curved += [slow] * int(used.sum())
    return Features(
        np.hstack(columns), np.array(group, dtype=np.int64), names, np.array(curved, dtype=bool)
    )


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


def _curves(values: FloatArray) -> FloatArray:
    """A straight line, a parabola and a cubic in the signal."""
    spread = float(values.std())
    if spread <= 0:
        return np.empty((values.size, 0))
    u = np.clip((values - values.mean()) / spread, -_FARTHEST, _FARTHEST)
    return np.stack([u, u**2 - 1.0, u**3 - 3.0 * u], axis=1)


_FARTHEST = 2.5  # a signal counts up to so many of its sd


def _memories(problem: Problem) -> FloatArray:
    """Each regressor less its exponentially forgotten past, at several time constants."""
    from scipy.signal import lfilter

    starts = starts_of(problem.sequence)
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
