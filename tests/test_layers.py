"""The arrows of the house: who may import whom, read from the source."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parent.parent / "footcal_cli"

# room -> what it may import of footcal; listed from the ground up
ALLOWED: dict[str, set[str]] = {
    "errors": set(),
    "core": {"core", "errors"},
    "columns": set(),
    "textfiles": {"errors"},
    "units": {"core", "errors"},
    "reading": set(),
    "delimited": {"reading", "textfiles", "core", "errors"},
    "logfiles": {"delimited", "reading", "textfiles", "core", "errors"},
    "values": {"columns", "logfiles", "textfiles", "core", "errors"},
    "canonical": {"columns", "reading", "logfiles", "values", "units", "core", "errors"},
    "sources": {"canonical", "columns", "logfiles", "reading", "errors"},
    "tables": {
        "canonical", "columns", "logfiles", "reading", "sources", "units", "core", "errors",
    },
    "models": {"errors"},
    "filespecs": {"models", "reading"},
    "recipe": {"columns", "filespecs", "models", "reading", "errors"},
    "records": {"records", "textfiles", "core", "errors"},
    "plots": {"plots", "core", "records"},
    "report": {"records", "core"},
    "sheets": {
        "sheets", "plots", "report", "intake", "cell_effects", "recipe", "core", "records",
    },
    "run_folder": {"errors"},
    "interruption": set(),
    "rigid_body": {"core", "errors"},
    "session": {
        "columns", "tables", "recipe", "records", "report", "run_folder", "core", "errors",
    },
    "cell_effects": {"recipe", "records", "core", "errors"},
    "intake": {
        "intake", "cell_effects", "columns", "tables", "recipe", "records", "session", "core",
        "errors",
    },
    "sniff": {
        "sniff", "columns", "delimited", "logfiles", "reading", "textfiles", "units", "core",
        "errors",
    },
    "formats": {"formats", "logfiles", "errors"},
    "exporters": {"exporters", "records", "core", "errors"},
    "commands": {
        "commands", "formats", "exporters", "logfiles", "cell_effects", "columns", "tables",
        "reading", "sources", "sniff",
        "recipe", "records", "report", "session", "intake", "plots", "sheets", "rigid_body",
        "core", "errors",
    },
    "app": {"commands", "errors", "interruption", "run_folder"},
    "__main__": {"app", "interruption"},
    "__init__": set(),
}  # fmt: skip
# heavy libraries and the rooms that may know them
LIBRARIES: dict[str, set[str]] = {
    "pandas": {"tables", "logfiles", "delimited", "values", "session", "commands"},
    "pinocchio": {"rigid_body"},
    "pyarrow": {"logfiles"},
    "pint": {"units"},
    "matplotlib": {"plots", "report"},
    "pydantic": {"models", "filespecs", "recipe", "records", "commands"},
    "typer": {"app", "commands"},
    "rich": {"report", "session"},
    "jinja2": {"report"},
    "scipy": {"core", "formats", "exporters"},
    "rosbags": {"formats"},
    "mcap": {"formats"},
    "ezc3d": {"formats"},
    "h5py": {"formats"},
}


def sources() -> list[Path]:
    return sorted(PACKAGE.rglob("*.py"))


def room_of(path: Path) -> str:
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


def imports_of(path: Path) -> list[str]:
    found = []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            module = node.module or ""
            found += (
                [f"{module}.{alias.name}" for alias in node.names]
                if module == "footcal_cli"
                else [module]
            )
    return found


@pytest.mark.parametrize("path", sources(), ids=lambda p: p.relative_to(PACKAGE).as_posix())
def test_imports_point_downward(path: Path) -> None:
    room = room_of(path)
    assert room in ALLOWED, f"{room} is no room of the house"
    for name in imports_of(path):
        parts = name.split(".")
        if parts[0] == "footcal_cli" and len(parts) > 1 and parts[1] != "__version__":
            assert parts[1] in ALLOWED[room], f"{room} must not import {name}"
        if parts[0] in LIBRARIES:
            assert room in LIBRARIES[parts[0]], f"{room} must not import {name}"


@pytest.mark.parametrize("path", sources(), ids=lambda p: p.relative_to(PACKAGE).as_posix())
def test_the_core_neither_prints_nor_opens_files(path: Path) -> None:
    if room_of(path) != "core":
        return
    calls = {
        node.func.id
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
    }
    assert not calls & {"print", "open", "input"}


def test_every_room_of_the_table_is_looked_at() -> None:
    """The rule must not go blind: it has to see a nested import."""
    tree = PACKAGE / "commands" / "offline_fit.py"
    assert any(name.startswith("footcal_cli.core") for name in imports_of(tree))
