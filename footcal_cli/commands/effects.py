"""``footcal effects``: the table of effects, or one of its rows in full."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from footcal_cli.commands.options import RecipeFile

if TYPE_CHECKING:
    from footcal_cli.records.own_effects import OwnEffect


def effects(
    name: Annotated[
        str | None, typer.Argument(metavar="NAME", help="Effect to describe in full.")
    ] = None,
    experiment: Annotated[
        str | None, typer.Option("--experiment", help="Only effects that this experiment can see.")
    ] = None,
    recipe: RecipeFile = None,
    check: Annotated[
        bool,
        typer.Option(
            "--check",
            help="Check the recipe's own effects and those of installed packages: whether they "
            "keep the contract, and how much they look like effects of the table.",
        ),
    ] = False,
    signals: Annotated[
        bool,
        typer.Option(
            "--signals", help="List the signals that the formula of an own effect may use."
        ),
    ] = False,
) -> None:
    """Print the table of effects, or one effect's formula, look-alikes and remedy."""
    from footcal_cli.core.effects import TABLE
    from footcal_cli.errors import UsageError, nearest
    from footcal_cli.records.effects import known_effect, table_with
    from footcal_cli.sheets.effects import checked, explained, listed, signals_listed

    if signals:
        typer.echo(signals_listed())
        return
    rows = _own_rows(recipe)
    table = table_with(rows, recipe)
    if check:
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
