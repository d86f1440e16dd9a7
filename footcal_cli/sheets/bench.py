"""The run folder of a bench calibration: report, parameters, predictions, corrections."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pandas as pd

    from footcal_cli.core.bench.cop_study import FootStudy
    from footcal_cli.core.bench.matrix import MatrixStudy
    from footcal_cli.core.bench.record import BenchRecord
    from footcal_cli.core.bench.study import ChannelStudy
    from footcal_cli.core.quality import Finding
    from footcal_cli.recipe import Robot
    from footcal_cli.records.results import RmseRow, VerdictRecord
    from footcal_cli.report import Picture, Sheet


@dataclass(frozen=True)
class Part:
    """What weights or placements contribute to the run folder.

    Parameters
    ----------
    verdict, pictures, sheets, findings, footer
        Of the report.
    rows, rejected
        Of rmse.json.
    files
        Name -> table to write.
    inadequate
        Code of the strict finding that a verdict other than good means.
    """

    verdict: VerdictRecord
    pictures: tuple[Picture, ...]
    sheets: tuple[Sheet, ...]
    rows: tuple[RmseRow, ...]
    inadequate: str
    findings: tuple[Finding, ...] = ()
    footer: tuple[str, ...] = ()
    rejected: Mapping[str, int] = field(default_factory=dict)
    files: Mapping[str, pd.DataFrame] = field(default_factory=dict)


def weights_part(
    studies: Sequence[ChannelStudy],
    held_out: Sequence[BenchRecord],
    *,
    findings: Sequence[Finding],
    intended_load_n: tuple[float, float] | None,
    tolerance_percent: float,
    method: str,
) -> Part:
    """Channels with their weights, and records that were kept apart from the fit."""
    import numpy as np

    from footcal_cli.core.bench.regression import pooled_curvature
    from footcal_cli.sheets import ladder as ladder_sheets
    from footcal_cli.sheets import weights as weights_sheets

    fits = [study.affine for study in studies]
    largest = max(float(np.abs(fit.load_n).max()) for fit in fits)
    tolerance_n = tolerance_percent / 100.0 * largest
    curvature = pooled_curvature(fits)
    climbed = any(study.ladder is not None for study in studies)
    extended = any(study.fit is not None for study in studies)
    apart, scored = _held_out(studies, held_out)
    rows = weights_sheets.affine_rows(fits, "affine" if extended else "after")
    if extended:
        rows += [
            weights_sheets.force_row(
                s.channel, "after", s.predict(s.record).load_n - s.record.load_n
            )
            for s in studies
        ]
    rejected: dict[str, int] = {}
    for study in studies:
        for reason, n in (study.samples.rejected() if study.samples is not None else {}).items():
            rejected[reason] = rejected.get(reason, 0) + n
    sheets = [weights_sheets.parameter_sheet(fits)]
    if climbed:
        sheets.append(ladder_sheets.model_sheet(studies))
    sheets += [s for s in (ladder_sheets.creep_sheet(studies),) if s is not None]
    sheets += [weights_sheets.residual_sheet(fits), weights_sheets.method_sheet(fits)]
    sheets += [s for s in (ladder_sheets.tried_sheet(studies),) if s is not None]
    return Part(
        verdict=ladder_sheets.weights_verdict(studies, curvature, tolerance_n),
        pictures=_weights_pictures(studies, tolerance_n, climbed=climbed),
        sheets=tuple(sheets),
        rows=(*rows, *ladder_sheets.held_out_rows(studies), *scored),
        inadequate="affine_inadequate",
        findings=tuple(findings),
        footer=(
            f"Model: F = scale · S + bias per channel, {method} regression of load on counts "
            "(NAO CoP self-calibration, eqs. 1 and 2). Adequate: no residual above "
            f"{tolerance_percent:g} % of the largest load ({tolerance_n:.3g} N).",
        ),
        rejected=rejected,
        files={"predictions.parquet": _predictions(studies, apart)},
    )


def _weights_pictures(
    studies: Sequence[ChannelStudy], tolerance_n: float, *, climbed: bool
) -> tuple[Picture, ...]:
    from footcal_cli.plots.ladder import plot_ladder, plot_recordings, plot_staircases
    from footcal_cli.plots.weights import plot_loads_against_counts, plot_residuals, plot_scales
    from footcal_cli.report import Picture

    fits = [study.affine for study in studies]
    recorded = any(study.samples is not None for study in studies)
    pictures = [
        Picture(
            "loads_against_counts", lambda: plot_loads_against_counts(fits, tolerance_n),
            "Known load against raw reading with the fitted line, and the error below it; orange "
            "channels leave the band.",
            title="Known load against reading, with the fitted line",
        ),
        Picture("scales", lambda: plot_scales(fits),
                "Cells of one type should have scales that agree.",
            title="Scales of all cells"),
    ]  # fmt: skip
    if not recorded:
        pictures.insert(
            0,
            Picture(
                "residuals", lambda: plot_residuals(fits, tolerance_n),
                "Residual at each known load, one line per cell; lines that bend together share "
                "a cause. Blue band: the tolerance.",
                title="Residuals",
            ),
        )  # fmt: skip
    if climbed:
        pictures[:0] = [
            Picture(
                "staircases", lambda: plot_staircases(studies),
                "Residual against load of the straight line and of the chosen model; loading and "
                "unloading apart: a gap between them is memory, a common bend is nonlinearity.",
                title="Residual against load: straight line and chosen model",
            ),
            Picture(
                "ladder", lambda: plot_ladder(studies),
                "Error of each model on sessions or loads that it was not fitted to; further "
                "left is "
                "better, the filled one is in use.",
                title="Held-out error of each model",
            ),
        ]  # fmt: skip
    if recorded:
        pictures.insert(
            0,
            Picture(
                "recordings", lambda: plot_recordings(studies),
                "The recording: blue samples were used, the others not, and why.",
                title="Recording, with the samples used and rejected", zoom=True,
            ),
        )  # fmt: skip
    return tuple(pictures)


def _held_out(
    studies: Sequence[ChannelStudy], held_out: Sequence[BenchRecord]
) -> tuple[list[tuple[ChannelStudy, BenchRecord]], list[RmseRow]]:
    """Records kept apart, each with its channel's model, and their errors."""
    from footcal_cli.core.bench.study import settled_like
    from footcal_cli.errors import DataError
    from footcal_cli.sheets.weights import force_row

    models = {study.channel: study for study in studies}
    pairs, rows = [], []
    for record in held_out:
        if record.channel not in models:
            raise DataError(
                "a held-out log has a channel that no weights log calibrates",
                column=record.channel, remedy="name the log of its weights in [data]",
            )  # fmt: skip
        study = models[record.channel]
        scored = settled_like(study, record)
        for stage, fit in (("affine", "affine"), ("after", "chosen")):
            if study.ladder is None and stage == "affine":
                continue
            found = (
                study.ladder.affine.predict(scored)
                if study.ladder is not None and fit == "affine"
                else study.predict(scored)
            )
            row = force_row(study.channel, stage, found.load_n - scored.load_n, "held_out")
            rows.append(row.model_copy(update={"reference": "known load, log never used"}))
        pairs.append((study, scored))
    return pairs, rows


def _predictions(
    studies: Sequence[ChannelStudy], apart: Sequence[tuple[ChannelStudy, BenchRecord]]
) -> pd.DataFrame:
    """Every row (of a recording: every sample) with its predicted load and why it counts or not."""
    import numpy as np
    import pandas as pd

    from footcal_cli.core.bench.plateaus import SampleState
    from footcal_cli.core.bench.study import record_of_samples

    frames = []
    pairs = [(study, record_of_samples(study), "train") for study in studies]
    pairs += [(study, record, "held_out") for study, record in apart]
    for study, record, split in pairs:
        found = study.predict(record)
        states = np.full(len(record), SampleState.SETTLED.reason, dtype=object)
        if study.samples is not None and split == "train":
            reasons = np.array([state.reason for state in SampleState], dtype=object)
            states = reasons[study.samples.state]
        frames.append(
            pd.DataFrame(
                {
                    "channel": study.channel,
                    "session": record.session,
                    "time_s": record.time_s if record.timed else np.nan,
                    "load_n": record.load_n,
                    "counts": record.reading,
                    "predicted_n": found.load_n,
                    "sd_n": found.sd_n,
                    "ci95_half_width_n": found.half_width_n(),
                    "extrapolated": found.extrapolated,
                    "model": study.model,
                    "split": split,
                    "state": states,
                }
            )
        )
    return pd.concat(frames, ignore_index=True)


def together_part(channels: Sequence[str], outputs: Sequence[str], study: MatrixStudy) -> Part:
    """Cells loaded together, or a sensor of several bridges against a known wrench."""
    from footcal_cli.plots.matrix import plot_matrix
    from footcal_cli.records.results import VerdictRecord
    from footcal_cli.report import Picture
    from footcal_cli.sheets import matrix as sheets

    return Part(
        verdict=VerdictRecord(
            level="good",
            sentence=sheets.matrix_headline(channels, outputs, study),
            details=sheets.matrix_details(study),
        ),
        pictures=(
            Picture(
                "matrix", lambda: plot_matrix(channels, outputs, study.full),
                "What each reading adds to each load, relative to the largest of its row, with "
                "95 % intervals; grey ones could be zero.",
                title="Contribution of each reading to each load",
            ),
        ),
        sheets=(sheets.matrix_sheet(channels, outputs, study), sheets.error_sheet(outputs, study)),
        rows=tuple(sheets.matrix_rows(outputs, study)),
        inadequate="matrix_inadequate",
        footer=("Loads = matrix · counts + bias, all loads regressed on all readings.",),
    )  # fmt: skip


def feet_part(feet: Sequence[FootStudy], robot: Robot) -> Part:
    """Corrections of the CoP, foot by foot."""
    import numpy as np
    import pandas as pd

    from footcal_cli.plots.placements import plot_corrections, plot_error_map, plot_total_force
    from footcal_cli.records.results import VerdictRecord
    from footcal_cli.report import Picture
    from footcal_cli.sheets import placements as sheets

    pictures: list[Picture] = []
    tables: list[Sheet] = []
    for found in feet:
        spec = robot.feet.get(found.foot)
        outline = np.array(spec.outline_m) if spec is not None and spec.outline_m else None
        pictures += [
            Picture(
                f"cop_errors_{found.foot}", partial(plot_error_map, found, outline),
                f"{found.foot}: from each hole (circle) to the mean CoP of every load there, "
                "enlarged as stated; squares are the cells, orange are placements never used.",
                title=f"CoP error at each hole, {found.foot} foot",
            ),
            Picture(
                f"cop_corrections_{found.foot}", partial(plot_corrections, found),
                f"{found.foot}: error of every correction where it was fitted and where not.",
                title=f"Error of each CoP correction, {found.foot} foot",
            ),
        ]  # fmt: skip
        if np.isfinite(found.rows.load_n).all() and found.rows.cells:
            pictures.append(
                Picture(
                    f"total_force_{found.foot}", partial(plot_total_force, found),
                    f"{found.foot}: sum of the cells against the weight that lay on the foot, and "
                    "its error.",
                    title=f"Total force against the known load, {found.foot} foot",
                )
            )  # fmt: skip
        cell = sheets.cell_sheet(found)
        tables += [sheets.correction_sheet(found), *([cell] if cell is not None else [])]
        tables.append(sheets.repeat_sheet(found))
    poor = [found.foot for found in feet if not sheets.explains(found)]
    verdict = VerdictRecord(
        level="warning" if poor else "good",
        sentence=sheets.feet_headline(feet),
        details=tuple(sheets.foot_sentence(found) for found in feet),
    )
    light = sum(int(np.sum(~found.rows.valid)) for found in feet)
    return Part(
        verdict=verdict,
        pictures=tuple(pictures),
        sheets=tuple(tables),
        rows=tuple(row for found in feet for row in sheets.placement_errors(found)),
        inadequate="cop_inadequate",
        findings=tuple(f for found in feet for f in sheets.misplaced_cells(found)),
        footer=(
            "CoP corrections: NAO CoP self-calibration, eqs. (3)–(5), solved as the linear "
            "problem they are; the "
            "physical alternatives correct the cells instead. Each row's own placement is left "
            "out where it says so.",
        ),
        rejected={"too little force for a CoP": light} if light else {},
        files={"placements.parquet": pd.concat([_corrected(f) for f in feet], ignore_index=True)},
    )


def _corrected(found: FootStudy) -> pd.DataFrame:
    """Every placement with raw and corrected CoP, sd and split."""
    import pandas as pd

    chosen = found.study.chosen
    frames = []
    for split, rows in (("train", found.rows), ("held_out", found.held_out)):
        if rows is None:
            continue
        raw, cop, sd = rows.raw_cop_m, chosen.fit.cop_m(rows), chosen.cop_sd_m(rows)
        frames.append(
            pd.DataFrame(
                {
                    "foot": found.foot,
                    "hole_x_m": rows.hole_m[:, 0],
                    "hole_y_m": rows.hole_m[:, 1],
                    "load_n": rows.load_n,
                    "raw_cop_x_m": raw[:, 0],
                    "raw_cop_y_m": raw[:, 1],
                    "cop_x_m": cop[:, 0],
                    "cop_y_m": cop[:, 1],
                    "cop_x_sd_m": sd[:, 0],
                    "cop_y_sd_m": sd[:, 1],
                    "vgrf_n": chosen.fit.total_n(rows),
                    "valid": rows.valid,
                    "extrapolated": chosen.extrapolated(rows, found.rows),
                    "correction": chosen.name,
                    "split": split,
                }
            )
        )
    return pd.concat(frames, ignore_index=True)
