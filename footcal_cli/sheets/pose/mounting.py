"""Mountings found from standing poses: report, tables, error rows and sentences."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.pose.common import CommonShift
from footcal_cli.core.pose.data import PoseData
from footcal_cli.core.pose.departures import (
    Disagreement,
    constant_error,
    disagreements,
)
from footcal_cli.core.pose.joint import FEWEST_LEFT, PoseFit
from footcal_cli.core.pose.leg_map import LegMap
from footcal_cli.core.pose.mounted import Mounted, in_floating_base
from footcal_cli.core.pose.selection import Candidate
from footcal_cli.core.pose.slow_noise import SlowNoise
from footcal_cli.core.pose.study import MountingStudy
from footcal_cli.core.pose.wrenches import FootCalibration, foot_wrenches, robot_com_b_m
from footcal_cli.core.signals import root_mean_square
from footcal_cli.core.spatial import rotation_log
from footcal_cli.plots import pose as plots
from footcal_cli.records.results import RmseRecord, VerdictRecord
from footcal_cli.report import Picture, number
from footcal_cli.report.outcome import Outcome
from footcal_cli.sheets.feet import wrench_columns

if TYPE_CHECKING:
    from footcal_cli.recipe.options import PoseCalibOptions
from footcal_cli.sheets.pose.findings import (
    BELIEF,
    constant_findings,
    departure_findings,
    disagreeing_directions,
    findings,
    shared_shift,
)
from footcal_cli.sheets.pose.mounting_tables import (
    candidate_sheet,
    common_sd,
    common_sheet,
    mounting_sheet,
    prior_sheet,
    rmse_rows,
)

_NOISY = 1.5


def outcome_of(
    robot: str,
    study: MountingStudy,
    stages: Mapping[str, FloatArray],
    rejected: Mapping[str, int],
    options: PoseCalibOptions,
) -> Outcome:
    """The mounting of all transducers.

    Parameters
    ----------
    study
        The fit and what judges it.
    stages
        Balance errors (P, 6) by stage: before, offsets only, …, after.
    rejected
        Poses by reason.
    """
    data, fit = study.data, study.fit
    calibration = Mounted(fit.rot_bt, fit.arm_b_m).feet(data, fit.mounting.offset, study.legs)
    com = robot_com_b_m(calibration, data, calibration.leg_weight_n / data.robot_weight_n)
    constant = constant_error(data, fit)
    # offsets that moved are why poses contradict hanging and the scale: that is said alone
    contradicted = (
        () if study.moved
        else (*study.refuted, *disagreements(fit, study.legs, data.robot_weight_n))
    )  # fmt: skip
    shifted = study.moved or (constant.stands_out and not contradicted)
    alike = None if "chassis_com_m" in options.model_fields_set else shared_shift(fit)
    dropped = () if study.dropped is None else (disagreeing_directions(study.dropped),)
    return Outcome(
        title=f"Standing calibration of {robot}",
        verdict=verdict(study, stages, contradicted, alike, shifted=shifted),
        pictures=_pictures(study, stages, com),
        sheets=(
            mounting_sheet(fit),
            candidate_sheet(study.candidates),
            common_sheet(fit),
            prior_sheet(fit, study.legs),
        ),
        findings=(
            *dropped, *findings(fit, study.mapped, com_given=alike is None, shifted=shifted),
            *departure_findings(contradicted), *(constant_findings(constant) if shifted else ()),
        ),
        footer=footer(options.method, options.balance, options.errors_in_variables),
        rmse=RmseRecord(rows=rmse_rows(stages, study.held_out), rejected=dict(rejected)),
        tables={
            "wrenches.parquet": pose_wrenches(data, calibration),
            "models.parquet": _models(study.candidates),
        },
        usable=fit.converged,
    )  # fmt: skip


def _pictures(
    study: MountingStudy, stages: Mapping[str, FloatArray], com: FloatArray
) -> tuple[Picture, ...]:
    """Figures of the mounting; `com` is the robot's CoM in the floating base, shape (P, 3)."""
    data, fit, names = study.data, study.fit, study.data.geometry.legs
    return (
        Picture(
            "balance",
            lambda: plots.plot_balance(
                {name: in_floating_base(data, e, com) for name, e in stages.items()}
            ),
            "Sum of the ground's wrenches on all feet minus the robot's weight, in the "
            "floating base about the robot's CoM: zero if every transducer is "
            "right. Before: tare in the air, nominal mounting (compare Wu & Revzen, Figs. "
            "2 and 6).",
            title="Sum of all foot wrenches against the robot's weight",
            result="RMS of the sum of forces: "
            + " N before, ".join(
                number(root_mean_square(stages[stage][:, :3]), 2) for stage in ("before", "after")
            )
            + " N now.",
        ),
        Picture(
            "mounting",
            lambda: plots.plot_mounting(fit),
            "The robot from above: nominal hips (squares), calibrated hips with 95 % "
            "ellipses and axes, errors drawn larger than life.",
            title="Nominal and calibrated hips, from above",
            result=lambda: _largest_errors(fit),
        ),
        Picture(
            "legs_and_poses",
            lambda: plots.plot_leg_map(study.mapped, names),
            "Residual that each leg's own readings predict, pose by pose: a row that "
            "lights up is a leg with a wrong gain, a twisted axis or a dead channel.",
            title="Residual predicted by each leg, pose by pose",
            result=lambda: _largest_share(study.mapped, names),
        ),
        Picture(
            "coverage",
            lambda: plots.plot_coverage(data),
            "Which shaft angles and body tilts the poses cover: yaw and height of the "
            "mounting are only seen where the body tilts.",
            title="Shaft angles and body tilts covered by the poses",
            result=lambda: _covered(data),
        ),
    )


def _largest_errors(fit: PoseFit) -> str:
    """The largest turn and the largest shift of a mounting."""
    legs, geometry = fit.geometry.legs, fit.geometry
    turn = np.rad2deg(np.linalg.norm(rotation_log(fit.mounting.turn_b), axis=1))
    nominal = geometry.hip_b_m - geometry.chassis_com_b_m
    shift = 1e3 * np.linalg.norm(fit.arm_b_m - nominal, axis=1)
    return (
        f"Largest turn {number(float(turn.max()), 2)}° ({legs[int(turn.argmax())]}), largest "
        f"shift {number(float(shift.max()), 2)} mm ({legs[int(shift.argmax())]})."
    )


def _largest_share(mapped: LegMap, legs: Sequence[str]) -> str:
    """Which leg predicts most of the residual."""
    worst = int(np.argmax(mapped.share))
    return (
        f"{legs[worst]} predicts most: {number(100 * float(mapped.share[worst]), 2)} % of the "
        "residual."
    )


def _covered(data: PoseData) -> str:
    """Ranges of shaft angles and tilts."""
    phase = np.rad2deg(data.phase_rad)
    lean = np.rad2deg(np.arcsin(np.clip(np.linalg.norm(data.gravity_b[:, :2], axis=1), 0, 1)))
    return (
        f"{len(data)} poses; shafts from {np.nanmin(phase):.0f} to {np.nanmax(phase):.0f}°, tilt "
        f"of the body up to {float(lean.max()):.1f}°."
    ).replace("-", "−")


def _models(candidates: Sequence[Candidate]) -> dict[str, object]:
    """Which mounting errors the evidence asks for, the chosen model first."""
    names = ("freedom", "cv_error", "bic_paper", "cv_chi2", "bic")
    return {
        "model": [candidate.structure.name.lower() for candidate in candidates],
        **{name: [getattr(candidate, name) for candidate in candidates] for name in names},
    }


def pose_wrenches(data: PoseData, calibration: FootCalibration) -> dict[str, object]:
    """Columns of ``wrenches.parquet``."""
    poses = np.arange(len(data.phase_rad))
    return wrench_columns(data, "pose", poses, foot_wrenches(data, calibration))


def verdict(
    study: MountingStudy, stages: Mapping[str, FloatArray], contradicted: Sequence[Disagreement],
    alike: CommonShift | None = None, *, shifted: bool = False,
) -> VerdictRecord:  # fmt: skip
    """One sentence: what the sum of forces was off by, and is now on poses not used.

    Parameters
    ----------
    alike
        The shift that all hips share, where nobody said where the CoM of the chassis lies.
    shifted
        Whether offsets moved since hanging.
    """
    fit, held_out = study.fit, study.held_out
    before = root_mean_square(stages["before"][:, :3])
    alternated = bool(np.isnan(fit.covariance).any())
    after = root_mean_square(stages["after"][:, :3]) if alternated else _held_out(held_out, 0)
    moment = root_mean_square(stages["after"][:, 3:]) if alternated else _held_out(held_out, 3)
    turn = np.rad2deg(np.linalg.norm(rotation_log(fit.mounting.turn_b), axis=1))
    details = [
        f"Mounting errors fitted: {fit.options.structure.value}; rotations up to "
        f"{number(float(turn.max()), 2)}° ({fit.geometry.legs[int(turn.argmax())]}).",
        f"The evidence alone asks for: {study.candidates[0].structure.value}.",
        f"Moments: {number(root_mean_square(stages['before'][:, 3:]), 2)} Nm before, "
        f"{number(moment, 2)} Nm now.",
        *common_words(fit),
        *_place_words(alike),
        *attitude_words(fit),
        *slow_words(study.slow),
    ]
    if not fit.converged:
        return VerdictRecord(
            level="bad", sentence="The fit did not converge.", details=tuple(details)
        )
    sentence = (
        f"The sum of forces on {fit.poses} poses is off by {number(after, 2)} N per axis"
        f"{'' if alternated else ' on poses not used for the fit'} ({number(before, 2)} N with a "
        "tare in the air)."
    )
    suspect = study.mapped.suspect
    if suspect is not None and not shifted:
        return VerdictRecord(
            level="warning",
            sentence=f"{sentence} Leg {fit.geometry.legs[suspect]} does not fit the others.",
            details=tuple(details),
        )
    if contradicted:
        names = {BELIEF.get(one.name, "hanging") for one in contradicted}
        sentence = f"{sentence} The poses contradict {' and '.join(sorted(names))}."
    if shifted:
        sentence = (
            f"{sentence} In all poses it is off alike, as offsets that moved since hanging do."
        )
    unplaced = alike is not None and alike.stands_out
    if unplaced:
        sentence = f"{sentence} All hips are shifted alike, or the CoM of the chassis is elsewhere."
    noisy = fit.options.noise_known and fit.noise_factor > _NOISY
    few = fit.left < FEWEST_LEFT
    actions: tuple[str, ...] = ()
    if few:
        sentence = f"{sentence} So few poses do not show whether anything is wrong."
        needed = -((6 * fit.poses - fit.left + FEWEST_LEFT) // -6)
        actions = (
            f"Record at least {needed} poses: {fit.poses} leave nothing to check the fit by.",
        )
    if noisy:
        actions = (
            *actions,
            f"Run diagnose: the balance is {fit.noise_factor:.1f} times noisier than the stated "
            "noise of the sensors, so something is not in the model.",
        )
    return VerdictRecord(
        level="warning" if noisy or contradicted or unplaced or few or shifted else "good",
        sentence=sentence,
        actions=(*actions, _GIVE_COM) if unplaced else actions,
        details=tuple(details),
    )


def _held_out(candidate: Candidate, first: int) -> float:
    """Held-out error per axis of the forces (0) or the moments (3)."""
    return float(np.sqrt(candidate.cv_square[first : first + 3].mean()))


def common_words(fit: PoseFit) -> tuple[str, ...]:
    """What all legs share is seen worst: a common yaw and a common height."""
    yaw, height = common_sd(fit, 2), common_sd(fit, 3 * len(fit.geometry.legs) + 2)
    if np.isnan(yaw):
        return ("This method gives no intervals.",)
    known = f"a height common to all hips is known to ± {1e3 * height:.2g} mm"
    if fit.options.structure.rotates:
        known = f"a yaw common to all transducers is known to ± {np.rad2deg(yaw):.2g}°, {known}"
    return (f"{known[0].upper()}{known[1:]} (one sd); more tilt of the body narrows it.",)


_GIVE_COM = (
    "Give chassis_com_m in [pose_calib], the CoM of the robot without its legs in the body frame, "
    "from CAD or by balancing it: each shift is then a hip's own."
)


def _place_words(alike: CommonShift | None) -> tuple[str, ...]:
    """How far all hips together may lie elsewhere where the CoM of the chassis is not known."""
    if alike is None:
        return ()
    x, y, z = (number(1e3 * float(sd), 2) for sd in alike.sd_m)
    return (
        "Standing shows hips against the CoM of the chassis, and chassis_com_m is not given: a "
        f"shift common to all hips may be that of the CoM, to ± {x}, {y}, {z} mm (x, y, z).",
    )


def attitude_words(fit: PoseFit) -> tuple[str, ...]:
    """How far the logged attitudes scatter, where the balance shows it."""
    sd = fit.options.attitude_sd_rad * (1.0 if fit.options.noise_known else fit.noise_factor)
    if sd == 0.0:
        return ()
    return (
        f"The attitudes of the body scatter by about {number(float(np.rad2deg(sd)), 2)}° from pose "
        "to pose; the intervals allow for it.",
    )


def slow_words(slow: SlowNoise) -> tuple[str, ...]:
    """What of the noise lasts from pose to pose, where any does."""
    if slow.share == 0.0:
        return ()
    return (
        f"{100 * slow.share:.0f} % of the noise's variance is drift that lasts about "
        f"{slow.memory_poses:.0f} poses; the intervals allow for it.",
    )


def footer(method: str, balance: str, errors_in_variables: bool) -> tuple[str, ...]:
    """How it was computed."""
    if method == "alternating":
        form = "as printed (fixed CoM)" if balance == "printed" else "exact chassis balance"
        return (
            f"Alternating least squares of Wu & Revzen, eqs. (8) and (9), {form}; no intervals.",
        )
    eiv = "noise of the wrenches compensated" if errors_in_variables else "plain least squares"
    return (
        f"Chassis balance, joint Levenberg-Marquardt on the Gram matrix of the poses, {eiv}; "
        "offsets, weights and directions of gravity with their joint covariance from hanging "
        "(Wu & Revzen, eqs. (8) and (9), in the form in which no leg CoM enters).",
    )
