"""Standing poses of a robot with hip transducers, and what hanging knows of its legs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from footcal_cli.commands.parts.six_axis_logs import (
    frames_of_tables,
    geometry_of,
    steady_frames,
    without_effects,
)
from footcal_cli.core.pose.data import PoseData, pose_data
from footcal_cli.core.pose.hanging import LegKnowledge, stored_knowledge
from footcal_cli.core.pose.intake import Frames, pose_log
from footcal_cli.core.quality import Finding
from footcal_cli.errors import DataError, UsageError
from footcal_cli.tables.columns import legs_table, poses_table

if TYPE_CHECKING:
    from collections.abc import Sequence

    from footcal_cli.commands.pose_calib import PoseCalibOptions
    from footcal_cli.core.log import Log
    from footcal_cli.session.session import Session
    from footcal_cli.tables.table import Table

_MOST_NAMED = 8


def read_poses(
    session: Session[PoseCalibOptions], options: PoseCalibOptions
) -> tuple[PoseData, tuple[LegKnowledge, ...], dict[str, int]]:
    """Poses without the effects of the calibration, legs, and rejected poses by reason."""
    log, legs, rejected = raw_poses(session, options)
    return pose_data(without_effects(log, session.parameters)), legs, rejected


def raw_poses(
    session: Session[Any], options: PoseCalibOptions
) -> tuple[Log, tuple[LegKnowledge, ...], dict[str, int]]:
    """Poses as they were measured."""
    legs = known_legs(session)
    robot = session.recipe.robot
    assert robot.weight_n is not None  # `known_legs` refused it
    geometry = geometry_of(session.recipe, options.chassis_com_m)
    role = "tripod" if options.fit == "offsets" and session.recipe.data.get("tripod") else None
    tables = session.read(poses_table(), role)
    rejected: dict[str, int] = {}
    if tables:
        frames = frames_of_tables(tables, geometry.legs, "pose")
        session.note(_poses_left_out(tables, frames))
    else:
        streams = session.read(legs_table(), "still")
        if not streams:
            session.read_required(poses_table(), role)
        frames, rejected, told = steady_frames(
            streams,
            geometry.legs,
            (options.steady_rate_nps, options.steady_duration_s, options.steady_window_s),
        )
        session.note(told)
    for reason, count in (
        ("a leg is missing or there twice", frames.incomplete),
        ("reading is not a number", frames.broken),
    ):
        if count:
            rejected[reason] = rejected.get(reason, 0) + count
    if len(frames.keys) == 0:
        why = ", ".join(f"{n} × {reason}" for reason, n in rejected.items())
        raise DataError(f"no usable pose ({why or 'no rows'})", remedy="stand still longer")
    log = pose_log(
        geometry,
        frames,
        robot_weight_n=robot.weight_n,
        leg_weight_n=np.array([leg.weight_n for leg in legs]),
    )
    return log, legs, rejected


def _poses_left_out(tables: Sequence[Table], frames: Frames) -> list[Finding]:
    """Which poses of a table were left out, by their names."""
    if not frames.left_out.size:
        return []
    every = dict.fromkeys(
        (i, name) for i, table in enumerate(tables) for name in table.text("pose").tolist()
    )
    names = [str(name) for _, name in every]
    chosen = [names[int(code)] for code in frames.left_out[:_MOST_NAMED]]
    count = frames.left_out.size
    more = f" and {count - _MOST_NAMED} more" if count > _MOST_NAMED else ""
    return [
        Finding(
            "poses_left_out", "note", tables[0].path.name,
            "a leg is missing, there twice, or not a number; left out: "
            f"{', '.join(chosen)}{more}",
            "record every leg once per pose",
        )
    ]  # fmt: skip


def known_legs(session: Session[Any]) -> tuple[LegKnowledge, ...]:
    """What the hanging calibration knows of every leg of the recipe."""
    robot, command = session.recipe.robot, session.request.command
    if session.parameters is None:
        raise UsageError(
            "standing poses start from a hanging calibration" if command == "diagnose"
            else f"{command} starts from a hanging calibration",
            remedy="give --parameters FILE of footcal hang-calib",
        )  # fmt: skip
    if robot.weight_n is None or not robot.legs:
        raise UsageError(
            f"{command} needs the robot's mass and the nominal mounting of its legs",
            file=session.recipe.path, remedy="add mass_kg and [robot.legs.…] to the recipe",
        )  # fmt: skip
    values = {name: record.value for name, record in session.parameters.parameters.items()}
    try:
        return tuple(
            stored_knowledge(leg, values, session.parameters.covariance_of) for leg in robot.legs
        )
    except KeyError as error:
        raise UsageError(
            f"the calibration has no parameter {error}", file=session.request.parameters,
            remedy="calibrate every leg of the recipe with hang-calib first",
        ) from None  # fmt: skip
