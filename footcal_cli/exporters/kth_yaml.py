"""KTH's ``force_torque_tools``: bias, mass and CoM of ``gravity_compensation``.

Fields as ``force_torque_sensor_calib`` writes them and ``gravity_compensation_node`` reads them:
https://github.com/kth-ros-pkg/force_torque_tools. The node computes
``compensated = reading − bias − [m a; r × m a]`` with ``a`` the ``linear_acceleration`` of its
``imu`` topic in the transducer's frame. In footcal's readings the weight points down, so ``a`` has
to be gravity itself (down); an accelerometer at rest shows the opposite.
"""

from __future__ import annotations

from collections.abc import Mapping

from footcal_cli.exporters.contract import Exported, ToExport, head, number, only


def export(calibration: ToExport, names: Mapping[str, str]) -> Exported:
    """A YAML file of one transducer.

    Raises
    ------
    UsageError
        Several transducers, or no weight and CoM.
    """
    name, theirs = only(names, "kth-yaml")
    hung = calibration.load(name)
    warnings = list(calibration.beyond([name], ()))
    if hung.swing_m:
        warnings.append(
            f"the CoM below {name} moves by {1e3 * hung.swing_m:.1f} mm with the shaft; this file "
            "holds its mean"
        )
    comments = head(
        calibration,
        [name],
        [
            "bias: N and Nm, [fx fy fz tx ty tz]; subtracted from the reading.",
            f"gripper_mass: kg, weight {number(hung.weight_n)} N / "
            f"{number(calibration.record.gravity_mps2)} m/s^2.",
            "gripper_com_pose: m and rad in the transducer's frame.",
            "The imu topic must carry gravity (pointing down at rest), not what an accelerometer",
            "shows (pointing up): a weight below reads along gravity here.",
        ],
        warnings,
    )
    pose = ", ".join(number(x) for x in (*hung.com_m, 0.0, 0.0, 0.0))
    bias = ", ".join(number(x) for x in calibration.offset(name))
    lines = [
        *(f"# {line}" for line in comments),
        f"bias: [{bias}]",
        f"gripper_com_child_frame_id: {theirs}_com",
        f"gripper_com_frame_id: {theirs}",
        f"gripper_com_pose: [{pose}]",
        f"gripper_mass: {number(hung.weight_n / calibration.record.gravity_mps2)}",
    ]
    return Exported("\n".join(lines) + "\n", tuple(warnings))
