"""The hexapod's sample logs run through the commands once, shared by the tests."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from footcal_cli.core.parameters import FloatArray
from footcal_cli.records.files import read_record
from footcal_cli.records.results import ParametersRecord

LEGS = ("fl", "ml", "hl", "fr", "mr", "hr")
AXES = ("fx", "fy", "fz", "tx", "ty", "tz")


def truth_of(repository: Path) -> dict[str, Any]:
    """What was true of the sample hexapod."""
    text = (repository / "sample_data/hexapod/truth.json").read_text(encoding="utf-8")
    loaded: dict[str, Any] = json.loads(text)
    return loaded


def calibration(folder: Path) -> ParametersRecord:
    """The parameters a run left."""
    return read_record(ParametersRecord, folder / "parameters.json")


def true_mounting(leg: dict[str, Any]) -> tuple[FloatArray, FloatArray]:
    """True rotation transducer to body, and hip, of one leg."""
    turn = Rotation.from_rotvec(leg["mount_rotvec_b_rad"]).as_matrix()
    rot = turn @ np.array(leg["nominal_rot_bt"])
    return rot, np.add(leg["nominal_pos_b_m"], leg["mount_offset_b_m"])


def stored_mounting(
    record: ParametersRecord, leg: dict[str, Any], name: str
) -> tuple[FloatArray, FloatArray]:
    """Calibrated rotation transducer to body, and chassis CoM to hip, of one leg."""
    nominal = np.array(leg["nominal_rot_bt"])
    turn = [record.value(f"{name}.mount_rot_{a}") for a in "xyz"]
    shift = [record.value(f"{name}.mount_pos_{a}") for a in "xyz"]
    rot = nominal @ Rotation.from_rotvec(turn).as_matrix()
    return rot, np.array(leg["nominal_pos_b_m"]) + nominal @ np.array(shift)
