"""Feet whose cells a plate weighs, or whose cells themselves read kilograms.

Room: sniff; asked by experiment.
"""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from footcal_cli.sniff.cells import cells_in_time, of_both_feet
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, numbers_of
from footcal_cli.sniff.names import words_of
from footcal_cli.sniff.plan import FORCES, MASS, LogPlan
from footcal_cli.sniff.units import GRAVITY_MPS2, known_unit, split_unit
from footcal_cli.sniff.vocabulary import WORDS
from footcal_cli.tables.units import conversion

_SEVERAL = 2
"""Masses of so many names are of cells."""
_STEADY = 0.1
"""What a plate bears that nobody steps on or off changes by less than this share."""


_SAID = re.compile(
    r"(?i)\b(?:corners?|cells?|sensors?|channels?|values?|readings?|outputs?|data|feet|columns?|"
    r"zellen|sensoren|kanäle|werte|valeurs|capteurs|valores|valori|sensori)(?:\s+(?:are|is|sind|"
    r"sont|son|sono))?\s+(?:in|en)\s+(?P<unit>[^\s;,.()]+)"
)
"""``corners in kg``: what lines above a table say of all its readings."""


def in_said_unit(file: FileGuess) -> FileGuess:
    """The log with readings that have no unit in the one that a line above the table says."""
    said = {known_unit(f["unit"]) for line in file.text.above for f in _SAID.finditer(line)}
    unit = next(iter(said)) if len(said) == 1 else None
    if unit not in FORCES and unit not in ("V", "mV", "mV/V"):
        return file
    return replace(file, columns=tuple(
        replace(c, unit=unit, name=replace(c.name, quantity="reading"), why="said above the table")
        if c.quantity in ("reading", "unknown") and c.unit is None and c.values is not None
        and not c.counts else c for c in file.columns
    ))  # fmt: skip


def in_kilograms(file: FileGuess) -> FileGuess:
    """The log with loads that stand on both feet taken for what their cells read, for want of any.

    Weights that were put on are known in one column; a mass in several columns of each foot, next
    to stamps and to no reading, is what a firmware made of the readings. So are several loads next
    to a CoM and feet, whatever they are called: no weights are put on a robot that walks.
    """
    loads = [c for c in file.of("load") if c.values is not None and c.unit in FORCES]
    if file.of("reading", "force") or not file.of("time") or len(loads) < _SEVERAL:
        return file
    walks = bool(file.of("com") and file.of("motion"))
    if not walks and not (of_both_feet(loads) and all(c.name.side for c in loads)):
        return file
    why = "a mass on each cell of both feet"
    if walks:
        why = "a load on each cell of a body that moves"
    read = {c.column for c in loads}
    return replace(file, columns=tuple(
        c.as_quantity("reading", "likely", why)
        if c.column in read else c for c in file.columns
    ))  # fmt: skip


def beside_a_weight(file: FileGuess) -> FileGuess:
    """The log with masses by their unit alone as what cells show: ``c1_kg`` next to ``load_kg``.

    One column is called a load and takes fewer values than any other, and nothing else is read.
    """
    loads = [c for c in file.of("load") if c.values is not None and c.unit in FORCES]
    if len(loads) < _SEVERAL + 1 or file.of("reading", "force"):
        return file
    sizes = {c.column: np.unique(numbers_of(c)).size for c in loads}
    put = [c for c in loads if any(WORDS.get(w) == "load" for w in words_of(_stem(c)))]
    shown = [c for c in loads if c not in put]
    if len(put) != 1 or len({_stem(c) for c in shown}) < len(shown) or len(shown) < _SEVERAL:
        return file
    if sizes[put[0].column] >= min(sizes[c.column] for c in shown):
        return file
    names = {c.column for c in shown}
    return replace(file, columns=tuple(
        c.as_quantity("reading", "likely", f"a mass next to {put[0].column}")
        if c.column in names else c for c in file.columns
    ))  # fmt: skip


def _stem(column: ColumnGuess) -> str:
    return split_unit(column.column)[0]


def on_a_plate(file: FileGuess, cells: list[ColumnGuess]) -> LogPlan | None:
    """The plan for cells of two feet on one plate, whose force is the robot's weight.

    None where there is no such plate, or it does not bear all of the robot all the time.
    """
    plates = [
        c for c in file.of("force", "load", "reading", "unknown")
        if c.values is not None and not c.name.side and c.name.axis in ("", "fz")
        and (c.unit in FORCES or (c.quantity == "force" and c.unit is None))
    ]  # fmt: skip
    cells = [c for c in cells if c.name.side and c not in plates]
    if len(plates) != 1 or not of_both_feet(cells) or not file.of("time"):
        return None
    plate, unit = plates[0], plates[0].unit or "N"
    force = np.abs(numbers_of(plate))
    force = force[np.isfinite(force)]
    if unit not in FORCES or not force.size:
        return None
    low, middle, high = np.quantile(force, [0.05, 0.5, 0.95])
    if not high - low < _STEADY * middle:
        return None
    mass = float(middle) * conversion(unit, "N", GRAVITY_MPS2).slope / GRAVITY_MPS2
    plan = cells_in_time(file, cells)
    return replace(
        plan, blanks=tuple(blank for blank in plan.blanks if blank is not MASS),
        robot=(f"mass_kg = {mass:.4g}    # likely: what {plate.column} bears", *plan.robot),
        kind=f"{plan.kind}, on a plate",
    )  # fmt: skip
