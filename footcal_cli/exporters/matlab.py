"""MATLAB and Octave: a function that returns the calibration, or the same as a ``.mat`` file."""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np

from footcal_cli.errors import UsageError
from footcal_cli.exporters.contract import LINEAR, Exported, ToExport, head, number

_CONVENTIONS = (
    "cells.NAME: force N = scale * counts + bias, positive when pressed.",
    "transducers.NAME: wrench = matrix * (reading - offset), columns [fx fy fz tx ty tz]' in N and",
    "Nm, in the nominal frame.",
)


def export(calibration: ToExport, names: Mapping[str, str]) -> Exported:
    """A function file; `Exported.content` has the variables of a ``.mat`` file.

    Raises
    ------
    UsageError
        A name that MATLAB takes for no field.
    """
    warnings = calibration.beyond(list(names), LINEAR)
    lines = [
        "function calibration = footcal_calibration()",
        *(f"% {line}" for line in head(calibration, names, _CONVENTIONS, warnings)),
    ]
    content: dict[str, dict[str, object]] = {}
    for name, theirs in names.items():
        if not re.fullmatch(r"[A-Za-z]\w{0,62}", theirs):
            raise UsageError(f"'{theirs}' is no name of a field in MATLAB",
                             remedy=f"name it otherwise: --sensor {name}=OTHER")  # fmt: skip
        if name in calibration.cells:
            scale, bias = calibration.values(name, ["scale", "bias"])
            content.setdefault("cells", {})[theirs] = {"scale": scale, "bias": bias}
            here = f"calibration.cells.{theirs}"
            lines += [
                f"{here}.scale = {number(scale)}; % N/count",
                f"{here}.bias = {number(bias)}; % N",
            ]
            continue
        offset, matrix = calibration.offset(name), calibration.matrix(name, LINEAR)
        content.setdefault("transducers", {})[theirs] = {
            "offset": offset[:, np.newaxis], "matrix": matrix
        }  # fmt: skip
        here = f"calibration.transducers.{theirs}"
        rows = ["; ".join(number(x) for x in offset), *(" ".join(map(number, r)) for r in matrix)]
        lines += [
            f"{here}.offset = [{rows[0]}]; % N, N, N, Nm, Nm, Nm",
            f"{here}.matrix = [{'; '.join(rows[1:])}];",
        ]
    notes = {"comment": "\n".join(head(calibration, names, _CONVENTIONS, warnings))}
    return Exported("\n".join([*lines, "end"]) + "\n", warnings, {**notes, **content})
