"""Matrices of channels loaded together, as tables and sentences."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footcal_cli.core.bench.matrix import MatrixFit, MatrixStudy
from footcal_cli.core.parameters import FloatArray
from footcal_cli.plots.matrix import plot_matrix
from footcal_cli.records.results import RmseRecord, RmseRow, VerdictRecord
from footcal_cli.report import Picture, Sheet, number, with_sd
from footcal_cli.report.outcome import Outcome


def outcome_of(channels: Sequence[str], outputs: Sequence[str], study: MatrixStudy) -> Outcome:
    """Cells loaded together, or a sensor of several bridges against a known wrench."""
    return Outcome(
        title="Matrix",
        verdict=VerdictRecord(
            level="good",
            sentence=matrix_headline(channels, outputs, study),
            details=matrix_details(study),
        ),
        pictures=(
            Picture(
                "matrix", lambda: plot_matrix(channels, outputs, study.full),
                "What each reading adds to each load, relative to the largest of its row, with "
                "95 % intervals; grey ones could be zero.",
                title="Contribution of each reading to each load",
                result=matrix_headline(channels, outputs, study),
            ),
        ),
        sheets=(matrix_sheet(channels, outputs, study), error_sheet(outputs, study)),
        footer=("Loads = matrix · counts + bias, all loads regressed on all readings.",),
        rmse=RmseRecord(rows=tuple(matrix_rows(outputs, study))),
    )  # fmt: skip


def shares_of_row(fit: MatrixFit) -> FloatArray:
    """What each reading's range adds to each load, over the largest of its row, shape (k, c)."""
    moved = fit.matrix * (fit.reading_high - fit.reading_low)
    return np.asarray(moved / np.abs(moved).max(axis=1, keepdims=True))


def matrix_headline(channels: Sequence[str], outputs: Sequence[str], study: MatrixStudy) -> str:
    """Whether channels are coupled, and what a full matrix gains."""
    error = study.held_out_rmse.mean(axis=1)
    if study.diagonal is None:
        return (
            f"{len(channels)} readings give {len(outputs)} loads; error on load cases left out: "
            + ", ".join(
                f"{name} {number(float(rmse), 2)}"
                for name, rmse in zip(outputs, study.held_out_rmse[-1], strict=True)
            )
            + "."
        )
    if study.full.diagonal:
        return (
            "A scale and a bias for each cell; error on load cases left out: "
            f"{number(float(error[0]), 2)} N. Crosstalk is not judged: the loads always stood in "
            "the same proportion."
        )
    off = np.abs(shares_of_row(study.full) * (1.0 - np.eye(len(channels))))
    row, column = divmod(int(np.argmax(off)), len(channels))
    largest, load, reading = 100.0 * off[row, column], outputs[row], channels[column]
    if study.chosen is study.full:
        return (
            f"The cells are coupled: {load} takes {largest:.1f} % from {reading}. "
            f"The error of the full matrix is {number(float(error[-1]), 2)} N instead of "
            f"{number(float(error[0]), 2)} N on load cases left out."
        )
    return (
        f"No crosstalk beyond noise: a matrix would take at most {largest:.2f} % "
        f"({load} from {reading}) and predict no better "
        f"({number(float(error[-1]), 2)} against {number(float(error[0]), 2)} N)."
    )


def matrix_details(study: MatrixStudy) -> tuple[str, ...]:
    """Health of the design, in words."""
    fit = study.full
    if fit.diagonal:
        return (
            "The loads keep one proportion: load the cells one by one to see whether one takes a "
            "share of another's load.",
        )
    return (
        f"The loads move {fit.rank} of {fit.matrix.shape[1]} combinations of readings, condition "
        f"number {number(fit.condition, 3)}"
        + (": load the channels in more different combinations." if fit.condition > 30 else "."),
    )


def matrix_sheet(channels: Sequence[str], outputs: Sequence[str], study: MatrixStudy) -> Sheet:
    """The chosen matrix with sd, in load per million counts."""
    fit = study.chosen
    sd = fit.estimates.sd.reshape(len(outputs), len(channels) + 1)
    rows = []
    for i, output in enumerate(outputs):
        cells = [
            with_sd(1e6 * float(fit.matrix[i, j]), 1e6 * float(sd[i, j])) if sd[i, j] > 0 else "0"
            for j in range(len(channels))
        ]
        rows.append((output, *cells, with_sd(float(fit.bias[i]), float(sd[i, -1]))))
    kind = "diagonal" if fit.diagonal else "full"
    return Sheet(
        f"Matrix ({kind})",
        ("load", *(f"{channel} (per 10⁶ counts)" for channel in channels), "bias"),
        rows,
        note="± one standard deviation; parameters.json has the joint covariance.",
    )


def _candidates(study: MatrixStudy) -> list[str]:
    """Names of the matrices that were compared, as in `MatrixStudy.held_out_rmse`."""
    return (["full"] if study.diagonal is None else ["diagonal", "full"])[
        : len(study.held_out_rmse)
    ]


def error_sheet(outputs: Sequence[str], study: MatrixStudy) -> Sheet:
    """Held-out errors of the candidates."""
    names = _candidates(study)
    return Sheet(
        "Error on load cases left out",
        ("matrix", *outputs),
        [
            (name, *(number(float(value), 3) for value in row))
            for name, row in zip(names, study.held_out_rmse, strict=True)
        ],
    )


def matrix_rows(outputs: Sequence[str], study: MatrixStudy) -> list[RmseRow]:
    """Held-out errors as rows of rmse.json."""
    names = _candidates(study)
    chosen = "diagonal" if study.chosen.diagonal else "full"
    units = study.full.estimates.units[study.full.matrix.shape[1] :: study.full.matrix.shape[1] + 1]
    return [
        RmseRow(
            quantity=f"force {output}" if unit == "N" else f"torque {output}",
            unit=unit,
            stage="after" if name == chosen else name,
            reference="known load, its load case left out of the fit",
            split="held_out",
            rmse=float(value),
            n=study.rows,
        )
        for name, errors in zip(names, study.held_out_rmse, strict=True)
        for output, unit, value in zip(outputs, units, errors, strict=True)
    ]
