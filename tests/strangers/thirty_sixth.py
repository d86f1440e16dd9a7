"""Six axes of new labs: units in notes, poses by number, plugs, files of legs, words for forces."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tests.strangers.rigs import G, Made, Rng, rows, tool_truth, wrist, write


def kilograms_in_notes(to: Path, rng: Rng) -> Made:
    """Means of a wrist in kgf and kgf cm, which the notes say and the header does not."""
    made, wrench, rot = wrist(rng, 24, 1)
    read = wrench / ([G] * 3 + [G / 100] * 3)
    names = "no,qw,qx,qy,qz,FX,FY,FZ,MX,MY,MZ"
    body = rows(np.arange(1, 25), *np.roll(rot.as_quat(), 1, axis=1).T, *read.T, form="%.5f")
    notes = write(to / "notes.md", ["# kensa", "", "- `FX FY FZ` [kgf], `MX MY MZ` [kgf.cm]."])
    return Made([write(to / "kensa.csv", [names, *body]), notes], tool_truth(made))


THIRTY_SIXTH = (kilograms_in_notes,)
