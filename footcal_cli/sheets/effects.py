"""``footcal effects --check``: whether own effects keep the contract, and what they are like."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from footcal_cli.core.diagnosis.rehearsal import Rehearsal
    from footcal_cli.core.effects.contract import Effect
    from footcal_cli.core.parameters import FloatArray

_PLAN_OF = {
    "weights": "up_down", "placements": "holes", "stand": "stand_turned", "walk": "walk_slow_fast",
    "hang": "hang", "pose": "pose_tilted",
}  # fmt: skip
_ALIKE = 0.95
_SHOWN = 3


def checked(own: Sequence[Effect], table: Mapping[str, Effect]) -> tuple[str, bool]:
    """What is found of each effect as text, and whether all keep the contract."""
    from footcal_cli.core.effects.promises import promises_of

    lines, sound = [], True
    for effect in own:
        lines += [effect.name, "=" * len(effect.name), f"formula  {effect.formula}"]
        for promise in promises_of(effect):
            sound &= promise.kept
            lines.append(f"{'ok' if promise.kept else 'FAILS':<8} {promise.says} ({promise.found})")
        lines += [
            "",
            "likeness to the table's effects, 1 being identical (|cos| once the calibration is "
            "fitted, in a planned experiment):",
        ]
        for experiment in effect.experiments:
            others = [e for e in table.values() if experiment in e.experiments]
            lines.append(f"  {experiment:<11} {_likeness(effect, experiment, others)}")
        lines.append("")
    return "\n".join(lines).rstrip(), sound


def _likeness(effect: Effect, experiment: str, others: Sequence[Effect]) -> str:
    import numpy as np

    from footcal_cli.core.diagnosis.plans import PLANS
    from footcal_cli.core.diagnosis.rehearsal import rehearsed
    from footcal_cli.core.diagnosis.rig import Rig

    plan = next(plan for plan in PLANS if plan.id == _PLAN_OF[experiment])
    there = rehearsed(plan, Rig())
    mine = _shown(there, effect)
    if not mine:
        return "the calibration absorbs it"
    found: dict[str, float] = {}
    for other in others:
        for a, b in product(mine, _shown(there, other)):
            cosine = abs(float(a @ b)) / float(np.sqrt((a @ a) * (b @ b)))
            found[other.name] = max(found.get(other.name, 0.0), cosine)
    nearest = sorted(found, key=lambda name: -found[name])[:_SHOWN]
    said = ", ".join(f"{name} {found[name]:.3f}" for name in nearest)
    if nearest and found[nearest[0]] > _ALIKE:
        said += f"  (these data cannot distinguish it from {nearest[0].replace('_', ' ')})"
    return said


def _shown(there: Rehearsal, effect: Effect) -> list[FloatArray]:
    """What an effect adds beside the calibration, for each size and shape; none where it hides."""
    from footcal_cli.core.inference.problem import Signature

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
