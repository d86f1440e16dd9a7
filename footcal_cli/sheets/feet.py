"""Foot wrenches of a robot with hip transducers as tables and sentences."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.pose.data import PoseData
from footcal_cli.records.results import RmseRow, VerdictRecord
from footcal_cli.report import Sheet, number

_BETTER = 0.8


def _lifted_force(wrench: FloatArray, data: PoseData) -> FloatArray:
    """Force on feet known to be in the air, where it must be zero, shape (m, 3)."""
    return np.asarray(wrench[..., :3][data.contact == 0.0])


def _weight_error(wrench: FloatArray, data: PoseData) -> FloatArray:
    """Sum of vertical forces minus the robot's weight, shape (n,)."""
    return np.asarray(wrench[..., 2].sum(axis=1) - data.robot_weight_n)


def rmse_rows(stages: Mapping[str, FloatArray], data: PoseData) -> tuple[RmseRow, ...]:
    """Robot's weight, sideways sum and lifted feet, before and after."""
    rows = []
    for stage, wrench in stages.items():
        parts = [
            ("vertical force", "N", "robot weight", _weight_error(wrench, data)),
            ("horizontal force", "N", "zero while slow", wrench[..., :2].sum(axis=1)),
        ]
        lifted = _lifted_force(wrench, data)
        if lifted.size:
            parts.append(("force on lifted feet", "N", "zero", lifted))
        rows += [
            RmseRow(
                quantity=quantity, unit=unit, stage=stage, reference=reference, split="all",
                rmse=float(np.sqrt(np.mean(error**2))), n=int(error.size),
            )
            for quantity, unit, reference, error in parts
        ]  # fmt: skip
    return tuple(rows)


def verdict(stages: Mapping[str, FloatArray], data: PoseData, mounted: bool) -> VerdictRecord:
    """One sentence with the lifted feet, else with the robot's weight."""
    details = [
        f"Sum of vertical forces against {number(data.robot_weight_n, 4)} N: off by "
        + " N before, ".join(
            number(float(np.sqrt(np.median(_weight_error(w, data) ** 2))), 2)
            for w in stages.values()
        )
        + " N now (median)."
    ]
    if not mounted:
        details.append(
            "The calibration holds no mounting: nominal rotations and hips were used; run "
            "pose-calib."
        )
    lifted = {
        stage: float(np.sqrt(np.mean(error**2)))
        for stage, wrench in stages.items()
        if (error := _lifted_force(wrench, data)).size
    }
    if lifted:
        good = lifted["after"] < _BETTER * lifted["before"] and mounted
        return VerdictRecord(
            level="good" if good else "warning",
            sentence=f"Feet in the air show {number(lifted['after'], 2)} N per axis "
            f"({number(lifted['before'], 2)} N with a tare); it should be zero.",
            details=tuple(details),
        )
    off = float(np.sqrt(np.mean(_weight_error(stages["after"], data) ** 2)))
    return VerdictRecord(
        level="good" if mounted else "warning",
        sentence=f"The feet carry the robot's weight to {number(off, 2)} N RMS.",
        details=tuple(details),
    )


def foot_sheet(stages: Mapping[str, FloatArray], data: PoseData) -> Sheet:
    """Per foot: what it carries, and what it shows in the air."""
    rows = []
    for k, leg in enumerate(data.geometry.legs):
        up = data.contact[:, k] == 0.0
        after, before = stages["after"][:, k, :3], stages["before"][:, k, :3]
        rows.append(
            (
                leg,
                number(float(after[:, 2].max()), 3),
                number(float(np.median(after[:, 2])), 3),
                number(float(np.sqrt(np.mean((after - before) ** 2))), 2),
                number(float(np.sqrt(np.mean(before[up] ** 2))), 2) if up.any() else "–",
                number(float(np.sqrt(np.mean(after[up] ** 2))), 2) if up.any() else "–",
            )
        )
    return Sheet(
        "Feet",
        ("foot", "largest fz (N)", "median fz (N)", "moved by calibration (N)",
         "in the air before (N)", "in the air now (N)"),
        rows,
        note="In the air: RMS per axis over stamps with contact 0.",
    )  # fmt: skip
