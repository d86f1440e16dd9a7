"""``footcal effects``: the table of effects, or one of its rows in full."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from footcal_cli.commands.options import RecipeFile

if TYPE_CHECKING:
    from footcal_cli.core.effects.contract import Effect
    from footcal_cli.records.own_effects import OwnEffect

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
    recipe: RecipeFile = None,
    check: Annotated[
        bool,
        typer.Option(
            "--check",
            help="Check the recipe's own effects and those of installed packages: they keep the "
            "contract, and how alike they are to the table's.",
        ),
    ] = False,
    signals: Annotated[
        bool, typer.Option("--signals", help="List what a formula of an own effect may use.")
    ] = False,
) -> None:
    """Print the table of effects, or the formula, mimics and remedy of one."""
    from footcal_cli.core.effects import TABLE
    from footcal_cli.errors import UsageError, nearest
    from footcal_cli.records.effects import known_effect, table_with

    if signals:
        typer.echo(signals_listed())
        return
    rows = _own_rows(recipe)
    table = table_with(rows, recipe)
    if check:
        from footcal_cli.commands.parts.effects_check import checked

        own = [effect for effect in table.values() if effect.name not in TABLE]
        if not own:
            raise UsageError(
                "no effect to check", file=recipe,
                remedy="write [[effect]] into the recipe and give it with --recipe",
            )  # fmt: skip
        text, sound = checked(own, TABLE)
        typer.echo(text)
        raise typer.Exit(0 if sound else 1)
    if name is not None:
        typer.echo(explained(known_effect(name, table)))
        return
    chosen = list(table.values())
    if experiment is not None:
        known = sorted({e for effect in chosen for e in effect.experiments})
        if experiment not in known:
            raise UsageError(
                f"no experiment named '{experiment}'{nearest(experiment, known)}",
                remedy=f"one of {', '.join(known)}",
            )
        chosen = [effect for effect in chosen if experiment in effect.experiments]
    typer.echo(listed(chosen))


def _own_rows(recipe: Path | None) -> tuple[OwnEffect, ...]:
    from footcal_cli.commands import option_tables
    from footcal_cli.recipe import read_recipe

    return () if recipe is None else read_recipe(recipe, option_tables()).effect


def signals_listed() -> str:
    """Signals and functions of formulas as aligned text."""
    from footcal_cli.core.effects.formula import FUNCTIONS
    from footcal_cli.core.effects.own import SIGNALS

    rows = [("signal", "unit", "known in", "what it is")]
    rows += [(n, s.unit, " ".join(s.experiments), s.meaning) for n, s in SIGNALS.items()]
    widths = [max(len(row[i]) for row in rows) for i in range(3)]
    lines = [
        "  ".join([*(cell.ljust(w) for cell, w in zip(row, widths, strict=False)), row[-1]])
        for row in rows
    ]
    return "\n".join([*lines, f"functions: + - * / ** {' '.join(FUNCTIONS)}"])


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
