"""The six axes of a transducer as entries of a recipe, with what lines above the table say of them.

Room: sniff; asked by six_axis and six_axis_feet.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, numbers_of
from footcal_cli.sniff.plan import Entry, of
from footcal_cli.sniff.units import GRAVITY_MPS2, known_unit

_AXIS_COLUMNS = {"fx": "fx_n", "fy": "fy_n", "fz": "fz_n", "tx": "tx_nm", "ty": "ty_nm",
                 "tz": "tz_nm"}  # fmt: skip
_LONGEST_M, _LONGEST_CM = 2.0, 20.0
"""Torques that change so much beside forces of unknown unit are not in Nm, and not in Ncm."""


@dataclass(frozen=True)
class Said:
    """What lines above the table say of forces (``f``) and torques (``t``).

    Parameters
    ----------
    per_count
        Newtons or newton metres, or what `unit` says, in one count.
    unit
        Of the values.
    """

    per_count: Mapping[str, float]
    unit: Mapping[str, str]


def said_above(file: FileGuess) -> Said:
    """Counts per newton and units in the lines above a table, as Net F/T writes them."""
    per_count, unit = {}, {}
    for line in file.text.above:
        plain = line.replace('"', "")
        counts = re.search(r"counts per (?:unit )?(force|torque)\W+([\d.]+(?:e\d+)?)", plain, re.I)
        if counts and float(counts[2]) > 0:
            per_count[counts[1][0].lower()] = 1.0 / float(counts[2])
        named = re.search(r"(force|torque) units?\W+([A-Za-z.*-]+)", plain, re.I)
        if named and (known := known_unit(named[2])) is not None:
            unit[named[1][0].lower()] = known
    return Said(per_count, unit)


def _lever(group: dict[str, ColumnGuess]) -> float:
    """How much the torques change beside the forces: metres, if they are in N and Nm."""
    values = np.column_stack([numbers_of(group[axis]) for axis in _AXIS_COLUMNS])
    spread = np.nanstd(values, axis=0)
    force, torque = float(np.linalg.norm(spread[:3])), float(np.linalg.norm(spread[3:]))
    return torque / force if force > 0 else 0.0


def unit_asked(groups: Iterable[dict[str, ColumnGuess]], said: Said) -> tuple[str, ...]:
    """What to check where nothing states a unit, and torques by a lever are in no Nm.

    The same numbers are a weight in N with torques in N cm, and one in kgf with torques in kgf cm.
    """
    for group in groups:
        lever = _lever(group)
        named = said.unit or said.per_count or any(c.unit for c in group.values())
        if named or lever <= _LONGEST_M:
            continue
        most = max(float(np.nanmax(np.abs(numbers_of(group[a])))) for a in ("fx", "fy", "fz"))
        by = "cm" if lever <= _LONGEST_CM else "mm"
        return (
            f'no unit is stated: N and N {by} are taken. Say unit = "kgf" of the forces and '
            '"kgf*cm" of the torques if they are so, or "gf" and "gf*cm": a force of '
            f"{most:.3g} is {most:.3g} N, in kgf {GRAVITY_MPS2 * most:.3g} N, in gf "
            f"{1e-3 * GRAVITY_MPS2 * most:.2g} N",
        )
    return ()


def axes_of(
    group: dict[str, ColumnGuess], said: Said, sign: float = 1.0, prefix: str = ""
) -> dict[str, Entry]:
    """Entries of the six axes; torques too large beside the forces are in Ncm or Nmm.

    Parameters
    ----------
    group
        Axis -> column.
    said
        What the lines above the table say.
    sign
        −1 where the transducer reads the opposite of what pulls on it.
    prefix
        Before each canonical name.
    """
    entries = {}
    lever = _lever(group)
    torque = "N*m" if lever <= _LONGEST_M else "N*cm" if lever <= _LONGEST_CM else "N*mm"
    doubt = torque == "N*cm" and not (said.unit.get("t") or group["tx"].unit)
    why = f"nothing says its unit: its lever is {lever:.2g} cm, or mm if it is in N mm"
    for axis, name in _AXIS_COLUMNS.items():
        column, kind = group[axis], axis[0]
        unit = column.unit or said.unit.get(kind) or ("N" if kind == "f" else torque)
        factor = sign * column.name.factor
        factor *= said.per_count.get(kind, 1.0) if column.counts else 1.0
        entry = replace(of(column, unit), factor=None if factor == 1 else factor)
        if not column.unit and kind in said.unit:
            entry = replace(entry, why="its name; the unit as it is said above the table")
        elif kind == "t" and doubt:
            entry = replace(entry, sure="guess", why=why)
        elif doubt and not column.unit:
            entry = replace(entry, sure="guess", why="nothing says its unit: N or kgf")
        entries[prefix + name] = entry
    return entries
