"""A rival without a name: any curve of the cells' own loads, whether or not the table has it.

Tests that know no cause see a stance or a step only through its posture or its phase. A curve that
the table lacks shows there as whatever else those loads resemble: crosstalk, a bypass, both. A
named cause of another nature must therefore leave nothing to such curves, and must still explain
something beside them.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from footcal_cli.core.diagnosis.answer import Cause
from footcal_cli.core.diagnosis.detection import flexible_gain
from footcal_cli.core.diagnosis.form import FORM, Form
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.effects import having
from footcal_cli.core.effects.contract import (
    Effect,
    EffectParameter,
    Scope,
    Stage,
    State,
    Theta,
    Trait,
    is_six_axis,
    on_readings,
)
from footcal_cli.core.inference.case import Case, channels_of
from footcal_cli.core.inference.evidence import sign_flip_group
from footcal_cli.core.inference.grams import whitened_grams
from footcal_cli.core.inference.linear import unit_columns
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.inference.scores import held_out_loss, scores
from footcal_cli.core.inference.signatures import derivative
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray

CURVES = having(Trait.CURVE)
"""Names of a curve of a cell's own load: what is left of one is recognised by its form."""
KNEES = (0.2, 0.5, 0.8)
"""Quantiles of a cell's load at which the curve may bend."""
_CARRIES = 0.05  # of its largest load, from which a cell carries something


def _bent(x: FloatArray, _log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    return x + theta["gain"] * np.maximum(x - theta["knee"], 0.0), state


def _straight(y: FloatArray, _log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    above = np.maximum(y - theta["knee"], 0.0)
    return y - theta["gain"] / (1.0 + theta["gain"]) * above, state


KNEE = Effect(
    name="knee",
    stage=Stage.CELL,
    scope=Scope.CHANNEL,
    parameters=(
        EffectParameter("gain", "-", 0.0, -0.5, 0.5, 0.02),
        EffectParameter("knee", "N", 1.0, 0.0, np.inf, 1.0, shape=True),
    ),
    apply=on_readings(_bent),
    remove=on_readings(_straight),
    experiments=(),
    formula="y = x + g · max(x − k, 0); sums of them are any piecewise straight curve",
    source="a basis, no effect of the table",
    remedy="",
)


@dataclass(frozen=True)
class Curves:
    """Piecewise straight curves of the cells' loads.

    Parameters
    ----------
    shared
        What one curve of all cells adds to the residual, knee by knee, shape (m, knees).
    own
        The same for each cell, shape (m, cells knees).
    """

    shared: FloatArray
    own: FloatArray


@dataclass(frozen=True)
class Unnamed:
    """How the named causes stand against curves without a name.

    Parameters
    ----------
    left
        What curves explain beside them.
    rival
        Whether a curve of all cells does in their place, so that they add nothing beside it.
    as_form
        Whether what is left is a fault in the form of the names: where it is linear like them, or a
        curve of the same readings.
    smallest
        Squared error from which what is left matters, whatever share of the names it is.
    """

    left: Form
    rival: bool
    as_form: bool = False
    smallest: float = np.inf

    def spoils(self, removed: float, rules: Rules, *, several: bool = False) -> bool:
        """Whether the names cannot be said for them.

        As of a later cause, a small share beside what the names remove may be what their own form
        gets wrong.

        Parameters
        ----------
        removed
            Held-out squared error that the names remove.
        rules
            Thresholds.
        several
            Whether the answer is a set, which says less of a form.
        """
        beside = self.left.p < rules.alpha_form
        least = min(rules.share_form, rules.share_set) if several else rules.share_form
        allowed = 1.0 - least if self.as_form else rules.later_share
        return self.rival or (beside and self.left.bought > allowed * removed)


def curves_of(ideal: Case, rows: Problem) -> Curves:
    """Curves at the loads of the recordings, at unit RMS.

    Parameters
    ----------
    ideal
        The model's recordings, without noise.
    rows
        Which errors count.
    """
    cells = knees_of(ideal, rows, channels_of(ideal.logs))
    return Curves(
        unit_columns(cells.sum(axis=0).T), unit_columns(cells.reshape(-1, cells.shape[-1]).T)
    )


def knees_of(ideal: Case, rows: Problem, channels: Sequence[str]) -> FloatArray:
    """What knees of channels add to the residual at `KNEES` of what they carry, (c, knees, m)."""
    single = []
    for channel, load in loads_of(ideal, channels).items():
        carried = load[load > _CARRIES * np.nanmax(load)]
        knees = np.quantile(carried, KNEES) if carried.size else KNEES
        single.append(knees_at(ideal, rows, channel, knees))
    return np.array(single)


def loads_of(ideal: Case, channels: Sequence[str]) -> dict[str, FloatArray]:
    """What each channel carries in all recordings together, shape (n,) each."""
    truths = [ideal.chain.remove(log, ideal.values)[0] for log in ideal.logs]
    return {
        channel: np.concatenate(
            [t.readings[:, t.channels.index(channel)] for t in truths if channel in t.channels]
        )
        for channel in channels
    }


def knees_at(ideal: Case, rows: Problem, channel: str, knees: Iterable[float]) -> list[FloatArray]:
    """What a knee of a channel adds to the residual at each of some loads, shape (m,) each."""
    owners, seen = {channel: (channel,)}, ideal.memory()
    return [
        derivative(ideal, rows, KNEE, KNEE.size, owners, {"knee": float(knee)}, seen=seen)
        for knee in knees
    ]


def applies(problem: Problem, case: Case, causes: Sequence[Cause]) -> bool:
    """Whether curves are another explanation: of cells whose loads no other test looks at.

    Where the load itself is recorded beside the readings (`Problem.regressors`) the tests that know
    no cause hold every curve of it; a curve among the causes or their rivals is judged by its form.
    """
    named = {effect for c in causes for effect in c.effects}
    unseen = "load" not in problem.regressors
    return unseen and not is_six_axis(channels_of(case.logs)) and not CURVES & named


def against_curves(
    before: Problem,
    after: Problem,
    named: FloatArray,
    curves: Curves,
    signs: FloatArray,
    rules: Rules,
) -> Unnamed:
    """Judge the named causes against curves.

    Parameters
    ----------
    before, after
        The baseline, and the problem on the extended model.
    named
        What the named sizes add to the residual, shape (m, k).
    curves
        From `curves_of`.
    signs
        Sign patterns of the blocks.
    rules
        Thresholds.
    """
    left = left_beside(after, (curves.shared, curves.own), signs)
    less = left.p < rules.alpha_form
    return Unnamed(left, _replaces(before, after, named, curves.shared, signs, rules, less=less))


def left_beside(after: Problem, families: Sequence[FloatArray], signs: FloatArray) -> Form:
    """What families of columns explain beside the named causes; the gain is that of the first.

    Parameters
    ----------
    after
        The problem on the extended model.
    families
        Columns of each, shape (m, k).
    signs
        Sign patterns of the blocks.
    """
    grams, _ = whitened_grams(after.without_candidates, np.hstack(families))
    ends = np.cumsum([family.shape[1] for family in families])
    parts = np.split(grams.features, ends[:-1])
    base = grams.calibration
    p = min(sign_flip_group(scores(grams.inner, base, part).score, signs) for part in parts)
    return Form(min(len(parts) * p, 1.0), flexible_gain(grams, base, parts[:1])[1])


def _replaces(
    before: Problem,
    after: Problem,
    named: FloatArray,
    curve: FloatArray,
    signs: FloatArray,
    rules: Rules,
    *,
    less: bool,
) -> bool:
    """Whether a curve is a rival of the named causes, by the rule for rivals with a name.

    Or because neither is all, and the curve leaves to the names less than `FORM` times what they
    leave to it (`less`: that is surely something).
    """
    grams, _ = whitened_grams(before.without_candidates, np.hstack([curve, named]), after.law)
    bent, mine = np.split(grams.features, [curve.shape[1]])
    base = grams.calibration
    start, with_curve, with_names, with_both = (
        float(held_out_loss(grams.inner, np.concatenate([base, part])).sum())
        for part in (base[:0], bent, mine, grams.features)
    )
    if start - with_curve < rules.rival_share * (start - with_names):
        return False
    if less and with_curve - with_both < FORM * (with_names - with_both):
        return True
    beside = scores(grams.inner, np.concatenate([base, bent]), mine).score
    return sign_flip_group(beside, signs) > rules.alpha_beside
