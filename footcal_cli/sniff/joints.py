"""Angles of a leg's joints, by what they are called: the one that turns the leg, and the others.

Room: sniff; asked by names.
"""

from __future__ import annotations

from collections.abc import Set as AbstractSet

from footcal_cli.sniff.vocabulary import Quantity

SHAFTS = {"hip", "hips", "hfe", "hpe", "thigh", "coxa", "femur", "huefte", "hüfte", "hüftwinkel",
          "hueftwinkel", "hüftgelenk", "oberschenkel", "cadera", "muslo", "fémur", "hanche",
          "cuisse", "anca", "quadril", "heup", "höft", "бедро", "股関節", "髋", "髖"}  # fmt: skip
"""Joints that turn a whole leg."""
JOINTS = {"haa", "kfe", "knee", "knie", "rodilla", "genou", "ginocchio", "joelho", "abd",
          "abduction", "abduktion", "abducción", "abduccion", "abduzione", "adduction", "tibia",
          "shank", "calf", "kniewinkel", "колено", "膝", "ankle", "tobillo"}  # fmt: skip
"""Other joints of a leg."""
_ANGLE_OF = {"q", "angle", "theta", "phi", "winkel", "angulo", "ángulo", "ângulo", "angolo", "hoek",
             "vinkel", "pos", "position", "posicion", "posición", "posição", "posizione",
             "stellung"}  # fmt: skip
"""What a joint's angle is called without a unit: ``q_hfe``."""
_CHANGES = {"vel", "dot", "velocity", "speed", "acc", "acceleration"}


def joint_angle(words: AbstractSet[str], unit: str | None) -> Quantity | None:
    """The angle of a joint that turns a leg, or of another; None for what is no such angle."""
    if words & _CHANGES or not (unit in ("deg", "rad") or words & _ANGLE_OF):
        return None
    return "phase" if words & SHAFTS else "other" if words & JOINTS else None
