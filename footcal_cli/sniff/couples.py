"""Torques that are called couples: ``LeftFootForceSensor_cx`` next to ``…_fx``.

Room: sniff; asked by numbered.
"""

from __future__ import annotations

import re
from dataclasses import replace

from footcal_cli.sniff.guesses import ColumnGuess, FileGuess

_COMPONENT = re.compile(r"(?P<stem>.*[\W_])(?P<letter>[cfCF])(?P<axis>[xyzXYZ])")


def couples(file: FileGuess) -> dict[str, ColumnGuess]:
    """Columns of couples as torques, by name: three next to the three forces of their stem."""
    stems: dict[str, dict[str, ColumnGuess]] = {}
    for column in file.columns:
        found = _COMPONENT.fullmatch(column.column)
        if found and column.values is not None:
            own = stems.setdefault(found["stem"], {})
            own[(found["letter"] + found["axis"]).lower()] = column
    made = {}
    for own in stems.values():
        if set(own) != {"fx", "fy", "fz", "cx", "cy", "cz"}:
            continue
        for axis in "xyz":
            name = replace(own[f"f{axis}"].name, axis=f"t{axis}", unit=own[f"c{axis}"].unit)
            why = "a couple next to its force"
            column = replace(own[f"c{axis}"], name=name, sure="likely", why=why)
            made[column.column] = column
    return made
