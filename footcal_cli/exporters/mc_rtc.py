"""mc_rtc's ``calib_data.<sensor>``: 13 numbers.

Layout by ``mc_rbdyn::ForceSensor`` (https://github.com/jrl-umi3218/mc_rtc,
``src/mc_rbdyn/ForceSensor.cpp``): mass, roll-pitch-yaw from the model's to the real sensor frame,
CoM of what hangs below in the parent body's frame, offset. It removes
``offset + weight · [r × down; down]``, wrenches as ``[torque; force]`` (SpaceVecAlg), the weight
pointing down as in footcal's readings. Roll, pitch and yaw are those of URDF: SpaceVecAlg's
``RotX(r) RotY(p) RotZ(y)`` is the transpose of ``Rz(y) Ry(p) Rx(r)``. What follows the 13th number
is not read, so the comments stand behind.
"""

from __future__ import annotations

from collections.abc import Mapping

from footcal_cli.core.spatial import rpy_of_rotation
from footcal_cli.exporters.contract import MOUNTING, Exported, ToExport, head, number, only


def export(calibration: ToExport, names: Mapping[str, str]) -> Exported:
    """A calibration file of one sensor.

    Raises
    ------
    UsageError
        Several transducers, no weight and CoM, or no nominal pose.
    """
    name, theirs = only(names, "mc_rtc")
    hung, place, turn = calibration.load(name), calibration.place(name), calibration.turn(name)
    com_parent_m = place.position_m + place.rotation @ turn @ hung.com_m
    warnings = list(calibration.beyond([name], MOUNTING))
    if calibration.shift_m(name).any():
        shown = ", ".join(f"{1e3 * x:.2f}" for x in calibration.shift_m(name))
        warnings.append(
            f"mc_rtc turns a sensor but does not move it: move {name} by ({shown}) mm along its "
            "nominal axes in the robot's model"
        )
    if hung.swing_m:
        warnings.append(
            f"the CoM below {name} moves by {1e3 * hung.swing_m:.1f} mm with the shaft; this file "
            "holds its mean"
        )
    offset = calibration.offset(name)
    mass_kg = hung.weight_n / calibration.record.gravity_mps2
    values = [mass_kg, *rpy_of_rotation(turn), *com_parent_m, *offset[3:], *offset[:3]]
    comments = head(
        calibration,
        [name],
        [
            f"Rename to calib_data.{theirs}. Order: mass kg; roll pitch yaw rad from the model's",
            "to the real sensor frame; CoM in the parent body m; offset torque Nm, then force N.",
            "mc_rtc multiplies the mass by its own gravity (9.81 m/s^2 unless set otherwise).",
        ],
        warnings,
    )
    lines = [number(value) for value in values] + [f"# {line}" for line in comments]
    return Exported("\n".join(lines) + "\n", tuple(warnings))
