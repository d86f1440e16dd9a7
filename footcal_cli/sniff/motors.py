"""What feeds a motor is no reading: volts, amperes, watts and the torque of a thrust stand.

Room: sniff; asked once for each table by columns.
"""

from __future__ import annotations

from dataclasses import replace

from footcal_cli.sniff.guesses import ColumnGuess
from footcal_cli.sniff.names import words_of

_VOLTS = {"voltage", "volts", "volt", "spannung", "vbat"}
_AMPERES = {"current", "amps", "amp", "ampere", "amperes", "strom"}
_FED = {
    "power", "watt", "watts", "rpm", "throttle", "esc", "pwm", "motor", "thrust", "propeller",
    "duty", "torque",
}  # fmt: skip


def without_supply(columns: list[ColumnGuess]) -> list[ColumnGuess]:
    """A table's columns, those of what feeds a motor as no reading, load or time.

    A cell may be read in volts or in mA. A table that has both, and a speed, a power, a thrust or a
    throttle beside them, has the supply of a motor in them; its torque goes with its thrust.
    """
    words = {c.column: set(words_of(c.column)) for c in columns}
    said = set().union(*words.values())
    if not (_VOLTS & said and _AMPERES & said and _FED & said):
        return columns
    supply = _VOLTS | _AMPERES | _FED - {"thrust", "motor", "propeller"}
    return [
        replace(c.as_quantity("other", "likely", "what feeds a motor"), values=None)
        if words[c.column] & supply and c.quantity in ("unknown", "reading", "time", "sequence")
        else c
        for c in columns
    ]
