"""ros2_control's ``force_torque_sensor_broadcaster``: offset and multiplier per axis.

Parameters: https://control.ros.org/master/doc/ros2_controllers/force_torque_sensor_broadcaster/doc/userdoc.html
The broadcaster *adds* its offset (ros2_controllers pull request 1215) and multiplies afterwards
(pull request 1647): ``published = (reading + offset) · multiplier``. So the offset is the
calibration's with its sign changed, and the multiplier undoes gains.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.exporters.contract import GAINS, Exported, ToExport, head, number


def export(calibration: ToExport, names: Mapping[str, str]) -> Exported:
    """A parameter file, a broadcaster per transducer."""
    warnings = list(calibration.beyond(list(names), GAINS))
    lines: list[str] = []
    for name, theirs in names.items():
        node = "force_torque_sensor_broadcaster"
        lines += [
            f"{node if len(names) == 1 else f'{theirs}_{node}'}:",
            "  ros__parameters:",
            f"    sensor_name: {theirs}",
            f"    frame_id: {theirs}",
            *_axes("offset", -calibration.offset(name)),
        ]
        gains = np.diag(calibration.matrix(name, GAINS))
        if not np.array_equal(gains, np.ones(6)):
            lines += _axes("multiplier", gains)
        if _weighed(calibration, name):
            warnings.append(
                f"the weight below {name} stays in what is published: the broadcaster does not "
                "remove gravity"
            )
    comments = head(
        calibration,
        names,
        [
            "published = (reading + offset) * multiplier, in N and Nm along the transducer's axes,",
            "applied by what is below on the transducer; so offset is footcal's with its sign",
            "changed. The multiplier came into ros2_controllers in 2025 (pull request 1647).",
        ],
        warnings,
    )
    return Exported("\n".join([*(f"# {c}" for c in comments), *lines]) + "\n", tuple(warnings))


def _weighed(calibration: ToExport, name: str) -> bool:
    return f"{name}.weight" in calibration.record.parameters or name in calibration.hung


def _axes(key: str, values: FloatArray) -> list[str]:
    lines = [f"    {key}:"]
    for i, kind in enumerate(("force", "torque")):
        lines.append(f"      {kind}:")
        lines += [
            f"        {axis}: {number(value)}"
            for axis, value in zip("xyz", values[3 * i : 3 * i + 3], strict=True)
        ]
    return lines
