"""Names of effects and outputs as they stand in figures and sentences."""

from __future__ import annotations

OUTPUTS = {
    "fz": "vertical force",
    "fx": "force along x",
    "fy": "force along y",
    "mx": "moment about x",
    "my": "moment about y",
    "mz": "moment about z",
    "tx": "torque about x",
    "ty": "torque about y",
    "tz": "torque about z",
    "moment_x": "moment along x",
    "moment_y": "moment along y",
    "force": "force",
    "swing": "force of unloaded cells",
}
"""Outputs of the balances, for people."""


_SPELT = {"com": "CoM", "imu": "IMU", "accel": "accelerometer"}


_UNITS = {
    "time": "s", "load": "N", "step": "N", "force": "N", "temperature": "°C", "CoM": "m",
    "hole": "m", "shaft": "rad", "gait": "cycles",
}  # fmt: skip
"""Unit of a recorded signal by the first word of its name."""


def signal_words(name: str) -> str:
    """A recorded signal's name for a sentence, without its unit."""
    return words(name).removesuffix(" (s)")


def signal_label(name: str) -> str:
    """The same with its unit, for an axis."""
    unit = "" if "×" in name else _UNITS.get(name.split(" ")[0], "")
    return f"{signal_words(name)} ({unit})" if unit else signal_words(name)


def words(name: str) -> str:
    """An effect's name for a sentence: ``com_offset`` is *CoM offset*."""
    return " ".join(_SPELT.get(part, part) for part in name.split("_"))


def output_words(name: str) -> str:
    """An output's name for a sentence."""
    owner, _, plain = name.rpartition(".")
    known = OUTPUTS.get(plain, words(plain))
    return f"{known} ({words(owner)})" if owner else known


def capital(sentence: str) -> str:
    """The same with a capital letter in front."""
    return sentence[:1].upper() + sentence[1:]
