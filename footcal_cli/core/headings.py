"""How bodies and feet are turned, against what they can do: degrees, steps, conventions."""

from __future__ import annotations

import numpy as np

from footcal_cli.core.body_stream import alarm
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.quality import Finding
from footcal_cli.core.spatial import rotation_of_quaternion

FASTEST_TURN_RADPS = 20.0
"""No foot turns faster about the vertical."""
MOST_TURNS_RAD = 4.0 * np.pi
"""Headings beyond are degrees, or a robot that turned more than twice."""
_FEWEST = 20
ACROSS_RAD, IN_DEGREES = 0.8, 0.3
"""Steps turn the line from foot to foot by half a radian; a heading that lies further off, and
as degrees within this share of it, is one in degrees."""


def check_heading(time_s: FloatArray, yaw_rad: FloatArray, where: str) -> list[Finding]:
    """Find headings in degrees: they turn too far, or too fast.

    Parameters
    ----------
    time_s, yaw_rad
        Shape (n,).
    """
    good = np.isfinite(yaw_rad) & np.isfinite(time_s)
    yaw, time_s = yaw_rad[good], time_s[good]
    if yaw.size < _FEWEST:
        return []
    # jumps by whole turns are a matter of the range, not of the unit
    turned = np.unwrap(yaw)
    furthest = float(np.abs(yaw).max())
    gap = max(round(0.05 / max(float(np.median(np.diff(time_s))), 1e-6)), 1)
    spent = time_s[gap:] - time_s[:-gap]
    moving = spent > 0
    rate = np.abs(turned[gap:] - turned[:-gap])[moving] / spent[moving]
    fastest = float(np.percentile(rate, 99.5)) if rate.size else 0.0
    if furthest <= MOST_TURNS_RAD and fastest <= FASTEST_TURN_RADPS:
        return []
    return [
        _in_degrees(where, f"reaches {furthest:.4g} rad and turns by up to {fastest:.3g} rad/s")
    ]


def check_heading_across(
    yaw_rad: FloatArray, left_m: FloatArray, right_m: FloatArray, where: str
) -> list[Finding]:
    """Find headings in degrees by the line from foot to foot, which lies across the heading.

    Parameters
    ----------
    yaw_rad
        Shape (n,).
    left_m, right_m
        Positions of both feet, shape (n, 3).
    """
    across = left_m - right_m
    good = np.isfinite(yaw_rad) & np.isfinite(across).all(axis=1)
    if good.sum() < _FEWEST:
        return []
    yaw, across = yaw_rad[good], across[good]
    ahead = np.arctan2(across[:, 1], across[:, 0]) - np.pi / 2.0

    def off(heading: FloatArray) -> float:
        return float(np.median(np.abs(np.angle(np.exp(1j * (heading - ahead))))))

    given, turned = off(yaw), off(np.radians(yaw))
    if given < ACROSS_RAD or turned > IN_DEGREES * given:
        return []
    return [_in_degrees(where, f"lies {given:.2g} rad off the line across both feet")]


def _in_degrees(where: str, seen: str) -> Finding:
    return alarm(
        "heading_not_radians", where, f"the heading {seen}: it looks given in degrees",
        'give the unit in [columns], left_foot_yaw_rad = { column = "…", unit = "deg" }',
    )  # fmt: skip


def check_quaternions(quaternion: FloatArray, where: str, *, upright: bool = True) -> list[Finding]:
    """Find quaternions that are no rotations, or given with w first.

    Parameters
    ----------
    quaternion
        x y z w, shape (n, 4).
    upright
        The z axis of what is turned points up; with w first it points elsewhere.
    """
    good = quaternion[np.isfinite(quaternion).all(axis=1)]
    size = np.linalg.norm(good, axis=1)
    if len(good) < 1 or float(np.median(np.abs(size - 1.0))) > 0.05:
        return [] if len(good) < 1 else [
            alarm(
                "no_unit_quaternions", where,
                f"the quaternions have a norm of {float(np.median(size)):.3g} (median), not 1",
                "check that all four columns are mapped to the right names",
            )
        ]  # fmt: skip
    if not upright:
        return []
    good = good[np.abs(size - 1.0) < 0.1]
    up = float(np.median(rotation_of_quaternion(good)[:, 2, 2]))
    other = float(np.median(rotation_of_quaternion(good[:, [1, 2, 3, 0]])[:, 2, 2]))
    if up > 0.5 or other < 0.9:
        return []
    return [
        alarm(
            "quaternions_w_first", where,
            f"with the order x y z w it does not stand upright (its z axis rises by {up:.2g}), "
            f"with w first it does ({other:.2g})",
            "map the columns to qx qy qz qw by what they hold: the first one is w",
        )
    ]  # fmt: skip
