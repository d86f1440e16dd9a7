"""The reference is made of the source, and names every key of an entry."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from runpy import run_path

from footcal_cli.recipe.filespecs import FileSpec, JoinSpec, PivotSpec, Place

PAGES = run_path(str(Path(__file__).resolve().parents[2] / "docs" / "make_reference.py"))


def test_the_page_of_recipes_has_every_key() -> None:
    page = PAGES["recipe_page"]()
    for model in (Place, FileSpec, PivotSpec):
        for field in fields(model):
            assert f"\n| `{field.name}` | `" in page
    for name in JoinSpec.model_fields:
        assert f"\n| `{name}` | `" in page
