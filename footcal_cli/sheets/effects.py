"""The table of effects as text: all rows, one in full, and the check of a user's own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from footcal_cli.core.diagnosis.likeness import likeness
from footcal_cli.core.effects.contract import Effect
from footcal_cli.core.effects.formula import FUNCTIONS
from footcal_cli.core.effects.own import SIGNALS
from footcal_cli.core.effects.promises import promises_of

_ALIKE = 0.95
_SHOWN = 3
_STAGE_NAMES = {
    1: "bench", 2: "body", 3: "foot", 4: "six-axis", 5: "cells", 6: "calibration", 7: "digital",
    8: "transport",
}  # fmt: skip


def signals_listed() -> str:
    """Signals and functions of formulas as aligned text."""
    rows = [("signal", "unit", "known in", "what it is")]
    rows += [(n, s.unit, " ".join(s.experiments), s.meaning) for n, s in SIGNALS.items()]
    widths = [max(len(row[i]) for row in rows) for i in range(3)]
    lines = [
        "  ".join([*(cell.ljust(w) for cell, w in zip(row, widths, strict=False)), row[-1]])
        for row in rows
    ]
    return "\n".join([*lines, f"functions: + - * / ** {' '.join(FUNCTIONS)}"])


def listed(chosen: Sequence[Effect]) -> str:
    """The table as aligned text: name, stage, owner, size with unit, experiments, remedy."""
    rows = [("effect", "stage", "per", "usual size", "seen by", "what to do about it")]
    rows += [
        (
            effect.name,
            _STAGE_NAMES[effect.stage],
            effect.scope.value,
            f"{effect.size.prior_sd:g} {effect.size.unit}".removesuffix(" -"),
            " ".join(effect.experiments),
            effect.remedy,
        )
        for effect in chosen
    ]
    widths = [max(len(row[i]) for row in rows) for i in range(5)]
    return "\n".join(
        "  ".join([*(cell.ljust(w) for cell, w in zip(row, widths, strict=False)), row[-1]])
        for row in rows
    )


def explained(effect: Effect) -> str:
    """One effect in full, as text."""
    lines = [
        effect.name,
        "=" * len(effect.name),
        f"formula       {effect.formula}",
        f"stage         {_STAGE_NAMES[effect.stage]}, one value per {effect.scope.value}",
        f"source        {effect.source}",
        f"seen by       {', '.join(effect.experiments)}",
    ]
    if effect.needs:
        lines.append(f"needs         {', '.join(effect.needs)}")
    if effect.mimics:
        lines.append(f"mimics        {', '.join(effect.mimics)}")
    if effect.separates:
        lines.append(f"separated by  {effect.separates}")
    lines += [
        f"remedy        {effect.remedy}",
        "inverse       "
        + (
            f"exact to {effect.tolerance:g}"
            if effect.invertible
            else "none: removing it is a best guess"
        ),
        "",
        "parameter                 unit      neutral    bounds               usual size",
    ]
    for p in effect.parameters:
        bounds = f"[{p.lower:g}, {p.upper:g}]"
        usual = f"shape: {p.tried}" if p.shape else f"{p.prior_sd:g}"
        lines.append(f"{p.name:<25} {p.unit:<9} {p.neutral:<10g} {bounds:<20} {usual}")
    return "\n".join(lines)


def checked(own: Sequence[Effect], table: Mapping[str, Effect]) -> tuple[str, bool]:
    """What is found of each effect as text, and whether all keep the contract."""
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
    found = likeness(effect, experiment, others)
    if not found:
        return "the calibration absorbs it"
    nearest = sorted(found, key=lambda name: -found[name])[:_SHOWN]
    said = ", ".join(f"{name} {found[name]:.3f}" for name in nearest)
    if found[nearest[0]] > _ALIKE:
        said += f"  (these data cannot distinguish it from {nearest[0].replace('_', ' ')})"
    return said
