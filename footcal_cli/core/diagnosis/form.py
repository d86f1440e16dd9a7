"""Has a named effect the same size everywhere? An impostor has not."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footcal_cli.core.diagnosis.detection import flexible_gain
from footcal_cli.core.inference.evidence import sign_flip_group
from footcal_cli.core.inference.grams import whitened_grams
from footcal_cli.core.inference.linear import unit_columns
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.inference.scores import scores
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.signals import starts_of

FORM = 2.0
"""So many times as much must the wrong kind leave to the right one, as that leaves to it. Of six
loops (Bouc and Wen, Dahl, Preisach) and nine creeps (two stages, logarithm, powers, load-dependent,
slower in recovery) on four ladders of four to nine loads, 5 to 20 s each, without noise, the wrong
kind leaves more in 55 of 60 cases, and in none less than half as much."""
_FARTHEST = 2.5  # a regressor counts up to this many of its sd


@dataclass(frozen=True)
class Form:
    """How well the form of the named effects fits.

    Parameters
    ----------
    p
        That their sizes change with nothing that was recorded.
    gain
        Held-out squared error per block that sizes which do change would remove, as the user
        counts it, shape (B,).
    """

    p: float
    gain: FloatArray

    @property
    def bought(self) -> float:
        """Squared error that changing sizes would remove."""
        return max(float(self.gain.sum()), 0.0)


def form_of(problem: Problem, named: FloatArray, signs: FloatArray) -> Form:
    """Test the named effects' sizes against every recorded signal.

    A true effect g has one coefficient: its products with a centred signal u, ``g·u`` and
    ``g·(u² − 1)``, with the direction of a rate and with the time within a recording, add nothing
    once g is in the model. Mean squared standardised block score of all products, by sign flips.

    Parameters
    ----------
    problem
        The model whose residual is judged; what it has accepted is fitted.
    named
        Row columns of the named effects, shape (m, k).
    signs
        Sign patterns of the blocks.
    """
    products = _products(problem, named)
    grams, _ = whitened_grams(problem.without_candidates, products)
    base = grams.calibration
    p = sign_flip_group(scores(grams.inner, base, grams.features).score, signs)
    return Form(p, flexible_gain(grams, base, [grams.features])[1])


def _products(problem: Problem, named: FloatArray) -> FloatArray:
    """Named columns times centred signals, at unit RMS, shape (m, products)."""
    factors: list[FloatArray] = []
    for name, values in problem.regressors.items():
        if np.ptp(values) <= 0:
            continue
        if "phase" in name:
            factors += [turn(k * 2.0 * np.pi * values) for k in (1, 2) for turn in (np.sin, np.cos)]
            continue
        u = np.clip((values - values.mean()) / values.std(), -_FARTHEST, _FARTHEST)
        factors.append(u)
        if "×" not in name:
            factors.append(u**2 - 1.0)
        if "rate" in name or "step" in name:
            factors.append(np.sign(values))
    if problem.rate_hz > 0:
        factors.append(_share_of_sequence(problem))
    columns = np.hstack([named * f[:, None] for f in factors]) if factors else named[:, :0]
    return unit_columns(columns)


def _share_of_sequence(problem: Problem) -> FloatArray:
    """Time within each sequence from −1 to 1, shape (m,)."""
    starts = starts_of(problem.sequence)
    lengths = np.diff(np.append(starts, problem.sequence.size))
    age = np.arange(problem.sequence.size) - np.repeat(starts, lengths)
    return np.asarray(2.0 * age / np.repeat(np.maximum(lengths - 1, 1), lengths) - 1.0)
