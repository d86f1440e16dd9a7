"""Any linear mixture of a foot's readings: what crosstalk or a cell elsewhere could be.

Each cell may hear every other cell of its foot by a share of its own. Beside free gains these
mixtures span crosstalk of any pattern and, where a foot stands on one plane, cells at any places:
``Σ_i p_i κ_ij`` is any shift of cell j that a moment can show. One effect of the table is a single
pattern of them. Where another pattern is left beside it, data cannot tell which mixture it is.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footcal_cli.core.diagnosis.answer import Cause
from footcal_cli.core.diagnosis.unnamed import Unnamed, left_beside
from footcal_cli.core.effects import having
from footcal_cli.core.effects.cells import mixing
from footcal_cli.core.effects.contract import (
    Effect,
    EffectParameter,
    Scope,
    Stage,
    State,
    Theta,
    Trait,
    columns_of,
    is_six_axis,
    on_readings,
)
from footcal_cli.core.inference.case import Case, channels_of
from footcal_cli.core.inference.linear import unit_columns
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.inference.signatures import derivative
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray

LINEAR = having(Trait.MIXTURE)
"""Names of one pattern of mixtures."""


def _mixed(x: FloatArray, log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    return x @ mixing(log, theta["heard"], theta["heard_from"]).T, state


def _unmixed(y: FloatArray, log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    own = np.linalg.solve(mixing(log, theta["heard"], theta["heard_from"]), y.T).T
    return np.asarray(own, dtype=np.float64), state


MIXTURE = Effect(
    name="mixture",
    stage=Stage.CELL,
    scope=Scope.CHANNEL,
    parameters=(
        EffectParameter("heard", "-", 0.0, -0.4, 0.4, 0.02),
        EffectParameter("heard_from", "channel", 1.0, 1.0, 127.0, 1.0, shape=True),
    ),
    apply=on_readings(_mixed),
    remove=on_readings(_unmixed),
    experiments=(),
    formula="y_i = x_i + κ · x_j; sums of them are any linear mixture of a foot's readings",
    source="a basis, no effect of the table",
    remedy="",
)


def applies_to(case: Case, causes: Sequence[Cause]) -> bool:
    """Whether mixtures are another explanation: a cause is one pattern of them, not a set of two.

    Rivals of both kinds say already that these data cannot tell which mixture it is.
    """
    kinds = [LINEAR & c.effects for c in causes]
    single = any(len(kind) == 1 for kind in kinds)
    return single and not is_six_axis(channels_of(case.logs))


def mixtures_of(ideal: Case, rows: Problem) -> FloatArray:
    """What each cell hearing each other cell of its foot adds, at unit RMS, shape (m, mixtures).

    Parameters
    ----------
    ideal
        The model's recordings, without noise.
    rows
        Which errors count.
    """
    seen = ideal.memory()
    found = [
        derivative(
            ideal,
            rows,
            MIXTURE,
            MIXTURE.size,
            {cell: (cell,)},
            {"heard_from": float(before)},
            seen=seen,
        )
        for cells in _feet(ideal)
        for cell in cells
        for before in range(1, len(cells))
    ]
    return unit_columns(np.array(found).reshape(len(found), rows.residual.size).T)


def _feet(case: Case) -> list[tuple[str, ...]]:
    """Channels of each foot with several cells."""
    feet = (
        tuple(log.channels[c] for c in cells)
        for log in case.logs
        for cells in columns_of(Scope.FOOT, log.channels)
    )
    return [cells for cells in dict.fromkeys(feet) if len(cells) > 1]


def against_mixtures(after: Problem, mixtures: FloatArray, signs: FloatArray) -> Unnamed:
    """Judge the named causes by what mixtures explain beside them.

    In their place mixtures explain as much by design, which says nothing.

    Parameters
    ----------
    after
        The problem on the extended model.
    mixtures
        From `mixtures_of`.
    signs
        Sign patterns of the blocks.
    """
    return Unnamed(left_beside(after, (mixtures,), signs), rival=False, as_form=True)
