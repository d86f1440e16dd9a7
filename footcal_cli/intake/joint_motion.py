"""The motion of a robot's model along a log of joint positions."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core.kinematics import Accelerations, Posture, accelerations, standing_base
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.signals import clock_of
from footcal_cli.errors import DataError, UsageError
from footcal_cli.intake.joints import base_of, feet_frames, joints_of, read_joints
from footcal_cli.intake.rigid_body import read_urdf

if TYPE_CHECKING:
    from footcal_cli.recipe.options import KinematicsOptions
    from footcal_cli.session.session import Session


@dataclass(frozen=True)
class JointMotion:
    """What a URDF does along a log.

    Parameters
    ----------
    log
        Name of the file.
    mass_kg
        Of the URDF.
    feet
        Their names, in the posture's order.
    base_known
        Whether the base's position was logged.
    carried_n
        Mean vertical force on the feet, None where it was not logged.
    """

    log: str
    mass_kg: float
    feet: tuple[str, ...]
    time_s: FloatArray
    posture: Posture
    accelerations: Accelerations
    base_known: bool
    carried_n: float | None


def read_motion(session: Session[KinematicsOptions]) -> JointMotion:
    """Read the URDF and the one log, and move the URDF along it.

    Raises
    ------
    UsageError
        No URDF, or a recipe that does not fit it.
    DataError
        Too few rows, or none in which all joints and the base are known.
    """
    options = session.options
    path = _urdf_path(session)
    with session.step("read"):
        body = read_urdf(path)
        feet = feet_frames(session, body)
        log = read_joints(session, body, tuple(feet))
        positions = joints_of(log, body, options)
        base_m, turned = base_of(log)
    stamps = log.number("time_s")
    keep = clock_of(stamps).keep
    if keep.size < 4:
        raise DataError(
            f"{keep.size} rows with increasing stamps are too few", file=log.path,
            remedy="check the unit of time_s, or record longer",
        )  # fmt: skip
    start = np.zeros((keep.size, 3)) if base_m is None else base_m[keep]
    with session.step("kinematics"):
        kept = {name: position[keep] for name, position in positions.items()}
        frames = list(feet.values())
        posture = body.posture(stamps[keep], start, turned[keep], kept, frames)
        if not np.isfinite(posture.com_m).all(axis=1).any():
            lost = [name for name, position in positions.items() if not np.isfinite(position).any()]
            raise DataError(
                "in no row are all joints and the base known"
                + (f"; without a reading: {', '.join(lost)}" if lost else ""), file=log.path,
                remedy="fill the columns that are empty",
            )  # fmt: skip
        if base_m is None:
            fixed = None if options.anchor is None else list(feet).index(options.anchor)
            posture = posture.moved(standing_base(posture.feet_m, fixed))
        moved = accelerations(stamps[keep], posture, options.cutoff_hz)
    loads = [f"{foot}_fz_n" for foot in feet]
    carried_n = None
    if all(column in log for column in loads):
        carried_n = float(np.nanmean(log.numbers(loads).sum(axis=1)))
    return JointMotion(
        log.path.name, body.mass_kg, tuple(feet), stamps[keep], posture, moved,
        base_m is not None, carried_n,
    )  # fmt: skip


def _urdf_path(session: Session[KinematicsOptions]) -> Path:
    if session.options.urdf is None:
        raise UsageError("no URDF given", remedy="give --urdf FILE.urdf, or urdf in [kinematics]")
    path, recipe = Path(session.options.urdf), session.recipe.path
    if path.is_absolute() or path.is_file() or recipe is None:
        return path
    return recipe.parent / path
