"""``footcal effects``: the table of effects, or one of its rows in full."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from footcal_cli.core.effects.contract import Effect

_STAGE_NAMES = {
    1: "bench", 2: "body", 3: "foot", 4: "six-axis", 5: "cells", 6: "calibration", 7: "digital",
    8: "transport",
}  # fmt: skip


def effects(
    name: Annotated[
        str | None, typer.Argument(metavar="[NAME]", help="The effect to explain in full.")
    ] = None,
    experiment: Annotated[
        str | None, typer.Option("--experiment", help="Only what this experiment can see.")
    ] = None,
) -> None:
    """Print the table of effects, or the formula, mimics and remedy of one."""
    from footcal_cli.core.effects import TABLE
    from footcal_cli.errors import UsageError, nearest

    if name is not None:
        if name not in TABLE:
            raise UsageError(
                f"no effect named '{name}'{nearest(name, list(TABLE))}",
                remedy="footcal effects lists them",
            )
        typer.echo(explained(TABLE[name]))
        return
    chosen = list(TABLE.values())
    if experiment is not None:
        known = sorted({e for effect in chosen for e in effect.experiments})
        if experiment not in known:
            raise UsageError(
                f"no experiment named '{experiment}'{nearest(experiment, known)}",
                remedy=f"one of {', '.join(known)}",
            )
        chosen = [effect for effect in chosen if experiment in effect.experiments]
    typer.echo(listed(chosen))


def listed(chosen: list[Effect]) -> str:
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
    lines += [
        f"mimics        {', '.join(effect.mimics)}",
        f"separated by  {effect.separates}",
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
