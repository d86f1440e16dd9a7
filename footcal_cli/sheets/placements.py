"""What placements of known weights say about a foot, as tables, sentences and error rows."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from footcal_cli.core.bench.cop_models import CopFit
from footcal_cli.core.bench.cop_study import CopResult, FootStudy
from footcal_cli.core.bench.odd_gain import gain_finding, odd_gain
from footcal_cli.core.bench.placement_rows import PlacementRows, find_repeats
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.quality import Finding, listed
from footcal_cli.records.results import RmseRow, Split
from footcal_cli.report import Sheet, number, with_sd

_MOST_ROWS = 120
_MM = 1e3

MISPLACED_M, _SIGMAS = 3e-3, 4.0
"""A cell is said to be misplaced from this distance on, and this many sd."""
POOR_M, POOR_RATIO = 2e-3, 5.0
"""CoP errors that are called good: smaller than this, or than so many sd of repeats."""


def cop_errors_m(cop_m: FloatArray, rows: PlacementRows) -> FloatArray:
    """Distance vectors from the hole where there is a CoP, shape (m, 2)."""
    error = cop_m - rows.hole_m
    return np.asarray(error[np.isfinite(error).all(axis=1)])


_SHOWN = {"m": (_MM, "mm"), "-": (100.0, "%")}
"""Factor and unit of a parameter as it is written."""


def rms_distance_m(error_m: FloatArray) -> float:
    """Root mean squared length of error vectors."""
    return float(np.sqrt(np.mean(np.sum(error_m**2, axis=1)))) if len(error_m) else float("nan")


def feet_headline(feet: Sequence[FootStudy]) -> str:
    """The foot with the largest remaining error, in one sentence."""
    worst = max(feet, key=lambda found: found.study.chosen.left_out.rmse)
    study, chosen = worst.study, worst.study.chosen
    error = with_sd(_MM * chosen.left_out.rmse, _MM * chosen.left_out.rmse_sd)
    if chosen.name == "none":
        best = study.results[study.choice.best]
        other = with_sd(_MM * best.left_out.rmse, _MM * best.left_out.rmse_sd)
        rival = "" if best is chosen else f"; the best correction, {best.name}, leaves {other} mm"
        return f"No correction of the CoP helps on unseen placements: {error} mm as it is{rival}."
    plain = _MM * study.results[0].left_out.rmse
    return (
        f"CoP error at placements left out of the fit: {plain:.2f} mm without a correction, "
        f"{error} mm with it ({worst.foot}; {chosen.name})."
    )


def explains(found: FootStudy) -> bool:
    """Whether what the chosen correction leaves is small, or no larger than repeats scatter."""
    chosen = found.study.chosen
    repeats = find_repeats(found.rows, chosen.fit.cop_m(found.rows))
    scatter = float(np.linalg.norm(repeats.pooled_sd_m))
    known = np.isfinite(scatter)
    return bool(chosen.left_out.rmse < max(POOR_M, POOR_RATIO * scatter if known else 0.0))


def foot_sentence(found: FootStudy) -> str:
    """The errors at each stage, and the verdict between physics and polynomial."""
    chosen = found.study.chosen
    stages = []
    if found.before is not None:
        raw = rms_distance_m(cop_errors_m(found.before.raw_cop_m, found.before))
        stages.append(f"{_MM * raw:.2f} mm before the cells were calibrated")
    if found.held_out is not None:
        error = rms_distance_m(cop_errors_m(chosen.fit.cop_m(found.held_out), found.held_out))
        stages.append(f"{_MM * error:.2f} mm on placements never used")
    verdict = found.study.verdict()
    text = f"{verdict[0].upper()}{verdict[1:]}."
    return (
        f"{found.foot}: CoP error {', '.join(stages)}. {text}"
        if stages
        else (f"{found.foot}: {text}")
    )


def correction_sheet(found: FootStudy) -> Sheet:
    """All corrections of one foot side by side."""
    rows = []
    for result in found.study.results:
        held = found.held_out
        error = "–" if held is None else f"{_MM * _held_out_m(result, held):.3f}"
        sd = _MM * result.left_out.rmse_sd
        rows.append(
            (
                ("→ " if result is found.study.chosen else "") + result.name,
                with_sd(_MM * result.left_out.rmse, sd),
                error,
                number(result.left_out_total.rmse, 3),
                f"{_MM * result.cop_rmse_m:.3f}",
                str(result.fit.model.coefficients(len(found.rows.cells))),
                str(result.fit.rank),
                number(result.fit.condition, 3),
                number(result.fit.ridge, 1) if result.fit.ridge else "–",
            )
        )
    return Sheet(
        f"CoP corrections of {found.foot}",
        ("correction", "CoP, left out (mm)", "CoP, never used (mm)", "vGRF, left out (N)",
         "CoP, fitted (mm)", "coefficients", "rank", "condition", "ridge"),
        rows,
        note="CoP: root mean squared distance from the hole. Left out: each placement predicted by "
        "a fit without it, ± one standard error over placements. Never used: placements that no "
        "fit and no choice saw. → marks the choice: the simplest "
        "within one standard error of the best, CoP and vGRF together. Crosstalk is what a share "
        "of a cell's reading means when the cells were calibrated one by one; a wrong scale would "
        "look the same.",
    )  # fmt: skip


def cell_sheet(found: FootStudy) -> Sheet | None:
    """Corrections of the cells' positions, and their crosstalk or scales."""
    physical = found.study.physical
    if physical is None:
        return None
    result = found.study.results[physical]
    if result.parameters is None:
        return None
    estimates = result.parameters
    rows = []
    for name, unit, value, sd in zip(
        estimates.names, estimates.units, estimates.values, estimates.sd, strict=True
    ):
        factor, shown = _SHOWN.get(unit, (1.0, unit))
        rows.append(
            (name, with_sd(factor * value, factor * sd), shown, f"{value / sd:+.1f}" if sd else "–")
        )
    return Sheet(
        f"Cells of {found.foot} by their placements",
        ("parameter", "value", "unit", "in its sd"),
        rows,
        note=f"Model: {result.name}; sd by leaving out one placement after the other (jackknife).",
    )


@listed
def odd_cells(found: FootStudy) -> Iterator[Finding]:
    """The cell whose gain alone explains nearly all that placements show."""
    odd = odd_gain(found.study, found.rows)
    if odd is not None:
        yield gain_finding(odd)


@listed
def misplaced_cells(found: FootStudy) -> Iterator[Finding]:
    """Cells that placements see elsewhere than the recipe has them, by more than chance."""
    physical = found.study.physical
    chosen = found.study.chosen
    if physical is None or chosen is found.study.results[0]:
        return
    if odd_gain(found.study, found.rows) is not None:
        return  # beside a wrong gain places of four cells are known to no millimetre
    estimates = found.study.results[physical].parameters
    if estimates is None:
        return
    for cell in found.rows.cells:
        at = [
            estimates.names.index(name)
            for axis in "xy"
            if (name := f"{cell}.cell_correction_{axis}") in estimates.names
        ]
        if len(at) < 2:
            continue
        moved, covariance = estimates.values[at], estimates.covariance[np.ix_(at, at)]
        distance = float(np.hypot(*moved))
        sd = float(np.sqrt(moved @ covariance @ moved)) / max(distance, np.finfo(float).tiny)
        if distance < MISPLACED_M or distance < _SIGMAS * sd:
            continue
        x, y = (f"{_MM * along:+.1f}".replace("-", "−") for along in moved)
        yield Finding(
            "cell_misplaced", "warning", cell,
            f"the placements put it {with_sd(_MM * distance, _MM * sd)} mm from where the "
            f"recipe has it (x {x}, y {y} mm)",
            "measure where it sits and correct x_m and y_m in the recipe; if it sits right, "
            "look for a load that bypasses it",
        )  # fmt: skip


def repeat_sheet(found: FootStudy) -> Sheet:
    """Mean and sd of the corrected CoP per hole and load: [NAO], section 4.2."""
    fit = found.study.chosen.fit
    repeats = find_repeats(found.rows, fit.cop_m(found.rows))
    rows = [
        (
            f"({_MM * hole[0]:.0f}, {_MM * hole[1]:.0f})",
            number(float(load), 4),
            str(n),
            *(
                with_sd(_MM * float(error[k]), _MM * float(sd[k]))
                if n > 1
                else number(_MM * float(error[k]), 3)
                for k in (0, 1)
            ),
        )
        for hole, load, n, error, sd in zip(
            repeats.hole_m, repeats.load_n, repeats.n, repeats.error_m, repeats.sd_m, strict=True
        )
    ]
    pooled = _MM * repeats.pooled_sd_m
    note = (
        f"Repeatability over all holes and loads: {number(float(pooled[0]), 3)} mm in x, "
        f"{number(float(pooled[1]), 3)} mm in y."
        if np.isfinite(pooled).all()
        else "No placement was repeated."
    )
    if len(rows) > _MOST_ROWS:
        note += f" The first {_MOST_ROWS} of {len(rows)} combinations."
    return Sheet(
        f"Repeats on {found.foot} (corrected CoP minus hole)",
        ("hole (mm)", "load (N)", "n", "x (mm)", "y (mm)"),
        rows[:_MOST_ROWS],
        note=note,
    )


def placement_errors(found: FootStudy) -> list[RmseRow]:
    """CoP and vGRF errors before and after, on the fit, left out, and never used."""
    rows: list[RmseRow] = []
    if found.before is not None:
        rows += _error_rows(found, "before", found.before, found.before.raw_cop_m, "all")
    for result in found.study.results:
        chosen = result is found.study.chosen
        stage = "after" if chosen else result.name
        fit = result.fit
        if chosen:
            rows += _error_rows(found, stage, found.rows, fit.cop_m(found.rows), "train", fit)
        rows += _left_out_rows(found, stage, result)
        if found.held_out is not None:
            rows += _error_rows(
                found, stage, found.held_out, fit.cop_m(found.held_out), "held_out", fit
            )
    return rows


def _error_rows(
    found: FootStudy,
    stage: str,
    rows: PlacementRows,
    cop_m: FloatArray,
    split: Split,
    fit: CopFit | None = None,
) -> list[RmseRow]:
    error = cop_errors_m(cop_m, rows)
    total = (rows.total_n if fit is None else fit.total_n(rows)) - rows.load_n
    apart = ", placement never used" if split == "held_out" else ""
    parts = [
        (f"cop_x {found.foot}", "m", f"hole{apart}", error[:, 0]),
        (f"cop_y {found.foot}", "m", f"hole{apart}", error[:, 1]),
        (f"cop {found.foot}", "m", f"hole{apart}", np.hypot(*error.T)),
        (f"vgrf {found.foot}", "N", f"known load{apart}", total),
    ]
    # the axes of every correction that was not chosen would bury the rest
    return [
        RmseRow.of(quantity, unit, stage, reference, errors, split)
        for quantity, unit, reference, errors in parts[0 if stage in ("before", "after") else 2 :]
        if np.isfinite(errors).any()
    ]


def _left_out_rows(found: FootStudy, stage: str, result: CopResult) -> list[RmseRow]:
    reference = "hole, its placement left out of the fit"
    error = result.left_out.error
    total = result.left_out_total.error
    made = [RmseRow.of(f"cop {found.foot}", "m", stage, reference, np.hypot(*error.T), "held_out")]
    if np.isfinite(total).all():
        against = "known load, its placement left out of the fit"
        made.append(RmseRow.of(f"vgrf {found.foot}", "N", stage, against, total, "held_out"))
    return made


def _held_out_m(result: CopResult, rows: PlacementRows) -> float:
    return rms_distance_m(cop_errors_m(result.fit.cop_m(rows), rows))
