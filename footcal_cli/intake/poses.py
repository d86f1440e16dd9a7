"""Standing poses of a robot with hip transducers, and what hanging knows of its legs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.pose.data import PoseData, pose_data
from footcal_cli.core.pose.hanging import LegKnowledge, stored_knowledge
from footcal_cli.core.pose.intake import Frames, pose_log
from footcal_cli.core.quality import Finding
from footcal_cli.core.spatial import rotation_of_rpy
from footcal_cli.errors import DataError, UsageError
from footcal_cli.intake.legs import frames_of_tables, geometry_of, steady_frames, without_effects
from footcal_cli.tables.columns import AXIS_COLUMNS, legs_table, poses_table, six_axis_feet_table

if TYPE_CHECKING:
    from collections.abc import Sequence

    from footcal_cli.core.log import Log
    from footcal_cli.recipe import Robot as RecipeRobot
    from footcal_cli.recipe.options import ApplyOptions, PoseCalibOptions
    from footcal_cli.session.session import Session
    from footcal_cli.tables.table import Table

_MOST_NAMED = 8
_WEIGHT_SHARE = 5e-4
"""Sd of a robot's weight as a share of it where nobody says it: a scale for heavier robots."""
_FORCE_SD_N, _FORCE_SHARE = 0.05, 5e-4
"""Noise of a pose's force where nobody says it and too few poses show it: of a small robot, and by
the weight of one whose transducers have a larger range."""


def read_poses(
    session: Session[PoseCalibOptions], options: PoseCalibOptions
) -> tuple[PoseData, tuple[LegKnowledge, ...], dict[str, int]]:
    """Poses without the effects of the calibration, legs, and rejected poses by reason."""
    log, legs, rejected = raw_poses(session, options)
    return pose_data(without_effects(log, session.parameters)), legs, rejected


def read_steps(
    session: Session[ApplyOptions],
) -> tuple[PoseData, tuple[LegKnowledge, ...], tuple[str, NDArray[Any]], dict[str, int]]:
    """Every stamp (else every pose) without the effects of the calibration.

    Returns
    -------
    data, legs
        Readings and what hanging knows.
    along
        ``time_s`` or ``pose``, and its values (n,).
    rejected
        Stamps by reason.
    """
    robot = session.recipe.robot
    legs = known_legs(session)
    assert robot.weight_n is not None, "known_legs refused it"
    assert session.parameters is not None, "known_legs refused it"
    values = session.parameters.values
    com = [
        values.get(f"robot.chassis_com_{axis}", said)
        for axis, said in zip("xyz", session.options.chassis_com_m, strict=True)
    ]
    geometry = geometry_of(session.recipe, com)
    tables = session.read(legs_table())
    poses = [] if tables else session.read(poses_table())
    tables = tables or poses or session.read_required(legs_table())
    frames = frames_of_tables(tables, geometry.legs, "pose" if poses else "time_s")
    if len(frames.keys) == 0:
        raise DataError("no stamp at which every leg was read", file=tables[0].path)
    if poses:
        along: tuple[str, NDArray[Any]] = ("pose", np.array(_names(poses))[frames.keys])
    else:
        along = ("time_s", frames.columns["time_s"][:, 0])
    log = pose_log(
        geometry, frames, robot_weight_n=robot.weight_n,
        leg_weight_n=np.array([leg.weight_n for leg in legs]),
        time_s=None if poses else along[1],
    )  # fmt: skip
    data = pose_data(without_effects(log, session.parameters))
    return data, legs, along, frames.rejected


def noise_sd_of(
    options: PoseCalibOptions, legs: int, robot_weight_n: float
) -> tuple[FloatArray, bool]:
    """Noise per leg and channel (K, 6), and whether its level is known."""
    force = options.force_sd_n or max(_FORCE_SD_N, _FORCE_SHARE * robot_weight_n)
    torque = options.torque_sd_nm or 0.1 * force
    known = options.force_sd_n is not None and options.torque_sd_nm is not None
    return np.tile([force] * 3 + [torque] * 3, (legs, 1)), known


def weight_sd_of(options: PoseCalibOptions, robot: RecipeRobot) -> float:
    """How well the robot was weighed, N."""
    if "robot_weight_sd_n" in options.model_fields_set:
        return options.robot_weight_sd_n
    if robot.mass_sd_kg is not None:
        return robot.mass_sd_kg * robot.gravity_mps2
    return max(options.robot_weight_sd_n, _WEIGHT_SHARE * (robot.weight_n or 0.0))


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
        frames, rejected, notes = steady_frames(
            streams,
            geometry.legs,
            (options.steady_rate_nps, options.steady_duration_s, options.steady_window_s),
        )
        session.note(notes)
    rejected |= frames.rejected
    if len(frames.keys) == 0:
        why = ", ".join(f"{n} × {reason}" for reason, n in rejected.items())
        raise DataError(
            f"no usable pose ({why or 'no rows'})",
            remedy="record every leg in each pose; of a stream, stand still longer",
        )
    log = pose_log(
        geometry,
        frames,
        robot_weight_n=robot.weight_n,
        leg_weight_n=np.array([leg.weight_n for leg in legs]),
    )
    return log, legs, rejected


def read_pairs(session: Session[PoseCalibOptions]) -> tuple[dict[str, FloatArray], int, int, int]:
    """Wrenches of transducers in series.

    Returns
    -------
    wrench
        Of each transducer, complete rows (n, 6).
    quiet, block
        Rows of quiet standing at the beginning, and rows of a mean.
    lost
        Rows that are not complete.
    """
    options = session.options
    if not options.series:
        raise session.lacks("no pairs named", "add series = [['hip', 'ankle']] to [pose_calib]")
    names = tuple(dict.fromkeys(name for pair in options.series for name in pair))
    table = session.read_required(six_axis_feet_table(names))[0]
    time_s = table.number("time_s")
    wrench = {name: table.numbers([f"{name}_{c}" for c in AXIS_COLUMNS]) for name in names}
    sound = np.logical_and.reduce([np.isfinite(w).all(axis=1) for w in wrench.values()])
    step_s = float(np.median(np.diff(time_s)))
    block = max(round(options.block_s / step_s), 1)
    quiet = int(np.sum(time_s[sound] < time_s[0] + options.quiet_s))
    if sound.sum() < 4 * block or quiet < 2 * block:
        raise DataError("too few samples", file=table.path, remedy="record longer")
    return {name: w[sound] for name, w in wrench.items()}, quiet, block, int((~sound).sum())


def _poses_left_out(tables: Sequence[Table], frames: Frames) -> list[Finding]:
    """Which poses of a table were left out, by their names."""
    if not frames.left_out.size:
        return []
    names = _names(tables)
    chosen = [names[int(code)] for code in frames.left_out[:_MOST_NAMED]]
    count = frames.left_out.size
    more = f" and {count - _MOST_NAMED} more" if count > _MOST_NAMED else ""
    return [
        Finding(
            "poses_left_out", "note", tables[0].path.name,
            "a leg is missing, there more often than another, or not a number; left out: "
            f"{', '.join(chosen)}{more}",
            "record every leg equally often in each pose",
        )
    ]  # fmt: skip


def _names(tables: Sequence[Table]) -> list[str]:
    """Names of the poses in the order in which the logs first have them."""
    keys = ((i, name) for i, table in enumerate(tables) for name in table.text("pose").tolist())
    return [str(name) for _, name in dict.fromkeys(keys)]


def known_legs(session: Session[Any]) -> tuple[LegKnowledge, ...]:
    """What the hanging calibration found for every leg of the recipe."""
    robot, command = session.recipe.robot, session.request.command
    if session.parameters is None:
        raise session.lacks(
            "standing poses start from a hanging calibration" if command == "diagnose"
            else f"{command} starts from a hanging calibration",
            "give --parameters FILE of footcal hang-calib",
        )  # fmt: skip
    if robot.weight_n is None or not robot.legs:
        raise session.lacks(
            f"{command} needs the robot's mass and the nominal mounting of its legs",
            "add mass_kg and [robot.legs.…] to the recipe",
        )
    values, covariance_of = session.parameters.values, session.parameters.covariance_of
    hung = session.recipe.options.get("hang_calib", {})
    by_body = hung.get("orientation_of") == "body"
    try:
        return tuple(
            stored_knowledge(
                leg, values, covariance_of,
                rotation_of_rpy(spec.rotation_rpy_rad) if by_body else None,
            )
            for leg, spec in robot.legs.items()
        )  # fmt: skip
    except KeyError as error:
        raise UsageError(
            f"the calibration has no parameter {error}", file=session.request.parameters,
            remedy="calibrate every leg of the recipe with hang-calib first",
        ) from None  # fmt: skip
