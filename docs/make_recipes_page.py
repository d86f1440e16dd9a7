"""docs/recipes.md from the models that read a recipe: every key, its type, its default."""

from __future__ import annotations

import inspect
import re
from importlib import import_module
from pathlib import Path
from typing import Any

from pydantic import BaseModel
from pydantic_core import PydanticUndefined

from footcal_cli.commands import option_tables
from footcal_cli.filespecs import FileSpec, JoinSpec, Place
from footcal_cli.recipe import Adc, Cell, Foot, Gates, Leg, Nameplate, Robot

HEAD = """# Recipes
Every key that a recipe may have, made from the models that read it (`make recipes-page`). A key
that is not here is an error that names the nearest one. `footcal init LOG…` writes a first recipe.

```toml
[[files]]                        # how the files of one kind are written
match = "press_*.csv"
separator = ";"
decimal = ","
encoding = "latin-1"
skip_rows = 4
skip_below = 1                   # a row of units
rate_hz = 100                    # where no stamps are
join = [{ file = "reference.csv", by = "time", offset_s = 0.02 }]

[columns]                        # footcal's name = yours
time_s = { column = "Zeit", unit = "ms" }
load_n = { column = "reference.Kraft", unit = "kN" }
channel = { value = "plate" }    # the same for every row
session = { file_name = "day(\\\\d+)" }
counts = { column = "Sensor", unit = "mV" }
```
"""
_SECTIONS: tuple[tuple[str, type[BaseModel]], ...] = (
    ("`[columns]`: an entry", Place), ("`[[files]]`", FileSpec), ("`[[files]] join`", JoinSpec),
    ("`[robot]`", Robot), ("`[robot.feet.<name>]`", Foot),
    ("`[robot.feet.<name>.cells]`: an entry", Cell), ("`[robot.legs.<name>]`", Leg),
    ("`[robot.adc]`", Adc), ("`[robot.nameplate]`", Nameplate), ("`[gates]`", Gates),
)  # fmt: skip


def page() -> str:
    """The whole page."""
    parts = [HEAD.replace("\\\\", "\\")]
    parts += [_section(title, model) for title, model in _SECTIONS]
    for table in sorted(option_tables()):
        module = import_module(f"footcal_cli.commands.{table}")
        name = "".join(word.capitalize() for word in table.split("_")) + "Options"
        model = getattr(module, name, None)
        if model is not None:
            parts.append(_section(f"`[{table}]`", model))
            parts += [
                _section(f"`[{table}.{key}]`", field.annotation)
                for key, field in model.model_fields.items()
                if inspect.isclass(field.annotation) and issubclass(field.annotation, BaseModel)
                and field.annotation is not Gates
            ]  # fmt: skip
    return "\n".join(parts)


def _section(title: str, model: Any) -> str:
    said = inspect.cleandoc(model.__doc__ or "")
    lines = [f"## {title}", said, "", "| key | type | default |", "|---|---|---|"]
    for name, field in model.model_fields.items():
        default = "required" if field.default is PydanticUndefined else _shown(field.default)
        if field.default_factory is not None:
            default = ""
        lines.append(f"| `{name}` | {_kind(field.annotation)} | {default} |")
    return "\n".join(lines) + "\n"


def _kind(annotation: Any) -> str:
    text = annotation.__name__ if inspect.isclass(annotation) else str(annotation)
    if "[" in str(annotation):
        text = str(annotation)
    text = re.sub(r"\b(?:typing|pathlib|footcal_cli(?:\.\w+)*)\.", "", text)
    text = re.sub(r"Annotated\[([^,\]]+),.*?\]\)?\]", r"\1", text)
    return text.replace("|", "or")


def _shown(value: object) -> str:
    if isinstance(value, BaseModel):
        return "its own table"
    return "" if value is None or value == () else f"`{value!r}`"


if __name__ == "__main__":
    Path(__file__).with_name("recipes.md").write_text(page(), encoding="utf-8")
