"""``footcal offline-fit``: the bench calibration, weights and placements ([NAO], section 3.1)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
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
from footcal_cli.tables.columns import weights_table

if TYPE_CHECKING:
    from footcal_cli.commands.parts.bench_report import Part
    from footcal_cli.core.bench.cop_study import FootStudy
    from footcal_cli.core.bench.matrix import MatrixStudy
    from footcal_cli.core.bench.plateaus import PlateauOptions
    from footcal_cli.core.bench.record import BenchRecord
    from footcal_cli.core.bench.study import ChannelStudy
    from footcal_cli.core.quality import Finding
    from footcal_cli.session.session import Outcome, Session
    from footcal_cli.tables.table import Table


class PlateauSettings(Frozen):
    """``[offline_fit.plateaus]``: what counts as standing still in a running recording.

    Tolerances that are 0 are chosen from the recording. `loads` names the loads in the order in
    which they were put on, with their unit (``"0, 1, 2, 5 lb"``), where the recording does not have
    them; `loads_n` is the same in N.
    """

    window_s: float = Field(default=2.0, gt=0)
    min_hold_s: float = Field(default=3.0, gt=0)
    settle_s: float = Field(default=0.0, ge=0)
    max_change: float = Field(default=0.0, ge=0)
    max_scatter: float = Field(default=0.0, ge=0)
    same_level: float = Field(default=0.02, ge=0)
    glitch_sd: float = Field(default=8.0, gt=0)
    loads_n: tuple[float, ...] = ()
    loads: str = ""

    @property
    def tolerances(self) -> PlateauOptions:
        """What the core takes for standing still."""
        from footcal_cli.core.bench.plateaus import PlateauOptions

        return PlateauOptions(**self.model_dump(exclude={"loads_n", "loads"}))

    def known_n(self, gravity_mps2: float) -> tuple[float, ...]:
        """The loads in N, masses as their weight."""
        if not self.loads:
            return self.loads_n
        from footcal_cli.tables.units import load_list

        return load_list(self.loads, gravity_mps2)


class OfflineFitOptions(CommandOptions):
    """``[offline_fit]`` of a recipe."""

    method: Literal["ordinary", "weighted", "robust"] = "ordinary"
    models: Literal["auto", "affine"] = "auto"
    most_degree: int = Field(default=3, ge=1, le=6)
    samples: bool | None = None
    plateaus: PlateauSettings = PlateauSettings()
    known_wrench: bool = False
    held_out_placements: tuple[str, ...] = ()
    min_force_n: float = Field(default=5.0, gt=0)
    intended_load_n: tuple[float, float] | None = None
    tolerance_percent: float = Field(default=1.0, gt=0)
    max_rmse_n: float | None = Field(default=None, gt=0)
    max_cop_rmse_mm: float | None = Field(default=None, gt=0)

    @property
    def limits(self) -> dict[str, float | None]:
        """Limits of `max_…`, by quantity, SI units."""
        return {"force *": self.max_rmse_n, "cop *": metres(self.max_cop_rmse_mm)}


def offline_fit(
    logs: Logs = None,
    recipe: RecipeFile = None,
    parameters: ParametersFile = None,
    method: Annotated[
        str | None, typer.Option("--method", help="ordinary, weighted or robust regression.")
    ] = None,
    models: Annotated[
        str | None, typer.Option("--models", help="auto: beyond affine where it pays; affine.")
    ] = None,
    max_rmse_n: Annotated[
        float | None, typer.Option("--max-rmse-n", help="Gate: exit 1 above this RMSE.")
    ] = None,
    max_cop_rmse_mm: Annotated[
        float | None,
        typer.Option("--max-cop-rmse-mm", help="Gate on the CoP at left-out placements."),
    ] = None,
    reference: ReferenceFile = None,
    strict_findings: StrictFindings = None,
    out: Out = Path("out/offline-fit"),
    overwrite: Overwrite = False,
    seed: Seed = 0,
    no_pictures: NoPictures = False,
    quiet: Quiet = False,
) -> None:
    """Fit load cells to known weights, and a foot's CoP to weights over known holes."""
    session = begin(
        "offline-fit",
        OfflineFitOptions,
        logs=logs,
        recipe=recipe,
        parameters=parameters,
        reference=reference,
        out=out,
        overwrite=overwrite,
        seed=seed,
        quiet=quiet,
        no_pictures=no_pictures,
        method=method,
        models=models,
        max_rmse_n=max_rmse_n,
        max_cop_rmse_mm=max_cop_rmse_mm,
        strict_findings=strict_findings,
    )
    raise typer.Exit(session.finish(_calibrate(session)))


def _calibrate(session: Session[OfflineFitOptions]) -> Outcome:
    """Weights first, then the placements that need their calibration."""
    from footcal_cli.commands.parts.bench_outcome import outcome_of
    from footcal_cli.commands.parts.bench_report import feet_part, together_part, weights_part

    with session.step("read"):
        logs = _read(session)
    with session.step("fit"):
        studies = _studies(session, logs.records) if logs.records else ()
        together = _together(session)
        feet = _feet(session, studies)
    if not studies and not feet and together is None:
        session.read_required(weights_table())
    parts = []
    if studies:
        parts.append(
            weights_part(
                studies,
                logs.held_out,
                findings=_findings(session, logs, studies),
                intended_load_n=session.options.intended_load_n,
                tolerance_percent=session.options.tolerance_percent,
                method=session.options.method,
            )
        )
    if together is not None:
        parts.append(together_part(session.recipe.robot.cell_names, *together))
    if feet:
        parts.append(feet_part(feet, session.recipe.robot))
    estimates = [study.estimates for study in studies]
    if together is not None:
        estimates.append(together[1].chosen.estimates)
    return outcome_of(session, parts, studies, estimates, feet, _inadequate(session.options, parts))


@dataclass(frozen=True)
class _WeightsLogs:
    """Everything weighed: long tables, and the records to fit and to keep apart."""

    tables: Sequence[Table]
    records: Sequence[BenchRecord]
    held_out: Sequence[BenchRecord]


def _read(session: Session[OfflineFitOptions]) -> _WeightsLogs:
    from footcal_cli.commands.parts.bench_logs import records_of_rows, records_of_streams
    from footcal_cli.tables.columns import weights_stream_table

    channels = session.recipe.robot.cell_names
    tables = session.read(weights_table())
    records = records_of_rows(tables) if tables else []
    held_out = []
    if not session.request.logs:
        apart = session.read(weights_table(), "weights_held_out")
        held_out += records_of_rows(apart) if apart else []
    if channels:
        stream = weights_stream_table(channels)
        running = session.read(stream)
        records += records_of_streams(running, channels) if running else []
        apart = [] if session.request.logs else session.read(stream, "weights_stream_held_out")
        held_out += records_of_streams(apart, channels) if apart else []
    return _WeightsLogs(tables, records, held_out)


def _studies(
    session: Session[OfflineFitOptions], records: Sequence[BenchRecord]
) -> Sequence[ChannelStudy]:
    from footcal_cli.core.bench.pooled import with_common_noise

    gravity_mps2 = session.recipe.robot.gravity_mps2
    return with_common_noise([_study(r, session.options, gravity_mps2) for r in records])


def _study(record: BenchRecord, options: OfflineFitOptions, gravity_mps2: float) -> ChannelStudy:
    from footcal_cli.commands.parts.bench_logs import is_recording
    from footcal_cli.core.bench.study import study_rows, study_samples

    extend = options.models == "auto"
    dense = is_recording(record) if options.samples is None else options.samples
    if not dense:
        return study_rows(record, options.method, extend=extend, most_degree=options.most_degree)
    return study_samples(
        record,
        options.method,
        options=options.plateaus.tolerances,
        loads_n=options.plateaus.known_n(gravity_mps2),
        extend=extend,
        most_degree=options.most_degree,
    )


def _together(session: Session[OfflineFitOptions]) -> tuple[tuple[str, ...], MatrixStudy] | None:
    """Matrices of cells loaded together, None without such a log."""
    from footcal_cli.commands.parts.bench_logs import study_together
    from footcal_cli.core.plausibility import check_scale
    from footcal_cli.tables.columns import weights_together_table

    channels, wrench = session.recipe.robot.cell_names, session.options.known_wrench
    if not channels:
        return None
    tables = session.read(weights_together_table(channels, known_wrench=wrench))
    if not tables:
        return None
    study = study_together(tables, channels, known_wrench=wrench)
    estimates, nameplate = study[1].chosen.estimates, session.recipe.robot.nameplate
    for cell in channels:
        if f"{cell}.scale" in estimates.names:
            own = estimates[f"{cell}.scale"]
            session.note(check_scale(cell, own, nameplate.scale_n_per_count))
    return study


def _feet(session: Session[OfflineFitOptions], studies: Sequence[ChannelStudy]) -> list[FootStudy]:
    """Corrections of every foot with placements, and of instruments that report a CoP."""
    import numpy as np

    from footcal_cli.commands.parts.bench_logs import read_cop_points, read_placements, study_foot
    from footcal_cli.core.plausibility import check_shares
    from footcal_cli.errors import UsageError, nearest
    from footcal_cli.tables.columns import cop_points_table, placements_table

    robot, options = session.recipe.robot, session.options
    cells = next((tuple(foot.cells) for foot in robot.feet.values() if foot.cells), ())
    logs, apart = {}, {}
    if cells:
        calibration = _calibration(session, studies)
        table = placements_table(cells)
        if tables := session.read(table):
            logs = read_placements(tables, robot, calibration, options.min_force_n)
        held = [] if session.request.logs else session.read(table, "placements_held_out")
        if held:
            apart = read_placements(held, robot, calibration, options.min_force_n)
    if tables := session.read(cop_points_table()):
        logs["instrument"] = read_cop_points(tables)
    names = {str(name) for log in logs.values() for name in log.names}
    for name in options.held_out_placements:
        if name not in names:
            raise UsageError(
                f"held_out_placements: no placement '{name}'{nearest(name, names)}",
                file=session.recipe.path, remedy="name placements as the log does",
            )  # fmt: skip
    found = []
    for foot, log in logs.items():
        rows = log.rows
        session.note(check_shares(rows.forces_n, rows.cells, rows.load_n, calibrated=True))
        out = np.isin(log.names.astype(str), options.held_out_placements)
        study = study_foot(foot, log, out)
        found.append(replace(study, held_out=apart[foot].rows) if foot in apart else study)
    return found


def _calibration(
    session: Session[OfflineFitOptions], studies: Sequence[ChannelStudy]
) -> dict[str, tuple[float, float]]:
    """Scale and bias per channel: of this run's weights, else of --parameters."""
    from footcal_cli.commands.parts.bench_logs import calibrated_cells

    found = {} if session.parameters is None else calibrated_cells(session.parameters)
    for study in studies:
        estimates = study.estimates
        found[study.channel] = (
            estimates[f"{study.channel}.scale"], estimates[f"{study.channel}.bias"],
        )  # fmt: skip
    return found


def _findings(
    session: Session[OfflineFitOptions], logs: _WeightsLogs, studies: Sequence[ChannelStudy]
) -> list[Finding]:
    from footcal_cli.core.plausibility import check_scale
    from footcal_cli.session.inspection import weights_findings
    from footcal_cli.sheets.weights import find_extrapolation, moving_findings

    nameplate = session.recipe.robot.nameplate.scale_n_per_count
    for study in studies:  # those whose loads stand in the recipe, not in the log
        known = any(f.where == study.channel and f.severity == "alarm" for f in session.noted)
        scale = study.estimates[f"{study.channel}.scale"]
        session.note(moving_findings(study))
        session.note([] if known else check_scale(study.channel, scale, nameplate))
    intended, robot = session.options.intended_load_n, session.recipe.robot
    found = weights_findings(logs.tables, robot, intended) if logs.tables else []
    return [*found, *find_extrapolation([study.affine for study in studies], intended)]


def _inadequate(options: OfflineFitOptions, parts: Sequence[Part]) -> tuple[str, ...]:
    """The gate of ``--strict-findings`` on models that do not describe their data."""
    codes = [part.inadequate for part in parts if part.verdict.level != "good"]
    return (f"strict findings: {', '.join(codes)}",) if options.strict_findings and codes else ()
