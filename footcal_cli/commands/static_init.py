"""``footcal static-init``: scale and bias of foot cells from quiet standing."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

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
from footcal_cli.recipe import CommandOptions, metres

if TYPE_CHECKING:
    from footcal_cli.core.stance_curve import CurvePoint
    from footcal_cli.core.static_init import StanceErrors, StanceRows, StaticInit
    from footcal_cli.intake.recordings import Recording
    from footcal_cli.report import Picture
    from footcal_cli.session.session import Outcome, Session


class StaticInitOptions(CommandOptions):
    """``[static_init]`` of a recipe."""

    warm_s: float = Field(default=1.0, ge=0)
    largest_acceleration_mps2: float = Field(default=0.3, gt=0)
    largest_rate_radps: float = Field(default=0.1, gt=0)
    least_samples: int = Field(default=40, ge=4)
    until_s: float | None = Field(default=None, gt=0)
    delay_s: float = Field(default=0.02, ge=0)
    cutoff_hz: float = Field(default=10.0, gt=0)
    force_sd_n: float = Field(default=0.15, gt=0)
    moment_sd_nm: float = Field(default=0.03, gt=0)
    lifted_sd_n: float = Field(default=0.15, gt=0)
    max_cop_rmse_mm: float | None = Field(default=None, gt=0)

    @property
    def limits(self) -> dict[str, float | None]:
        """Limits of `max_…`, by quantity, SI units."""
        return {"cop*": metres(self.max_cop_rmse_mm)}


def static_init(
    logs: Logs = None,
    recipe: RecipeFile = None,
    parameters: ParametersFile = None,
    until_s: Annotated[
        float | None, typer.Option("--until-s", help="Use only the log's first seconds.")
    ] = None,
    max_cop_rmse_mm: Annotated[
        float | None,
        typer.Option("--max-cop-rmse-mm", help="Gate: exit 1 above this CoP error."),
    ] = None,
    reference: ReferenceFile = None,
    strict_findings: StrictFindings = None,
    out: Out = Path("out/static-init"),
    overwrite: Overwrite = False,
    seed: Seed = 0,
    no_pictures: NoPictures = False,
    quiet: Quiet = False,
) -> None:
    """Find scales and biases of foot cells as far as quiet standing shows them."""
    session = begin(
        "static-init",
        StaticInitOptions,
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
        until_s=until_s,
        max_cop_rmse_mm=max_cop_rmse_mm,
    )
    raise typer.Exit(session.finish(_stand(session)))


def _stand(session: Session[StaticInitOptions]) -> Outcome:
    from footcal_cli.core.online.streams import MergeRule
    from footcal_cli.intake.recordings import is_six_axis_robot, read_recordings

    options = session.options
    rule = MergeRule(delay_s=options.delay_s, cutoff_hz=options.cutoff_hz)
    with session.step("read"):
        recordings = read_recordings(
            session, rule, "stand", body_needed=is_six_axis_robot(session.recipe.robot)
        )
    if recordings[0].belief is None:
        from footcal_cli.commands.parts.standing_six_axis import standing_on_six_axis

        return standing_on_six_axis(session, recordings)
    return _cells(session, recordings)


def _cells(session: Session[StaticInitOptions], recordings: Sequence[Recording]) -> Outcome:
    import numpy as np

    from footcal_cli.commands.parts.feet_parameters import feet_parameters
    from footcal_cli.commands.parts.stances import (
        all_stances,
        next_menu,
        standing_findings,
    )
    from footcal_cli.core.online.weighed import weighed_standing
    from footcal_cli.core.stance_curve import stance_curve
    from footcal_cli.core.static_init import fit_static, stance_errors, stance_rows
    from footcal_cli.records.results import FindingRecord
    from footcal_cli.report import Report
    from footcal_cli.session.session import Outcome
    from footcal_cli.sheets import stand as sheets

    options, robot = session.options, session.recipe.robot
    belief = recordings[0].belief
    assert belief is not None
    with session.step("fit"):
        rows, quiet = all_stances(
            session,
            recordings,
            lambda recording, chosen: stance_rows(
                recording.merged.log, chosen, belief, force_sd_n=options.force_sd_n,
                moment_sd_nm=options.moment_sd_nm, swing_sd_n=options.lifted_sd_n,
            ),
        )  # fmt: skip
        fit = fit_static(rows, belief)
        weight_n = robot.weight_n or 1.0
        errors = stance_errors(rows, belief, weight_n)
        curve = stance_curve(rows, belief, weight_n)
        menu = next_menu(recordings, quiet, rows, weight_n)
        total = np.array([name == "fz" for name in rows.output])
        weighed = weighed_standing(
            rows.h[total], rows.error[total], rows.sd[total],
            rows.prior_correlation, weight_n, robot.mass_kg or 1.0,
        )  # fmt: skip
    estimates = fit.estimates
    rmse = sheets.rmse_of(errors, quiet)
    return Outcome(
        report=Report(
            title=f"Standing calibration of {robot.name}",
            verdict=sheets.verdict_of(fit, errors, menu, weighed),
            pictures=_pictures(fit, rows, errors, curve),
            sheets=(
                sheets.beliefs_sheet(
                    rows.names,
                    rows.units,
                    np.concatenate([fit.gain, fit.bias_n]),
                    np.sqrt(np.diag(fit.covariance)),
                    rows.prior_sd,
                    estimates.status,
                    sheets.BELIEFS_NOTE,
                ),
                sheets.directions_sheet(fit.observability),
                *((sheets.menu_sheet(menu),) if menu else ()),
                *((sheets.curve_sheet(curve),) if curve else ()),
                sheets.stances_sheet(errors, rows.effective_samples),
            ),
            findings=(
                *standing_findings(recordings, (fit.chi2, fit.dof)),
                *map(FindingRecord.of, weighed.findings()),
            ),
            footer=(
                "Model: Σ(1 + γ)F⁰ + β per cell against weight and projected CoM (NAO CoP "
                "self-calibration, eqs. 12, "
                "13), maximum a posteriori in centred units; the prior is --parameters or the "
                "nameplate.",
                f"A stance counts {options.force_sd_n:g} N in force and "
                f"{1e3 * options.moment_sd_nm:g} N·mm in moment at best, whatever its length.",
            ),
        ),
        rmse=rmse,
        parameters=feet_parameters(session, estimates),
    )


def _pictures(
    fit: StaticInit,
    rows: StanceRows,
    errors: Sequence[StanceErrors],
    curve: Sequence[CurvePoint],
) -> tuple[Picture, ...]:
    import numpy as np

    from footcal_cli.plots.stand import plot_beliefs, plot_curve, plot_directions, plot_stances
    from footcal_cli.report import Picture

    seen = fit.observability
    value = np.concatenate([fit.gain, fit.bias_n])
    sd = np.sqrt(np.diag(fit.covariance))
    several = (
        Picture(
            "curve", lambda: plot_curve(curve),
            "CoP error on the next, held-out stance after one, two, five … stances: with the prior "
            "it falls; least squares without one needs many before it can be trusted.",
            title="Error on the next stance against the number of stances",
        ),
    )  # fmt: skip
    single = (
        Picture(
            "stances", lambda: plot_stances(errors),
            "Error of each stance before and after, and by least squares without a prior.",
            title="Error of each stance before and after",
        ),
    )  # fmt: skip
    return (
        *(several if curve else ()),
        *(single if errors[0].vgrf_n.size > 1 else ()),
        Picture(
            "directions", lambda: plot_directions(seen.singular_values, seen.rank),
            "What the stances see; grey directions keep the prior whatever the fit says.",
            title="How well each parameter direction is observed",
        ),
        Picture(
            "beliefs",
            lambda: plot_beliefs(
                rows.names, rows.units, rows.prior_sd, value, sd,
                [status == "estimated" for status in fit.estimates.status],
            ),
            "Where standing moved each gain and bias, in units of the prior sd; the band is ± 2.",
            title="Each parameter before and after standing",
        ),
    )  # fmt: skip
