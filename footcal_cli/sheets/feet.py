"""`apply` on hip transducers: foot wrenches as report and tables."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.pose.data import PoseData
from footcal_cli.core.pose.wrenches import FootCalibration
from footcal_cli.core.signals import root_mean_square
from footcal_cli.plots.feet import plot_feet, plot_groups, stepping_together
from footcal_cli.records.results import RmseRecord, RmseRow, VerdictRecord
from footcal_cli.report import Picture, Sheet, number
from footcal_cli.report.outcome import Outcome

_BETTER = 0.8
_COLUMNS = ("fx_w_n", "fy_w_n", "fz_w_n", "tx_w_nm", "ty_w_nm", "tz_w_nm")


def outcome_of(
    robot: str,
    data: PoseData,
    along: tuple[str, NDArray[Any]],
    stages: Mapping[str, FloatArray],
    calibration: FootCalibration,
    *,
    rejected: Mapping[str, int],
    mounted: bool,
) -> Outcome:
    """Wrenches of the ground on the feet, with a tare and calibrated.

    Parameters
    ----------
    along
        ``pose`` or ``time_s``, and its values (n,).
    stages
        ``before`` and ``after``: wrenches (n, K, 6).
    calibration
        What ``after`` was made with.
    rejected
        Stamps by reason.
    mounted
        Whether the calibration holds a mounting.
    """
    before, after, legs = stages["before"], stages["after"], data.geometry.legs
    key, values = along
    poses = key == "pose"
    found = verdict(stages, data, mounted)
    x = np.arange(len(values), dtype=float) if poses else values
    pictures = [
        Picture(
            "foot_wrenches",
            lambda: plot_feet(x, before, after, legs, "pose" if poses else "time (s)"),
            "Wrench of the ground on each foot in the floating-base frame: grey with a tare in "
            "the air and the nominal mounting, blue calibrated. A lifted foot must show zero.",
            title="Wrench of the ground on each foot",
            result=found.sentence,
        )
    ]
    groups = stepping_together(data.phase_rad)
    if not poses and 1 < len(groups) < len(legs):
        pictures.append(
            Picture(
                "foot_wrenches_by_phase",
                lambda: plot_groups(data.phase_rad, before, after, legs, groups),
                "The same over the shaft angle, legs that step together in one column (compare "
                "Wu & Revzen, Figs. 8 and 9).",
                title="Wrench of the ground on each foot over the shaft angle",
                result=found.sentence,
            )
        )
    origin = ", ".join(f"{1e3 * x:.1f}" for x in calibration.origin_b_m)
    return Outcome(
        title=f"Foot wrenches of {robot}",
        verdict=found,
        pictures=tuple(pictures),
        sheets=(foot_sheet(stages, data),),
        footer=(
            "Floating base: origin fixed in the body at the robot's CoM with all shafts at 0 "
            f"({origin} mm in the body frame), z up, x along the heading (Wu & Revzen, eq. "
            "(3)).",
        ),
        rmse=RmseRecord(rows=rmse_rows(stages, data), rejected=dict(rejected)),
        tables={
            "calibrated.parquet": wrench_columns(data, key, values, after)
            | {f"tared_{n}": before[..., i].ravel() for i, n in enumerate(_COLUMNS)}
        },
    )


def wrench_columns(
    data: PoseData, key: str, along: NDArray[Any], wrench: FloatArray
) -> dict[str, object]:
    """The ground's wrench on every foot (n, K, 6), floating-base frame, in long form."""
    stamps, count = wrench.shape[:2]
    return {
        key: np.repeat(along, count),
        "leg": np.tile(data.geometry.legs, stamps),
        "phase_rad": data.phase_rad.ravel(),
        **{name: wrench[..., i].ravel() for i, name in enumerate(_COLUMNS)},
    }


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
            RmseRow.of(quantity, unit, stage, reference, error)
            for quantity, unit, reference, error in parts
        ]
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
    actions: tuple[str, ...] = ()
    if not mounted:
        actions = (
            "Run pose-calib: the calibration holds no mounting, so nominal rotations and hip "
            "positions were used.",
        )
    lifted = {
        stage: root_mean_square(error)
        for stage, wrench in stages.items()
        if (error := _lifted_force(wrench, data)).size
    }
    if lifted:
        good = lifted["after"] < _BETTER * lifted["before"] and mounted
        return VerdictRecord(
            level="good" if good else "warning",
            sentence=f"Feet in the air show {number(lifted['after'], 2)} N per axis "
            f"({number(lifted['before'], 2)} N with a tare); it should be zero.",
            actions=actions,
            details=tuple(details),
        )
    off = root_mean_square(_weight_error(stages["after"], data))
    return VerdictRecord(
        level="good" if mounted else "warning",
        sentence=f"The feet carry the robot's weight to {number(off, 2)} N RMS.",
        actions=actions,
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
                number(root_mean_square(after - before), 2),
                number(root_mean_square(before[up]), 2),
                number(root_mean_square(after[up]), 2),
            )
        )
    return Sheet(
        "Feet",
        ("foot", "largest fz (N)", "median fz (N)", "moved by calibration (N)",
         "in the air before (N)", "in the air now (N)"),
        rows,
        note="In the air: RMS per axis over stamps with contact 0.",
    )  # fmt: skip
