"""What the calibration does when an effect enters the model, in units of its own uncertainty."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.inference.case import Case
from footcal_cli.core.inference.grams import calibration_grams
from footcal_cli.core.inference.linear import scaled_inverse
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.parameters import FloatArray


@dataclass(frozen=True)
class Movement:
    """One calibration parameter before and after.

    Parameters
    ----------
    name, unit
        Of the parameter.
    before, after
        Refitted without and with the effects.
    sd
        Standard deviation without the effects.
    """

    name: str
    unit: str
    before: float
    after: float
    sd: float

    @property
    def in_sd(self) -> float:
        """How far it moved in units of its own sd."""
        return (self.after - self.before) / self.sd if self.sd > 0 else 0.0


def movements(case: Case, before: Problem, after: Problem) -> tuple[Movement, ...]:
    """Generalised least squares of the calibration on both models; none where it drifts.

    The effects stay at their sizes: were they and their rivals free beside it, the calibration
    would be that of all of them together, which no model has, and as unsure as they are alike.
    """
    turn, turned = before.calibration_turn, after.calibration_turn
    if case.drifts or turn is None or turned is None:
        return ()
    # an extended model is differentiated anew: its columns are directions of their own
    first, cov = _calibrated(before)
    second, _ = _calibrated(replace(after, accepted=None))
    old, new = -turn @ first, -turned @ second
    sd = np.sqrt(np.clip(np.einsum("ij,jk,ik->i", turn, cov, turn), 0.0, None))
    found = []
    for i, parameter in enumerate(case.calibration):
        at = case.values.get(parameter.name, parameter.value)
        found.append(
            Movement(
                parameter.name, parameter.unit, at + float(old[i]), at + float(new[i]), float(sd[i])
            )
        )
    return tuple(found)


def _calibrated(problem: Problem) -> tuple[FloatArray, FloatArray]:
    """Coefficients of the calibration columns and their covariance."""
    grams = calibration_grams(problem)
    total = grams.inner.summed(np.append(grams.calibration, grams.inner.last))
    inverse = scaled_inverse(total[:-1, :-1], 1e-12)
    p = problem.calibration.shape[1]
    return np.asarray(inverse @ total[:-1, -1])[:p], np.asarray(inverse[:p, :p])
