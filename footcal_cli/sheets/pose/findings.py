"""What standing poses say that a user must know: legs that do not fit, shifts that are shared."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.pose.common import CommonShift, common_shift, common_turn, odd_hip
from footcal_cli.core.pose.departures import ROBOT_WEIGHT, ConstantError, Disagreement
from footcal_cli.core.pose.joint import PoseFit
from footcal_cli.core.pose.leg_map import LegMap
from footcal_cli.core.quality import Finding
from footcal_cli.core.spatial import rotation_log
from footcal_cli.report import number, with_sd
from footcal_cli.sheets.pose.mounting_tables import common_sd

BELIEF = {ROBOT_WEIGHT: "the recipe's mass"}
"""Who believed in a quantity before the poses; all others are known from hanging."""
_MOST_DEPARTURES = 4
"""So many contradictions are reported; they have one cause, mostly."""


def findings(
    fit: PoseFit, mapped: LegMap, *, com_given: bool = True, shifted: bool = False
) -> Iterator[Finding]:
    """A leg that does not fit, poses that do not suffice, a turn that all mountings share.

    Parameters
    ----------
    com_given
        Whether it was said where the CoM of the chassis lies.
    shifted
        Whether offsets moved since hanging: that bends the fit, and makes other legs seem wrong.
    """
    suspect = None if shifted else mapped.suspect
    if suspect is not None:
        yield Finding(
            "leg_predicts_residual", "warning", f"leg {fit.geometry.legs[suspect]}",
            f"its own readings predict {100 * mapped.share[suspect]:.0f} % of the residual of the "
            "balance",
            "check gain, axes and channels of that transducer; run diagnose",
        )  # fmt: skip
    if fit.rank < fit.free:
        yield Finding(
            "rank", "warning", f"{fit.poses} poses",
            f"they determine {fit.rank} of {fit.free} mounting errors; the rest rests "
            "on priors and hanging logs",
            "add poses with other shaft angles and body tilts (8 suffice for full rank)",
        )  # fmt: skip
    common = common_turn(rotation_log(fit.mounting.turn_b))
    if common is not None and common.stands_out:
        yield Finding(
            "mountings_turned_alike", "note", "all legs",
            f"{common.words}; a body frame tilted by its markers (body_tilt) looks "
            "the same in every pose (mount_rotation)",
            "put a spirit level on the chassis where the markers define its frame",
        )  # fmt: skip
    yield from _hip_elsewhere(fit)
    yield from _com_elsewhere(fit, com_given)


def _shifts(fit: PoseFit) -> FloatArray | None:
    """Hips against the chassis' CoM beside the drawing, (K, 3); None without intervals."""
    geometry = fit.geometry
    if not np.isfinite(fit.options.translation_sd_m) or np.isnan(fit.covariance).any():
        return None
    return np.asarray(fit.arm_b_m - (geometry.hip_b_m - geometry.chassis_com_b_m))


def _hip_elsewhere(fit: PoseFit) -> Iterator[Finding]:
    """One hip that lies elsewhere than the others say is no matter of the CoM."""
    shift, first = _shifts(fit), 3 * len(fit.geometry.legs)
    if shift is None:
        return
    own = slice(first, first + shift.size)
    odd = odd_hip(shift, fit.covariance[own, own])
    if odd is not None:
        off = ", ".join(
            with_sd(1e3 * value, 1e3 * sd)
            for value, sd in zip(odd.shift_b_m, odd.sd_m, strict=True)
        )
        yield Finding(
            "hip_elsewhere", "warning", f"leg {fit.geometry.legs[odd.leg]}",
            f"its transducer lies ({off}) mm (body x, y, z) from where the other hips, which "
            "agree, put it: it is mounted elsewhere than drawn (mount_translation)",
            "check the screws and spacers of that transducer; the calibration holds its shift",
        )  # fmt: skip


def shared_shift(fit: PoseFit) -> CommonShift | None:
    """The shift that all hips share; None where the fit has no intervals or moves no hip."""
    shift, first = _shifts(fit), 3 * len(fit.geometry.legs)
    if shift is None:
        return None
    seen = np.array([common_sd(fit, first + axis) for axis in range(3)])
    com_sd = min(fit.options.com_sd_m, 10.0)
    return common_shift(shift, seen, fit.options.translation_sd_m, com_sd)


def _com_elsewhere(fit: PoseFit, com_given: bool) -> tuple[Finding, ...]:
    """A shift that all hips share is named as that of the chassis' CoM."""
    geometry, shared = fit.geometry, shared_shift(fit)
    if shared is None or not shared.stands_out:
        return ()
    where = ", ".join(
        with_sd(1e3 * value, 1e3 * sd)
        for value, sd in zip(geometry.chassis_com_b_m + shared.com_b_m, shared.sd_m, strict=True)
    )
    metres = ", ".join(f"{v:.4f}" for v in geometry.chassis_com_b_m + shared.com_b_m)
    return (
        Finding(
            "chassis_com_elsewhere",
            "note" if com_given else "warning",
            "all legs",
            "all hips are shifted alike, as if the CoM of the robot without its legs lay "
            f"at ({where}) mm in the body frame; standing shows only hip minus CoM",
            f"write chassis_com_m = [{metres}] into [pose_calib] if the CoM was not "
            "measured: the shifts are then each hip's own",
        ),
    )


def constant_findings(found: ConstantError) -> Iterator[Finding]:
    """What is wrong in all poses alike."""
    force = ", ".join(number(float(value), 2) for value in found.mean[:3])
    yield Finding(
        "constant_error", "warning", "all legs",
        f"the sum of forces is off by ({force}) N in the body's axes in all poses alike, "
        f"{100 * found.share:.0f} % of the residual's mean square: offsets moved since "
        "hanging, or something pulls on the body",
        "run diagnose, which looks for the leg; hang the robot again just before it stands, or "
        "find new offsets from tripods (--fit offsets); check cables",
    )  # fmt: skip


def departure_findings(found: Sequence[Disagreement]) -> Iterator[Finding]:
    """Where the poses contradict the scale or the hanging robot."""
    for one in found[:_MOST_DEPARTURES]:
        of_robot = one.name == ROBOT_WEIGHT
        said = BELIEF.get(one.name, "hanging")
        yield Finding(
            "robot_weight_differs" if of_robot else "differs_from_hanging", "warning", one.name,
            f"the poses say {with_sd(one.found, one.found_sd)} {one.unit}, {said} "
            f"{with_sd(one.believed, one.believed_sd)} {one.unit}: {one.sigmas:.0f} sd apart",
            "weigh the robot as it stood, with battery and cables; if the scale is "
            "right, the transducers' gain is off"
            if of_robot
            else "hang the robot again and compare; an offset that moved since asks for "
            "--fit offsets",
        )  # fmt: skip


def disagreeing_directions(misfit: float) -> Finding:
    """The hanging logs of different legs do not belong to one rigid robot that then stood so."""
    return Finding(
        "hang_directions_disagree", "warning", "hanging logs",
        "the legs' directions of gravity do not fit one rigid robot in these poses (χ² "
        f"{misfit:.0f}); they are not used for the mounting",
        "hang the whole robot at once for all legs, or check the transducers' axes "
        "(orientation_of in hang-calib)",
    )  # fmt: skip
