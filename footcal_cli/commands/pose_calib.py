"""``footcal pose-calib``: mounting of hip transducers from standing poses (Wu & Revzen, III-B)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from footcal_cli.commands.options import command
from footcal_cli.recipe.options import PoseCalibOptions

if TYPE_CHECKING:
    from footcal_cli.core.parameters import Estimates
    from footcal_cli.core.pose.data import Geometry
    from footcal_cli.records.results import ParametersRecord
    from footcal_cli.report.outcome import Outcome
    from footcal_cli.session.session import Session


@command(PoseCalibOptions)
def pose_calib(session: Session[PoseCalibOptions]) -> Outcome:
    """Fit the mounting of hip transducers, or new offsets, from standing poses."""
    session.refuse_missing_logs("poses")
    return {"mounting": _mounting, "offsets": _offsets, "series": _series}[session.options.fit](
        session
    )


def _mounting(session: Session[PoseCalibOptions]) -> Outcome:
    from dataclasses import replace

    import numpy as np

    from footcal_cli.core.plausibility import check_supported
    from footcal_cli.core.pose.mounted import error_of, naive_error, offset_error
    from footcal_cli.core.pose.moving import find_moving, moving_finding
    from footcal_cli.core.pose.problem import PoseOptions
    from footcal_cli.core.pose.seating import standing_axes
    from footcal_cli.core.pose.study import study_mounting
    from footcal_cli.errors import UsageError
    from footcal_cli.intake.poses import noise_sd_of, read_poses, weight_sd_of
    from footcal_cli.sheets.pose.mounting import outcome_of

    options = session.options
    if options.balance == "printed" and options.method == "joint":
        raise UsageError(
            "the printed balance is only kept for the paper's own scheme",
            remedy="give --method alternating too",
        )
    with session.step("read"):
        data, legs, rejected = read_poses(session, options)
    noise_sd, noise_known = noise_sd_of(options, len(legs), data.robot_weight_n)
    free = PoseOptions(
        errors_in_variables=options.errors_in_variables,
        com_sd_m=options.com_sd_m,
        rotation_sd_rad=options.rotation_sd_rad or np.inf,
        robot_weight_sd_n=weight_sd_of(options, session.recipe.robot),
        noise_known=noise_known,
    )
    with session.step("fit"):
        supported = data.robot_weight_n - data.leg_weight_n.sum()
        error = offset_error(data, legs)[:, :3]
        session.note(check_supported(error, float(supported), "all legs"))
        moving = find_moving(data, legs, noise_sd, free)
        if moving.any():
            session.note(moving_finding(moving))
            data, rejected = data.only(~moving), {**rejected, "off balance": int(moving.sum())}
        session.note(
            standing_axes(data, legs, noise_sd, options.com_sd_m, options.translation_sd_m)
        )
        study = study_mounting(
            data, legs, noise_sd, free, structure=options.structure,
            translation_sd_m=options.translation_sd_m, directions=options.hang_directions,
            folds=options.folds,
        )  # fmt: skip
    stages = {
        "before": naive_error(data, study.legs),
        "offsets only": offset_error(data, study.legs),
    }
    if options.method == "alternating":
        from footcal_cli.core.study.alternating import alternated

        with session.step("alternate"):
            stages["joint"] = error_of(data, study.fit)
            printed = options.balance == "printed"
            study = replace(study, fit=alternated(data, study.legs, study.fit, printed=printed))
    stages["after"] = error_of(data, study.fit)
    found = outcome_of(session.recipe.robot.name, study, stages, rejected, options)
    return replace(found, parameters=_updated(session, study.fit.estimates(), data.geometry))


def _offsets(session: Session[PoseCalibOptions]) -> Outcome:
    from dataclasses import replace

    import numpy as np

    from footcal_cli.core.pose.mounted import Mounted
    from footcal_cli.core.pose.study import offset_estimates, refit_offsets
    from footcal_cli.errors import DataError
    from footcal_cli.intake.poses import noise_sd_of, read_poses
    from footcal_cli.sheets.pose.offsets import outcome_of

    options = session.options
    with session.step("read"):
        data, legs, rejected = read_poses(session, options)
    if np.isnan(data.contact).any():
        raise DataError(
            "which feet were down is not known",
            remedy="add the column contact (1 on the ground, 0 lifted)",
        )
    assert session.parameters is not None, "checked while reading"
    mounted = Mounted.of(session.parameters.values, data.geometry)
    noise_sd, noise_known = noise_sd_of(options, len(legs), data.robot_weight_n)
    wanted = (options.wanted_force_sd_n, options.wanted_torque_sd_nm)
    with session.step("fit"):
        fit = refit_offsets(data, legs, mounted, noise_sd, wanted, noise_known=noise_known)
    found = outcome_of(session.recipe.robot.name, data, legs, mounted, fit, rejected)
    if not fit.accepted:
        return found
    estimates = offset_estimates(fit, data.geometry.legs)
    return replace(found, parameters=_updated(session, estimates, data.geometry))


def _series(session: Session[PoseCalibOptions]) -> Outcome:
    from footcal_cli.core.pose.series import fit_series
    from footcal_cli.intake.poses import read_pairs
    from footcal_cli.sheets.pose.series import outcome_of

    options = session.options
    with session.step("read"):
        wrench, quiet, block, lost = read_pairs(session)
    with session.step("fit"):
        fits = [
            fit_series(one, two, wrench[one], wrench[two], quiet, block)
            for one, two in options.series
        ]
    return outcome_of(session.recipe.robot.name, fits, lost, options.block_s, options.quiet_s)


def _updated(
    session: Session[PoseCalibOptions], estimates: Estimates, geometry: Geometry
) -> ParametersRecord:
    """The calibration of ``--parameters`` with new estimates and the chassis CoM believed."""
    from footcal_cli.core.parameters import Status
    from footcal_cli.records.results import ParameterRecord
    from footcal_cli.session.calibration import MOUNTED_LEGS, updated

    believed = {
        f"robot.chassis_com_{axis}": ParameterRecord(
            value=float(value), sd=None, unit="m", status=Status.FIXED
        )
        for axis, value in zip("xyz", geometry.chassis_com_b_m, strict=True)
    }
    return updated(session, MOUNTED_LEGS, estimates, believed)
