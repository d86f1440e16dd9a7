"""``footcal offline-fit``: scale and bias of load cells from known weights (seed 1, 3.1)."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer
from pydantic import Field

from footcal_cli.commands.options import (
    Logs,
    Out,
    Overwrite,
    Quiet,
    RecipeFile,
    Seed,
    StrictFindings,
    begin,
)
from footcal_cli.recipe import CommandOptions

if TYPE_CHECKING:
    from footcal_cli.core.bench.regression import AffineFit, Curvature
    from footcal_cli.core.parameters import FloatArray
    from footcal_cli.core.quality import Finding
    from footcal_cli.records import ParametersRecord, RmseRecord, VerdictRecord
    from footcal_cli.report import Picture, Sheet
    from footcal_cli.session import Outcome, Session
    from footcal_cli.tables import Table

NEXT_RECORDING = (
    "Record next: a ladder of at least six loads up to the intended load and down again, one hold "
    "of five minutes at the top and one unloaded, the whole repeated three times, each cell alone."
)


class OfflineFitOptions(CommandOptions):
    """``[offline_fit]`` of a recipe."""

    method: Literal["ordinary", "weighted", "robust"] = "ordinary"
    intended_load_n: tuple[float, float] | None = None
    tolerance_percent: float = Field(default=1.0, gt=0)
    strict_findings: bool = False
    max_rmse_n: float | None = Field(default=None, gt=0)


def offline_fit(
    logs: Logs = None,
    recipe: RecipeFile = None,
    method: Annotated[
        str | None, typer.Option("--method", help="ordinary, weighted or robust regression.")
    ] = None,
    max_rmse_n: Annotated[
        float | None, typer.Option("--max-rmse-n", help="Gate: exit 1 above this RMSE.")
    ] = None,
    strict_findings: StrictFindings = None,
    out: Out = Path("out/offline-fit"),
    overwrite: Overwrite = False,
    seed: Seed = 0,
    quiet: Quiet = False,
) -> None:
    """Fit scale and bias of load cells to known weights."""
    session = begin(
        "offline-fit",
        OfflineFitOptions,
        logs=logs,
        recipe=recipe,
        out=out,
        overwrite=overwrite,
        seed=seed,
        quiet=quiet,
        method=method,
        max_rmse_n=max_rmse_n,
        strict_findings=strict_findings,
    )
    raise typer.Exit(session.finish(_calibrate_weights(session)))


def _calibrate_weights(session: Session[OfflineFitOptions]) -> Outcome:
    from footcal_cli.columns import weights_table
    from footcal_cli.commands.check import weights_findings
    from footcal_cli.core.bench.regression import fit_affine, pooled_curvature
    from footcal_cli.records import FindingRecord
    from footcal_cli.report import Report
    from footcal_cli.session import Outcome

    with session.step("read"):
        tables = session.read_required(weights_table())
    with session.step("fit"):
        fits = [
            fit_affine(channel, load_n, counts, session.options.method)
            for channel, load_n, counts in by_channel(tables)
        ]
        curvature = pooled_curvature(fits)
    tolerance_n = _tolerance_n(fits, session.options)
    findings = [
        *weights_findings(tables, session.recipe, session.options.intended_load_n),
        *_extrapolation(fits, session.options),
    ]
    with session.step("draw"):
        pictures = _pictures(fits, tolerance_n)
    verdict = _verdict(fits, curvature, tolerance_n)
    rmse = _rmse(fits)
    gates = _gates(session.options, rmse, findings, verdict.level)
    return Outcome(
        report=Report(
            title=f"Offline calibration of {session.recipe.robot.name}",
            verdict=verdict,
            pictures=pictures,
            sheets=(_parameter_sheet(fits), _residual_sheet(fits), _method_sheet(tables)),
            findings=tuple(FindingRecord.of(f) for f in findings),
            footer=(
                f"Model: F = scale · S + bias per channel, {session.options.method} regression of "
                "load on counts (seed 1, eqs. 1 and 2). Adequate: no residual above "
                f"{session.options.tolerance_percent:g} % of the largest load "
                f"({tolerance_n:.3g} N).",
            ),
        ),
        rmse=rmse,
        parameters=_parameters(session, fits),
        gates_missed=gates,
    )


def by_channel(tables: Sequence[Table]) -> list[tuple[str, FloatArray, FloatArray]]:
    """Channel, loads (n,) and counts (n,) over all logs, channels in order of appearance."""
    import numpy as np

    channel = np.concatenate([table.text("channel") for table in tables])
    load_n = np.concatenate([table.number("load_n") for table in tables])
    counts = np.concatenate([table.number("counts") for table in tables])
    names = list(dict.fromkeys(channel))
    return [(str(name), load_n[channel == name], counts[channel == name]) for name in names]


def _tolerance_n(fits: Sequence[AffineFit], options: OfflineFitOptions) -> float:
    largest = max(float(abs(fit.load_n).max()) for fit in fits)
    return options.tolerance_percent / 100.0 * largest


def _verdict(
    fits: Sequence[AffineFit], curvature: Curvature | None, tolerance_n: float
) -> VerdictRecord:
    from footcal_cli.records import VerdictRecord
    from footcal_cli.report import number

    bad = [f for f in fits if f.worst_n > tolerance_n or (f.lack_of_fit and f.lack_of_fit.p < 0.01)]
    if not bad:
        worst = max(fits, key=lambda fit: fit.worst_n)
        return VerdictRecord(
            level="good",
            sentence=f"A scale and a bias describe all {len(fits)} channels: largest error "
            f"{number(worst.worst_n, 2)} N ({worst.channel}).",
        )
    worst = max(bad, key=lambda fit: fit.worst_n)
    details = [_misfit_sentence(fit) for fit in sorted(bad, key=lambda fit: -fit.worst_n)]
    if curvature is not None and curvature.same_sign == len(curvature.bows):
        details.append(
            f"The curvature has the same sign in all {len(curvature.bows)} channels (sensitivity "
            f"{'falls' if curvature.mean > 0 else 'rises'} with load; mean bow "
            f"{100 * curvature.mean:.1f} % of the span, sign test p = {curvature.sign_p:.3f}): a "
            "shared cause, not noise of single channels. Without repeated loads it cannot be told "
            "whether that is nonlinearity, creep or the order of loading."
            if all(fit.lack_of_fit is None for fit in fits)
            else f"The curvature has the same sign in all {len(curvature.bows)} channels "
            f"(sign test p = {curvature.sign_p:.3f})."
        )
    details.append(NEXT_RECORDING)
    return VerdictRecord(
        level="warning",
        sentence=f"The affine model does not fit {len(bad)} of the {len(fits)} channels: errors up "
        f"to {number(worst.worst_n, 2)} N ({worst.channel}).",
        details=tuple(details),
    )


def _misfit_sentence(fit: AffineFit) -> str:
    from footcal_cli.report import number

    at = int(abs(fit.residual_n).argmax())
    load = float(fit.load_n[at])
    share = f" ({100 * abs(fit.residual_n[at]) / load:.0f} % of the load)" if load else ""
    text = f"{fit.channel}: {number(fit.residual_n[at], 2)} N at {number(load, 3)} N{share}"
    if fit.lack_of_fit is not None:
        text += f", lack of fit p = {fit.lack_of_fit.p:.1g}"
    return text


def _extrapolation(fits: Sequence[AffineFit], options: OfflineFitOptions) -> list[Finding]:
    from footcal_cli.core.quality import Finding

    if options.intended_load_n is None:
        return []
    highest = min(float(fit.load_n.max()) for fit in fits)
    intended = options.intended_load_n[1]
    if intended <= highest:
        return []
    return [
        Finding(
            "extrapolation", "warning", "all channels",
            f"cells are meant to carry {intended:.4g} N but were loaded to {highest:.4g} N "
            f"({intended / highest:.1f} times less)",
            "add weights up to the intended load; above the fitted range errors are unknown",
        )
    ]  # fmt: skip


def _gates(
    options: OfflineFitOptions, rmse: RmseRecord, findings: Sequence[Finding], level: str
) -> tuple[str, ...]:
    missed = []
    if options.strict_findings:
        serious = [f.code for f in findings if f.severity != "note"]
        if level != "good":
            serious.append("affine_inadequate")
        if serious:
            missed.append(f"strict findings: {', '.join(serious)}")
    if options.max_rmse_n is not None:
        over = [r for r in rmse.rows if r.stage == "after" and r.rmse > options.max_rmse_n]
        missed += [f"{r.quantity}: RMSE {r.rmse:.4g} N > {options.max_rmse_n:g} N" for r in over]
    return tuple(missed)


def _pictures(fits: Sequence[AffineFit], tolerance_n: float) -> tuple[Picture, ...]:
    from footcal_cli.plots.weights import (
        plot_loads_against_counts,
        plot_residuals,
        plot_scales,
    )
    from footcal_cli.report import Picture

    return (
        Picture(
            "residuals", plot_residuals(fits, tolerance_n),
            "Error left at each known load, one line per cell; lines that bend together share a "
            "cause. The blue band is what was asked.",
        ),
        Picture(
            "loads_against_counts", plot_loads_against_counts(fits, tolerance_n),
            "Known load against raw reading with the fitted line, and the error below it; orange "
            "channels leave the band.",
        ),
        Picture("scales", plot_scales(fits), "Cells of one type should have scales that agree."),
    )  # fmt: skip


def _parameter_sheet(fits: Sequence[AffineFit]) -> Sheet:
    from footcal_cli.report import Sheet, number, with_sd

    rows = [
        (
            fit.channel,
            with_sd(1e6 * fit.scale_n_per_count, 1e6 * float(fit.estimates.sd[0])),
            number(fit.bias_n, 7),
            f"{fit.zero_counts:,.0f}",
            number(fit.centre_sd_n, 2),
            number(fit.rmse_n, 3),
            number(fit.worst_n, 3),
            number(1e6 * fit.resolution_n, 3),
            number(fit.smallest_step_n, 3),
            f"{number(float(fit.load_n.min()), 3)} … {number(float(fit.load_n.max()), 3)}",
            str(fit.load_n.size),
        )
        for fit in fits
    ]
    return Sheet(
        "Calibration",
        ("channel", "scale (µN/count)", "bias (N)", "zero at (counts)", "sd at mid-load (N)",
         "RMSE (N)", "worst (N)", "µN per count", "smallest step (N)", "loads (N)", "n"),
        rows,
        note="± is one standard deviation from the residuals of the fit; parameters.json has the "
        "covariance of scale and bias, which are nearly collinear at these readings.",
    )  # fmt: skip


def _residual_sheet(fits: Sequence[AffineFit]) -> Sheet:
    from footcal_cli.report import Sheet, number

    rows = [
        (fit.channel, number(load, 4), f"{counts:,.0f}", number(error, 3),
         number(100 * error / load, 2) if load else "–")
        for fit in fits
        for load, counts, error in zip(fit.load_n, fit.counts, fit.residual_n, strict=True)
    ]  # fmt: skip
    shown = rows[:200]
    more = f" The first 200 of {len(rows)} rows." if len(rows) > len(shown) else ""
    return Sheet(
        "Residuals",
        ("channel", "load (N)", "counts", "measured − known (N)", "% of load"),
        shown,
        note=f"Residual of the affine fit.{more}",
    )


def _method_sheet(tables: Sequence[Table]) -> Sheet:
    from footcal_cli.core.bench.regression import fit_affine
    from footcal_cli.report import Sheet, number

    rows = []
    for channel, load_n, counts in by_channel(tables):
        ordinary = fit_affine(channel, load_n, counts, "ordinary")
        weighted = fit_affine(channel, load_n, counts, "weighted")
        robust = fit_affine(channel, load_n, counts, "robust")
        test = ordinary.lack_of_fit
        rows.append(
            (
                channel,
                *(number(1e6 * fit.scale_n_per_count, 6) for fit in (ordinary, weighted, robust)),
                f"{100 * ordinary.bow:.2f}",
                number(test.f, 3) if test else "no repeats",
                number(test.p, 2) if test else "–",
            )
        )
    return Sheet(
        "Checks of the model",
        ("channel", "ordinary (µN/count)", "weighted", "robust", "bow (% of span)",
         "lack of fit F", "p"),
        rows,
        note="Where ordinary, weighted and robust scales differ by more than their sd, single "
        "readings drive the fit.",
    )  # fmt: skip


def _rmse(fits: Sequence[AffineFit]) -> RmseRecord:
    import numpy as np

    from footcal_cli.records import RmseRecord, RmseRow

    def row(channel: str, stage: str, errors: FloatArray) -> RmseRow:
        return RmseRow(
            quantity=f"force {channel}", unit="N", stage=stage, reference="known load",
            split="all", rmse=float(np.sqrt(np.mean(errors**2))), n=errors.size,
        )  # fmt: skip

    # before: the cells taken as identical, with the fits' median scale and their own zero reading
    common = float(np.median([fit.scale_n_per_count for fit in fits]))
    rows = []
    for fit in fits:
        unloaded = fit.counts[np.argmin(np.abs(fit.load_n))]
        rows.append(row(fit.channel, "before", common * (fit.counts - unloaded) - fit.load_n))
        rows.append(row(fit.channel, "after", fit.residual_n))
    rows.append(row("all", "after", np.concatenate([fit.residual_n for fit in fits])))
    return RmseRecord(rows=tuple(rows))


def _parameters(session: Session[OfflineFitOptions], fits: Sequence[AffineFit]) -> ParametersRecord:
    from footcal_cli.records import (
        ParameterRecord,
        ParametersRecord,
        Range,
        covariance_blocks,
        parameter_records,
    )

    parameters: dict[str, ParameterRecord] = {}
    ranges: dict[str, dict[str, Range]] = {}
    for fit in fits:
        parameters |= parameter_records(fit.estimates)
        ranges[fit.channel] = {
            "load": Range(
                lowest=float(fit.load_n.min()), highest=float(fit.load_n.max()), unit="N"
            ),
            "reading": Range(
                lowest=float(fit.counts.min()), highest=float(fit.counts.max()), unit="count"
            ),
        }
    return ParametersRecord(
        command="offline-fit",
        created=session.created(),
        robot=session.recipe.robot.name,
        gravity_mps2=session.recipe.robot.gravity_mps2,
        sign_convention="force = scale * counts + bias, positive when the cell is pressed",
        frame="each cell's own axis",
        expressed_at="the cell",
        parameters=parameters,
        covariance=covariance_blocks(*(fit.estimates for fit in fits)),
        fitted_range=ranges,
        inputs=session.inputs,
    )
