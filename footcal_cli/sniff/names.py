"""What the name of a column says: its quantity, its axis, and the sensor, foot or leg it is of."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from footcal_cli.sniff.joints import joint_angle
from footcal_cli.sniff.units import (
    LENGTHS,
    LOADS,
    MASSES,
    VOLTAGES,
    WEIGHTS,
    degrees,
    known_unit,
    split_unit,
)
from footcal_cli.sniff.vocabulary import (
    ANGLES,
    BEHIND_AN_END,
    EAST_ASIAN,
    ENDS,
    MARKED,
    NOT_OF_CELLS,
    OF_A_LEG,
    PLACES,
    SAID_OTHERWISE,
    SCATTER,
    SIDES,
    WITH_A_LEG,
    WORDS,
)
from footcal_cli.sniff.vocabulary import Quantity as Quantity
from footcal_cli.tables.units import TIMES

_CAMEL = re.compile(
    r"[A-Z]+(?![a-zà-öø-ž])|[A-Z]?[a-zà-öø-ž]+|\d+|[А-Яа-яЁёÀ-ž]+|[\u3041-\u30ff\u4e00-\u9fff]+"
)
_ASKED_OR_MEASURED = re.compile(r"(soll|ist|ziel)(kraft|last|gewicht|masse|wert|moment)")
_CENTRE = re.compile(r"(?<![A-Za-ce-z])[Cc]o[MP](?![a-z])")
_AXIS = re.compile(r"([fmt])([xyz])(\d{0,2})")


def are_names(fields: Sequence[str]) -> bool:
    """Whether every field of a row is a word for a column of its own: ``millis, raw, note``."""
    words = [field.strip().lower() for field in fields]
    return len(words) > 1 and len(set(words)) == len(words) and all(w in WORDS for w in words)


COMMANDED = {
    "setpoint", "target", "soll", "command", "commanded", "cmd", "desired", "consigne",
    "ziel",
}  # fmt: skip
"""Loads that were asked for; what was put on may be another."""
NOMINAL = {
    "nominal", "stated", "nenn", "nennlast", "nenngewicht", "nominell", "nominale", *COMMANDED
}  # fmt: skip
"""What stands on a weight, or was asked for: not what it weighs."""
_WEIGHED = {"actual", "true", "real", "certified", "conventional", "exact", "tatsächlich", "ist"}
"""What a weight really weighs, if the unit is one of loads."""
LETTERED = "letters"
"""Owner of angles called A, B and C, which are about z, y, x or about z, y, z."""
_GREEK = {"alpha": "rx", "beta": "ry", "gamma": "rz", "rx": "rx", "ry": "ry", "rz": "rz"}
_RUN = re.compile(r"(?<=[)\]])[\s,:]*(?:run|set|trial)\s*#?\s*\d+$", re.IGNORECASE)
"""A run behind the unit, as school software writes it."""
PUT = {"applied", "known", "reference", "ref", "true", "nominal", "rig", "standard", "load"}
"""How a rig's own wrench is called, beside the gauges that felt it."""
GROSS = {"gross", "brutto", "lordo", "bruto", "total"}
"""What lies on a cell with its tare; the net is what lies there without."""
NET = {"net", "netto", "neto"}
ADDED = {"added", "increment", "increments", "delta", "zugelegt", "ajouté", "ajoutée"}
"""What was put on top of what lay there."""
STATISTICS = {"mean", "avg", "average", "median", "std", "sd", "var", "min", "max", "sem"}
"""What stands in a second row of names, under the quantity that it is of."""
_MEAN = re.compile(r"[\W_](?!(?-i:AvG))(?:mean|avg|average|median)$", re.IGNORECASE)
_SPREAD = re.compile(r"[\W_](?:std|sd|stdev|stddev|var|variance|rms|sem)$", re.IGNORECASE)
"""How a column of means or of scatter is called."""
_QUOTED = re.compile(r"(?:^|(?<=/))'|'(?=/|$)")  # /'press'/'ref_N', of a TDMS file
_FOOT_AND_PLACE = re.compile(r"[lr][frbh][lr]")
"""A foot and a cell under it in one word: LFL, RRR."""
_UNDER_A_FOOT = re.compile(r"([lr])f(sensor|loadcell|cell)s?")
"""Cells of a foot in one word, as hrpsys calls its sensors: lfsensor; of a hand it is lhsensor."""
_F_OF = 3
_COMPOUNDS: tuple[tuple[str, Quantity], ...] = (
    ("gewicht", "load"), ("gewichte", "load"), ("belastung", "load"), ("messwert", "reading"),
    ("rohwert", "reading"), ("wellenwinkel", "phase"), ("beinwinkel", "phase"),
    ("temp", "temperature"), ("temperatur", "temperature"), ("temperature", "temperature"),
)  # fmt: skip
"""How compound words end that say what a column is: ``Prüfgewicht``."""
_NO_FORCE = {"com", "acc", "gyro", "imu", "position", "pos", "pose", "translation"}
_JOINTS = {"hip", "knee", "joint", "joints", "waist", "motor"}
"""What is driven: its torque is that of a motor, which no cell under a foot feels."""
_TICKS = {"sampletimefine": ("ms", 0.1)}  # tenths of a ms by Xsens' manual
_ACCELERATED = {"acc", "accel", "acceleration", "dd", "beschleunigung", "aceleración",
                "aceleracion", "accélération", "accelerazione", "aceleração"}  # fmt: skip
_TURNED = {"theta", "euler", "angle", "rpy", "rotvec", "angolo", "angulo", "ángulo", "ângulo"}
_REPORTED = {"plate", "platform", "measured", "meas", "sensor", "estimated", "est", "insole"}
FORCE = {"force", "forces", "kraft", "fuerza", "effort", "f", "forza", "grf", "kracht", "сила",
         "力"}  # fmt: skip
TORQUE = {"torque", "torques", "moment", "moments", "tau", "drehmoment", "m", "t", "couple",
          "coppia", "coppie",
          "момент", "力矩", "扭矩", "モーメント", "トルク"}  # fmt: skip
NOISE = {
    "field", "wrench", "header", "data", "fsr", "sensor", "value", "device", "sub", "list", "raw",
    "counts", "count", "adc", "reading", "cell", "lc", "loadcell", "load", "sole", "ft", "msg",
    "force", "torque", "moment", "measured", "sensors", "analog", "val", "s", "hx", "signal",
    "readings", "channel", "ch", "output", "kraft", "stamped", "foot", "feet", "total", "vertical",
    "effort", "filtered", "state", "zone", "pad", "corner", "n", "volt", "voltage", "est", "cells",
    "loadcells", "pied", "fuß", "fuss",
}  # fmt: skip
_ZONES = {"medial", "lateral", "heel", "toe", "hallux", "midfoot", "arch", *ENDS}
_FEET = {"lf": "left", "rf": "right"}
_INNER = re.compile(
    r"(heel|toe|ball|talon|ferse|front|rear|back)[\W_]*"
    r"(inn?er|in|innen|int|out|outer|ext|außen)(?![A-Za-z])", re.IGNORECASE,
)  # fmt: skip
"""The inner and the outer cell of a heel: ``heel_in`` is in no inches."""


@dataclass(frozen=True)
class NameGuess:
    """What a name says.

    Parameters
    ----------
    quantity
        What is measured.
    axis
        ``fx`` … ``tz``, ``x y z w``, ``roll pitch yaw``, ``11`` … ``33``; empty without one.
    side, place
        Left or right, and where on the foot or which leg; empty where nothing says so.
    owner
        What is left of the name, for telling sensors apart.
    unit
        As the name states it.
    factor
        How many of the unit are one of the numbers: 0.1 of ``[0.1 N]``.
    """

    quantity: Quantity
    axis: str = ""
    side: str = ""
    place: str = ""
    owner: str = ""
    unit: str | None = None
    factor: float = 1.0

    @property
    def address(self) -> str:
        """Name of the cell, foot or leg, as footcal writes it."""
        return "_".join(part for part in (self.side, self.place) if part) or self.owner


def _as_zone(found: re.Match[str]) -> str:
    return f"{found[1]}_{'medial' if found[2].lower().startswith('i') else 'lateral'}"


def common_start(words: Sequence[str]) -> str:
    """The letters that all words begin with."""
    first, last = min(words), max(words)
    return first[: next((i for i, c in enumerate(first) if last[i] != c), len(first))]


def is_label(word: str) -> bool:
    """Whether a word is one for sensors or what they sit on."""
    return WORDS.get(word) == "label" or word in NOISE


def words_of(name: str) -> list[str]:
    """Words of a name in small letters: ``LFsrFL`` is l, fsr, fl, and ``CoM`` is com."""
    for phrase, said in SAID_OTHERWISE:
        name = phrase.sub(f" {said} ", name)
    for word, said in EAST_ASIAN.items():
        name = name.replace(word, f" {said} ")
    name = _CENTRE.sub(lambda centre: f"_{centre[0].lower()}_", name)  # ddCoM is dd, com
    words = [word.lower() for word in _CAMEL.findall(name)]
    return [part for word in words for part in _parts_of(word)]


def _parts_of(word: str) -> list[str]:
    """Known words within one that is written without blanks: Chinese, Japanese, ``Sollkraft``."""
    if compound := _ASKED_OR_MEASURED.fullmatch(word):
        return list(compound.groups())
    if _FOOT_AND_PLACE.fullmatch(word):
        return [word[0], word[1:]]
    if under := _UNDER_A_FOOT.fullmatch(word):
        return [under[1], "foot", under[2]]
    if word in ("dcom", "ddcom"):
        return [word[:-3], "com"]
    if word.isascii() or word in WORDS or word < "\u3000":
        return [word]
    return [known for known in WORDS if known > "\u3000" and known in word] or [word]


def name_guess(name: str) -> NameGuess:
    """What a column's name says of it."""
    plain = re.sub(r"\[(\d+)\]", r"_\1", _QUOTED.sub("", name).lstrip("%#$/ ").rstrip("?:. "))
    plain = _INNER.sub(_as_zone, _RUN.sub("", plain))
    plain = re.sub(r"(?<=[\])])\.\d+$", "", plain)  # the same name a second time
    stem, unit, factor = split_unit(_MEAN.sub("", plain))
    unit, factor = _TICKS.get(stem.lower(), (unit, factor))
    called = known_unit(stem) if len(stem) > 1 else None
    unit = unit or (called if called in (*MASSES, *WEIGHTS, *VOLTAGES) else None)
    words = words_of(stem)
    if _SPREAD.search(stem.rstrip(". ")) or SCATTER & {*words}:
        return NameGuess("other", unit=unit)
    side, place, rest = _address(words)
    quantity, axis, used = _quantity(stem, words, unit)
    if quantity == "unknown" and rest and rest != words:
        quantity, axis, used = _quantity(stem, rest, unit)  # fz_left
    warm = degrees(words, unit) if quantity in ("temperature", "time", "unknown") else None
    if warm and (quantity == "temperature" or unit or stem[0] == "T"):
        quantity, unit = "temperature", warm
    elif quantity == "temperature" and unit == "deg":
        unit = "degC"  # Temperatur_Grad
    if quantity in ("unknown", "reading", "load", "placement") and not axis:
        quantity = joint_angle({*words}, unit) or quantity
    if quantity == "unknown" and len(stem) > 1 and (clock := known_unit(stem)) in TIMES:
        quantity, unit = "time", clock  # sec, Sekunden
    if quantity == "time" and unit is None:  # Minutes after load change
        unit = next((u for w in words if len(w) > 3 and (u := known_unit(w)) in TIMES), None)
    owner = "_".join(w for w in rest if w not in used and w not in NOISE)
    if quantity == "force" and axis and words[-1].isdigit() and words[-1] not in owner:
        owner = f"{owner}_{words[-1]}".strip("_")  # plates are counted: Fx1, Fx2
    return NameGuess(quantity, axis, side, place, owner, unit, factor)


def without_side(name: str, side: str) -> str:
    """A name without the word or the letter that its side begins it with: ``links_2`` is 2."""
    sides = (sorted((w for w, s in words.items() if s == side), key=len, reverse=True)
             for words in (SIDES, WITH_A_LEG))  # fmt: skip
    called, more = map("|".join, sides)
    return re.sub(rf"^(?:(?:{called}|{more})(?=_|\d|$)|{called})_?", "", name)


def _address(words: list[str]) -> tuple[str, str, list[str]]:
    """Side, place and the other words."""
    side = place = ""
    rest: list[str] = []
    i = 0
    while i < len(words):
        word = words[i]
        following = words[i + 1] if i + 1 < len(words) else ""
        if word in ENDS and SIDES.get(following) and len(following) > 1 and not place:
            place, i = ENDS[word] + SIDES[following][0], i + 2
            continue
        if word in SIDES and len(word) > 1 and following in ENDS and not place and side:
            place, i = ENDS[following] + SIDES[word][0], i + 2
            continue
        if word in ENDS and following in BEHIND_AN_END and not place:
            place, i = ENDS[word] + BEHIND_AN_END[following][0], i + 2
            continue
        if word in WITH_A_LEG and not side and OF_A_LEG & set(words):
            side, i = WITH_A_LEG[word], i + 1
            continue
        if word in _ZONES and following in SIDES and side and not place:
            # behind the foot's side the place's own: LF_ToeLeft
            place, i = f"{word}_{SIDES[following]}", i + 2
            continue
        if word in PLACES and not place:
            # lf before another place is the left foot
            later = any(w in PLACES or w in _ZONES for w in words[i + 1 :])
            if later and word in _FEET and not side:
                side = _FEET[word]
            else:
                place = PLACES[word]
        elif word in SIDES and not side:
            side = SIDES[word]
        elif word in _ZONES and (not place or place in _ZONES):
            place = f"{place}_{word}".strip("_")
        else:
            rest.append(word)
        i += 1
    return side, place, rest


def _quantity(stem: str, words: list[str], unit: str | None) -> tuple[Quantity, str, set[str]]:
    """Quantity and axis of a name, and the words that said so."""
    compact = [w for w in words if not w.isdigit()]
    last = words[-1] if words else ""
    axis = _AXIS.fullmatch("".join(words[-1:])) or _AXIS.fullmatch("".join(words[-2:]))
    kinds = {w for w in words if w in FORCE or w in TORQUE}
    if "cop" in words or re.search(r"cop_?[xyzap](?![a-z]{2})", stem.lower()):
        found = re.search(r"(?:cop)[\W_]*([xyzap])|([xy])[\W_]*cop", stem.lower())
        letter = (found[1] or found[2]) if found else last[:1]
        return "cop", {"a": "x"}.get(letter, letter), {"cop", "x", "y", "copx", "copy"}
    centre = re.fullmatch(r"([xyz])com|com([xyz])", last)
    if centre or (
        {"com", "center", "centre"} & set(words) and last[-1:] in "xyz"
        and not {"cop", "rotation", "orientation", "quaternion", "quat", "euler"} & set(words)
        and last[:-1] in ("", "d", "dd", "a", "acc", "v", "vel")
    ):  # fmt: skip
        if {"vel", "velocity", "speed", "twist"} & set(words) or last[:-1] in ("d", "v", "vel"):
            return "other", "", set(words)
        acc = _ACCELERATED & set(words) or last[:-1] in ("dd", "a", "acc")
        axis_of = (centre[1] or centre[2]) if centre else last[-1]
        return ("com_acc" if acc else "com"), axis_of, set(words)
    if {"gravity", "grav"} & set(words) and last in "xyz":
        return "gravity", last, {"gravity", "grav", last}
    if (part := {"linear", "angular"} & set(words)) and "wrench" in words and last in "xyz":
        return "force", ("f" if "linear" in part else "t") + last, {last, *part}
    if axis and not set(words) & _NO_FORCE:
        kind = "f" if axis[1] == "f" else "t"
        return "force", kind + axis[2], {axis[0], axis[1], axis[2], axis[1] + axis[2]}
    if kinds and last in ("x", "y", "z", *(("vx", "vy", "vz") if max(map(len, kinds)) > 1 else ())):
        kind = "f" if kinds & FORCE and not any(len(w) > 1 for w in kinds & TORQUE) else "t"
        return "force", kind + last[-1], {last, *kinds}
    if (
        re.fullmatch(r"q[xyzw]|q_[xyzw]", stem.lower().split(".")[-1].split("_q")[0])
        or (
            {"quat", "quaternion", "orientation", "q", "rotation", "rot"} & set(words)
            and last in ("x", "y", "z", "w")
        )
        or re.fullmatch(r"q[xyzw]", last)
    ):
        return "quaternion", last[-1], {"quat", "quaternion", "orientation", "q", last}
    found = re.fullmatch(r"(?:.*[\W_])?q(?:uat|uaternion)?[\W_]?([0-3])", stem.lower())
    if found and unit is None and not {"joint", "joints"} & set(words):
        return "quaternion", found[1], {"q", "quat", "quaternion", found[1]}
    if re.fullmatch(r"(?:.*[\W_])?a[xy]", stem.lower()) and unit in LENGTHS:
        return "cop", last[-1], {last}  # Kistler's Ax and Ay
    said = {"acc", "accel", "acceleration", "accelerometer", "accelerometers"} & set(words)
    if said and last in "xyz":
        return "acceleration", last, {last, *said}
    if re.fullmatch(r"(?:acc|a)[xyz]", last):
        return "acceleration", last[-1], {last}
    if re.fullmatch(r"(?:.*[\W_])?r[xyz]", stem.lower()) and unit in ("rad", "deg", None):
        return "angle", last, {last}
    if words and words[-1] in _GREEK and unit in ("rad", "deg", None) and len(words[-1]) > 2:
        return "angle", _GREEK[words[-1]], {words[-1]}
    if words[-2:-1] == ["axis"] and last in ("x", "y", "z") and unit is None:
        return "angle", f"a{last}", {"axis", last}
    if last == "angle" and unit in ("rad", "deg", None):
        return "angle", "angle", {"angle"}
    if _TURNED & set(words) and last in ("x", "y", "z"):
        return "angle", f"r{last}", {last, *_TURNED}
    for word in words:
        if word in ANGLES:
            return "angle", ANGLES[word], {word}
    found = re.fullmatch(r"r_?([0-3])_?([0-3])", stem.lower().split(".")[-1].split("rot_")[-1])
    if found:
        return "matrix", found[1] + found[2], {"r"}
    place = words[0] if len(words) > 1 and words[0] in ("x", "y") else last  # X_ref, ref_x
    if place in ("x", "y") and unit in LENGTHS and set(words) & _REPORTED:
        return "cop", place, {place, *_REPORTED}
    if (place in ("x", "y") and set(words) & MARKED) or (
        stem.lower() in ("x", "y") and unit in (*LENGTHS, None)
    ):
        return "hole", place, {place}
    if set(words) & NOT_OF_CELLS or ("tau" in words and set(words) & _JOINTS):
        return "other", "", set()
    return _by_words(words, compact, unit)


def _meant(word: str) -> Quantity | None:
    """What a word is of, by itself or by how it ends."""
    stem = word[1:]
    if word[:1] == "f" and WORDS.get(stem) == "load" and len(word) > _F_OF and (
        stem not in STATISTICS
    ):  # fmt: skip
        return "load"  # Fref, Fsoll
    ends = (quantity for end, quantity in _COMPOUNDS if word.endswith(end))
    return WORDS.get(word) or next(ends, None)


def _by_words(
    words: list[str], compact: list[str], unit: str | None
) -> tuple[Quantity, str, set[str]]:
    """Quantity by a word of the vocabulary, the last one first, or by the unit alone."""
    if (
        any(w in ("weight", "load", "mass", "gewicht", "masse", "poids", "last") for w in words)
        and any(w in ("cell", "cells", "sensor", "sensors", "raw", "counts", "adc") for w in words)
        and "on" not in words
    ):
        return "reading", "", set()
    if compact and {*compact} <= _WEIGHED and unit in LOADS:
        return "load", "", set(compact)
    if words in (["p"], ["p", "0"]):
        return "pressure", "", set(words)
    if words and words[-1] in ("x", "y", "z") and unit in LENGTHS:
        return "unknown", "", set()  # a place is no load, whatever it is a reference for
    for quantity in ("time", "load", "temperature", "direction", "repeat", "session", "phase",
                     "orientation", "placement", "contact", "pressure", "reading", "label",
                     "sequence", "other"):  # fmt: skip
        said = [w for w in compact if _meant(w) == quantity]
        if said and not (quantity == "load" and unit is None and {*said} <= GROSS | NET):
            if quantity == "load" and unit in ("count", "V", "mV", "mV/V"):
                return "reading", "", set(said)
            weighed = quantity in ("session", "repeat") and unit in LOADS  # Set (kg)
            return "load" if weighed else quantity, "", set(said)
    if set(words) & FORCE:
        return "force", "", set(words) & FORCE
    if all(len(w) <= 2 for w in compact):
        if unit in ("s", "ms", "us", "ns"):
            return "time", "", set()
        if unit in ("kg", "g", "lb", "oz", "kgf", "lbf"):
            return "load", "", set()
    return "unknown", "", set()
