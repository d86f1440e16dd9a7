"""Figures of standing poses: balance violins, mounting sketch, leg map, coverage."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core.effects.calibration import AXES
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.pose.data import PoseData
from footcal_cli.core.pose.joint import PoseFit
from footcal_cli.core.pose.leg_map import LegMap
from footcal_cli.core.pose.series import SeriesFit
from footcal_cli.core.pose.standing import OffsetFit
from footcal_cli.core.spatial import rotation_exp, rotation_log
from footcal_cli.plots.hang import draw_violins
from footcal_cli.plots.style import (
    AFTER,
    BEFORE,
    CELL_COLOURS,
    MARKERS,
    REFERENCE,
    legend_below,
    new_figure,
    tidy,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_CHI2_95_2D = 5.991
_MOST_POSES = 600


def plot_balance(stages: Mapping[str, FloatArray]) -> Figure:
    """Violins of the sum of forces and of moments, stage by stage ([Wu], Figs. 2 and 6).

    Parameters
    ----------
    stages
        Errors in the floating base about the robot's CoM, shape (P, 6) each.
    """
    figure = new_figure(3.6)
    grid = figure.subplots(1, 2)
    width = 0.8 / len(stages)
    colours = {"before": BEFORE, "after": AFTER}
    spare = iter(CELL_COLOURS[1:3] + CELL_COLOURS[5:6])
    for k, (stage, error) in enumerate(stages.items()):
        colour = colours.get(stage) or next(spare)
        places = np.arange(3.0) + (k - 0.5 * (len(stages) - 1)) * width
        for half, axes in enumerate(grid):
            samples = [error[:, 3 * half + i] for i in range(3)]
            draw_violins(axes, samples, places, colour, 0.95 * width)
        grid[0].plot([], [], color=colour, linewidth=6, alpha=0.75, label=stage)
    for axes, names, title, unit in (
        (grid[0], "x y z", "Ground forces of all feet − robot weight", "N"),
        (grid[1], "x y z", "Their moments about the robot's CoM", "Nm"),
    ):
        axes.axhline(0.0, color=REFERENCE, linewidth=0.7)
        axes.set_xticks(range(3), names.split())
        tidy(axes, title, "axis of the floating base (x forward, z up)", f"error ({unit})")
    figure.legend(*grid[0].get_legend_handles_labels(), loc="outside lower center", ncols=4,
                  frameon=False, fontsize=9)  # fmt: skip
    return figure


def plot_mounting(fit: PoseFit) -> Figure:
    """Hips from above, nominal and calibrated, errors enlarged; turns with intervals beside."""
    figure = new_figure(4.6, width_in=9.5)
    sketch, turns = figure.subplots(1, 2, width_ratios=[1.25, 1.0])
    _draw_hips(sketch, fit)
    _draw_turns(turns, fit)
    return figure


def _draw_hips(sketch: Axes, fit: PoseFit) -> None:
    """Hips from above: nominal in grey, calibrated in blue with the 95 % ellipse and the axes."""
    from matplotlib.patches import Ellipse

    legs, geometry = fit.geometry.legs, fit.geometry
    shift = fit.arm_b_m - (geometry.hip_b_m - geometry.chassis_com_b_m)
    common = shift.mean(axis=0)
    own = shift - common
    largest = float(np.abs(own[:, :2]).max()) or 1e-4
    enlarge = 10.0 ** np.floor(np.log10(0.06 / largest)) if largest < 0.06 else 1.0
    enlarge = float(np.clip(enlarge, 1.0, 100.0))
    rotvec = rotation_log(fit.mounting.turn_b)
    turn_scale = float(np.clip(0.3 / max(float(np.abs(rotvec).max()), 1e-4), 1.0, 10.0))
    for k, leg in enumerate(legs):
        x, y = geometry.hip_b_m[k, :2]
        sketch.plot(-y, x, "s", color=BEFORE, markersize=7)
        sketch.plot([0, -y], [0, x], color="#d5d9de", linewidth=3, zorder=0)
        moved = geometry.hip_b_m[k, :2] + enlarge * own[k, :2]
        rows = 3 * len(legs) + 3 * k + np.arange(2)
        values, vectors = np.linalg.eigh(fit.covariance[np.ix_(rows, rows)])
        if np.isfinite(values).all():
            size = 2 * enlarge * np.sqrt(_CHI2_95_2D * np.clip(values, 0, None))
            angle = np.rad2deg(np.arctan2(vectors[0, 0], -vectors[1, 0]))
            sketch.add_patch(
                Ellipse((-moved[1], moved[0]), size[0], size[1], angle=float(angle),
                        facecolor=AFTER, alpha=0.2)
            )  # fmt: skip
        turned = rotation_exp(turn_scale * rotvec[k])
        for axis, colour in ((0, CELL_COLOURS[3]), (1, CELL_COLOURS[2])):
            arrow = 0.05 * turned[:2, axis]
            sketch.annotate(
                "", (-(moved[1] + arrow[1]), moved[0] + arrow[0]), (-moved[1], moved[0]),
                arrowprops={"arrowstyle": "->", "color": colour, "linewidth": 1.4},
            )  # fmt: skip
        sketch.plot(-moved[1], moved[0], "o", color=AFTER, markersize=5)
        sketch.annotate(leg, (-y, x), xytext=(8, -12), textcoords="offset points",
                        fontsize=9)  # fmt: skip
    shared = (f"{a} {1e3 * c:+.1f}" for a, c in zip("xyz", common, strict=True))
    together = ", ".join(shared).replace("-", "−")
    sketch.set_aspect("equal")
    sketch.margins(0.18)
    sketch.set_xticks([])
    tidy(sketch, f"From above; shifts × {enlarge:g}, turns × {turn_scale:.2g}",
         f"shift of all hips together (not drawn): {together} mm",
         "x forward (mm)")  # fmt: skip
    sketch.yaxis.set_major_formatter(lambda metres, _: f"{1e3 * metres:.0f}".replace("-", "−"))


def _draw_turns(turns: Axes, fit: PoseFit) -> None:
    """Turns of each transducer about the body's axes with 95 % intervals."""
    legs, rotvec = fit.geometry.legs, rotation_log(fit.mounting.turn_b)
    sd = np.sqrt(np.clip(np.diag(fit.covariance)[: 3 * len(legs)], 0, None)).reshape(-1, 3)
    places = np.arange(len(legs))[::-1]
    for a, name in enumerate("xyz"):
        at = places + 0.22 * (1 - a)
        turns.errorbar(
            np.rad2deg(rotvec[:, a]), at, xerr=1.96 * np.rad2deg(np.nan_to_num(sd[:, a])),
            fmt=MARKERS[a], color=CELL_COLOURS[a], markersize=5, linewidth=1.4,
            label=f"about {name}",
        )  # fmt: skip
    turns.axvline(0, color=REFERENCE, linewidth=0.7)
    turns.set_yticks(places, legs)
    tidy(turns, "Mounting rotation with 95 % interval", "body axes (°)", "")
    turns.legend(
        fontsize=8, frameon=False, loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=3
    )


def plot_leg_map(mapped: LegMap, legs: Sequence[str]) -> Figure:
    """Leg by pose: the residual that the leg's own readings predict."""
    figure = new_figure(0.36 * len(legs) + 1.6)
    axes, bars = figure.subplots(1, 2, width_ratios=[4, 1], sharey=True)
    poses = mapped.foretold.shape[1]
    step = max(int(np.ceil(poses / _MOST_POSES)), 1)
    image = axes.imshow(
        mapped.foretold[:, ::step], aspect="auto", cmap="viridis", vmin=0.0,
        vmax=max(float(mapped.foretold.max()), 2.0), extent=(0, poses, len(legs) - 0.5, -0.5),
        interpolation="nearest",
    )  # fmt: skip
    axes.set_yticks(range(len(legs)), legs)
    tidy(axes, "Residual predicted by each leg's readings", "pose", "")
    axes.grid(False)
    bar = figure.colorbar(image, ax=axes, pad=0.01)
    bar.set_label("residual (noise sd)", fontsize=9)
    bar.ax.tick_params(labelsize=8)
    bars.barh(range(len(legs)), 100 * mapped.share, color=AFTER)
    tidy(bars, "Share of each leg", "% of the residual", "")
    bars.set_xlim(0, max(100 * float(mapped.share.max()) * 1.1, 10.0))
    return figure


def plot_coverage(data: PoseData) -> Figure:
    """Shaft angles per leg, and tilt of the body."""
    figure = new_figure(3.2)
    shafts, tilts = figure.subplots(1, 2)
    legs = data.geometry.legs
    for k in range(len(legs)):
        jitter = 0.3 * (np.arange(len(data)) % 17 / 17 - 0.5)
        shafts.plot(np.rad2deg(data.phase_rad[:, k]), k + jitter, ".", markersize=2,
                    color=CELL_COLOURS[k % len(CELL_COLOURS)])  # fmt: skip
    shafts.set_yticks(range(len(legs)), legs)
    shafts.invert_yaxis()
    tidy(shafts, f"Shaft angles of {len(data)} poses", "shaft angle (°)", "")
    lean = np.rad2deg(np.arcsin(np.clip(data.gravity_b[:, :2], -1, 1)))
    tilts.plot(lean[:, 0], lean[:, 1], ".", color=AFTER, markersize=3)
    tilts.set_aspect("equal", adjustable="datalim")
    tilts.axhline(0, color=REFERENCE, linewidth=0.6)
    tilts.axvline(0, color=REFERENCE, linewidth=0.6)
    tidy(tilts, "Tilt of the body", "gravity towards x (°)", "gravity towards y (°)")
    return figure


def plot_offset_change(found: OffsetFit, legs: Sequence[str]) -> Figure:
    """Change of each offset since the last calibration, with 95 % intervals."""
    figure = new_figure(3.8)
    grid = figure.subplots(2, 3, sharey=True)
    places = np.arange(len(legs))[::-1]
    for i, axis in enumerate(AXES):
        axes = grid[i // 3][i % 3]
        axes.errorbar(
            found.change[:, i], places, xerr=1.96 * found.change_sd[:, i], fmt="o",
            color=AFTER, markersize=4, linewidth=1.4,
        )  # fmt: skip
        axes.axvline(0, color=REFERENCE, linewidth=0.7)
        axes.set_yticks(places, legs)
        axes.locator_params(axis="x", nbins=4)
        tidy(axes, axis, f"change ({'N' if i < 3 else 'Nm'})", "")
    return figure


def plot_series(fits: Sequence[SeriesFit]) -> Figure:
    """Unexplained force of the second transducer of each pair, block by block."""
    figure = new_figure(1.9 * len(fits) + 0.6)
    grid = figure.subplots(len(fits), 1, sharex=True, squeeze=False)
    for row, fit in zip(grid, fits, strict=True):
        for a, name in enumerate("xyz"):
            row[0].plot(fit.left[:, a], color=CELL_COLOURS[a], linewidth=1.0, label=f"f{name}")
        row[0].axhline(0, color=REFERENCE, linewidth=0.6)
        below = "block of readings" if fit is fits[-1] else ""
        tidy(row[0], f"{fit.first} → {fit.second}", below, "unexplained (N)")
    legend_below(figure)
    return figure
