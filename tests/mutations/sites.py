"""Where the product can be mutated, and the mutation: operators, comparisons, constants."""

from __future__ import annotations

import ast
import copy
import random
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

PACKAGE = "footcal_cli"
RECORDER = "_mutants"

_COMPARISONS: dict[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Lt: ast.GtE, ast.GtE: ast.Lt, ast.Gt: ast.LtE, ast.LtE: ast.Gt, ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq, ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In,
}  # fmt: skip
_OPERATORS: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.Pow: ast.Mult,
}  # fmt: skip


@dataclass(frozen=True)
class Mutant:
    """One expression of one function, as it is and as it is mutated.

    `nth` counts the equal expressions of the function that stand before it, so that a mutant is
    found again after the lines around it have moved.
    """

    file: str
    function: str
    before: str
    nth: int
    after: str


def mutants_of(root: Path, file: str) -> Iterator[tuple[Mutant, ast.expr, ast.Module]]:
    """All mutants of a file, each with its node in the file's tree."""
    tree = ast.parse((root / file).read_text(encoding="utf-8"))
    seen: dict[tuple[str, str], int] = {}
    for function, node in _expressions(tree, ""):
        mutated = _mutated(node)
        if mutated is None:
            continue
        key = (function, ast.unparse(node))
        nth = seen.get(key, 0)
        seen[key] = nth + 1
        yield Mutant(file, function, key[1], nth, ast.unparse(mutated)), node, tree


def drawn(root: Path, count: int, seed: int) -> list[Mutant]:
    """Draw mutants from the whole package, every site as likely as any other."""
    files = sorted(p.relative_to(root).as_posix() for p in (root / PACKAGE).rglob("*.py"))
    sites = [mutant for file in files for mutant, _, _ in mutants_of(root, file)]
    return random.Random(seed).sample(sites, count)


def apply(root: Path, mutant: Mutant) -> bool:
    """Write the mutated file; False where the product no longer has the expression."""
    if not (root / mutant.file).is_file():
        return False
    for found, node, tree in mutants_of(root, mutant.file):
        if found == mutant:
            mutated = ast.parse(mutant.after, mode="eval").body
            _write(root / mutant.file, _Swap(node, mutated).visit(tree))
            return True
    return False


def instrument(root: Path, mutants: list[Mutant]) -> set[int]:
    """Let the sites of all mutants note which tests reach them; the indices that were found."""
    (root / PACKAGE / f"{RECORDER}.py").write_text(_RECORDER, encoding="utf-8")
    found = set()
    for index, mutant in enumerate(mutants):
        if not (root / mutant.file).is_file():
            continue
        for other, node, tree in mutants_of(root, mutant.file):
            if other == mutant:
                call = (
                    f"(__import__('{PACKAGE}.{RECORDER}', fromlist=['hit']).hit({index}), None)[1]"
                )
                wrapped = ast.parse(call, mode="eval").body
                assert isinstance(wrapped, ast.Subscript)
                assert isinstance(wrapped.value, ast.Tuple)
                wrapped.value.elts[1] = copy.deepcopy(node)
                _write(root / mutant.file, _Swap(node, wrapped).visit(tree))
                found.add(index)
                break
    return found


_RECORDER = '''"""Notes which test reached which mutant."""
import os

_seen = set()


def hit(index):
    test = os.environ.get("PYTEST_CURRENT_TEST", "")
    if (index, test) not in _seen:
        _seen.add((index, test))
        with open(os.environ["MUTATION_HITS"], "a", encoding="utf-8") as file:
            file.write(f"{index}\\t{test}\\n")
'''


class _Swap(ast.NodeTransformer):
    """Put one node in the place of another."""

    def __init__(self, old: ast.expr, new: ast.expr) -> None:
        self.old, self.new = old, new

    def visit(self, node: ast.AST) -> ast.AST:
        return self.new if node is self.old else super().generic_visit(node)


def _write(path: Path, tree: ast.AST) -> None:
    path.write_text(ast.unparse(ast.fix_missing_locations(tree)), encoding="utf-8")


def _expressions(node: ast.AST, function: str) -> Iterator[tuple[str, ast.expr]]:
    """Expressions that run when a function is called: no messages, defaults or annotations."""
    if isinstance(node, ast.Raise | ast.JoinedStr | ast.match_case):
        return
    if isinstance(node, ast.FunctionDef):
        if any("jit" in ast.unparse(decorator) for decorator in node.decorator_list):
            return
        name = f"{function}.{node.name}".lstrip(".")
        for statement in node.body:
            yield from _expressions(statement, name)
        return
    if isinstance(node, ast.AnnAssign):
        if node.value is not None:
            yield from _expressions(node.value, function)
        return
    if isinstance(node, ast.expr) and function:
        yield function, node
    for child in ast.iter_child_nodes(node):
        yield from _expressions(child, function)


def _mutated(node: ast.expr) -> ast.expr | None:
    """The mutation of an expression, None where it has none."""
    new = copy.deepcopy(node)
    if isinstance(new, ast.Compare) and len(new.ops) == 1 and type(new.ops[0]) in _COMPARISONS:
        new.ops = [_COMPARISONS[type(new.ops[0])]()]
        return new
    if isinstance(new, ast.BinOp) and type(new.op) in _OPERATORS:
        new.op = _OPERATORS[type(new.op)]()
        return new
    if isinstance(new, ast.BoolOp):
        new.op = ast.Or() if isinstance(new.op, ast.And) else ast.And()
        return new
    if isinstance(new, ast.UnaryOp) and isinstance(new.op, ast.Not | ast.USub):
        return new.operand
    if isinstance(new, ast.Constant):
        if isinstance(new.value, bool):
            return ast.Constant(not new.value)
        if isinstance(new.value, int):
            return ast.Constant(new.value + 1)
        if isinstance(new.value, float):
            return ast.Constant(new.value * 1.5 or 1.0)
    return None
