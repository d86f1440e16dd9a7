"""Figures of placements: where the CoP is seen and where it is, before and after."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core.bench.cop_study import FootStudy
from footcal_cli.core.bench.placement_rows import PlacementRows, find_repeats
from footcal_cli.core.parameters import FloatArray
from footcal_cli.plots.style import (
    AFTER,
    BAD,
    BEFORE,
    REFERENCE,
    legend_below,
    log_axis,
    new_figure,
    tidy,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MM = 1e3


def plot_error_map(found: FootStudy, outline_m: FloatArray | None = None) -> Figure:
    """Vectors from each hole to the mean CoP of every load, before and after, over the foot."""
    figure = new_figure(4.6)
    chosen = found.study.chosen
    before = found.before if found.before is not None else found.rows
    panels = (
        ("before", before, before.raw_cop_m, BEFORE),
        (f"after: {chosen.name}", found.rows, chosen.fit.cop_m(found.rows), AFTER),
    )
    for i, (title, rows, cop, colour) in enumerate(panels):
        axes = figure.add_subplot(1, 2, i + 1)
        magnification = _draw_vectors(axes, rows, cop, colour)
        if i == 1 and found.held_out is not None:
            corrected = chosen.fit.cop_m(found.held_out)
            _draw_vectors(axes, found.held_out, corrected, BAD, magnification)
        _draw_foot(axes, found.rows, outline_m)
        tidy(axes, f"{title} (errors × {magnification:g})", "x (mm)", "y (mm)" if i == 0 else "")
        axes.set_aspect("equal", adjustable="datalim")
    return figure


def _draw_vectors(
    axes: Axes, rows: PlacementRows, cop_m: FloatArray, colour: str, magnification: float = 0.0
) -> float:
    """Error vectors enlarged so that the typical one is a quarter of the spacing of the holes."""
    repeats = find_repeats(rows, cop_m)
    error = repeats.error_m
    if not magnification:
        spacing = float(np.ptp(rows.hole_m, axis=0).max()) / 6.0
        typical = float(np.median(np.hypot(*error.T))) if len(error) else 1.0
        ratio = 0.25 * spacing / max(typical, 1e-9)
        magnification = float(max(10.0 ** np.floor(np.log10(ratio)), 1.0)) if ratio > 1 else 1.0
        magnification *= float(max(np.floor(ratio / magnification), 1.0))
    start, step = _MM * repeats.hole_m, _MM * magnification * error
    for hole, vector in zip(start, step, strict=True):
        axes.plot([hole[0], hole[0] + vector[0]], [hole[1], hole[1] + vector[1]], color=colour,
                  linewidth=0.9, alpha=0.6)  # fmt: skip
        axes.plot(hole[0] + vector[0], hole[1] + vector[1], ".", color=colour, markersize=3)
    axes.plot(
        start[:, 0], start[:, 1], "o", color=REFERENCE, markersize=3.5, markerfacecolor="none"
    )
    return magnification


def _draw_foot(axes: Axes, rows: PlacementRows, outline_m: FloatArray | None) -> None:
    if outline_m is not None and len(outline_m) > 2:
        closed = _MM * np.vstack([outline_m, outline_m[:1]])
        axes.plot(closed[:, 0], closed[:, 1], color=BEFORE, linewidth=1.0)
    if rows.cells:
        cells = _MM * rows.cell_pos_m
        axes.plot(cells[:, 0], cells[:, 1], "s", color="#52708f", markersize=7,
                  markerfacecolor="none")  # fmt: skip


def plot_corrections(found: FootStudy) -> Figure:
    """Error of every correction on the fit, on left-out placements and on those never used."""
    results = found.study.results
    figure = new_figure(0.36 * len(results) + 1.4)
    axes = figure.add_subplot()
    for i, result in enumerate(results):
        chosen = result is found.study.chosen
        axes.plot(_MM * result.cop_rmse_m, -i, "o", color=BEFORE, markersize=5,
                  label="fitted" if i == 0 else None)  # fmt: skip
        spread = _MM * float(np.nan_to_num(result.left_out.rmse_sd))
        axes.errorbar(_MM * result.left_out.rmse, -i, xerr=spread, fmt="D" if chosen else "o",
                      color=AFTER, markersize=8 if chosen else 6, capsize=3,
                      label="placement left out" if i == 0 else None)  # fmt: skip
        if found.held_out is not None:
            error = result.fit.cop_m(found.held_out) - found.held_out.hole_m
            error = error[np.isfinite(error).all(axis=1)]
            rmse = np.sqrt(np.mean(np.sum(error**2, axis=1))) if len(error) else np.nan
            axes.plot(_MM * float(rmse), -i, "x", color=BAD,
                      markersize=7, label="never used" if i == 0 else None)  # fmt: skip
    axes.set_yticks([-i for i in range(len(results))], [result.name for result in results])
    log_axis(axes)
    tidy(axes, f"CoP error of {found.foot} by correction (diamond: chosen)", "RMSE (mm)", "")
    axes.legend(fontsize=8, frameon=False, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure


def plot_total_force(found: FootStudy) -> Figure:
    """Total force against the known load, and its error ([NAO], Fig. 8)."""
    figure = new_figure(3.2)
    force, error = figure.subplots(1, 2)
    corrected = found.study.chosen.fit.total_n(found.rows)
    series = [(found.rows.load_n, corrected, AFTER, ".", "corrected")]
    if found.before is not None:
        before = found.before
        series.insert(0, (before.load_n, before.total_n, BEFORE, "x", "before"))
    largest = float(np.nanmax(found.rows.load_n))
    force.plot([0.0, largest], [0.0, largest], color=REFERENCE, linewidth=1.0, label="known load")
    for load, total, colour, marker, label in series:
        force.plot(load, total, marker, color=colour, markersize=4, label=label)
        error.plot(load, total - load, marker, color=colour, markersize=4)
    error.axhline(0.0, color=REFERENCE, linewidth=0.8)
    tidy(force, f"Vertical force, {found.foot} foot", "known load (N)", "sum of the cells (N)")
    tidy(error, "Error of the vertical force", "known load (N)", "measured − known (N)")
    legend_below(figure)
    return figure
