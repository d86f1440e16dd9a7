"""Formulas of recorded signals, read by a small parser: arithmetic and a few functions, no code.

``k * shear * load`` becomes a function of named arrays. Only numbers, names, ``+ - * / **`` and the
calls of `FUNCTIONS` are read; anything else is refused before it is computed.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches

import numpy as np

from footcal_cli.core.parameters import FloatArray

FUNCTIONS: Mapping[str, tuple[int, Callable[..., FloatArray]]] = {
    "abs": (1, np.abs),
    "sqrt": (1, np.sqrt),
    "exp": (1, np.exp),
    "log": (1, np.log),
    "sin": (1, np.sin),
    "cos": (1, np.cos),
    "tanh": (1, np.tanh),
    "sign": (1, np.sign),
    "min": (2, np.minimum),
    "max": (2, np.maximum),
}
"""Name -> number of arguments and what it computes."""
_OPERATORS: Mapping[type[ast.operator], Callable[..., FloatArray]] = {
    ast.Add: np.add,
    ast.Sub: np.subtract,
    ast.Mult: np.multiply,
    ast.Div: np.divide,
    ast.Pow: np.power,
}
_LONGEST, _MOST_PARTS = 300, 120


class FormulaError(ValueError):
    """A formula that the parser does not read, with the reason."""


@dataclass(frozen=True)
class Formula:
    """A parsed formula.

    Parameters
    ----------
    names
        Signals and parameters that it uses.
    """

    text: str
    names: frozenset[str]
    tree: ast.expr

    def __call__(self, values: Mapping[str, FloatArray]) -> FloatArray:
        """Its value where every name has one; what is undefined (0/0) counts as nothing."""
        with np.errstate(all="ignore"):
            found = np.asarray(_value(self.tree, values), dtype=float)
        return np.where(np.isfinite(found), found, 0.0)


def formula_of(text: str, known: frozenset[str]) -> Formula:
    """Parse a formula of known names.

    Raises
    ------
    FormulaError
        What in it is not arithmetic of known names; names the nearest known one.
    """
    if len(text) > _LONGEST:
        raise FormulaError(f"longer than {_LONGEST} characters")
    try:
        tree = ast.parse(text, mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise FormulaError(f"'{text}' is no formula") from None
    parts = list(ast.walk(tree))
    if len(parts) > _MOST_PARTS:
        raise FormulaError("too many terms")
    names = frozenset(_names(tree))
    for name in sorted(names - known):
        near = get_close_matches(name, known, n=1, cutoff=0.4)
        hint = f"; did you mean '{near[0]}'?" if near else ""
        raise FormulaError(f"unknown signal '{name}'{hint}")
    return Formula(text, names, tree)


def _names(node: ast.expr) -> list[str]:
    """Names in a tree that holds nothing but arithmetic."""
    if isinstance(node, ast.Constant) and type(node.value) in (int, float):
        return []
    if isinstance(node, ast.Name):
        return [node.id]
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.UAdd)):
        return _names(node.operand)
    if isinstance(node, ast.BinOp) and type(node.op) in _OPERATORS:
        return [*_names(node.left), *_names(node.right)]
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and not node.keywords:
        if node.func.id not in FUNCTIONS:
            raise FormulaError(f"no function '{node.func.id}'; known are {', '.join(FUNCTIONS)}")
        count = FUNCTIONS[node.func.id][0]
        if len(node.args) != count:
            raise FormulaError(f"{node.func.id} takes {count} argument{'s' * (count > 1)}")
        return [name for argument in node.args for name in _names(argument)]
    raise FormulaError(f"'{ast.unparse(node)}' is neither number, signal nor arithmetic")


def _value(node: ast.expr, values: Mapping[str, FloatArray]) -> FloatArray:
    if isinstance(node, ast.Constant):
        return np.asarray(float(node.value))  # type: ignore[arg-type]
    if isinstance(node, ast.Name):
        return values[node.id]
    if isinstance(node, ast.UnaryOp):
        inner = _value(node.operand, values)
        return -inner if isinstance(node.op, ast.USub) else inner
    if isinstance(node, ast.BinOp):
        return _OPERATORS[type(node.op)](_value(node.left, values), _value(node.right, values))
    assert isinstance(node, ast.Call)
    assert isinstance(node.func, ast.Name)
    return FUNCTIONS[node.func.id][1](*(_value(argument, values) for argument in node.args))
