"""Generate docs/reference from the models: `make docs`."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterable, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import typer
from pydantic import BaseModel

from footcal_cli.app import COMMANDS, function_of
from footcal_cli.recipe import CommandOptions, Recipe
from footcal_cli.recipe.filespecs import FileSpec, JoinSpec, PivotSpec, Place
from footcal_cli.records.models import fields_of
from footcal_cli.records.schemas import SCHEMAS
from footcal_cli.tables import columns

HERE = Path(__file__).resolve().parent / "reference"


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A Markdown table."""
    lines = [f"| {' | '.join(head)} |", f"|{'---|' * len(head)}"]
    lines += [f"| {' | '.join(cell.replace('|', '∣') for cell in row)} |" for row in rows]
    return "\n".join(lines) + "\n"


def commands_page() -> str:
    """Every command with its options."""
    parts = ["# Commands\n"]
    for name, sentence in COMMANDS.items():
        one = typer.Typer(add_completion=False)
        one.command(name)(function_of(name))
        command: Any = typer.main.get_command(one)
        rows = []
        for p in command.params:
            if p.name in ("install_completion", "show_completion"):
                continue
            names = (
                ", ".join(f"`{o}`" for o in p.opts)
                if p.param_type_name == "option"
                else f"`{p.metavar or p.name}`"
            )
            default = "" if p.default in (None, False) else f" (default `{p.default}`)"
            rows.append((names, f"{getattr(p, 'help', '') or ''}{default}".replace("\\[", "[")))
        parts.append(f"## {name}\n{sentence}\n\n{table(('option', 'meaning'), rows)}")
    return "\n".join(parts)


def keys(model: type, prefix: str = "") -> list[tuple[str, str, str]]:
    """Key, type and default of a model of settings, nested ones as tables."""
    rows = []
    for name, field in fields_of(model).items():
        kind = field.annotation
        if inspect.isclass(kind) and issubclass(kind, BaseModel):
            rows += keys(kind, f"{prefix}{name}.")
            continue
        default = (
            "–" if field.is_required() else f"`{field.get_default(call_default_factory=True)!r}`"
        )
        shown = kind.__name__ if inspect.isclass(kind) and "[" not in str(kind) else str(kind)
        shown = re.sub(r"typing\.|collections\.abc\.|footcal_cli\.\w+\.|pathlib\.", "", shown)
        shown = re.sub(r"Annotated\[(\w+), .*\)\]", r"\1", shown)
        rows.append((f"`{prefix}{name}`", f"`{shown}`", default))
    return rows


def options_of(name: str) -> type[CommandOptions] | None:
    """The option table of a command, None where it has none."""
    module = import_module(f"footcal_cli.commands.{name.replace('-', '_')}")
    wanted = "".join(word.capitalize() for word in name.split("-")) + "Options"
    return getattr(module, wanted, None)


def recipe_page() -> str:
    """Every key of a recipe."""
    head = ("key", "type", "default")
    own = [row for row in keys(Recipe) if not row[0].startswith(("`options", "`path"))]
    parts = ["# Recipe keys\n", inspect.cleandoc(Recipe.__doc__ or ""), "\n", table(head, own)]
    for title, model in (
        ("[columns]: an entry", Place), ("[[files]]", FileSpec), ("[[files]] join", JoinSpec),
        ("[[files]] pivot", PivotSpec),
    ):  # fmt: skip
        said = inspect.cleandoc(model.__doc__ or "")
        parts.append(f"## {title}\n{said}\n\n{table(head, keys(model))}")
    parts.append(f"## Every command\n{table(head, keys(CommandOptions))}")
    shared = {row[0] for row in keys(CommandOptions)}
    for name in COMMANDS:
        model = options_of(name)
        mine = [row for row in keys(model) if row[0] not in shared] if model is not None else []
        if mine:
            parts.append(f"## [{name.replace('-', '_')}]\n{table(head, mine)}")
    return "\n".join(parts)


def columns_page() -> str:
    """The columns of every kind of log, for an example robot."""
    cells = ("left_fl", "left_fr")
    kinds = {
        "weights": columns.weights_table(),
        "weights_stream": columns.weights_stream_table(cells),
        "placements": columns.placements_table(("fl", "fr", "rl", "rr")),
        "cop_points": columns.cop_points_table(),
        "cells": columns.cells_table(cells),
        "zeros": columns.zeros_table(cells),
        "six_axis_feet": columns.six_axis_feet_table(("left",)),
        "body": columns.body_table(("left",)),
        "hang": columns.hang_table(),
        "legs": columns.legs_table(),
        "poses": columns.poses_table(),
    }
    parts = [
        "# Columns of logs\nA canonical column carries its unit as suffix; another name or unit is "
        "mapped in `[columns]` of a recipe. Names of cells and feet are those of the recipe; shown "
        "are examples. Optional columns may be missing.\n"
    ]
    for name, kind in kinds.items():
        rows = [
            (
                f"`{c.name}`",
                c.unit or ("text" if c.kind == "text" else "–"),
                "optional" if c.optional else "",
                c.meaning,
            )
            for c in kind.columns
        ]
        parts.append(f"## {name}\n{table(('column', 'unit', '', 'meaning'), rows)}")
    return "\n".join(parts)


def files_page() -> str:
    """The records that commands write."""
    parts = ["# Files\nJSON Schemas: `footcal schema NAME`.\n"]
    for name, model in SCHEMAS.items():
        rows = [
            (
                f"`{field.alias or key}`",
                f"`{getattr(field.annotation, '__name__', field.annotation)}`".replace(
                    "footcal_cli.records.", ""
                ),
            )
            for key, field in model.model_fields.items()
        ]
        text = inspect.cleandoc(model.__doc__ or "").replace("``", "`")
        parts.append(f"## {name}\n{text}\n\n{table(('key', 'type'), rows)}")
    return "\n".join(parts)


PAGES = {
    "commands.md": commands_page,
    "recipe.md": recipe_page,
    "columns.md": columns_page,
    "files.md": files_page,
}


def main() -> None:
    """Write all pages."""
    HERE.mkdir(exist_ok=True)
    for name, page in PAGES.items():
        (HERE / name).write_text(page().rstrip() + "\n", encoding="utf-8")


def on_pre_build(config: object) -> None:
    """Hook of mkdocs: the reference is always that of this version."""
    main()


if __name__ == "__main__":
    main()
