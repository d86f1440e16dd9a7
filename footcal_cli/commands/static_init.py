"""``footcal static-init``: scale and bias of foot cells from quiet standing (seed 1, 3.3.1)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from pydantic import Field

from footcal_cli.commands.options import (
    Logs,
    Out,
    Overwrite,
    ParametersFile,
    Quiet,
    RecipeFile,
    Seed,
    begin,
)
from footcal_cli.recipe import CommandOptions

if TYPE_CHECKING:
    from footcal_cli.core.observability import NextStep
    from footcal_cli.core.parameters import Estimates
    from footcal_cli.core.quiet import QuietSet
    from footcal_cli.core.static_init import StanceErrors, StanceRows, StaticInit
    from footcal_cli.intake import Recording
    from footcal_cli.records import FindingRecord, ParametersRecord, RmseRecord
    from footcal_cli.report import Picture
    from footcal_cli.session import Outcome, Session


BELIEFS_NOTE = (
    "Gain in per cent and bias in newtons on top of the prior; parameters.json has scale and bias "
    "of the raw counts. Estimated: standing at least halved the sd. The others keep their prior "
    "and were moved only as far as sums over cells ask."
)


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
    out: Out = Path("out/static-init"),
    overwrite: Overwrite = False,
    seed: Seed = 0,
    quiet: Quiet = False,
) -> None:
    """Find scales and biases of foot cells from quiet standing, as far as it shows them."""
    session = begin(
        "static-init",
        StaticInitOptions,
        logs=logs,
        recipe=recipe,
        parameters=parameters,
        out=out,
        overwrite=overwrite,
        seed=seed,
        quiet=quiet,
        until_s=until_s,
        max_cop_rmse_mm=max_cop_rmse_mm,
    )
    raise typer.Exit(session.finish(_stand(session)))


def _stand(session: Session[StaticInitOptions]) -> Outcome:
    from footcal_cli.core.online.streams import MergeRule
    from footcal_cli.intake import is_six_axis_robot, read_recordings

    options = session.options
    rule = MergeRule(delay_s=options.delay_s, cutoff_hz=options.cutoff_hz)
    with session.step("read"):
        recordings = read_recordings(
            session, rule, "stand", body_needed=is_six_axis_robot(session.recipe.robot)
        )
    if recordings[0].belief is None:
        return _six_axis(session, recordings)
    return _cells(session, recordings)


def _cells(session: Session[StaticInitOptions], recordings: Sequence[Recording]) -> Outcome:
    import numpy as np

    from footcal_cli.core.static_init import fit_static, stance_errors, stance_rows
    from footcal_cli.report import Report
    from footcal_cli.session import Outcome
    from footcal_cli.sheets import stand as sheets

    options, robot = session.options, session.recipe.robot
    belief = recordings[0].belief
    assert belief is not None
    with session.step("fit"):
        rows, quiet = _all_stances(
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
        menu = _menu(recordings, quiet, rows, weight_n)
    estimates = fit.estimates
    rmse = sheets.rmse_of(errors, quiet)
    gates = _gates(options, rmse)
    return Outcome(
        report=Report(
            title=f"Standing calibration of {robot.name}",
            verdict=sheets.verdict_of(fit, errors, menu),
            pictures=_pictures(fit, rows, errors),
            sheets=(
                sheets.beliefs_sheet(
                    rows.names,
                    rows.units,
                    np.concatenate([fit.gain, fit.bias_n]),
                    np.sqrt(np.diag(fit.covariance)),
                    rows.prior_sd,
                    estimates.status,
                    BELIEFS_NOTE,
                ),
                sheets.directions_sheet(fit.observability),
                *((sheets.menu_sheet(menu),) if menu else ()),
                sheets.stances_sheet(errors, rows.effective_samples),
            ),
            findings=_findings(recordings, fit),
            footer=(
                "Model: Σ(1 + γ)F⁰ + β per cell against weight and projected CoM (seed 1, eqs. 12, "
                "13), maximum a posteriori in centred units; the prior is --parameters or the "
                "nameplate.",
                f"A stance counts {options.force_sd_n:g} N in force and "
                f"{1e3 * options.moment_sd_nm:g} N·mm in moment at best, whatever its length.",
            ),
        ),
        rmse=rmse,
        parameters=_parameters(session, estimates),
        gates_missed=gates,
    )


def _six_axis(session: Session[StaticInitOptions], recordings: Sequence[Recording]) -> Outcome:
    import numpy as np

    from footcal_cli.core.static_init import fit_static_six_axis, six_axis_stance_rows
    from footcal_cli.plots.stand import plot_beliefs, plot_directions
    from footcal_cli.records import VerdictRecord
    from footcal_cli.report import Picture, Report
    from footcal_cli.session import Outcome
    from footcal_cli.sheets import stand as sheets

    with session.step("fit"):
        rows, quiet = _all_stances(
            session,
            recordings,
            lambda recording, chosen: six_axis_stance_rows(recording.merged.log, chosen),
        )
        fit = fit_static_six_axis(rows)
    known = sum(status == "estimated" for status in fit.estimates.status)
    seen = fit.observability
    everything = known == len(fit.estimates.status)
    return Outcome(
        report=Report(
            title=f"Standing calibration of {session.recipe.robot.name}",
            verdict=VerdictRecord(
                level="good" if everything else "warning",
                sentence=f"{_counted(quiet)} of six-axis feet show {seen.rank} of "
                f"{seen.unknowns} unknowns; {known} estimated, the others keep their prior.",
                details=(
                    "With both feet down only sums over the feet are seen: lift each foot once, or "
                    "walk (online-replay), to tell their offsets apart.",
                    f"Not seen: {'; '.join(seen.weakest(3))}.",
                ),
            ),
            pictures=(
                Picture(
                    "beliefs",
                    plot_beliefs(
                        rows.names, rows.units, rows.prior_sd, fit.estimates.values,
                        fit.estimates.sd, [s == "estimated" for s in fit.estimates.status],
                    ),
                    "Offsets against the prior of zero; grey ones were not told by standing.",
                ),
                Picture(
                    "directions", plot_directions(seen.singular_values, seen.rank),
                    "How well each direction is seen.",
                ),
            ),
            sheets=(
                sheets.beliefs_sheet(
                    rows.names, rows.units, fit.estimates.values, fit.estimates.sd, rows.prior_sd,
                    fit.estimates.status, BELIEFS_NOTE,
                ),
                sheets.directions_sheet(seen),
            ),
            findings=_findings(recordings, None),
            footer=(f"chi² {fit.chi2:.3g} for {fit.dof} rows.",),
        ),
        rmse=sheets.offset_rmse_of(rows, np.asarray(fit.estimates.values), quiet),
        parameters=_parameters(session, fit.estimates),
    )  # fmt: skip


def _all_stances(
    session: Session[StaticInitOptions],
    recordings: Sequence[Recording],
    rows_of: Callable[[Recording, QuietSet], StanceRows],
) -> tuple[StanceRows, list[QuietSet]]:
    """Rows of the stances of all logs, one after the other."""
    from dataclasses import replace

    import numpy as np

    from footcal_cli.core.quiet import QuietRule, select_quiet

    options = session.options
    rule = QuietRule(
        warm_s=options.warm_s,
        acceleration_mps2=options.largest_acceleration_mps2,
        rate_radps=options.largest_rate_radps,
        least_samples=options.least_samples,
    )
    parts, quiet, offset = [], [], 0
    for recording in recordings:
        recording = _shortened(recording, options.until_s)
        log = recording.merged.log
        forces = (
            recording.belief.forces(log.readings) if recording.belief is not None else log.readings
        )
        chosen = select_quiet(log, forces, gyro_radps=recording.merged.imu_gyro_radps, rule=rule)
        part = rows_of(recording, chosen)
        parts.append(replace(part, stance=part.stance + offset))
        offset += chosen.stances
        quiet.append(chosen)
    first = parts[0]
    joined = replace(
        first,
        h=np.concatenate([p.h for p in parts]),
        error=np.concatenate([p.error for p in parts]),
        sd=np.concatenate([p.sd for p in parts]),
        output=tuple(name for p in parts for name in p.output),
        stance=np.concatenate([p.stance for p in parts]),
        effective_samples=np.concatenate([p.effective_samples for p in parts]),
    )
    return joined, quiet


def _shortened(recording: Recording, until_s: float | None) -> Recording:
    """The first seconds of a recording."""
    from dataclasses import replace

    import numpy as np

    if until_s is None:
        return recording
    log = recording.merged.log
    stop = int(np.searchsorted(log.time_s, log.time_s[0] + until_s))
    merged = replace(
        recording.merged,
        log=log.rows(0, stop),
        imu_gyro_radps=(
            None
            if recording.merged.imu_gyro_radps is None
            else recording.merged.imu_gyro_radps[:stop]
        ),
    )
    return replace(recording, merged=merged)


def _counted(quiet: Sequence[QuietSet]) -> str:
    count = sum(one.stances for one in quiet)
    return f"{count} stance" + ("s" if count > 1 else "")


def _menu(
    recordings: Sequence[Recording], quiet: Sequence[QuietSet], rows: StanceRows, weight_n: float
) -> list[NextStep]:
    """What to stand like next, from the last stance; nothing where its feet are unknown."""
    import numpy as np

    from footcal_cli.core.effects.contract import Scope, columns_of
    from footcal_cli.core.next_stance import next_stances

    last = recordings[-1]
    if last.no_body or last.belief is None:
        return []
    inside = quiet[-1].stance == quiet[-1].stances - 1
    cells = np.nanmean(last.merged.log.known["cell_pos_m"][inside], axis=0)
    feet = [[int(i) for i in c] for c in columns_of(Scope.FOOT, last.merged.log.channels)]
    return next_stances(rows, cells, feet, last.feet, weight_n, last.belief)


def _pictures(
    fit: StaticInit, rows: StanceRows, errors: Sequence[StanceErrors]
) -> tuple[Picture, ...]:
    import numpy as np

    from footcal_cli.plots.stand import plot_beliefs, plot_directions, plot_stances
    from footcal_cli.report import Picture

    seen = fit.observability
    value = np.concatenate([fit.gain, fit.bias_n])
    sd = np.sqrt(np.diag(fit.covariance))
    return (
        Picture(
            "stances", plot_stances(errors),
            "Error of each stance before and after, and by least squares without a prior.",
        ),
        Picture(
            "directions", plot_directions(seen.singular_values, seen.rank),
            "What the stances see; grey directions keep the prior whatever the fit says.",
        ),
        Picture(
            "beliefs",
            plot_beliefs(
                rows.names, rows.units, rows.prior_sd, value, sd,
                [status == "estimated" for status in fit.estimates.status],
            ),
            "Where standing moved each gain and bias, in units of the prior sd; the band is ± 2.",
        ),
    )  # fmt: skip


def _findings(recordings: Sequence[Recording], fit: StaticInit | None) -> tuple[FindingRecord, ...]:
    from footcal_cli.records import FindingRecord
    from footcal_cli.sheets.streams import stream_findings

    found = [f for recording in recordings for f in stream_findings(recording)]
    if recordings[0].no_body:
        found.append(
            FindingRecord(
                code="no_body", severity="warning", where="log",
                sentence="without a body stream only the total weight is known, not the CoP",
                remedy="log the CoM and the feet's poses beside the cells",
            )
        )  # fmt: skip
    if fit is not None and fit.dof and fit.chi2 > 3.0 * fit.dof:
        found.append(
            FindingRecord(
                code="misfit", severity="warning", where="stances",
                sentence=f"the residual is {(fit.chi2 / fit.dof) ** 0.5:.1f} times what noise and "
                "prior allow",
                remedy="check mass, CoM, cell positions and gains; run diagnose on this log",
            )
        )  # fmt: skip
    return tuple(found)


def _gates(options: StaticInitOptions, rmse: RmseRecord) -> tuple[str, ...]:
    if options.max_cop_rmse_mm is None:
        return ()
    split = "held_out" if any(r.split == "held_out" for r in rmse.rows) else "all"
    return tuple(
        f"{r.quantity}: RMSE {1e3 * r.rmse:.3g} mm > {options.max_cop_rmse_mm:g} mm"
        for r in rmse.rows
        if r.stage == "after"
        and r.split == split
        and r.quantity.startswith("cop")
        and 1e3 * r.rmse > options.max_cop_rmse_mm
    )


def _parameters(session: Session[StaticInitOptions], estimates: Estimates) -> ParametersRecord:
    from footcal_cli.records import ParametersRecord, covariance_blocks, parameter_records

    robot = session.recipe.robot
    six_axis = not any(foot.cells for foot in robot.feet.values())
    return ParametersRecord(
        command="static-init",
        created=session.created(),
        robot=robot.name,
        gravity_mps2=robot.gravity_mps2,
        sign_convention=(
            "reading = applied wrench + offset"
            if six_axis
            else "force = scale * counts + bias, positive when the cell is pressed"
        ),
        frame="each transducer's axes" if six_axis else "each cell's own axis",
        expressed_at="the transducer" if six_axis else "the cell",
        parameters=parameter_records(estimates),
        covariance=covariance_blocks(estimates),
        inputs=session.inputs,
    )
