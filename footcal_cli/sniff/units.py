"""Units that people write into headers and rows of units."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence

from footcal_cli.tables.units import SPELLINGS, TIMES

_ALSO = {
    "newton": "N", "newtons": "N", "kilogram": "kg", "kilograms": "kg", "gram": "g", "grams": "g",
    "gramm": "g", "sec": "s", "secs": "s", "seconds": "s", "second": "s", "sekunden": "s",
    **dict.fromkeys(("minute", "minutes", "minuten", "minuti", "minutos", "minuter", "minutter",
                     "minuty"), "min"),
    **dict.fromkeys(("hours", "stunden", "heures", "horas"), "h"),
    "millis": "ms", "msec": "ms", "milliseconds": "ms", "usec": "us", "micros": "us", "nsec": "ns",
    "nanoseconds": "ns", "volts": "V", "volt": "V", "vdc": "V", "mvdc": "mV",
    "degrees": "deg", "degree": "deg", "grad": "deg", "grados": "deg", "gradi": "deg",
    "graus": "deg", "degrés": "deg", "degres": "deg", "градус": "deg", "度": "deg",
    "fok": "deg", "derece": "deg", "grader": "deg", "graden": "deg", "stopnie": "deg",
    "%": "%", "%rh": "%", "%fs": "%",
    "%f.s.": "%", "%ro": "%", "%bw": "%", "db": "dB",
    "dbm": "dB", "ppm": "ppm", "radians": "rad", "celsius": "degC",
    "deg c": "degC", "°c": "degC", "m/s²": "m/s^2", "m/s2": "m/s^2", "m/s^2": "m/s^2",
    "lsb": "count", "raw": "count", "adc": "count", "cnt": "count", "cts": "count",
    "digits": "count", "digit": "count", "ticks": "count", "counts": "count", "count": "count",
    "pounds": "lb", "pound": "lb",
    "kp": "kgf", "kilopond": "kgf", "kgf": "kgf", "gf": "gf",
    "ounces": "oz", "ounce": "oz", "stones": "stone", "stone": "stone",
    "mv/v": "mV/V", "rad/s": "rad/s", "deg/s": "deg/s",
    "kn": "kN", "kilonewton": "kN", "mn": "mN", "hz": "",
    "mpa": "MPa", "n/mm²": "MPa", "n/mm2": "MPa", "gpa": "GPa",
    "millimeter": "mm", "millimetre": "mm", "millimeters": "mm",
    "millimetres": "mm", "centimeters": "cm", "centimetres": "cm",
    "inch": "in", "inches": "in", "meter": "m", "metre": "m",
    "meters": "m", "metres": "m", "s": "s", "m": "m", "n": "N",
    "dan": "daN", "decanewton": "daN",
    "кг": "kg", "г": "g", "н": "N", "кн": "kN", "мс": "ms", "с": "s", "мм": "mm", "мв": "mV",
    "كغ": "kg", "كجم": "kg", "غ": "g", "غرام": "g", "نيوتن": "N", "کیلوگرم": "kg", "گرم": "g",
    "किग्रा": "kg", "ग्राम": "g", "กก.": "kg", "กรัม": "g", "ק\"ג": "kg", "גרם": "g", "킬로그램": "kg",
    "в": "V", "千克": "kg", "公斤": "kg", "克": "g", "牛": "N", "秒": "s", "毫秒": "ms",
}  # fmt: skip
GRAVITY_MPS2 = 9.80665
MASSES = {"kg": 1.0, "g": 1e-3, "lb": 0.45359237, "oz": 0.028349523125, "mg": 1e-6}
"""In kg."""
LENGTHS = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "in": 0.0254, "ft": 0.3048}
"""In m."""
SHARES = ("%", "dB", "ppm")
"""Units of shares, which nothing that is calibrated here is given in."""
NO_READING = ("mm", "cm", "um", "in", "deg", "rad", "degC", "degF", "m/s^2", "m/s", "rad/s",
              "deg/s", "Hz", "rpm", "g0", "bar", "MPa", "GPa", *SHARES,
              *[unit for unit in TIMES if unit != "s"])  # fmt: skip
"""Units of what no load cell gives: lengths, angles, temperatures, speeds, shares, times."""
WEIGHTS = {"N": 1.0, "kN": 1e3, "mN": 1e-3}
"""In N."""
VOLTAGES = {"mV": 1.0, "V": 1e3, "uV": 1e-3, "µV": 1e-3}
"""In mV."""
LOADS = (*WEIGHTS, "kgf", "lbf", "gf", "kg", "g", "lb", "oz", "mg", "t", "stone", "daN", "ozf")
"""Units of a load."""
_AMBIGUOUS = 2
"""Units of so few letters differ by the size of these letters."""
_BRACKETED = re.compile(r"^(?P<stem>.*?)[\s_]*[\[(<{](?P<unit>[^\])>}]*)[\])>}]\s*$")
_WITHIN = re.compile(
    r"^(?P<stem>[^\[\](){}]*?)[\s_]*[\[(](?P<unit>[^\[\](){}]*)[\])](?P<after>[^\[\](){}]*)$"
)
"""A unit with words or an axis behind it: ``Force (N) + tension``, ``CoM (mm) X``."""
_SPOKEN = re.compile(r"^(?P<stem>.*\S)\s+in\s+(?P<unit>\S+)$")
"""A unit that is spoken: ``Force in kN``."""
_COUNTED = re.compile(r"(\d*\.?\d+(?:e-?\d+)?)\s*([A-Za-z·*/^²°.-]+)")
_SUFFIXES = {
    "n": "N", "nm": "N*m", "kg": "kg", "g": "g", "mn": "mN", "kn": "kN", "nmm": "N*mm", "s": "s",
    "ms": "ms", "us": "us", "ns": "ns", "mm": "mm", "m": "m", "cm": "cm", "deg": "deg",
    "degrees": "deg", "grad": "deg", "grados": "deg", "gradi": "deg", "graus": "deg",
    "degres": "deg", "degrés": "deg", "rad": "rad",
    "counts": "count", "raw": "count", "adc": "count", "cnt": "count", "cts": "count",
    "v": "V", "mv": "mV",
    "lb": "lb", "lbs": "lb", "lbf": "lbf", "degc": "degC", "grams": "g", "sec": "s", "gf": "gf",
    "kgf": "kgf", "oz": "oz", "mg": "mg", "newton": "N", "newtons": "N", "kpa": "kPa",
    "кг": "kg", "г": "g", "н": "N", "кн": "kN", "мс": "ms", "с": "s", "мм": "mm",
    "bar": "bar", "dan": "daN", "millis": "ms", "micros": "us", "volts": "V", "mvv": "mV/V",
    "db": "dB", "dbm": "dB", "ppm": "ppm", "pct": "%", "percent": "%",
}  # fmt: skip
_DEGREES = {"c": "degC", "f": "degF", "k": "K"}
_RATIO = re.compile(r"[_\s.-]+mV(?:[_\s./-]?(?:per[_\s.-]?)?)V$", re.IGNORECASE)
"""What a bridge gives for each volt: ``cell_mV_V``, ``Anzeige_mV/V``."""
_SPLIT = re.compile(r"[_\s/.\-,]+")
_TIMES = "[-_. *·⋅×]?"
_TORQUE = (
    rf"(?!k?n_)(?P<metric>mN|(?i:k?n|dan|kgf|kp|gf)){_TIMES}(?P<by>(?i:mm|cm|m))"
    rf"|(?i:(?P<pound>lb|oz)f?s?{_TIMES}(?P<to>in|ft)(?:ch)?)"
    rf"|(?i:(?P<far>in|ft)(?:ch)?{_TIMES}(?P<ounce>lb|oz)f?s?)"
)
"""A force by a length: ``N.mm``, ``kgfcm``, ``lbf-in``, ``ft-lbs``."""
_CYRILLIC = str.maketrans("НнКкМм", "NnKkMm")
_PRODUCT = re.compile(rf"[_\s/.,-]+(?P<unit>{_TORQUE})$")
"""A unit of torque at the end of a name: ``Tx_lbf-in``, ``Mz N.mm``, ``ty_kgfcm``."""


def _torque(text: str) -> str | None:
    """A unit of torque as footcal spells it, None where the text is none."""
    found = re.fullmatch(_TORQUE, text.translate(_CYRILLIC))
    if found is None:
        return None
    if found["metric"]:
        force = found["metric"]
        return f"{force if force == 'mN' else _ALSO[force.lower()]}*{found['by'].lower()}"
    return f"{found['pound'] or found['ounce']}f*{found['to'] or found['far']}".lower()


def metres_per(unit: str | None) -> float:
    """What 1 in a unit of lengths is in m; 1 where none is said, or it is none of lengths."""
    return LENGTHS.get(unit or "m", 1.0)


def known_unit(text: str) -> str | None:
    """A unit as footcal spells it, None where the text is none."""
    plain = text.strip().strip("[](){}<>").strip()
    if plain in SPELLINGS or plain in ("mV/V", "N*m", "N*mm", "m/s^2"):
        return {"counts": "count", "lbs": "lb", "sec": "s", "°": "deg"}.get(plain, plain)
    if torque := _torque(plain):
        return torque
    small = plain.lower()
    if len(small) > _AMBIGUOUS and small in SPELLINGS:
        return small  # lbF, KGF; of MN and mN the size of the letters is all that tells
    if (unit := _ALSO.get(small)) is not None:
        return unit or None
    one_letter_each = unicodedata.normalize("NFKC", plain)  # ℃, ㎏ and ㎜ are one sign
    return known_unit(one_letter_each) if one_letter_each != plain else None


def split_unit(name: str) -> tuple[str, str | None, float]:
    """A column's name without its unit, the unit, and how many of it are one of the numbers.

    >>> split_unit("Kraft [0.1 N]")
    ('Kraft', 'N', 0.1)
    """
    found = _BRACKETED.match(name) or _SPOKEN.match(name)
    if found and (unit := known_unit(found["unit"])) is not None:
        return found["stem"], unit, 1.0
    within = _WITHIN.match(name)
    if (
        within
        and re.search(r"[^\W\d_]{2}|^\W*[xyzXYZ]$", within["after"])
        and (unit := known_unit(within["unit"]))
    ):
        return within["stem"] + within["after"], unit, 1.0
    parted = _COUNTED.fullmatch(found["unit"].strip()) if found else None
    if found and parted and (unit := known_unit(parted[2])) and float(parted[1]) > 0:
        return found["stem"], unit, float(parted[1])
    if ratio := _RATIO.search(f" {name}"):
        return name[: max(ratio.start() - 1, 0)] or name, "mV/V", 1.0
    product = _PRODUCT.search(name)
    if product and (unit := known_unit(product["unit"])) is not None:
        return name[: product.start()].rstrip("_ /.-,"), unit, 1.0
    parts = [part for part in _SPLIT.split(name) if part]
    if len(parts) > 1:
        last = parts[-1]
        spelled = known_unit(last) if last in SPELLINGS else None
        unit = spelled or _SUFFIXES.get(last.lower()) or _torque(last)
        # left_m and force_g are a unit, leg_L is none; x_N as much as x_n
        if unit is not None and last.lower() not in ("l", "r"):
            return name[: name.rindex(last)].rstrip("_ /.-,"), unit, 1.0
    return name, None, 1.0


def degrees(words: Sequence[str], unit: str | None) -> str | None:
    """Unit of a temperature, by its unit or by the letter that its name ends with: ``T_F``."""
    if unit in ("degC", "degF", "K", "°C", "°F"):
        return unit
    return _DEGREES.get(words[-1]) if len(words) > 1 and unit is None else None


def looks_like_units(fields: list[str]) -> bool:
    """Whether a row of a text holds units."""
    said = [field for field in fields if field.strip().strip("[]()-")]
    bracketed = [found for field in said if (found := _BRACKETED.match(field))]
    if not said or any(b["stem"].strip() and known_unit(b["unit"]) for b in bracketed):
        return False  # "Load (kg)" is a name
    named = [split_unit(field)[0] for field in said if not known_unit(field)]
    if any(len(stem) > _AMBIGUOUS and stem not in said for stem in named):
        return False  # and so is "load_kg"
    return sum(known_unit(field) is not None for field in said) * 2 >= len(said)
