"""Cells under two feet by a letter for the foot and the cell's own: ``U_LA``, ``Lfi``, ``eA``.

Room: sniff; asked by columns. One name alone may end in a unit (``U_LB``) or in a place (``RF``).
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace

from footcal_cli.sniff.guesses import ColumnGuess
from footcal_cli.sniff.names import NameGuess
from footcal_cli.sniff.vocabulary import PLACES

_ENDS = re.compile(
    r"(?P<stem>.*(?:[\W_]|^))(?P<side>[LRlreigsdEIGSD])_?(?P<cell>[A-Z])(?P<unit>[\W_]*[\w/]*)"
)
_SIDES = {
    "L": "R", "l": "r", **dict.fromkeys("eigs", "d"), **dict.fromkeys("EIGS", "D"),
}  # fmt: skip
"""Letter of a left foot -> that of the right one: English, and esquerdo, izquierdo, gauche,
sinistro beside direito, derecho, droit, destro."""
_WORDS = re.compile(
    r"(?P<stem>.*(?:[\W_]|^))(?P<side>[LR])(?P<cell>(?![fmt]?[xyz])[a-z]{1,3}\d?)(?P<unit>)"
)
"""``mV_Lfi``, ``Rho``: inner and outer cells, if each is there on the other foot too."""
_FEWEST = 2
_NO_PLACE = frozenset("XYZ")


def with_lettered_cells(columns: Sequence[ColumnGuess]) -> list[ColumnGuess]:
    """Columns with foot and cell where their names are all pairs of a side and a letter.

    Next to forces and torques along axes such letters are of legs: ``LV_kracht_vx``, ``LV_heup``.
    """
    if {"fx", "fy", "fz", "tx", "ty", "tz"} <= {c.name.axis for c in columns}:
        return list(columns)
    kinds: dict[tuple[str, str], dict[str, re.Match[str]]] = defaultdict(dict)
    for column in columns:
        found = _ENDS.fullmatch(column.column.strip())
        if found is None and column.quantity in ("reading", "unknown") and not column.name.side:
            found = _WORDS.fullmatch(column.column.strip())
        if found and column.values is not None:
            kinds[found["stem"], found["unit"]][column.column] = found
    cells: dict[str, re.Match[str]] = {}
    for own in kinds.values():
        feet = {m["side"]: {n["cell"] for n in own.values() if n["side"] == m["side"]}
                for m in own.values()}  # fmt: skip
        left = next((side for side in feet if _SIDES.get(side) in feet), None)
        if left is None or len(feet) > 2:
            continue
        places = all((m["side"] + m["cell"]).lower() in PLACES for m in own.values())
        whole = feet[left] == feet[_SIDES[left]] and len(feet[left]) >= _FEWEST
        if whole and not places and not feet[left] <= _NO_PLACE:
            cells |= own
    return [_of_a_foot(c, cells[c.column]) if c.column in cells else c for c in columns]


def _of_a_foot(column: ColumnGuess, found: re.Match[str]) -> ColumnGuess:
    side = "left" if found["side"] in _SIDES else "right"
    unit = column.unit if found["unit"] or found.re is _WORDS else None
    place = f"{side}_{found['cell'].lower()}"
    name = NameGuess(
        "reading", side=side, place=found["cell"].lower(), unit=unit,
        factor=column.name.factor if unit else 1.0,
    )  # fmt: skip
    why = f"{place}, by a letter for its foot and one for itself"
    return replace(column, name=name, unit=unit, sure="likely", why=why)
