"""`apply` for a robot with hip transducers: ground wrenches per foot."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from footcal_cli.commands.parts.pose_outcome import WRENCH_COLUMNS, calibration_of, mounting_of
from footcal_cli.commands.parts.six_axis_logs import frames_of_tables, geometry_of, without_effects
from footcal_cli.core.plausibility import check_total_force
from footcal_cli.core.pose.data import pose_data
from footcal_cli.core.pose.hanging import stored_knowledge
from footcal_cli.core.pose.intake import pose_log
from footcal_cli.core.pose.wrenches import foot_wrenches, naive_wrenches, tare_in_the_air
from footcal_cli.errors import DataError, UsageError
from footcal_cli.plots.feet import plot_feet, plot_groups, stepping_together
from footcal_cli.records.results import RmseRecord
from footcal_cli.report import Picture, Report
from footcal_cli.session.session import Outcome
from footcal_cli.sheets import feet as sheets
from footcal_cli.tables.columns import legs_table, poses_table

if TYPE_CHECKING:
    from footcal_cli.commands.apply import ApplyOptions
    from footcal_cli.session.session import Session
    from footcal_cli.tables.table import Table


def _pose_names(tables: Sequence[Table]) -> NDArray[np.str_]:
    """Names of the poses in the order in which the logs first have them."""
    keys = [(i, name) for i, table in enumerate(tables) for name in table.text("pose").tolist()]
    return np.array([name for _, name in dict.fromkeys(keys)], dtype=np.str_)


def apply_legs(session: Session[ApplyOptions]) -> Outcome:
    """Readings of hip transducers to wrenches of the ground on the feet, before and after."""
    record, robot = session.parameters, session.recipe.robot
    assert record is not None, "checked by the caller"
    if robot.weight_n is None:
        raise UsageError("the robot's mass is needed", file=session.recipe.path,
                         remedy="add mass_kg to [robot]")  # fmt: skip
    values = {name: parameter.value for name, parameter in record.parameters.items()}
    try:
        legs = tuple(stored_knowledge(leg, values, record.covariance_of) for leg in robot.legs)
    except KeyError as error:
        raise UsageError(
            f"the calibration has no parameter {error}", file=session.request.parameters,
            remedy="calibrate every leg of the recipe with hang-calib first",
        ) from None  # fmt: skip
    com_names = [f"robot.chassis_com_{axis}" for axis in "xyz"]
    com = [values.get(n, v) for n, v in zip(com_names, session.options.chassis_com_m, strict=True)]
    geometry = geometry_of(session.recipe, com)
    with session.step("read"):
        tables = session.read(legs_table())
        poses = [] if tables else session.read(poses_table())
        tables = tables or poses or session.read_required(legs_table())
        frames = frames_of_tables(tables, geometry.legs, "pose" if poses else "time_s")
    if len(frames.keys) == 0:
        raise DataError("no stamp at which every leg was read", file=tables[0].path)
    with session.step("apply"):
        weight = np.array([leg.weight_n for leg in legs])
        key, along = ("pose", _pose_names(poses)[frames.keys]) if poses else (
            "time_s", frames.columns["time_s"][:, 0],
        )  # fmt: skip
        time_s = np.arange(len(along), dtype=float) if poses else along
        log = pose_log(
            geometry, frames, robot_weight_n=robot.weight_n, leg_weight_n=weight,
            time_s=None if poses else time_s,
        )  # fmt: skip
        data = pose_data(without_effects(log, record))
        offset = np.stack([leg.offset for leg in legs])
        calibration = calibration_of(data, mounting_of(record, geometry), offset, legs)
        after = foot_wrenches(data, calibration)
        coms = tuple(leg.com_m for leg in legs)
        tare = tare_in_the_air(geometry.rot_bt, offset, weight, coms)
        before = naive_wrenches(data, tare, calibration.origin_b_m)
    session.note(check_total_force(after[..., 2].sum(axis=1), robot.weight_n, "all legs"))
    picture = Picture(
        "foot_wrenches",
        lambda: plot_feet(time_s, before, after, geometry.legs, "pose" if poses else "time (s)"),
        "Wrench of the ground on each foot in the floating-base frame: grey with a tare in "
        "the air and the nominal mounting, blue calibrated. A lifted foot must show zero.",
        title="Wrench of the ground on each foot",
    )
    pictures = [picture]
    groups = stepping_together(data.phase_rad)
    if not poses and 1 < len(groups) < len(geometry.legs):
        pictures.append(
            Picture(
                "foot_wrenches_by_phase",
                lambda: plot_groups(data.phase_rad, before, after, geometry.legs, groups),
                "The same over the shaft angle, legs that step together in one column (compare "
                "Wu & Revzen, Figs. 8 and 9).",
                title="Wrench of the ground on each foot over the shaft angle",
            )
        )
    rejected = {
        reason: count
        for reason, count in (
            ("a leg is missing or there twice", frames.incomplete),
            ("reading is not a number", frames.broken),
        )
        if count
    }
    stages = {"before": before, "after": after}
    mounted = f"{geometry.legs[0]}.mount_rot_x" in values

    def write(path: Path) -> None:
        import pandas as pd

        from footcal_cli.tables.table import write_parquet

        stamps, count = after.shape[:2]
        table = pd.DataFrame(
            {
                key: np.repeat(along, count),
                "leg": np.tile(geometry.legs, stamps),
                "phase_rad": data.phase_rad.ravel(),
            }
        )
        for i, name in enumerate(WRENCH_COLUMNS):
            table[name] = after[..., i].ravel()
        for i, name in enumerate(WRENCH_COLUMNS):
            table[f"tared_{name}"] = before[..., i].ravel()
        write_parquet(table, path)

    return Outcome(
        report=Report(
            title=f"Foot wrenches of {robot.name}",
            verdict=sheets.verdict(stages, data, mounted),
            pictures=tuple(pictures),
            sheets=(sheets.foot_sheet(stages, data),),
            footer=(
                "Floating base: origin fixed in the body at the robot's CoM with all shafts at 0 "
                f"({', '.join(f'{1e3 * x:.1f}' for x in calibration.origin_b_m)} mm in the body "
                "frame), z up, x along the heading (Wu & Revzen, eq. (3)).",
            ),
        ),
        rmse=RmseRecord(rows=sheets.rmse_rows(stages, data), rejected=rejected),
        files={"calibrated.parquet": write},
    )
