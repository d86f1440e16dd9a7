"""The one fit where a record is reduced so far that no residual is left: a cost and its curvature.

A cost on a Gram matrix whose weights depend on the unknowns (errors in the regressors) is no sum of
squares of rows; `fit_map` serves the others. The unknowns may be curved (rotations): steps are
taken where the point is, by whatever moves it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

import numpy as np

from footcal_cli.core.parameters import FloatArray

_DECREMENT = 1e-10
"""Of the cost: what the last step may promise. It goes a hundred-thousandth of a sd, and what then
remains is a small part of that."""
_REMAINS = 1e-15
"""Of the cost: what a next step would promise, from which it is not taken."""
_ROUNDING = 1e-12
"""Of a cost, which a sum of squares loses: what a step promises below that is not seen."""
_FIRST_DAMPING = 1e-9
_LEAST_RETRY = 1e-4
_EASE = 0.01
_GIVE_UP = 1e10
_NEARLY = 1e-3

PointT = TypeVar("PointT")
StateT = TypeVar("StateT", bound="Curved")


class Curved(Protocol):
    """A cost at a point, −log of a posterior density, and its derivatives by a step from there."""

    @property
    def cost(self) -> float:
        """Its value."""

    @property
    def gradient(self) -> FloatArray:
        """Shape (n,)."""

    def hessian(self) -> FloatArray:
        """Expected curvature, positive definite, shape (n, n)."""


@dataclass(frozen=True)
class Descent(Generic[PointT, StateT]):
    """Where a descent ended, after how many steps, whether at a minimum, or given up."""

    point: PointT
    state: StateT
    steps: int
    converged: bool
    given_up: bool = False


def newton_step(state: Curved, damping: float = 0.0) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The step to the minimum of a quadratic cost, of unknowns in any units.

    Returns
    -------
    step, scaled, scale
        ``−H⁻¹ g``, shape (n,), and H = scaled / (scale scaleᵀ) with a unit diagonal; `damping` is
        added to that (Levenberg and Marquardt).
    """
    metric = state.hessian()
    scale = 1.0 / np.sqrt(np.maximum(np.diag(metric), np.finfo(float).tiny))
    scaled = metric * np.outer(scale, scale)
    damped = scaled + damping * np.eye(scale.size)
    return -scale * np.linalg.solve(damped, scale * state.gradient), scaled, scale


def descend(
    at: Callable[[PointT], StateT],
    move: Callable[[PointT, FloatArray], PointT],
    begin: PointT,
    most_steps: int = 100,
    hopeless: Callable[[StateT, float], bool] | None = None,
) -> Descent[PointT, StateT]:
    """Levenberg-Marquardt on the expected curvature.

    Parameters
    ----------
    move
        The point that a step (n,) leads to.
    hopeless
        Whether to give up at a state from which an undamped step promises so much of the cost.
    """
    point, state, damping, before = begin, at(begin), _FIRST_DAMPING, 0.0
    for steps in range(1, most_steps + 1):
        step, _, _ = newton_step(state, damping)
        promised = float(-0.5 * state.gradient @ step)
        if hopeless is not None and damping < _LEAST_RETRY and hopeless(state, promised):
            return Descent(point, state, steps, converged=False, given_up=True)
        # near a minimum promises shrink by the same factor in each step, or by more
        ratio = min(promised / before, 1.0) if before > 0.0 and damping < _LEAST_RETRY else 1.0
        settled, before = promised < _DECREMENT or promised * ratio < _REMAINS, promised
        candidate = move(point, step)
        tried = at(candidate)
        # so little is lost in the cost's rounding, not in the gradient's
        last = settled and damping < _LEAST_RETRY
        if last or tried.cost <= state.cost + _ROUNDING * abs(state.cost):
            point, state, damping = candidate, tried, _EASE * damping
            if settled:
                return Descent(point, state, steps, True)
        # shorter steps would show nothing either: the gradient is more exact than the cost
        elif damping < _LEAST_RETRY and promised < max(_DECREMENT, _ROUNDING * abs(state.cost)):
            return Descent(candidate, tried, steps, True)
        else:
            damping = max(10.0 * damping, _LEAST_RETRY)
            if damping > _GIVE_UP:
                return Descent(point, state, steps, promised < _NEARLY)
    return Descent(point, state, most_steps, False)
