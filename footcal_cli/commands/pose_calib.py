"""``footcal pose-calib``: mounting of hip transducers from standing poses (Wu & Revzen, III-B)."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer
from pydantic import Field

from footcal_cli.commands.options import (
    Logs,
    NoPictures,
    Out,
    Overwrite,
    ParametersFile,
    Quiet,
    RecipeFile,
    ReferenceFile,
    Seed,
    StrictFindings,
    begin,
)
from footcal_cli.recipe import CommandOptions

if TYPE_CHECKING:
    from footcal_cli.core.parameters import FloatArray
    from footcal_cli.core.pose.data import PoseData
    from footcal_cli.core.pose.hanging import LegKnowledge
    from footcal_cli.core.pose.problem import PoseOptions
    from footcal_cli.records.results import FindingRecord
    from footcal_cli.session.session import Outcome, Session

Vector = tuple[float, float, float]


class PoseCalibOptions(CommandOptions):
    """``[pose_calib]`` of a recipe.

    `force_sd_n` and `torque_sd_nm` are the noise of one pose's reading; without them their level
    is estimated. `translation_sd_m` and `com_sd_m` are priors on each hip and on the chassis CoM.
    `structure` names the free mounting errors; ``auto`` lets the evidence choose. `series` lists
    pairs of transducers on one stiff leg, for `fit` ``series``: nothing else is known of them.
    With ``auto`` and a prior on translations, every hip may shift within its prior.
    """

    fit: Literal["mounting", "offsets", "series"] = "mounting"
    method: Literal["joint", "alternating"] = "joint"
    balance: Literal["exact", "printed"] = "exact"
    structure: Literal[
        "auto", "full", "body_rotations", "hip_rotations", "translations", "single"
    ] = "auto"
    errors_in_variables: bool = True
    force_sd_n: float | None = Field(default=None, gt=0)
    torque_sd_nm: float | None = Field(default=None, gt=0)
    translation_sd_m: float | None = Field(default=0.005, gt=0)
    com_sd_m: float = Field(default=0.05, gt=0)
    rotation_sd_rad: float | None = Field(default=None, gt=0)
    robot_weight_sd_n: float = Field(default=0.05, gt=0)
    chassis_com_m: Vector = (0.0, 0.0, 0.0)
    hang_directions: Literal["auto", "use", "ignore"] = "auto"
    folds: int = Field(default=5, ge=2)
    steady_rate_nps: float = Field(default=1.0, gt=0)
    steady_duration_s: float = Field(default=1.5, gt=0)
    steady_window_s: float = Field(default=0.5, gt=0)
    wanted_force_sd_n: float = Field(default=0.1, gt=0)
    wanted_torque_sd_nm: float = Field(default=0.01, gt=0)
    series: tuple[tuple[str, str], ...] = ()
    quiet_s: float = Field(default=10.0, gt=0)
    block_s: float = Field(default=0.5, gt=0)
    max_force_rmse_n: float | None = Field(default=None, gt=0)

    @property
    def limits(self) -> dict[str, float | None]:
        """Limits of `max_…`, by quantity, SI units."""
        quantity = "* force" if self.fit == "series" else "sum of forces"
        return {quantity: self.max_force_rmse_n}


def pose_calib(
    logs: Logs = None,
    recipe: RecipeFile = None,
    parameters: ParametersFile = None,
    fit: Annotated[
        str | None,
        typer.Option("--fit", help="mounting, offsets (again, from tripods), or series (pairs)."),
    ] = None,
    method: Annotated[
        str | None, typer.Option("--method", help="joint, or the paper's alternating scheme.")
    ] = None,
    balance: Annotated[
        str | None,
        typer.Option("--balance", help="exact, or as printed in Wu & Revzen (alternating only)."),
    ] = None,
    structure: Annotated[
        str | None,
        typer.Option(
            "--structure", help="auto, full, body_rotations, hip_rotations, translations, single."
        ),
    ] = None,
    max_force_rmse_n: Annotated[
        float | None, typer.Option("--max-force-rmse-n", help="Gate: exit 1 above this RMSE.")
    ] = None,
    reference: ReferenceFile = None,
    strict_findings: StrictFindings = None,
    out: Out = Path("out/pose-calib"),
    overwrite: Overwrite = False,
    seed: Seed = 0,
    no_pictures: NoPictures = False,
    quiet: Quiet = False,
) -> None:
    """Fit the mounting of hip transducers, or offsets again, from standing poses."""
    session = begin(
        "pose-calib",
        PoseCalibOptions,
        logs=logs,
        recipe=recipe,
        parameters=parameters,
        reference=reference,
        out=out,
        overwrite=overwrite,
        seed=seed,
        quiet=quiet,
        no_pictures=no_pictures,
        strict_findings=strict_findings,
        fit=fit,
        method=method,
        balance=balance,
        structure=structure,
        max_force_rmse_n=max_force_rmse_n,
    )
    session.refuse_missing_logs("poses")
    if session.options.fit == "series":
        from footcal_cli.commands.parts.pose_series import series_outcome

        raise typer.Exit(session.finish(series_outcome(session)))
    if session.options.fit == "offsets":
        raise typer.Exit(session.finish(_offsets(session)))
    raise typer.Exit(session.finish(_mounting(session)))


def pose_noise_sd(options: PoseCalibOptions, legs: int) -> tuple[FloatArray, bool]:
    """Noise per leg and channel (K, 6), and whether its level is known."""
    import numpy as np

    force = options.force_sd_n or 0.05
    torque = options.torque_sd_nm or 0.1 * force
    known = options.force_sd_n is not None and options.torque_sd_nm is not None
    return np.tile([force] * 3 + [torque] * 3, (legs, 1)), known


def _with_directions(
    options: PoseCalibOptions,
    data: PoseData,
    legs: tuple[LegKnowledge, ...],
    noise_sd: FloatArray,
    free: PoseOptions,
) -> tuple[tuple[LegKnowledge, ...], tuple[FindingRecord, ...]]:
    """Hanging directions kept where they agree with each other, dropped with a finding else."""
    from footcal_cli.core.pose.data import summarise
    from footcal_cli.core.pose.joint import directions_agree, fit_pose
    from footcal_cli.sheets.pose import disagreeing_directions

    if options.hang_directions == "use" or not any(leg.gravity_dir_t.size for leg in legs):
        return legs, ()
    without = tuple(leg.without_directions() for leg in legs)
    if options.hang_directions == "ignore":
        return without, ()
    fit = fit_pose(summarise(data), legs, noise_sd, free)
    if directions_agree(fit, legs):
        return legs, ()
    return without, (disagreeing_directions(fit),)


def _mounting(session: Session[PoseCalibOptions]) -> Outcome:
    import numpy as np

    from footcal_cli.commands.parts.pose_logs import read_poses
    from footcal_cli.commands.parts.pose_outcome import Found, mounting_outcome
    from footcal_cli.core.plausibility import check_supported
    from footcal_cli.core.pose.leg_map import leg_map
    from footcal_cli.core.pose.model import Structure
    from footcal_cli.core.pose.problem import PoseOptions
    from footcal_cli.core.pose.selection import compare_structures, cross_validated
    from footcal_cli.core.pose.slow_noise import fit_pose_slowly
    from footcal_cli.core.pose.stages import alternated, error_of, naive_error, offset_error
    from footcal_cli.core.turned import standing_axes
    from footcal_cli.errors import UsageError

    options = session.options
    if options.balance == "printed" and options.method == "joint":
        raise UsageError(
            "the printed balance is only kept for the paper's own scheme",
            remedy="give --method alternating too",
        )
    with session.step("read"):
        data, legs, rejected = read_poses(session, options)
    noise_sd, noise_known = pose_noise_sd(options, len(legs))
    free = PoseOptions(
        errors_in_variables=options.errors_in_variables,
        com_sd_m=options.com_sd_m,
        rotation_sd_rad=options.rotation_sd_rad or np.inf,
        robot_weight_sd_n=options.robot_weight_sd_n,
        noise_known=noise_known,
    )
    with session.step("fit"):
        supported = data.robot_weight_n - data.leg_weight_n.sum()
        error = offset_error(data, legs)[:, :3]
        session.note(check_supported(error, float(supported), "all legs"))
        # as `diagnose` asks: with ordinary priors, whatever this run leaves free
        usual = PoseOptions(com_sd_m=options.com_sd_m, translation_sd_m=0.005)
        session.note(standing_axes(data, legs, noise_sd, usual))
        legs, findings = _with_directions(options, data, legs, noise_sd, free)
        candidates = compare_structures(data, legs, noise_sd, free, options.folds)
        structure, prior = candidates[0].structure, options.translation_sd_m or np.inf
        if options.structure != "auto":
            structure = Structure[options.structure.upper()]
        elif np.isfinite(prior):
            # Hips are never exactly in place: what the evidence does not demand keeps its prior.
            structure = structure.with_translations
        final = replace(free, structure=structure, translation_sd_m=prior)
        fit, slow = fit_pose_slowly(data, legs, noise_sd, final)
        held_out = cross_validated(data, legs, noise_sd, fit, options.folds)
    stages = {"before": naive_error(data, legs), "offsets only": offset_error(data, legs)}
    if options.method == "alternating":
        with session.step("alternate"):
            stages["joint"] = error_of(data, fit)
            fit = alternated(data, legs, fit, printed=options.balance == "printed")
    stages["after"] = error_of(data, fit)
    scaled = noise_sd * (1.0 if noise_known else fit.noise_factor)
    with session.step("map"):
        mapped = leg_map(data, fit, scaled)
    return mounting_outcome(
        session,
        Found(data, legs, fit, slow, candidates, held_out, stages, mapped, findings, rejected),
    )


def _offsets(session: Session[PoseCalibOptions]) -> Outcome:
    import numpy as np

    from footcal_cli.commands.parts.pose_logs import read_poses
    from footcal_cli.commands.parts.pose_outcome import offset_outcome, stored_mounting
    from footcal_cli.core.pose.standing import StandingRobot, fit_offsets
    from footcal_cli.core.pose.wrenches import leg_coms_t_m
    from footcal_cli.errors import DataError

    options = session.options
    with session.step("read"):
        data, legs, rejected = read_poses(session, options)
    if np.isnan(data.contact).any():
        raise DataError(
            "which feet were down is not known",
            remedy="add the column contact (1 on the ground, 0 lifted)",
        )
    mounted = stored_mounting(session, data.geometry)
    weights = np.array([leg.weight_n for leg in legs])
    robot = StandingRobot(
        mounted.rot_bt,
        mounted.arm_b_m,
        weights,
        data.robot_weight_n - weights.sum(),
        leg_coms_t_m(tuple(leg.com_m for leg in legs), data.phase_rad),
        np.stack([leg.offset for leg in legs]),
        np.stack([np.sqrt(np.diag(leg.covariance)[:6]) for leg in legs]),
    )
    noise_sd, noise_known = pose_noise_sd(options, len(legs))
    wanted = (options.wanted_force_sd_n, options.wanted_torque_sd_nm)
    with session.step("fit"):
        found = fit_offsets(data, robot, noise_sd, wanted)
        if not noise_known and found.accepted:
            found = fit_offsets(data, robot, noise_sd * found.noise_factor, wanted)
    return offset_outcome(session, data, legs, mounted, found, rejected)
