"""Each name means one thing: no type, and no function of the core, is defined in two modules."""

from __future__ import annotations

import ast
from collections import defaultdict
from pathlib import Path

PACKAGE = Path(__file__).resolve().parent.parent / "footcal_cli"


def defined_twice(*, functions: bool) -> dict[str, list[str]]:
    """Public names of the top level of more than one module, with these; or only of types."""
    found = defaultdict(list)
    for path in sorted(PACKAGE.rglob("*.py")):
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            names = [node.name] if isinstance(node, ast.ClassDef) else []
            if isinstance(node, ast.FunctionDef):
                names = [node.name] if functions else []
            if isinstance(node, ast.Assign):  # a name for a type is spelt as a class is
                names = [t.id for t in node.targets if isinstance(t, ast.Name)]
                names = [name for name in names if name[0].isupper() and not name.isupper()]
            for name in names:
                found[name].append(str(path.relative_to(PACKAGE)))
    return {
        name: where for name, where in found.items() if len(where) > 1 and not name.startswith("_")
    }


def test_a_type_has_a_name_of_its_own() -> None:
    assert defined_twice(functions=False) == {}


ALSO = {
    "balance": "what each experiment's module calls its own",
    "residual": "the one residual: of a log, and of the rows that count of a case",
}
"""Names that mean the same thing wherever they stand."""
PUBLIC = "core/calibrate.py"
"""The library, whose functions are called as the experiments are."""


def test_a_function_of_the_core_has_a_name_of_its_own() -> None:
    core = {
        name: [place for place in where if place.startswith("core/") and place != PUBLIC]
        for name, where in defined_twice(functions=True).items()
        if name not in ALSO
    }
    assert {name: where for name, where in core.items() if len(where) > 1} == {}
