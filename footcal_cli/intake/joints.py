"""Logs of joint positions: which columns they need, and the body stream made of them."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core.kinematics import quaternion_of_rpy, unit_quaternion
from footcal_cli.core.parameters import FloatArray
from footcal_cli.errors import DataError, UsageError, nearest
from footcal_cli.intake.rigid_body import RigidBody
from footcal_cli.tables.columns import Column, TableType, base_columns
from footcal_cli.tables.reading import ForeignColumn
from footcal_cli.tables.sources import source_names
from footcal_cli.tables.table import Table, read_table

if TYPE_CHECKING:
    from footcal_cli.recipe.options import KinematicsOptions
    from footcal_cli.session.session import Session

_POSITION = tuple(f"base_{axis}_m" for axis in "xyz")
_QUATERNION = tuple(f"base_q{axis}" for axis in "xyzw")
_RPY = tuple(f"base_{angle}_rad" for angle in ("roll", "pitch", "yaw"))


def joints_table(body: RigidBody, feet: tuple[str, ...]) -> TableType:
    """Joint positions and the base's pose, one row per stamp.

    Parameters
    ----------
    body
        Whose joints.
    feet
        Feet whose vertical force may be logged beside.
    """
    return TableType(
        "joints",
        (
            Column("time_s", "time stamp"),
            *(
                Column(f"{name}_{unit}", f"position of joint {name}", optional=True, missing="keep")
                for name, unit in body.units.items()
            ),
            *base_columns(),
            *(
                Column(f"{foot}_fz_n", f"vertical force on foot {foot}", optional=True,
                       missing="keep")
                for foot in feet
            ),
        ),
    )  # fmt: skip


def read_joints(
    session: Session[KinematicsOptions], body: RigidBody, feet: tuple[str, ...]
) -> Table:
    """Read the one log of joint positions.

    Raises
    ------
    UsageError
        No log or several, or a joint that the URDF does not have.
    DataError
        A column that the recipe names is missing.
    """
    options, robot = session.options, session.recipe.robot
    paths = session.paths("joints")
    if len(paths) != 1:
        raise UsageError(
            "no joint log given" if not paths else f"{len(paths)} logs given, one is taken",
            remedy="name one LOG on the command line or joints in [data]",
        )
    for table, names in (("joints", options.joints), ("fixed", options.fixed)):
        for name in names:
            if name not in body.units:
                raise UsageError(
                    f"[kinematics.{table}]: the URDF has no moving joint '{name}'"
                    f"{nearest(name, list(body.units))}",
                    file=session.recipe.path,
                    remedy=f"its joints are {', '.join(body.units)}",
                )
    path = paths[0]
    if not path.is_file():
        raise UsageError("no such file", file=path, remedy="check the path")
    reading = session.recipe.reading(path)
    header = source_names(path, reading)
    columns = dict(reading.columns)
    for name, unit in body.units.items():
        usual = options.joint_unit if unit == "rad" else unit
        if name in options.joints:
            place = options.joints[name]
            if place.column not in header:
                raise DataError(
                    f"missing column '{place.column}' that [kinematics.joints] names for {name}"
                    f"{nearest(place.column, header)}",
                    file=path, remedy="correct the name",
                )  # fmt: skip
            columns[f"{name}_{unit}"] = ForeignColumn(place.column, place.unit or usual)
        elif name in header:
            columns[f"{name}_{unit}"] = ForeignColumn(name, usual)
    log = read_table(
        path, joints_table(body, feet), replace(reading, columns=columns),
        gravity_mps2=robot.gravity_mps2,
    )  # fmt: skip
    session.inputs[path.name] = log.digest
    session.rows[path.name] = len(log)
    return log


def joints_of(log: Table, body: RigidBody, options: KinematicsOptions) -> dict[str, FloatArray]:
    """Positions of all joints, shape (n,) each: logged, fixed, or following another."""
    positions = {
        name: log.number(f"{name}_{unit}")
        for name, unit in body.units.items()
        if f"{name}_{unit}" in log
    }
    for name, value in options.fixed.items():
        if name in positions:
            raise UsageError(
                f"joint '{name}' stands in [kinematics.fixed] and in the log", file=log.path,
                remedy="take it out of [kinematics.fixed]",
            )  # fmt: skip
        positions[name] = np.full(len(log), value)
    return body.followed(positions)


def base_of(log: Table) -> tuple[FloatArray | None, FloatArray]:
    """Position (n, 3) of the base, None where not logged, and its quaternion x y z w (n, 4).

    Raises
    ------
    DataError
        The log has no orientation, or part of a pose.
    """
    for names in (_POSITION, _QUATERNION, _RPY):
        has = [name for name in names if name in log]
        if has and len(has) < len(names):
            lacking = ", ".join(name for name in names if name not in log)
            raise DataError(
                f"the base has {', '.join(has)} but not {lacking}", file=log.path,
                remedy="log all of them, or none",
            )  # fmt: skip
    if _QUATERNION[0] in log:
        turned = unit_quaternion(log.numbers(_QUATERNION))
    elif _RPY[0] in log:
        turned = quaternion_of_rpy(log.numbers(_RPY))
    else:
        raise DataError(
            "no orientation of the base", file=log.path,
            remedy="log base_qx base_qy base_qz base_qw or base_roll_rad base_pitch_rad "
            "base_yaw_rad, or map their columns in [columns]",
        )  # fmt: skip
    return (log.numbers(_POSITION) if _POSITION[0] in log else None), turned


def feet_frames(session: Session[KinematicsOptions], body: RigidBody) -> dict[str, str]:
    """Foot -> link of the URDF, from ``[kinematics.feet]`` or by its usual names.

    Raises
    ------
    UsageError
        No feet, or a link that the URDF does not have.
    """
    options = session.options
    names = tuple(session.recipe.robot.feet) or tuple(options.feet)
    if not names:
        raise session.lacks(
            "no feet are named", 'name their links: [kinematics.feet] left = "l_sole"'
        )
    for name in (*options.feet, *((options.anchor,) if options.anchor else ())):
        if name not in names:
            raise UsageError(
                f"no foot '{name}'{nearest(name, list(names))}", file=session.recipe.path,
                remedy=f"the feet are {', '.join(names)}",
            )  # fmt: skip
    found = {}
    for foot in names:
        usual = [f"{foot}_sole", f"{foot}_foot", foot]
        guess = next((name for name in usual if name in body.frames), usual[0])
        found[foot] = body.require_frame(options.feet.get(foot, guess))
    return found
