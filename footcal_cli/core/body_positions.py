"""Where a robot says that its CoM and its feet are, against what bodies can do."""

from __future__ import annotations

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.quality import Finding

TALLEST_M = 10.0
"""No CoM of a legged robot or a person lies higher above its feet, no two feet further apart."""
_UPRIGHT, _LEAST_HEIGHT_M = 1.5, 0.02
"""The CoM stands out over the feet by this factor, and so much."""
_FEWEST = 20


def _alarm(code: str, where: str, sentence: str, remedy: str) -> Finding:
    return Finding(code, "alarm", where, sentence, remedy)


def check_positions(com_m: FloatArray, feet_m: FloatArray, where: str) -> list[Finding]:
    """Find positions in another unit, axes that point down, CoM and feet in different frames.

    Parameters
    ----------
    com_m, feet_m
        Shapes (n, 3) and (n, feet, 3).
    """
    good = np.isfinite(com_m).all(axis=1) & np.isfinite(feet_m).all(axis=(1, 2))
    if good.sum() < _FEWEST:
        return []
    com, feet = com_m[good], feet_m[good]
    height = float(np.median(com[:, 2] - feet[:, :, 2].min(axis=1)))
    wide = 0.0
    if feet.shape[1] > 1:
        wide = float(np.median(np.linalg.norm(np.ptp(feet[..., :2], axis=1), axis=1)))
    aside = float(np.median(np.linalg.norm(com[:, :2] - feet[..., :2].mean(axis=1), axis=1)))
    if max(abs(height), wide, aside) > TALLEST_M:
        which = [name for name, size in (("the CoM", abs(height)), ("the feet", wide)) if size > 10]
        return [
            _alarm(
                "positions_not_metres", where,
                f"the CoM lies {height:.4g} m above and {aside:.4g} m away from the feet, and the "
                f"feet {wide:.4g} m apart: {' and '.join(which) or 'one of them'} may be in mm, or "
                "in another frame",
                'give the unit in [columns], com_x_m = { column = "…", unit = "mm" }',
            )
        ]  # fmt: skip
    up = upright_axis(com, feet)
    if up not in ("", "+z"):
        said = "z points down" if up == "-z" else f"{up.removeprefix('+')} points up"
        where_com = f"{-height:.3g} m below" if up == "-z" else f"along {up} of"
        return [
            _alarm(
                "z_points_down" if up == "-z" else "z_not_up", where,
                f"the CoM lies {where_com} the feet: {said}, or the frames differ",
                f'write world_up = "{up}" in [robot]',
            )
        ]  # fmt: skip
    if aside > max(1.0, 2.0 * height):
        return [
            _alarm(
                "com_not_over_feet", where,
                f"the CoM lies {aside:.3g} m away from the feet (its height: {height:.3g} m): they "
                "are given in different frames",
                "log CoM and feet in the same world frame",
            )
        ]  # fmt: skip
    return []


def upright_axis(com_m: FloatArray, feet_m: FloatArray) -> str:
    """Axis along which the CoM stays above all feet, ``+x`` … ``-z``; empty where none stands out.

    A robot that stands or walks has its CoM over its feet: along one axis they lie further apart
    than along both others, and always on one side. Where that holds for z, the others may be those
    of another frame.

    Parameters
    ----------
    com_m, feet_m
        Shapes (n, 3) and (n, feet, 3).
    """
    off = com_m[:, None] - feet_m
    usual = np.median(off, axis=(0, 1))
    low, high = np.percentile(off, [2, 98], axis=(0, 1))
    if low[2] > _LEAST_HEIGHT_M:
        return "+z"
    first = int(np.argmax(np.abs(usual)))
    others = np.max(np.abs(np.delete(usual, first)))
    one_side = low[first] > 0 or high[first] < 0
    if not one_side or abs(usual[first]) < max(_UPRIGHT * others, _LEAST_HEIGHT_M):
        return ""
    return ("+" if usual[first] > 0 else "-") + "xyz"[first]
