"""Two memories of past loads against each other, each in every form of its kind.

What one loop of hysteresis gets wrong another one with a longer reach makes good: plays of several
reaches add up to any rate-independent loop (Prandtl and Ishlinskii), and several time constants to
any linear creep. Which kind of memory it is must not hang on the one shape that a refit found.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from footcal_cli.core.diagnosis.answer import Cause
from footcal_cli.core.diagnosis.rivals import Tried
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.subject import Subject
from footcal_cli.core.effects import having
from footcal_cli.core.effects.contract import Effect, Trait
from footcal_cli.core.inference.evidence import sign_flip_mean
from footcal_cli.core.inference.grams import calibration_grams
from footcal_cli.core.inference.linear import unit_columns
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.inference.scores import held_out_loss
from footcal_cli.core.inference.whitening import Noise
from footcal_cli.core.parameters import FloatArray

MEMORIES = having(Trait.SPECTRUM)
FORM = 2.0
"""So many times as much must the wrong kind leave to the right one, as that leaves to it. Of six
loops (Bouc and Wen, Dahl, Preisach) and nine creeps (two stages, logarithm, powers, load-dependent,
slower in recovery) on four ladders of four to nine loads, 5 to 20 s each, without noise, the wrong
kind leaves more in 55 of 60 cases, and in none less than half as much."""


def surer(
    subject: Subject, one: Tried, other: Tried, noise: Noise, signs: FloatArray, rules: Rules
) -> bool:
    """Whether one memory explains what another kind of it does not, whatever the form of each.

    ``E_j = L(kind j) − L(both kinds)`` is what a kind leaves to the other one on left-out blocks;
    ``E_other > 2 E_one`` by the signs of the blocks.
    """
    if not _of_two_kinds(subject.table, one.cause, other.cause):
        return False
    mine, its = (_every_form(subject, t.cause) for t in (one, other))
    both = left_with(one.bare, np.hstack([mine, its]), noise)
    excess = left_with(one.bare, mine, noise) - both
    others = left_with(other.bare, its, noise) - both
    return sign_flip_mean(others - FORM * excess, signs) < rules.alpha_left


def _of_two_kinds(table: Mapping[str, Effect], one: Cause, other: Cause) -> bool:
    """Whether both are memories, with two remedies."""
    names = {one.signature.effect, other.signature.effect}
    return names <= MEMORIES and len({table[name].remedy for name in names}) > 1


def _every_form(subject: Subject, cause: Cause) -> FloatArray:
    """The memories with a cause's remedy in its place, in every shape, shape (m, k)."""
    remedy, where = subject.table[cause.signature.effect].remedy, cause.signature.where
    columns = [
        i for i, s in enumerate(subject.problem.signatures)
        if s.effect in MEMORIES and subject.table[s.effect].remedy == remedy and s.where == where
    ]  # fmt: skip
    return unit_columns(subject.problem.columns[:, columns])


def left_with(bare: Problem, columns: FloatArray, noise: Noise) -> FloatArray:
    """Held-out squared error of each block with further columns fitted, shape (B,)."""
    grams = calibration_grams(bare.holding(columns), noise, counted=False)
    return held_out_loss(grams.inner, grams.calibration)
