"""The mutants themselves: found again, applied, and each another program."""

from __future__ import annotations

import ast
import json
from pathlib import Path

from tests.mutations.sites import Mutant, apply, instrument, mutants_of

SOURCE = '''"""A module."""

LIMIT = 3


def clipped(x: float, most: float = 2.0) -> float:
    """Between zero and most."""
    if x > most and not x < 0:
        raise ValueError(f"{x + 1}")
    return x * 0.5 - 1
'''
FILE = "footcal_cli/module.py"


def tree(folder: Path) -> Path:
    (folder / "footcal_cli").mkdir()
    (folder / FILE).write_text(SOURCE, encoding="utf-8")
    return folder


def test_operators_comparisons_and_constants_of_function_bodies_are_mutated(tmp_path: Path) -> None:
    found = {(m.before, m.after) for m, _, _ in mutants_of(tree(tmp_path), FILE)}
    assert found == {
        ("x > most and (not x < 0)", "x > most or not x < 0"), ("x > most", "x <= most"),
        ("not x < 0", "x < 0"), ("x < 0", "x >= 0"), ("0", "1"),
        ("x * 0.5 - 1", "x * 0.5 + 1"), ("x * 0.5", "x / 0.5"), ("0.5", "0.75"), ("1", "2"),
    }  # fmt: skip


def test_a_mutant_is_applied_where_it_stands_and_gone_where_it_does_not(tmp_path: Path) -> None:
    root = tree(tmp_path)
    mutant = Mutant(FILE, "clipped", "x > most", 0, "x <= most")
    assert apply(root, mutant)
    assert "x <= most and (not x < 0)" in (root / FILE).read_text(encoding="utf-8")
    assert not apply(root, mutant)


def test_recording_changes_no_result(tmp_path: Path) -> None:
    root = tree(tmp_path)
    mutants = [mutant for mutant, _, _ in mutants_of(root, FILE)]
    assert instrument(root, mutants[:4]) == {0, 1, 2, 3}
    text = (root / FILE).read_text(encoding="utf-8")
    assert text.count(".hit(") == 4
    ast.parse(text)


def test_the_drawn_mutants_stand_in_the_product(repository: Path) -> None:
    """A file that was moved takes its mutants along; some lines may be written anew."""
    rows = json.loads((Path(__file__).parent / "mutants.json").read_text(encoding="utf-8"))
    asked = [Mutant(**{k: v for k, v in row.items() if k != "verdict"}) for row in rows]
    known = {
        mutant
        for file in {m.file for m in asked if (repository / m.file).is_file()}
        for mutant, _, _ in mutants_of(repository, file)
    }
    assert len([m for m in asked if m not in known]) <= 3
