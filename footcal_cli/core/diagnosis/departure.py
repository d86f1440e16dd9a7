"""How far a known calibration must move for a model: evidence that no block alone holds.

Of the room of the diagnosis; `footcal_cli.core.diagnosis.standing` asks.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core import chances
from footcal_cli.core.inference.grams import calibration_grams
from footcal_cli.core.inference.linear import left_by
from footcal_cli.core.inference.problem import Problem, Signature
from footcal_cli.core.inference.scores import coefficients
from footcal_cli.core.inference.whitening import Noise

_RANK = 1e-12
_FAR = 0.01
_WITHIN = 1e-3
"""Share of a cause's square beside the calibration's columns, below which it is one of them."""
_HELD = 1e6
"""Times the precision with which a calibration was known, that holds it there."""


@dataclass(frozen=True)
class Departure:
    """Distance of the fitted calibration from the known one, ``D = θᵀ K θ``, K its precision.

    Parameters
    ----------
    before, after
        Without and with the named causes.
    directions, causes
        In how many directions something was known, and how many sizes are named.
    among
        Number of independent tests that the causes were chosen among.
    """

    before: float
    after: float
    directions: int
    causes: int
    among: float

    @property
    def p(self) -> float:
        """That names which are nothing bring the calibration so much nearer.

        ``F = ((D₀ − D₁) / k) / max(D₁ / (n − k), 1)``: the stated sd may be too small, which what
        is left tells, and is not taken to be too large. The best of m tests has at most
        ``1 − (1 − p)ᵐ`` [Šidák], and no more than all directions together [Scheffé].
        """
        freedom = self.directions - self.causes
        if freedom < 1:
            return 1.0
        spared = (self.before - self.after) / max(self.after / freedom, 1.0)
        one = float(chances.f_sf(spared / self.causes, self.causes, freedom))
        best = 1.0 if one == 1.0 else float(-np.expm1(self.among * np.log1p(-one)))
        whole = float(chances.f_sf(spared / self.directions, self.directions, freedom))
        return min(best, max(whole, one))

    @property
    def far(self) -> bool:
        """Whether the calibration must still be off by more than its sd allows, χ², 1 %."""
        return bool(chances.chi2_sf(self.after, max(self.directions, 1)) < _FAR)


def departure_of(
    before: Problem, after: Problem, noise: Noise, causes: int, among: float
) -> Departure | None:
    """The distances of two models in one noise; None where nothing was known of a calibration.

    Parameters
    ----------
    before, after
        The baseline and the problem on the extended model.
    noise
        In which both are fitted.
    causes, among
        Number of named sizes, and of independent tests that they were chosen among.
    """
    if before.known is None or after.known is None:
        return None
    spread = np.linalg.eigvalsh(before.known)
    directions = int(np.sum(spread > _RANK * spread.max(initial=0.0)))
    return Departure(_of(before, noise), _of(after, noise), directions, causes, among)


def of_calibration(problem: Problem, named: Sequence[Signature]) -> bool:
    """Whether a known calibration could take up a named cause whole, so that no block tells it."""
    at = [problem.signatures.index(one) for one in named if one in problem.signatures]
    if problem.known is None or not at:
        return False
    columns = problem.columns[:, at]
    left = left_by(problem.calibration, columns, _RANK)
    share = np.einsum("ij,ij->j", left, left) / np.einsum("ij,ij->j", columns, columns)
    return bool(np.any(share < _WITHIN))


def as_known(problem: Problem) -> Problem:
    """The problem with its calibration held at what was known of it."""
    assert problem.known is not None
    return replace(problem, known=_HELD * problem.known)


def _of(problem: Problem, noise: Noise) -> float:
    grams = calibration_grams(problem, noise, counted=False)
    base = grams.calibration
    total = grams.inner.summed(np.append(base, grams.inner.last))
    moved = coefficients(total, np.arange(base.size), np.array([base.size]))[:, 0]
    assert problem.known is not None
    moved = moved[: len(problem.known)]
    return float(moved @ problem.known @ moved)
