"""Each name means one thing: no class, and no kind of function, is defined in two modules."""

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
