"""What lines above a table say of the robot's mass and of weights, and where its numbers differ.

Room: sniff; asked by several.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.core.plausibility import TOTAL_RANGE
from footcal_cli.sniff.cells import NAMEPLATE
from footcal_cli.sniff.guesses import Sure, numbers_of
from footcal_cli.sniff.placed import WEIGHT
from footcal_cli.sniff.plan import (
    FORCES,
    IN_NEWTON,
    MASS,
    NOT_SAID,
    UNIT_ASKED,
    Blank,
    Entry,
    LogPlan,
)
from footcal_cli.sniff.said_accuracy import with_accuracy
from footcal_cli.sniff.said_axes import with_left_asked
from footcal_cli.sniff.said_gravity import with_gravity
from footcal_cli.sniff.said_scales import with_scale
from footcal_cli.sniff.tokens import IN_WORDS
from footcal_cli.sniff.units import GRAVITY_MPS2, LOADS, known_unit
from footcal_cli.tables.units import conversion

_UNIT = r"[A-Za-zкгН]{1,4}"
_MASSES = (
    r"(?i:\b(?:(?:body|körper|kropps)[ _-]?)?(?:mass|weighs?|weight|masse|gewicht|wiegt|poids|"
    r"pèse|masa|waga|waży|massa|massan|peso|pesa|vikt|väger|vægt|vejer|vekt|veier|weegt|hmotnost|"
    r"váží|tömeg|paino|painaa|ağırlık|kütle|масса|вес|весит)\b|体重|質量|质量|重量)"
)
_ROBOT = (
    r"(?i:\b(?:robot\w*|biped\w*|hexapod\w*|quadruped\w*|humanoid\w*|person|subject|proband\w*|"
    r"sujet|sujeto|participant|athlete)\b)"
)
_HAS_MASS, _HAS_ROBOT = re.compile(_MASSES), re.compile(_ROBOT)
_MASS = re.compile(
    rf"(?:{_MASSES}|{_ROBOT})[^\d\n;,:=\[(]{{0,25}}(?:\([^()\d\n]{{5,60}}\)\s*)?[\[(]?\s*(?P<before>{_UNIT})?\s*[\])]?[\s\"';,:=]*"
    rf"(?P<number>\d+(?:[.,]\d+)?)[\s\"';,\[(]*(?P<after>{_UNIT})?(?!\w|\.\w)"
)
"""``Körpergewicht: 71,5 kg``, ``"Weight [kg]","66.0"``, ``robot: pupper, mass: 2.1 kg``.

A remark in brackets may stand between: ``Massa total (balança do laboratório): 14,64 kg``.
"""
_OF_A_PART = re.compile(
    r"(?i)\b(?:tool|payload|leg|foot|feet|gripper|hand|cell|sensor|calibration|known|test|applied|"
    r"plate|per|each|insole|sole|shank|thigh|tara|tare|empty|holes?|prüf\w*|kalibrier\w*|eich\w*|"
    r"étalon\w*|campione|patrón|wzorc\w*|odważnik\w*|zelle|cellule|cella|celda|bein|jambe|gamba|"
    r"pata|werkzeug|outil|herramienta|utensile|fuß|fuss|pied|piede|pie)\b"
)
"""Words with which a mass is not that of all that stands there."""
_WITHOUT = re.compile(
    r"(?i)\b(?:without|w/o|excl\w*|exkl\w*|minus|less|ohne|sans|sin|senza|sem|zonder|uten|uden|utan|bez|"
    r"ilman|nélkül)\b"
)
_LESS = re.compile(rf"{_WITHOUT.pattern}(?!\D{{0,12}}\d)")
"""What was not weighed; with its mass behind it, it says what the rest would be."""
_REMARK = re.compile(
    r"(?i)[,;(]|\b(?:with|includ\w*|incl|mit|inkl\w*|samt|avec|con|com|med|met|inclu\w*|compris)\b"
)
"""What a robot was weighed with stands behind its mass: ``41.3 kg with battery and feet``."""
_LISTED = re.compile(
    r"(?i)\b(?:loads|weights|masses|gewichte|lasten|charges|cargas|pesi|massen|poids|vikter)\b"
)
_PUT = re.compile(
    r"(?i)\b(?:put|placed|laid|set|aufgelegt|aufgesetzt|posée?|puest[oa]|colocad[oa])\b"
)
"""What was done with a weight that no line calls one."""
_NUMBER = re.compile(r"\d+(?:[.,]\d+)?")
_CAPACITY = re.compile(
    r"(?i)\b(?:capacity|range|rated|full.?scale|nennlast|messbereich|höchstlast|nennkraft|portée|"
    r"capacité|capacidad|portata|fondo.?scala|mätområde|nimellis\w*|névleges\w*|jmenovit\w*|"
    r"znamionow\w*|ονομαστικ\w*)\b|\dm?V\b|mV/V"
)
_NEAR, _BY_FAR = 0.15, 1.5
"""How far forces may be from a robot's weight as a share; ratio of its mass to any other named."""
_OF_MASS = ("kg", "g", "lb")
_NOMINAL = 0.02
"""How far a weight may be from what it is called."""
_FAR = 30.0
"""No cell is loaded with so many times its capacity, and no list of loads is so far off."""


def as_said_above(plan: LogPlan) -> LogPlan:
    """The plan with masses and gravity as they stand above; asked for where numbers contradict."""
    weighed = _with_mass(_in_newtons(_with_put(plan)))
    return with_accuracy(with_left_asked(with_gravity(with_scale(_with_load(weighed)))))


def _in_newtons(plan: LogPlan) -> LogPlan:
    """The plan with readings in N where nothing says their unit and they weigh the robot so."""
    read = {name: entry for name, entry in plan.read.items() if name.endswith("_counts")}
    plain = all(e.column is not None and e.unit is None and not e.column.counts and e.factor is None
                for e in read.values())  # fmt: skip
    masses = _masses(plan.file.text.above)
    if NAMEPLATE not in plan.blanks or not read or not plain or len(masses) != 1:
        return plan
    mass = next(iter(masses))
    why = f"in N they carry the {mass:g} kg that are said"
    made = {name: replace(entry, unit="N", why=why) for name, entry in read.items()}
    weighed = replace(
        plan, entries={**plan.entries, **made}, robot=(*plan.robot, IN_NEWTON),
        blanks=tuple(blank for blank in plan.blanks if blank is not NAMEPLATE),
    )  # fmt: skip
    total = _total_n(weighed)
    near = total is not None and abs(total / (mass * GRAVITY_MPS2) - 1.0) < _NEAR
    return weighed if near else plan


def _with_put(plan: LogPlan) -> LogPlan:
    """Placements with the one weight on all holes that a line says."""
    entry = plan.entries.get("load_n")
    weighs = [x for x in plan.file.text.above if not _HAS_ROBOT.search(x)]
    lines = [x for x in weighs if _HAS_MASS.search(x)] or [x for x in weighs if _PUT.search(x)]
    said = {(f[1], known_unit(f[2]) or f[2]): x for x in lines for f in IN_WORDS.finditer(x)}
    lies = entry is not None and UNIT_ASKED in plan.blanks and _says_whether(entry)
    if not (WEIGHT in plan.blanks or lies) or entry is None or not said:
        return plan
    sizes = [_newton(number, unit) for number, unit in said]
    if max(sizes) > (1.0 + _NOMINAL) * min(sizes):
        return plan
    number, unit = max(said, key=lambda one: len(one[0]))  # 12.003 kg of a 12 kg weight
    line = said[number, unit]
    put = number.replace(",", ".")
    names = {word: put if own == NOT_SAID else own for word, own in entry.names.items()}
    value = put if entry.value == NOT_SAID else entry.value
    why = f"'{line.strip()}'"
    made = replace(entry, value=value, names=names, unit=unit, sure="likely", why=why)
    made = replace(made, factor=float(put)) if lies else made
    blanks = tuple(blank for blank in plan.blanks if blank not in (WEIGHT, UNIT_ASKED))
    return replace(plan, entries={**plan.entries, "load_n": made}, blanks=blanks)


def _says_whether(entry: Entry) -> bool:
    """Whether a load's column says only that the weight lies there (1) or does not (0)."""
    column = entry.column
    return column is not None and column.values is not None and {*column.values} == {0.0, 1.0}


def _masses(above: Sequence[str]) -> dict[float, str]:
    """Masses in kg of all that stands there -> the line that says each."""
    found = {}
    for line in above:
        of_a_part = bool(_OF_A_PART.search(_without_remark(line)))
        for said in _MASS.finditer(line):
            if _is_of_a_part(line, said.start("number")):
                continue
            unit = known_unit(said["before"] or "") or known_unit(said["after"] or "")
            if unit in LOADS and (newton := _newton(said["number"], unit)) > 0:
                found[round(newton / GRAVITY_MPS2, 6)] = line.strip()
        alone = [*IN_WORDS.finditer(line)]
        if len(alone) == 1 and _HAS_ROBOT.search(line, 0, alone[0].start()):
            of_a_part = _is_of_a_part(line, alone[0].start())
        unit = known_unit(alone[0][2]) or alone[0][2] if len(alone) == 1 else ""
        if _HAS_ROBOT.search(line) and unit in _OF_MASS and not of_a_part:
            found[round(_newton(alone[0][1], unit) / GRAVITY_MPS2, 6)] = line.strip()
    return found


def _is_of_a_part(line: str, at: int) -> bool:
    """Whether the number there is the mass of a part, by the words of its line.

    Where the robot is named before it, those behind the robot's name up to a remark count:
    ``Robot with battery and feet: 24.6 kg`` weighs all of it.
    """
    robot = _HAS_ROBOT.search(line, 0, at)
    if robot is None:
        return _OF_A_PART.search(_without_remark(line)) is not None
    named = line[: robot.end()] + _REMARK.split(line[robot.end() : at])[0]
    named += _REMARK.split(line[at:])[0]
    return bool(_OF_A_PART.search(named) or _WITHOUT.search(line, 0, at) or _LESS.search(line, at))


def _without_remark(line: str) -> str:
    """A line with one mass, of a robot, up to what is said behind it: ``…, feet included``."""
    alone = [*IN_WORDS.finditer(line)]
    if len(alone) != 1 or _WITHOUT.search(line) or not _HAS_ROBOT.search(line, 0, alone[0].start()):
        return line
    return line[: alone[0].end()] + _REMARK.split(line[alone[0].end() :])[0]


def _newton(number: str, unit: str) -> float:
    """A written load or mass in N."""
    return float(number.replace(",", ".")) * conversion(unit, "N", GRAVITY_MPS2).slope


def _newton_each(unit: str, factor: float | None) -> float:
    """What 1 in a column of a unit, and of a factor if it has one, is in N."""
    return conversion(unit, "N", GRAVITY_MPS2).slope * (factor or 1.0)


def _by_size(plan: LogPlan) -> tuple[dict[float, str], Sure]:
    """The one mass that lines name which the forces agree with, or that is by far the largest."""
    found: dict[float, str] = {}
    for line in plan.file.text.above:
        if _CAPACITY.search(line) or _OF_A_PART.search(_without_remark(line)):
            continue
        for said in IN_WORDS.finditer(line):
            unit = known_unit(said[2]) or said[2]
            if unit in _OF_MASS and (newton := _newton(said[1], unit)) > 0:
                found.setdefault(round(newton / GRAVITY_MPS2, 6), line.strip())
    total = _total_n(plan)
    if total is not None:
        near = {m: x for m, x in found.items() if abs(total / (m * GRAVITY_MPS2) - 1.0) < _NEAR}
        return near, "likely"
    largest, *others = sorted(found, reverse=True) or [0.0]
    far = largest > _BY_FAR * max(others, default=0.0)
    return ({largest: found[largest]} if far and largest > 0 else {}), "guess"


def _with_mass(plan: LogPlan) -> LogPlan:
    said, sure = _masses(plan.file.text.above), "likely"
    if MASS in plan.blanks and len(said) != 1:
        said, sure = _by_size(plan)
    if MASS not in plan.blanks or len(said) != 1:
        return plan
    mass, line = next(iter(said.items()))
    total = _total_n(plan)
    blanks = tuple(blank for blank in plan.blanks if blank is not MASS)
    if total is None or TOTAL_RANGE[0] < total / (mass * GRAVITY_MPS2) < TOTAL_RANGE[1]:
        own = f"mass_kg = {mass:g}    # {sure}: '{line}'"
        return replace(plan, robot=(own, *plan.robot), blanks=blanks)
    why = (
        f"the forces add up to {total:.3g} N, which is no mass of {mass:g} kg ('{line}'): correct "
        "the unit of the forces in [columns] (N, kN, kgf …), or the mass"
    )
    return replace(plan, blanks=(replace(MASS, why=why), *blanks))


def _total_n(plan: LogPlan) -> float | None:
    """What all vertical forces add up to, in the middle of the log; None where some are counts."""
    forces = []
    for name, entry in plan.entries.items():
        if not name.endswith(("_fz_n", "_counts")):
            continue
        if entry.column is None or entry.column.values is None or entry.unit not in FORCES:
            return None
        forces.append(numbers_of(entry.column) * _newton_each(entry.unit, entry.factor))
    if not forces or len({f.shape for f in forces}) > 1:
        return None
    return float(abs(np.nanmedian(np.sum(forces, axis=0))))


def _with_load(plan: LogPlan) -> LogPlan:
    """The plan, the unit of its load asked for where a line above the table contradicts it."""
    entry = plan.entries.get("load_n")
    if entry is None or entry.column is None or entry.column.values is None:
        return plan
    if entry.unit not in LOADS:
        return plan
    put = np.abs(numbers_of(entry.column)) * _newton_each(entry.unit, entry.factor)
    for most, line, both_ways in _loads(plan.file.text.above):
        ratio = float(np.nanmax(put)) / most
        if ratio > _FAR or (both_ways and ratio < 1 / _FAR):
            why = (
                f"the unit of the load is in doubt: '{entry.column.column}' goes up to "
                f"{np.nanmax(np.abs(numbers_of(entry.column))):g} {entry.unit}, but '{line}' "
                "stands above the table"
            )
            asked = replace(entry, unit=NOT_SAID, sure="guess", why="contradicted above the table")
            lines = ('# in [columns]: unit = "?" of load_n becomes N, kg, g, lb …',)
            return replace(
                plan, entries={**plan.entries, "load_n": asked},
                blanks=(*plan.blanks, Blank(lines, why)),
            )  # fmt: skip
    return plan


def _loads(above: Sequence[str]) -> Iterator[tuple[float, str, bool]]:
    """The largest load in N that a line says, the line, and whether loads must come near it."""
    for line in above:
        listed = bool(_LISTED.search(line)) and len(_NUMBER.findall(line)) > 1
        if not (listed or _CAPACITY.search(line)):
            continue
        sizes = [
            _newton(found[1], known_unit(found[2]) or found[2]) for found in IN_WORDS.finditer(line)
        ]
        if max(sizes, default=0.0) > 0:
            yield max(sizes), line.strip(), listed
