"""docs/recipes.md says what the models of recipes say."""

from __future__ import annotations

import importlib.util
from pathlib import Path


def test_the_page_of_recipes_is_that_of_the_models(repository: Path) -> None:
    path = repository / "docs" / "make_recipes_page.py"
    spec = importlib.util.spec_from_file_location("make_recipes_page", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    assert (repository / "docs" / "recipes.md").read_text(encoding="utf-8") == module.page()
