"""Units of columns: which spellings are known, what they are called in full, how they convert.

Only spellings that name one unit beyond doubt are taken: pint knows ``gr`` as grain, ``mil`` as a
thousandth of an inch and ``kp`` as nothing, where whoever wrote them meant something else.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, NoReturn

from footcal_cli.core.parameters import FloatArray
from footcal_cli.errors import UsageError, nearest

if TYPE_CHECKING:  # the registry takes long to build, and most logs need no unit converted
    import pint

SPELLINGS = {
    "N": "newton", "mN": "millinewton", "cN": "centinewton", "daN": "decanewton",
    "kN": "kilonewton", "MN": "meganewton",
    "kgf": "kilogram_force", "gf": "gram_force", "lbf": "pound_force", "ozf": "ounce_force",
    "kg": "kilogram", "g": "gram", "mg": "milligram", "t": "metric_ton", "lb": "pound",
    "lbs": "pound", "oz": "ounce",
    "m": "meter", "dm": "decimeter", "cm": "centimeter", "mm": "millimeter", "um": "micrometer",
    "µm": "micrometer", "μm": "micrometer", "km": "kilometer", "in": "inch", "ft": "foot",
    "s": "second", "sec": "second", "ms": "millisecond", "us": "microsecond", "µs": "microsecond",
    "μs": "microsecond", "ns": "nanosecond", "min": "minute", "h": "hour",
    "rad": "radian", "mrad": "milliradian", "deg": "degree", "°": "degree", "rev": "turn",
    "rpm": "revolutions_per_minute",
    "g0": "standard_gravity",
    "degC": "degree_Celsius", "°C": "degree_Celsius", "degF": "degree_Fahrenheit",
    "°F": "degree_Fahrenheit", "K": "kelvin",
    "Pa": "pascal", "hPa": "hectopascal", "kPa": "kilopascal", "MPa": "megapascal", "bar": "bar",
    "mbar": "millibar", "psi": "pound_force_per_square_inch",
    "count": "count", "counts": "count",
    "V": "volt", "mV": "millivolt", "uV": "microvolt", "µV": "microvolt",
    "Nm": "newton * meter", "mNm": "millinewton * meter", "kNm": "kilonewton * meter",
    "Nmm": "newton * millimeter", "Ncm": "newton * centimeter",
}  # fmt: skip
"""Short spellings that are taken -> the unit in full."""

_MASS, _LENGTH, _TIME = (1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0)
_FORCE, _PRESSURE, _VOLTAGE = (1, 1, -2, 0), (1, -1, -2, 0), (1, 2, -3, -1)
_ACCELERATION, _RATE, _NUMBER = (0, 1, -2, 0), (0, 0, -1, 0), (0, 0, 0, 0)
_POUND_KG, _G0_MPS2, _INCH_M = 0.45359237, 9.80665, 0.0254
_SIZES: dict[str, tuple[float, tuple[int, ...]]] = {
    "newton": (1.0, _FORCE), "millinewton": (1e-3, _FORCE), "centinewton": (1e-2, _FORCE),
    "decanewton": (10.0, _FORCE), "kilonewton": (1e3, _FORCE), "meganewton": (1e6, _FORCE),
    "kilogram_force": (_G0_MPS2, _FORCE), "gram_force": (1e-3 * _G0_MPS2, _FORCE),
    "pound_force": (_POUND_KG * _G0_MPS2, _FORCE),
    "ounce_force": (_POUND_KG / 16 * _G0_MPS2, _FORCE),
    "kilogram": (1.0, _MASS), "gram": (1e-3, _MASS), "milligram": (1e-6, _MASS),
    "metric_ton": (1e3, _MASS), "pound": (_POUND_KG, _MASS), "ounce": (_POUND_KG / 16, _MASS),
    "meter": (1.0, _LENGTH), "decimeter": (0.1, _LENGTH), "centimeter": (1e-2, _LENGTH),
    "millimeter": (1e-3, _LENGTH), "micrometer": (1e-6, _LENGTH), "kilometer": (1e3, _LENGTH),
    "inch": (_INCH_M, _LENGTH), "foot": (12 * _INCH_M, _LENGTH),
    "second": (1.0, _TIME), "millisecond": (1e-3, _TIME), "microsecond": (1e-6, _TIME),
    "nanosecond": (1e-9, _TIME), "minute": (60.0, _TIME), "hour": (3600.0, _TIME),
    "radian": (1.0, _NUMBER), "milliradian": (1e-3, _NUMBER), "degree": (math.pi / 180, _NUMBER),
    "turn": (2 * math.pi, _NUMBER), "count": (1.0, _NUMBER),
    "revolutions_per_minute": (2 * math.pi / 60, _RATE),
    "standard_gravity": (_G0_MPS2, _ACCELERATION),
    "pascal": (1.0, _PRESSURE), "hectopascal": (1e2, _PRESSURE), "kilopascal": (1e3, _PRESSURE),
    "megapascal": (1e6, _PRESSURE), "bar": (1e5, _PRESSURE), "millibar": (1e2, _PRESSURE),
    "pound_force_per_square_inch": (_POUND_KG * _G0_MPS2 / _INCH_M**2, _PRESSURE),
    "volt": (1.0, _VOLTAGE), "millivolt": (1e-3, _VOLTAGE), "microvolt": (1e-6, _VOLTAGE),
}  # fmt: skip
"""In SI units, with powers of kg, m, s and A: no registry is built for what most logs hold."""

NOT_SAID = "?"
"""Stands in a recipe for a unit that its writer has to be asked for, and behind one in a name."""
TIMES = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0}
"""In s."""

MEANT = {
    "gr": ("g (gram)", "grain"), "grs": ("g (gram)", "grain"), "gm": ("g (gram)",),
    "gms": ("g (gram)",), "G": ("g (gram)", "g0 (standard gravity)"),
    "kp": ("kgf (kilopond)",), "p": ("gf (pond)",), "kgs": ("kg (kilogram)",),
    "Kg": ("kg (kilogram)",), "KG": ("kg (kilogram)",), "kG": ("kg (kilogram)", "kgf"),
    "kilo": ("kg (kilogram)", "kgf (kilogram-force)"), "KN": ("kN (kilonewton)",),
    "mil": ("mm (millimetre)", "0.001 in"), "mils": ("mm (millimetre)", "0.001 in"),
    "MM": ("mm (millimetre)",), "M": ("m (metre)",), "CM": ("cm (centimetre)",),
    "NM": ("N*m (newton metre)",), "nm": ("N*m (newton metre)", "nanometer"),
    "nM": ("N*m (newton metre)",), "n": ("N (newton)",),
    "S": ("s (second)",), "MS": ("ms (millisecond)",), "mS": ("ms (millisecond)",),
    "Ms": ("ms (millisecond)",), "NS": ("ns (nanosecond)",), "US": ("us (microsecond)",),
    "cts": ("counts",), "ct": ("counts",), "cnt": ("counts",), "cnts": ("counts",),
    "lsb": ("counts",), "LSB": ("counts",), "raw": ("counts",), "adc": ("counts",),
    "digits": ("counts",), "C": ("degC",), "c": ("degC",), "F": ("degF",), "k": ("K", "kg"),
    "d": ("deg (degree)", "day"), "RAD": ("rad",), "DEG": ("deg",), "#": ("lb (pound)",),
    "ton": ("t (tonne)", "short_ton"), "tons": ("t (tonne)", "short_ton"), "T": ("t (tonne)",),
    "PA": ("Pa",), "pa": ("Pa",), "LB": ("lb",), "Lb": ("lb",), "LBF": ("lbf",),
    "oz_t": ("oz (ounce)",), "R": ("rev", "rad"), "r": ("rev", "rad"),
}  # fmt: skip
"""Spellings that are not taken -> what was probably meant."""

PLACES_TOO = frozenset({"lb", "ft", "in", "min"})
"""Units that are the end of other names as well: left back, force and torque, smallest."""

_LONGEST = 40
_ATOM = re.compile(r"([A-Za-zµμ°][A-Za-z_µμ°0]*)(?:(?:\*\*|\^)(-?[1-4]))?")
_SUPERSCRIPTS = {"²": "^2", "³": "^3", "·": "*", "⋅": "*", "×": "*"}
_SHORT = 3
"""Words of up to so many letters must be a known spelling; longer ones may be a name of pint's."""


@dataclass(frozen=True)
class Unit:
    """A unit that was understood.

    Parameters
    ----------
    name
        In full (``gram``, ``newton * meter``).
    """

    name: str


@dataclass(frozen=True)
class Conversion:
    """``canonical = slope * value + offset``, and whether a mass was taken as its weight."""

    source: Unit
    target: Unit
    slope: float
    offset: float = 0.0
    weighed: bool = False

    def __call__(self, values: FloatArray) -> FloatArray:
        """Values in the target's unit, same shape."""
        return values * self.slope + self.offset


@cache
def _registry() -> pint.UnitRegistry[float]:
    import pint

    registry: pint.UnitRegistry[float] = pint.UnitRegistry()
    return registry


def parse_unit(text: str) -> Unit:
    """Understand the spelling of a unit: names joined by ``*`` and ``/``, powers up to 4.

    Raises
    ------
    UsageError
        A spelling nobody knows, one that could mean several units, or anything but a unit.
    """
    shown = text.strip()
    if len(shown) > _LONGEST:
        raise UsageError(
            f"a unit of {len(shown)} characters", value=shown[:_LONGEST] + "…",
            remedy="write a unit such as N, kg, g, lbf, kgf, mm or deg",
        )  # fmt: skip
    plain = shown
    for sign, word in _SUPERSCRIPTS.items():
        plain = plain.replace(sign, word)
    full = ""
    # a product that follows a slash is one factor
    for piece in re.split(r"((?<!\*)\*(?!\*)|/)", plain):
        part = piece.strip()
        if part in ("*", "/"):
            full += f" {part} "
            continue
        atom = _ATOM.fullmatch(part)
        if atom is None:
            raise UsageError(
                f"'{shown}' is not the spelling of a unit",
                remedy="join names by * and /, with powers from 1 to 4: N, kg, N*m, m/s^2, deg/s",
            )
        name = _full_name(atom[1], shown)
        power = f" ** {atom[2]}" if atom[2] else ""
        product = " " in name and (bool(full) or bool(power))
        full += f"({name}){power}" if product else name + power
    return Unit(full)


def _full_name(word: str, whole: str) -> str:
    if word in SPELLINGS:
        return SPELLINGS[word]
    if word in MEANT:
        raise UsageError(
            f"unit '{whole}': '{word}' is not clear", remedy=f"write {' or '.join(MEANT[word])}"
        )
    if len(word) > _SHORT and word.islower():
        name = word.replace("metre", "meter")
        known = next((n for n in (name, name.removesuffix("s")) if n in _SIZES), "")
        if known:
            return known
        import pint

        try:
            return str(_registry().get_name(name))
        except (pint.errors.UndefinedUnitError, pint.errors.DefinitionSyntaxError, ValueError):
            pass
    raise UsageError(
        f"unknown unit '{whole}'{nearest(word, list(SPELLINGS))}",
        remedy="write a unit such as N, kg, g, lbf, kgf, mm or deg",
    )


def conversion(unit: str, to: str, gravity_mps2: float) -> Conversion:
    """How values in one unit become values in another; a mass becomes its weight as a force.

    Parameters
    ----------
    unit, to
        Spellings of units.
    gravity_mps2
        With which a mass weighs.

    Raises
    ------
    UsageError
        For a unit nobody knows, or one of another quantity.
    """
    named, wanted = parse_unit(unit), parse_unit(to)
    if named == wanted:
        return Conversion(named, wanted, 1.0)
    source, target = _size(named), _size(wanted)
    if source is None or target is None:
        return _by_registry(named, wanted, gravity_mps2) or _refuse(unit, named, to)
    if source[1] == _MASS and target[1] == _FORCE:
        return Conversion(named, wanted, source[0] * gravity_mps2 / target[0], weighed=True)
    # a radian is as dimensionless as a count
    if source[1] != target[1] or (named.name == "count") != (wanted.name == "count"):
        _refuse(unit, named, to)
    return Conversion(named, wanted, source[0] / target[0])


def _refuse(unit: str, named: Unit, to: str) -> NoReturn:
    raise UsageError(
        f"unit '{unit}' ({named.name}) is not one of the same quantity as '{to}'",
        remedy=f"give a unit that converts to {to}"
        + (", such as g0 (standard gravity)" if to == "m/s^2" else ""),
    )


def _size(unit: Unit) -> tuple[float, tuple[int, ...]] | None:
    """A unit in SI units, and its powers of kg, m, s and A; None where a name is pint's alone."""
    size, powers, sign = 1.0, [0, 0, 0, 0], 1
    for piece in re.findall(r"/|\([^)]*\)(?: \*\* -?\d)?|\w+(?: \*\* -?\d)?", unit.name):
        if piece == "/":
            sign = -1
            continue
        atom, _, power = piece.partition(" ** ")
        own = _size(Unit(atom[1:-1])) if atom.startswith("(") else _SIZES.get(atom)
        if own is None:
            return None
        times = sign * int(power or 1)
        size *= own[0] ** times
        powers = [p + times * q for p, q in zip(powers, own[1], strict=True)]
        sign = 1
    return size, tuple(powers)


def _by_registry(named: Unit, wanted: Unit, gravity_mps2: float) -> Conversion | None:
    """A conversion of units with other names, or with another zero; None where there is none."""
    registry = _registry()
    source, target = registry.Unit(named.name), registry.Unit(wanted.name)
    if source.is_compatible_with("kg") and target.is_compatible_with("N"):
        source_n = float(registry.Quantity(1.0, source).to("kg").magnitude) * gravity_mps2
        slope = source_n / float(registry.Quantity(1.0, target).to("N").magnitude)
        return Conversion(named, wanted, slope, weighed=True)
    if "count" in (named.name, wanted.name) or not source.is_compatible_with(target):
        return None
    offset = float(registry.Quantity(0.0, source).to(target).magnitude)
    slope = float(registry.Quantity(1.0, source).to(target).magnitude) - offset
    return Conversion(named, wanted, slope, offset)


def may_mean(word: str, to: str) -> bool:
    """Whether a word is a unit that converts to another, or may have been meant as one."""
    if word not in SPELLINGS and word not in MEANT and not re.search(r"[*/·^²]", word):
        return False
    meant = [text.split()[0] for text in MEANT.get(word, (word,)) if text != "counts"]
    try:
        return any(conversion(unit, to, 1.0) for unit in meant)
    except UsageError:
        return False


def load_list(text: str, gravity_mps2: float) -> tuple[float, ...]:
    """Loads in N of a text such as ``0, 1, 2, 5 lb``; a mass becomes its weight.

    Raises
    ------
    UsageError
        No unit, one that is none of a force or a mass, or a word among the numbers.
    """
    found = re.fullmatch(r"\[?([-+\d.,;\seE]+?)\]?\s*([A-Za-zµ]+)", text.strip())
    words = re.split(r"[\s,;]+", found[1].strip(" ,;")) if found else []
    try:
        values = [float(word) for word in words]
    except ValueError:
        values = []
    if found is None or not values:
        raise UsageError(
            f"'{text}' is no list of loads", remedy='write numbers and a unit: "0, 1, 2, 5 lb"'
        )
    change = conversion(found[2], "N", gravity_mps2)
    return tuple(value * change.slope for value in values)
