"""Offsets found again from standing poses: report, tables, error rows and sentences."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal

import numpy as np

from footcal_cli.core.effects.calibration import AXES, OFFSET
from footcal_cli.core.effects.six_axis import OFFSET_CHANGE
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.pose.data import PoseData
from footcal_cli.core.pose.hanging import LegKnowledge
from footcal_cli.core.pose.mounted import Mounted
from footcal_cli.core.pose.standing import OffsetFit
from footcal_cli.core.spatial import wrench_transform
from footcal_cli.plots import pose as plots
from footcal_cli.records.results import RmseRecord, RmseRow, VerdictRecord
from footcal_cli.report import Picture, Sheet, number, with_sd
from footcal_cli.report.outcome import Outcome
from footcal_cli.sheets.pose.mounting import pose_wrenches
from footcal_cli.sheets.pose.mounting_tables import row


def outcome_of(
    robot: str,
    data: PoseData,
    legs: Sequence[LegKnowledge],
    mounted: Mounted,
    found: OffsetFit,
    rejected: Mapping[str, int],
) -> Outcome:
    """All offsets again, with mounting, weights and CoM as they were; a refusal is not usable."""
    names = data.geometry.legs
    old = np.stack([leg.offset for leg in legs])
    rows = offset_rmse(data, mounted, legs, old, "before")
    pictures: tuple[Picture, ...] = ()
    tables: dict[str, Mapping[str, object]] = {}
    if found.accepted:
        rows += offset_rmse(data, mounted, legs, found.offset, "after")
        tables["wrenches.parquet"] = pose_wrenches(data, mounted.feet(data, found.offset, legs))
        pictures = (
            Picture(
                OFFSET_CHANGE.name,
                lambda: plots.plot_offset_change(found, names),
                "How far each offset moved since the last calibration, with 95 % intervals.",
                title="Change of each offset since the last calibration",
                result=offset_sentence(found, names),
            ),
        )
    return Outcome(
        title=f"Offsets again, from standing: {robot}",
        verdict=VerdictRecord(
            level=offset_level(found), sentence=offset_sentence(found, names), details=found.words
        ),
        pictures=pictures,
        sheets=(offset_sheet(found, names),),
        findings=(),
        footer=(
            "Chassis balance of every pose plus, for every lifted leg, reading = offset + its "
            "own weight; mounting, weights and CoM kept (Wu & Revzen, section V).",
        ),
        rmse=RmseRecord(rows=rows, rejected=dict(rejected)),
        tables=tables,
        usable=found.accepted,
    )


def offset_sentence(found: OffsetFit, legs: Sequence[str]) -> str:
    """One sentence for the verdict of an offset run."""
    if not found.accepted:
        return (
            f"Offsets cannot be had from these poses: only {found.rank} of {found.unknowns} "
            "directions are seen."
        )
    leg, axis = divmod(int(np.argmax(np.abs(found.change[:, :3]))), 3)
    worst_sd = float(found.offset_sd[:, :3].max())
    return (
        f"All offsets found again from {found.poses} poses, ± {number(worst_sd, 2)} N or better; "
        f"the largest change is {number(float(found.change[leg, axis]), 3)} N "
        f"({legs[leg]} {AXES[axis]})."
    )


def offset_level(found: OffsetFit) -> Literal["good", "warning", "bad"]:
    """Refused, too few poses for the asked precision, or good."""
    if not found.accepted:
        return "bad"
    return "good" if len(found.words) == 1 else "warning"


def offset_sheet(found: OffsetFit, legs: Sequence[str]) -> Sheet:
    """New offsets and their change."""
    rows = []
    for k, leg in enumerate(legs):
        rows.append(
            (leg, OFFSET.name, *(_maybe(found.offset, found.offset_sd, k, i) for i in range(6)))
        )
        rows.append(
            (leg, "change", *(_maybe(found.change, found.change_sd, k, i) for i in range(6)))
        )
    return Sheet(
        "Offsets from standing",
        ("leg", "", "fx (N)", "fy (N)", "fz (N)", "tx (Nm)", "ty (Nm)", "tz (Nm)"),
        rows,
        note="± one standard deviation; lifted in "
        + ", ".join(f"{leg} {int(n)}" for leg, n in zip(legs, found.lifted, strict=True))
        + f" of {found.poses} poses.",
    )


def _maybe(values: FloatArray, sd: FloatArray, leg: int, axis: int) -> str:
    """A force in N or a torque in Nm with its sd; a dash where it is not seen."""
    if np.isnan(values[leg, axis]):
        return "–"
    return with_sd(float(values[leg, axis]), float(sd[leg, axis]))


def offset_rmse(
    data: PoseData, mounted: Mounted, legs: Sequence[LegKnowledge], offset: FloatArray, stage: str
) -> tuple[RmseRow, ...]:
    """Balance errors with given offsets."""
    applied = data.wrench_t - offset
    total = np.einsum("kij,pkj->pi", wrench_transform(mounted.rot_bt, mounted.arm_b_m), applied)
    chassis_n = data.robot_weight_n - sum(leg.weight_n for leg in legs)
    total[:, :3] += chassis_n * data.gravity_b
    return (
        row("sum of forces", "N", stage, total[:, :3]),
        row("sum of moments", "Nm", stage, total[:, 3:]),
    )
