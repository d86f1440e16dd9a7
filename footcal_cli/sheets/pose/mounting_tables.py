"""Mountings found from standing poses: tables and error rows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from footcal_cli.core.effects.calibration import AXES
from footcal_cli.core.parameters import FloatArray, Status
from footcal_cli.core.pose.hanging import LegKnowledge
from footcal_cli.core.pose.joint import PoseFit
from footcal_cli.core.pose.selection import Candidate
from footcal_cli.records.results import RmseRow
from footcal_cli.report import Sheet, number, with_sd


def rmse_rows(stages: Mapping[str, FloatArray], held_out: Candidate) -> tuple[RmseRow, ...]:
    """Per stage: sum of forces and of moments, per axis RMS; held-out errors of the fit."""
    rows = [
        row(quantity, unit, stage, part)
        for stage, error in stages.items()
        for quantity, unit, part in (
            ("sum of forces", "N", error[:, :3]),
            ("sum of moments", "Nm", error[:, 3:]),
        )
    ]
    samples = 3 * next(iter(stages.values())).shape[0]
    for quantity, unit, square in (
        ("sum of forces", "N", held_out.cv_square[:3]),
        ("sum of moments", "Nm", held_out.cv_square[3:]),
    ):
        rows.append(
            RmseRow(
                quantity=quantity,
                unit=unit,
                stage="joint" if "joint" in stages else "after",
                reference="chassis weight",
                split="held_out",
                rmse=float(np.sqrt(square.mean())),
                n=samples,
            )
        )
    return tuple(rows)


def row(quantity: str, unit: str, stage: str, error: FloatArray) -> RmseRow:
    """One error of the chassis balance."""
    return RmseRow.of(quantity, unit, stage, "chassis weight", error)


def common_sd(fit: PoseFit, first: int) -> float:
    """Sd of the mean over legs of one body axis' rotation or shift."""
    legs = len(fit.geometry.legs)
    at = first + 3 * np.arange(legs)
    return float(np.sqrt(fit.covariance[np.ix_(at, at)].sum())) / legs


def mounting_sheet(fit: PoseFit) -> Sheet:
    """Mounting errors along the nominal transducer's axes."""
    estimates = fit.estimates()
    fixed = {
        name
        for name, status in zip(estimates.names, estimates.status, strict=True)
        if status == Status.FIXED
    }
    rows = []
    for leg in fit.geometry.legs:
        cells = [
            "fixed"
            if f"{leg}.{kind}_{axis}" in fixed
            else with_sd(
                factor * estimates[f"{leg}.{kind}_{axis}"],
                factor * estimates.sd_of(f"{leg}.{kind}_{axis}"),
            )
            for kind, factor in (("mount_rot", 180.0 / np.pi), ("mount_pos", 1e3))
            for axis in "xyz"
        ]
        rows.append((leg, *cells))
    return Sheet(
        "Mounting errors",
        ("leg", "turn x (°)", "turn y (°)", "turn z (°)", "shift x (mm)", "shift y (mm)",
         "shift z (mm)"),
        rows,
        note="Along the nominal transducer's axes, ± one standard deviation; fixed: not part of "
        "the fit. A shift is the hip's minus the chassis CoM's: standing shows only their sum "
        "(p̃ + p_BC in Wu & Revzen).",
    )  # fmt: skip


def candidate_sheet(candidates: Sequence[Candidate]) -> Sheet:
    """Table I with a fifth model and both ways of counting."""
    best = min(candidate.bic for candidate in candidates)
    return Sheet(
        "Which mounting errors are there",
        ("free", "DOF", "held-out error", "held-out χ²", "BIC as printed", "BIC above best"),
        [
            (
                candidate.structure.value,
                str(candidate.freedom),
                number(candidate.cv_error, 3),
                number(candidate.cv_chi2, 3),
                f"{candidate.bic_paper:z,.0f}",
                f"{candidate.bic - best:z,.0f}",
            )
            for candidate in candidates
        ],
        note="Cross-validation by pose block, squared error per pose: in the paper's norm, and in "
        "units of the noise (6 if all is explained). The printed BIC counts P residuals though "
        "there are 6 P; the last one counts all, in units of the noise, hanging logs included. The "
        "evidence decides on rotations; translations it does not demand keep their prior.",
    )  # fmt: skip


def common_sheet(fit: PoseFit) -> Sheet:
    """What only the legs together share."""
    legs = len(fit.geometry.legs)
    rows = [
        (name, axis, number(factor * common_sd(fit, first + i), 2), unit)
        for name, first, factor, unit in (
            ("common turn", 0, 180.0 / np.pi, "°"),
            ("common shift", 3 * legs, 1e3, "mm"),
        )
        for i, axis in enumerate("xyz")
    ]
    return Sheet(
        "How well common errors are seen",
        ("error", "body axis", "sd", "unit"),
        rows,
        note=f"The poses alone determine {fit.rank} of {fit.free} directions.",
    )


def prior_sheet(fit: PoseFit, legs: Sequence[LegKnowledge]) -> Sheet:
    """How far offsets and weights moved from the hanging logs, in their own sd."""
    rows = []
    for k, (name, leg) in enumerate(zip(fit.geometry.legs, legs, strict=True)):
        sd = np.sqrt(np.diag(leg.covariance)[:7])
        pull = (np.append(fit.mounting.offset[k], fit.mounting.leg_weight_n[k])
                - np.append(leg.offset, leg.weight_n)) / sd  # fmt: skip
        rows.append((name, *(f"{value:+z.1f}".replace("-", "−") for value in pull)))
    return Sheet(
        "Pull on the hanging calibration",
        ("leg", *AXES, "weight"),
        rows,
        note="Shift of offset and weight by the poses in units of their hanging sd: beyond ± 3 "
        "something changed between hanging and standing.",
    )
