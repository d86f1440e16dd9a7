"""How much of each output's error repeats and has no name, in its own unit, and whether it matters.

Identity and importance are two sentences: what has no name is a finding only where it is larger
than what matters to the user.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core import chances
from footcal_cli.core.diagnosis.features import MEMORY, Features
from footcal_cli.core.diagnosis.gain import output_losses, without_rivals
from footcal_cli.core.diagnosis.jumps import means_of_blocks, taken_from_each
from footcal_cli.core.inference.case import Case
from footcal_cli.core.inference.linear import orthonormal, scaled_inverse
from footcal_cli.core.inference.lines import Line
from footcal_cli.core.inference.problem import Problem, Signature
from footcal_cli.core.inference.refit import Refit
from footcal_cli.core.parameters import FloatArray

MOST = 3.0
"""Times what matters: a larger error as a whole is a finding whatever of it repeats."""
_RCOND = 1e-9
_RIDGE = 0.01
"""Of the mean information of a column: a signal that half the blocks hardly have says nothing."""
_ONE = (Signature("residual", "", "", ""),)


@dataclass(frozen=True)
class Nameless:
    """What of one output's error repeats from block to block without a sure name.

    Parameters
    ----------
    output, unit
        The quantity.
    rms, whole, white
        Of the part that repeats, of all of the held-out error, and of what is new in each row.
    smallest
        RMS error from which it matters.
    """

    output: str
    unit: str
    rms: float
    whole: float
    white: float
    smallest: float

    @property
    def lasting(self) -> float:
        """RMS of the error without what is new in each row."""
        return float(np.sqrt(max(self.whole**2 - self.white**2, 0.0)))

    @property
    def repeats_much(self) -> bool:
        """Whether the part that repeats is as large as what matters."""
        return self.rms >= self.smallest

    @property
    def matters(self) -> bool:
        """Whether it is as large as what matters, or all that is left is no noise of this robot."""
        return self.repeats_much or self.lasting >= MOST * self.smallest


def nameless_of(
    case: Case, baseline: Problem, current: Problem, model: Refit | None, repeats: FloatArray
) -> tuple[Nameless, ...]:
    """``√(e² − e₁² + g²)`` of each output: what unsure names remove, and what repeats beside them.

    Parameters
    ----------
    case
        Says what matters.
    baseline, current, model
        The problem without names, on the model with the unsure ones, and that model; twice the same
        and None without any.
    repeats
        From `repeating`, of `current`.
    """
    rows = np.bincount(baseline.output, minlength=len(baseline.outputs))
    unit_noise = np.array(
        [float(baseline.noise[baseline.output == o][:1].sum()) for o in range(rows.size)]
    )
    squared = repeats * unit_noise**2
    noise, share = current.law, unit_noise**2 / np.maximum(rows, 1)
    whole = share * output_losses(current if model is None else baseline, noise).sum(axis=0)
    if model is not None:
        after = share * output_losses(without_rivals(current, model), noise).sum(axis=0)
        squared += np.maximum(whole - after, 0.0)
    if baseline.pieces:
        # a stance left out is far off where the others do not know the calibration
        whole = np.minimum(whole, unit_noise**2 * _surely(current if model is None else baseline))
    smallest = [
        max(case.tolerance_nm, case.finding_nm)
        if unit == "Nm"
        else max(case.tolerance_n, case.finding_n)
        for unit in baseline.units
    ]
    return tuple(
        Nameless(name, unit, float(np.sqrt(s)), float(np.sqrt(w)), float(white), least)
        for name, unit, s, w, white, least in zip(
            baseline.outputs,
            baseline.units,
            squared,
            whole,
            noise.whitener.sd * unit_noise,
            smallest,
            strict=True,
        )
    )


def _surely(problem: Problem) -> FloatArray:
    """Mean square of the error of each output that stances surely have, (outputs,).

    ``Σ e² / χ²₀.₉₅(ν)`` of their means about the fit, ν stances less what was fitted to it.
    """
    outputs = len(problem.outputs)
    mean = means_of_blocks(problem, np.column_stack([problem.residual, problem.fitted]))
    basis = orthonormal(mean[:, 1:], _RCOND)
    left = mean[:, 0] - basis @ (basis.T @ mean[:, 0])
    squares = np.sum(left.reshape(-1, outputs) ** 2, axis=0)
    free = problem.blocks - taken_from_each(basis, outputs)
    return np.array([
        s / chances.chi2_isf(0.05, nu) if nu > 1.0 else 0.0
        for s, nu in zip(squares.tolist(), free.tolist(), strict=True)
    ])  # fmt: skip


def line_over_smallest(problem: Problem, line: Line, found: Sequence[Nameless]) -> float:
    """RMS of a line over what matters of its output; infinite where its channel is no output."""
    if problem.traces is None or problem.raw is not None or line.name not in problem.traces.names:
        return np.inf
    mine = problem.traces.channel == problem.traces.names.index(line.name)
    output, noise = problem.output[mine][0], float(problem.noise[mine][0])
    return float(line.rms * noise / found[output].smallest)


def left_over(problem: Problem) -> FloatArray:
    """Residual after the calibration and accepted effects, in units of noise, shape (m,)."""
    bare = replace(problem, columns=problem.residual[:, None], signatures=_ONE)
    return bare.left()[:, 0]


def repeating(problem: Problem, features: Features, bends_with: str = "") -> FloatArray:
    """Mean square of what the recorded signals explain of the residual again and again, (outputs,).

    A function of the signals is fitted to every other block, another one to the blocks between. The
    mean of their product is ``g²`` without bias, however the noise within blocks is correlated.

    Parameters
    ----------
    bends_with
        The signal that the residual surely bends with, if any: of single observations there are too
        few for a function of all signals, and curves in that one are what is known to repeat.
    """
    left = left_over(problem)
    found = np.zeros(len(problem.outputs))
    odd = problem.block % 2 == 1
    lasting = np.array([name == MEMORY for name in features.names], dtype=bool)[features.group]
    columns = features.columns[:, ~lasting]
    sure = features.curved & (np.array(features.names)[features.group] == bends_with)
    for o in range(found.size):
        mine = problem.output == o
        basis = columns[:, np.any(columns[mine] != 0.0, axis=0)]
        halves = [mine & odd, mine & ~odd]
        rows = min(int(half.sum()) for half in halves)
        if rows <= 2 * basis.shape[1]:
            basis = features.columns[:, sure & np.any(features.columns[mine] != 0.0, axis=0)]
        if rows <= 2 * basis.shape[1] or not basis.shape[1]:
            continue
        fits = [basis[mine] @ _fitted(basis[half], left[half]) for half in halves]
        found[o] = max(float(np.mean(fits[0] * fits[1])), 0.0)
    return found


def _fitted(basis: FloatArray, target: FloatArray) -> FloatArray:
    normal = basis.T @ basis
    normal[np.diag_indices_from(normal)] += _RIDGE * float(np.mean(np.diag(normal)))
    return np.asarray(scaled_inverse(normal, _RCOND) @ (basis.T @ target))
