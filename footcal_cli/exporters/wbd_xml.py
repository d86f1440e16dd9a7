"""YARP's ``wholeBodyDynamics``: secondary calibration matrix and offset.

Groups ``FT_SECONDARY_CALIBRATION`` (36 numbers, row-major) and ``FT_OFFSET`` (6) of
https://github.com/robotology/whole-body-estimators/blob/master/devices/wholeBodyDynamics/README.md,
wrenches ``[force; torque]``. The device computes ``matrix · reading − offset``
(``SixAxisForceTorqueMeasureHelpers.cpp``), so its offset is the matrix times footcal's.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from xml.sax.saxutils import quoteattr

from footcal_cli.exporters.contract import LINEAR, Exported, ToExport, head, number


def export(calibration: ToExport, names: Mapping[str, str]) -> Exported:
    """The two groups, to be put into the device's configuration."""
    warnings = calibration.beyond(list(names), LINEAR)
    comments = head(
        calibration,
        names,
        [
            "wrench = matrix * reading - offset, [fx fy fz tx ty tz] in N and Nm, applied by what",
            "is below on the transducer, in the transducer's nominal frame: the matrix undoes",
            "gains and coupling, turns the wrench and moves it to the nominal origin.",
            "Keep the model's nominal sensor frame with it (not footcal's urdf export as well).",
            "The device uses FT_OFFSET after the rpc command usePreEstimatedOffset.",
        ],
        warnings,
    )
    matrices, offsets = [], []
    for name, theirs in names.items():
        matrix = calibration.matrix(name, LINEAR)
        matrices.append(_param(theirs, matrix.ravel()))
        offsets.append(_param(theirs, matrix @ calibration.offset(name)))
    # two hyphens may not stand in a comment of XML
    lines = [
        "<device>",
        *(f"  <!-- {line.replace('--', '- -')} -->" for line in comments),
        '  <group name="FT_SECONDARY_CALIBRATION">',
        *matrices,
        "  </group>",
        '  <group name="FT_OFFSET">',
        *offsets,
        "  </group>",
        "</device>",
    ]
    return Exported("\n".join(lines) + "\n", warnings)


def _param(name: str, values: Iterable[float]) -> str:
    return f"    <param name={quoteattr(name)}>({','.join(number(x) for x in values)})</param>"
