"""URDF: the calibrated mounting of transducers as fixed joints.

``<origin xyz rpy>`` of https://wiki.ros.org/urdf/XML/joint: fixed-axis roll, pitch, yaw, so
``R = Rz(yaw) Ry(pitch) Rx(roll)``, from the child's axes to the parent's.
"""

from __future__ import annotations

from collections.abc import Mapping
from xml.sax.saxutils import quoteattr

from footcal_cli.core.spatial import rpy_of_rotation
from footcal_cli.errors import UsageError
from footcal_cli.exporters.contract import MOUNTING, Exported, ToExport, head, number

_BODY = "base_link"


def export(calibration: ToExport, names: Mapping[str, str]) -> Exported:
    """A robot of `base_link` and, on a fixed joint each, the transducers.

    Raises
    ------
    UsageError
        The mounting was not calibrated, or its nominal pose is not known.
    """
    bare = [name for name in names if not calibration.mounted(name)]
    if bare:
        raise UsageError(
            f"the mounting of '{bare[0]}' is not in the calibration", file=calibration.source,
            remedy="calibrate it with pose-calib",
        )  # fmt: skip
    warnings = (
        *calibration.beyond(list(names), MOUNTING),
        "offsets, weights and CoMs have no place in a URDF",
    )
    comments = head(
        calibration,
        names,
        [
            "Transducer frames in the body: m, and rad about fixed axes (roll, pitch, yaw).",
            "Take the joints into the robot's own description.",
        ],
        warnings,
    )
    lines = [
        f"<robot name={quoteattr(calibration.record.robot)}>",
        *(f"  <!-- {line.replace('--', '- -')} -->" for line in comments),
        f'  <link name="{_BODY}"/>',
    ]
    for name, theirs in names.items():
        place, turn = calibration.place(name), calibration.turn(name)
        xyz = place.position_m + place.rotation @ calibration.shift_m(name)
        rpy = rpy_of_rotation(place.rotation @ turn)
        shown = {
            "xyz": " ".join(number(x) for x in xyz), "rpy": " ".join(number(x) for x in rpy)
        }  # fmt: skip
        lines += [
            f"  <link name={quoteattr(theirs)}/>",
            f'  <joint name={quoteattr(f"{theirs}_ft_joint")} type="fixed">',
            f'    <origin xyz="{shown["xyz"]}" rpy="{shown["rpy"]}"/>',
            f'    <parent link="{_BODY}"/>',
            f"    <child link={quoteattr(theirs)}/>",
            "  </joint>",
        ]
    return Exported("\n".join([*lines, "</robot>"]) + "\n", warnings)
