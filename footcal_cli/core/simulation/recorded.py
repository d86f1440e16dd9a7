"""A motion that another engine made, with its own ground forces, in place of the planned one."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from footcal_cli.core.effects.foot import turned
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.simulation.biped_logs import MotionAt
from footcal_cli.core.simulation.gait import Motion
from footcal_cli.core.simulation.robots import Biped

CONTACT_N = 0.5
"""A foot that carries less is in the air."""


def motion_columns(robot: Biped) -> tuple[str, ...]:
    """Columns a recorded motion must have."""
    return (
        "time_s",
        *(f"{channel}_n" for channel in robot.channels),
        *(f"com_{axis}_m" for axis in "xyz"),
        *(f"com_acc_{axis}_mps2" for axis in "xyz"),
        *(f"angmom_rate_{axis}_nm" for axis in "xy"),
        *(f"{foot}_foot_{axis}_m" for foot in robot.feet for axis in "xyz"),
        *(f"{foot}_foot_yaw_rad" for foot in robot.feet),
    )


def recorded(
    robot: Biped, columns: Mapping[str, FloatArray]
) -> tuple[MotionAt, Callable[[FloatArray], FloatArray]]:
    """The motion and the cell loads of a recording, at any stamps.

    Everything is interpolated linearly, so that sums of forces and accelerations stay balanced
    between the recorded rows; outside, the first and the last row hold.

    Parameters
    ----------
    columns
        `motion_columns`, each of shape (n,); block: a new one with each landing of the first foot.

    Returns
    -------
    motion_at, loads_at
        Functions of stamps (m,); loads have shape (m, c).
    """
    clock = columns["time_s"]
    feet = tuple(robot.feet)
    loads = np.stack([columns[f"{channel}_n"] for channel in robot.channels], axis=-1)
    on = np.stack([loads[:, robot.foot_of_channel == i].sum(axis=1) for i in range(len(feet))], -1)
    standing = (on > CONTACT_N).astype(float)
    landings = np.concatenate([[0], np.cumsum(np.diff(standing[:, 0]) > 0)])

    def at(time_s: FloatArray, names: list[str]) -> FloatArray:
        return np.stack([np.interp(time_s, clock, columns[name]) for name in names], axis=-1)

    def loads_at(time_s: FloatArray) -> FloatArray:
        return at(time_s, [f"{channel}_n" for channel in robot.channels])

    def motion_at(time_s: FloatArray) -> Motion:
        last = np.clip(np.searchsorted(clock, time_s, side="right") - 1, 0, len(clock) - 2)
        # A foot that is loaded on one side of a stamp only is landing or lifting.
        before, after = standing[last], standing[last + 1]
        foot_m = np.stack(
            [at(time_s, [f"{foot}_foot_{axis}_m" for axis in "xyz"]) for foot in feet], axis=1
        )
        yaw = at(time_s, [f"{foot}_foot_yaw_rad" for foot in feet])
        middle = np.stack([robot.cells_m(foot).mean(axis=0) for foot in feet])
        return Motion(
            time_s=time_s,
            com_m=at(time_s, [f"com_{axis}_m" for axis in "xyz"]),
            com_acc_mps2=at(time_s, [f"com_acc_{axis}_mps2" for axis in "xyz"]),
            angmom_rate_nm=at(time_s, [f"angmom_rate_{axis}_nm" for axis in "xy"]),
            foot_m=foot_m,
            foot_yaw_rad=yaw,
            foot_ref_m=foot_m[..., :2] + turned(middle[:, 0], middle[:, 1], yaw),
            contact=np.where(before == after, before, np.nan),
            block=landings[last],
        )

    return motion_at, loads_at
