"""``footcal online-replay``: self-calibration along a recorded walk ([NAO], 3.3.2)."""

from __future__ import annotations

from collections.abc import Callable
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
from footcal_cli.recipe import CommandOptions, Frozen, metres

if TYPE_CHECKING:
    from footcal_cli.core.online.comparison import Comparison
    from footcal_cli.intake.recordings import Recording
    from footcal_cli.session.session import Outcome, Session

Method = Literal["memory", "window", "static"]


class NoiseOptions(Frozen):
    """``[online_replay.noise]``: what the innovations need not tell; absent ones are learnt."""

    force_n: float | None = Field(default=None, gt=0)
    moment_nm: float | None = Field(default=None, gt=0)
    force_slow_n: float | None = Field(default=None, gt=0)
    moment_slow_nm: float | None = Field(default=None, gt=0)
    force_slow_s: float | None = Field(default=None, gt=0)
    moment_slow_s: float | None = Field(default=None, gt=0)
    jitter_s: float | None = Field(default=None, gt=0)
    swing_n: float | None = Field(default=None, gt=0)
    swing_slow_n: float | None = Field(default=None, gt=0)
    swing_slow_s: float | None = Field(default=None, gt=0)
    swing_fixed_n: float | None = Field(default=None, ge=0)
    swing_fixed_s: float | None = Field(default=None, gt=0)
    gain_walk: float | None = Field(default=None, gt=0)
    bias_walk_n: float | None = Field(default=None, gt=0)
    state_walk: float | None = Field(default=None, gt=0)


class OnlineReplayOptions(CommandOptions):
    """``[online_replay]`` of a recipe.

    `picture_span_s` says which part of the walk the figures show, from its first sample. `compare`
    runs all methods; `sensitivity` scales every setting of them, with `compare` unless
    it is said.
    """

    method: Method = "memory"
    delay_s: float = 0.02
    cutoff_hz: float = Field(default=10.0, gt=0)
    causal: bool = False
    min_force_n: float = Field(default=5.0, gt=0)
    largest_acceleration_mps2: float = Field(default=8.0, gt=0)
    update_hz: float = Field(default=20.0, gt=0)
    window_s: float = Field(default=0.5, gt=0)
    foot_length_m: float = Field(default=0.16, gt=0)
    force_weight: float | None = Field(default=None, gt=0)
    cop_weight: float | None = Field(default=None, gt=0)
    smooth_weight: float | None = Field(default=None, gt=0)
    states: tuple[str, ...] = (
        "robot.delay",
        "robot.com_correction_x",
        "robot.com_correction_y",
        "robot.angmom_loss",
    )
    hanging_plate: bool = True
    swing_rows: bool = True
    align_delay: bool = True
    scales: bool | None = None
    noise: NoiseOptions = NoiseOptions()
    compare: bool = False
    sensitivity: bool | None = None
    picture_span_s: tuple[float, float] | None = None
    baseline: str | None = None
    truth: str | None = None
    max_cop_rmse_mm: float | None = Field(default=None, gt=0)
    max_vgrf_rmse_n: float | None = Field(default=None, gt=0)

    @property
    def limits(self) -> dict[str, float | None]:
        """Limits of `max_…`, by quantity, SI units."""
        return {"cop": metres(self.max_cop_rmse_mm), "vgrf": self.max_vgrf_rmse_n}


def online_replay(
    logs: Logs = None,
    recipe: RecipeFile = None,
    parameters: ParametersFile = None,
    method: Annotated[
        str | None,
        typer.Option(
            "--method",
            help="memory, window (sliding Gauss-Newton) or static (zero acceleration, after Han).",
        ),
    ] = None,
    compare: Annotated[
        bool | None,
        typer.Option("--compare", help="Run all methods and how much their settings matter."),
    ] = None,
    delay_s: Annotated[
        float | None, typer.Option("--delay-s", help="Delay of the body stream to compensate.")
    ] = None,
    causal: Annotated[
        bool | None,
        typer.Option("--causal", help="Filter, learn and find contact from the past only."),
    ] = None,
    baseline: Annotated[
        str | None,
        typer.Option("--baseline", metavar="FILE.json", help="Calibration to compare with."),
    ] = None,
    truth: Annotated[
        str | None,
        typer.Option("--truth", metavar="FILE", help="True cell forces, to compare with."),
    ] = None,
    max_cop_rmse_mm: Annotated[
        float | None,
        typer.Option("--max-cop-rmse-mm", help="Gate: exit 1 above this CoP error."),
    ] = None,
    max_vgrf_rmse_n: Annotated[
        float | None,
        typer.Option("--max-vgrf-rmse-n", help="Gate: exit 1 above this force error."),
    ] = None,
    reference: ReferenceFile = None,
    strict_findings: StrictFindings = None,
    out: Out = Path("out/online-replay"),
    overwrite: Overwrite = False,
    seed: Seed = 0,
    no_pictures: NoPictures = False,
    quiet: Quiet = False,
) -> None:
    """Track scales and biases of foot sensors along a recorded walk."""
    session = begin(
        "online-replay",
        OnlineReplayOptions,
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
        compare=compare,
        delay_s=delay_s,
        causal=causal,
        baseline=baseline,
        truth=truth,
        max_cop_rmse_mm=max_cop_rmse_mm,
        max_vgrf_rmse_n=max_vgrf_rmse_n,
    )
    raise typer.Exit(session.finish(_replay(session)))


def _replay(session: Session[OnlineReplayOptions]) -> Outcome:
    from footcal_cli.core.online.streams import MergeRule
    from footcal_cli.errors import UsageError
    from footcal_cli.intake.recordings import read_recordings
    from footcal_cli.intake.walk_length import is_long_walk

    options = session.options
    rule = MergeRule(
        delay_s=options.delay_s,
        cutoff_hz=options.cutoff_hz,
        causal=options.causal,
        largest_acc_mps2=options.largest_acceleration_mps2,
        min_force_n=options.min_force_n,
    )
    if _in_parts(options) and is_long_walk(session):
        from footcal_cli.commands.parts.long_replay import replay_long

        return replay_long(session, rule)
    with session.step("read"):
        recordings = read_recordings(session, rule, "walk")
    if len(recordings) > 1:
        raise UsageError(
            f"{len(recordings)} walks given, one is replayed at a time",
            remedy="name one sensor log and its body log, or use batch for many",
        )
    if recordings[0].belief is None:
        if options.method != "memory":
            raise UsageError(
                f"method '{options.method}' knows load cells only", remedy="use --method memory"
            )
        return _six_axis(session, recordings[0])
    return _cells(session, recordings[0])


def _in_parts(options: OnlineReplayOptions) -> bool:
    """Whether a long walk may run in parts; what compares methods or spans needs all of it."""
    whole = options.compare or options.sensitivity or options.picture_span_s is not None
    return options.method == "memory" and not whole


def _cells(session: Session[OnlineReplayOptions], recording: Recording) -> Outcome:
    import numpy as np
    import pandas as pd

    from footcal_cli.commands.parts.feet_parameters import feet_parameters
    from footcal_cli.commands.parts.replay_settings import baseline_of, settings_of, truth_of
    from footcal_cli.core.online.comparison import compare
    from footcal_cli.core.online.memory import memory_estimates
    from footcal_cli.core.online.windows import QUIET_S
    from footcal_cli.errors import DataError
    from footcal_cli.records.results import FindingRecord
    from footcal_cli.report import Report
    from footcal_cli.session.session import Outcome
    from footcal_cli.sheets import walk as sheets
    from footcal_cli.sheets.streams import stream_findings
    from footcal_cli.tables.table import write_parquet, write_parquet_pieces

    options, merged, belief = session.options, recording.merged, recording.belief
    assert belief is not None
    settings = settings_of(options, merged, belief, session.recipe.robot.weight_n or 53.0)
    truth_n, baseline = truth_of(session, merged.log.time_s, belief.channels), baseline_of(session)
    with session.step("replay"):
        found: Comparison = compare(
            merged, belief, settings, truth_n=truth_n, baseline=baseline,
            rng=np.random.default_rng(session.request.seed),
        )  # fmt: skip
    if options.method not in found.replayed:
        raise DataError(
            f"method '{options.method}' takes its weights from standing still, and this log starts "
            f"with less than {QUIET_S} s of it",
            remedy="record half a second of standing before the first step, or give force_weight "
            "and cop_weight in [online_replay]",
        )
    with session.step("evidence"):
        wanted = options.compare if options.sensitivity is None else options.sensitivity
        curves = found.sensitivity() if wanted else []
    pictures = sheets.pictures_of(found, curves, session.recipe.robot, options.picture_span_s)
    rmse = sheets.rmse_of(found)
    estimates = (
        memory_estimates(found.memory, belief)
        if options.method == "memory"
        else found.window_estimates(options.method)
    )
    findings = [*stream_findings(recording), *map(FindingRecord.of, found.findings())]

    def write(path: Path) -> None:
        write_parquet_pieces(sheets.frames_of(found), path)

    extra: dict[str, Callable[[Path], None]] = {}
    if curves:
        extra["sensitivity.parquet"] = lambda path: write_parquet(
            pd.DataFrame(sheets.sensitivity_frame(curves)), path
        )
    return Outcome(
        report=Report(
            title=f"Walking calibration of {session.recipe.robot.name}, {recording.name}",
            verdict=sheets.verdict_of(found, options.method),
            pictures=pictures,
            sheets=sheets.sheets_of(found),
            findings=tuple(findings),
            footer=sheets.footer_of(found, options.delay_s),
        ),
        rmse=rmse,
        parameters=feet_parameters(session, estimates),
        files={"replay.parquet": write, **extra},
        stage=options.method,
        reference=found.best_reference,
    )


def _six_axis(session: Session[OnlineReplayOptions], recording: Recording) -> Outcome:
    from footcal_cli.commands.parts.feet_parameters import feet_parameters
    from footcal_cli.core.online.six_axis_replay import replay_six_axis
    from footcal_cli.report import Report
    from footcal_cli.session.session import Outcome
    from footcal_cli.sheets import six_axis_walk as sheets
    from footcal_cli.sheets.streams import stream_findings
    from footcal_cli.tables.table import write_parquet

    options, merged = session.options, recording.merged
    with session.step("replay"):
        found = replay_six_axis(
            merged,
            samples_per_update=max(round(merged.rate_hz / options.update_hz), 1),
            scales=options.scales,
        )
    pictures = sheets.pictures_of(found)
    return Outcome(
        report=Report(
            title=f"Walking calibration of {session.recipe.robot.name}, {recording.name}",
            verdict=sheets.verdict_of(found),
            pictures=pictures,
            sheets=sheets.sheets_of(found),
            findings=(*stream_findings(recording), *sheets.findings_of(found)),
            footer=sheets.footer_of(found),
        ),
        rmse=sheets.rmse_of(found),
        stage="memory",
        parameters=feet_parameters(session, found.estimates),
        files={"replay.parquet": lambda path: write_parquet(sheets.frame_of(found), path)},
    )
