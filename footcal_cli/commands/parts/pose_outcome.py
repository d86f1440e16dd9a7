"""What `pose-calib` found, as the run folder's records, tables and figures."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.commands.parts.calibration_record import Conventions, calibration_record
from footcal_cli.core.parameters import Estimates, FloatArray, Status
from footcal_cli.core.pose.data import Geometry, PoseData
from footcal_cli.core.pose.departures import departures
from footcal_cli.core.pose.hanging import LegKnowledge
from footcal_cli.core.pose.joint import PoseFit
from footcal_cli.core.pose.leg_map import LegMap
from footcal_cli.core.pose.selection import Candidate
from footcal_cli.core.pose.slow_noise import SlowNoise
from footcal_cli.core.pose.stages import in_floating_base
from footcal_cli.core.pose.standing import OffsetFit
from footcal_cli.core.pose.wrenches import (
    FootCalibration,
    foot_wrenches,
    reference_com_b_m,
    robot_com_b_m,
)
from footcal_cli.core.spatial import rotation_exp
from footcal_cli.plots import pose as plots
from footcal_cli.records.results import (
    CovarianceBlock,
    FindingRecord,
    ParameterRecord,
    ParametersRecord,
    RmseRecord,
    VerdictRecord,
    covariance_blocks,
    parameter_records,
)
from footcal_cli.report import Picture, Report
from footcal_cli.session.session import Outcome
from footcal_cli.sheets import pose as sheets

if TYPE_CHECKING:
    from footcal_cli.commands.pose_calib import PoseCalibOptions
    from footcal_cli.session.session import Session

WRENCH_COLUMNS = ("fx_w_n", "fy_w_n", "fz_w_n", "tx_w_nm", "ty_w_nm", "tz_w_nm")
SIGNS = (
    "reading = applied + offset; applied by leg and ground on the transducer; "
    "R_bt = R_nominal exp[mount_rot], hip = nominal + R_nominal mount_pos, both along the nominal "
    "transducer's axes; mount_pos holds minus the shift of the chassis CoM (their sum is seen)"
)


@dataclass(frozen=True)
class Found:
    """Everything a mounting run found.

    Parameters
    ----------
    slow
        How the noise lasts from pose to pose.
    held_out
        The fit judged on poses it was not made with.
    stages
        Balance errors (P, 6) by stage: before, offsets only, …, after.
    """

    data: PoseData
    legs: tuple[LegKnowledge, ...]
    fit: PoseFit
    slow: SlowNoise
    candidates: tuple[Candidate, ...]
    held_out: Candidate
    stages: Mapping[str, FloatArray]
    mapped: LegMap
    findings: tuple[FindingRecord, ...]
    rejected: Mapping[str, int]


@dataclass(frozen=True)
class Mounted:
    """A calibrated mounting as it stands in ``parameters.json``.

    Parameters
    ----------
    rot_bt
        Transducer to body, shape (K, 3, 3).
    arm_b_m
        Chassis CoM to hip, shape (K, 3), m.
    """

    rot_bt: FloatArray
    arm_b_m: FloatArray


def stored_mounting(session: Session[PoseCalibOptions], geometry: Geometry) -> Mounted:
    """The mounting of ``--parameters``; nominal where it was never calibrated."""
    return mounting_of(session.parameters, geometry)


def mounting_of(record: ParametersRecord | None, geometry: Geometry) -> Mounted:
    """Mounting rotations and arms of a calibration, nominal for what it does not hold."""
    known = {} if record is None else record.parameters
    rot, arm = [], []
    for k, leg in enumerate(geometry.legs):
        turn, shift = (
            np.array(
                [
                    known[name].value if (name := f"{leg}.{kind}_{axis}") in known else 0.0
                    for axis in "xyz"
                ]
            )
            for kind in ("mount_rot", "mount_pos")
        )
        nominal = geometry.rot_bt[k]
        rot.append(nominal @ rotation_exp(turn))
        arm.append(geometry.hip_b_m[k] - geometry.chassis_com_b_m + nominal @ shift)
    return Mounted(np.stack(rot), np.stack(arm))


def calibration_of(
    data: PoseData, mounted: Mounted, offset: FloatArray, legs: tuple[LegKnowledge, ...]
) -> FootCalibration:
    """All that turns readings into foot wrenches."""
    geometry = data.geometry
    hip = geometry.chassis_com_b_m + mounted.arm_b_m
    weight = np.array([leg.weight_n for leg in legs])
    com = tuple(leg.com_m for leg in legs)
    origin = reference_com_b_m(
        mounted.rot_bt, hip, weight, data.robot_weight_n, com, geometry.chassis_com_b_m
    )
    return FootCalibration(mounted.rot_bt, hip, offset, weight, com, origin)


def mounting_outcome(session: Session[PoseCalibOptions], found: Found) -> Outcome:
    """Report, records and files of a mounting run."""
    options = session.options
    names = found.data.geometry.legs
    rmse = RmseRecord(
        rows=sheets.rmse_rows(found.stages, found.held_out), rejected=dict(found.rejected)
    )
    mounted = Mounted(found.fit.rot_bt, found.fit.arm_b_m)
    calibration = calibration_of(found.data, mounted, found.fit.mounting.offset, found.legs)
    share = calibration.leg_weight_n / found.data.robot_weight_n
    com = robot_com_b_m(calibration, found.data, share)
    pictures = (
        Picture(
            "balance",
            lambda: plots.plot_balance(
                {name: in_floating_base(found.data, e, com) for name, e in found.stages.items()}
            ),
            "Sum of the ground's wrenches on all feet minus the robot's weight, in the floating "
            "base about the robot's CoM: zero if every transducer tells the truth. Before: tare in "
            "the air, nominal mounting (compare Wu & Revzen, Figs. 2 and 6).",
            title="Sum of all foot wrenches against the robot's weight",
        ),
        Picture(
            "mounting",
            lambda: plots.plot_mounting(found.fit),
            "The robot from above: nominal hips (squares), calibrated hips with 95 % ellipses "
            "and axes, errors drawn larger than life.",
            title="Nominal and calibrated hips, from above",
        ),
        Picture(
            "legs_and_poses",
            lambda: plots.plot_leg_map(found.mapped, names),
            "Residual that each leg's own readings predict, pose by pose: a row that lights "
            "up is a leg with a wrong gain, a twisted axis or a dead channel.",
            title="Residual predicted by each leg, pose by pose",
        ),
        Picture(
            "coverage",
            lambda: plots.plot_coverage(found.data),
            "Which shaft angles and body tilts the poses cover: yaw and height of the mounting "
            "are only seen where the body tilts.",
            title="Shaft angles and body tilts covered by the poses",
        ),
    )
    contradicted = departures(found.fit, found.legs, found.data.robot_weight_n)
    verdict = sheets.verdict(
        found.fit,
        found.stages,
        found.mapped,
        found.held_out,
        found.candidates[0],
        found.slow,
        contradicted,
    )
    return Outcome(
        report=Report(
            title=f"Standing calibration of {session.recipe.robot.name}",
            verdict=verdict,
            pictures=pictures,
            sheets=(
                sheets.mounting_sheet(found.fit),
                sheets.candidate_sheet(found.candidates),
                sheets.common_sheet(found.fit),
                sheets.prior_sheet(found.fit, found.legs),
            ),
            findings=(
                *found.findings,
                *sheets.findings(found.fit, found.mapped),
                *sheets.departure_findings(contradicted),
            ),
            footer=sheets.footer(options.method, options.balance, options.errors_in_variables),
        ),
        rmse=rmse,
        parameters=_parameters(session, found.fit.estimates(), found.data),
        files={
            "wrenches.parquet": wrench_writer(found.data, calibration),
            "models.parquet": _models_writer(found.candidates),
        },
        usable=found.fit.converged,
    )


def offset_outcome(
    session: Session[PoseCalibOptions],
    data: PoseData,
    legs: tuple[LegKnowledge, ...],
    mounted: Mounted,
    found: OffsetFit,
    rejected: Mapping[str, int],
) -> Outcome:
    """Report, records and files of an offset run; a refusal is not usable."""
    names = data.geometry.legs
    pictures = (
        Picture(
            "offset_change",
            lambda: plots.plot_offset_change(found, names),
            "How far each offset moved since the last calibration, with 95 % intervals.",
            title="Change of each offset since the last calibration",
        ),
    ) if found.accepted else ()  # fmt: skip
    old = np.stack([leg.offset for leg in legs])
    parameters = None
    files: dict[str, Callable[[Path], None]] = {}
    rows = sheets.offset_rmse(data, mounted.rot_bt, mounted.arm_b_m, legs, old, "before")
    if found.accepted:
        axes = ("fx", "fy", "fz", "tx", "ty", "tz")
        estimates = Estimates(
            tuple(f"{leg}.offset_{axis}" for leg in names for axis in axes),
            (("N",) * 3 + ("Nm",) * 3) * len(names),
            found.offset.ravel(),
            found.covariance,
            (Status.ESTIMATED,) * found.offset.size,
        )
        parameters = _parameters(session, estimates, data)
        calibration = calibration_of(data, mounted, found.offset, legs)
        files["wrenches.parquet"] = wrench_writer(data, calibration)
        rows += sheets.offset_rmse(
            data, mounted.rot_bt, mounted.arm_b_m, legs, found.offset, "after"
        )
    return Outcome(
        report=Report(
            title=f"Offsets again, from standing: {session.recipe.robot.name}",
            verdict=VerdictRecord(
                level=sheets.offset_level(found),
                sentence=sheets.offset_sentence(found, names),
                details=found.words,
            ),
            pictures=pictures,
            sheets=(sheets.offset_sheet(found, names),),
            findings=(),
            footer=(
                "Chassis balance of every pose plus, for every lifted leg, reading = offset + its "
                "own weight; mounting, weights and CoM kept (Wu & Revzen, section V).",
            ),
        ),
        rmse=RmseRecord(rows=rows, rejected=dict(rejected)),
        parameters=parameters,
        files=files,
        usable=found.accepted,
    )


def _parameters(
    session: Session[PoseCalibOptions], estimates: Estimates, data: PoseData
) -> ParametersRecord:
    """The calibration of ``--parameters`` with what this run found put in."""
    old = session.parameters
    assert old is not None, "checked while reading"
    new = parameter_records(estimates)
    kept = {name: record for name, record in old.parameters.items() if name not in new}
    names = tuple(kept)
    blocks = list(covariance_blocks(estimates))
    for block in old.covariance:
        left = tuple(name for name in block.names if name in kept)
        if left:
            matrix = old.covariance_of(left)
            rows = tuple(tuple(float(x) for x in row) for row in matrix)
            blocks.append(CovarianceBlock(names=left, matrix=rows))
    believed = {
        f"robot.chassis_com_{axis}": ParameterRecord(
            value=float(value), sd=None, unit="m", status=Status.FIXED
        )
        for axis, value in zip("xyz", data.geometry.chassis_com_b_m, strict=True)
    }
    return calibration_record(
        session,
        Conventions(
            SIGNS,
            "each transducer's own axes; mounting along the nominal ones",
            "the transducer's origin",
        ),
        {**{name: kept[name] for name in names}, **believed, **new},
        covariance=blocks,
        fitted_range=old.fitted_range,
        effects=old.effects,
        earlier_inputs=old.inputs,
    )


def _models_writer(candidates: Sequence[Candidate]) -> Callable[[Path], None]:
    """Writes which mounting errors the evidence asks for, the chosen model first."""

    def write(path: Path) -> None:
        import pandas as pd

        from footcal_cli.tables.table import write_parquet

        rows = [
            {
                "model": candidate.structure.name.lower(),
                "freedom": candidate.freedom,
                "cv_error": candidate.cv_error,
                "bic_paper": candidate.bic_paper,
                "cv_chi2": candidate.cv_chi2,
                "bic": candidate.bic,
            }
            for candidate in candidates
        ]
        write_parquet(pd.DataFrame(rows), path)

    return write


def wrench_writer(data: PoseData, calibration: FootCalibration) -> Callable[[Path], None]:
    """Writes the ground's wrench on every foot, floating-base frame, long form."""

    def write(path: Path) -> None:
        import pandas as pd

        from footcal_cli.tables.table import write_parquet

        wrench = foot_wrenches(data, calibration)
        poses, legs = wrench.shape[:2]
        table = pd.DataFrame(
            {
                "pose": np.repeat(np.arange(poses), legs),
                "leg": np.tile(data.geometry.legs, poses),
                "phase_rad": data.phase_rad.ravel(),
            }
        )
        for i, name in enumerate(WRENCH_COLUMNS):
            table[name] = wrench[..., i].ravel()
        write_parquet(table, path)

    return write
