"""How alike an effect is to those of the table, in planned experiments."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np

from footcal_cli.core.diagnosis.plans import PLANS
from footcal_cli.core.diagnosis.rehearsal import Rehearsal, rehearsed
from footcal_cli.core.diagnosis.rig import Rig
from footcal_cli.core.effects.contract import Effect
from footcal_cli.core.inference.problem import Signature
from footcal_cli.core.parameters import FloatArray

_PLAN_OF = {
    "weights": "up_down", "placements": "holes", "stand": "stand_turned", "walk": "walk_slow_fast",
    "hang": "hang", "pose": "pose_tilted",
}  # fmt: skip


def likeness(effect: Effect, experiment: str, others: Sequence[Effect]) -> dict[str, float]:
    """Largest |cos| of an effect with each other one once the calibration is fitted.

    Over all sizes and shapes of both; empty where the calibration absorbs the effect.
    """
    plan = next(plan for plan in PLANS if plan.id == _PLAN_OF[experiment])
    there = rehearsed(plan, Rig())
    mine = _shown(there, effect)
    found: dict[str, float] = {}
    for other in others if mine else ():
        for a, b in product(mine, _shown(there, other)):
            cosine = abs(float(a @ b)) / float(np.sqrt((a @ a) * (b @ b)))
            found[other.name] = max(found.get(other.name, 0.0), cosine)
    return found


def _shown(there: Rehearsal, effect: Effect) -> list[FloatArray]:
    """What an effect adds beside the calibration, for each size and shape; none where it hides."""
    signature = Signature(effect.name, effect.size.name, "", effect.size.unit)
    forms = [
        dict(zip((p.name for p in effect.shapes), values, strict=True))
        for values in product(*((p.grid or (p.neutral,)) for p in effect.shapes))
    ]
    found = []
    for size, form in product(effect.sizes, forms):
        value = size.neutral + (size.prior_sd if size.neutral < size.upper else -size.prior_sd)
        shown = there.shown(effect, signature, {**form, size.name: value})
        if shown @ shown > 0.0:
            found.append(shown)
    return found
