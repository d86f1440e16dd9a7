"""What notes say of a transducer at a foot: where it sits, how it is turned, what hangs below it.

Room: sniff; asked by recipe_text. ``Sensor centre in sole frame: (-12, 0, 92) mm, both feet`` is a
place; a sentence with a mass below the transducer may hold the place of its centre.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.sniff.listed_places import sides_said
from footcal_cli.sniff.said_gravity import gravity_in
from footcal_cli.sniff.tokens import IN_WORDS
from footcal_cli.sniff.units import GRAVITY_MPS2, LENGTHS, MASSES, known_unit, metres_per

_NUMBER = r"[-+−]?\d+(?:[.,]\d+)?"
_POINT = re.compile(
    rf"(?P<ahead>\b[a-z]{{1,2}}\b)?\s*[(\[]\s*({_NUMBER})\s*[,;]\s*({_NUMBER})\s*[,;]\s*({_NUMBER})\s*"
    r"(?P<within>[a-z]{1,2})?\s*[)\]]\s*(?P<behind>(?!in\b)[a-z]{1,2}\b)?"
)
"""Three numbers in brackets, their unit before, within or behind them; there ``in`` is a word."""
_AXIS_TO = re.compile(r"(?i)\b[xyz]\b[\s:=]*(?:to (?:the )?)?[^\W\d_]{2,}")
"""Which way an axis points: ``y left``, ``z: up``."""
_UP = re.compile(
    rf"^[^\d]*(?P<height>{_NUMBER})\s*(?P<unit>mm|cm|m)\b(?P<way>(?:(?!\b[xy]\b)[^\d()])*)\bz\b[^\d]*$"
)
"""One length of a sentence, and the z axis alone behind it."""
_SENSOR = re.compile(
    r"(?i)\b(?:sen[sz]or\w*|czujnik\w*|transducer\w*|f/?t|aufnehmer\w*|kraftmess\w*|capteur\w*|snímač\w*|"
    r"transduc?tor\w*|trasduttor\w*|givare\w*|opnemer\w*|anturi\w*|érzékelő\w*|algılayıcı\w*|"
    r"rikikaku\w*)|(?:датчик|センサ|传感器|力覚)"
)
_BELOW = re.compile(
    r"(?i)\b(?:below|under|underneath|beneath|distal|unter\w*|sous|sotto|debajo|bajo|abaixo|sob|"
    r"onder|under\w*|nedanför|pod|poniżej|alatt\w*|alla|alapuolella|altında\w*|нижe|под)\b|(?:の下|下方|以下)"
)
_TURNED = re.compile(r"(?i)par+al+[eè]l|aligned|fluchte|równoleg|rovnob|yhdensuunt|párhuzam|平行")
_NOT = re.compile(r"(?i)\b(?:not|nicht|pas|no|non|nie|ne|inte|niet|ikke|rotated|turned)\b")
_FRAME = re.compile(r"(?i)([^\W\d_]+)[\s-]*(?:frame|axes|coordinates|koordinat|system)")
"""Of what a place is in the axes: ``sole frame``."""


@dataclass(frozen=True)
class SaidMount:
    """Of the transducer at a foot, in the foot's frame: place (3,) in m, sentences that say it.

    `weight_n` hangs below it, its centre `com_m` (3,) is in the transducer's axes.
    """

    place_m: FloatArray | None = None
    parallel: bool = False
    weight_n: float = 0.0
    com_m: FloatArray | None = None
    said: tuple[str, str, str] = ("", "", "")

    def lines(self) -> list[str]:
        """Lines of ``[robot.feet.…]``; none for what is not said."""
        made = []
        turned, placed, below = self.said
        if self.parallel:
            made.append(f"transducer_rotation_rpy_rad = [0.0, 0.0, 0.0]    # likely: '{turned}'")
        if self.place_m is not None:
            made.append(f"transducer_position_m = {_written(self.place_m)}    # likely: '{placed}'")
        if self.weight_n:
            made.append(f"weight_below_n = {self.weight_n:.4g}    # likely: '{below}'")
        if self.com_m is not None:
            why = "likely: from the transducer, in its own axes, by the same sentences"
            made.append(f"com_below_m = {_written(self.com_m)}    # {why}")
        return made


def said_mount(above: Sequence[str], foot: str) -> SaidMount:
    """What sentences say of the transducer at a foot, by one alone each.

    >>> said_mount(["Sensor at [0, 0, 0.09] m in the sole frame"], "left").lines()[0][:43]
    'transducer_position_m = [0.0, 0.0, 0.09]   '
    """
    own = [x.strip() for x in above if _side(x) in ("", foot)]
    sensors = [x for x in own if _SENSOR.search(x)]
    turned = [x for x in sensors if _TURNED.search(x) and not _NOT.search(x)]
    masses = {x: m for x in sensors if _BELOW.search(x) and (m := _mass(x))}
    places = {x: p for x in sensors if x not in masses and (p := _point(x)) is not None}
    place = next(iter(places.values())) if len(places) == 1 else None
    mass = next(iter(masses.values())) if len(masses) == 1 else 0.0
    com = _point(next(iter(masses))) if mass else None
    frames = [_FRAME.findall(next(iter(lines), "")) for lines in (masses, places)]
    if com is not None and not any(_SENSOR.search(word) for word in frames[0]):
        alike = bool(turned) and place is not None and bool({*frames[0]} & {*frames[1]})
        com = com - place if alike and place is not None else None
    gravity = gravity_in(above)
    return SaidMount(
        place, bool(turned), mass * (gravity[0] if gravity else GRAVITY_MPS2), com,
        ((*turned, "")[0], next(iter(places), ""), next(iter(masses), "")),
    )  # fmt: skip


def _side(line: str) -> str:
    """The one foot that a line is about; empty for both. Of axes, ``y left`` is no foot."""
    sides = {*sides_said(_AXIS_TO.sub("", line))}
    return sides.pop() if len(sides) == 1 else ""


def _point(line: str) -> FloatArray | None:
    """The one point of a sentence in m, shape (3,); None without, or without a unit.

    ``58.5 mm above the sole on its z axis`` is one, too.
    """
    found = [*_POINT.finditer(line)]
    if not found and (up := _UP.search(line)) and not _BELOW.search(up["way"]):
        height = float(up["height"].replace(",", ".")) * metres_per(known_unit(up["unit"]))
        return np.array([0.0, 0.0, height])
    units = [known_unit(f[by] or "") for f in found for by in ("within", "behind", "ahead")]
    units = [unit for unit in units if unit in LENGTHS]
    if len(found) != 1 or not units:
        return None
    numbers = [float(n.replace(",", ".").replace("−", "-")) for n in found[0].group(2, 3, 4)]
    return np.array(numbers) * metres_per(units[0])


def _mass(line: str) -> float:
    """The one mass of a sentence in kg; 0 for none or several."""
    found = [f for f in IN_WORDS.finditer(line) if f[2] in MASSES]
    return float(found[0][1].replace(",", ".")) * MASSES[found[0][2]] if len(found) == 1 else 0.0


def _written(point: FloatArray) -> str:
    return f"[{', '.join(repr(round(float(v), 5) + 0.0) for v in point)}]"
