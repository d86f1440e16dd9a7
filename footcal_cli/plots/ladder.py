"""Figures of the ladder: what each model leaves on unseen data, and staircases up and down."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core.bench.plateaus import SampleState, find_direction
from footcal_cli.core.bench.study import ChannelStudy
from footcal_cli.plots.style import (
    AFTER,
    BAD,
    BEFORE,
    CELL_COLOURS,
    MARKERS,
    REFERENCE,
    log_axis,
    new_figure,
    tidy,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MOST_PANELS = 8


def plot_ladder(studies: Sequence[ChannelStudy]) -> Figure:
    """Held-out error of significant models of the first step, per channel, the choice filled."""
    shown = [study for study in studies if study.ladder is not None]
    rows = [row for s in shown if s.ladder for row in s.ladder.rows]
    names = list(dict.fromkeys(r.model for r in rows if np.isfinite(r.held_out_rmse_n)))
    names = [name for name in names if " + " not in name or _is_chosen(shown, name)]
    figure = new_figure(0.34 * len(names) + 1.5)
    axes = figure.add_subplot()
    places = {name: -i for i, name in enumerate(names)}
    for i, study in enumerate(shown):
        if study.ladder is None:
            continue
        colour = CELL_COLOURS[i % len(CELL_COLOURS)]
        for row in study.ladder.rows:
            if row.model not in places:
                continue
            chosen = row.model == study.ladder.model
            axes.plot(
                row.held_out_rmse_n,
                places[row.model] + 0.28 * (i / max(len(shown) - 1, 1) - 0.5),
                MARKERS[i % len(MARKERS)],
                color=colour,
                markerfacecolor=colour if chosen else "white",
                markersize=8 if chosen else 5,
                label=study.channel if row.model == "affine" else None,
            )
    axes.set_yticks(list(places.values()), list(places))
    log_axis(axes)
    tidy(axes, "Error on sessions or loads left out of the fit (filled: chosen)",
         "held-out RMSE (N)", "")  # fmt: skip
    axes.legend(fontsize=8, frameon=False, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure


def _is_chosen(studies: Sequence[ChannelStudy], name: str) -> bool:
    return any(study.ladder is not None and study.ladder.model == name for study in studies)


def plot_staircases(studies: Sequence[ChannelStudy]) -> Figure:
    """Error against load, loading and unloading apart: above the straight line, below the model.

    Where the straight line is the model of every channel it is drawn once.
    """
    shown = list(studies)[:_MOST_PANELS]
    across = min(4, len(shown))
    blocks = int(np.ceil(len(shown) / across))
    each = 1 if all(s.ladder is None or s.ladder.model == "affine" for s in shown) else 2
    figure = new_figure(1.8 * each * blocks + 0.4, width_in=max(2.6 * across, 5.0))
    grid = figure.add_gridspec(each * blocks, across)
    for i, study in enumerate(shown):
        block, column = divmod(i, across)
        record, ladder = study.record, study.ladder
        if ladder is None:
            continue
        known = record.known
        direction = find_direction(
            record.load_n[known], record.time_s[known], record.session[known]
        )
        limit = 0.0
        panels = []
        for k, (fit, title) in enumerate(
            (
                (ladder.affine, study.channel if each == 1 else f"{study.channel}\nstraight line"),
                (ladder.chosen, f"{study.channel}\n{ladder.model}"),
            )[: 1 if ladder.model == "affine" else 2]
        ):
            axes = figure.add_subplot(grid[each * block + k, column])
            error = (fit.predict(record).load_n - record.load_n)[known]
            limit = max(limit, float(np.abs(error).max()))
            for sign, colour, marker, label in (
                (1, AFTER, "^", "loading"), (-1, BAD, "v", "unloading"),
                (0, BEFORE, "o", "first reading"),
            ):  # fmt: skip
                at = direction == sign
                axes.plot(record.load_n[known][at], error[at], marker, color=colour, markersize=3,
                          alpha=0.7, label=label if at.any() else None)  # fmt: skip
            axes.axhline(0, color=REFERENCE, linewidth=0.7)
            last = k == each - 1 or ladder.model == "affine"
            below = "known load (N)" if last else ""
            tidy(axes, title, below, "residual (N)" if column == 0 else "")
            panels.append(axes)
        for axes in panels:
            axes.set_ylim(-1.15 * limit, 1.15 * limit)
        if i == 0:
            figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center",
                          ncols=3, fontsize=8, frameon=False)  # fmt: skip
    return figure


def plot_recordings(studies: Sequence[ChannelStudy]) -> Figure:
    """Running recordings with what was used, what was not, and why."""
    shown = [study for study in studies if study.samples is not None][:_MOST_PANELS]
    figure = new_figure(2.3 * len(shown) + 0.4)
    colours = {
        SampleState.SETTLED: AFTER, SampleState.MOVING: BEFORE, SampleState.SHORT: CELL_COLOURS[1],
        SampleState.GLITCH: BAD, SampleState.DROPOUT: CELL_COLOURS[5],
    }  # fmt: skip
    for i, study in enumerate(shown):
        axes = figure.add_subplot(len(shown), 1, i + 1)
        samples = study.samples
        if samples is None:
            continue
        step = max(len(samples.record) // 20_000, 1)
        for state, colour in colours.items():
            at = np.flatnonzero(samples.state == state)
            at = at[::step] if state in (SampleState.SETTLED, SampleState.MOVING) else at
            if at.size:
                record = samples.record
                axes.plot(record.time_s[at], record.reading[at], ".", color=colour, markersize=2,
                          label=state.reason)  # fmt: skip
        tidy(axes, study.channel, "time (s)" if i == len(shown) - 1 else "", "reading (counts)")
        if i == 0:
            axes.legend(fontsize=7, frameon=False, markerscale=4, loc="center left",
                        bbox_to_anchor=(1.0, 0.5))  # fmt: skip
    return figure
