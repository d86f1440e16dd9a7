"""``footcal offline-fit``: the bench calibration, weights and placements ([NAO], section 3.1)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from footcal_cli.commands.options import command
from footcal_cli.recipe.options import OfflineFitOptions
from footcal_cli.tables.columns import weights_table

if TYPE_CHECKING:
    from footcal_cli.core.bench.cop_study import FootStudy
    from footcal_cli.core.bench.record import BenchRecord
    from footcal_cli.core.bench.study import ChannelStudy
    from footcal_cli.core.parameters import Estimates
    from footcal_cli.core.quality import Finding
    from footcal_cli.intake.bench import WeightsLogs
    from footcal_cli.report.outcome import Outcome
    from footcal_cli.session.session import Session


@command(OfflineFitOptions)
def offline_fit(session: Session[OfflineFitOptions]) -> Outcome:
    """Fit load cells to known weights, and a foot's CoP to weights over known holes."""
    session.refuse_missing_logs("weights")
    from dataclasses import replace

    from footcal_cli.core.bench.pooled import with_common_noise
    from footcal_cli.core.plausibility import check_scale
    from footcal_cli.intake.bench import read_weights, studies_of, study_together
    from footcal_cli.intake.placed_weights import believed_cells, placed
    from footcal_cli.intake.zeros import at_zeros
    from footcal_cli.session.bench_calibration import bench_calibration
    from footcal_cli.session.calibration import counted_together
    from footcal_cli.sheets import bench, cop, matrix

    options, robot = session.options, session.recipe.robot
    with session.step("read"):
        logs = read_weights(session)
    with session.step("fit"):
        studies = with_common_noise(studies_of(logs.records, options, robot.gravity_mps2))
        together = study_together(session)
        alone = [study.estimates for study in studies]
        estimates = counted_together(session, alone) if alone else []
        weighed = session.parameters is not None or session.recipe.data_paths("weights")
        if not estimates and together is None and not weighed and (tables := placed(session)):
            estimates = believed_cells(robot, tables)
        estimates = at_zeros(session, estimates, robot.cell_names)
        feet = _feet(session, estimates)
    parts: dict[str, Outcome] = {}  # placements are what weights are for: they come first
    if feet:
        parts["cop_inadequate"] = cop.outcome_of(feet, robot)
    if together is not None:
        outputs, matrices = together
        parts["matrix_inadequate"] = matrix.outcome_of(robot.cell_names, outputs, matrices)
        found = matrices.chosen.estimates
        estimates.append(found)
        alone.append(found)
        scale = robot.nameplate.scale_n_per_count
        for cell in (cell for cell in robot.cell_names if f"{cell}.scale" in found.names):
            session.note(check_scale(cell, found[f"{cell}.scale"], scale))
    if studies:
        parts["affine_inadequate"] = bench.weights_outcome(
            studies, _apart(studies, logs.held_out), _findings(session, logs, studies),
            options.tolerance_percent, options.method,
        )  # fmt: skip
    if not parts:
        session.read_required(weights_table())
    bad = [code for code, part in parts.items() if part.verdict.level != "good"]
    corrections = cop.corrections_of(feet)
    every = [*alone, *(e for foot in feet if (e := foot.estimates) is not None)]
    title = f"Offline calibration of {robot.name}"
    return replace(
        bench.joined(title, list(parts.values()), session.parameters, every),
        parameters=bench_calibration(session, studies, estimates, feet),
        records={} if corrections is None else {"cop_correction.json": corrections},
        gates_missed=(f"strict findings: {', '.join(bad[::-1])}",)
        if options.strict_findings and bad
        else (),
    )


def _apart(
    studies: Sequence[ChannelStudy], held_out: Sequence[BenchRecord]
) -> list[tuple[ChannelStudy, BenchRecord]]:
    """Records kept apart from the fit, each with its channel's models."""
    from footcal_cli.core.bench.study import settled_like
    from footcal_cli.errors import DataError

    models = {study.channel: study for study in studies}
    for record in held_out:
        if record.channel not in models:
            raise DataError(
                "a held-out log has a channel that no weights log calibrates",
                column=record.channel, remedy="name the log of its weights in [data]",
            )  # fmt: skip
    return [
        (study, settled_like(study, record))
        for record in held_out
        for study in (models[record.channel],)
    ]


def _feet(session: Session[OfflineFitOptions], channels: Sequence[Estimates]) -> list[FootStudy]:
    """Corrections of every foot with placements, and of instruments that report a CoP."""
    from dataclasses import replace

    import numpy as np

    from footcal_cli.core.checks.holes import check_placed
    from footcal_cli.core.parameters import Status
    from footcal_cli.errors import UsageError, nearest
    from footcal_cli.intake.placed_weights import read_feet, study_foot

    calibration = {} if session.parameters is None else session.parameters.calibrated_cells
    for one in channels:
        channel = one.names[0].removesuffix(".scale")
        calibration[channel] = one[f"{channel}.scale"], one[f"{channel}.bias"]
    believed = bool(channels) and all({*one.status} == {Status.PRIOR_KEPT} for one in channels)
    logs, apart = read_feet(session, calibration, believed=believed)
    left_out = session.options.held_out_placements
    names = {str(name) for log in logs.values() for name in log.names}
    for name in left_out:
        if logs and name not in names:  # weights alone have no placements to leave out
            raise UsageError(
                f"held_out_placements: no placement '{name}'{nearest(name, names)}",
                file=session.recipe.path, remedy="name placements as the log does",
            )  # fmt: skip
    found = []
    for foot, log in logs.items():
        rows = log.rows
        session.note(check_placed(rows.forces_n, rows.cells, rows.load_n))
        study = study_foot(foot, log, np.isin(log.names.astype(str), left_out))
        found.append(replace(study, held_out=apart[foot].rows) if foot in apart else study)
    return found


def _findings(
    session: Session[OfflineFitOptions], logs: WeightsLogs, studies: Sequence[ChannelStudy]
) -> list[Finding]:
    from footcal_cli.core.plausibility import check_determined, check_scale
    from footcal_cli.session.inspection import weights_findings
    from footcal_cli.session.uneven import uneven
    from footcal_cli.sheets.weights import find_extrapolation, moving_findings

    robot, intended = session.recipe.robot, session.options.intended_load_n
    for study in studies:  # those whose loads stand in the recipe, not in the log
        known = any(f.where == study.channel and f.severity == "alarm" for f in session.noted)
        name = f"{study.channel}.scale"
        scale = study.estimates[name]
        nameplate = robot.nameplate.scale_n_per_count
        session.note(moving_findings(study))
        session.note(check_determined(study.channel, scale, study.estimates.sd_of(name)))
        session.note([] if known else check_scale(study.channel, scale, nameplate))
    found = weights_findings(logs.tables, robot, intended) if logs.tables else []
    # a cell that has a curve of its own is said by that
    straight = {s.channel for s in studies if s.ladder is None or not s.ladder.rungs}
    found += [f for f in uneven(logs.tables) if f.where in straight]
    return [*found, *find_extrapolation([study.affine for study in studies], intended)]
