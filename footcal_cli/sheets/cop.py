"""`offline-fit` on placements: the report, and the corrections as tables and record."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from footcal_cli.core.bench.cop_study import FootStudy
from footcal_cli.core.signals import root_mean_square
from footcal_cli.plots.placements import plot_corrections, plot_error_map, plot_total_force
from footcal_cli.recipe import Robot
from footcal_cli.records.results import (
    CopCorrectionRecord,
    CopCorrectionsRecord,
    RmseRecord,
    VerdictRecord,
)
from footcal_cli.report import Picture, Sheet, number
from footcal_cli.report.outcome import Outcome
from footcal_cli.sheets import placements as sheets


def outcome_of(feet: Sequence[FootStudy], robot: Robot) -> Outcome:
    """Corrections of the CoP, foot by foot."""
    pictures: list[Picture] = []
    tables: list[Sheet] = []
    for found in feet:
        pictures += _pictures(found, robot)
        cell = sheets.cell_sheet(found)
        tables += [sheets.correction_sheet(found), *([cell] if cell is not None else [])]
        tables.append(sheets.repeat_sheet(found))
    poor = [found.foot for found in feet if not sheets.explains(found)]
    light = sum(int(np.sum(~found.rows.valid)) for found in feet)
    corrected = [_corrected(found) for found in feet]
    return Outcome(
        title="Placements",
        verdict=VerdictRecord(
            level="warning" if poor else "good",
            sentence=sheets.feet_headline(feet),
            details=tuple(sheets.foot_sentence(found) for found in feet),
        ),
        pictures=tuple(pictures),
        sheets=tuple(tables),
        findings=tuple(
            f for found in feet for f in (*sheets.odd_cells(found), *sheets.misplaced_cells(found))
        ),
        footer=(
            "CoP corrections: NAO CoP self-calibration, eqs. (3)–(5), solved as the linear "
            "problem they are; the physical alternatives correct the cells instead. Each row's "
            "own placement is left out where it says so.",
        ),
        rmse=RmseRecord(
            rows=tuple(row for found in feet for row in sheets.placement_errors(found)),
            rejected={"too little force for a CoP": light} if light else {},
        ),
        tables={
            "placements.parquet": {
                name: np.concatenate([part[name] for part in corrected]) for name in corrected[0]
            }
        },
    )


def _pictures(found: FootStudy, robot: Robot) -> list[Picture]:
    spec = robot.feet.get(found.foot)
    chosen = found.study.chosen
    none = next((r for r in found.study.results if r.name == "none"), chosen)
    errors = (
        f"CoP error on placements left out: {1e3 * none.left_out.rmse:.2f} mm without a "
        f"correction, {1e3 * chosen.left_out.rmse:.2f} mm with the one in use ({chosen.name})."
    )
    outline = np.array(spec.outline_m) if spec is not None and spec.outline_m else None
    pictures = [
        Picture(
            f"cop_errors_{found.foot}", lambda: plot_error_map(found, outline),
            f"{found.foot}: from each hole (circle) to the mean CoP of every load there, "
            "enlarged as stated; squares are the cells, orange are placements never used.",
            title=f"CoP error at each hole, {found.foot} foot", result=errors,
        ),
        Picture(
            f"cop_corrections_{found.foot}", lambda: plot_corrections(found),
            f"{found.foot}: error of every correction where it was fitted and where not.",
            title=f"Error of each CoP correction, {found.foot} foot", result=errors,
        ),
    ]  # fmt: skip
    if np.isfinite(found.rows.load_n).all() and found.rows.cells:
        pictures.append(
            Picture(
                f"total_force_{found.foot}", lambda: plot_total_force(found),
                f"{found.foot}: sum of the cells against the weight that lay on the foot, and "
                "its error.",
                title=f"Total force against the known load, {found.foot} foot",
                result=lambda: _force_errors(found),
            )
        )  # fmt: skip
    return pictures


def _force_errors(found: FootStudy) -> str:
    """RMS error of the total force before and after."""
    stages = {"corrected": found.study.chosen.fit.total_n(found.rows) - found.rows.load_n}
    if found.before is not None:
        stages = {"before": found.before.total_n - found.before.load_n, **stages}
    rms = {stage: root_mean_square(error) for stage, error in stages.items()}
    return f"RMS error: {', '.join(f'{number(v, 2)} N {stage}' for stage, v in rms.items())}."


def _corrected(found: FootStudy) -> dict[str, NDArray[Any]]:
    """Every placement with raw and corrected CoP, sd and split."""
    chosen = found.study.chosen
    parts = []
    for split, rows in (("train", found.rows), ("held_out", found.held_out)):
        if rows is None:
            continue
        raw, cop, sd = rows.raw_cop_m, chosen.fit.cop_m(rows), chosen.cop_sd_m(rows)
        n = len(rows.load_n)
        parts.append(
            {
                "foot": np.full(n, found.foot, dtype=object),
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
                "correction": np.full(n, chosen.name, dtype=object),
                "split": np.full(n, split, dtype=object),
            }
        )
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def corrections_of(feet: Sequence[FootStudy]) -> CopCorrectionsRecord | None:
    """The best polynomial of every foot, as [NAO] has it."""
    found = {}
    for foot in feet:
        at = foot.study.empirical
        if at is None or foot.study.results[at].name == "none":
            continue
        result = foot.study.results[at]
        coefficients = result.fit.coefficients()
        found[foot.foot] = CopCorrectionRecord(
            model=result.name,
            terms=result.fit.model.terms(foot.rows.cells),
            coefficients_x=tuple(float(c) for c in coefficients[:, 0]),
            coefficients_y=tuple(float(c) for c in coefficients[:, 1]),
            ridge=result.fit.ridge,
            left_out_rmse_m=result.left_out.rmse,
            placements=result.groups,
            chosen=result is foot.study.chosen,
        )
    return CopCorrectionsRecord(feet=found) if found else None
