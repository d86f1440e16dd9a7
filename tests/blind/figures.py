"""Figures of the bench: confusion, power, risk against coverage."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from footcal_cli.plots.style import AFTER, BAD, REFERENCE, new_figure, tidy
from tests.blind.scoring import Score, Share, risk_coverage

COLUMNS = (
    "right name", "right name + unknown", "rivals with it", "rivals without it", "wrong name",
    "wrong name + unknown", "unknown", "none", "underpowered", "bad-data", "error",
)  # fmt: skip


def draw_confusion(scores: Sequence[Score], path: Path) -> None:
    """Truth by verdict, in per cent of the row."""
    rows = sorted({s.row for s in scores}, key=lambda r: (r in ("none", "unseen", "left out"), r))
    table = np.array(
        [[sum(s.row == r and s.column == c for s in scores) for c in COLUMNS] for r in rows]
    )
    total = table.sum(axis=1, keepdims=True)
    figure = new_figure(1.6 + 0.26 * len(rows))
    axes = figure.add_subplot()
    axes.imshow(table / np.maximum(total, 1), cmap="Blues", vmin=0, vmax=1, aspect="auto")
    for i, j in np.argwhere(table > 0):
        share = table[i, j] / total[i, 0]
        bad = COLUMNS[j].startswith("wrong")
        colour = BAD if bad else "white" if share > 0.6 else REFERENCE
        axes.text(j, i, f"{100 * share:.0f}", ha="center", va="center", fontsize=7, color=colour)
    tidy(axes, "What was hidden (rows) and what was said (columns), % of the row")
    axes.grid(visible=False)
    axes.set_xticks(range(len(COLUMNS)), COLUMNS, rotation=35, ha="right")
    axes.set_yticks(
        range(len(rows)), [f"{r}  (n = {n})" for r, n in zip(rows, total[:, 0], strict=True)]
    )
    figure.savefig(path, dpi=110)


def draw_power(scores: Sequence[Score], path: Path) -> None:
    """Right answers against ρ, one panel per hidden effect, with Wilson bands."""
    singles = [s for s in scores if s.truth["kind"] in ("single", "alias")]
    keys = sorted({(s.group, str(s.truth["effects"][0]["key"])) for s in singles})
    if not keys:
        return
    across = 5
    down = -(-len(keys) // across)
    height_in = 1.1 + 1.3 * down
    # not new_figure: its constrained layout takes seconds for so many panels
    figure = Figure(figsize=(11.0, height_in))
    FigureCanvasAgg(figure)
    figure.subplots_adjust(
        left=0.07, right=0.99, top=1 - 0.4 / height_in, bottom=0.6 / height_in, hspace=0.55
    )
    panels = figure.subplots(down, across, sharex=True, sharey=True, squeeze=False).ravel()
    for panel in panels[len(keys) :]:
        panel.set_visible(False)
    for panel, (experiment, key) in zip(panels, keys, strict=False):
        mine = [s for s in singles if s.group == experiment and s.truth["effects"][0]["key"] == key]
        rhos = sorted({float(s.truth["rho"]) for s in mine})
        for flag, colour in (("right", AFTER), ("exact", REFERENCE)):
            shares = [Share.of(getattr(s, flag) for s in mine if s.truth["rho"] == r) for r in rhos]
            low, high = np.array([s.wilson() for s in shares]).T
            panel.plot(rhos, [s.value for s in shares], "o-", color=colour, ms=3, lw=1)
            panel.fill_between(rhos, low, high, color=colour, alpha=0.15, lw=0)
        tidy(panel, f"{key}\n{experiment}, n = {len(mine)}")
        panel.title.set_fontsize(6.5)
        panel.set_ylim(-0.05, 1.05)
        panel.axhline(0.8, color="#cccccc", lw=0.7)
    figure.supxlabel("ρ: what calibration cannot absorb, RMS over noise RMS", fontsize=9)
    figure.supylabel("share of trials: right (blue), exact (black)", fontsize=9)
    figure.savefig(path, dpi=110)


def draw_risk(scores: Sequence[Score], path: Path) -> None:
    """Wrong names among the answers against the share of trials answered, surest first."""
    figure = new_figure(3.0, width_in=5.5)
    axes = figure.add_subplot()
    for colour, name, kept in (
        (AFTER, "single effects and pairs", ("single", "pair")),
        (BAD, "unseen and left out", ("unseen", "left_out")),
    ):
        mine = [s for s in scores if s.truth["kind"] in kept]
        coverage, risk = risk_coverage(mine)
        axes.plot([0.0, *coverage], [0.0, *risk], color=colour, label=name, drawstyle="steps-post")
    tidy(axes, "Risk against coverage", "share of trials answered with a name", "wrong among them")
    axes.set_ylim(bottom=-0.005)
    axes.legend(fontsize=8, frameon=False)
    figure.savefig(path, dpi=110)
