"""Tables of standing and walking as streams: readings of the feet, and the body's own."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footcal_cli.core.checks.impossible import find_impossible
from footcal_cli.core.online.streams import BodyStream, SensorStream
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.spatial import headings, rotations_logged, rotations_of_rpy
from footcal_cli.errors import DataError
from footcal_cli.tables.columns import AXIS_COLUMNS
from footcal_cli.tables.table import Table

_FEW = 10
"""Rows in which torques may be alike by chance."""


def sensor_stream_of(
    table: Table, channels: tuple[str, ...], feet: tuple[str, ...], lost: float | None
) -> SensorStream:
    """Readings of cells or, where `feet` are named, of their transducers; lost ones are NaN."""
    _refuse_three_axes(table, feet)
    columns = (
        [f"{foot}_{axis}" for foot in feet for axis in AXIS_COLUMNS]
        if feet
        else [f"{channel}_counts" for channel in channels]
    )
    readings = table.numbers(columns)
    if lost is not None:
        readings = np.where(readings == lost, np.nan, readings)
    return SensorStream(table.number("time_s"), readings, channels)


def body_stream_of(table: Table, feet: tuple[str, ...]) -> BodyStream:
    """The body's columns; what a log may lack is zero or None, values beyond all sense are NaN."""
    n = len(table)

    def possible(columns: Sequence[str]) -> FloatArray:
        values = table.numbers(columns)
        far = np.stack([find_impossible(column) for column in values.T], axis=1)
        return np.where(far, np.nan, values) if far.any() else values

    def triple(pattern: str) -> FloatArray:
        return possible([pattern.format(axis) for axis in "xyz"])

    rotations = []
    yaws = []
    for foot in feet:
        if f"{foot}_foot_qw" in table:
            quaternion = table.numbers([f"{foot}_foot_q{axis}" for axis in "xyzw"])
            rot = rotations_logged(quaternion)
        else:
            angles = [f"{foot}_foot_{angle}_rad" for angle in ("roll", "pitch", "yaw")]
            rpy = [possible([a])[:, 0] if a in table else np.zeros(n) for a in angles]
            rot = rotations_of_rpy(np.stack(rpy, axis=1))
        rotations.append(rot)
        yaws.append(headings(rot))
    momentum = (
        possible(["angmom_rate_x_nm", "angmom_rate_y_nm"])
        if "angmom_rate_x_nm" in table
        else np.zeros((n, 2))
    )
    momenta = ["angmom_x_nms", "angmom_y_nms"]
    return BodyStream(
        time_s=table.number("time_s"),
        com_m=triple("com_{}_m"),
        com_acc_mps2=(
            triple("com_acc_{}_mps2") if "com_acc_x_mps2" in table else np.full((n, 3), np.nan)
        ),
        com_vel_mps=triple("com_vel_{}_mps") if "com_vel_x_mps" in table else None,
        angmom_rate_nm=momentum,
        angmom_nms=(
            possible(momenta) if momenta[0] in table and "angmom_rate_x_nm" not in table else None
        ),
        feet_m=np.stack([triple(f"{foot}_foot_{{}}_m") for foot in feet], axis=1),
        feet_yaw_rad=np.stack(yaws, axis=1),
        feet_rot=np.stack(rotations, axis=1),
        imu_acc_mps2=triple("imu_acc_{}_mps2") if "imu_acc_x_mps2" in table else None,
        imu_gyro_radps=triple("imu_gyro_{}_radps") if "imu_gyro_x_radps" in table else None,
    ).without_skipped()


def _refuse_three_axes(table: Table, feet: Sequence[str]) -> None:
    """Refuse transducers under feet whose three torques never change: they have three axes.

    Raises
    ------
    DataError
        Names the foot, and how a force alone is read.
    """
    for foot in feet:
        names = [f"{foot}_t{axis}_nm" for axis in "xyz"]
        torques = table.numbers(names)
        known = torques[np.isfinite(torques).all(axis=1)]
        if len(known) > _FEW and not np.ptp(known, axis=0).any():
            raise DataError(
                f"the torques of {foot} never change: under feet six axes are needed",
                file=table.path, column=names[0],
                remedy=f"read its vertical force as a cell: {foot}_foot_counts in [columns], "
                f"foot = {{ x_m = 0.0, y_m = 0.0 }} in [robot.feet.{foot}.cells]",
            )  # fmt: skip


def has_momentum(table: Table) -> bool:
    """Whether a body's stream knows its angular momentum, or the rate of that."""
    return "angmom_rate_x_nm" in table or "angmom_x_nms" in table


def no_body(stream: SensorStream, feet: int) -> BodyStream:
    """A robot that says nothing: its weight is known, its CoM is not."""
    time_s = stream.time_s[np.isfinite(stream.time_s)]
    ends = np.array([time_s.min() - 1.0, *np.unique(time_s), time_s.max() + 1.0])
    n = ends.size
    return BodyStream(
        ends, np.full((n, 3), np.nan), np.zeros((n, 3)), np.zeros((n, 2)),
        np.zeros((n, feet, 3)), np.zeros((n, feet)),
    )  # fmt: skip
