"""``footcal hang-calib``: offsets, leg weight and leg CoM of hanging legs ([Wu], III-A)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
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
    from footcal_cli.core.hang.joint import HangFit, HangOptions
    from footcal_cli.core.hang.runs import HangRun
    from footcal_cli.core.hang.stepwise import StepwiseFit
    from footcal_cli.core.log import Log
    from footcal_cli.core.parameters import Estimates, FloatArray
    from footcal_cli.core.quality import Finding
    from footcal_cli.records.results import ParametersRecord
    from footcal_cli.report import Picture
    from footcal_cli.session.session import Outcome, Session


_POOR = 5.0
"""Residual over the scatter from sample to sample beyond which more than noise is left."""


class HangCalibOptions(CommandOptions):
    """``[hang_calib]`` of a recipe.

    `orientation_of` says whose axis the log's orientation names: the transducer's own, or the
    body's (a transducer turned by π about z then reads −x in a log called ``+x``). `tilt` is one
    per named orientation (`per_log`), one of the sensor on its `mount`, or none; where nothing is
    said it is `mount` if the log has a measured attitude, else `per_log`.
    """

    method: Literal["joint", "stepwise", "naive"] = "joint"
    order: int | None = Field(default=None, ge=0, le=8)
    max_order: int = Field(default=3, ge=0, le=8)
    tilt: Literal["per_log", "mount", "none"] | None = None
    tilt_sd_rad: float = Field(default=0.2, gt=0)
    orientation_of: Literal["transducer", "body"] = "transducer"
    leg_weight_n: float = Field(default=0.0, ge=0)
    temperature: bool = False
    drift: bool = False
    white: bool = False
    compare: bool = True
    max_force_rmse_n: float | None = Field(default=None, gt=0)

    @property
    def limits(self) -> dict[str, float | None]:
        """Limits of `max_…`, by quantity, SI units."""
        return {"* force": self.max_force_rmse_n}


def hang_calib(
    logs: Logs = None,
    recipe: RecipeFile = None,
    parameters: ParametersFile = None,
    method: Annotated[
        str | None, typer.Option("--method", help="joint, or the paper's stepwise, or naive.")
    ] = None,
    tilt: Annotated[
        str | None, typer.Option("--tilt", help="per_log, mount (a sensor on a wrist) or none.")
    ] = None,
    max_force_rmse_n: Annotated[
        float | None, typer.Option("--max-force-rmse-n", help="Gate: exit 1 above this RMSE.")
    ] = None,
    reference: ReferenceFile = None,
    strict_findings: StrictFindings = None,
    out: Out = Path("out/hang-calib"),
    overwrite: Overwrite = False,
    seed: Seed = 0,
    no_pictures: NoPictures = False,
    quiet: Quiet = False,
) -> None:
    """Fit offsets, leg weight and leg CoM of six-axis transducers hanging in the air."""
    session = begin(
        "hang-calib",
        HangCalibOptions,
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
        method=method,
        tilt=tilt,
        max_force_rmse_n=max_force_rmse_n,
    )
    raise typer.Exit(session.finish(_calibrate(session)))


def _calibrate(session: Session[HangCalibOptions]) -> Outcome:
    session.refuse_missing_logs("hang")
    from footcal_cli.commands.parts.hang_logs import leg_logs
    from footcal_cli.core.hang.joint import fit_hang
    from footcal_cli.core.hang.runs import hang_runs
    from footcal_cli.core.plausibility import check_leg_weights
    from footcal_cli.records.results import RmseRecord
    from footcal_cli.report import Report
    from footcal_cli.session.session import Outcome
    from footcal_cli.sheets import hang as sheets
    from footcal_cli.tables.columns import hang_table

    options = session.options
    with session.step("read"):
        tables = session.read_required(hang_table())
        logs, rejected = leg_logs(
            tables,
            session.recipe,
            options.orientation_of,
            options.leg_weight_n,
            session.parameters,
        )
        runs = {leg: hang_runs(log)[0] for leg, log in logs.items()}
    with session.step("fit"):
        asked = asked_of(
            options, session.recipe.robot.gravity_mps2,
            measured=not any("orientation" in table for table in tables),
        )  # fmt: skip
        fits = {leg: fit_hang(log, asked) for leg, log in logs.items()}
        session.note(hanging_axes(logs, runs, fits, asked))
    others: dict[str, dict[str, StepwiseFit]] = {}
    if options.compare or options.method != "joint":
        with session.step("compare"):
            others = _others(session, logs)
    residuals = sheets.residuals_by_stage(fits, others, runs, options.method)
    pictures = _pictures(fits, runs, residuals, others.get(options.method))
    rmse = RmseRecord(rows=sheets.rmse_rows(residuals), rejected=rejected)
    chosen: Mapping[str, Estimates] = (
        {leg: fit.estimates for leg, fit in fits.items()}
        if options.method == "joint"
        else {leg: sheets.without_intervals(other) for leg, other in others[options.method].items()}
    )
    weights = {leg: float(one[f"{leg}.weight"]) for leg, one in chosen.items()}
    robot = session.recipe.robot
    stated = {n: leg.mass_kg * robot.gravity_mps2 for n, leg in robot.legs.items() if leg.mass_kg}
    session.note(check_leg_weights(weights, robot.weight_n, stated))
    return Outcome(
        report=Report(
            title=f"Hanging calibration of {session.recipe.robot.name}",
            verdict=sheets.verdict(fits, residuals, runs, options.method),
            pictures=pictures,
            sheets=(
                sheets.parameter_sheet(chosen),
                sheets.com_sheet(chosen),
                *sheets.method_sheets(fits, others),
                sheets.noise_sheet(fits),
            ),
            findings=sheets.findings(fits, runs),
            footer=sheets.footer(options.method),
        ),
        rmse=rmse,
        parameters=_parameters(session, chosen, logs),
        usable=options.method != "joint" or all(fit.fit.converged for fit in fits.values()),
    )


def hanging_axes(
    logs: Mapping[str, Sequence[Log]],
    runs: Mapping[str, Sequence[HangRun]],
    fits: Mapping[str, HangFit],
    asked: HangOptions,
) -> list[Finding]:
    """Axes of turned sign and turned transducers; axes are refitted only where a fit is poor."""
    from footcal_cli.core.pose.wiring import turned_when_hanging
    from footcal_cli.core.turned import check_turned_hanging

    found: list[Finding] = []
    for leg, own in logs.items():
        turned = check_turned_hanging(leg, own)
        if turned or fits[leg].misfit(runs[leg]) > _POOR:
            axis = turned_when_hanging(own, asked)
            turned = turned if axis is None else [axis.finding()]
        found += turned
    return found


def asked_of(
    options: HangCalibOptions, gravity_mps2: float, *, measured: bool = False
) -> HangOptions:
    """What the core is asked to fit; `measured` where the attitude was, not named."""
    from footcal_cli.core.hang.joint import HangOptions

    return HangOptions(
        order=options.order,
        max_order=options.max_order,
        tilt=options.tilt or ("mount" if measured else "per_log"),
        tilt_sd_rad=options.tilt_sd_rad,
        temperature=options.temperature,
        drift=options.drift,
        white=options.white,
        gravity_mps2=gravity_mps2,
    )


def _others(
    session: Session[HangCalibOptions], logs: Mapping[str, list[Log]]
) -> dict[str, dict[str, StepwiseFit]]:
    """Stepwise and naive fits, empty where the orientations do not come in two opposite pairs."""
    from footcal_cli.core.hang.stepwise import fit_stepwise_and_naive
    from footcal_cli.errors import FitError

    try:
        both = {leg: fit_stepwise_and_naive(log) for leg, log in logs.items()}
        return {
            "naive": {leg: naive for leg, (_, naive) in both.items()},
            "stepwise": {leg: stepwise for leg, (stepwise, _) in both.items()},
        }
    except FitError:
        if session.options.method == "joint":
            return {}
        raise


def _pictures(
    fits: Mapping[str, HangFit],
    runs: Mapping[str, Sequence[HangRun]],
    residuals: Mapping[str, Mapping[str, FloatArray]],
    own: Mapping[str, StepwiseFit] | None,
) -> tuple[Picture, ...]:
    """Figures of the method that was asked for: `own`, or the joint fit where None."""
    from footcal_cli.core.hang.binned import binned_com
    from footcal_cli.plots.hang import plot_com, plot_residuals, plot_tilts
    from footcal_cli.report import Picture

    pictures = [
        Picture(
            "residuals", lambda: plot_residuals(residuals),
            "Residual of the readings after offset and leg weight are subtracted: one violin "
            "per leg and axis. A good fit is one narrow hump around zero.",
            title="Residuals",
        ),
    ]  # fmt: skip
    shown: Mapping[str, HangFit | StepwiseFit] = own or fits
    if any(fit.model.order > 0 for fit in fits.values()):
        binned = {leg: binned_com(fit, runs[leg]) for leg, fit in shown.items()}
        pictures.append(
            Picture(
                "leg_com", lambda: plot_com(shown, binned),
                "Leg CoM in the transducer frame against the shaft angle: dots are medians over "
                "cycles, dark the quartiles, light 95 % of the cycles; dashed the fitted series.",
                title="Leg CoM against shaft angle",
            )
        )  # fmt: skip
    tilted = own is None or any(fit.turn_rad.any() for fit in own.values())
    if tilted and any(fit.model.tilt != "none" for fit in fits.values()):
        directions = {
            leg: fit.gravity_dir_t if own is None else own[leg].gravity_dir_t(runs[leg])
            for leg, fit in fits.items()
        }
        pictures.append(
            Picture(
                "orientations", lambda: plot_tilts(fits, directions),
                "Where gravity really pointed in each orientation, seen along the named axis: what "
                "all legs share is the robot's tilt, where they differ it is the mounting.",
                title="Direction of gravity in each orientation",
            )
        )  # fmt: skip
    return tuple(pictures)


def _parameters(
    session: Session[HangCalibOptions],
    chosen: Mapping[str, Estimates],
    logs: Mapping[str, Sequence[Log]],
) -> ParametersRecord:
    import numpy as np

    from footcal_cli.commands.parts.calibration_record import Conventions, calibration_record
    from footcal_cli.records.results import (
        ParameterRecord,
        Range,
        covariance_blocks,
        parameter_records,
    )

    parameters: dict[str, ParameterRecord] = {}
    ranges: dict[str, dict[str, Range]] = {}
    for leg, estimates in chosen.items():
        parameters |= parameter_records(estimates)
        force = np.concatenate([np.linalg.norm(log.readings[:, :3], axis=1) for log in logs[leg]])
        ranges[leg] = {
            "force": Range(lowest=float(force.min()), highest=float(force.max()), unit="N")
        }
        warmth = [w for log in logs[leg] if (w := log.known.get("temperature_degc")) is not None]
        if warmth:
            all_of = np.concatenate(warmth)
            ranges[leg]["temperature"] = Range(
                lowest=float(all_of.min()), highest=float(all_of.max()), unit="degC"
            )
    effects = session.parameters.effects if session.parameters is not None else ()
    if session.parameters is not None and effects:
        kept = session.parameters.parameters
        parameters = {**{n: p for n, p in kept.items() if n not in parameters}, **parameters}
    return calibration_record(
        session,
        Conventions(
            "reading = applied + offset; applied by leg and ground on the transducer, "
            "[fx fy fz tx ty tz]; leg CoM = mean + sin · sin φ + cos · cos φ",
            "each transducer's own axes",
            "the transducer's origin",
        ),
        parameters,
        covariance=covariance_blocks(
            *(e for e in chosen.values() if session.options.method == "joint")
        ),
        fitted_range=ranges,
        effects=effects,
    )
