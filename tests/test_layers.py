"""The arrows of the house: who may import whom, read from the source."""

from __future__ import annotations

import ast
import gc
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from runpy import run_path

import pytest

from footcal_cli.core.effects import TABLE

PACKAGE = Path(__file__).resolve().parent.parent / "footcal_cli"
PAGE = run_path(str(PACKAGE.parent / "docs" / "make_architecture_page.py"))

# room -> what it may import of footcal; listed from the ground up
ALLOWED: dict[str, set[str]] = {
    "errors": set(),
    "core": {"core", "errors"},
    "tables": {"tables", "core", "errors"},
    "records": {"records", "tables", "core", "errors"},
    "recipe": {"recipe", "records", "tables", "errors"},
    "plots": {"plots", "core", "records"},
    "report": {"report", "records", "core"},
    "session": {"session", "tables", "recipe", "records", "report", "core", "errors"},
    "intake": {"intake", "session", "tables", "recipe", "records", "core", "errors"},
    "sheets": {"sheets", "plots", "report", "intake", "recipe", "records", "tables", "core"},
    "batch": {"batch", "tables", "records", "errors"},
    "sniff": {"sniff", "tables", "core", "errors"},
    "formats": {"formats", "tables", "errors"},
    "exporters": {"exporters", "records", "core", "errors"},
    "commands": {
        "commands", "formats", "exporters", "tables", "sniff", "recipe", "records", "report",
        "session", "intake", "plots", "sheets", "batch", "core", "errors",
    },
    "app": {"commands", "session", "errors"},
    "__main__": {"app", "session"},
    "__init__": set(),
}  # fmt: skip
OF_THE_PACKAGE = {"__version__", "NEW_OBJECTS"}
# heavy libraries and the rooms that may know them
LIBRARIES: dict[str, set[str]] = {
    "pandas": {"tables"},
    "pinocchio": {"intake"},
    "pyarrow": {"tables"},
    "pint": {"tables"},
    "matplotlib": {"plots", "report"},
    "pydantic": {"recipe", "records", "commands"},
    "typer": {"app", "commands"},
    "rich": {"report", "session"},
    "jinja2": {"report"},
    "scipy": {"core", "formats", "exporters"},
    "distributed": {"batch"},
    "numba": {"core"},
    "rosbags": {"formats"},
    "mcap": {"formats"},
    "ezc3d": {"formats"},
    "h5py": {"formats"},
}

# the ground of the core, which the inference stands on
BELOW_INFERENCE = {
    "contact",
    "inference",
    "experiments",
    "effects",
    "chain",
    "parameters",
    "chances",
    "log",
    "signals",
    "centroidal",
    "spatial",
}

# words of foreign formats and tables that happen to be spelt as an effect is. A rule that treats
# effects alike asks for a trait; who models one effect imports its row.
EFFECT_NAMES_OUTSIDE: dict[str, set[str]] = {
    "exporters/matlab.py": {"offset"},
    "exporters/ros2_control.py": {"offset"},
    "intake/rigid_body.py": {"offset"},
    "sniff/names.py": {"mass"},
}


@pytest.fixture(scope="module", autouse=True)
def _no_collection() -> Iterator[None]:
    """Trees of a thousand files are kept: to look for garbage in them takes most of the time."""
    gc.disable()
    yield
    gc.enable()


@cache
def sources() -> list[Path]:
    return sorted(PACKAGE.rglob("*.py"))


@cache
def nodes_of(path: Path) -> tuple[ast.AST, ...]:
    """What the rules look at of a file, which is parsed once for them and for the page."""
    kinds = (ast.Import, ast.ImportFrom, ast.Call, ast.Constant)
    return tuple(node for node in PAGE["nodes_of"](path) if isinstance(node, kinds))


def room_of(path: Path) -> str:
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


@cache
def imports_of(path: Path) -> list[str]:
    found = []
    for node in nodes_of(path):
        if isinstance(node, ast.Import):
            found += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            module = node.module or ""
            found += (
                [f"{module}.{alias.name}" for alias in node.names]
                if module in ("footcal_cli", "footcal_cli.core")
                else [module]
            )
    return found


def test_imports_point_downward() -> None:
    broken, seen = [], 0
    for path in sources():
        room, place = room_of(path), path.relative_to(PACKAGE).as_posix()
        if room not in ALLOWED:
            broken.append(f"{place}: {room} is no room of the house")
            continue
        for name in imports_of(path):
            parts = name.split(".")
            seen += 1
            if parts[0] == "footcal_cli" and len(parts) > 1:
                if parts[1] not in ALLOWED[room] | OF_THE_PACKAGE:
                    broken.append(f"{place} must not import {name}")
            elif room not in LIBRARIES.get(parts[0], {room}):
                broken.append(f"{place} must not import {name}")
    assert not broken, "\n".join(broken)
    assert seen > len(sources()), "the rule has gone blind"


def test_no_subsystems_import_each_other_in_a_circle() -> None:
    assert PAGE["circles"](PAGE["arrows"]()) == []


def test_the_core_neither_prints_nor_opens_files() -> None:
    broken = [
        f"{path.relative_to(PACKAGE).as_posix()}:{node.lineno} calls {node.func.id}"
        for path in sources()
        if room_of(path) == "core"
        for node in nodes_of(path)
        if isinstance(node, ast.Call)
        and isinstance(node.func, ast.Name)
        and node.func.id in {"print", "open", "input"}
    ]
    assert not broken, "\n".join(broken)


def test_every_room_of_the_table_is_looked_at() -> None:
    """The rule must not go blind: it has to see a nested import."""
    tree = PACKAGE / "commands" / "offline_fit.py"
    assert any(name.startswith("footcal_cli.core") for name in imports_of(tree))


def test_the_inference_stands_on_experiments_and_effects_alone() -> None:
    """So that no circle goes through it: neither of the two may know it."""
    broken = []
    for room, may in (
        ("inference", BELOW_INFERENCE),
        ("experiments", BELOW_INFERENCE - {"inference"}),
        ("effects", {"effects", "parameters", "log", "spatial"}),
    ):
        for path in sorted((PACKAGE / "core" / room).rglob("*.py")):
            broken += [
                f"{path.relative_to(PACKAGE).as_posix()} must not import {name}"
                for name in imports_of(path)
                if name.startswith("footcal_cli.") and name.split(".")[2] not in may
            ]
    assert not broken, "\n".join(broken)


def test_no_fit_of_the_product_knows_the_papers_methods() -> None:
    """They are compared with from outside: commands ask for them, sheets show them."""
    study = PACKAGE / "core" / "study"
    broken = [
        path.relative_to(PACKAGE).as_posix()
        for path in (PACKAGE / "core").rglob("*.py")
        if study not in path.parents
        and any(name.startswith("footcal_cli.core.study") for name in imports_of(path))
    ]
    assert not broken


def solvers_in(path: Path) -> int:
    """How often a file calls SciPy's optimisers or inverts a matrix."""
    imported = {
        alias.asname or alias.name
        for node in nodes_of(path)
        if isinstance(node, ast.ImportFrom) and node.module in ("scipy.optimize", "scipy.linalg")
        for alias in node.names
        if node.module == "scipy.optimize" or "inv" in alias.name
    }
    called = [node.func for node in nodes_of(path) if isinstance(node, ast.Call)]
    return sum(
        func.id in imported
        if isinstance(func, ast.Name)
        else isinstance(func, ast.Attribute)
        and (func.attr in ("inv", "pinv") or ast.unparse(func.value).endswith("optimize"))
        for func in called
    )


def test_solvers_and_inverses_stand_in_the_inference() -> None:
    outside = {
        path.relative_to(PACKAGE).as_posix(): found
        for path in sources()
        if (found := solvers_in(path)) and PACKAGE / "core" / "inference" not in path.parents
    }
    assert not outside


def test_frozen_objects_keep_no_memory() -> None:
    """Who remembers from call to call says so, and is not frozen; a log keeps what follows from it.

    A value that follows from fields alone (`cached_property`) is none.
    """
    remembering = {
        f"{path.relative_to(PACKAGE).as_posix()}: {kind.name}"
        for path in sources()
        for kind in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(kind, ast.ClassDef)
        and any("frozen=True" in ast.unparse(d) for d in kind.decorator_list)
        for line in kind.body
        if isinstance(line, ast.AnnAssign) and line.value is not None
        and {"default_factory", "init"} <= {k.arg for k in getattr(line.value, "keywords", ())}
    }  # fmt: skip
    assert remembering == {"core/log.py: Log"}


def effect_names_in(path: Path) -> set[str]:
    """Strings of a file that are an effect's name."""
    return {
        node.value
        for node in nodes_of(path)
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value in TABLE
    }


def test_no_file_outside_the_table_knows_an_effect_by_name() -> None:
    outside = {
        path.relative_to(PACKAGE).as_posix(): found
        for path in sources()
        if PACKAGE / "core" / "effects" not in path.parents and (found := effect_names_in(path))
    }
    assert outside == EFFECT_NAMES_OUTSIDE


def test_every_file_is_short_enough_to_read() -> None:
    long = {
        path.relative_to(PACKAGE).as_posix(): count
        for path in sources()
        if (count := len(path.read_text(encoding="utf-8").splitlines())) > 400
    }
    assert not long


def test_no_module_brings_scipy_stats_before_it_is_needed() -> None:
    """It takes a fifth of a second (`scipy.signal` loads it too): imported where it is called."""
    code = (
        "import pkgutil, sys, footcal_cli\n"
        "for m in pkgutil.walk_packages(footcal_cli.__path__, 'footcal_cli.'):\n"
        "    if not m.name.endswith('__main__'): __import__(m.name)\n"
        "assert 'scipy.stats' not in sys.modules and 'scipy.signal' not in sys.modules\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
